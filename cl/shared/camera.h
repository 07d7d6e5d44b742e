// The camera as rays: pixel (x, y) with offset (a, b) looks along forward + right * X + down * Y with
// X = (crop_x + x + a) * scale - center_x (perspective), or starts at position + right * X + down * Y (orthographic).
// The axes are unit vectors in world space. Written by host/render, read by cl/rays/ray_generate.cl.
// A picture may be of several cameras (views), one view under the other: all of the same size and, but for one alone,
// of whole tiles.
#ifndef SHARED_CAMERA_H
#define SHARED_CAMERA_H

#include "shared/types.h"

typedef struct CameraInfo {
  Float3 position, right, down, forward;
  float scale;  // of a pixel: 2 tan(yfov / 2) / height, or 2 ymag / height
  float center_x, center_y;
  float near_m, far_m;  // bounds of t for camera rays
  uint width, height;   // pixels rendered
  uint crop_x, crop_y;  // of the first pixel, in the whole picture
  uint tiles_per_row;
  uint orthographic;
} CameraInfo;
SHARED_SIZE(CameraInfo, 92);

#endif
