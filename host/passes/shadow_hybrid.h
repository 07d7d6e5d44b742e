// Hybrid shadows: shadow rays judged by what a light's maps know for sure (cl/rays/shadow_hybrid.cl), and the rays that
// these leave unsure.
#pragma once

#include "device_scene/device_scene.h"
#include "device_scene/solid.h"
#include "passes/camera_rays.h"
#include "passes/kept_verdicts.h"
#include "passes/ray_stream.h"
#include "passes/sure_maps.h"
#include "passes/trace.h"

typedef struct ShadowHybrid {
  Kernel judge, mark;
  SureMaps maps;     // without maps a light's rays are traced
  ShadowFit *fits;   // of each light; without views, without maps
  uint64_t *probes;  // of each light: rays that marked its maps
  Solids solids;
  bool *suited;  // [light_count], to the light: its maps leave out what of them faces it
  ShadowOptions options;
  uint64_t taken_bytes;  // of options.max_bytes, by other lights' maps
  uint32_t left_out;     // lights for whose maps there was no room
  RayStream unsure;
  DeviceBuffer unsure_count;
  uint64_t rays, traced;  // of what was judged so far, by shading too
  KeptVerdicts verdicts;  // of the frame before, and for the next
  // Whom the maps were drawn for.
  CameraInfo camera;
  LightInfo *lights;  // [light_count]
  uint32_t samples;
} ShadowHybrid;

// Aims the maps of every light whose method is HYBRID, as finely as they may be drawn; `taken_bytes` of what all maps
// may take are others' (passes/shadow_maps.h). Errors: those of program_build and buffer_create.
Status shadow_hybrid_make(ShadowHybrid *out, Device *device, const DeviceScene *scene, const Plan *plan,
                          const CameraInfo *camera, uint32_t capacity, uint64_t taken_bytes, Log *log);
void shadow_hybrid_free(ShadowHybrid *hybrid);

// Marks what shadow rays of probes, the pixels of `probes`, ask of a light's maps. Errors: STATUS_DEVICE.
Status shadow_hybrid_mark(ShadowHybrid *hybrid, Device *device, const CameraRays *probes, uint32_t light,
                          const RayStream *rays, uint32_t segment, uint32_t count, Log *log);

// Whom the maps are drawn for.
typedef struct ShadowReceivers {
  const CameraInfo *camera;
  uint32_t samples;       // a pixel
  uint32_t probe_pixels;  // that each probe stood for
} ShadowReceivers;

// Draws what is marked of the maps, which so are those of one camera and one pose of the scene: rays from elsewhere are
// traced. Without a size asked for, maps become as small as suits their receivers. At most 76 bytes a texel that is
// marked, of which a CPU touches what the lists need; lights for whose maps there is no room any more are left out,
// with a warning that says how many. `before`, which may be NULL, are those of the frame before in a sequence: views
// whose map and receivers are the same, and that see nothing which moved since, get what was drawn there, which is lost
// to it; unless the trees were rebuilt, whose triangles the maps name by number. Errors: those of program_build and
// buffer_create.
Status shadow_hybrid_draw(ShadowHybrid *hybrid, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                          const ShadowReceivers *receivers, ShadowHybrid *before, Log *log);

// Takes the maps of the frame before in a sequence, whole, if all is as it was then: the pose, the lights, and for whom
// they are. False where it is not: then nothing was done, and receivers are to be marked, and maps drawn.
bool shadow_hybrid_take(ShadowHybrid *hybrid, const DeviceScene *scene, const ShadowReceivers *receivers,
                        ShadowHybrid *before);

// Makes room for verdicts on the hits of a picture's `slots` camera rays: shading takes from there those of the frame
// before whose ray is the same and whose view sees nothing that moved, and leaves its own for the next frame. From the
// second frame on of which a view stays; where there is no memory left of what maps may take, there are none. The maps
// are drawn or taken. Errors: those of buffer_create.
Status shadow_hybrid_keep(ShadowHybrid *hybrid, Device *device, uint64_t slots, ShadowHybrid *before, Log *log);

// False where nothing of a light's maps is drawn: all its rays are to be traced.
bool shadow_hybrid_has(const ShadowHybrid *hybrid, uint32_t light);

// What of the maps' verdicts is believed. What two mirrors reflect may begin within a closed surface that touches them,
// by rounding: of that only what is dark. Of rays that go all ways nothing: the maps gain nothing there. Of rays that
// shading has judged there is nothing more to know.
typedef enum HybridTrust { HYBRID_TRUST_ALL, HYBRID_TRUST_DARK, HYBRID_TRUST_NONE, HYBRID_TRUST_TOLD } HybridTrust;

// Adds the weights of rays [0, count) of segment `segment` that nothing stops on their way to light `light`: what
// trace_any does. What is not judged is traced, that of HYBRID_TRUST_ALL and _TOLD as coherent rays. Waits for the
// device to say how many rays are unsure, where they are judged. Errors: STATUS_DEVICE.
Status shadow_hybrid_trace(ShadowHybrid *hybrid, const Tracer *tracer, Device *device, const DeviceScene *scene,
                           uint32_t light, const RayStream *rays, uint32_t segment, uint32_t count,
                           const DeviceBuffer *radiance, HybridTrust trust, Log *log);
