#include "render/list_bound.h"

#include <math.h>
#include <stdlib.h>

#include "render/near_objects.h"

static Vec3 wide(Float3 v) { return vec3((double)v.x, (double)v.y, (double)v.z); }

void list_bound_free(ListBound *bound)
{
  for (uint32_t o = 0; o < bound->object_count; o++) {
    if (bound->lists) near_list_free(&bound->lists[o]);
    if (bound->texels) free(bound->texels[o]);
  }
  free(bound->lists);
  free(bound->texels);
  *bound = (ListBound){0};
}

// A texel of an object's snapshot, in texels of the cube at the middle of a face.
static double snapshot_texel(const ObjectFacts *object, const CubeInfo *cube)
{
  SnapshotFrustum frustum;
  if (!snapshot_frustum_fit(&frustum, wide(cube->center), object->low, object->high)) return 1;
  uint32_t size = snapshot_size_px(frustum.width, cube->size);
  return frustum.width / (size - 1.0 - 2 * SNAPSHOT_MARGIN_PX) * 0.5 * (cube->size - 1.0);
}

static Status reflector_list(ListBound *out, const Frame *frame, const CubeInfo *cube, const ObjectFacts *facts,
                             Log *log)
{
  const CubeOptions *options = &frame->request.plan.cubes;
  const ObjectFacts *reflector = &facts[cube->object];
  NearList *list = &out->lists[cube->object];
  Status status = near_list_make(list, frame->scene->source, facts, cube->object, wide(cube->center),
                                 near_objects_radius_m(options, reflector), UINT32_MAX, log);
  if (status) return status;
  near_list_choose(list, facts, wide(cube->center), REFLECTIONS_SNAPSHOT, out->complex_from);
  double *texels = out->texels[cube->object] = malloc((list->count + 1) * sizeof *texels);
  if (!texels) return log_no_memory(log, "reflection bound");
  for (uint32_t i = 0; i < list->count; i++) texels[i] = snapshot_texel(&facts[list->objects[i].object], cube);
  return STATUS_OK;
}

Status list_bound_make(ListBound *out, const Frame *frame, const CubeInfo *cubes, Log *log)
{
  Status status = STATUS_OK;
  const uint32_t objects = frame->scene->object_count, complex_from = frame->request.plan.cubes.complex_from;
  ObjectFacts *facts = NULL;
  *out = (ListBound){.lists = calloc(objects + 1, sizeof *out->lists),
                     .texels = calloc(objects + 1, sizeof *out->texels),
                     .object_count = objects,
                     .complex_from = complex_from ? complex_from : COMPLEX_FROM_TRIANGLES};
  if (!out->lists || !out->texels) return log_no_memory(log, "reflection bound");
  TRY(object_facts_make(&facts, frame->scene->source, log));
  for (uint32_t o = 0; o < objects; o++)
    if (cubes[o].size) TRY(reflector_list(out, frame, &cubes[o], facts, log));

done:
  free(facts);
  return status;
}

// How a rung finds what a ray meets.
typedef enum Finder { BY_CUBE, BY_PHOTO, BY_RAYS } Finder;

// *texel: of what is photographed, in texels of the cube.
static Finder finder_of(double *texel, const ListBound *bound, uint32_t reflector, uint32_t met, int rung)
{
  const NearList *list = &bound->lists[reflector];
  *texel = 1;
  if (met == reflector) return BY_RAYS;
  for (uint32_t i = 0; i < list->count; i++) {
    const NearObject *near = &list->objects[i];
    if (near->object != met) continue;
    bool photo = rung == BOUND_SNAPSHOT || (rung == BOUND_MIXED && near->triangles >= bound->complex_from);
    if (!photo || near->method != NEAR_BY_SNAPSHOT) return BY_RAYS;
    *texel = bound->texels[reflector][i];
    return BY_PHOTO;
  }
  return BY_CUBE;
}

static double rung_wrong(const ListBound *bound, uint32_t reflector, uint32_t met, const ProbeEdge *edges,
                         int edge_count, int rung, double outline_share, double threshold)
{
  double own_texel, other_texel, swept = 0, smooth = 0;
  Finder own = finder_of(&own_texel, bound, reflector, met, rung);
  for (int k = 0; k < edge_count; k++) {
    const ProbeEdge *edge = &edges[k];
    if (!edge->is_there) continue;
    Finder other = finder_of(&other_texel, bound, reflector, edge->met, rung);
    bool apart = own != other || (own == BY_PHOTO && met != edge->met);
    double share = edge->outline || apart ? outline_share : 1;
    double own_px = own == BY_RAYS ? 0 : own_texel * edge->own_px;
    double other_px = other == BY_RAYS ? 0 : other_texel * edge->other_px;
    if (edge->weight == 0)
      smooth += edge->change * own_px;
    else if (own != BY_RAYS && other != BY_RAYS)
      swept += edge->weight * share * fmax(own_px, other_px);
  }
  return swept > 0 ? swept : smooth > threshold;
}

void list_bound_wrong(double wrong[BOUND_RUNGS], const ListBound *bound, uint32_t reflector, uint32_t met,
                      const ProbeEdge *edges, int edge_count, double outline_share, double threshold)
{
  static const int rungs[] = {BOUND_SNAPSHOT, BOUND_CANDIDATES, BOUND_MIXED};
  for (size_t i = 0; i < sizeof rungs / sizeof *rungs; i++)
    wrong[rungs[i]] = rung_wrong(bound, reflector, met, edges, edge_count, rungs[i], outline_share, threshold);
  wrong[BOUND_PLANAR] = wrong[BOUND_HYBRID] = 0;
}

double list_bound_stated(int rung, double bound, double share)
{
  bool photos = rung == BOUND_SNAPSHOT || rung == BOUND_MIXED;
  double stated = photos ? PHOTO_FACTOR * bound + PHOTO_SHARE * share : bound;
  return fmin(stated + EXACT_SHARE * share, fmax(bound, share));
}
