// The shade kernel on rays and hits made by hand.
#pragma once

#include "passes/shade.h"
#include "shared/stream.h"
#include "support/oracle_surface.h"
#include "support/picture_fixture.h"

enum { LAB_CAPACITY = 4096, LAB_WIDTHS = 3 };

// LANES that a test goes through: 16, 8, 1.
extern const uint32_t lab_widths[LAB_WIDTHS];

// The unit vector at this cosine from +Z.
Vec3 lab_polar(double cosine, double azimuth_rad);

// A ray that has hit a point of a triangle.
typedef struct LabHit {
  uint32_t triangle;  // HIT_NONE: it has left the scene
  float u, v;
  float direction[3];  // of any length
  float weight[3];     // throughput
} LabHit;

// A ray of a stream as the kernels left it.
typedef struct LabRay {
  float origin[3], direction[3], t_max, weight[3];
  float density;  // RAY_DENSITY; 0 in streams that have none
  uint32_t slot;
} LabRay;

typedef struct ShadeLab {
  Device *device;
  DeviceScene scene;
  Plan plan;
  Shader shader;
  RayStream rays, shadow, onward[2];
  HitStream hits;
  DeviceBuffer radiance;
  uint32_t count;
  uint32_t counts[STREAM_COUNTS];  // of the last launch
} ShadeLab;

// For a plan that lights by the environment's harmonics, or another one.
ShadeLab lab_open(const Scene *scene, uint32_t lanes);
ShadeLab lab_open_planned(const Scene *scene, const Plan *plan, uint32_t lanes);
void lab_close(ShadeLab *lab);

// Sets the rays, at most LAB_CAPACITY. Ray i adds to slot count - 1 - i.
void lab_set_hits(ShadeLab *lab, const LabHit *hits, uint32_t count);

// Shades them into radiance that begins as zero. out: [count], by ray; NULL for none of it.
void lab_shade(float (*out)[4], ShadeLab *lab, const ShadeInfo *info);

// Further launches add to the same radiance, which is read at the end.
void lab_begin(ShadeLab *lab);
void lab_add(ShadeLab *lab, const ShadeInfo *info);
void lab_end(float (*out)[4], ShadeLab *lab);

// The last launch's shadow rays of light `light` of its batch, reflected rays, and rays that BLEND lets through; as
// many as `counts` says. The caller frees them.
LabRay *lab_shadow_rays(ShadeLab *lab, uint32_t light);
LabRay *lab_reflected_rays(ShadeLab *lab);
LabRay *lab_environment_rays(ShadeLab *lab, uint32_t segment);  // of ENVIRONMENT_RAYS_*, where environment_segment is 0
LabRay *lab_transmitted_rays(ShadeLab *lab);

// Ray i of the slot that a LabRay adds to.
uint32_t lab_ray_of_slot(const ShadeLab *lab, uint32_t slot);

// The same hit for the oracle: its point, and (not NULL) the unit vector to the viewer.
OraclePoint lab_oracle_point(const OracleScene *scene, const LabHit *hit, Vec3 *view);
