#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "device/device_internal.h"
#include "device/kernel_cache.h"

static const char *const no_device_hint = "install an OpenCL runtime, e.g. the package pocl-opencl-icd";

typedef struct Candidate {
  cl_platform_id platform;
  cl_device_id id;
  DeviceInfo info;
} Candidate;

const char *device_error_text(cl_int error)
{
  switch (error) {
    case CL_SUCCESS: return "CL_SUCCESS";
    case CL_DEVICE_NOT_AVAILABLE: return "CL_DEVICE_NOT_AVAILABLE";
    case CL_COMPILER_NOT_AVAILABLE: return "CL_COMPILER_NOT_AVAILABLE";
    case CL_MEM_OBJECT_ALLOCATION_FAILURE: return "CL_MEM_OBJECT_ALLOCATION_FAILURE";
    case CL_OUT_OF_RESOURCES: return "CL_OUT_OF_RESOURCES";
    case CL_OUT_OF_HOST_MEMORY: return "CL_OUT_OF_HOST_MEMORY";
    case CL_BUILD_PROGRAM_FAILURE: return "CL_BUILD_PROGRAM_FAILURE";
    case CL_INVALID_VALUE: return "CL_INVALID_VALUE";
    case CL_INVALID_MEM_OBJECT: return "CL_INVALID_MEM_OBJECT";
    case CL_INVALID_KERNEL_NAME: return "CL_INVALID_KERNEL_NAME";
    case CL_INVALID_ARG_INDEX: return "CL_INVALID_ARG_INDEX";
    case CL_INVALID_ARG_SIZE: return "CL_INVALID_ARG_SIZE";
    case CL_INVALID_KERNEL_ARGS: return "CL_INVALID_KERNEL_ARGS";
    case CL_INVALID_WORK_GROUP_SIZE: return "CL_INVALID_WORK_GROUP_SIZE";
    case CL_INVALID_BUFFER_SIZE: return "CL_INVALID_BUFFER_SIZE";
    case CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST: return "a launch before it failed";
    default: return "OpenCL error";
  }
}

static void info_string(cl_device_id id, cl_device_info key, char *out, size_t size)
{
  out[0] = 0;
  clGetDeviceInfo(id, key, size, out, NULL);
  out[size - 1] = 0;
}

static bool has_extension(cl_device_id id, const char *name)
{
  size_t size = 0;
  if (clGetDeviceInfo(id, CL_DEVICE_EXTENSIONS, 0, NULL, &size) != CL_SUCCESS) return false;
  char *list = malloc(size + 1);
  if (!list) return false;
  bool found = clGetDeviceInfo(id, CL_DEVICE_EXTENSIONS, size, list, NULL) == CL_SUCCESS && strstr(list, name);
  free(list);
  return found;
}

static void candidate_describe(Candidate *candidate)
{
  DeviceInfo *info = &candidate->info;
  cl_device_id id = candidate->id;
  info_string(id, CL_DEVICE_NAME, info->name, sizeof info->name);
  info_string(id, CL_DRIVER_VERSION, info->driver, sizeof info->driver);
  info_string(id, CL_DEVICE_VERSION, info->version, sizeof info->version);
  clGetPlatformInfo(candidate->platform, CL_PLATFORM_NAME, sizeof info->platform, info->platform, NULL);
  cl_device_type type = 0;
  clGetDeviceInfo(id, CL_DEVICE_TYPE, sizeof type, &type, NULL);
  info->is_gpu = type & CL_DEVICE_TYPE_GPU;
  info->is_pocl = strstr(info->platform, "Portable Computing Language") != NULL;
  info->int64_atomics =
      has_extension(id, "cl_khr_int64_base_atomics") && has_extension(id, "cl_khr_int64_extended_atomics");
  info->limits_registers = has_extension(id, "cl_nv_compiler_options");
  cl_ulong bytes = 0;
  clGetDeviceInfo(id, CL_DEVICE_GLOBAL_MEM_SIZE, sizeof bytes, &bytes, NULL);
  info->memory_bytes = bytes;
  clGetDeviceInfo(id, CL_DEVICE_MAX_MEM_ALLOC_SIZE, sizeof bytes, &bytes, NULL);
  info->max_buffer_bytes = bytes;
  cl_uint count = 0;
  clGetDeviceInfo(id, CL_DEVICE_MAX_COMPUTE_UNITS, sizeof count, &count, NULL);
  info->compute_units = count;
  clGetDeviceInfo(id, CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT, sizeof count, &count, NULL);
  info->vector_width = count;
}

static bool candidate_before(const Candidate *a, const Candidate *b)
{
  if (a->info.is_gpu != b->info.is_gpu) return a->info.is_gpu;
  return a->info.compute_units > b->info.compute_units;
}

static Status candidates_find(Candidate **out, uint32_t *out_count, Log *log)
{
  Status status = STATUS_OK;
  Candidate *list = NULL;
  uint32_t count = 0;
  cl_uint platform_count = 0;
  cl_platform_id platforms[32];
  kernel_cache_prepare();
  if (clGetPlatformIDs(32, platforms, &platform_count) != CL_SUCCESS) platform_count = 0;
  for (cl_uint p = 0; p < platform_count && p < 32; p++) {
    cl_device_id ids[64];
    cl_uint id_count = 0;
    if (clGetDeviceIDs(platforms[p], CL_DEVICE_TYPE_ALL, 64, ids, &id_count) != CL_SUCCESS) continue;
    for (cl_uint d = 0; d < id_count && d < 64; d++) {
      Candidate candidate = {.platform = platforms[p], .id = ids[d]};
      cl_bool available = CL_FALSE;
      clGetDeviceInfo(ids[d], CL_DEVICE_AVAILABLE, sizeof available, &available, NULL);
      if (!available) continue;
      candidate_describe(&candidate);
      Candidate *grown = realloc(list, (count + 1) * sizeof *list);
      if (!grown) {
        status = log_no_memory(log, "device list");
        goto done;
      }
      list = grown;
      uint32_t at = count++;
      for (; at > 0 && candidate_before(&candidate, &list[at - 1]); at--) list[at] = list[at - 1];
      list[at] = candidate;
    }
  }
  *out = list;
  *out_count = count;
  list = NULL;

done:
  free(list);
  return status;
}

Status device_list(DeviceInfo **out, uint32_t *count, Log *log)
{
  Status status = STATUS_OK;
  Candidate *candidates = NULL;
  uint32_t found = 0;
  TRY(candidates_find(&candidates, &found, log));
  DeviceInfo *infos = malloc((found + 1) * sizeof *infos);
  if (!infos) {
    status = log_no_memory(log, "device list");
    goto done;
  }
  for (uint32_t i = 0; i < found; i++) infos[i] = candidates[i].info;
  *out = infos;
  *count = found;

done:
  free(candidates);
  return status;
}

static bool contains_ignoring_case(const char *text, const char *part)
{
  size_t length = strlen(part);
  for (; *text; text++)
    if (strncasecmp(text, part, length) == 0) return true;
  return false;
}

static Status candidate_choose(uint32_t *out, const Candidate *list, uint32_t count, const char *choice, Log *log)
{
  if (count == 0) return log_fail(log, STATUS_NO_DEVICE, "OpenCL: no device: %s", no_device_hint);
  if (!choice || !strcmp(choice, "best")) {
    *out = 0;
    return STATUS_OK;
  }
  char *end = NULL;
  unsigned long index = strtoul(choice, &end, 10);
  bool is_index = isdigit((unsigned char)choice[0]) && *end == 0;
  for (uint32_t i = 0; i < count; i++) {
    const DeviceInfo *info = &list[i].info;
    bool match = is_index                 ? i == index
                 : !strcmp(choice, "gpu") ? info->is_gpu
                 : !strcmp(choice, "cpu") ? !info->is_gpu
                                          : contains_ignoring_case(info->name, choice);
    if (!match) continue;
    *out = i;
    return STATUS_OK;
  }
  return log_fail(log, STATUS_USAGE, "--device %s: no such device: `frugal devices` lists %u, the first is '%s'",
                  choice, count, list[0].info.name);
}

// A CPU device is the processor that this program runs on.
static bool host_has_fma(void)
{
#ifdef __x86_64__
  return __builtin_cpu_supports("fma");
#else
  return true;
#endif
}

// The one table of what differs between device classes.
static DeviceTraits traits_for(const DeviceInfo *info)
{
  // A picture of 1920 x 1080 in one wave, at half a kilobyte a ray and more where many lights shine.
  uint32_t gpu_wave_rays = info->memory_bytes >= 8ull << 30 ? 1u << 21 : 1u << 20;
  if (info->is_gpu)
    return (DeviceTraits){.lanes = 1,
                          .rays_per_item = 1,
                          .group_size = 64,
                          .wave_rays = gpu_wave_rays,
                          .lean_waves = 1,
                          .wide_bvh = false,
                          .fast_fma = true,
                          .raster_registers = info->limits_registers ? 80 : 0,
                          .lean_shade_registers = info->limits_registers ? 72 : 0};
  return (DeviceTraits){.lanes = info->vector_width >= 16 ? 16 : 8,
                        .rays_per_item = 64,
                        .group_size = 1,
                        .wave_rays = 1u << 15,  // streams stay in the cache
                        .lean_waves = 12,
                        .wide_bvh = true,
                        .fast_fma = host_has_fma()};
}

Status device_open(Device **out, const char *choice, uint32_t threads, Timeline *timeline, Log *log)
{
  Status status = STATUS_OK;
  Candidate *candidates = NULL;
  uint32_t count = 0, chosen = 0;
  cl_int error = CL_SUCCESS;
  Device *device = calloc(1, sizeof *device);
  if (!device) return log_no_memory(log, "device");
  pthread_mutex_init(&device->programs_lock, NULL);
  pthread_cond_init(&device->program_built, NULL);
  if (threads) {
    char text[16];
    snprintf(text, sizeof text, "%u", threads);
    setenv("POCL_MAX_PTHREAD_COUNT", text, 1);  // PoCL up to 3
    setenv("POCL_CPU_MAX_CU_COUNT", text, 1);   // PoCL 4 on
  }
  if (!choice) choice = getenv("FRUGAL_DEVICE");
  TRY(candidates_find(&candidates, &count, log));
  TRY(candidate_choose(&chosen, candidates, count, choice, log));
  device->info = candidates[chosen].info;
  if (device->info.is_pocl && kernel_cache_unusable())
    log_info(log, "kernel cache: %s, so kernels are compiled on each run: set POCL_CACHE_DIR", kernel_cache_unusable());
  device->platform = candidates[chosen].platform;
  device->id = candidates[chosen].id;
  device->traits = traits_for(&device->info);
  device->timeline = timeline;
  cl_device_fp_config fp = 0;
  clGetDeviceInfo(device->id, CL_DEVICE_SINGLE_FP_CONFIG, sizeof fp, &fp, NULL);
  device->exact_division = fp & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT;
  device->context = clCreateContext(NULL, 1, &device->id, NULL, NULL, &error);
  if (error == CL_SUCCESS)
    device->queue = clCreateCommandQueue(device->context, device->id, timeline ? CL_QUEUE_PROFILING_ENABLE : 0, &error);
  if (error != CL_SUCCESS) {
    status = log_fail(log, STATUS_DEVICE, "%s: cannot be opened (%s, %d): try another --device", device->info.name,
                      device_error_text(error), error);
    goto done;
  }
  *out = device;
  device = NULL;

done:
  free(candidates);
  device_close(device);
  return status;
}

void device_close(Device *device)
{
  if (!device) return;
  for (uint32_t i = 0; i < device->pending_count; i++) clReleaseEvent(device->pending[i].event);
  programs_release(device);
  if (device->queue) clReleaseCommandQueue(device->queue);
  if (device->context) clReleaseContext(device->context);
  pthread_mutex_destroy(&device->programs_lock);
  pthread_cond_destroy(&device->program_built);
  free(device);
}

const DeviceInfo *device_info(const Device *device) { return &device->info; }
const DeviceTraits *device_traits(const Device *device) { return &device->traits; }
void device_override_traits(Device *device, const DeviceTraits *traits) { device->traits = *traits; }
