// The camera's ray through a sample of a pixel: computed in one place, so that raster and rays see the same bits.

#include "lib/lanes.cl"
#include "lib/tile.cl"

// Tiles of a picture of `view_count` views.
static inline uint2 views_tiles(constant CameraInfo *cameras, uint view_count)
{
  uint2 grid = camera_tiles(cameras);
  return (uint2)(grid.x, grid.y * view_count);
}

// What cameras see by, and the first pixel of a tile in its view.
typedef struct TileView {
  constant CameraInfo *camera;
  uint2 px;
} TileView;

static inline TileView tile_view(constant CameraInfo *cameras, uint view_count, uint tile)
{
  uint2 px = tile_at(tile, views_tiles(cameras, view_count)) * (uint)TILE_SIZE;
  uint view = view_count > 1 ? px.y / cameras->height : 0;
  TileView out = {&cameras[view], (uint2)(px.x, px.y - view * cameras->height)};
  return out;
}

// Pixels of LANES neighbouring slots, of which the first is `within` (0..63) a tile.
static inline void tile_pixels(UintL *x, UintL *y, const TileView *tile, uint within)
{
  uint2 first = tile->px + within_tile(within & ~15u);
  UintL inside = LANE_AS_UINT(INTL((int)(within & 15)) + LANE_INDEX);
  *x = UINTL(first.x) + (inside & UINTL(3));
  *y = UINTL(first.y) + (inside >> UINTL(2));
}

typedef struct CameraRay {
  Vec3L origin, direction;  // the direction has a component of 1 along the view axis
} CameraRay;

// A Float3 for all lanes. Not a function: NVIDIA's compiler copies a structure that is passed byte by byte.
#define BROADCAST3(v) vec3l(FLOATL((v).x), FLOATL((v).y), FLOATL((v).z))

// Ray through sample `offset` (0..1 from the top left) of pixels (x, y).
static inline CameraRay camera_ray(constant CameraInfo *camera, UintL x, UintL y, Float2 offset)
{
  FloatL scale = FLOATL(camera->scale);
  FloatL to_right =
      (LANE_CONVERT_FLOAT(x + UINTL(camera->crop_x)) + FLOATL(offset.x)) * scale - FLOATL(camera->center_x);
  FloatL to_down =
      (LANE_CONVERT_FLOAT(y + UINTL(camera->crop_y)) + FLOATL(offset.y)) * scale - FLOATL(camera->center_y);
  Vec3L across = add3(scale3(BROADCAST3(camera->right), to_right), scale3(BROADCAST3(camera->down), to_down));
  Vec3L position = BROADCAST3(camera->position), forward = BROADCAST3(camera->forward);
  CameraRay ray = {camera->orthographic ? add3(position, across) : position,
                   camera->orthographic ? forward : add3(forward, across)};
  return ray;
}

// Where a sample's ray ends: the far plane; below 0 (inactive) outside the picture.
static inline FloatL camera_ray_end(constant CameraInfo *camera, UintL x, UintL y)
{
  IntL visible = (x < UINTL(camera->width)) & (y < UINTL(camera->height));
  return visible ? FLOATL(camera->far_m) : FLOATL(-1);
}

// What camera rays are made from: cameras (shared/camera.h), sample positions, and the wave.
typedef struct CameraSources {
  constant CameraInfo *cameras;
  uint view_count;
  constant Float2 *offsets;
  uint first_tile, tile_count, first_sample;
} CameraSources;

// A tile of a wave at one of its samples.
typedef struct WaveTile {
  TileView view;
  Float2 offset;
} WaveTile;

// Tile and sample of a slot: x and y.
static inline uint2 wave_place(const CameraSources *from, uint slot)
{
  uint tile = slot / TILE_PIXELS, sample = 0;
  if (tile >= from->tile_count) sample = tile / from->tile_count, tile -= sample * from->tile_count;
  return (uint2)(from->first_tile + tile, from->first_sample + sample);
}

// What a slot is of.
static inline WaveTile wave_tile(const CameraSources *from, uint slot)
{
  uint2 place = wave_place(from, slot);
  WaveTile out = {tile_view(from->cameras, from->view_count, place.x), from->offsets[place.y]};
  return out;
}

// The slot of the whole picture, sample by sample, that a wave's is.
static inline uint wave_picture_slot(const CameraSources *from, uint slot)
{
  uint2 grid = views_tiles(from->cameras, from->view_count), place = wave_place(from, slot);
  return (place.y * grid.x * grid.y + place.x) * TILE_PIXELS + slot % TILE_PIXELS;
}

// The rays of LANES neighbouring slots of it.
static inline CameraRay wave_ray(FloatL *t_max, const WaveTile *tile, uint slot)
{
  UintL x, y;
  tile_pixels(&x, &y, &tile->view, slot % TILE_PIXELS);
  *t_max = camera_ray_end(tile->view.camera, x, y);
  return camera_ray(tile->view.camera, x, y, tile->offset);
}
