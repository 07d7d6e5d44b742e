// Marching a ray through a map of distances: a cube map, or the snapshot of one object from the cube's centre.
//
// As seen from the centre a ray runs along an arc. It is followed in strides of CUBE_STRIDE texels, texel by texel
// where a cell of the map holds something as close as the ray, and where it goes behind a surface the step is halved
// IMPOSTOR_HALVINGS times. What is looked up is the point where the ray then is, seen from the centre. (The report of
// the 2007 system says that the reflector's point is projected into the snapshot. That would show what the centre sees
// behind that point whatever the direction of the ray, so that nothing moved with the eye: it is the point that the ray
// meets.)
//
// Not sure is a ray that comes behind any of four texels that show more than one surface (silhouettes, and what they
// hide), one that starts behind a texel's surface, and one under the reflector's own outermost surface, where that is
// given. A snapshot knows its object's farthest surfaces too: what passes behind those, or outside of the picture,
// which holds the whole object, misses it for sure; what comes from there is on a side that the snapshot did not see.
//
//   Cost  4 bytes a stride, up to size / 2 of them, and 64 a texel of the way.
//   Fails where no texel saw a thing, and where the reflector shows itself from hollows of less than the slack
//         (HULL_SLACK) of the distance from its centre.
//   From  Szirmay-Kalos, Aszodi, Lazanyi, Premecz, "Approximate Ray-Tracing on the GPU with Distance Impostors", 2005;
//         Vucurevich, "Achieving Real Time Ray Tracing Effects Through GPGPU Acceleration", 2007 (snapshots).

#include "lib/cube.cl"
#include "shared/near.h"

#define IMPOSTOR_HALVINGS 8
#define IMPOSTOR_EVENNESS 0.8f
#define HULL_SLACK 0.02f

// The way of a ray as seen from the centre: towards e cos(a) + n sin(a), 0 <= a <= whole, it is met at a distance of
// reach sin(whole) / sin(whole - a). An angle is given as its cosine and sine.
typedef struct CubeArc {
  float3 e, n;
  float cosine, sine, cotangent;  // of the whole
  float reach;
  bool straight;  // away from the centre, or towards it: no arc
} CubeArc;

static inline CubeArc arc_of(CubeRay ray)
{
  CubeArc arc;
  arc.reach = length(ray.origin);
  arc.e = arc.reach > 0 ? ray.origin / arc.reach : ray.direction;
  arc.cosine = dot(arc.e, ray.direction);
  float3 across = ray.direction - arc.e * arc.cosine;
  arc.sine = length(across);
  arc.straight = arc.sine < 1e-6f;
  arc.n = across / max(arc.sine, 1e-6f);
  arc.cotangent = arc.cosine / max(arc.sine, 1e-6f);
  return arc;
}

// The angle at which the ray is after `t` metres. Angles are cosines and sines throughout: a CPU takes longer for one
// sine than for many steps.
static inline float2 arc_angle(CubeArc arc, float t)
{
  float2 whole = (float2)(arc.cosine, arc.sine), at = (float2)(arc.reach, 0) + t * whole;
  return t < INFINITY ? at * rsqrt(dot(at, at)) : whole;
}

// The other way round.
static inline float arc_distance(CubeArc arc, float2 angle)
{
  float left = arc.sine * angle.x - arc.cosine * angle.y;  // sine of what is left of the arc
  return left > 0 ? arc.reach * angle.y / left : INFINITY;
}

static inline float2 turned(float2 angle, float2 turn)
{
  return (float2)(angle.x * turn.x - angle.y * turn.y, angle.y * turn.x + angle.x * turn.y);
}

// Is an angle at `end` or beyond, by less than half a turn?
static inline bool is_past(float2 angle, float2 end) { return end.y * angle.x - end.x * angle.y <= 0; }

// A turn by an angle of no more than a fifth.
static inline float2 small_turn(float rad)
{
  float square = rad * rad;
  return (float2)(1 - square / 2 * (1 - square / 12), rad * (1 - square / 6 * (1 - square / 20)));
}

// What is marched through. One of `cube` and `snapshot` is there.
typedef struct MarchMap {
  global const CubeInfo *cube;
  global const SnapshotInfo *snapshot;
  global const float4 *texels;
  global const float *cells;
  global const float *hull;  // of a cube, or 0
  global const float *back;  // of a snapshot
  float texels_rad;
} MarchMap;

static inline MarchMap march_map_of_cube(global const CubeInfo *cube, global const float4 *texels,
                                         global const float *cells, global const float *hull)
{
  MarchMap map = {cube, 0, texels, cells, hull, 0, (float)cube->size * 0.6366198f};  // size a quarter turn
  return map;
}

#define PLACE_NOWHERE 0xffffffffu  // texel of a place that is outside of the map

static inline CubePlace snapshot_place(global const SnapshotInfo *snapshot, float3 d)
{
  float3 right = (float3)(snapshot->right.x, snapshot->right.y, snapshot->right.z);
  float3 down = (float3)(snapshot->down.x, snapshot->down.y, snapshot->down.z);
  float3 forward = (float3)(snapshot->forward.x, snapshot->forward.y, snapshot->forward.z);
  CubePlace place = {PLACE_NOWHERE, snapshot->size, 0, 0, 0, dot(d, forward)};
  float last = (float)(snapshot->size - 1);
  float x = (dot(d, right) / place.major - snapshot->left) * snapshot->texels;
  float y = (dot(d, down) / place.major - snapshot->top) * snapshot->texels;
  if (!(place.major > 0 && x >= 0 && y >= 0 && x < last && y < last)) return place;
  uint column = (uint)x, row = (uint)y, cells = snapshot->size / CUBE_CELL;
  place.across = x - (float)column;
  place.down = y - (float)row;
  place.cell = snapshot->first_texel / (CUBE_CELL * CUBE_CELL) + row / CUBE_CELL * cells + column / CUBE_CELL;
  place.texel = snapshot->first_texel + row * snapshot->size + column;
  return place;
}

static inline CubePlace map_place(const MarchMap *map, float3 d)
{
  return map->snapshot ? snapshot_place(map->snapshot, d) : cube_place(map->cube, d);
}

// Closeness of the ray at an angle of its arc; `place` receives where that is.
static inline float arc_closeness(CubePlace *place, CubeArc arc, float2 angle, const MarchMap *map)
{
  *place = map_place(map, arc.e * angle.x + arc.n * angle.y);
  return (angle.x - arc.cotangent * angle.y) / (arc.reach * place->major);
}

static inline CubeDepth map_depth(const MarchMap *map, CubePlace place)
{
  CubeDepth nothing = {0, 0, 0};
  return place.texel == PLACE_NOWHERE ? nothing : cube_depth(map->texels, place);
}

static inline float map_cell(const MarchMap *map, CubePlace place)
{
  return place.texel == PLACE_NOWHERE ? 0 : map->cells[place.cell];
}

static inline bool is_uneven(CubeDepth depth) { return depth.least < IMPOSTOR_EVENNESS * depth.most; }

// What is closer than none of it is behind the object, as far as four texels tell: less than the least of them by as
// much as they differ. *seen: none of them shows an open side.
static inline float snapshot_back(global const float *back, CubePlace place, bool *seen)
{
  global const float *upper = back + place.texel, *lower = upper + place.size;
  float4 four = (float4)(upper[0], upper[1], lower[0], lower[1]), size = fabs(four);
  float least = min(min(size.x, size.y), min(size.z, size.w)), most = least;
  most = size.x < SNAPSHOT_NO_BACK ? max(most, size.x) : most;
  most = size.y < SNAPSHOT_NO_BACK ? max(most, size.y) : most;
  most = size.z < SNAPSHOT_NO_BACK ? max(most, size.z) : most;
  most = size.w < SNAPSHOT_NO_BACK ? max(most, size.w) : most;
  *seen = all(four > 0);
  return least - (most - least) - 1e-5f * least;
}

// Where a ray is.
#define MARCH_EMPTY 0   // the texels about it show nothing, or it has just begun
#define MARCH_FRONT 1   // before all that they show
#define MARCH_BEYOND 2  // behind all of it, without having met it
#define MARCH_HIT 3     // just behind a surface that it was before
#define MARCH_UNSURE 4

// Where it is at a place, once it was in a state.
static inline int march_step(int state, const MarchMap *map, CubePlace place, float closeness)
{
  bool seen = true;
  CubeDepth depth = map_depth(map, place);
  if (map->snapshot && depth.most == 0) return MARCH_EMPTY;
  if (closeness >= depth.most) return state == MARCH_BEYOND ? MARCH_UNSURE : MARCH_FRONT;
  if (map->snapshot && closeness < snapshot_back(map->back, place, &seen))
    return state != MARCH_FRONT ? MARCH_BEYOND : is_uneven(depth) ? MARCH_UNSURE : MARCH_HIT;
  if (is_uneven(depth) || state != MARCH_FRONT) return MARCH_UNSURE;
  return closeness < depth.here ? MARCH_HIT : MARCH_FRONT;
}

typedef struct Meeting {
  CubePlace place;
  float2 angle;
} Meeting;

// The part of an arc that is followed, a texel a turn; an endless one ends infinitely far away, behind all there is.
typedef struct MarchWay {
  float2 begin, end, turn;
  bool endless;
} MarchWay;

// Looks at each of CUBE_STRIDE turns after `angle`, up to the end. HIT: *at is where.
static inline int march_stride(Meeting *at, int state, CubeArc arc, float2 angle, MarchWay way, const MarchMap *map)
{
  float2 before = angle;
  bool ends = false;
  for (int i = 1; i <= CUBE_STRIDE && state < MARCH_HIT && !ends; i++) {
    before = angle;
    angle = turned(angle, way.turn);
    ends = is_past(angle, way.end);
    if (ends) angle = way.end;
    float closeness = arc_closeness(&at->place, arc, angle, map);
    if (ends && way.endless) closeness = 0;
    state = march_step(state, map, at->place, closeness);
  }
  if (state != MARCH_HIT) return state;
  for (int k = 0; k < IMPOSTOR_HALVINGS; k++) {
    float2 middle = before + angle;
    middle *= 1 / length(middle);
    bool is_behind = arc_closeness(&at->place, arc, middle, map) < map_depth(map, at->place).here;
    before = is_behind ? before : middle;
    angle = is_behind ? middle : angle;
  }
  at->angle = angle;
  bool seen = at->place.texel != PLACE_NOWHERE;
  if (seen && map->snapshot) snapshot_back(map->back, at->place, &seen);
  return seen && !is_uneven(map_depth(map, at->place)) ? MARCH_HIT : MARCH_UNSURE;
}

// Does the ray go under the reflector's own surface after `angle` within CUBE_STRIDE turns?
static inline bool hull_is_met(CubeArc arc, float2 angle, MarchWay way, const MarchMap *map)
{
  CubePlace place;
  for (int i = 0; i < CUBE_STRIDE; i++) {
    angle = turned(angle, way.turn);
    if (is_past(angle, way.end)) return false;
    float closeness = arc_closeness(&place, arc, angle, map);
    if (hull_holds(map->hull, place, closeness, HULL_SLACK)) return true;
  }
  return false;
}

// Follows a ray. HIT: *at is where; UNSURE; else nothing was met, and at->place is that of the end.
static inline int march(Meeting *at, const MarchMap *map, CubeArc arc, MarchWay way)
{
  float2 stride = turned(turned(way.turn, way.turn), turned(way.turn, way.turn)), angle = way.begin;
  float closeness = arc_closeness(&at->place, arc, angle, map), cell = map_cell(map, at->place);
  int state = MARCH_FRONT;
  bool ends = is_past(angle, way.end) && !way.endless;
  if (closeness < cell || map->snapshot) state = march_step(MARCH_EMPTY, map, at->place, closeness);
  while (!ends && state != MARCH_UNSURE) {
    float2 next = turned(angle, stride);
    ends = is_past(next, way.end);
    if (ends) next = way.end;
    float ahead = arc_closeness(&at->place, arc, next, map), cell_ahead = map_cell(map, at->place);
    if (ends && way.endless) ahead = 0;
    if (map->hull && ahead > map->cube->hull_least && hull_is_met(arc, angle, way, map)) return MARCH_UNSURE;
    if (min(closeness, ahead) < max(cell, cell_ahead)) {
      Meeting here = {at->place, next};
      state = march_stride(&here, state, arc, angle, way, map);
      if (state == MARCH_HIT) *at = here;
      if (state == MARCH_HIT) return state;
    } else {
      state = map->snapshot && cell_ahead == 0 ? MARCH_EMPTY : MARCH_FRONT;
    }
    angle = next;
    closeness = ahead;
    cell = cell_ahead;
  }
  return state;
}

// The same for a ray that goes straight away from the centre, or towards it, up to `t_most` metres.
static inline int march_straight(CubePlace *place, float *t, const MarchMap *map, CubeArc arc, float3 direction,
                                 float t_most)
{
  *place = map_place(map, direction);
  CubeDepth depth = map_depth(map, *place);
  if (arc.cosine <= 0) return MARCH_UNSURE;
  if (depth.most == 0) return MARCH_EMPTY;
  bool seen = true;
  if (map->snapshot) snapshot_back(map->back, *place, &seen);
  if (!seen || is_uneven(depth)) return MARCH_UNSURE;
  *t = 1 / (depth.here * place->major) - arc.reach;
  return *t < 0 ? MARCH_UNSURE : *t < t_most ? MARCH_HIT : MARCH_FRONT;
}

// Where a ray meets what a map shows between t_least and t_most metres, and where a cube shows what it sees that meets
// nothing up to INFINITY.
static inline int map_meet(CubePlace *place, float *t, const MarchMap *map, CubeRay ray, CubeArc arc, float t_least,
                           float t_most)
{
  if (arc.straight) return march_straight(place, t, map, arc, ray.direction, t_most);
  Meeting at;
  MarchWay way = {(float2)(1, 0), arc_angle(arc, t_most), small_turn(1 / map->texels_rad), t_most == INFINITY};
  if (t_least > 0) {
    // A stride before it the ray is before all four texels of what begins there, however steep that is.
    float2 back = turned(turned(way.turn, way.turn), turned(way.turn, way.turn));
    way.begin = turned(arc_angle(arc, t_least), (float2)(back.x, -back.y));
    if (way.begin.y < 0) way.begin = (float2)(1, 0);
  }
  int state = march(&at, map, arc, way);
  *place = at.place;
  if (state == MARCH_HIT) *t = arc_distance(arc, at.angle);
  return state;
}
