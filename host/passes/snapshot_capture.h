// Snapshot pass: cl/capture/snapshot_capture.cl.
#pragma once

#include "device_scene/device_scene.h"
#include "passes/camera_rays.h"
#include "passes/near_reflect.h"
#include "passes/trace.h"

typedef struct SnapshotCapture {
  Kernel rays, depths, keep, cells, change;
  DeviceBuffer info;         // SnapshotInfo of the snapshot that is taken
  DeviceBuffer cube;         // CubeInfo of the cube whose change is measured
  HitStream any, back;       // of rays that see either side, outwards and inwards
  DeviceScene seen, either;  // copies of the scene with a tree of the object alone; `either` has no open side
  float beyond_m;
} SnapshotCapture;

// For waves of up to `capacity` rays.
Status snapshot_capture_make(SnapshotCapture *out, Device *device, uint32_t capacity, Log *log);
void snapshot_capture_free(SnapshotCapture *capture);

// What the waves to come are of: builds the object's trees. Errors: those of part_bvh_make and buffer_create.
Status snapshot_capture_aim(SnapshotCapture *capture, Device *device, const DeviceScene *scene,
                            const SnapshotInfo *snapshot, Log *log);

// Rays of a wave, size / TILE_SIZE tiles a row.
Status snapshot_capture_rays(const SnapshotCapture *capture, Device *device, const Wave *wave, const RayStream *stream,
                             Log *log);

// Nearest hits of `rays` (slots are the identity) on the object; sets the depths of the wave's texels in `near` if it
// has their first sample. `spare` holds rays meanwhile.
Status snapshot_capture_trace(const SnapshotCapture *capture, const Tracer *tracer, Device *device, const Wave *wave,
                              const RayStream *rays, const HitStream *hits, const RayStream *spare,
                              const NearReflect *near, Log *log);

// Adds the wave's radiance, times `share`, to the texels.
Status snapshot_capture_keep(const SnapshotCapture *capture, Device *device, const Wave *wave, float share,
                             const DeviceBuffer *radiance, const NearReflect *near, Log *log);

// Fills the cells of a snapshot of `size` x `size` texels, once they are all there.
Status snapshot_capture_cells(const SnapshotCapture *capture, Device *device, uint32_t size, const NearReflect *near,
                              Log *log);

// Sets NearInfo's change and nearest_m of a cube that is drawn. Waits for the device.
Status cube_change_measure(NearInfo *near, const SnapshotCapture *capture, Device *device, const CubeInfo *cube,
                           const CubeReflect *cubes, Log *log);
