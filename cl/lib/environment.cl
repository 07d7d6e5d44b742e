// The environment: radiance by direction, and light from it without visibility.

#include "lib/lanes.cl"
#include "shared/scene.h"

// A place between texel centres: columns column and column + 1, rows row and row + 1, -1 <= row < height.
typedef struct ImagePlace {
  IntL column, row;
  FloatL across, down;  // towards the second column and row, 0..1
} ImagePlace;

// Equirectangular images, u and v in [0, 1]: the centre is +X and +Z a quarter to its right; rotation about +Y.
static inline void environment_coordinates(constant EnvironmentInfo *info, Vec3L direction, FloatL *u, FloatL *v)
{
  FloatL turn_cos = FLOATL(info->cos_rotation), turn_sin = FLOATL(info->sin_rotation);
  FloatL x = turn_cos * direction.x - turn_sin * direction.z, z = turn_sin * direction.x + turn_cos * direction.z;
  FloatL y = max_lane(min_lane(direction.y, FLOATL(1)), FLOATL(-1));
  *u = atan2(z, x) * FLOATL(0.15915494f) + FLOATL(0.5f);
  *v = acos(y) * FLOATL(0.31830989f);
}

static inline ImagePlace environment_place(constant EnvironmentInfo *info, Vec3L direction)
{
  ImagePlace place;
  FloatL u, v;
  environment_coordinates(info, direction, &u, &v);
  FloatL px = u * FLOATL((float)info->width) - FLOATL(0.5f), py = v * FLOATL((float)info->height) - FLOATL(0.5f);
  FloatL left = floor(px), top = floor(py);
  place.column = LANE_CONVERT_INT(left);
  place.column = place.column < INTL(0) ? INTL((int)info->width - 1) : place.column;
  place.row = LANE_CONVERT_INT(top);
  place.across = px - left;
  place.down = py - top;
  return place;
}

// The four texels about a place, for the lanes of `mask`; others are 0. In an image of one column both columns are it.
typedef struct ImageCorners {
  Vec3L at[2][2];  // [row][column]
} ImageCorners;

static inline ImageCorners environment_corners(constant EnvironmentInfo *info, global const Float4 *pixels, IntL column,
                                               IntL row, IntL mask)
{
  ImageCorners corners;
  int width = (int)info->width, height = (int)info->height;
  for (uint i = 0; i < 4; i++) corners.at[i / 2][i % 2] = vec3l(FLOATL(0), FLOATL(0), FLOATL(0));
  for (uint bits = lane_bits(mask); bits; bits &= bits - 1) {
    uint lane = lowest_bit(bits);
    int x0 = LANE_INT(column, lane), x1 = x0 + 1 < width ? x0 + 1 : 0;
    int y0 = max(LANE_INT(row, lane), 0) * width, y1 = min(LANE_INT(row, lane) + 1, height - 1) * width;
    const int texels[4] = {y0 + x0, y0 + x1, y1 + x0, y1 + x1};
    for (uint i = 0; i < 4; i++) {
      float4 texel = vload4(texels[i], (global const float *)pixels);
      LANE_FLOAT(corners.at[i / 2][i % 2].x, lane) = texel.x;
      LANE_FLOAT(corners.at[i / 2][i % 2].y, lane) = texel.y;
      LANE_FLOAT(corners.at[i / 2][i % 2].z, lane) = texel.z;
    }
  }
  return corners;
}

static inline Vec3L mix3(Vec3L a, Vec3L b, FloatL share) { return add3(a, scale3(sub3(b, a), share)); }

static inline Vec3L corners_blend(const ImageCorners *c, FloatL across, FloatL down)
{
  return mix3(mix3(c->at[0][0], c->at[0][1], across), mix3(c->at[1][0], c->at[1][1], across), down);
}

// Radiance from unit directions. `place` receives the place in the image, where there is one.
static inline Vec3L environment_radiance_at(constant EnvironmentInfo *info, global const Float4 *pixels,
                                            Vec3L direction, IntL mask, ImagePlace *place)
{
  if (info->kind == ENVIRONMENT_KIND_IMAGE) {
    *place = environment_place(info, direction);
    ImageCorners corners = environment_corners(info, pixels, place->column, place->row, mask);
    return scale3(corners_blend(&corners, place->across, place->down), FLOATL(info->intensity));
  }
  IntL up = direction.y >= FLOATL(0);
  FloatL f = min_lane(fabs(direction.y), FLOATL(1));
  Vec3L pole = select3(up, vec3l(FLOATL(info->zenith.x), FLOATL(info->zenith.y), FLOATL(info->zenith.z)),
                       vec3l(FLOATL(info->ground.x), FLOATL(info->ground.y), FLOATL(info->ground.z)));
  Vec3L horizon = vec3l(FLOATL(info->horizon.x), FLOATL(info->horizon.y), FLOATL(info->horizon.z));
  return add3(horizon, scale3(sub3(pole, horizon), f));
}

static inline Vec3L environment_radiance(constant EnvironmentInfo *info, global const Float4 *pixels, Vec3L direction,
                                         IntL mask)
{
  ImagePlace place;
  return environment_radiance_at(info, pixels, direction, mask, &place);
}

// Sum of the harmonics at a unit direction, each band times its factor; never negative.
static inline FloatL harmonics_sum(constant Float3 *harmonics, uint channel, Vec3L d, FloatL band1, FloatL band2)
{
#define COEFFICIENT(i) FLOATL(((constant const float *)&harmonics[i])[channel])
  FloatL first = COEFFICIENT(0) * FLOATL(0.282095f);
  FloatL second = FLOATL(0.488603f) * (COEFFICIENT(1) * d.y + COEFFICIENT(2) * d.z + COEFFICIENT(3) * d.x);
  FloatL third =
      FLOATL(1.092548f) * (COEFFICIENT(4) * d.x * d.y + COEFFICIENT(5) * d.y * d.z + COEFFICIENT(7) * d.x * d.z) +
      FLOATL(0.315392f) * COEFFICIENT(6) * (FLOATL(3) * d.z * d.z - FLOATL(1)) +
      FLOATL(0.546274f) * COEFFICIENT(8) * (d.x * d.x - d.y * d.y);
#undef COEFFICIENT
  return max_lane(first + band1 * second + band2 * third, FLOATL(0));
}

// Mean radiance over all directions.
static inline Vec3L environment_mean(constant EnvironmentInfo *info)
{
  return vec3l(FLOATL(info->harmonics[0].x * 0.282095f), FLOATL(info->harmonics[0].y * 0.282095f),
               FLOATL(info->harmonics[0].z * 0.282095f));
}

// Irradiance / pi on a surface of normal n: the cosine lobe has band factors 1, 2/3, 1/4.
// From Ramamoorthi, Hanrahan, "An Efficient Representation for Irradiance Environment Maps", 2001.
static inline Vec3L environment_irradiance(constant EnvironmentInfo *info, Vec3L n)
{
  FloatL band1 = FLOATL(2.0f / 3.0f), band2 = FLOATL(0.25f);
  return vec3l(harmonics_sum(info->harmonics, 0, n, band1, band2), harmonics_sum(info->harmonics, 1, n, band1, band2),
               harmonics_sum(info->harmonics, 2, n, band1, band2));
}

// Bilinear value of an equirectangular image of one lane.
static inline float4 image_sample(global const float *pixels, int width, int height, float u, float v)
{
  float px = u * width - 0.5f, py = v * height - 0.5f, left = floor(px), top = floor(py);
  int x0 = (int)left < 0 ? width - 1 : (int)left, x1 = x0 + 1 < width ? x0 + 1 : 0;
  int y0 = max((int)top, 0) * width, y1 = min((int)top + 1, height - 1) * width;
  float4 upper = mix(vload4(y0 + x0, pixels), vload4(y0 + x1, pixels), px - left);
  return mix(upper, mix(vload4(y1 + x0, pixels), vload4(y1 + x1, pixels), px - left), py - top);
}

// Radiance about unit directions as a surface of this roughness reflects it, nothing standing before it: the images of
// shared/scene.h, and the environment's own below the least roughness that they are made for.
static inline Vec3L environment_prefiltered(constant EnvironmentInfo *info, global const Float4 *pixels,
                                            global const Float4 *levels, Vec3L direction, FloatL roughness, IntL mask)
{
  if (info->kind == ENVIRONMENT_KIND_CONSTANT)
    return vec3l(FLOATL(info->zenith.x), FLOATL(info->zenith.y), FLOATL(info->zenith.z));
  Vec3L radiance = vec3l(FLOATL(0), FLOATL(0), FLOATL(0));
  FloatL u, v;
  bool image = info->kind == ENVIRONMENT_KIND_IMAGE;
  environment_coordinates(info, direction, &u, &v);
  FloatL level = max_lane(FLOATL(-2) * log2(max_lane(roughness, FLOATL(1e-6f))), FLOATL(0));
  FloatL last = FLOATL(ENVIRONMENT_LEVELS - 1), whole = min_lane(floor(level), last);
  FloatL share = whole < last ? level - whole : FLOATL(1) - roughness * FLOATL(1 << (ENVIRONMENT_LEVELS / 2));
  for (uint bits = lane_bits(mask); bits; bits &= bits - 1) {
    uint lane = lowest_bit(bits);
    int k = (int)LANE_FLOAT(whole, lane), width = ENVIRONMENT_LEVEL_WIDTH(k);
    float x = LANE_FLOAT(u, lane), y = LANE_FLOAT(v, lane);
    float4 value = image_sample((global const float *)(levels + ENVIRONMENT_LEVEL_FIRST(k)), width, width / 2, x, y);
    k++;
    width = ENVIRONMENT_LEVEL_WIDTH(k);
    float4 next = value;
    if (k < ENVIRONMENT_LEVELS)
      next = image_sample((global const float *)(levels + ENVIRONMENT_LEVEL_FIRST(k)), width, width / 2, x, y);
    else if (image)
      next = image_sample((global const float *)pixels, (int)info->width, (int)info->height, x, y);
    value = mix(value, next, LANE_FLOAT(share, lane));
    LANE_FLOAT(radiance.x, lane) = value.x;
    LANE_FLOAT(radiance.y, lane) = value.y;
    LANE_FLOAT(radiance.z, lane) = value.z;
  }
  return image ? scale3(radiance, FLOATL(info->intensity)) : radiance;
}
