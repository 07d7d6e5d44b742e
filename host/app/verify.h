// frugal render --verify: how far the picture is from the right one, measured at probes.
#pragma once

#include <jansson.h>

#include "app/options.h"
#include "render/reflection_bound.h"
#include "render/shadow_bound.h"
#include "report/probe_error.h"

typedef struct VerifySources {
  const RenderOptions *options;
  const SceneFacts *facts;
  Frame *frame;                   // rendered
  const PictureOptions *picture;  // with the exposure that was used
} VerifySources;

// Against the reference (settings_exact); and against the picture as it is but for its shadows, which are exact.
typedef struct VerifyResult {
  ProbeError error, shadows;
  ProbeError edges;  // `shadows`, of the pixels at the edges of exact ones (probe_edges) alone
  uint32_t probes;
  bool all;
  bool has_shadows;            // false: no shadows, or ones that differ from exact ones by noise alone
  uint32_t reference_samples;  // a pixel
  double noise;                // share of the pixels that the reference's own noise puts off
} VerifyResult;

// A reference with something random in it is the mean of as many pictures as make up VERIFY_SAMPLES samples a pixel.
// How its first half differs from the whole tells its noise: both are off by as much, on average.
enum { VERIFY_SAMPLES = 256 };

// Errors: those of rendering.
Status verify_picture(VerifyResult *out, const VerifySources *sources, Log *log);

// A line for people, with what shadow maps and those of reflections stated where that is not NULL; and what --stats
// holds (NULL when out of memory).
void verify_say(const VerifyResult *result, const ShadowBound *bound, const BoundShare *reflections, const char *path,
                Log *log);
json_t *verify_json(const VerifyResult *result);
