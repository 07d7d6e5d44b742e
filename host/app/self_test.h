// A known-answer test of a device: does it render right?
#pragma once

#include "device/device.h"

// Renders a small scene whose picture has a closed form (a wall lit by a point light, half of it in shadow, and a
// mirror that shows a glowing plane behind the camera) with the kernels of every picture: camera rays, closest and any
// hit, shading, reflection, AOVs, resolve. Compares what each pixel shows: the object exactly, its distance within
// 1e-5, its colour within 1e-4 (float rounding is some 1e-6; a device may divide and take roots with 3 ulp).
//
// Takes 0.1 s, or the time of compiling the kernels. Errors: STATUS_DEVICE, the message naming what came out where and
// what is right; those of the passes.
Status self_test(Device *device, Log *log);
