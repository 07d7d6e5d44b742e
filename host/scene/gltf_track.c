#include <math.h>

#include "scene/gltf_animation.h"

enum { QUATERNION = 4 };

// The last key that is not after the time; 0 where all are.
static uint32_t key_before(const GltfTrack *track, double time_s)
{
  uint32_t low = 0, high = track->key_count;
  while (high - low > 1) {
    uint32_t middle = low + (high - low) / 2;
    if (track->times_s[middle] <= time_s)
      low = middle;
    else
      high = middle;
  }
  return low;
}

static const float *value_at(const GltfTrack *track, uint32_t key)
{
  bool is_cubic = track->interpolation == INTERPOLATION_CUBIC;
  return track->values + (is_cubic ? 3ull * key + 1 : key) * track->width;
}

static void quaternion_normalize(double q[QUATERNION])
{
  double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (int c = 0; c < QUATERNION && length > 0; c++) q[c] /= length;
}

// From Shoemake, "Animating Rotation with Quaternion Curves", 1985.
static void quaternion_slerp(double out[QUATERNION], const float *from, const float *to, double share)
{
  double a[QUATERNION], b[QUATERNION], dot = 0;
  for (int c = 0; c < QUATERNION; c++) {
    a[c] = from[c];
    b[c] = to[c];
  }
  quaternion_normalize(a);
  quaternion_normalize(b);
  for (int c = 0; c < QUATERNION; c++) dot += a[c] * b[c];
  double side = dot < 0 ? -1 : 1, angle = acos(fmin(fabs(dot), 1)), sine = sin(angle);
  bool is_small = sine < 1e-6;  // a chord is as good as the arc then
  double weight_a = is_small ? 1 - share : sin((1 - share) * angle) / sine;
  double weight_b = side * (is_small ? share : sin(share * angle) / sine);
  for (int c = 0; c < QUATERNION; c++) out[c] = weight_a * a[c] + weight_b * b[c];
}

static void cubic_sample(double *out, const GltfTrack *track, uint32_t key, double share, double interval_s)
{
  const float *a = value_at(track, key), *b = value_at(track, key + 1);
  const float *leaves_a = a + track->width, *reaches_b = b - track->width;
  double t = share, t2 = t * t, t3 = t2 * t;
  for (uint32_t c = 0; c < track->width; c++)
    out[c] = (2 * t3 - 3 * t2 + 1) * a[c] + interval_s * (t3 - 2 * t2 + t) * leaves_a[c] + (3 * t2 - 2 * t3) * b[c] +
             interval_s * (t3 - t2) * reaches_b[c];
}

void gltf_track_sample(double *out, const GltfTrack *track, double time_s)
{
  uint32_t key = key_before(track, time_s);
  const float *value = value_at(track, key);
  double first_s = track->times_s[key];
  if (time_s <= first_s || key + 1 == track->key_count || track->interpolation == INTERPOLATION_STEP) {
    for (uint32_t c = 0; c < track->width; c++) out[c] = value[c];
    return;
  }
  double interval_s = track->times_s[key + 1] - first_s, share = (time_s - first_s) / interval_s;
  const float *next = value + track->width;
  if (track->interpolation == INTERPOLATION_CUBIC)
    cubic_sample(out, track, key, share, interval_s);
  else if (track->path == TRACK_ROTATION)
    quaternion_slerp(out, value, next, share);
  else
    for (uint32_t c = 0; c < track->width; c++) out[c] = value[c] + share * ((double)next[c] - value[c]);
}
