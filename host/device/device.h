// OpenCL devices, buffers, programs and launches. The only room that calls OpenCL: its types hide the handles.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/log.h"
#include "base/timeline.h"

// How kernels are compiled for a class of device: what must differ between a CPU and a GPU, in one table (device.c).
typedef struct DeviceTraits {
  uint32_t lanes;          // LANES: rays or pixels that a work-item handles in one vector
  uint32_t rays_per_item;  // RAYS_PER_ITEM: rays that a work-item loops over
  // Work-items of a work-group; one size per kernel, for ever (PoCL compiles each anew). Their rays are of one tile:
  // group_size x rays_per_item divides TILE_PIXELS.
  uint32_t group_size;
  uint32_t wave_rays;   // rays in flight: what a stream buffer holds
  uint32_t lean_waves;  // times as many where few hits send rays (plan_sends_rays); 0: once
  bool wide_bvh;        // incoherent rays walk a Bvh8
  bool fast_fma;        // FAST_FMA: fused multiply-add is one instruction
  // Of a work-item of raster, and of shading where few hits send rays, so that more are at work; 0: the compiler's.
  uint32_t raster_registers, lean_shade_registers;
} DeviceTraits;

typedef struct DeviceInfo {
  char name[128], platform[128], driver[128], version[128];
  bool is_gpu, is_pocl;
  bool int64_atomics;     // cl_khr_int64_base_atomics and cl_khr_int64_extended_atomics
  bool limits_registers;  // cl_nv_compiler_options: -cl-nv-maxrregcount
  uint64_t memory_bytes, max_buffer_bytes;
  uint32_t compute_units;
  uint32_t vector_width;  // native floats in a register
} DeviceInfo;

typedef struct Device Device;

// Lists all devices of all platforms, best first: GPUs before CPUs, larger before smaller, then platform order. The
// index in this list is what --device takes. *out is freed by the caller; a machine without OpenCL has a count of 0.
Status device_list(DeviceInfo **out, uint32_t *count, Log *log);

// Opens a device: an index of device_list, "cpu", "gpu", part of a name (case ignored), or NULL for what the
// environment variable FRUGAL_DEVICE says, else the best.
// `threads` limits a CPU device's threads (0 = all). Spans of what runs go to `timeline` when it is not NULL.
//
// Errors: STATUS_USAGE (no such device; says which there are), STATUS_NO_DEVICE, STATUS_DEVICE.
Status device_open(Device **out, const char *choice, uint32_t threads, Timeline *timeline, Log *log);
void device_close(Device *device);

const DeviceInfo *device_info(const Device *device);
const DeviceTraits *device_traits(const Device *device);

// Replaces the traits, before any program is built: for tests of the other width on one device.
void device_override_traits(Device *device, const DeviceTraits *traits);

typedef struct DeviceBuffer {
  void *memory;
  size_t bytes;
} DeviceBuffer;

// What maps of some kind may take of the device's memory: `asked`, or where that is 0 a quarter of it, at most
// `usual_most`; never more than one buffer may have.
uint64_t device_budget(const Device *device, uint64_t asked, uint64_t usual_most);

// Makes a buffer of `bytes` (an empty one becomes 4 bytes, so that it can be passed), filled from `initial` if given.
// `what` names it in messages. Errors: STATUS_NO_MEMORY, STATUS_TOO_LARGE (over the device's largest buffer).
Status buffer_create(DeviceBuffer *out, Device *device, size_t bytes, const void *initial, const char *what, Log *log);
// The same for what is written from end to end at once: on a CPU device it has huge pages, as what is filled has.
Status buffer_create_whole(DeviceBuffer *out, Device *device, size_t bytes, const char *what, Log *log);
// The same filled from memory that free() frees, best a large_array: on a CPU device it becomes the buffer's own.
// Whatever comes of it, the memory is the caller's no more.
Status buffer_adopt(DeviceBuffer *out, Device *device, size_t bytes, void *memory, const char *what, Log *log);
void buffer_free(DeviceBuffer *buffer);

// Makes a buffer of at least `bytes` anew where the one at hand is smaller: what was in it is gone. Errors: those of
// buffer_create. buffer_put then copies to its start.
Status buffer_reserve(DeviceBuffer *buffer, Device *device, size_t bytes, const char *what, Log *log);
Status buffer_put(DeviceBuffer *buffer, Device *device, size_t bytes, const void *from, const char *what, Log *log);

// Copies to the start of the buffer; waits for the queue unless `bytes` is a power of two up to 128.
Status buffer_write(Device *device, DeviceBuffer *buffer, const void *from, size_t bytes, Log *log);

// Queues a copy to `offset` bytes from the start of the buffer: `from` must stay as it is until device_finish.
Status buffer_write_part(Device *device, const DeviceBuffer *buffer, size_t offset, const void *from, size_t bytes,
                         Log *log);
Status buffer_zero(Device *device, DeviceBuffer *buffer, Log *log);

// Sets every 32-bit word of the buffer. Errors: STATUS_DEVICE.
Status buffer_fill_words(Device *device, DeviceBuffer *buffer, uint32_t word, Log *log);
// Words [first, first + count) alone.
Status buffer_fill_part(Device *device, const DeviceBuffer *buffer, size_t first, size_t count, uint32_t word,
                        Log *log);

// Queues a copy of `count` 32-bit words from one buffer to another. Errors: STATUS_DEVICE.
Status buffer_copy_words(Device *device, const DeviceBuffer *from, size_t from_first, const DeviceBuffer *to,
                         size_t to_first, size_t count, Log *log);

// Waits for all launches before it, then copies `bytes` from the start of the buffer, or from `offset` bytes after it.
Status buffer_read(Device *device, const DeviceBuffer *buffer, void *to, size_t bytes, Log *log);
Status buffer_read_part(Device *device, const DeviceBuffer *buffer, size_t offset, void *to, size_t bytes, Log *log);

// What a buffer holds, to be looked at here: where it lies on a CPU device, elsewhere a copy.
typedef struct BufferView {
  void *data;  // not to be written
  void *copy, *memory;
  Device *device;
} BufferView;

// Waits for all launches before it; the buffer must be there, and nobody write to it, until buffer_view_close. `what`
// names it in messages. Errors: STATUS_DEVICE, STATUS_NO_MEMORY.
Status buffer_view_open(BufferView *out, Device *device, const DeviceBuffer *buffer, const char *what, Log *log);
void buffer_view_close(BufferView *view);

typedef struct Program Program;

typedef struct Kernel {
  void *kernel;
  const char *name;
} Kernel;

// Builds the embedded source `path` ("rays/trace_packet.cl") with its includes expanded and `options` ("-D X=1 ...")
// added to those of the device. FRUGAL_KERNELS=DIR reads sources from that folder instead of the program.
// The device keeps its programs until it is closed: a second call of the same is free, and one from another thread
// waits for the first. Errors: STATUS_DEVICE with the compiler's log.
Status program_build(Program **out, Device *device, const char *path, const char *options, Log *log);
Status program_kernel(Kernel *out, const Program *program, const char *name, Log *log);
void kernel_free(Kernel *kernel);

typedef struct KernelArg {
  size_t bytes;
  const void *value;
} KernelArg;

#define ARG(value) ((KernelArg){sizeof(value), &(value)})
#define ARG_BUFFER(buffer) ((KernelArg){sizeof(void *), &(buffer).memory})
#define ARGS(...) (const KernelArg[]){__VA_ARGS__}, sizeof((KernelArg[]){__VA_ARGS__}) / sizeof(KernelArg)

// An option for program_build that limits the registers of a work-item; nothing for 0.
void program_registers_option(char *out, size_t size, uint32_t registers);

// Queues `work_items` work-items of a kernel (rounded up to whole work-groups: kernels check their index), after
// everything queued before. `items` is what the profile counts, `sentence` (static) what it says.
Status device_launch(Device *device, const Kernel *kernel, size_t work_items, uint64_t items, const char *sentence,
                     const KernelArg *args, size_t arg_count, Log *log);

// Waits until everything queued has run, and moves the finished launches into the timeline.
Status device_finish(Device *device, Log *log);
