extern "C" {
#include "image/helper/oiio_shim.h"
}

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <new>
#include <thread>

// Rows as differences from the row above, at zlib's level 1: a noisy 1280x720 picture takes 51 ms and 1.58 MB, where
// the defaults (no filter, level 6) take 350 ms and 1.38 MB.
enum { PNG_LEVEL = 1, PNG_FILTER_UP = 32 };

enum { MAX_THREADS = 8, FULL_CHROMA_QUALITY = 90 };

static const char *const format_names[IMAGE_FORMAT_COUNT] = {"png", "jpeg", "hdr", "openexr"};

struct OiioInput {
  std::unique_ptr<OIIO::ImageInput> file;
  ImageFormat format;
};

template <typename Body>
static Status guarded(Status failure, const char *hint, Log *log, Body body)
{
  try {
    return body();
  } catch (const std::bad_alloc &) {
    return log_no_memory(log, "image helper");
  } catch (const std::exception &error) {
    return log_fail(log, failure, "%s: %s", error.what(), hint);
  } catch (...) {
    return log_fail(log, failure, "unknown exception: %s", hint);
  }
}

template <typename File>
static Status fail(File &file, Status failure, const char *hint, Log *log)
{
  std::string cause = file ? file->geterror() : OIIO::geterror();
  return log_fail(log, failure, "%s: %s", cause.empty() ? "unknown cause" : cause.c_str(), hint);
}

static const char *const damaged = "the file is damaged, or of an unknown kind";

void oiio_set_up(void)
{
  int threads = (int)std::min(std::max(std::thread::hardware_concurrency(), 1u), (unsigned)MAX_THREADS);
  OIIO::attribute("threads", threads);
  OIIO::attribute("exr_threads", threads);
}

Status oiio_open(OiioInput **out, uint32_t *width, uint32_t *height, ImageFormat format, const char *path, Log *log)
{
  return guarded(STATUS_BAD_IMAGE, damaged, log, [&] {
    std::unique_ptr<OiioInput> input(new OiioInput{OIIO::ImageInput::create(format_names[format]), format});
    OIIO::ImageSpec spec, hints;
    hints.attribute("oiio:UnassociatedAlpha", 1);
    if (!input->file || !input->file->open(path, spec, hints)) return fail(input->file, STATUS_BAD_IMAGE, damaged, log);
    if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || spec.deep || spec.nchannels < 1)
      return log_fail(log, STATUS_BAD_IMAGE, "not a flat picture: save it as one");
    if (spec.x != spec.full_x || spec.y != spec.full_y || spec.width != spec.full_width ||
        spec.height != spec.full_height)
      return log_fail(log, STATUS_BAD_IMAGE, "its data window is not its display window: save the whole picture");
    *width = (uint32_t)spec.width;
    *height = (uint32_t)spec.height;
    *out = input.release();
    return STATUS_OK;
  });
}

template <typename T>
static void expand(T *rgba, uint64_t count, int colours, bool has_alpha, T opaque)
{
  for (T *p = rgba; p < rgba + 4 * count; p += 4) {
    if (!has_alpha) p[3] = opaque;
    if (colours == 3) continue;
    if (has_alpha) p[3] = p[1];
    p[1] = p[2] = p[0];
  }
}

Status oiio_decode(OiioInput *input, ImageKind kind, void *rgba, Log *log)
{
  return guarded(STATUS_BAD_IMAGE, damaged, log, [&] {
    const OIIO::ImageSpec &spec = input->file->spec();
    uint64_t count = (uint64_t)spec.width * spec.height;
    int colours = spec.nchannels < 3 ? 1 : 3;
    bool has_alpha = spec.alpha_channel == colours;
    bool is_texture = kind == IMAGE_TEXTURE;
    OIIO::stride_t pixel_bytes = is_texture ? 4 : 4 * sizeof(float);
    if (!input->file->read_image(0, 0, 0, colours + has_alpha,
                                 is_texture ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::FLOAT, rgba, pixel_bytes))
      return fail(input->file, STATUS_BAD_IMAGE, damaged, log);
    if (is_texture)
      expand((uint8_t *)rgba, count, colours, has_alpha, (uint8_t)255);
    else
      expand((float *)rgba, count, colours, has_alpha, 1.0f);
    return STATUS_OK;
  });
}

static ImageElement element_of(const OIIO::TypeDesc &type)
{
  switch (type.basetype) {
    case OIIO::TypeDesc::UINT8: return IMAGE_UINT8;
    case OIIO::TypeDesc::UINT16: return IMAGE_UINT16;
    case OIIO::TypeDesc::UINT32: return IMAGE_UINT32;
    default: return IMAGE_FLOAT;
  }
}

Status oiio_layer_find(OiioLayer *out, const OiioInput *input, const char *channel, Log *log)
{
  return guarded(STATUS_BAD_IMAGE, damaged, log, [&] {
    const OIIO::ImageSpec &spec = input->file->spec();
    std::string names;
    for (int c = 0; c < spec.nchannels && *channel; c++) {
      names += (c ? ", " : "") + spec.channelnames[c];
      if (spec.channelnames[c] != channel) continue;
      *out = OiioLayer{(uint32_t)c, 1, element_of(spec.channelformat(c))};
      return STATUS_OK;
    }
    if (*channel) return log_fail(log, STATUS_BAD_IMAGE, "no channel %s: it has %.300s", channel, names.c_str());

    bool is_exr = input->format == IMAGE_EXR;
    int colours = spec.nchannels < 3 ? 1 : 3;
    bool has_alpha = spec.alpha_channel == colours;
    if (is_exr && spec.channelnames[0] != (colours == 3 ? "R" : "Y"))
      return log_fail(log, STATUS_BAD_IMAGE, "no picture among its channels: write R, G and B, or Y alone");
    *out = OiioLayer{0, (uint32_t)(colours + has_alpha), is_exr ? IMAGE_FLOAT : element_of(spec.format)};
    return STATUS_OK;
  });
}

Status oiio_layer_decode(OiioInput *input, const OiioLayer *layer, void *values, Log *log)
{
  static const OIIO::TypeDesc::BASETYPE types[] = {OIIO::TypeDesc::UINT8, OIIO::TypeDesc::UINT16,
                                                   OIIO::TypeDesc::UINT32, OIIO::TypeDesc::FLOAT};
  return guarded(STATUS_BAD_IMAGE, damaged, log, [&] {
    int first = (int)layer->first;
    if (!input->file->read_image(0, 0, first, first + (int)layer->channels, types[layer->element], values))
      return fail(input->file, STATUS_BAD_IMAGE, damaged, log);
    return STATUS_OK;
  });
}

void oiio_close(OiioInput *input) { delete input; }

// Primaries of linear sRGB (ITU-R BT.709): red, green, blue and the white D65, x and y of each.
static const float rec_709[8] = {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};

static const char *next(const char *text) { return text + strlen(text) + 1; }

Status oiio_encode(const char *path, const ImageRequest *request, const void *pixels, const char *text, Log *log)
{
  const char *hint = "try another format";
  return guarded(STATUS_OUTPUT, hint, log, [&] {
    ImageFormat format = (ImageFormat)request->format;
    OIIO::TypeDesc type = request->element_bits == 8    ? OIIO::TypeDesc::UINT8
                          : request->element_bits == 16 ? OIIO::TypeDesc::UINT16
                                                        : OIIO::TypeDesc::FLOAT;
    OIIO::ImageSpec spec((int)request->width, (int)request->height, (int)request->channels, type);

    const char *compression = text, *end = text + request->text_bytes;
    text = next(text);
    for (uint32_t c = 0; c < request->channels; c++, text = next(text)) {
      if (format != IMAGE_EXR) continue;
      spec.channelformats.push_back(text[0] == 'u' ? OIIO::TypeDesc::UINT : OIIO::TypeDesc::FLOAT);
      spec.channelnames[c] = text + 1;
    }
    if (format == IMAGE_EXR) spec.alpha_channel = -1;
    for (; text < end; text = next(next(text))) spec.attribute(text, next(text));

    if (format == IMAGE_PNG || format == IMAGE_JPEG) {
      spec.attribute("oiio:UnassociatedAlpha", 1);
      spec.attribute("oiio:ColorSpace", "sRGB");
    }
    if (format == IMAGE_PNG) {
      spec.attribute("png:compressionLevel", *compression ? *compression - '0' : PNG_LEVEL);
      spec.attribute("png:filter", PNG_FILTER_UP);
    }
    if (format == IMAGE_JPEG) {
      spec.attribute("CompressionQuality", (int)request->quality);
      if (request->quality >= FULL_CHROMA_QUALITY) spec.attribute("jpeg:subsampling", "4:4:4");
    }
    if (format == IMAGE_EXR) {
      spec.attribute("compression", *compression ? compression : "zip");
      spec.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), rec_709);
      // The writer stamps the time unless there is a DateTime, and drops one that is not a string.
      spec.attribute("DateTime", 0);
    }

    std::unique_ptr<OIIO::ImageOutput> file = OIIO::ImageOutput::create(format_names[format]);
    if (!file || !file->open(path, spec)) return fail(file, STATUS_OUTPUT, hint, log);
    OIIO::TypeDesc memory = format == IMAGE_EXR ? OIIO::TypeDesc(OIIO::TypeDesc::UNKNOWN) : type;
    bool written = file->write_image(memory, pixels);
    if (!file->close() || !written) return fail(file, STATUS_OUTPUT, hint, log);
    return STATUS_OK;
  });
}
