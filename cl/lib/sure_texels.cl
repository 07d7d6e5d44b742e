// What each texel of a light's maps knows of the triangles that may stand in the way of a ray from a point that is seen
// through it (ShadowBlock of shared/shadow.h), for both ways of drawing it. The result does not depend on the order of
// the triangles, but for entries that are less close than what covers the texel, which mean nothing.

#include "lib/lanes.cl"
#include "shared/shadow.h"

typedef struct ListRecord {
  float edge_x[3], edge_y[3], edge_0[3];
  float near_0, near_x, near_y, near_most, near_least, slack, across;
  int first_x, first_y, last_x, last_y;
  uint number, hides;
} ListRecord;

static inline ListRecord list_record(global const uint *record)
{
  ListRecord r;
  global const float *edge = (global const float *)record + SURE_EDGE, *near = (global const float *)record + SURE_NEAR;
  for (uint i = 0; i < 3; i++) {
    r.edge_x[i] = edge[3 * i];
    r.edge_y[i] = edge[3 * i + 1];
    r.edge_0[i] = edge[3 * i + 2];
  }
  r.near_0 = near[0];
  r.near_x = near[1];
  r.near_y = near[2];
  r.near_most = near[3];
  r.near_least = near[4];
  r.slack = near[5];
  r.first_x = (int)(record[SURE_TEXELS] & 0xffffu);
  r.last_x = (int)(record[SURE_TEXELS] >> 16);
  r.first_y = (int)(record[SURE_TEXELS + 1] & 0xffffu);
  r.last_y = (int)(record[SURE_TEXELS + 1] >> 16);
  r.number = record[SURE_NUMBER];
  r.hides = record[SURE_HIDES];
  r.across = as_float(record[SURE_ACROSS]);
  return r;
}

// A record's terms at texels (x, y) of any block.
typedef struct ListLanes {
  FloatL edge[3], near;
} ListLanes;

static inline ListLanes list_lanes(const ListRecord *t, FloatL x, FloatL y)
{
  ListLanes lanes;
  for (uint i = 0; i < 3; i++)
    lanes.edge[i] = x * FLOATL(t->edge_x[i]) + y * FLOATL(t->edge_y[i]) + FLOATL(t->edge_0[i]);
  lanes.near = x * FLOATL(t->near_x) + y * FLOATL(t->near_y) + FLOATL(t->near_0);
  return lanes;
}

// The terms at the block whose first texel is (x, y).
static inline ListLanes list_lanes_at(const ListLanes *lanes, const ListRecord *t, float x, float y)
{
  ListLanes at;
  for (uint i = 0; i < 3; i++) at.edge[i] = lanes->edge[i] + FLOATL(t->edge_x[i] * x + t->edge_y[i] * y);
  at.near = lanes->near + FLOATL(t->near_x * x + t->near_y * y);
  return at;
}

// Texels (x, y) of the block at `first` that the triangle may touch.
static inline IntL list_touches(const ListLanes *at, const ListRecord *t, IntL x, IntL y, int2 first)
{
  FloatL zero = FLOATL(0);
  IntL within = (x >= INTL(t->first_x - first.x)) & (x <= INTL(t->last_x - first.x)) &
                (y >= INTL(t->first_y - first.y)) & (y <= INTL(t->last_y - first.y));
  return within & (at->edge[0] >= zero) & (at->edge[1] >= zero) & (at->edge[2] >= zero);
}

// How close a triangle is everywhere in the texels that it hides all of; `covered` where it does not, or is less close.
static inline FloatL list_cover(const ListLanes *at, const ListRecord *t, IntL touched, FloatL most, FloatL covered)
{
  float within[3];
  for (uint i = 0; i < 3; i++)
    within[i] = (fabs(t->edge_x[i]) + fabs(t->edge_y[i])) * (1 + 2 * SURE_PADDING) + 2 * t->slack;
  FloatL least = min_lane(max_lane(at->near - FLOATL(t->across), FLOATL(t->near_least)), most);
  IntL covers = touched & (at->edge[0] >= FLOATL(within[0])) & (at->edge[1] >= FLOATL(within[1])) &
                (at->edge[2] >= FLOATL(within[2]));
  return (covers & (least > covered)) ? least : covered;
}

// Enters a triangle into an entry of lists, the closest first, ties by number; returns with what that displaces, or
// with what came. Lanes without a triangle are at -INFINITY, UINT_MAX.
static inline IntL list_enter(FloatL *near, UintL *number, FloatL *most, UintL *name)
{
  FloatL before = *near;
  UintL named = *number;
  IntL first = (*most > before) | ((*most == before) & (*name < named));
  *near = first ? *most : before;
  *number = first ? *name : named;
  *most = first ? before : *most;
  *name = first ? named : *name;
  return first;
}
