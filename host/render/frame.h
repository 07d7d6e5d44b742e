// Renders one view of a scene on a device by the stream ray tracer.
#pragma once

#include "device_scene/device_scene.h"
#include "passes/camera_rays.h"
#include "passes/cube_capture.h"
#include "passes/cube_doubt.h"
#include "passes/cube_reflect.h"
#include "passes/film.h"
#include "passes/hybrid_reflect.h"
#include "passes/planar.h"
#include "passes/raster_visibility.h"
#include "passes/shade.h"
#include "passes/shadow_doubt.h"
#include "passes/shadow_hybrid.h"
#include "passes/shadow_maps.h"
#include "passes/trace.h"
#include "plan/plan.h"
#include "render/kept_cubes.h"
#include "render/near_objects.h"
#include "render/reflection_sights.h"

typedef enum AovSet {
  AOV_SET_NONE = 0,
  AOV_SET_SURFACE = 1,     // the planes of shared/aov.h
  AOV_SET_SHADOW = 2,      // share of the direct light that arrives at the first hit
  AOV_SET_REFLECTION = 4,  // radiance that came by reflected rays
} AovSet;

// Called now and then with the share of the work done; `context` is the caller's.
typedef void (*FrameProgress)(void *context, double share);

typedef struct Frame Frame;

typedef struct FrameRequest {
  const Camera *camera;
  PictureArea area;
  uint32_t samples;
  Plan plan;
  bool adds;             // to what was rendered before with other seeds
  uint32_t seed;         // of samples of lobes and of the environment
  uint32_t aovs;         // of AovSet
  bool flat_background;  // camera rays that miss see this radiance in place of the environment
  float background[3];
  float
      exposure_ev;  // with which the picture will be shown, for what hybrid reflections allow; INFINITY: not known yet
  // Not NULL: not the picture is wanted but what these maps may get wrong of it, by pixels block_px as wide and high.
  ShadowDoubt *doubt;
  ReflectionSights *sights;  // the same: what mirrors reflect of it
  uint32_t block_px;
  FrameProgress progress;
  void *progress_context;
  // The frame before in a sequence, of the same device, scene and settings, or NULL: maps of what has not moved are
  // taken from it, and it is good for nothing but frame_free then.
  Frame *before;
} FrameRequest;

// Streams that can wait at once: two, save where surfaces behind each other both reflect and let through.
enum { FRAME_STREAMS = 64 };

// Which reflectors have cube maps.
typedef struct ReflectorSummary {
  uint32_t visible;                // to the camera
  uint32_t within;                 // to it by way of another one; not looked for where cubes do not answer that
  uint32_t within_alone;           // of these, not to the camera
  uint32_t unseen;                 // objects that reflect, of which neither is true
  uint32_t deep_cubes;             // of all, for what reflectors show of others
  uint32_t rough;                  // of these, those of which no mirror is seen
  uint32_t levels;                 // of all maps: prefiltered ones
  uint32_t left_out;               // without a map for want of memory
  uint32_t flat, without_gain;     // without one for hybrid reflections: flat, or rays are quicker
  double rays_ms, hybrid_ms;       // predicted for those that are not flat (plan/reflection_cost.h)
  uint32_t least_px, greatest_px;  // sizes of the maps
  uint64_t bytes;
  uint32_t faces_kept;  // of the cubes', as they were in the frame before
} ReflectorSummary;

// Device resources of a frame. Buffers grow with the wave (wave_capacity), not with the picture, save 32
// bytes a pixel for the picture itself.
struct Frame {
  Device *device;
  const DeviceScene *scene;
  FrameRequest request;
  CameraRays camera;
  RasterScene raster_scene;  // with PRIMARY_RASTER, shadow maps, cube maps or flat mirrors
  RasterVisibility raster;   // with PRIMARY_RASTER
  ShadowMaps shadow_maps;    // where the plan's shadows use them, as `shadow_hybrid`
  ShadowHybrid shadow_hybrid;
  CubeReflect cube_reflect;  // where maps answer reflected rays
  HybridReflect hybrid_reflect;
  KnownHits known_hits;  // of rays that need not be traced
  Planar planar;         // with REFLECTIONS_PLANAR
  CubeRecord cubes_drawn;
  CubeCapture cube_capture;  // while cube maps are drawn
  bool capturing;            // a wave is one of a cube map's faces, without AOVs
  NearObjects near_objects;  // where lists answer them, as `near_reflect`
  NearReflect near_reflect;
  SnapshotCapture snapshot_capture;  // while snapshots are taken
  bool photographing;                // a wave is one of a snapshot
  bool marking;                      // a wave is one of probes that mark where hybrid shadows are asked, without AOVs
  ReflectorSummary reflectors;
  Tracer tracer;
  Shader shader;
  Film film;
  RayStream streams[FRAME_STREAMS];  // rays that arrive or wait for their turn; made when first needed
  bool taken[FRAME_STREAMS];
  RayStream no_rays;        // stands for a stream that nothing is written to
  uint32_t capacity;        // of a stream
  uint32_t light_segments;  // of the shadow rays; those of the environment come after them
  RayStream shadow;
  HitStream hits;
  DeviceBuffer radiance;                             // Float4 by slot of the wave
  DeviceBuffer own_sums, unshadowed_sums, lit_sums;  // of the first hits, for AOV_SET_SHADOW
  DeviceBuffer direct_sums;                          // of all that camera rays see, for AOV_SET_REFLECTION
};

// The method of a light's shadows.
ShadowMethod frame_light_shadows(const Frame *frame, uint32_t light);

// The camera of the waves that are rendered: the picture's, or a cube map's.
const CameraRays *frame_camera(const Frame *frame);

Status frame_make(Frame *out, Device *device, const DeviceScene *scene, const FrameRequest *request, Log *log);
void frame_free(Frame *frame);

// Frees all that the next frame of a sequence could not take.
void frame_retire(Frame *frame);

// Renders all waves; the sums are then in frame->film. Errors: STATUS_DEVICE.
Status frame_render(Frame *frame, Log *log);

// Tiles of a wave of `samples` of each, of `tiles` that are left: few bins of raster lie in two waves.
uint32_t frame_wave_tiles(const Frame *frame, uint32_t tiles, uint32_t samples);

// Renders one wave into the radiance by slot: of the camera, or of the cube map that is captured.
Status frame_render_wave(Frame *frame, const Wave *wave, Log *log);

// Renders the tile in column x and row y of the picture's tiles alone, all its samples: frame->film is then complete
// there. Errors: STATUS_DEVICE.
Status frame_render_tile(Frame *frame, uint32_t x, uint32_t y, Log *log);
