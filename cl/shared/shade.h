// What a shading launch is told besides the scene. Written by host/render, read by cl/shade.
#ifndef SHARED_SHADE_H
#define SHARED_SHADE_H

#include "shared/types.h"

#define LIGHTS_PER_LAUNCH 4  // shadow streams written by one launch

#define LIGHTING_MODEL_PBR 0u
#define LIGHTING_MODEL_PHONG 1u

// How the environment lights surfaces, in pbr.
#define ENVIRONMENT_BY_NOTHING 0u
#define ENVIRONMENT_BY_HARMONICS 1u  // as if nothing stood before it
#define ENVIRONMENT_BY_MEAN 2u       // its mean radiance, from everywhere
#define ENVIRONMENT_BY_OCCLUSION 3u  // the harmonics' light x the share of OCCLUSION_RAYS that nothing stops
#define ENVIRONMENT_BY_SAMPLES 4u    // lib/surface_samples.cl

#define OCCLUSION_RAYS 4

// Where radiance goes: to the wave's slots, or, where nothing is added later and slots are pixels, to the picture's
// sums, of which those of its first samples set what was there.
#define SHADE_TO_SLOTS 0
#define SHADE_BEGINS_PICTURE 1
#define SHADE_TO_PICTURE 2

// Segments of the environment's rays among the shadow rays, from ShadeInfo.environment_segment on; those of
// ENVIRONMENT_BY_OCCLUSION are one for each of the OCCLUSION_RAYS. ShadeInfo.environment_open is one more: rays chosen
// by the image for lobes that reflect the scene; back faces are open to them.
#define ENVIRONMENT_RAYS_LOBE 0   // chosen as the surface reflects
#define ENVIRONMENT_RAYS_IMAGE 1  // chosen by the image
#define ENVIRONMENT_SEGMENTS (OCCLUSION_RAYS + 1)

typedef struct ShadeInfo {
  uint model;                    // LIGHTING_MODEL_*
  uint first_light;              // of this launch's batch
  uint light_count;              // in the batch, 0..LIGHTS_PER_LAUNCH
  uint first_batch;              // 1: this launch adds emission, ambient and environment, and spawns reflected rays
  unsigned char casting_lights;  // bit i: light i of the batch casts shadows; of others light arrives unblocked
  unsigned char judged_lights;   // with HAS_SURE_MAPS, bit i: its sure maps judge shadow rays first
  unsigned char area_lights;     // with HAS_AREA_LIGHTS, bit i: a point of it is chosen by chance
  unsigned char reflect;         // 1: mirrors spawn rays, and rough surfaces up to max_roughness; 0: they stay dark
  uint environment_light;        // ENVIRONMENT_BY_*; pbr alone
  float ambient;                 // phong
  float min_weight;              // reflected rays below it in every channel are cut
  float min_transmitted;         // the same for what BLEND lets through
  uint primary;                  // 1: camera rays, or what BLEND let through of them: they count as coverage
  uint flat_background;          // 1: camera rays that miss see `background` in place of the environment
  Float3 background;
  float max_roughness;  // of surfaces that reflect by samples, with HAS_LOBES
  float occlusion_radius_m;
  uint environment_segment;                   // first of the environment's segments of shadow rays
  uint environment_open;                      // counted from there
  uint environment_table;                     // 1: directions are also chosen by the image
  uint random_key;                            // of seed and path
  uint receivers;                             // 1: rays that mirrors reflect say where from (RAY_FROM_MIRROR)
  uint first_tile, tile_count, first_sample;  // of the wave
  uint tiles_per_row, tile_rows;              // of the picture
  uint crop_x, crop_y;                        // as in CameraInfo
  float light_radius_m, light_sine;  // with HAS_AREA_LIGHTS: of spheres; of what directional ones subtend, halved
  unsigned char from_camera;         // 1: the rays are those of the camera, of which there is no stream
  unsigned char from_keys;           // 1: and their hits are those of raster's keys, with HAS_KEYS
  unsigned char to_picture;          // SHADE_TO_*
  unsigned char unused;
  float map_roughness;  // with HAS_ROUGH_MAPS, of surfaces for whose lobe maps are asked; 0: none
} ShadeInfo;
SHARED_SIZE(ShadeInfo, 128);

// Counters of the streams that a launch appends to: shadow rays by light of the batch, reflected rays, what BLEND lets
// through, and the environment's rays by segment; and how many shadow rays were judged, and of these how many are in a
// stream all the same: they are lit, and wait for a ray of an earlier light (t_max of 0).
#define STREAM_COUNT_REFLECTED LIGHTS_PER_LAUNCH
#define STREAM_COUNT_TRANSMITTED (LIGHTS_PER_LAUNCH + 1)
#define STREAM_COUNT_ENVIRONMENT (LIGHTS_PER_LAUNCH + 2)
#define STREAM_COUNT_JUDGED (STREAM_COUNT_ENVIRONMENT + ENVIRONMENT_SEGMENTS)
#define STREAM_COUNT_WAITING (STREAM_COUNT_JUDGED + 1)
#define STREAM_COUNTS (STREAM_COUNT_WAITING + 1)

#endif
