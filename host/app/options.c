#include "app/options.h"

#include <stdlib.h>
#include <string.h>

// "WxH", or `count` whole numbers between commas, each of at most `most`; false for anything else.
static bool numbers_read(uint32_t *out, int count, char separator, unsigned long most, const char *text)
{
  for (int i = 0; i < count; i++) {
    char *end = NULL;
    if (text[0] < '0' || text[0] > '9') return false;
    unsigned long value = strtoul(text, &end, 10);
    if (value > most || *end != (i + 1 < count ? separator : 0)) return false;
    out[i] = (uint32_t)value;
    text = end + 1;
  }
  return true;
}

static Status read_size(void *field, const Option *option, const char *text, Log *log)
{
  uint32_t size[2];
  RenderSettings *settings = field;
  if (!numbers_read(size, 2, 'x', (unsigned long)option->high, text) || size[0] == 0 || size[1] == 0)
    return option_fail(log, option, text, "WIDTHxHEIGHT such as 1280x720, each from 1 to 65536");
  settings->width = size[0];
  settings->height = size[1];
  return STATUS_OK;
}

static Status read_crop(void *field, const Option *option, const char *text, Log *log)
{
  uint32_t crop[4];
  if (!numbers_read(crop, 4, ',', (unsigned long)option->high, text) || crop[2] == 0 || crop[3] == 0)
    return option_fail(log, option, text, "X,Y,WIDTH,HEIGHT in pixels from the top left");
  *(Crop *)field = (Crop){crop[0], crop[1], crop[2], crop[3]};
  return STATUS_OK;
}

// Names joined by commas; a bit each, in the order of `words`.
static Status read_aovs(void *field, const Option *option, const char *text, Log *log)
{
  Status status = STATUS_OK;
  char list[256];
  if (strlen(text) >= sizeof list) return option_fail(log, option, text, "names joined by commas");
  strcpy(list, text);
  uint32_t set = 0;
  for (char *rest = NULL, *name = strtok_r(list, ", ", &rest); name; name = strtok_r(NULL, ", ", &rest)) {
    int index = 0;
    TRY(option_read_word(&index, option, name, log));
    set |= 1u << index;
  }
  *(uint32_t *)field = set;

done:
  return status;
}

// A size in texels; 0 for auto.
static Status size_read(void *field, const Option *option, const char *text, uint32_t multiple, const char *wanted,
                        Log *log)
{
  Status status = STATUS_OK;
  uint32_t size = 0;
  if (strcmp(text, "auto") != 0) TRY(option_read_u32(&size, option, text, log));
  if (size % multiple) return option_fail(log, option, text, wanted);
  *(uint32_t *)field = size;

done:
  return status;
}

static Status read_map_size(void *field, const Option *option, const char *text, Log *log)
{
  return size_read(field, option, text, 4, "a multiple of 4", log);
}

static Status read_cube_size(void *field, const Option *option, const char *text, Log *log)
{
  return size_read(field, option, text, 8, "a multiple of 8", log);
}

static Status read_near_radius(void *field, const Option *option, const char *text, Log *log)
{
  *(float *)field = 0;
  if (strcmp(text, "auto") == 0) return STATUS_OK;
  Status status = option_read_float(field, option, text, log);
  if (!status && !(*(float *)field > 0)) status = option_fail(log, option, text, "metres above 0, or auto");
  return status;
}

static Status read_reflections(void *field, const Option *option, const char *text, Log *log)
{
  int index = 0;
  Status status = option_read_word(&index, option, text, log);
  if (!status) *(ReflectionMethod *)field = (ReflectionMethod)(REFLECTIONS_NONE + index);
  return status;
}

static Status read_kernel(void *field, const Option *option, const char *text, Log *log)
{
  Status status = STATUS_OK;
  uint32_t size = 0;
  TRY(option_read_u32(&size, option, text, log));
  if (size % 2 == 0) return option_fail(log, option, text, "an odd number");
  *(uint32_t *)field = size;

done:
  return status;
}

static Status read_environment(void *field, const Option *option, const char *text, Log *log)
{
  EnvironmentSource source = {.choice = ENVIRONMENT_FILE, .text = text};
  if (!strcmp(text, "none"))
    source.choice = ENVIRONMENT_NONE;
  else if (!strcmp(text, "sky"))
    source.choice = ENVIRONMENT_SKY;
  else if (text[0] == '#')
    source.choice = ENVIRONMENT_COLOR;
  Status status = source.choice == ENVIRONMENT_COLOR ? option_read_color(source.color, option, text, log)
                  : *text                            ? STATUS_OK
                                                     : option_fail(log, option, text, "a file, #rrggbb, sky or none");
  if (!status) *(EnvironmentSource *)field = source;
  return status;
}

static Status read_background(void *field, const Option *option, const char *text, Log *log)
{
  Background background = {.kind = BACKGROUND_COLOR, .text = text};
  int index = 0;
  Status status = text[0] == '#' ? option_read_color(background.color, option, text, log)
                                 : option_read_word(&index, option, text, log);
  if (text[0] != '#') background.kind = index == 0 ? BACKGROUND_ENVIRONMENT : BACKGROUND_TRANSPARENT;
  if (!status) *(Background *)field = background;
  return status;
}

static Status read_exposure(void *field, const Option *option, const char *text, Log *log)
{
  ExposureChoice choice = {.is_auto = !strcmp(text, "auto")};
  Status status = choice.is_auto ? STATUS_OK : option_read_float(&choice.ev, option, text, log);
  if (!status) *(ExposureChoice *)field = choice;
  return status;
}

static Status read_verify(void *field, const Option *option, const char *text, Log *log)
{
  VerifyChoice choice = {.all = !strcmp(text, "all")};
  Status status = choice.all ? STATUS_OK : option_read_u32(&choice.pixels, option, text, log);
  if (!status) *(VerifyChoice *)field = choice;
  return status;
}

#define WORDS(...) ((const char *const[]){__VA_ARGS__, NULL})
#define REFLECTIONS \
  WORDS("none", "environment", "cube", "box", "impostor", "snapshot", "planar", "candidates", "mixed", "hybrid", "rays")
#define FIELD(name) .field = offsetof(RenderOptions, name)

static const Option render_options[] = {
    OPTION_HEADING("Output:"),
    {"output", 'o', "FILE", option_read_text, FIELD(output_path),
     .help = ".png, .jpg, .exr or .hdr; - writes to standard output"},
    {"format", 0, "FORMAT", option_read_name, FIELD(format), .words = WORDS("png", "jpg", "exr", "hdr"),
     .help = "png, jpg, exr or hdr, whatever the name's ending"},
    {"size", 's', "WxH", read_size, FIELD(settings), .high = 65536, .json = OPTION_JSON_TEXT | OPTION_JSON_NUMBERS,
     .between = 'x', .help = "pixels (1280x720)"},
    {"crop", 0, "X,Y,W,H", read_crop, FIELD(crop), .high = 65536, .json = OPTION_JSON_TEXT | OPTION_JSON_NUMBERS,
     .help = "only this part of the picture, from its top left (all)"},
    {"samples", 'n', "N", option_read_u32, FIELD(settings.samples), .low = 1, .high = 1 << 20,
     .json = OPTION_JSON_NUMBER, .help = "samples a pixel (1)"},
    {"exposure", 0, "EV", read_exposure, FIELD(exposure), .low = -64, .high = 64,
     .json = OPTION_JSON_NUMBER | OPTION_JSON_TEXT,
     .help = "brightness, in powers of two (0), or auto: the surfaces'\nlog-average luminance becomes 0.18"},
    {"tone-map", 0, "CURVE", option_read_word, FIELD(picture.tone), .words = WORDS("none", "filmic", "pbr-neutral"),
     .json = OPTION_JSON_TEXT, .help = "none, filmic, pbr-neutral (none)"},
    {"background", 0, "WHAT", read_background, FIELD(background), .words = WORDS("environment", "transparent"),
     .json = OPTION_JSON_TEXT,
     .help = "environment, transparent (.png, .exr) or #rrggbb: what the\ncamera sees behind the scene (environment)"},
    {"aov", 0, "LIST", read_aovs, FIELD(picture.aovs),
     .words = WORDS("depth", "position", "normal", "albedo", "object", "primitive", "material", "shadow", "reflection"),
     .json = OPTION_JSON_TEXT | OPTION_JSON_TEXTS,
     .help = "layers of an .exr, joined by commas: depth position normal\nalbedo object primitive material shadow "
             "reflection"},
    {"bit-depth", 0, "BITS", option_read_u32, FIELD(picture.bit_depth), .low = 8, .high = 16,
     .json = OPTION_JSON_NUMBER, .help = "8 or 16 bits a channel of a .png (8)"},
    {"quality", 0, "Q", option_read_u32, FIELD(picture.quality), .low = 1, .high = 100, .json = OPTION_JSON_NUMBER,
     .help = "of a .jpg, 1 to 100 (95)"},
    {"compression", 0, "METHOD", option_read_text, FIELD(picture.compression),
     .json = OPTION_JSON_NUMBER | OPTION_JSON_TEXT,
     .help = ".png: 0 to 9 (1); .exr: none, rle, zip, zips, piz, pxr24,\nb44, b44a, dwaa or dwab (zip)"},
    {"overwrite", 0, NULL, option_read_true, FIELD(overwrite), .help = "replace a picture that is there (the default)"},
    {"no-clobber", 0, NULL, option_read_false, FIELD(overwrite), .help = "fail where there is one already"},

    OPTION_HEADING("Animation:"),
    {"frames", 0, "RANGE", option_read_frames, FIELD(frames), .json = OPTION_JSON_NUMBER | OPTION_JSON_TEXT,
     .help =
         "12, 0-47, 0-47x2 (each second one) or all: pictures of the\nscene as it moves, with {frame} or {frame:04} "
         "in the name of\neach output (one picture of the pose at rest)"},
    {"fps", 0, "N", option_read_float, FIELD(fps), .low = 1e-3, .high = 1e6, .json = OPTION_JSON_NUMBER,
     .help = "frames a second (24)"},
    {"animation", 0, "ANIMATION", option_read_text, FIELD(animation), .json = OPTION_JSON_NUMBER | OPTION_JSON_TEXT,
     .help = "index or name of an animation of the file (the first)"},

    OPTION_HEADING("View and light:"),
    {"camera", 0, "CAMERA", option_read_text, FIELD(camera), .json = OPTION_JSON_NUMBER | OPTION_JSON_TEXT,
     .help = "index or name of a camera of the file, or fit: a view of\nall (the first, else fit)"},
    {"list-cameras", 0, NULL, option_read_true, FIELD(list_cameras),
     .help = "print the scene's cameras, render nothing"},
    {"environment", 0, "LIGHT", read_environment, FIELD(environment), .json = OPTION_JSON_TEXT,
     .help = "HDR image file, #rrggbb, sky or none (none for a scene with\nlights, else sky)"},
    {"environment-rotation", 0, "DEGREES", option_read_radians, FIELD(environment_rotation_rad), .low = -3600,
     .high = 3600, .json = OPTION_JSON_NUMBER, .help = "about the vertical axis (0)"},
    {"environment-intensity", 0, "FACTOR", option_read_float, FIELD(environment_intensity), .high = 1e9,
     .json = OPTION_JSON_NUMBER, .help = "times its radiance (1)"},
    {"no-key-light", 0, NULL, option_read_false, FIELD(key_light), .json = OPTION_JSON_FLAG,
     .help = "no built-in sun in a scene without lights"},

    OPTION_HEADING("Methods:"),
    {"lighting", 0, "MODEL", option_read_word, FIELD(settings.lighting), .words = WORDS("pbr", "phong"),
     .json = OPTION_JSON_TEXT, .help = "pbr (glTF) or phong (the 2007 system's) (pbr)"},
    {"ambient", 0, "A", option_read_float, FIELD(settings.ambient), .high = 1e6, .json = OPTION_JSON_NUMBER,
     .help = "ambient term of phong (0.05)"},
    {"primary", 0, "METHOD", option_read_word, FIELD(settings.primary), .words = WORDS("auto", "raster", "rays"),
     .json = OPTION_JSON_TEXT, .help = "raster, rays, or auto: the quicker; all show the same (auto)"},
    {"methods", 0, "CHOICE", option_read_word, FIELD(settings.methods), .words = WORDS("auto", "exact"),
     .json = OPTION_JSON_TEXT,
     .help = "exact: the most accurate method where none is named below;\nauto: that, unless samples are too few for "
             "it (auto)"},
    {"shadows", 0, "METHOD", option_read_word, FIELD(settings.shadows), .words = shadow_words, .json = OPTION_JSON_TEXT,
     .help = "none, map, pcf, pcss, hybrid, rays, area, or auto: hybrid\nor rays, the quicker for each light (rays)"},
    {"light-shadows", 0, "LIST", option_read_light_shadows, FIELD(light_shadows),
     .json = OPTION_JSON_TEXT | OPTION_JSON_PAIRS,
     .help = "NAME=METHOD,...: of single lights, by names and numbers (#2)\nof frugal info: none, map, pcf, pcss, "
             "hybrid, rays, area or\nauto (as --shadows)"},
    {"shadow-map-size", 0, "N", read_map_size, FIELD(settings.shadow_options.map_size_px), .low = 16, .high = 8192,
     .json = OPTION_JSON_NUMBER | OPTION_JSON_TEXT,
     .help = "texels a side of shadow maps, or auto: about a pixel each\n(auto)"},
    {"shadow-kernel", 0, "N", read_kernel, FIELD(settings.shadow_options.kernel_px), .low = 1, .high = 15,
     .json = OPTION_JSON_NUMBER, .help = "texels a side that pcf averages, odd (3)"},
    {"light-radius", 0, "M", option_read_float, FIELD(settings.shadow_options.light_radius_m), .high = 1e9,
     .json = OPTION_JSON_NUMBER, .help = "of point and spot lights in metres, for pcss and area (0)"},
    {"light-angle", 0, "DEGREES", option_read_radians, FIELD(settings.shadow_options.light_angle_rad), .high = 45,
     .json = OPTION_JSON_NUMBER,
     .help = "half of what a directional light subtends, for pcss and\narea (0; the sun has 0.27)"},
    {"reflections", 0, "METHOD", read_reflections, FIELD(settings.reflections), .words = REFLECTIONS,
     .json = OPTION_JSON_TEXT,
     .help = "what mirrors show: none, environment, cube, box, impostor,\nsnapshot, planar, candidates, mixed, hybrid, "
             "or rays (rays)"},
    {"deep-reflections", 0, "METHOD", read_reflections, FIELD(settings.deep_reflections), .words = REFLECTIONS,
     .json = OPTION_JSON_TEXT,
     .help = "what mirrors in mirrors show: none, environment, cube, box,\nimpostor, snapshot, planar, candidates, "
             "mixed, hybrid, or rays\n"
             "(as --reflections)"},
    {"cube-size", 0, "N", read_cube_size, FIELD(settings.cubes.size_px), .low = 8, .high = 2048,
     .json = OPTION_JSON_NUMBER | OPTION_JSON_TEXT,
     .help = "texels a side of cube maps, or auto: as pixels of the\nreflector (auto)"},
    {"near-radius", 0, "M", read_near_radius, FIELD(settings.cubes.near_radius_m), .high = 1e9,
     .json = OPTION_JSON_NUMBER | OPTION_JSON_TEXT,
     .help = "what is so near a cube map's centre, in metres, is listed by\nsnapshot, candidates and mixed; or auto: "
             "by parallax (auto)"},
    {"snapshot-from", 0, "N", option_read_u32, FIELD(settings.cubes.complex_from), .low = 1, .high = UINT32_MAX,
     .json = OPTION_JSON_NUMBER, .help = "triangles from which mixed takes a snapshot of an object (4096)"},
    {"environment-light", 0, "METHOD", option_read_word, FIELD(settings.environment_light),
     .words = WORDS("auto", "none", "ambient", "sh", "sh-ao", "sampled"), .json = OPTION_JSON_TEXT,
     .help =
         "none, ambient, sh (harmonics), sh-ao (and ambient occlusion),\nsampled (auto: sampled from 16 samples on, "
         "else sh)"},
    {"max-depth", 0, "N", option_read_u32, FIELD(settings.max_depth), .high = 1000, .json = OPTION_JSON_NUMBER,
     .help = "reflected bounces (8)"},
    {"max-roughness", 0, "R", option_read_float, FIELD(settings.max_roughness), .high = 1, .json = OPTION_JSON_NUMBER,
     .help = "surfaces up to this roughness reflect; 0: mirrors alone\n(1 with cube maps, which answer without "
             "samples, and\nfrom 16 samples on, else 0; phong: 0)"},

    OPTION_HEADING("Machine:"),
    {"device", 0, "DEVICE", option_read_text, FIELD(device),
     .help = "index or part of a name as in `frugal devices`, cpu, gpu\n(the best)"},
    {"threads", 0, "N", option_read_u32, FIELD(threads), .low = 1, .high = 256,
     .help = "of the host and of a CPU device (all)"},
    {"seed", 0, "N", option_read_u32, FIELD(seed), .high = UINT32_MAX, .json = OPTION_JSON_NUMBER,
     .help = "random numbers of sampled effects (0)"},
    {"max-memory", 0, "BYTES", option_read_bytes, FIELD(max_memory_bytes),
     .help = "most that the scene file and the picture may need, each,\nwith k, M or G (3/4 of RAM)"},
    {"max-image-pixels", 0, "N", option_read_u64, FIELD(max_image_pixels), .low = 1, .high = 1e12,
     .help = "largest image file read (268435456)"},
    {"allow-outside", 0, NULL, option_read_true, FIELD(allow_outside),
     .help = "let a .gltf name files outside its folder"},

    OPTION_HEADING("Reports:"),
    {"profile", 0, NULL, option_read_true, FIELD(profile), .help = "table of where the time went, on standard error"},
    {"stats", 0, "FILE", option_read_text, FIELD(stats_path), .help = "the same as JSON; - for standard output"},
    {"verify", 0, "N", read_verify, FIELD(verify), .low = 1, .high = UINT32_MAX,
     .help = "trace about N pixels, or all, exactly and say how many of the\npicture's are off by more than 2/255"},
    {"trace", 0, "FILE", option_read_text, FIELD(trace_path), .help = "every launch, in Chrome's trace format"},
    {"progress", 0, NULL, option_read_true, FIELD(progress),
     .help = "say how far it is, also where no terminal shows it"},
    {"verbose", 'v', NULL, option_read_true, FIELD(verbose), .help = "say what is done, and on what"},
    {"quiet", 'q', NULL, option_read_true, FIELD(quiet), .help = "warnings and errors only"},
};

const CommandLine render_command_line = {
    .name = "render",
    .usage =
        "Examples:\n"
        "  frugal render scene.glb -o picture.png\n"
        "  frugal render scene.glb -o picture.png -s 1920x1080 -n 16 --exposure auto\n"
        "  frugal render scene.glb -o picture.exr --aov depth,normal,object\n"
        "  frugal render scene.gltf -o picture.png --environment studio.hdr --background transparent\n"
        "  frugal render scene.glb -o - --format png --lighting phong >picture.png\n"
        "  frugal render scene.glb -o 'frames/{frame:04}.png' --frames all\n"
        "  frugal render scene.glb --list-cameras\n"
        "\n"
        "Usage: frugal render SCENE -o OUT [OPTIONS]\n"
        "\n"
        "SCENE is a glTF 2.0 file (.glb, .gltf), or a scene file (.json) that names one in \"scene\", holds\n"
        "options by their long names, which the command line's win over, and says what of \"nodes\" casts\n"
        "no shadow.\n",
    .closing =
        "\nExit codes: 0 done, 2 usage, 3 no usable device, 4 input or memory, 5 output, 130 and 143 interrupted.\n",
    .options = render_options,
    .option_count = sizeof render_options / sizeof *render_options,
};

PictureArea render_area(const RenderOptions *options)
{
  const RenderSettings *settings = &options->settings;
  const Crop *crop = &options->crop;
  PictureArea area = {settings->width, settings->height, crop->x, crop->y, crop->width, crop->height};
  if (crop->width == 0) area.width = settings->width;
  if (crop->width == 0) area.height = settings->height;
  return area;
}

Status render_options_parse(RenderOptions *out, int argc, char **argv, Log *log)
{
  Status status = STATUS_OK;
  *out = render_options_default();
  TRY(command_line_parse(&out->help, &out->scene_path, 1, out, &render_command_line, argc, argv, log));
  if (out->scene_path && !out->help) {
    TRY(render_options_read_file(out, out->scene_path, out->allow_outside, log));
    TRY(command_line_parse(&out->help, &out->scene_path, 1, out, &render_command_line, argc, argv, log));
  }
  if (out->help) return STATUS_OK;
  if (!out->scene_path) return log_fail(log, STATUS_USAGE, "render: no scene: frugal render SCENE -o OUT");
  if (out->list_cameras) return STATUS_OK;
  if (!out->output_path) return log_fail(log, STATUS_USAGE, "%s: no output: add -o picture.png", out->scene_path);
  if (!out->format) out->format = image_format_of(out->output_path);
  if (!out->format)
    return log_fail(log, STATUS_USAGE,
                    "%s: unknown kind of picture: end it in .png, .jpg, .exr or .hdr, or add --format",
                    out->output_path);
  TRY(render_options_check(out, log));
  if (out->fps == 0) out->fps = 24;
  out->picture.opaque = out->background.kind != BACKGROUND_TRANSPARENT;
  out->picture.has_background = out->background.kind == BACKGROUND_COLOR;
  memcpy(out->picture.background, out->background.color, sizeof out->picture.background);
  if (!out->picture.bit_depth) out->picture.bit_depth = 8;
  if (!out->picture.quality) out->picture.quality = 95;

done:
  return status;
}
