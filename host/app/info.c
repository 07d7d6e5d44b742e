// frugal info: what a scene holds, and what of it will not be rendered.

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/app.h"
#include "app/options.h"
#include "report/profile.h"
#include "scene/gltf.h"
#include "scene/gltf_contents.h"

typedef struct InfoOptions {
  const char *scene_path;
  bool json, allow_outside, help;
  uint64_t max_memory_bytes, max_image_pixels;
} InfoOptions;

static const Option info_options[] = {
    OPTION_HEADING("Options:"),
    {"json", 0, NULL, option_read_true, offsetof(InfoOptions, json), .help = "all of it as JSON"},
    {"max-memory", 0, "BYTES", option_read_bytes, offsetof(InfoOptions, max_memory_bytes),
     .help = "most that the scene file may need, with k, M or G (no limit)"},
    {"max-image-pixels", 0, "N", option_read_u64, offsetof(InfoOptions, max_image_pixels), .low = 1, .high = 1e12,
     .help = "largest image file read (268435456)"},
    {"allow-outside", 0, NULL, option_read_true, offsetof(InfoOptions, allow_outside),
     .help = "let a .gltf name files outside its folder"},
};

static const CommandLine info_command_line = {
    .name = "info",
    .usage =
        "Examples:\n"
        "  frugal info scene.glb\n"
        "  frugal info scene.glb --json | jq .triangles.drawn\n"
        "\n"
        "Usage: frugal info SCENE [OPTIONS]\n"
        "\n"
        "Says what a .gltf or .glb file holds, or the one that a scene file (.json) names, and what of it will\n"
        "not be rendered. Opens no device.\n",
    .closing = "\nExit codes: 0 the file can be read, 2 usage, 4 it cannot.\n",
    .options = info_options,
    .option_count = sizeof info_options / sizeof *info_options,
};

typedef struct SceneCounts {
  uint64_t primitives, triangles_stored, triangles_drawn, vertices, texels;
  bool has_bounds;
  Vec3 low, high;
} SceneCounts;

static SceneCounts scene_count(const Scene *scene)
{
  SceneCounts counts = {.triangles_drawn = scene_triangle_count(scene)};
  for (uint32_t m = 0; m < scene->mesh_count; m++) {
    const Mesh *mesh = &scene->meshes[m];
    counts.primitives += mesh->primitive_count;
    for (uint32_t p = 0; p < mesh->primitive_count; p++) {
      counts.triangles_stored += mesh->primitives[p].triangle_count;
      counts.vertices += mesh->primitives[p].vertex_count;
    }
  }
  for (uint32_t i = 0; i < scene->image_count; i++)
    counts.texels += (uint64_t)scene->images[i].width * scene->images[i].height;
  counts.has_bounds = scene_bounds(scene, &counts.low, &counts.high);
  return counts;
}

static const char *light_kind(const Light *light)
{
  return light->kind == LIGHT_POINT ? "point" : light->kind == LIGHT_SPOT ? "spot" : "directional";
}

static const char *light_unit(const Light *light) { return light->kind == LIGHT_DIRECTIONAL ? "lx" : "cd"; }

static const char *camera_kind(const Camera *camera)
{
  return camera->kind == CAMERA_PERSPECTIVE ? "perspective" : "orthographic";
}

static json_t *vec3_json(Vec3 v) { return json_pack("[f,f,f]", v.x, v.y, v.z); }

static json_t *cameras_json(const Scene *scene)
{
  json_t *list = json_array();
  for (uint32_t i = 0; i < scene->camera_count; i++) {
    const Camera *camera = &scene->cameras[i];
    bool is_perspective = camera->kind == CAMERA_PERSPECTIVE;
    json_array_append_new(
        list, json_pack("{s:s, s:s, s:f}", "name", camera->name, "kind", camera_kind(camera),
                        is_perspective ? "yfov_rad" : "ymag_m", is_perspective ? camera->yfov_rad : camera->ymag_m));
  }
  return list;
}

static json_t *lights_json(const Scene *scene)
{
  json_t *list = json_array();
  for (uint32_t i = 0; i < scene->light_count; i++) {
    const Light *light = &scene->lights[i];
    json_array_append_new(list, json_pack("{s:s, s:s, s:f, s:s, s:o}", "name", light->name, "kind", light_kind(light),
                                          "intensity", (double)light->intensity, "unit", light_unit(light), "color",
                                          vec3_json(vec3_from_floats(light->color))));
  }
  return list;
}

static json_t *animations_json(const GltfContents *contents)
{
  json_t *list = json_array();
  for (uint32_t i = 0; i < contents->animations; i++) {
    const GltfAnimationContents *animation = &contents->animation_list[i];
    json_array_append_new(
        list, json_pack("{s:o, s:o, s:I, s:I}", "name", app_json_text(animation->name), "length_s",
                        animation->is_fine ? json_real(animation->length_s) : json_null(), "nodes_moved",
                        (json_int_t)animation->node_count, "nodes_morphed", (json_int_t)animation->morph_count));
  }
  return list;
}

static json_t *file_json(const GltfContents *contents)
{
  json_t *extensions = json_array();
  for (uint32_t i = 0; i < contents->extension_count; i++)
    json_array_append_new(extensions, json_pack("{s:s, s:b}", "name", contents->extensions[i].name, "required",
                                                (int)contents->extensions[i].is_required));
  json_t *file = json_pack("{s:s, s:s, s:I, s:o}", "version", contents->version, "generator", contents->generator,
                           "buffer_bytes", (json_int_t)contents->buffer_bytes, "extensions", extensions);
  const struct {
    const char *key;
    uint32_t count;
  } counts[] = {
      {"scenes", contents->scenes},
      {"nodes", contents->nodes},
      {"meshes", contents->meshes},
      {"materials", contents->materials},
      {"textures", contents->textures},
      {"images", contents->images},
      {"cameras", contents->cameras},
      {"lights", contents->lights},
      {"skins", contents->skins},
      {"animations", contents->animations},
      {"morph_targets", contents->morph_targets},
  };
  for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
    json_object_set_new(file, counts[i].key, json_integer(counts[i].count));
  return file;
}

static json_t *info_json(const Scene *scene, const GltfContents *contents, json_t *warnings)
{
  SceneCounts counts = scene_count(scene);
  json_t *bounds = counts.has_bounds
                       ? json_pack("{s:o, s:o}", "low", vec3_json(counts.low), "high", vec3_json(counts.high))
                       : json_null();
  return json_pack("{s:o, s:o, s:I, s:I, s:I, s:I, s:{s:I, s:I}, s:o, s:o, s:o, s:o, s:I, s:I, s:{s:I, s:I}, s:O}",
                   "scene", app_json_text(scene->path), "file", file_json(contents), "objects",
                   (json_int_t)scene->object_count, "meshes", (json_int_t)scene->mesh_count, "primitives",
                   (json_int_t)counts.primitives, "vertices", (json_int_t)counts.vertices, "triangles", "stored",
                   (json_int_t)counts.triangles_stored, "drawn", (json_int_t)counts.triangles_drawn, "bounds", bounds,
                   "cameras", cameras_json(scene), "lights", lights_json(scene), "animations",
                   animations_json(contents), "materials", (json_int_t)scene->material_count, "textures",
                   (json_int_t)scene->texture_count, "images", "read", (json_int_t)scene->image_count, "pixels",
                   (json_int_t)counts.texels, "warnings", warnings);
}

// A row of the report: what, and as much of it as fits a line.
static void __attribute__((format(printf, 2, 3))) row_print(const char *name, const char *format, ...)
{
  char row[1024], clean[1024];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(row, sizeof row, format, arguments);
  va_end(arguments);
  app_text(clean, sizeof clean, row);
  printf("%-12s%s\n", name, clean);
}

static void file_print(const GltfContents *contents)
{
  row_print("file", "glTF %s, %.1f MB of buffers%s%s", contents->version, 1e-6 * (double)contents->buffer_bytes,
            contents->generator[0] ? ", by " : "", contents->generator);
  row_print("", "%u scenes, %u nodes, %u meshes, %u materials, %u images", contents->scenes, contents->nodes,
            contents->meshes, contents->materials, contents->images);
  if (contents->animations || contents->skins || contents->morph_targets)
    row_print("", "%u animations, %u skins, %u morph targets", contents->animations, contents->skins,
              contents->morph_targets);
  for (uint32_t i = 0; i < contents->extension_count; i++)
    row_print(i ? "" : "extensions", "%s%s", contents->extensions[i].name,
              contents->extensions[i].is_required ? " (required)" : "");
}

static void animations_print(const GltfContents *contents)
{
  for (uint32_t i = 0; i < contents->animations; i++) {
    const GltfAnimationContents *animation = &contents->animation_list[i];
    char length[64], moves[64] = "", morphs[64] = "";
    snprintf(length, sizeof length, animation->is_fine ? "%.4g s" : "cannot be followed", animation->length_s);
    if (animation->node_count) snprintf(moves, sizeof moves, ", moves %u nodes", animation->node_count);
    if (animation->morph_count) snprintf(morphs, sizeof morphs, ", morphs %u", animation->morph_count);
    row_print(i ? "" : "animations", "%u '%s', %s%s%s", i, animation->name, length, moves, morphs);
  }
}

static void info_print(const Scene *scene, const GltfContents *contents, const json_t *warnings)
{
  SceneCounts counts = scene_count(scene);
  row_print("scene", "%s", scene->path);
  file_print(contents);
  row_print("draws", "%llu triangles (%llu stored, %llu vertices) in %u objects of %u meshes, %llu primitives",
            (unsigned long long)counts.triangles_drawn, (unsigned long long)counts.triangles_stored,
            (unsigned long long)counts.vertices, scene->object_count, scene->mesh_count,
            (unsigned long long)counts.primitives);
  if (counts.has_bounds)
    row_print("bounds", "%.6g %.6g %.6g to %.6g %.6g %.6g", counts.low.x, counts.low.y, counts.low.z, counts.high.x,
              counts.high.y, counts.high.z);
  row_print("materials", "%u, with %u textures of %u images (%.1f million pixels)", scene->material_count,
            scene->texture_count, scene->image_count, 1e-6 * (double)counts.texels);
  for (uint32_t i = 0; i < scene->camera_count; i++) {
    const Camera *camera = &scene->cameras[i];
    row_print(i ? "" : "cameras", "%u '%s' %s", i, camera->name, camera_kind(camera));
  }
  for (uint32_t i = 0; i < scene->light_count; i++) {
    const Light *light = &scene->lights[i];
    row_print(i ? "" : "lights", "#%u '%s' %s, %.4g %s", i + 1, light->name, light_kind(light),
              (double)light->intensity, light_unit(light));
  }
  animations_print(contents);
  size_t i;
  json_t *warning;
  json_array_foreach(warnings, i, warning) { row_print(i ? "" : "warnings", "%s", json_string_value(warning)); }
}

// What render would warn of.
static void warning_keep(void *warnings, LogLevel level, const char *message)
{
  if (level == LOG_WARNING) json_array_append_new(warnings, json_string(message));
}

int app_info(int argc, char **argv)
{
  Status status = STATUS_OK;
  InfoOptions options = {.max_image_pixels = 1ull << 28};
  json_t *warnings = json_array(), *json = NULL;
  Log log = {.sink = warning_keep, .context = warnings};
  ImageHelper *images = NULL;
  Scene scene = {0};
  GltfContents contents = {0};
  RenderOptions render = {0};
  TRY(command_line_parse(&options.help, &options.scene_path, 1, &options, &info_command_line, argc, argv, &log));
  if (options.help) {
    command_line_help(&info_command_line, stdout);
    goto done;
  }
  if (!options.scene_path) {
    status = log_fail(&log, STATUS_USAGE, "info: no scene: frugal info SCENE");
    goto done;
  }
  TRY(render_options_read_file(&render, options.scene_path, options.allow_outside, &log));
  GltfOptions gltf = {.scene = NONE,
                      .allow_outside = options.allow_outside,
                      .max_memory_bytes = options.max_memory_bytes,
                      .changes = render.scene_file.document ? &render.scene_file : NULL};
  TRY(image_helper_start(&images, options.max_image_pixels, &log));
  TRY(gltf_read(&scene, render.gltf_path, &gltf, images, &log));
  TRY(gltf_contents_read(&contents, render.gltf_path, &gltf, &log));
  if (options.json) {
    json = info_json(&scene, &contents, warnings);
    TRY(json_write("-", json, &log));
  } else {
    info_print(&scene, &contents, warnings);
  }

done:
  json_decref(json);
  json_decref(warnings);
  scene_free(&scene);
  gltf_contents_free(&contents);
  render_options_free(&render);
  image_helper_stop(images);
  return status ? app_fail(&log, status) : app_end_output(0);
}
