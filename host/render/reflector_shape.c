#include "render/reflector_shape.h"

#include <math.h>
#include <stdlib.h>

#include "base/loop_clones.h"

// Share of an object's size by which a vertex may lie above a plane, and what unit normals may be off.
static const double rounding = 1e-5;

static Vec3 corner(const Primitive *primitive, uint32_t triangle, int k)
{
  const float *p = primitive->positions[primitive->triangles[triangle][k]];
  return vec3((double)p[0], (double)p[1], (double)p[2]);
}

// How far the vertices of a mesh lie above and below a plane, at most.
typedef struct Reach {
  double above, below;
} Reach;

enum { STEP = 8 };  // vertices at a time

// Vertices by coordinate; the last one fills what is left of a whole number of steps.
typedef struct Vertices {
  double *x, *y, *z;
  size_t count;
} Vertices;

static double mesh_tests(const Mesh *mesh)
{
  double triangles = 0, vertices = 0;
  for (uint32_t p = 0; p < mesh->primitive_count; p++) {
    triangles += mesh->primitives[p].triangle_count;
    vertices += mesh->primitives[p].vertex_count;
  }
  return triangles * vertices;
}

static void vertex_put(Vertices *to, size_t at, double x, double y, double z)
{
  to->x[at] = x;
  to->y[at] = y;
  to->z[at] = z;
}

// False where there is no memory, or no vertex. Free `x`.
static bool vertices_collect(Vertices *out, const Mesh *mesh)
{
  size_t count = 0, at = 0;
  for (uint32_t p = 0; p < mesh->primitive_count; p++) count += mesh->primitives[p].vertex_count;
  count = (count + STEP - 1) / STEP * STEP;
  double *x = count ? malloc(3 * count * sizeof *x) : NULL;
  if (!x) return false;
  *out = (Vertices){x, x + count, x + 2 * count, count};
  for (uint32_t p = 0; p < mesh->primitive_count; p++) {
    const Primitive *primitive = &mesh->primitives[p];
    for (uint32_t v = 0; v < primitive->vertex_count; v++) {
      const float *from = primitive->positions[v];
      vertex_put(out, at++, (double)from[0], (double)from[1], (double)from[2]);
    }
  }
  for (; at < count; at++) vertex_put(out, at, out->x[at - 1], out->y[at - 1], out->z[at - 1]);
  return true;
}

LOOP_CLONES static Reach vertices_reach(const Vertices *of, Vec3 normal, double offset)
{
  Reach reach = {0};
  double high[STEP] = {0}, low[STEP] = {0};
  for (size_t i = 0; i < of->count; i += STEP) {
    const double *x = of->x + i, *y = of->y + i, *z = of->z + i;
    for (int k = 0; k < STEP; k++) {
      double height = normal.x * x[k] + normal.y * y[k] + normal.z * z[k] - offset;
      high[k] = height > high[k] ? height : high[k];
      low[k] = height < low[k] ? height : low[k];
    }
  }
  for (int k = 0; k < STEP; k++) reach = (Reach){fmax(reach.above, high[k]), fmax(reach.below, -low[k])};
  return reach;
}

static bool primitive_is_outermost(const Primitive *primitive, const Vertices *vertices, bool double_sided)
{
  for (uint32_t i = 0; i < primitive->triangle_count; i++) {
    Vec3 a = corner(primitive, i, 0), b = vec3_sub(corner(primitive, i, 1), a),
         c = vec3_sub(corner(primitive, i, 2), a);
    Vec3 normal = vec3_unit_or(vec3_cross(b, c), vec3(0, 0, 0));
    Reach reach = vertices_reach(vertices, normal, vec3_dot(normal, a));
    double size = fmax(reach.below, fmax(vec3_length(b), vec3_length(c)));
    if (reach.above > rounding * size || (double_sided && reach.below > rounding * size)) return false;
  }
  return true;
}

bool object_is_convex(const Scene *scene, uint32_t object)
{
  const Mesh *mesh = &scene->meshes[scene->objects[object].mesh];
  Vertices vertices;
  if (mesh_tests(mesh) > CONVEX_TESTS_MOST || !vertices_collect(&vertices, mesh)) return false;
  bool is_convex = true;
  for (uint32_t p = 0; p < mesh->primitive_count && is_convex; p++)
    is_convex = primitive_is_outermost(&mesh->primitives[p], &vertices,
                                       scene->materials[mesh->primitives[p].material].double_sided);
  free(vertices.x);
  return is_convex;
}

bool plane_of_triangle(MirrorPlane *out, const Scene *scene, uint32_t object, const Primitive *primitive,
                       uint32_t triangle)
{
  const Mat4 *world = &scene->objects[object].world_from_object;
  if (scene->materials[primitive->material].normal_slot.texture != NONE) return false;
  Vec3 a = corner(primitive, triangle, 0), b = vec3_sub(corner(primitive, triangle, 1), a),
       c = vec3_sub(corner(primitive, triangle, 2), a);
  Vec3 own = vec3_unit_or(vec3_cross(b, c), vec3(0, 0, 0)), at = mat4_point(world, a);
  for (int k = 0; k < 3; k++) {
    const float *n = primitive->normals[primitive->triangles[triangle][k]];
    if (vec3_length(vec3_cross(vec3((double)n[0], (double)n[1], (double)n[2]), own)) > rounding) return false;
  }
  b = mat4_direction(world, b), c = mat4_direction(world, c);
  Vec3 normal = vec3_unit_or(vec3_cross(b, c), vec3(0, 0, 0));
  if (vec3_dot(normal, mat4_normal(world, own)) < 0) normal = vec3_neg(normal);
  double size = fmax(vec3_length(b), vec3_length(c));
  *out = (MirrorPlane){normal, vec3_dot(normal, at), at, size};
  return vec3_length(normal) > 0;
}

bool planes_are_one(const MirrorPlane *a, const MirrorPlane *b)
{
  double apart = fabs(vec3_dot(a->normal, b->at) - a->offset_m), size = fmax(a->size_m, b->size_m);
  return vec3_dot(a->normal, b->normal) > 0 && vec3_length(vec3_cross(a->normal, b->normal)) <= rounding &&
         apart <= rounding * size;
}
