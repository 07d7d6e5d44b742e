// Kernels compiled by a second process, for runs that find none in the cache. PoCL compiles under one lock, so a second
// thread is of no use; but processes share its cache of compiled kernels, where each appears whole.
//
// 4.0 s become 2.6 on two cores, for a scene of 12 k triangles with PoCL 3.1; the process itself takes 0.5 s of compute
// time to get ready.
#pragma once

#include "device_scene/device_scene.h"
#include "plan/plan.h"

// The word on the command line of this program that makes it such a process: it then calls compile_ahead_run.
#define COMPILE_AHEAD_COMMAND "compile-ahead"

// Starts this program again, to compile what a frame of such a scene and plan needs, on the device that device_open
// would open for `choice`. Whatever fails, then or later: what is not in the cache when a frame needs it is compiled by
// the frame. One process at a time, ended by compile_ahead_end. Errors: STATUS_NO_MEMORY, STATUS_USAGE (a choice too
// long, a process already there).
Status compile_ahead_start(const char *choice, const DeviceScene *features, const Plan *plan);

// Ends the process, done or not. Nothing happens without one.
void compile_ahead_end(void);

// For a signal handler that is about to end the program: async-signal-safe.
void compile_ahead_kill(void);

// The process itself: reads what to do from `input`, and ends where that does, with the process that started it.
// Kernels are launched for a scene of nothing, those first that a frame needs last: the two meet in the middle.
// Errors: STATUS_USAGE (nothing there to do), those of device_open and frame_make.
Status compile_ahead_run(int input, Log *log);
