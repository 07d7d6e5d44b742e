// Which objects are left out of a cube map and kept in a list, and by which method reflected rays find each. No OpenCL
// here.
//
// An object other than the reflector is near where any part of its surface lies within a radius of the cube's centre;
// then the whole of it is, however far it reaches: an object that straddles the radius is neither cut nor there twice.
// A room about the reflector is near only if a wall, floor or ceiling of it is. What has a mirror in it is listed
// wherever it stands, for what a mirror shows changes with the place from which it is seen.
#pragma once

#include "base/log.h"
#include "plan/plan.h"
#include "scene/scene.h"

typedef enum NearMethod { NEAR_BY_RAYS, NEAR_BY_SNAPSHOT } NearMethod;

// Why an object is not photographed though the method would have it so.
typedef enum NearReason {
  NEAR_AS_ASKED,
  NEAR_MIRROR,    // it shows something else from elsewhere
  NEAR_BLEND,     // a snapshot keeps one surface
  NEAR_TOO_WIDE,  // no frustum from the centre holds the whole of it: it stands about the centre, or nearly
  NEAR_CROWDED,   // SNAPSHOTS_MOST larger ones, or nearer, are there, or the memory for maps is full
} NearReason;

// What is looked at of each object, once for all lists.
typedef struct ObjectFacts {
  Vec3 low, high;  // bounds, world space
  uint32_t triangles;
  bool drawn, mirror, blend;  // it has triangles; a material is a mirror; one is BLEND
} ObjectFacts;

typedef struct NearObject {
  uint32_t object, triangles;
  double distance_m;  // of its bounds from the centre
  NearMethod method;
  NearReason reason;
} NearObject;

// Nearest first.
typedef struct NearList {
  NearObject *objects;
  uint32_t count;
  uint32_t left_out;  // near, but over the limit: they stay in the cube map
} NearList;

// How a snapshot's camera sees an object: `forward` and two directions across it, unit vectors, and how far it reaches
// across at 1 forward.
typedef struct SnapshotFrustum {
  Vec3 forward, right, down;
  double left, top, width;  // the frustum is square
  double beyond_m;          // forward: behind the object
} SnapshotFrustum;

// Slots in a reflector's list that snapshots may take; each is tested against every reflected ray.
enum { SNAPSHOTS_MOST = 32 };

// Triangles from which `mixed` photographs an object. With a BVH no number pays on a CPU: on two cores with PoCL a ray
// from a flat mirror to a ball took 11 ns where it had 48 triangles and 90 ns where it had a million, and 0.4 us by a
// snapshot. The number is that from which a march reads less than a ray of a GPU's tree, which is a guess of its time:
// 1.5 kB for 32 strides and a search of 20 texels, as much as 24 nodes of 64 bytes, of which a ray visits two a level.
enum { COMPLEX_FROM_TRIANGLES = 4096 };

// *out is [object_count], the caller's to free. Cost: that of scene_bounds. Errors: STATUS_NO_MEMORY.
Status object_facts_make(ObjectFacts **out, const Scene *scene, Log *log);

// Lists what is near `center`, at most `triangles_most` triangles in all. Cost: a look at each triangle of objects of
// which the bounds come within the radius, until one of them does.
// Errors: STATUS_NO_MEMORY.
Status near_list_make(NearList *out, const Scene *scene, const ObjectFacts *facts, uint32_t reflector, Vec3 center,
                      double radius_m, uint64_t triangles_most, Log *log);
void near_list_free(NearList *list);

// Sets each object's method, as `reflections` has it: SNAPSHOT, CANDIDATES or MIXED, which takes snapshots from
// `complex_from` triangles on.
void near_list_choose(NearList *list, const ObjectFacts *facts, Vec3 center, ReflectionMethod reflections,
                      uint32_t complex_from);

// Fits a frustum from `center` to an object's bounds. False where that would be wider than 45 degrees from its axis
// either way, or the object is not before the centre.
bool snapshot_frustum_fit(SnapshotFrustum *out, Vec3 center, Vec3 low, Vec3 high);

// "rays" or "snapshot"; "as asked", "mirror", ...
const char *near_method_name(NearMethod method);
const char *near_reason_name(NearReason reason);
