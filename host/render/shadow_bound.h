// How wrong shadow maps make a picture, told before it is rendered.
#pragma once

#include "render/frame.h"

// Shares of the picture's pixels that shadow maps put off by more than 2/255 in some displayed channel.
typedef struct ShadowBound {
  double expected, bound;
  double *lights;  // [light_count]: expected of each alone; together no less than `expected`
  uint64_t probes;
} ShadowBound;

// Sends the camera's rays through about 16 384 pixels in place of all, a few of each block of block_px x block_px, in
// the places and with the samples that the picture has, shades what they hit, and asks how sure the maps are of each
// shadow ray that is spawned, directly or by reflections (cl/shade/shadow_doubt.cl, which has the derivation). So each
// edge of a shadow counts where the camera sees it, in the cascade that is looked up there.
//
//   expected   the mean over the probes of the chance that one of their samples is wrong. A sample is wrong once:
//              lights a and b are taken to fail apart from each other, 1 - (1 - a)(1 - b); samples are added, at most
//              to 1
//   bound      f (expected + z s): s is the standard error of that mean over the probes, z = 2.576 (99 %); f = 2 for
//              SHADOWS_MAP, as an edge may lie as badly as it can all along; 1.35 for PCF and PCSS, for what is off
//              beyond the ramp: thin casters, bent surfaces; how much that is was found by trial on those pictures
//              and on `frugal stability --only projective-aliasing`. Lights of both kinds: the mean, by `lights`
//
// `frame` is made, with maps in it (SHADOW_SET_LOOKED_UP), and need not be rendered; `scale` is
// what its radiance is multiplied by for display by sRGB, INFINITY where that is not known. Where scale x what a light
// brings is under the 2/255 that show on black, or under half of it beside what other lights bring, it is not missed. A
// light that is traced, by its method or because it was left out of the maps, has no error; none is stated of one whose
// method is NONE.
//
// How good it is: boxes, shards, wires of 1 cm and balls on a floor, under a sun, a spot or a point light 0 to 75
// degrees off the normal, maps of 64 to 2048 texels, 480 pictures a method: see tests/test_shadow_bound.c.
//   method                   covered     bound / measured: median, first and last tenth
//   map, 1 sample a pixel    100 %       2.8, 2.3, 4.9
//   map, 4 samples           100 %       2.9, 2.5, 4.3
//   map, three lights        99.8 %      2.9, 2.3, 4.8
//   pcf, 1 to 7 texels       99.6 %      1.6, 1.4, 1.9
//   pcf, three lights        99.6 %      2.7, 2.0, 6.9
//   pcss                     99.4 %      2.9, 2.1, 4.4
// Of maps of less than FINER_PX finer ones are drawn and asked, 2 to 4 times the size, for PCSS of larger ones too, up
// to SHADOW_MAP_MOST_PX. By the maps alone, `map` was at 98.9 % of three lights (texels that wires happen to fill tell
// little of how many they miss), and at 98.3 % before what touches was doubted; PCSS was at 96 %, for it loses wires
// whose half-shadows are wide. What is not covered is what shadow_doubt.cl says that it misses: by `map` a pixel of one
// picture.
//
// Cost: that of 16 384 pixels twice, 10 to 20 ms on a core, those finer maps, and once a process what two kernels take
// to load. Errors: those of frame_make and frame_render.
Status shadow_bound_make(ShadowBound *out, const Frame *frame, float scale, Log *log);
void shadow_bound_free(ShadowBound *bound);
