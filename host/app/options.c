#include "app/options.h"

#include <ctype.h>
#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "app/app.h"

const char render_usage[] =
    "Examples:\n"
    "  frugal render scene.glb -o picture.png\n"
    "  frugal render scene.glb -o picture.png -s 1920x1080 -n 16\n"
    "  frugal render scene.glb -o picture.exr --aov depth,normal,object\n"
    "  frugal render scene.gltf -o picture.png --environment studio.hdr --exposure 0.5\n"
    "  frugal render scene.glb -o - --format png --lighting phong >picture.png\n"
    "\n"
    "Usage: frugal render SCENE -o OUT [OPTIONS]\n"
    "\n"
    "SCENE is a glTF 2.0 file (.glb, .gltf).\n"
    "\n"
    "Output:\n"
    "  -o, --output FILE          .png, .jpg, .exr or .hdr; - writes to standard output\n"
    "      --format FORMAT        png, jpg, exr or hdr, whatever the name's ending\n"
    "  -s, --size WxH             pixels (1280x720)\n"
    "  -n, --samples N            samples a pixel (1)\n"
    "      --exposure EV          brightness, in powers of two (0)\n"
    "      --tone-map CURVE       none, filmic, pbr-neutral (none)\n"
    "      --aov LIST             layers of an .exr: depth position normal albedo object primitive material shadow\n"
    "                             reflection\n"
    "\n"
    "View and light:\n"
    "      --camera CAMERA        index or name of a camera of the file, or fit (the first, else fit)\n"
    "      --environment LIGHT    HDR image file, #rrggbb, sky or none\n"
    "      --environment-rotation DEGREES, --environment-intensity FACTOR\n"
    "      --no-key-light         no built-in sun in a scene without lights\n"
    "\n"
    "Methods:\n"
    "      --lighting MODEL       pbr (glTF) or phong (the 2007 system's) (pbr)\n"
    "      --ambient A            ambient term of phong (0.05)\n"
    "      --primary METHOD       rays\n"
    "      --shadows METHOD       none, rays (rays)\n"
    "      --reflections METHOD   none, rays (rays)\n"
    "      --max-depth N          reflected bounces (8)\n"
    "      --max-roughness R      reflect surfaces up to this roughness (0: mirrors alone)\n"
    "\n"
    "Machine:\n"
    "      --device DEVICE        index or part of a name as in `frugal devices`, cpu, gpu (the best)\n"
    "      --threads N            threads of the host and of a CPU device (all)\n"
    "      --seed N               random numbers of sampled effects (0)\n"
    "      --max-memory BYTES     limit on what an input may ask for, with k, M, G (3/4 of RAM)\n"
    "      --max-image-pixels N   limit on the size of an image file (268435456)\n"
    "      --allow-outside        let a .gltf name files outside its folder\n"
    "\n"
    "Reports:\n"
    "      --profile              table of where the time went, on standard error\n"
    "      --stats FILE           the same as JSON\n"
    "      --trace FILE           every launch, in Chrome's trace format\n"
    "  -q, --quiet                warnings and errors only\n"
    "  -h, --help\n"
    "\n"
    "Exit codes: 0 done, 2 usage, 3 no usable device, 4 input, 5 output, 130 interrupted.\n";

typedef enum OptionId {
  OPT_FORMAT = 256, OPT_EXPOSURE, OPT_TONE_MAP, OPT_AOV, OPT_CAMERA, OPT_ENVIRONMENT, OPT_ROTATION, OPT_INTENSITY,
  OPT_NO_KEY_LIGHT, OPT_LIGHTING, OPT_AMBIENT, OPT_PRIMARY, OPT_SHADOWS, OPT_REFLECTIONS, OPT_MAX_DEPTH, OPT_MAX_ROUGHNESS,
  OPT_DEVICE, OPT_THREADS, OPT_SEED, OPT_MAX_MEMORY, OPT_MAX_IMAGE_PIXELS, OPT_ALLOW_OUTSIDE, OPT_PROFILE, OPT_STATS, OPT_TRACE,
} OptionId;

static const struct option long_options[] = {
    {"output", required_argument, NULL, 'o'},
    {"format", required_argument, NULL, OPT_FORMAT},
    {"size", required_argument, NULL, 's'},
    {"samples", required_argument, NULL, 'n'},
    {"exposure", required_argument, NULL, OPT_EXPOSURE},
    {"tone-map", required_argument, NULL, OPT_TONE_MAP},
    {"aov", required_argument, NULL, OPT_AOV},
    {"camera", required_argument, NULL, OPT_CAMERA},
    {"environment", required_argument, NULL, OPT_ENVIRONMENT},
    {"environment-rotation", required_argument, NULL, OPT_ROTATION},
    {"environment-intensity", required_argument, NULL, OPT_INTENSITY},
    {"no-key-light", no_argument, NULL, OPT_NO_KEY_LIGHT},
    {"lighting", required_argument, NULL, OPT_LIGHTING},
    {"ambient", required_argument, NULL, OPT_AMBIENT},
    {"primary", required_argument, NULL, OPT_PRIMARY},
    {"shadows", required_argument, NULL, OPT_SHADOWS},
    {"reflections", required_argument, NULL, OPT_REFLECTIONS},
    {"max-depth", required_argument, NULL, OPT_MAX_DEPTH},
    {"max-roughness", required_argument, NULL, OPT_MAX_ROUGHNESS},
    {"device", required_argument, NULL, OPT_DEVICE},
    {"threads", required_argument, NULL, OPT_THREADS},
    {"seed", required_argument, NULL, OPT_SEED},
    {"max-memory", required_argument, NULL, OPT_MAX_MEMORY},
    {"max-image-pixels", required_argument, NULL, OPT_MAX_IMAGE_PIXELS},
    {"allow-outside", no_argument, NULL, OPT_ALLOW_OUTSIDE},
    {"profile", no_argument, NULL, OPT_PROFILE},
    {"stats", required_argument, NULL, OPT_STATS},
    {"trace", required_argument, NULL, OPT_TRACE},
    {"quiet", no_argument, NULL, 'q'},
    {"help", no_argument, NULL, 'h'},
    {NULL, 0, NULL, 0},
};

static Status fail_value(Log *log, const char *option, const char *value, const char *expected)
{
  return log_fail(log, STATUS_USAGE, "--%s %s: not valid: expected %s", option, value, expected);
}

static Status parse_number(double *out, const char *option, const char *text, double low, double high, Log *log)
{
  char *end = NULL, expected[96];
  double value = strtod(text, &end);
  if (end != text && *end == 0 && value >= low && value <= high) {
    *out = value;
    return STATUS_OK;
  }
  snprintf(expected, sizeof expected, "a number from %g to %g", low, high);
  return fail_value(log, option, text, expected);
}

static Status parse_count(uint64_t *out, const char *option, const char *text, uint64_t low, uint64_t high, Log *log)
{
  char *end = NULL, expected[96];
  errno = 0;
  unsigned long long value = strtoull(text, &end, 10);
  if (isdigit((unsigned char)text[0]) && *end == 0 && errno == 0 && value >= low && value <= high) {
    *out = value;
    return STATUS_OK;
  }
  snprintf(expected, sizeof expected, "a whole number from %llu to %llu", (unsigned long long)low, (unsigned long long)high);
  return fail_value(log, option, text, expected);
}

static Status parse_u32(uint32_t *out, const char *option, const char *text, uint64_t low, uint64_t high, Log *log)
{
  uint64_t value = 0;
  Status status = parse_count(&value, option, text, low, high, log);
  if (!status) *out = (uint32_t)value;
  return status;
}

// Bytes with an optional k, M or G (powers of 1024).
static Status parse_bytes(uint64_t *out, const char *option, const char *text, Log *log)
{
  char *end = NULL;
  double value = strtod(text, &end);
  const char *units = "kMG", *unit = *end ? strchr(units, *end) : NULL;
  if (end != text && unit && end[1] == 0) {
    value *= pow(1024, (double)(unit - units + 1));
    end++;
  }
  if (end == text || *end || !(value >= 1) || value > 1e18) return fail_value(log, option, text, "a size such as 512M or 4G");
  *out = (uint64_t)value;
  return STATUS_OK;
}

static Status parse_choice(int *out, const char *option, const char *text, const char *const *names, Log *log)
{
  for (int i = 0; names[i]; i++) {
    if (strcmp(names[i], text) != 0) continue;
    *out = i;
    return STATUS_OK;
  }
  return log_fail(log, STATUS_USAGE, "--%s %s: no such value: did you mean '%s'?", option, text, app_nearest(text, names));
}

static Status parse_size(RenderSettings *settings, const char *text, Log *log)
{
  unsigned long width = 0, height = 0;
  char end = 0;
  if (!isdigit((unsigned char)text[0]) || sscanf(text, "%lux%lu%c", &width, &height, &end) != 2)
    return fail_value(log, "size", text, "WIDTHxHEIGHT, e.g. 1280x720");
  if (width < 1 || height < 1 || width > 65536 || height > 65536)
    return fail_value(log, "size", text, "1 to 65536 pixels on each side");
  settings->width = (uint32_t)width;
  settings->height = (uint32_t)height;
  return STATUS_OK;
}

static Status parse_aovs(uint32_t *out, const char *text, Log *log)
{
  static const char *const names[] = {"depth",     "position", "normal", "albedo", "object",
                                      "primitive", "material", "shadow", "reflection", NULL};
  char list[256];
  snprintf(list, sizeof list, "%s", text);
  for (char *rest = NULL, *name = strtok_r(list, ", ", &rest); name; name = strtok_r(NULL, ", ", &rest)) {
    int index = 0;
    Status status = parse_choice(&index, "aov", name, names, log);
    if (status) return status;
    *out |= 1u << index;
  }
  return STATUS_OK;
}

// #rrggbb, sRGB, to linear.
static Status parse_color(float out[3], const char *option, const char *text, Log *log)
{
  unsigned rgb[3];
  char end = 0;
  if (strlen(text) != 7 || sscanf(text, "#%2x%2x%2x%c", &rgb[0], &rgb[1], &rgb[2], &end) != 3)
    return fail_value(log, option, text, "a colour such as #8090a0");
  for (int c = 0; c < 3; c++) {
    double s = rgb[c] / 255.0;
    out[c] = (float)(s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4));
  }
  return STATUS_OK;
}

static Status parse_environment(RenderOptions *out, const char *text, Log *log)
{
  if (!strcmp(text, "none")) {
    out->environment = ENVIRONMENT_NONE;
  } else if (!strcmp(text, "sky")) {
    out->environment = ENVIRONMENT_SKY;
  } else if (text[0] == '#') {
    out->environment = ENVIRONMENT_COLOR;
    return parse_color(out->environment_color, "environment", text, log);
  } else {
    out->environment = ENVIRONMENT_FILE;
    out->environment_path = text;
  }
  return STATUS_OK;
}

static Status parse_option(RenderOptions *out, int id, const char *name, const char *value, Log *log)
{
  static const char *const tones[] = {"none", "filmic", "pbr-neutral", NULL}, *const models[] = {"pbr", "phong", NULL},
                           *const methods[] = {"none", "rays", NULL}, *const primaries[] = {"rays", NULL},
                           *const formats[] = {"png", "jpg", "exr", "hdr", NULL};
  Status status = STATUS_OK;
  double number = 0;
  int choice = 0;
  switch (id) {
    case 'o': out->output_path = value; break;
    case 's': return parse_size(&out->settings, value, log);
    case 'n': return parse_u32(&out->settings.samples, name, value, 1, 1u << 20, log);
    case 'q': out->quiet = true; break;
    case 'h': out->help = true; break;
    case OPT_FORMAT:
      TRY(parse_choice(&choice, name, value, formats, log));
      out->format = value;
      break;
    case OPT_EXPOSURE:
      TRY(parse_number(&number, name, value, -64, 64, log));
      out->picture.exposure_ev = (float)number;
      break;
    case OPT_TONE_MAP:
      TRY(parse_choice(&choice, name, value, tones, log));
      out->picture.tone = (uint32_t)choice;
      break;
    case OPT_AOV: return parse_aovs(&out->picture.aovs, value, log);
    case OPT_CAMERA: out->camera = value; break;
    case OPT_ENVIRONMENT: return parse_environment(out, value, log);
    case OPT_ROTATION:
      TRY(parse_number(&number, name, value, -3600, 3600, log));
      out->environment_rotation_rad = number * M_PI / 180;
      break;
    case OPT_INTENSITY:
      TRY(parse_number(&number, name, value, 0, 1e9, log));
      out->environment_intensity = (float)number;
      break;
    case OPT_NO_KEY_LIGHT: out->key_light = false; break;
    case OPT_LIGHTING:
      TRY(parse_choice(&choice, name, value, models, log));
      out->settings.lighting = (LightingModel)choice;
      break;
    case OPT_AMBIENT:
      TRY(parse_number(&number, name, value, 0, 1e6, log));
      out->settings.ambient = (float)number;
      break;
    case OPT_PRIMARY: return parse_choice(&choice, name, value, primaries, log);
    case OPT_SHADOWS:
      TRY(parse_choice(&choice, name, value, methods, log));
      out->settings.shadows = (ShadowMethod)choice;
      break;
    case OPT_REFLECTIONS:
      TRY(parse_choice(&choice, name, value, methods, log));
      out->settings.reflections = (ReflectionMethod)choice;
      break;
    case OPT_MAX_DEPTH: return parse_u32(&out->settings.max_depth, name, value, 0, 1000, log);
    case OPT_MAX_ROUGHNESS:
      TRY(parse_number(&number, name, value, 0, 1, log));
      if (number > 0)
        return log_fail(log, STATUS_USAGE, "--max-roughness %s: rough reflections are not there yet: use 0", value);
      break;
    case OPT_DEVICE: out->device = value; break;
    case OPT_THREADS: return parse_u32(&out->threads, name, value, 1, 256, log);
    case OPT_SEED: return parse_u32(&out->seed, name, value, 0, UINT32_MAX, log);
    case OPT_MAX_MEMORY: return parse_bytes(&out->max_memory_bytes, name, value, log);
    case OPT_MAX_IMAGE_PIXELS: return parse_count(&out->max_image_pixels, name, value, 1, 1ull << 40, log);
    case OPT_ALLOW_OUTSIDE: out->allow_outside = true; break;
    case OPT_PROFILE: out->profile = true; break;
    case OPT_STATS: out->stats_path = value; break;
    case OPT_TRACE: out->trace_path = value; break;
  }

done:
  return status;
}

// getopt has refused `word`: an unknown option, or one whose argument is missing.
static Status fail_option(Log *log, const char *word, int missing)
{
  if (missing) return log_fail(log, STATUS_USAGE, "%s: needs a value: see frugal render --help", word);
  const char *names[sizeof long_options / sizeof *long_options];
  size_t count = 0;
  for (; long_options[count].name; count++) names[count] = long_options[count].name;
  names[count] = NULL;
  char bare[64];
  snprintf(bare, sizeof bare, "%s", word + strspn(word, "-"));
  bare[strcspn(bare, "=")] = 0;
  return log_fail(log, STATUS_USAGE, "%s: no such option: did you mean --%s?", word, app_nearest(bare, names));
}

Status render_options_parse(RenderOptions *out, int argc, char **argv, Log *log)
{
  Status status = STATUS_OK;
  uint64_t ram = (uint64_t)sysconf(_SC_PHYS_PAGES) * (uint64_t)sysconf(_SC_PAGESIZE);
  *out = (RenderOptions){
      .settings = {.width = 1280, .height = 720, .samples = 1, .shadows = SHADOWS_RAYS, .reflections = REFLECTIONS_RAYS,
                   .max_depth = 8, .ambient = 0.05f},
      .picture = {.opaque = true, .bit_depth = 8, .quality = 95},
      .environment_intensity = 1,
      .key_light = true,
      .max_memory_bytes = ram / 4 * 3,
      .max_image_pixels = 1ull << 28,
  };
  opterr = 0;
  optind = 1;
  for (int id, index = -1; (id = getopt_long(argc, argv, ":o:s:n:qh", long_options, &index)) != -1; index = -1) {
    if (id == '?' || id == ':') return fail_option(log, argv[optind - 1], id == ':');
    const char *name = id == 'o' ? "output" : id == 's' ? "size" : id == 'n' ? "samples" : index >= 0 ? long_options[index].name : "";
    TRY(parse_option(out, id, name, optarg, log));
  }
  if (out->help) return STATUS_OK;
  if (optind >= argc) return log_fail(log, STATUS_USAGE, "render: no scene: frugal render SCENE -o OUT");
  out->scene_path = argv[optind];
  if (optind + 1 < argc)
    return log_fail(log, STATUS_USAGE, "%s: one scene at a time: what is this one for?", argv[optind + 1]);
  if (!out->output_path) return log_fail(log, STATUS_USAGE, "%s: no output: add -o picture.png", out->scene_path);
  if (!out->format) out->format = image_format_of(out->output_path);
  if (!out->format)
    return log_fail(log, STATUS_USAGE, "%s: unknown kind of picture: end it in .png, .jpg, .exr or .hdr, or add --format",
                    out->output_path);
  if (out->picture.aovs && strcmp(out->format, "exr") != 0)
    return log_fail(log, STATUS_USAGE, "%s: --aov needs a format with layers: use .exr", out->output_path);

done:
  return status;
}
