// Opens the device and builds the kernels on a thread of its own, while the scene's images are still being decoded.
#pragma once

#include "device/device.h"
#include "device_scene/device_scene.h"
#include "plan/plan.h"

typedef struct WarmUp WarmUp;

// Starts opening the device that device_open would open; `choice` and `timeline` must outlive the warm-up. Notes go to
// the sink of `log`, from the other thread. Errors: STATUS_NO_MEMORY.
Status warm_up_start(WarmUp **out, const char *choice, uint32_t threads, Timeline *timeline, const Log *log);

// Says what the scene has and what will be done with it, as soon as that is known or can be guessed: the kernels for it
// are built meanwhile.
void warm_up_scene(WarmUp *warm_up, const Scene *scene, const Plan *plan);

// Waits until the device is open and gives it to the caller, who closes it after warm_up_end. Errors: as device_open.
Status warm_up_device(Device **out, WarmUp *warm_up, Log *log);

// Waits until the thread has ended, and closes the device if nobody took it. NULL is allowed.
void warm_up_end(WarmUp *warm_up);
