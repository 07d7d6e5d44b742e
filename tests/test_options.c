// The command line of `frugal render` means what its help says.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "app/options.h"
#include "shared/resolve.h"

enum { MAX_ARGUMENTS = 16 };

static Log test_log;

// Parses `frugal render scene.glb -o out.exr WORDS`, the words separated by blanks.
static Status parse(RenderOptions *out, const char *words)
{
  static char text[512];
  char *arguments[MAX_ARGUMENTS + 1] = {"render", "scene.glb", "-o", "out.exr"};
  int count = 4;
  snprintf(text, sizeof text, "%s", words);
  for (char *rest = NULL, *word = strtok_r(text, " ", &rest); word; word = strtok_r(NULL, " ", &rest)) {
    assert_true(count < MAX_ARGUMENTS);
    arguments[count++] = word;
  }
  test_log = (Log){0};
  return render_options_parse(out, count, arguments, &test_log);
}

static RenderOptions parsed(const char *words)
{
  RenderOptions options;
  Status status = parse(&options, words);
  if (status) fail_msg("%s: %s", words, test_log.error);
  return options;
}

static void refused(const char *words, const char *message)
{
  RenderOptions options;
  Status status = parse(&options, words);
  if (status != STATUS_USAGE || !strstr(test_log.error, message))
    fail_msg("'%s' gives %d, %s; expected: %s", words, (int)status, test_log.error, message);
}

static void shadow_options_are_checked(void **state)
{
  RenderOptions o =
      parsed("--shadows pcss --shadow-map-size 1024 --shadow-kernel 5 --light-radius 0.25 --light-angle 0.5");
  const ShadowOptions *shadows = &o.settings.shadow_options;
  assert_int_equal(o.settings.shadows, SHADOWS_PCSS);
  assert_int_equal(shadows->map_size_px, 1024);
  assert_int_equal(shadows->kernel_px, 5);
  assert_true(shadows->light_radius_m == 0.25f && fabs(shadows->light_angle_rad - M_PI / 360) < 1e-12);
  assert_int_equal(parsed("--shadow-map-size auto").settings.shadow_options.map_size_px, 0);
  refused("--shadow-map-size 1000000", "--shadow-map-size 1000000: not valid: expected a whole number from 16 to 8192");
  refused("--shadow-map-size 0", "--shadow-map-size 0: not valid");
  refused("--shadow-map-size 1026", "--shadow-map-size 1026: not valid: expected a multiple of 4");
  refused("--shadow-kernel 4", "--shadow-kernel 4: not valid: expected an odd number");
  refused("--light-radius nan", "--light-radius nan: not valid");
  refused("--light-radius -1", "--light-radius -1: not valid");
  refused("--light-angle 60", "--light-angle 60: not valid");
  refused("--shadows soft", "--shadows soft: no such value");
}

static void what_is_verified_is_a_number_or_all(void **state)
{
  assert_int_equal(parsed("--verify 4096").verify.pixels, 4096);
  assert_true(parsed("--verify all").verify.all && !parsed("--verify 1").verify.all);
  refused("--verify 0", "--verify 0: not valid: expected a whole number from 1 to 4294967295");
  refused("--verify -1", "--verify -1: not valid");
  refused("--verify 1e3", "--verify 1e3: not valid");
  refused("--verify some", "--verify some: not valid");
}

static void defaults_are_those_of_the_help(void **state)
{
  RenderOptions o = parsed("");
  assert_string_equal(o.scene_path, "scene.glb");
  assert_string_equal(o.output_path, "out.exr");
  assert_string_equal(o.format, "exr");
  assert_int_equal(o.settings.width, 1280);
  assert_int_equal(o.settings.height, 720);
  assert_int_equal(o.settings.samples, 1);
  assert_int_equal(o.settings.lighting, LIGHTING_PBR);
  assert_int_equal(o.settings.shadows, SHADOWS_RAYS);
  assert_int_equal(o.settings.reflections, REFLECTIONS_RAYS);
  assert_int_equal(o.settings.methods, METHODS_AUTO);
  assert_int_equal(o.settings.environment_light, ENVIRONMENT_LIGHT_AUTO);
  assert_true(o.settings.max_roughness == MAX_ROUGHNESS_AUTO);
  assert_int_equal(o.settings.max_depth, 8);
  assert_true(o.settings.ambient == 0.05f);
  assert_true(o.exposure.ev == 0 && !o.exposure.is_auto);
  assert_int_equal(o.picture.tone, TONE_CURVE_NONE);
  assert_int_equal(o.picture.aovs, 0);
  assert_int_equal(o.picture.bit_depth, 8);
  assert_int_equal(o.picture.quality, 95);
  assert_null(o.picture.compression);
  assert_true(o.picture.opaque && !o.picture.has_background);
  assert_null(o.camera);
  assert_int_equal(o.environment.choice, ENVIRONMENT_UNSET);
  assert_true(o.environment_intensity == 1 && o.environment_rotation_rad == 0 && o.key_light);
  assert_null(o.device);
  assert_int_equal(o.threads, 0);
  assert_int_equal(o.seed, 0);
  assert_true(o.max_image_pixels == 268435456);
  assert_true(o.overwrite && !o.list_cameras && !o.allow_outside);
  assert_false(o.verify.all || o.verify.pixels || o.profile || o.progress || o.quiet || o.verbose || o.help ||
               o.stats_path || o.trace_path);
}

static void each_option_sets_its_own_field(void **state)
{
  RenderOptions o = parsed("-s 64x48 -n 4 --format png --exposure -1.5 --tone-map pbr-neutral");
  assert_int_equal(o.settings.width, 64);
  assert_int_equal(o.settings.height, 48);
  assert_int_equal(o.settings.samples, 4);
  assert_string_equal(o.format, "png");
  assert_true(o.exposure.ev == -1.5f);
  assert_int_equal(o.picture.tone, TONE_CURVE_PBR_NEUTRAL);
  assert_true(parsed("--exposure auto").exposure.is_auto);
  assert_int_equal(parsed("--tone-map filmic").picture.tone, TONE_CURVE_FILMIC);

  o = parsed("--lighting phong --ambient 0.25 --primary rays --shadows none --reflections none --max-depth 3");
  assert_int_equal(o.settings.lighting, LIGHTING_PHONG);
  assert_true(o.settings.ambient == 0.25f);
  assert_int_equal(o.settings.shadows, SHADOWS_NONE);
  assert_int_equal(o.settings.reflections, REFLECTIONS_NONE);
  assert_int_equal(o.settings.max_depth, 3);

  o = parsed("--methods exact --environment-light sh-ao --max-roughness 0.25");
  assert_int_equal(o.settings.methods, METHODS_EXACT);
  assert_int_equal(o.settings.environment_light, ENVIRONMENT_LIGHT_SH_AO);
  assert_true(o.settings.max_roughness == 0.25f);

  o = parsed("--camera fit --device cpu --threads 2 --seed 7 --max-memory 2M --max-image-pixels 9");
  assert_string_equal(o.camera, "fit");
  assert_string_equal(o.device, "cpu");
  assert_int_equal(o.threads, 2);
  assert_int_equal(o.seed, 7);
  assert_true(o.max_memory_bytes == 2 << 20);
  assert_true(o.max_image_pixels == 9);

  o = parsed("--list-cameras --allow-outside --profile --progress --stats s.json --trace t.json -q -v --no-key-light");
  assert_true(o.list_cameras && o.allow_outside && o.profile && o.progress && o.quiet && o.verbose && !o.key_light);
  assert_string_equal(o.stats_path, "s.json");
  assert_string_equal(o.trace_path, "t.json");

  assert_int_equal(parsed("-o a.png --bit-depth 16").picture.bit_depth, 16);
  assert_int_equal(parsed("-o a.jpg --quality 5").picture.quality, 5);
  assert_string_equal(parsed("-o a.png --compression 9").picture.compression, "9");
  assert_string_equal(parsed("--compression piz").picture.compression, "piz");
  assert_string_equal(parsed("-o a.JPEG").format, "jpg");
}

static void the_environment_is_a_file_a_colour_or_a_word(void **state)
{
  RenderOptions o = parsed("--environment studio.hdr --environment-rotation 90 --environment-intensity 2");
  assert_int_equal(o.environment.choice, ENVIRONMENT_FILE);
  assert_string_equal(o.environment.text, "studio.hdr");
  assert_true(fabs(o.environment_rotation_rad - M_PI / 2) < 1e-12 && o.environment_intensity == 2);
  assert_int_equal(parsed("--environment sky").environment.choice, ENVIRONMENT_SKY);
  assert_int_equal(parsed("--environment none").environment.choice, ENVIRONMENT_NONE);
  o = parsed("--environment #ff8000");
  assert_int_equal(o.environment.choice, ENVIRONMENT_COLOR);
  // IEC 61966-2-1: 128/255 is 0.215861 in linear light.
  assert_true(o.environment.color[0] == 1 && o.environment.color[2] == 0);
  assert_true(fabs((double)o.environment.color[1] - 0.215861) < 1e-6);
}

static void the_background_is_a_colour_or_a_word(void **state)
{
  RenderOptions o = parsed("--background transparent");
  assert_true(o.background.kind == BACKGROUND_TRANSPARENT && !o.picture.opaque && !o.picture.has_background);
  o = parsed("--background environment");
  assert_true(o.background.kind == BACKGROUND_ENVIRONMENT && o.picture.opaque && !o.picture.has_background);
  o = parsed("--background #0a0B0c");  // below the toe of the curve: 10 / 255 / 12.92
  assert_true(o.background.kind == BACKGROUND_COLOR && o.picture.opaque && o.picture.has_background);
  assert_true(fabs((double)o.picture.background[0] - 10 / 255.0 / 12.92) < 1e-8);
  refused("--background #12345", "--background #12345: not valid: expected a colour such as #8090a0");
  refused("--background #12345g", "expected a colour");
  refused("--background transparant", "did you mean 'transparent'?");
}

static void aov_names_are_joined_by_commas(void **state)
{
  assert_int_equal(parsed("--aov depth,normal").picture.aovs, AOV_NAME_DEPTH | AOV_NAME_NORMAL);
  RenderOptions o = parsed("--aov depth,position,normal,albedo,object,primitive,material,shadow,reflection");
  assert_int_equal(o.picture.aovs, 511);
  refused("--aov depth,normals", "--aov normals: no such value: did you mean 'normal'?");
  refused("-o a.png --aov depth", "a.png: --aov needs a format with layers: use .exr");
}

static void the_last_of_an_option_counts(void **state)
{
  assert_int_equal(parsed("-n 2 -n 3").settings.samples, 3);
  assert_false(parsed("--overwrite --no-clobber").overwrite);
  assert_true(parsed("--no-clobber --overwrite").overwrite);
  assert_int_equal(parsed("--aov depth --aov normal").picture.aovs, AOV_NAME_NORMAL);
}

static void a_crop_lies_within_the_picture(void **state)
{
  RenderOptions o = parsed("-s 100x50 --crop 10,20,90,30");
  PictureArea area = render_area(&o);
  assert_int_equal(area.whole_width, 100);
  assert_int_equal(area.whole_height, 50);
  assert_int_equal(area.crop_x, 10);
  assert_int_equal(area.crop_y, 20);
  assert_int_equal(area.width, 90);
  assert_int_equal(area.height, 30);
  o = parsed("-s 100x50");
  area = render_area(&o);
  assert_int_equal(area.width, 100);
  assert_int_equal(area.height, 50);
  refused("-s 100x50 --crop 11,20,90,30", "--crop 11,20,90,30: leaves the picture of 100x50");
  refused("-s 100x50 --crop 0,21,90,30", "leaves the picture");
  refused("--crop 0,0,0,5", "--crop 0,0,0,5: not valid: expected X,Y,WIDTH,HEIGHT");
  refused("--crop 1,2,3", "--crop 1,2,3: not valid");
  refused("--crop -1,2,3,4", "--crop -1,2,3,4: not valid");
}

static void values_out_of_range_are_refused(void **state)
{
  static const char *const sizes[] = {"0x0",  "0x5",   "1000000x1000000",       "65537x1", "64", "64x", "64x64x", "x64",
                                      "-1x5", "64X48", "18446744073709551617x1"};
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
    char words[64], message[96];
    snprintf(words, sizeof words, "-s %s", sizes[i]);
    snprintf(message, sizeof message, "--size %s: not valid: expected WIDTHxHEIGHT", sizes[i]);
    refused(words, message);
  }
  refused("-n 0", "--samples 0: not valid: expected a whole number from 1 to 1048576");
  refused("-n 1.5", "--samples 1.5: not valid");
  refused("-n -1", "--samples -1: not valid");
  refused("--exposure nan", "--exposure nan: not valid: expected a number from -64 to 64");
  refused("--exposure 65", "--exposure 65: not valid");
  refused("--exposure 1x", "--exposure 1x: not valid");
  refused("--environment-intensity inf", "--environment-intensity inf: not valid");
  refused("--ambient -1", "--ambient -1: not valid");
  refused("--max-memory 5X", "--max-memory 5X: not valid: expected a size such as 512M or 4G");
  refused("--max-memory -5", "--max-memory -5: not valid");
  refused("--max-memory 5MM", "--max-memory 5MM: not valid");
  refused("--threads 0", "--threads 0: not valid");
  refused("--seed 4294967296", "--seed 4294967296: not valid: expected a whole number from 0 to 4294967295");
  refused("--max-roughness 1.5", "--max-roughness 1.5: not valid: expected a number from 0 to 1");
  refused("--environment-light sample", "--environment-light sample: no such value: did you mean 'sampled'?");
  refused("-o a.png --bit-depth 12", "--bit-depth 12: not valid: expected 8 or 16");
  refused("-o a.jpg --quality 101", "--quality 101: not valid");
  refused("-o a.png --compression zip", "--compression zip: not one of .png: expected 0 to 9");
  refused("--compression 5", "--compression 5: not one of .exr: expected none");
  assert_true(parsed("--max-memory 1.5k").max_memory_bytes == 1536);
  assert_int_equal(parsed("-s 65536x1").settings.width, 65536);
  assert_int_equal(parsed("--seed 4294967295").seed, UINT32_MAX);
}

static void what_a_format_has_no_use_for_is_refused(void **state)
{
  refused("--bit-depth 8", "out.exr: --bit-depth is for .png alone");
  refused("-o a.png --quality 50", "a.png: --quality is for .jpg alone");
  refused("-o a.jpg --compression 5", "a.jpg: --compression is for .png and .exr");
  refused("-o a.jpg --background transparent", "a.jpg: --background transparent needs a format with alpha");
  refused("-o a.hdr --background transparent", "use .png or .exr");
  refused("-o a.gif", "a.gif: unknown kind of picture: end it in .png, .jpg, .exr or .hdr, or add --format");
  refused("-o -", "-: unknown kind of picture");
  assert_string_equal(parsed("-o - --format hdr").format, "hdr");
}

static void mistyped_words_meet_the_nearest_known_one(void **state)
{
  refused("--exposur2 1", "--exposur2: no such option: did you mean --exposure?");
  refused("--no-such=5", "--no-such=5: no such option: did you mean --");
  refused("--lighting prb", "--lighting prb: no such value: did you mean 'pbr'?");
  refused("--shadows ray", "--shadows ray: no such value: did you mean 'rays'?");
  refused("--format jpeg", "did you mean 'jpg'?");
  refused("-x", "-x: no such option: see frugal render --help");
  refused("-qx", "-x: no such option");
  refused("-n", "-n: needs a value: see frugal render --help");
  refused("--samples", "--samples: needs a value");
  refused("--quiet=1", "--quiet: takes no value: leave it out");
  refused("second.glb", "second.glb: one too many");
  refused("--max", "--max: may be --max-depth, --max-roughness, --max-memory, --max-image-pixels: name one");
}

static void one_file_takes_one_output(void **state)
{
  refused("--stats out.exr", "out.exr: named for two outputs: give each its own");
  refused("--stats a.json --trace a.json", "a.json: named for two outputs");
  refused("-o - --format png --stats -", "-: named for two outputs");
}

static void help_and_cameras_need_no_output(void **state)
{
  char *help[] = {"render", "--help", "--no-such-option"}, *cameras[] = {"render", "a.glb", "--list-cameras"};
  char *nothing[] = {"render"}, *no_output[] = {"render", "a.glb"};
  RenderOptions o;
  Log log = {0};
  assert_int_equal(render_options_parse(&o, 3, help, &log), STATUS_OK);
  assert_true(o.help);
  assert_int_equal(render_options_parse(&o, 3, cameras, &log), STATUS_OK);
  assert_int_equal(render_options_parse(&o, 1, nothing, &log), STATUS_USAGE);
  assert_string_equal(log.error, "render: no scene: frugal render SCENE -o OUT");
  log = (Log){0};
  assert_int_equal(render_options_parse(&o, 2, no_output, &log), STATUS_USAGE);
  assert_string_equal(log.error, "a.glb: no output: add -o picture.png");
}

static void reflection_options_are_checked(void **state)
{
  static const char *const words[] = {"none",   "environment", "cube",  "box",    "impostor", "snapshot",
                                      "planar", "candidates",  "mixed", "hybrid", "rays"};
  char text[128];
  const int count = sizeof words / sizeof *words;
  for (int i = 0; i < count; i++) {
    snprintf(text, sizeof text, "--reflections %s --deep-reflections %s --cube-size 256", words[i],
             words[count - 1 - i]);
    RenderOptions o = parsed(text);
    assert_string_equal(reflections_name(o.settings.reflections), words[i]);
    assert_string_equal(reflections_name(o.settings.deep_reflections), words[count - 1 - i]);
    assert_int_equal(o.settings.cubes.size_px, 256);
  }
  assert_true(parsed("--near-radius 2.5").settings.cubes.near_radius_m == 2.5f);
  assert_true(parsed("--near-radius auto").settings.cubes.near_radius_m == 0);
  assert_int_equal(parsed("--snapshot-from 300").settings.cubes.complex_from, 300);
  refused("--near-radius 0", "--near-radius 0: not valid: expected metres above 0, or auto");
  refused("--near-radius -1", "--near-radius -1");
  refused("--near-radius nan", "--near-radius nan");
  refused("--snapshot-from 0", "--snapshot-from 0: not valid");
  assert_int_equal(parsed("--cube-size auto").settings.cubes.size_px, 0);
  assert_int_equal(parsed("-n 1").settings.deep_reflections, REFLECTIONS_LIKE_FIRST);
  refused("--reflections sphere", "--reflections sphere: no such value");
  refused("--deep-reflections like-first", "--deep-reflections like-first: no such value");
  refused("--cube-size 12", "--cube-size 12: not valid: expected a multiple of 8");
  refused("--cube-size 4096", "--cube-size 4096: not valid: expected a whole number from 8 to 2048");
}

// Every option is in the help, each line fits a terminal, and words that an option takes are named there.
static void the_help_tells_all(void **state)
{
  char *text = NULL;
  size_t size = 0;
  FILE *stream = open_memstream(&text, &size);
  command_line_help(&render_command_line, stream);
  fclose(stream);
  for (size_t i = 0; i < render_command_line.option_count; i++) {
    const Option *option = &render_command_line.options[i];
    char name[64];
    if (!option->name) continue;
    snprintf(name, sizeof name, "--%s", option->name);
    if (!strstr(text, name)) fail_msg("%s is not in the help", name);
    for (const char *const *word = option->words; word && *word; word++)
      if (!strstr(option->help, *word)) fail_msg("%s: the help does not name %s", name, *word);
  }
  assert_int_equal(strncmp(text, "Examples:\n", 10), 0);
  for (const char *line = text; *line; line += strcspn(line, "\n") + 1)
    if (strcspn(line, "\n") > 110) fail_msg("%zu columns: %.60s...", strcspn(line, "\n"), line);
  free(text);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(shadow_options_are_checked),
      cmocka_unit_test(reflection_options_are_checked),
      cmocka_unit_test(what_is_verified_is_a_number_or_all),
      cmocka_unit_test(defaults_are_those_of_the_help),
      cmocka_unit_test(each_option_sets_its_own_field),
      cmocka_unit_test(the_environment_is_a_file_a_colour_or_a_word),
      cmocka_unit_test(the_background_is_a_colour_or_a_word),
      cmocka_unit_test(aov_names_are_joined_by_commas),
      cmocka_unit_test(the_last_of_an_option_counts),
      cmocka_unit_test(a_crop_lies_within_the_picture),
      cmocka_unit_test(values_out_of_range_are_refused),
      cmocka_unit_test(what_a_format_has_no_use_for_is_refused),
      cmocka_unit_test(mistyped_words_meet_the_nearest_known_one),
      cmocka_unit_test(one_file_takes_one_output),
      cmocka_unit_test(help_and_cameras_need_no_output),
      cmocka_unit_test(the_help_tells_all),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
