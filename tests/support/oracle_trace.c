#include "support/oracle_trace.h"

#include <stdlib.h>

#include "base/parallel.h"

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
  double t_low, t_high;           // depths of the nearest and the farthest corner
  double inset;                   // signed distance from the nearest edge across the line, positive inside, relative
  double thickness;               // least height of the triangle seen along the line, relative
  double length_m, unit_t;        // what those are relative to, and as a depth
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

// A number of some 106 bits, hi + lo, with |lo| <= ulp(hi) / 2. Source: Dekker, "A Floating-Point Technique for
// Extending the Available Precision", 1971; Knuth, "The Art of Computer Programming", volume 2, section 4.2.2 (the
// sum).
typedef struct Pair {
  double hi, lo;
} Pair;

static Pair pair_sum(double a, double b)
{
  double sum = a + b, from_b = sum - a;
  return (Pair){sum, (a - (sum - from_b)) + (b - from_b)};
}

static Pair pair_product(Pair a, Pair b)
{
  double product = a.hi * b.hi;
  return pair_sum(product, fma(a.hi, b.hi, -product) + (a.hi * b.lo + a.lo * b.hi));
}

static Pair pair_difference(Pair a, Pair b)
{
  Pair sum = pair_sum(a.hi, -b.hi);
  return pair_sum(sum.hi, sum.lo + (a.lo - b.lo));
}

// direction . ((p - o) x (q - o)), of the right sign: what is near zero in double is computed again.
static double edge_volume(Vec3 o, Vec3 d, Vec3 p, Vec3 q)
{
  Vec3 b = vec3_sub(p, o), c = vec3_sub(q, o);
  double volume = vec3_dot(d, vec3_cross(b, c));
  if (fabs(volume) > 1e-14 * vec3_length(d) * vec3_length(b) * vec3_length(c)) return volume;
  Pair bx = pair_sum(p.x, -o.x), by = pair_sum(p.y, -o.y), bz = pair_sum(p.z, -o.z);
  Pair cx = pair_sum(q.x, -o.x), cy = pair_sum(q.y, -o.y), cz = pair_sum(q.z, -o.z);
  Pair x = pair_product((Pair){-d.x, 0}, pair_difference(pair_product(by, cz), pair_product(bz, cy)));
  Pair y = pair_product((Pair){d.y, 0}, pair_difference(pair_product(bz, cx), pair_product(bx, cz)));
  Pair z = pair_product((Pair){-d.z, 0}, pair_difference(pair_product(bx, cy), pair_product(by, cx)));
  Pair sum = pair_difference(pair_difference(y, x), z);
  return sum.hi + sum.lo;
}

// A product in an edge function rounds to this share of what a coordinate may be off by.
#define PRODUCTS 0.25

// A triangle as a ray sees it. By corner: the volume of the edge opposite to it, and how much an error of 1 changes
// that; depths along the ray and along the direction's largest axis, which agree where the ray hits, and not beside it.
typedef struct View {
  double volume[3], slack[3], depth[2][3];
  double side, det;  // det: the sum of the volumes, without its sign
} View;

static double component(Vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

static void view_make(View *out, Candidate *at, const OracleScene *scene, const OracleRay *ray)
{
  Vec3 o = ray->origin, d = ray->direction, p[3];
  double across_m[3], far_m = 0, length = vec3_length(d), volumes = 0;
  int axis = fabs(d.x) >= fabs(d.y) && fabs(d.x) >= fabs(d.z) ? 0 : fabs(d.y) >= fabs(d.z) ? 1 : 2;
  for (int i = 0; i < 3; i++) p[i] = oracle_vertex(scene, at->triangle, i);
  for (int i = 0; i < 3; i++) {
    Vec3 from = p[(i + 1) % 3], to = p[(i + 2) % 3], corner = vec3_sub(p[i], o);
    out->volume[i] = edge_volume(o, d, from, to);
    out->slack[i] = vec3_length(vec3_cross(d, vec3_sub(to, from)));
    out->depth[0][i] = vec3_dot(corner, d) / (length * length);
    out->depth[1][i] = component(corner, axis) / component(d, axis);
    across_m[i] = vec3_length(vec3_cross(d, corner)) / length;
    far_m = most(far_m, vec3_length(corner));
    volumes += out->volume[i];
  }
  at->length_m = most(far_m, ray->reach_m);
  at->unit_t = at->length_m / length;
  out->side = volumes < 0 ? -1 : 1;
  out->det = fabs(volumes);
  for (int i = 0; i < 3; i++) {
    double products = length * across_m[(i + 1) % 3] * across_m[(i + 2) % 3];
    out->slack[i] = out->slack[i] * at->length_m + PRODUCTS * products;
  }
}

// What is made of the view: the hit, how far it is from its triangle's edges, and how rounding moves it.
static void candidate_place(Candidate *at, const View *view)
{
  const double *depth = view->depth[0], *slack = view->slack, det = view->det;
  double weight[3], rest = slack[0] + slack[1] + slack[2], t = 0;
  at->inset = at->thickness = INFINITY;
  at->t_low = INFINITY;
  at->t_high = -INFINITY;
  for (int i = 0; i < 3; i++) {
    weight[i] = det > 0 ? view->side * view->volume[i] / det : 1.0 / 3;
    t += weight[i] * depth[i];
    at->t_low = least(at->t_low, least(depth[i], view->depth[1][i]));
    at->t_high = most(at->t_high, most(depth[i], view->depth[1][i]));
    if (!(slack[i] > 0)) continue;
    at->inset = least(at->inset, view->side * view->volume[i] / slack[i]);
    at->thickness = least(at->thickness, det / slack[i]);
  }
  at->t = most(at->t_low, least(at->t_high, t));
  at->u = weight[1];
  at->v = weight[2];
  at->edge = least(weight[0], least(weight[1], weight[2]));
  at->t_condition = at->u_condition = at->v_condition = INFINITY;
  if (!(det > 0)) return;
  at->t_condition = at->unit_t;
  for (int i = 0; i < 3; i++)
    at->t_condition += slack[i] * most(fabs(depth[i] - at->t), fabs(view->depth[1][i] - at->t)) / det;
  at->u_condition = (slack[1] + fabs(at->u) * (rest - 2 * slack[1])) / det;
  at->v_condition = (slack[2] + fabs(at->v) * (rest - 2 * slack[2])) / det;
}

static void candidate_measure(Candidate *out, const OracleScene *scene, const OracleRay *ray, uint32_t triangle)
{
  View view;
  uint32_t flags = scene->triangles[triangle].flags;
  *out = (Candidate){.triangle = triangle, .coverage = 1, .cover_margin = ORACLE_MARGIN_MAX};
  double margin = INFINITY;
  view_make(&view, out, scene, ray);
  candidate_place(out, &view);
  double least_volume =
      least(view.side * view.volume[0], least(view.side * view.volume[1], view.side * view.volume[2]));
  out->inside = view.det > 0 && least_volume >= 0;
  out->culled = ray->cull && (flags & ORACLE_SINGLE_SIDED) && view.side > 0;
  if (!out->inside || !(flags & ORACLE_SEE_THROUGH) || !scene->coverage) return;
  out->coverage = scene->coverage(scene, triangle, out->u, out->v, &margin);
  out->cover_margin = least(margin / most(out->u_condition, out->v_condition), ORACLE_MARGIN_MAX);
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

static bool counts(const Candidate *at, const OracleRay *ray)
{
  return at->inside && !at->culled && at->coverage > 0 && at->t > ray->t_min && at->t <= ray->t_max;
}

// How far a triangle would have to move to be hit no longer before depth `end`, or no longer after it: its plane across
// the ray, and, since a hit lies between the corners, its farthest or nearest corner along it. 0 or less where it is
// not. `condition`: of `end`, which moves as well.
static double before(const Candidate *at, double end, double condition)
{
  if (!isfinite(end)) return end > at->t ? INFINITY : -INFINITY;
  return most((end - at->t) / (at->t_condition + condition), (end - at->t_high) / at->unit_t);
}

static double after(const Candidate *at, double end, double condition)
{
  if (!isfinite(end)) return end < at->t ? INFINITY : -INFINITY;
  return most((at->t - end) / (at->t_condition + condition), (at->t_low - end) / at->unit_t);
}

// Is the hit so near to an end of the ray, `apart` from it, that it may be refused there?
static bool may_refuse(const Candidate *at, double apart, double margin)
{
  return (apart - margin * at->unit_t) * at->thickness <= margin * (at->t_high - at->t_low);
}

// How surely a hit is one, setting others aside.
static double firmness(const Candidate *at, const OracleRay *ray)
{
  double range = least(before(at, ray->t_max, 0), after(at, ray->t_min, 0));
  if (may_refuse(at, at->t - ray->t_min, ray->start_margin)) return 0;
  return least(least(at->inset, range), at->cover_margin);
}

// How far a triangle is from being a hit before `t_end` (of that condition); 0 or less where it is one.
static double remoteness(const Candidate *at, const OracleRay *ray, double t_end, double condition)
{
  double range = most(after(at, t_end, condition), before(at, ray->t_min, 0));
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
  double end = best ? best->t : ray->t_max, condition = best ? best->t_condition : 0;
  for (size_t i = 0; i < list.count; i++) {
    if (&list.items[i] == best) continue;
    out->margin = least(out->margin, most(0, remoteness(&list.items[i], ray, end, condition)));
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
      open = least(open, most(0, remoteness(at, ray, ray->t_max, 0)));
    } else {
      bool refused = isfinite(ray->t_max) && may_refuse(at, ray->t_max - at->t, ray->end_margin);
      double surely = refused ? 0 : firmness(at, ray);
      lit *= 1 - at->coverage;
      open = least(open, surely);
      if (at->coverage >= 1) firm = most(firm, surely);
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
static bool depth_agrees(const Candidate *at, double t, double rounding)
{
  double slack = rounding * at->unit_t;
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
    if (claim->triangle == ray->skip || remoteness(&at, ray, ray->t_max, 0) > rounding) return ORACLE_WRONG;
    if (!depth_agrees(&at, claim->t, rounding)) return ORACLE_WRONG;
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
