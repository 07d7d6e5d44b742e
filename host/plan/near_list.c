#include "plan/near_list.h"

#include <stdlib.h>

// Nearest point of a triangle to the origin, squared distance.
// From Ericson, "Real-Time Collision Detection", 2005, section 5.1.5.
static double triangle_distance_squared(Vec3 a, Vec3 b, Vec3 c)
{
  Vec3 ab = vec3_sub(b, a), ac = vec3_sub(c, a), nearest = a;
  double d1 = -vec3_dot(ab, a), d2 = -vec3_dot(ac, a), d3 = -vec3_dot(ab, b), d4 = -vec3_dot(ac, b);
  double d5 = -vec3_dot(ab, c), d6 = -vec3_dot(ac, c);
  double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
  if (d1 <= 0 && d2 <= 0)
    nearest = a;
  else if (d3 >= 0 && d4 <= d3)
    nearest = b;
  else if (d6 >= 0 && d5 <= d6)
    nearest = c;
  else if (vc <= 0 && d1 >= 0 && d3 <= 0)
    nearest = vec3_add(a, vec3_scale(ab, d1 / (d1 - d3)));
  else if (vb <= 0 && d2 >= 0 && d6 <= 0)
    nearest = vec3_add(a, vec3_scale(ac, d2 / (d2 - d6)));
  else if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    nearest = vec3_add(b, vec3_scale(vec3_sub(c, b), (d4 - d3) / ((d4 - d3) + (d5 - d6))));
  else
    nearest = vec3_add(a, vec3_add(vec3_scale(ab, vb / (va + vb + vc)), vec3_scale(ac, vc / (va + vb + vc))));
  return vec3_dot(nearest, nearest);
}

// Is any triangle of an object within the radius?
static bool surface_is_near(const Scene *scene, const Object *object, Vec3 center, double radius_m)
{
  const Mesh *mesh = &scene->meshes[object->mesh];
  for (uint32_t p = 0; p < mesh->primitive_count; p++) {
    const Primitive *primitive = &mesh->primitives[p];
    for (uint32_t t = 0; t < primitive->triangle_count; t++) {
      Vec3 corners[3];
      for (int i = 0; i < 3; i++) {
        const float *position = primitive->positions[primitive->triangles[t][i]];
        corners[i] = vec3_sub(mat4_point(&object->world_from_object, vec3_from_floats(position)), center);
      }
      if (triangle_distance_squared(corners[0], corners[1], corners[2]) <= radius_m * radius_m) return true;
    }
  }
  return false;
}

static double bounds_distance_m(Vec3 center, Vec3 low, Vec3 high)
{
  Vec3 nearest = vec3_max(low, vec3_min(center, high));
  return vec3_length(vec3_sub(nearest, center));
}

static bool has_material(const Scene *scene, uint32_t object, bool (*is)(const Material *))
{
  const Mesh *mesh = &scene->meshes[scene->objects[object].mesh];
  for (uint32_t p = 0; p < mesh->primitive_count; p++)
    if (is(&scene->materials[mesh->primitives[p].material])) return true;
  return false;
}

static bool is_mirror(const Material *material) { return material->roughness <= 0 && !material->unlit; }

static bool is_blend(const Material *material) { return material->alpha_mode == ALPHA_BLEND; }

Status object_facts_make(ObjectFacts **out, const Scene *scene, Log *log)
{
  ObjectFacts *facts = calloc((size_t)scene->object_count + 1, sizeof *facts);
  if (!facts) return log_no_memory(log, "objects near a reflector");
  for (uint32_t i = 0; i < scene->object_count; i++) {
    facts[i].drawn = scene_object_bounds(scene, i, &facts[i].low, &facts[i].high);
    facts[i].triangles = scene_object_triangles(scene, i);
    facts[i].mirror = has_material(scene, i, is_mirror);
    facts[i].blend = has_material(scene, i, is_blend);
  }
  *out = facts;
  return STATUS_OK;
}

static int near_compare(const void *a, const void *b)
{
  const NearObject *x = a, *y = b;
  if (x->distance_m != y->distance_m) return x->distance_m < y->distance_m ? -1 : 1;
  return (x->object > y->object) - (x->object < y->object);
}

Status near_list_make(NearList *out, const Scene *scene, const ObjectFacts *facts, uint32_t reflector, Vec3 center,
                      double radius_m, uint64_t triangles_most, Log *log)
{
  NearList list = {.objects = calloc((size_t)scene->object_count + 1, sizeof *list.objects)};
  if (!list.objects) return log_no_memory(log, "objects near a reflector");
  for (uint32_t i = 0; i < scene->object_count; i++) {
    if (i == reflector || !facts[i].drawn) continue;
    double distance_m = bounds_distance_m(center, facts[i].low, facts[i].high);
    bool is_near = distance_m <= radius_m && surface_is_near(scene, &scene->objects[i], center, radius_m);
    if (is_near || facts[i].mirror)
      list.objects[list.count++] = (NearObject){.object = i, .triangles = facts[i].triangles, .distance_m = distance_m};
  }
  qsort(list.objects, list.count, sizeof *list.objects, near_compare);
  uint32_t kept = 0;
  uint64_t triangles = 0;
  while (kept < list.count && triangles + list.objects[kept].triangles <= triangles_most)
    triangles += list.objects[kept++].triangles;
  list.left_out = list.count - kept;
  list.count = kept;
  *out = list;
  return STATUS_OK;
}

void near_list_free(NearList *list)
{
  free(list->objects);
  *list = (NearList){0};
}

bool snapshot_frustum_fit(SnapshotFrustum *out, Vec3 center, Vec3 low, Vec3 high)
{
  static const double widest = 1;  // the tangent of 45 degrees
  SnapshotFrustum f = {.forward = vec3_sub(vec3_scale(vec3_add(low, high), 0.5), center)};
  f.forward = vec3_unit_or(f.forward, vec3(0, 0, 0));
  Vec3 upright = fabs(f.forward.y) < 0.9 ? vec3(0, -1, 0) : vec3(1, 0, 0);
  f.right = vec3_unit_or(vec3_cross(upright, f.forward), vec3(0, 0, 0));
  f.down = vec3_cross(f.forward, f.right);
  double reach_x[2] = {INFINITY, -INFINITY}, reach_y[2] = {INFINITY, -INFINITY};
  for (int i = 0; i < 8; i++) {
    Vec3 corner = vec3_sub(vec3(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z), center);
    double depth = vec3_dot(corner, f.forward);
    double x = vec3_dot(corner, f.right) / depth, y = vec3_dot(corner, f.down) / depth;
    if (!(depth > 0 && fabs(x) <= widest && fabs(y) <= widest)) return false;
    reach_x[0] = fmin(reach_x[0], x);
    reach_x[1] = fmax(reach_x[1], x);
    reach_y[0] = fmin(reach_y[0], y);
    reach_y[1] = fmax(reach_y[1], y);
    f.beyond_m = fmax(f.beyond_m, depth);
  }
  f.width = fmax(reach_x[1] - reach_x[0], reach_y[1] - reach_y[0]);
  f.left = (reach_x[0] + reach_x[1] - f.width) / 2;
  f.top = (reach_y[0] + reach_y[1] - f.width) / 2;
  *out = f;
  return f.width > 0;
}

static NearReason reason_of(const ObjectFacts *facts, Vec3 center)
{
  SnapshotFrustum frustum;
  if (facts->mirror) return NEAR_MIRROR;
  if (facts->blend) return NEAR_BLEND;
  return snapshot_frustum_fit(&frustum, center, facts->low, facts->high) ? NEAR_AS_ASKED : NEAR_TOO_WIDE;
}

void near_list_choose(NearList *list, const ObjectFacts *facts, Vec3 center, ReflectionMethod reflections,
                      uint32_t complex_from)
{
  uint32_t snapshots = 0;
  for (uint32_t i = 0; i < list->count; i++) {
    NearObject *near = &list->objects[i];
    bool is_complex = reflections == REFLECTIONS_MIXED && near->triangles >= complex_from;
    near->method = NEAR_BY_RAYS;
    near->reason = NEAR_AS_ASKED;
    if (reflections != REFLECTIONS_SNAPSHOT && !is_complex) continue;
    near->reason = reason_of(&facts[near->object], center);
    if (near->reason == NEAR_AS_ASKED && snapshots == SNAPSHOTS_MOST) near->reason = NEAR_CROWDED;
    if (near->reason != NEAR_AS_ASKED) continue;
    near->method = NEAR_BY_SNAPSHOT;
    snapshots++;
  }
}

const char *near_method_name(NearMethod method) { return method == NEAR_BY_SNAPSHOT ? "snapshot" : "rays"; }

const char *near_reason_name(NearReason reason)
{
  static const char *const names[] = {"as asked", "mirror", "blend", "too wide", "crowded"};
  return names[reason];
}
