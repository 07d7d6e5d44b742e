#include "app/record.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/app.h"
#include "app/near_record.h"
#include "report/profile.h"

static const char *base_name(const char *path)
{
  const char *slash = strrchr(path, '/');
  return slash ? slash + 1 : path;
}

static const char *const tone_names[] = {"none", "filmic", "pbr-neutral"};
static const char *const light_kind_names[SHADOW_LIGHT_KINDS] = {"point", "spot", "directional"};
static const char *const environment_light_names[] = {"auto", "none", "ambient", "sh", "sh-ao", "sampled"};

// A word as a shell reads it.
static void word_record(FILE *out, const char *option, const char *word)
{
  fprintf(out, " %s%s", option, *option ? " " : "");
  bool is_plain =
      *word && strspn(word, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./+-@%,:=") == strlen(word);
  if (is_plain) {
    fputs(word, out);
    return;
  }
  fputc('\'', out);
  for (; *word; word++) fputs(*word == '\'' ? "'\\''" : (char[]){*word, 0}, out);
  fputc('\'', out);
}

static void environment_record(FILE *out, const RenderOptions *options)
{
  const EnvironmentSource *source = &options->environment;
  if (source->choice == ENVIRONMENT_FILE)
    word_record(out, "--environment", base_name(source->text));
  else if (source->choice != ENVIRONMENT_UNSET)
    word_record(out, "--environment", source->text);
  if (options->environment_rotation_rad != 0)
    fprintf(out, " --environment-rotation %g", options->environment_rotation_rad * 180 / M_PI);
  if (options->environment_intensity != 1)
    fprintf(out, " --environment-intensity %g", (double)options->environment_intensity);
  if (!options->key_light) fputs(" --no-key-light", out);
}

// What methods of the shadows read of their options.
static void shadows_record(FILE *stream, const Plan *plan)
{
  const ShadowOptions *options = &plan->shadow_options;
  if (plan_uses_shadow_maps(plan)) {
    if (options->map_size_px)
      fprintf(stream, " --shadow-map-size %u", options->map_size_px);
    else
      fputs(" --shadow-map-size auto", stream);
  }
  if (plan_uses_shadows(plan, SHADOW_SET(SHADOWS_PCF))) fprintf(stream, " --shadow-kernel %u", options->kernel_px);
  if (plan_uses_shadows(plan, SHADOW_SET(SHADOWS_PCSS) | SHADOW_SET(SHADOWS_AREA)))
    fprintf(stream, " --light-radius %g --light-angle %g", (double)options->light_radius_m,
            options->light_angle_rad * 180 / M_PI);
}

// What is not as it would be without it.
static void reflections_record(FILE *stream, const RenderSettings *settings)
{
  const CubeOptions *cubes = &settings->cubes;
  if (settings->deep_reflections != REFLECTIONS_LIKE_FIRST && settings->deep_reflections != settings->reflections)
    fprintf(stream, " --deep-reflections %s", reflections_name(settings->deep_reflections));
  if (cubes->size_px) fprintf(stream, " --cube-size %u", cubes->size_px);
  if (cubes->near_radius_m > 0) fprintf(stream, " --near-radius %g", (double)cubes->near_radius_m);
  if (cubes->complex_from) fprintf(stream, " --snapshot-from %u", cubes->complex_from);
}

Status record_make(char **out, const RenderOptions *options, const Plan *plan, const Camera *camera, float exposure_ev,
                   const DeviceInfo *device, Log *log)
{
  char *text = NULL;
  size_t size = 0;
  FILE *stream = open_memstream(&text, &size);
  if (!stream) return log_no_memory(log, options->output_path);
  const RenderSettings *settings = &options->settings;
  const Crop *crop = &options->crop;
  fputs("frugal render", stream);
  word_record(stream, "", base_name(options->scene_path));
  fprintf(stream, " --size %ux%u", settings->width, settings->height);
  if (crop->width) fprintf(stream, " --crop %u,%u,%u,%u", crop->x, crop->y, crop->width, crop->height);
  fprintf(stream, " --samples %u --camera %s", settings->samples,
          options->camera ? options->camera
          : camera->name  ? "0"
                          : "fit");
  if (options->frames.given) fprintf(stream, " --frames %u --fps %.9g", options->frames.first, (double)options->fps);
  if (options->animation) word_record(stream, "--animation", options->animation);
  environment_record(stream, options);
  word_record(stream, "--background", options->background.text ? options->background.text : "environment");
  fprintf(stream, " --exposure %.7g --tone-map %s", (double)exposure_ev, tone_names[options->picture.tone]);
  if (settings->lighting == LIGHTING_PHONG)
    fprintf(stream, " --lighting phong --ambient %g", (double)settings->ambient);
  else
    fputs(" --lighting pbr", stream);
  fprintf(stream, " --primary %s --shadows %s --reflections %s --environment-light %s --max-depth %u",
          primary_name(settings->primary), shadow_words[settings->shadows], reflections_name(settings->reflections),
          environment_light_names[plan->environment_light], settings->max_depth);
  if (options->light_shadows) word_record(stream, "--light-shadows", options->light_shadows);
  reflections_record(stream, settings);
  shadows_record(stream, plan);
  fprintf(stream, " --max-roughness %g --seed %u", (double)plan->max_roughness, options->seed);
  fprintf(stream, "; on %s, %s, driver %s", device->name, device->platform, device->driver);
  if (fclose(stream) != 0) {
    free(text);
    return log_no_memory(log, options->output_path);
  }
  for (char *c = text; *c; c++)
    if ((unsigned char)*c < ' ') *c = '?';  // a file's name may hold anything, a header's line may not
  *out = text;
  return STATUS_OK;
}

// What a light's shadows were expected to cost in milliseconds, by kind of light, and by which method they are found.
// Where lights have methods of their own, those are in lights_json alone.
static json_t *shadow_costs_json(const Plan *plan, const DeviceScene *scene)
{
  json_t *out = json_object();
  for (uint32_t i = 0; i < scene->light_count; i++) {
    uint32_t kind = scene->light_infos[i].kind;
    const ShadowCost *cost = &plan->shadow_costs[kind];
    json_t *costs =
        json_pack("{s:f, s:f, s:f}", "rays", cost->rays_ms, "hybrid", cost->hybrid_ms, "hybrid_kept", cost->kept_ms);
    if (plan->sequence.frames > 0)
      json_object_update_new(
          costs, json_pack("{s:f, s:f}", "hybrid_sequence", cost->sequence_ms, "kept", plan->sequence.kept[kind]));
    if (!plan->light_shadows)
      json_object_set_new(costs, "method", json_string(shadow_words[plan_light_shadows(plan, i, kind)]));
    json_object_set_new(out, light_kind_names[kind], costs);
  }
  return out;
}

// What each light is called, and by which method its shadows were found.
static json_t *lights_json(const Plan *plan, const DeviceScene *scene)
{
  json_t *out = json_array();
  for (uint32_t i = 0; i < scene->light_count; i++) {
    const char *name = scene->source->lights[i].name,
               *method = shadow_words[plan_light_shadows(plan, i, scene->light_infos[i].kind)];
    json_array_append_new(out, json_pack("{s:o, s:s}", "name", app_json_text(name ? name : ""), "shadows", method));
  }
  return out;
}

// Each light's maps, and how many of them were kept from the frame before; for hybrid shadows how many rays they left
// to be traced, for others what they may get wrong. A light without maps has 0 views.
static json_t *shadow_maps_json(const Frame *frame, const ShadowBound *bound)
{
  const ShadowHybrid *hybrid = &frame->shadow_hybrid;
  const ShadowMaps *maps = &frame->shadow_maps;
  json_t *lights = json_array();
  for (uint32_t i = 0; i < frame->scene->light_count; i++) {
    const bool is_hybrid = frame_light_shadows(frame, i) == SHADOWS_HYBRID, has_maps = shadow_maps_have(maps, i);
    const ShadowInfo none = {0}, *info = is_hybrid ? &hybrid->maps.lights[i] : has_maps ? &maps->lights[i] : &none;
    const uint32_t kept = is_hybrid ? sure_maps_kept(&hybrid->maps, i) : has_maps ? maps->kept[i] : 0;
    json_t *light =
        json_pack("{s:i, s:i, s:i}", "size", (int)info->size_px, "views", (int)info->view_count, "kept", (int)kept);
    if (bound) json_object_set_new(light, "expected", json_real(bound->lights[i]));
    json_array_append_new(lights, light);
  }
  json_t *out = json_pack("{s:o}", "lights", lights);
  if (out && plan_uses_shadows(&frame->request.plan, SHADOW_SET(SHADOWS_HYBRID))) {
    json_object_set_new(out, "rays", json_integer((json_int_t)hybrid->rays));
    json_object_set_new(out, "traced", json_integer((json_int_t)hybrid->traced));
  }
  if (out && bound)
    json_object_set_new(out, "predicted",
                        json_pack("{s:f, s:f, s:I}", "expected", bound->expected, "bound", bound->bound, "probes",
                                  (json_int_t)bound->probes));
  return out;
}

// What each rung may get wrong, by name.
static json_t *bound_rungs_json(const BoundShare rungs[BOUND_RUNGS])
{
  json_t *out = json_object();
  for (int i = 0; i < BOUND_RUNGS; i++)
    json_object_set_new(out, reflections_name((ReflectionMethod)(REFLECTIONS_ENVIRONMENT + i)),
                        json_pack("{s:f, s:f}", "expected", rungs[i].expected, "bound", rungs[i].bound));
  return out;
}

static json_t *reflection_bound_json(const ReflectionBound *bound)
{
  json_t *reflectors = json_array();
  for (uint32_t i = 0; i < bound->count; i++) {
    json_t *reflector = bound_rungs_json(bound->reflectors[i].rungs);
    json_object_set_new(reflector, "object", json_integer(bound->reflectors[i].object));
    json_object_set_new(reflector, "share", json_real(bound->reflectors[i].share));
    json_array_append_new(reflectors, reflector);
  }
  json_t *out = bound_rungs_json(bound->rungs);
  json_object_set_new(out, "probes", json_integer((json_int_t)bound->probes));
  json_object_set_new(out, "reflectors", reflectors);
  return out;
}

// Cube maps, how many reflected rays maps were asked for and left to be traced, and what was said beforehand.
static json_t *reflection_maps_json(const Frame *frame, const ReflectionBound *bound)
{
  const ReflectorSummary *reflectors = &frame->reflectors;
  const CubeReflect *maps = &frame->cube_reflect;
  const NearReflect *near = &frame->near_reflect;
  json_t *out =
      json_pack("{s:i, s:i, s:i, s:i, s:i, s:i, s:i, s:i, s:i, s:i, s:i, s:i, s:i, s:[i,i], s:I, s:I, s:I, s:I}",
                "cubes", (int)maps->cube_count, "faces", CUBE_FACES * (int)maps->cube_count, "faces_kept",
                (int)reflectors->faces_kept, "reflectors", (int)reflectors->visible, "within", (int)reflectors->within,
                "within_alone", (int)reflectors->within_alone, "unseen", (int)reflectors->unseen, "deep_cubes",
                (int)reflectors->deep_cubes, "rough", (int)reflectors->rough, "levels", (int)reflectors->levels,
                "left_out", (int)reflectors->left_out, "flat", (int)reflectors->flat, "without_gain",
                (int)reflectors->without_gain, "size", (int)reflectors->least_px, (int)reflectors->greatest_px, "bytes",
                (json_int_t)reflectors->bytes, "rays", (json_int_t)(maps->looked_up + near->looked_up), "traced",
                (json_int_t)(maps->left + near->totals[NEAR_LEFT]), "shaded", (json_int_t)frame->hybrid_reflect.shaded);
  if (out && near->cube_count) json_object_set_new(out, "near", near_objects_json(frame));
  if (out && bound) json_object_set_new(out, "predicted", reflection_bound_json(bound));
  if (out && reflectors->hybrid_ms > 0)
    json_object_set_new(out, "predicted_ms",
                        json_pack("{s:f, s:f}", "rays", reflectors->rays_ms, "hybrid", reflectors->hybrid_ms));
  return out;
}

// Flat mirrors, how many reflected rays were asked for in them, and how many of all were left to be traced.
static json_t *flat_mirrors_json(const Frame *frame, const ReflectionBound *bound)
{
  const Planar *planar = &frame->planar;
  json_t *out = json_pack("{s:i, s:i, s:i, s:i, s:I, s:I, s:I, s:s}", "reflectors", (int)frame->reflectors.visible,
                          "flat", (int)frame->reflectors.flat, "planes", (int)planar->count, "left_out",
                          (int)planar->left_out, "bytes", (json_int_t)planar->bytes, "rays",
                          (json_int_t)planar->looked_up, "traced", (json_int_t)planar->left, "others", "rays");
  if (out && bound) json_object_set_new(out, "predicted", reflection_bound_json(bound));
  return out;
}

json_t *record_stats(const RecordSources *sources)
{
  const RenderOptions *options = sources->options;
  const DeviceScene *scene = sources->scene;
  const Plan *plan = sources->plan;
  const DeviceInfo *device = device_info(sources->device);
  PictureArea area = render_area(options);
  const ShadowMethod chosen = plan->hybrid_kinds ? SHADOWS_HYBRID : SHADOWS_RAYS;
  const ShadowMethod shadows = plan->shadows == SHADOWS_AUTO ? chosen : plan->shadows;
  json_t *stats =
      json_pack("{s:s, s:o, s:o, s:o}", "version", FRUGAL_VERSION, "scene", app_json_text(options->scene_path),
                "output", app_json_text(options->output_path), "settings", app_json_text(sources->record));
  json_t *parts[] = {
      json_pack("{s:s, s:s, s:s, s:i}", "name", device->name, "platform", device->platform, "driver", device->driver,
                "lanes", (int)device_traits(sources->device)->lanes),
      json_pack("[i,i]", (int)area.width, (int)area.height),
      json_integer(options->settings.samples),
      json_real((double)sources->exposure_ev),
      json_pack("{s:I, s:I, s:I, s:I}", "triangles", (json_int_t)scene->triangle_count, "objects",
                (json_int_t)scene->object_count, "materials", (json_int_t)scene->material_count, "lights",
                (json_int_t)scene->light_count),
      json_pack("{s:s, s:s, s:{s:f, s:f}, s:s, s:s, s:s, s:i, s:f, s:s}", "lighting",
                plan->lighting == LIGHTING_PHONG ? "phong" : "pbr", "primary", primary_name(plan->primary),
                "primary_ms", "raster", plan->primary_cost.raster_ms, "rays", plan->primary_cost.rays_ms, "shadows",
                shadow_words[shadows], "reflections", reflections_name(plan->reflections), "deep_reflections",
                reflections_name(plan->deep_reflections), "max_depth", (int)plan->max_depth, "max_roughness",
                (double)plan->max_roughness, "environment_light", environment_light_names[plan->environment_light]),
      profile_json(sources->timeline),
      json_real(sources->total_ms),
  };
  static const char *const keys[] = {"device", "size", "samples", "exposure", "counts", "plan", "passes", "total_ms"};
  bool failed = !stats;
  for (size_t i = 0; i < sizeof parts / sizeof *parts; i++)
    failed |= json_object_set_new(stats, keys[i], parts[i]) != 0;
  if (options->frames.given) {
    const uint32_t frame = options->frames.first;
    failed |= json_object_set_new(stats, "frame", json_integer(frame)) != 0;
    failed |= json_object_set_new(stats, "time_s", json_real(frame / (double)options->fps)) != 0;
  }
  if (sources->raster)
    failed |= json_object_set_new(stats, "raster",
                                  json_pack("{s:I, s:I}", "block_tests", (json_int_t)sources->raster->block_tests,
                                            "samples_covered", (json_int_t)sources->raster->samples_covered)) != 0;
  if (scene->light_count) failed |= json_object_set_new(stats, "lights", lights_json(plan, scene)) != 0;
  if (plan_uses_shadows(plan, SHADOW_SET(SHADOWS_HYBRID) | SHADOW_SET(SHADOWS_RAYS)))
    failed |= json_object_set_new(json_object_get(stats, "plan"), "shadow_ms", shadow_costs_json(plan, scene)) != 0;
  if (plan->sequence.frames > 0)
    failed |= json_object_set_new(json_object_get(stats, "plan"), "sequence", json_integer(plan->sequence.frames)) != 0;
  if (plan_uses_shadow_maps(plan))
    failed |= json_object_set_new(stats, "shadow_maps", shadow_maps_json(sources->frame, sources->shadow_bound)) != 0;
  if (plan->reflections == REFLECTIONS_PLANAR)
    failed |=
        json_object_set_new(stats, "flat_mirrors", flat_mirrors_json(sources->frame, sources->reflection_bound)) != 0;
  if (reflections_use_maps(plan->reflections) || reflections_use_maps(plan->deep_reflections))
    failed |= json_object_set_new(stats, "reflection_maps",
                                  reflection_maps_json(sources->frame, sources->reflection_bound)) != 0;
  if (sources->verify) failed |= json_object_set_new(stats, "verify", verify_json(sources->verify)) != 0;
  if (!failed) return stats;
  json_decref(stats);
  return NULL;
}
