#include "support/oracle_trace.h"

#include <stdlib.h>

#include "base/parallel.h"

#ifdef __SIZEOF_FLOAT128__
typedef __float128 Exact;
#else
typedef long double Exact;
#endif

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define WIDE __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define WIDE
#endif

OracleRay oracle_ray(Vec3 origin, Vec3 direction, double t_min, double t_max)
{
  return (OracleRay){.origin = origin, .direction = direction, .t_min = t_min, .t_max = t_max, .skip = ORACLE_MISS};
}

static double least(double a, double b) { return a < b ? a : b; }
static double most(double a, double b) { return a > b ? a : b; }

// One triangle that the ray's line passes inside of or near.
typedef struct Candidate {
  uint32_t triangle;
  bool inside, culled;
  double t, u, v, edge;
  double t_low, t_high;           // all of the triangle's depths where it is seen too thin for its plane to count
  double inset;                   // signed distance from the nearest edge across the line, positive inside, relative
  double thickness;               // least height of the triangle seen along the line, relative
  double length_m;                // what those are relative to
  double coverage, cover_margin;  // where inside
  double t_condition, u_condition, v_condition;
} Candidate;

typedef struct Candidates {
  Candidate *items;
  size_t count, capacity;
} Candidates;

static Candidate *candidates_add(Candidates *list)
{
  if (list->count == list->capacity) {
    Candidate *larger = oracle_array(2 * list->capacity + 16, sizeof *larger);
    for (size_t i = 0; i < list->count; i++) larger[i] = list->items[i];
    free(list->items);
    list->items = larger;
    list->capacity = 2 * list->capacity + 16;
  }
  return &list->items[list->count++];
}

// score[i] >= 0 where the line passes triangle i nearer than `tolerance` times the distance of its vertices: a bound
// that never leaves out a candidate. Each weight is the volume direction . (P x Q) of one edge.
WIDE static void block_score(double score[ORACLE_BLOCK], const OracleBlock *block, Vec3 o, Vec3 d, double length,
                             double tolerance, double reach_m)
{
  const float(*vertices)[3][ORACLE_BLOCK] = block->vertices;
  for (int i = 0; i < ORACLE_BLOCK; i++) {
    double ax = vertices[0][0][i] - o.x, ay = vertices[0][1][i] - o.y, az = vertices[0][2][i] - o.z;
    double bx = vertices[1][0][i] - o.x, by = vertices[1][1][i] - o.y, bz = vertices[1][2][i] - o.z;
    double cx = vertices[2][0][i] - o.x, cy = vertices[2][1][i] - o.y, cz = vertices[2][2][i] - o.z;
    double e0 = d.x * (by * cz - bz * cy) + d.y * (bz * cx - bx * cz) + d.z * (bx * cy - by * cx);
    double e1 = d.x * (cy * az - cz * ay) + d.y * (cz * ax - cx * az) + d.z * (cx * ay - cy * ax);
    double e2 = d.x * (ay * bz - az * by) + d.y * (az * bx - ax * bz) + d.z * (ax * by - ay * bx);
    double far = fabs(ax) + fabs(ay) + fabs(az) + fabs(bx) + fabs(by) + fabs(bz) + fabs(cx) + fabs(cy) + fabs(cz);
    far = far < reach_m ? reach_m : far;
    double bound = length * far * (tolerance * block->longest_m[i] + 1e-14 * far);
    double low = e0 < e1 ? e0 : e1, high = e0 > e1 ? e0 : e1;
    low = low < e2 ? low : e2;
    high = high > e2 ? high : e2;
    score[i] = (low > -high ? low : -high) + bound;
  }
}

// direction . ((p - o) x (q - o)), of the right sign: what is near zero in double is computed again.
static double edge_volume(Vec3 o, Vec3 d, Vec3 p, Vec3 q)
{
  Vec3 b = vec3_sub(p, o), c = vec3_sub(q, o);
  double volume = vec3_dot(d, vec3_cross(b, c));
  if (fabs(volume) > 1e-12 * vec3_length(d) * vec3_length(b) * vec3_length(c)) return volume;
  Exact bx = (Exact)p.x - o.x, by = (Exact)p.y - o.y, bz = (Exact)p.z - o.z;
  Exact cx = (Exact)q.x - o.x, cy = (Exact)q.y - o.y, cz = (Exact)q.z - o.z;
  return (double)(d.x * (by * cz - bz * cy) + d.y * (bz * cx - bx * cz) + d.z * (bx * cy - by * cx));
}

static void candidate_measure(Candidate *out, const OracleScene *scene, const OracleRay *ray, uint32_t triangle)
{
  Vec3 o = ray->origin, d = ray->direction, p[3];
  double volume[3], depth[3], around[3], far_m = 0, length = vec3_length(d);
  double volumes = 0;
  for (int i = 0; i < 3; i++) p[i] = oracle_vertex(scene, triangle, i);
  for (int i = 0; i < 3; i++) {
    Vec3 from = p[(i + 1) % 3], to = p[(i + 2) % 3];
    volume[i] = edge_volume(o, d, from, to);
    around[i] = vec3_length(vec3_cross(d, vec3_sub(to, from)));
    depth[i] = vec3_dot(vec3_sub(p[i], o), d) / (length * length);
    far_m = most(far_m, vec3_length(vec3_sub(p[i], o)));
    volumes += volume[i];
  }
  double side = volumes < 0 ? -1 : 1, det = fabs(volumes);
  double least_volume = least(side * volume[0], least(side * volume[1], side * volume[2]));
  Vec3 normal = vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[2], p[0]));

  *out = (Candidate){.triangle = triangle, .inside = det > 0 && least_volume >= 0, .coverage = 1};
  out->culled = ray->cull && (scene->triangles[triangle].flags & ORACLE_SINGLE_SIDED) && side > 0;
  out->length_m = most(far_m, ray->reach_m);
  out->inset = out->thickness = INFINITY;
  for (int i = 0; i < 3; i++) {
    if (!(around[i] > 0)) continue;
    out->inset = least(out->inset, side * volume[i] / around[i] / out->length_m);
    out->thickness = least(out->thickness, det / around[i] / out->length_m);
  }
  double weight[3] = {0};
  for (int i = 0; i < 3; i++) weight[i] = det > 0 ? side * volume[i] / det : 1.0 / 3;
  double nearest = least(depth[0], least(depth[1], depth[2])), farthest = most(depth[0], most(depth[1], depth[2]));
  double t = weight[0] * depth[0] + weight[1] * depth[1] + weight[2] * depth[2];
  bool thin = out->thickness < ORACLE_MARGIN_MAX;
  out->t = most(nearest, least(farthest, t));
  out->t_low = thin ? nearest : out->t;
  out->t_high = thin ? farthest : out->t;
  out->u = weight[1];
  out->v = weight[2];
  out->edge = least(weight[0], least(weight[1], weight[2]));
  out->t_condition = det > 0 ? far_m * vec3_length(normal) / det : INFINITY;
  out->u_condition = det > 0 ? far_m * around[1] / det : INFINITY;
  out->v_condition = det > 0 ? far_m * around[2] / det : INFINITY;
  out->cover_margin = ORACLE_MARGIN_MAX;
  if (out->inside && (scene->triangles[triangle].flags & ORACLE_SEE_THROUGH) && scene->coverage)
    out->coverage = scene->coverage(scene, triangle, out->u, out->v, &out->cover_margin);
}

static Candidates candidates_find(const OracleScene *scene, const OracleRay *ray)
{
  Candidates list = {0};
  double score[ORACLE_BLOCK], length = vec3_length(ray->direction);
  if (!(length > 0 && isfinite(length))) return list;
  for (uint32_t block = 0; block < scene->block_count; block++) {
    block_score(score, &scene->blocks[block], ray->origin, ray->direction, length, ORACLE_MARGIN_MAX, ray->reach_m);
    for (uint32_t slot = 0; slot < ORACLE_BLOCK; slot++) {
      uint32_t triangle = block * ORACLE_BLOCK + slot;
      if (score[slot] >= 0 && triangle != ray->skip) candidate_measure(candidates_add(&list), scene, ray, triangle);
    }
  }
  return list;
}

// (b - a) along the ray, relative to the distance at a.
static double along(const OracleRay *ray, double a, double b)
{
  double length = vec3_length(ray->direction), distance_m = fabs(a) * length;
  if (!isfinite(b)) return b > a ? INFINITY : -INFINITY;
  return b == a ? 0 : (b - a) * length / most(distance_m, ray->reach_m);
}

static bool counts(const Candidate *at, const OracleRay *ray)
{
  return at->inside && !at->culled && at->coverage > 0 && at->t > ray->t_min && at->t <= ray->t_max;
}

// How surely a hit is one, setting others aside.
static double firmness(const Candidate *at, const OracleRay *ray)
{
  double range = least(along(ray, at->t, ray->t_max), -along(ray, at->t, ray->t_min));
  return least(least(at->inset, range), at->cover_margin);
}

// How far a triangle is from being a hit before `t_end`; 0 or less where it is one.
static double remoteness(const Candidate *at, const OracleRay *ray, double t_end)
{
  double range = most(along(ray, at->t_high, ray->t_min), -along(ray, at->t_low, t_end));
  double aside = at->culled && at->inside ? at->inset : -at->inset;
  double absent = at->inside && !(at->coverage > 0) ? at->cover_margin : 0;
  return most(most(range, aside), absent);
}

void oracle_closest(OracleHit *out, const OracleScene *scene, const OracleRay *ray)
{
  Candidates list = candidates_find(scene, ray);
  const Candidate *best = NULL, *next = NULL;
  for (size_t i = 0; i < list.count; i++) {
    const Candidate *at = &list.items[i];
    if (!counts(at, ray)) continue;
    if (!best || at->t < best->t) {
      next = best;
      best = at;
    } else if (!next || at->t < next->t) {
      next = at;
    }
  }
  *out = (OracleHit){.triangle = ORACLE_MISS, .next_triangle = ORACLE_MISS, .t = INFINITY, .next_t = INFINITY};
  out->margin = ORACLE_MARGIN_MAX;
  out->gap = INFINITY;
  if (best) {
    *out = (OracleHit){.triangle = best->triangle, .t = best->t, .u = best->u, .v = best->v, .edge = best->edge};
    out->t_condition = best->t_condition;
    out->u_condition = best->u_condition;
    out->v_condition = best->v_condition;
    out->next_triangle = next ? next->triangle : ORACLE_MISS;
    out->next_t = next ? next->t : INFINITY;
    out->gap = next ? (next->t - best->t) / fabs(best->t) : INFINITY;
    out->margin = least(firmness(best, ray), ORACLE_MARGIN_MAX);
  }
  for (size_t i = 0; i < list.count; i++) {
    if (&list.items[i] == best) continue;
    out->margin = least(out->margin, most(0, remoteness(&list.items[i], ray, best ? best->t : ray->t_max)));
  }
  free(list.items);
}

double oracle_lit(const OracleScene *scene, const OracleRay *ray, double *margin)
{
  Candidates list = candidates_find(scene, ray);
  double lit = 1, open = ORACLE_MARGIN_MAX, firm = 0;
  for (size_t i = 0; i < list.count; i++) {
    const Candidate *at = &list.items[i];
    if (!counts(at, ray)) {
      open = least(open, most(0, remoteness(at, ray, ray->t_max)));
    } else {
      lit *= 1 - at->coverage;
      open = least(open, firmness(at, ray));
      if (at->coverage >= 1) firm = most(firm, firmness(at, ray));
    }
  }
  free(list.items);
  if (margin) *margin = least(*margin, lit > 0 ? open : firm);
  return lit;
}

typedef struct Batch {
  const OracleScene *scene;
  const OracleRay *rays;
  OracleHit *hits;
  double *lit, *margins;
} Batch;

static void batch_closest(void *context, size_t i)
{
  const Batch *batch = context;
  oracle_closest(&batch->hits[i], batch->scene, &batch->rays[i]);
}

static void batch_lit(void *context, size_t i)
{
  const Batch *batch = context;
  double margin = ORACLE_MARGIN_MAX;
  batch->lit[i] = oracle_lit(batch->scene, &batch->rays[i], &margin);
  if (batch->margins) batch->margins[i] = margin;
}

void oracle_closest_all(OracleHit *out, const OracleScene *scene, const OracleRay *rays, size_t count)
{
  parallel_for(count, batch_closest, &(Batch){.scene = scene, .rays = rays, .hits = out});
}

void oracle_lit_all(double *out, double *margins, const OracleScene *scene, const OracleRay *rays, size_t count)
{
  parallel_for(count, batch_lit, &(Batch){.scene = scene, .rays = rays, .lit = out, .margins = margins});
}

// t as near as the triangle's tilt lets it; seen so thin that its plane is lost in rounding, anywhere in its range.
static bool depth_agrees(const OracleRay *ray, const Candidate *at, double t, double rounding)
{
  double slack = rounding * at->length_m / vec3_length(ray->direction);
  if (fabs(t - at->t) <= rounding * at->t_condition) return true;
  return at->thickness <= 4 * rounding && t >= at->t_low - slack && t <= at->t_high + slack;
}

OracleVerdict oracle_judge(const OracleScene *scene, const OracleRay *ray, const OracleHit *truth,
                           const OracleHit *claim, double rounding)
{
  if (claim->triangle == ORACLE_MISS && truth->triangle == ORACLE_MISS) return ORACLE_SAME;
  if (claim->triangle != ORACLE_MISS && (claim->triangle >= scene->triangle_count || !isfinite(claim->t)))
    return ORACLE_WRONG;
  if (claim->triangle == truth->triangle && fabs(claim->t - truth->t) <= rounding * truth->t_condition &&
      fabs(claim->u - truth->u) <= rounding * truth->u_condition &&
      fabs(claim->v - truth->v) <= rounding * truth->v_condition)
    return ORACLE_SAME;

  double limit = INFINITY;  // no honest answer lies beyond
  if (claim->triangle != ORACLE_MISS) {
    Candidate at;
    candidate_measure(&at, scene, ray, claim->triangle);
    if (claim->triangle == ray->skip || remoteness(&at, ray, ray->t_max) > rounding) return ORACLE_WRONG;
    if (!depth_agrees(ray, &at, claim->t, rounding)) return ORACLE_WRONG;
    if (claim->triangle == truth->triangle && at.thickness > 4 * rounding) return ORACLE_WRONG;
    limit = claim->t;
  }
  OracleVerdict verdict = ORACLE_TIE;
  Candidates list = candidates_find(scene, ray);
  for (size_t i = 0; i < list.count; i++) {
    const Candidate *at = &list.items[i];
    if (counts(at, ray) && firmness(at, ray) > rounding && at->t + rounding * at->t_condition < limit)
      verdict = ORACLE_WRONG;
  }
  free(list.items);
  return verdict;
}

bool oracle_lit_unsure(const OracleScene *scene, const OracleRay *ray, double rounding)
{
  double margin = ORACLE_MARGIN_MAX;
  oracle_lit(scene, ray, &margin);
  return margin <= rounding;
}
