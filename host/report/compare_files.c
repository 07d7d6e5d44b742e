#include "report/compare_files.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"

typedef struct Linearise {
  const ImageLayer *layer;
  const float *table;  // linear values of integers, [256] or [65536]
  float (*pixels)[4];
  bool ignore_alpha;
} Linearise;

static float value_at(const Linearise *job, size_t i, bool is_alpha)
{
  const ImageLayer *layer = job->layer;
  if (layer->element == IMAGE_FLOAT) return ((const float *)layer->values)[i];
  uint32_t value =
      layer->element == IMAGE_UINT8 ? ((const uint8_t *)layer->values)[i] : ((const uint16_t *)layer->values)[i];
  if (is_alpha) return (float)value / (layer->element == IMAGE_UINT8 ? 255.0f : 65535.0f);
  return job->table[value];
}

static void row_linearise(void *context, size_t y)
{
  const Linearise *job = context;
  const ImageLayer *layer = job->layer;
  uint32_t channels = layer->channels, colors = channels < 3 ? 1 : 3;
  bool has_alpha = channels > colors && !job->ignore_alpha;
  for (size_t i = y * layer->width; i < (y + 1) * layer->width; i++) {
    float alpha = has_alpha ? value_at(job, i * channels + colors, true) : 1;
    float scale = layer->is_display ? alpha : 1;
    for (uint32_t c = 0; c < 3; c++)
      job->pixels[i][c] = scale * value_at(job, i * channels + (colors == 3 ? c : 0), false);
    job->pixels[i][3] = alpha;
  }
}

// Source: IEC 61966-2-1.
static float *linear_table(uint32_t count)
{
  float *table = malloc(count * sizeof *table);
  for (uint32_t i = 0; i < count && table; i++) {
    double v = (double)i / (count - 1);
    table[i] = (float)(v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4));
  }
  return table;
}

Status compare_picture_read(ComparePicture *out, ImageHelper *helper, const char *path, bool ignore_alpha, Log *log)
{
  Status status = STATUS_OK;
  ImageLayer layer = {0};
  float *table = NULL;
  Linearise job = {.layer = &layer, .ignore_alpha = ignore_alpha};

  TRY(image_read_layer(&layer, helper, path, NULL, log));
  *out = (ComparePicture){.channels = layer.channels, .is_display = layer.is_display};
  if (ignore_alpha) out->channels = layer.channels < 3 ? 1 : 3;
  out->image = (Image){.width = layer.width, .height = layer.height};
  if (layer.element == IMAGE_FLOAT && layer.channels == 4 && !ignore_alpha) {
    out->image.pixels = layer.values;  // as they are wanted
    layer.values = NULL;
    goto done;
  }
  job.table = table = linear_table(layer.element == IMAGE_UINT16 ? 1 << 16 : 1 << 8);
  job.pixels = malloc((size_t)layer.width * layer.height * sizeof *job.pixels);
  if (!table || !job.pixels) {
    free(job.pixels);
    status = log_no_memory(log, path);
    goto done;
  }
  parallel_for(layer.height, row_linearise, &job);
  out->image.pixels = (float *)job.pixels;

done:
  free(table);
  image_layer_free(&layer);
  return status;
}

Status compare_channels_check(const ComparePicture pictures[2], const char *const names[2], Log *log)
{
  static const char *const kinds[] = {"no channels", "grey", "grey and alpha", "RGB", "RGBA"};
  uint32_t a = pictures[0].channels, b = pictures[1].channels;
  if (a == b) return STATUS_OK;
  return log_fail(log, STATUS_BAD_IMAGE, "%s: %s, and %s is %s: %s", names[1], kinds[b], names[0], kinds[a],
                  (a < 3) == (b < 3) ? "--ignore-alpha compares the colours alone" : "compare pictures of one kind");
}

typedef struct Selection {
  char path[PATH_MAX];
  char channel[128];
  uint32_t ids[256];
  size_t id_count;
} Selection;

static bool ids_parse(Selection *out, const char *text)
{
  for (out->id_count = 0; out->id_count < sizeof out->ids / sizeof *out->ids;) {
    char *end = NULL;
    errno = 0;
    long long id = strtoll(text, &end, 10);
    if (end == text || errno || id < -1 || id > UINT32_MAX) return false;
    out->ids[out->id_count++] = (uint32_t)id;
    if (!*end) return true;
    if (*end != ',') return false;
    text = end + 1;
  }
  return false;
}

// A name may have `:` and `=` in it: the last ones count.
static Status selection_parse(Selection *out, const char *text, Log *log)
{
  const char *equals = strrchr(text, '='), *colon = equals;
  while (colon && colon > text && *colon != ':') colon--;
  bool good = colon && colon > text && equals - colon > 1 && ids_parse(out, equals + 1);
  good = good && colon - text < (ptrdiff_t)sizeof out->path;
  if (good) {
    int length = (int)(equals - colon - 1);
    bool whole = memchr(colon + 1, '.', (size_t)length);
    snprintf(out->path, sizeof out->path, "%.*s", (int)(colon - text), text);
    good = snprintf(out->channel, sizeof out->channel, "%.*s%s", length, colon + 1, whole ? "" : ".id") <
           (int)sizeof out->channel;
  }
  if (good) return STATUS_OK;
  return log_fail(log, STATUS_USAGE, "--mask %s: not valid: expected FILE:AOV=IDS, such as a.exr:object=3,5", text);
}

static bool id_is_selected(const Selection *selection, uint32_t id)
{
  for (size_t i = 0; i < selection->id_count; i++)
    if (selection->ids[i] == id) return true;
  return false;
}

Status compare_mask_select(uint8_t *mask, uint32_t width, uint32_t height, ImageHelper *helper, const char *text,
                           Log *log)
{
  Status status = STATUS_OK;
  Selection selection;
  ImageLayer layer = {0};
  size_t selected = 0;
  uint32_t largest = 0;

  TRY(selection_parse(&selection, text, log));
  TRY(image_read_layer(&layer, helper, selection.path, selection.channel, log));
  if (layer.element != IMAGE_UINT32)
    status = log_fail(log, STATUS_BAD_IMAGE, "%s: %s holds no ids: name object, primitive or material", selection.path,
                      selection.channel);
  else if (layer.width != width || layer.height != height)
    status =
        log_fail(log, STATUS_BAD_IMAGE, "%s: %u x %u pixels, and the pictures have %u x %u: use a mask of their size",
                 selection.path, layer.width, layer.height, width, height);
  if (status) goto done;

  const uint32_t *ids = layer.values;
  for (size_t i = 0; i < (size_t)width * height; i++) {
    bool is_selected = id_is_selected(&selection, ids[i]);
    selected += is_selected;
    if (!is_selected) mask[i] = 0;
    if (ids[i] != UINT32_MAX && ids[i] > largest) largest = ids[i];
  }
  if (!selected)
    status = log_fail(log, STATUS_BAD_IMAGE, "%s: no pixel with any of the ids asked for: those of %s end at %u",
                      selection.path, selection.channel, largest);

done:
  image_layer_free(&layer);
  return status;
}

Status image_compare_files(ImageError *out, ImageHelper *helper, const char *path_a, const char *path_b,
                           const ImageCompareOptions *options, Log *log)
{
  Status status = STATUS_OK;
  const char *names[2] = {path_a, path_b};
  ComparePicture pictures[2] = {0};
  ImageCompareOptions named = options ? *options : (ImageCompareOptions){0};
  for (int p = 0; p < 2; p++) {
    named.names[p] = names[p];
    TRY(compare_picture_read(&pictures[p], helper, names[p], false, log));
  }
  TRY(compare_channels_check(pictures, names, log));
  TRY(image_compare(out, &pictures[0].image, &pictures[1].image, &named, log));

done:
  for (int p = 0; p < 2; p++) image_free(&pictures[p].image);
  return status;
}
