#include "app/self_test.h"

#include <math.h>
#include <string.h>

#include "render/frame.h"
#include "shared/aov.h"

enum { SIZE = 32, PIXELS = SIZE * SIZE };
enum { WALL, OCCLUDER, MIRROR, GLOW, OBJECT_COUNT };

static const double light_intensity_cd = 50, distance_error = 1e-5, color_error = 1e-4;
static const double glow[3] = {0.25, 0.5, 1};
static const Vec3 light_position = {0, 6, -2};

// Two triangles a quad, corners counterclockwise as seen from the side that `normals` points to.
typedef struct Quads {
  float positions[OBJECT_COUNT][4][3], normals[OBJECT_COUNT][4][3];
  uint32_t triangles[2][3];
  Primitive primitives[OBJECT_COUNT];
  Mesh meshes[OBJECT_COUNT];
  Object objects[OBJECT_COUNT];
  Material materials[OBJECT_COUNT];
  Light light;
} Quads;

// The camera stands in the origin and sees z = -1 from -1 to 1. The occluder lies over the left half of the wall, above
// what it sees; the glowing plane is behind it.
static const float corners[OBJECT_COUNT][4][3] = {
    [WALL] = {{-9, -9, -4}, {9, -9, -4}, {9, 9, -4}, {-9, 9, -4}},
    [OCCLUDER] = {{-20, 5, -5}, {0, 5, -5}, {0, 5, -1}, {-20, 5, -1}},
    [MIRROR] = {{1, -3, -3}, {3, -3, -3}, {3, -1, -3}, {1, -1, -3}},
    [GLOW] = {{20, -20, 5}, {-20, -20, 5}, {-20, 20, 5}, {20, 20, 5}},
};
static const float normal_z[OBJECT_COUNT] = {[WALL] = 1, [MIRROR] = 1, [GLOW] = -1};

static Scene scene_make(Quads *quads)
{
  static const uint32_t triangles[2][3] = {{0, 1, 2}, {0, 2, 3}};
  *quads = (Quads){.light = {.kind = LIGHT_POINT,
                             .color = {1, 1, 1},
                             .intensity = (float)light_intensity_cd,
                             .range_m = INFINITY,
                             .position_world = light_position}};
  memcpy(quads->positions, corners, sizeof corners);
  memcpy(quads->triangles, triangles, sizeof triangles);
  for (int i = 0; i < OBJECT_COUNT; i++) {
    for (int k = 0; k < 4; k++) {
      quads->normals[i][k][1] = i == OCCLUDER ? -1 : 0;
      quads->normals[i][k][2] = normal_z[i];
    }
    quads->materials[i] = material_default();
    quads->materials[i].metallic = i == MIRROR;
    quads->materials[i].roughness = i != MIRROR;
    quads->materials[i].unlit = i == GLOW;
    quads->primitives[i] = (Primitive){.vertex_count = 4,
                                       .triangle_count = 2,
                                       .positions = quads->positions[i],
                                       .normals = quads->normals[i],
                                       .triangles = quads->triangles,
                                       .material = i};
    quads->meshes[i] = (Mesh){.primitives = &quads->primitives[i], .primitive_count = 1};
    quads->objects[i] = (Object){.mesh = i, .world_from_object = mat4_identity()};
  }
  for (int c = 0; c < 3; c++) quads->materials[GLOW].base_color[c] = (float)glow[c];
  return (Scene){.path = "self-test",
                 .materials = quads->materials,
                 .material_count = OBJECT_COUNT,
                 .meshes = quads->meshes,
                 .mesh_count = OBJECT_COUNT,
                 .objects = quads->objects,
                 .object_count = OBJECT_COUNT,
                 .lights = &quads->light,
                 .light_count = 1,
                 .environment = {.kind = ENVIRONMENT_CONSTANT, .intensity = 1}};
}

typedef struct Seen {
  uint32_t object;
  double depth, color[3];
} Seen;

// In closed form, under the phong model without its ambient term: at roughness 1 the wall's highlight is the same in
// all directions, 0.04 / pi. A mirror of metallic 1 and base colour 1 shows what it sees.
static Seen right_answer(int x, int y)
{
  double right = (2 * x + 1.0) / SIZE - 1, up = 1 - (2 * y + 1.0) / SIZE;
  Vec3 mirror_point = vec3(3 * right, 3 * up, -3), wall_point = vec3(4 * right, 4 * up, -4);
  if (mirror_point.x > 1 && mirror_point.y < -1) return (Seen){MIRROR, 3, {glow[0], glow[1], glow[2]}};
  double distance = vec3_length(vec3_sub(light_position, wall_point));
  double cosine = (light_position.z - wall_point.z) / distance;
  double lit = wall_point.x < 0 ? 0 : 1.04 / M_PI * light_intensity_cd * cosine / (distance * distance);
  return (Seen){WALL, 4, {lit, lit, lit}};
}

// Shared edges and shadow edges lie between pixel centres, so that each pixel has one answer.
static Status pixels_compare(const float *colors, const float *depths, const uint32_t *objects, const char *name,
                             Log *log)
{
  for (int i = 0; i < PIXELS; i++) {
    Seen right = right_answer(i % SIZE, i / SIZE);
    const char *what = NULL;
    double got = 0, expected = 0;
    if (objects[i] != right.object) {
      what = "object", got = objects[i], expected = right.object;
    } else if (!(fabs(depths[i] - right.depth) <= distance_error * right.depth)) {
      what = "distance", got = (double)depths[i], expected = right.depth;
    }
    for (int c = 0; c < 3 && !what; c++)
      if (!(fabs(colors[4 * i + c] - right.color[c]) <= color_error * fmax(right.color[c], 0.01)))
        what = "colour", got = (double)colors[4 * i + c], expected = right.color[c];
    if (what)
      return log_fail(log, STATUS_DEVICE,
                      "%s: self-test failed: %s %.9g at pixel %d,%d where %.9g is right: update its "
                      "driver, or use another --device",
                      name, what, got, i % SIZE, i / SIZE, expected);
  }
  return STATUS_OK;
}

Status self_test(Device *device, Log *log)
{
  Status status = STATUS_OK;
  Quads quads;
  Scene scene = scene_make(&quads);
  DeviceScene device_scene = {0};
  Frame frame = {0};
  float colors[PIXELS * 4], values[PIXELS * (AOV_DEPTH + 1)];
  uint32_t ids[PIXELS * (AOV_OBJECT + 1)];
  Camera camera = {.kind = CAMERA_PERSPECTIVE,
                   .yfov_rad = M_PI / 2,
                   .znear_m = 0.01,
                   .zfar_m = INFINITY,
                   .world_from_camera = mat4_identity()};
  RenderSettings settings = {.width = SIZE,
                             .height = SIZE,
                             .samples = 1,
                             .lighting = LIGHTING_PHONG,
                             .shadows = SHADOWS_RAYS,
                             .reflections = REFLECTIONS_RAYS,
                             .max_depth = 2};
  ResolveInfo resolve = {.pixel_count = PIXELS, .scale = 1, .coverage_scale = 1, .opaque = 1};
  TRY(device_scene_make(&device_scene, device, &scene, NULL, log));
  SceneFacts facts = {.light_count = 1, .has_mirrors = device_scene.has_mirrors};
  FrameRequest request = {.camera = &camera,
                          .area = {SIZE, SIZE, 0, 0, SIZE, SIZE},
                          .samples = 1,
                          .plan = plan_make(&settings, &facts),
                          .aovs = AOV_SET_SURFACE};
  TRY(frame_make(&frame, device, &device_scene, &request, log));
  TRY(frame_render(&frame, log));
  TRY(film_resolve(&frame.film, device, &frame.film.sums, &resolve, colors, log));
  TRY(buffer_read(device, &frame.film.aov_values, values, sizeof values, log));
  TRY(buffer_read(device, &frame.film.aov_ids, ids, sizeof ids, log));
  TRY(pixels_compare(colors, values + AOV_DEPTH * PIXELS, ids + AOV_OBJECT * PIXELS, device_info(device)->name, log));

done:
  frame_free(&frame);
  device_scene_free(&device_scene);
  return status;
}
