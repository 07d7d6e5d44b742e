#include "device/diagnose.h"

#include <ctype.h>
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "device/device_internal.h"
#include "device/kernel_cache.h"

static void __attribute__((format(printf, 2, 3))) finding_add(Diagnosis *out, const char *format, ...)
{
  if (out->count == MAX_FINDINGS) return;
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(out->findings[out->count++], sizeof out->findings[0], format, arguments);
  va_end(arguments);
}

// The first line of a file, without its end; empty where there is none.
static void line_read(char *out, size_t size, const char *path)
{
  out[0] = 0;
  FILE *file = fopen(path, "r");
  if (!file) return;
  if (!fgets(out, (int)size, file)) out[0] = 0;
  fclose(file);
  size_t length = strlen(out);
  while (length > 0 && isspace((unsigned char)out[length - 1])) out[--length] = 0;
}

static bool ends_with(const char *text, const char *end)
{
  size_t length = strlen(text), end_length = strlen(end);
  return length >= end_length && strcmp(text + length - end_length, end) == 0;
}

// Tried in a process of its own: a runtime that is loaded again after it was unloaded may end the program (PoCL's
// LLVM).
static bool library_loads(char *cause, size_t size, const char *library)
{
  int ends[2], ending = 0;
  cause[0] = 0;
  if (pipe(ends) != 0) return true;
  pid_t child = fork();
  if (child == 0) {
    if (!dlopen(library, RTLD_LAZY | RTLD_LOCAL)) {
      const char *error = dlerror();
      ssize_t written = write(ends[1], error, strlen(error));
      (void)written;
    }
    _exit(0);
  }
  close(ends[1]);
  ssize_t length = child < 0 ? 0 : read(ends[0], cause, size - 1);
  close(ends[0]);
  while (child > 0 && waitpid(child, &ending, 0) < 0 && errno == EINTR) continue;
  cause[length > 0 ? length : 0] = 0;
  if (!cause[0] && WIFSIGNALED(ending)) snprintf(cause, size, "ends the program that loads it");
  return !cause[0];
}

// A vendor file names the library of an OpenCL runtime, which the ICD loader loads.
static void vendor_check(Diagnosis *out, const char *path)
{
  char library[PATH_MAX], cause[256];
  line_read(library, sizeof library, path);
  if (!library[0]) {
    finding_add(out, "%s: names no library: install its package again", path);
    return;
  }
  if (!library_loads(cause, sizeof cause, library))
    finding_add(out, "%s: %s: install its package again, or remove the file", path, cause);
}

static void vendors_check(Diagnosis *out, const char *place)
{
  struct stat file;
  if (stat(place, &file) == 0 && !S_ISDIR(file.st_mode)) {
    vendor_check(out, place);
    return;
  }
  uint32_t count = 0;
  DIR *folder = opendir(place);
  for (struct dirent *entry; folder && (entry = readdir(folder));) {
    char path[PATH_MAX];
    if (!ends_with(entry->d_name, ".icd") || snprintf(path, sizeof path, "%s/%s", place, entry->d_name) >= PATH_MAX)
      continue;
    vendor_check(out, path);
    count++;
  }
  if (folder) closedir(folder);
  if (count == 0)
    finding_add(out,
                "%s: no OpenCL runtime is installed: install pocl-opencl-icd (any CPU); nvidia-opencl-icd, or "
                "libnvidia-compute of the driver's version on Ubuntu (NVIDIA); intel-opencl-icd (Intel GPUs); "
                "mesa-opencl-icd (AMD)",
                place);
}

static void platforms_check(Diagnosis *out)
{
  cl_platform_id platforms[MAX_FINDINGS];
  cl_uint count = 0;
  kernel_cache_prepare();
  if (clGetPlatformIDs(MAX_FINDINGS, platforms, &count) != CL_SUCCESS) return;
  for (cl_uint i = 0; i < count && i < MAX_FINDINGS; i++) {
    char *name = out->platforms[out->platform_count++];
    cl_uint devices = 0;
    clGetPlatformInfo(platforms[i], CL_PLATFORM_NAME, sizeof out->platforms[0], name, NULL);
    cl_int error = clGetDeviceIDs(platforms[i], CL_DEVICE_TYPE_ALL, 0, NULL, &devices);
    if (devices > 0) continue;
    finding_add(out, "%s: the platform has no device (%s): %s", name, device_error_text(error),
                strstr(name, "rusticl") ? "set RUSTICL_ENABLE to the driver's name"
                                        : "is the hardware there, and the user "
                                          "in the groups video and render?");
  }
}

static const struct GpuVendor {
  unsigned id;
  const char *name;
  const char *platforms[4];  // a part of the name that a platform for it has
  const char *hint;
} gpu_vendors[] = {
    {0x10de,
     "NVIDIA",
     {"NVIDIA", "rusticl", NULL},
     "install nvidia-opencl-icd, or libnvidia-compute of the driver's version on Ubuntu; where the driver is there "
     "without it, write the full path of its libnvidia-opencl.so.1 into /etc/OpenCL/vendors/nvidia.icd"},
    {0x1002, "AMD", {"AMD", "Clover", "rusticl", NULL}, "install mesa-opencl-icd, or AMD's ROCm"},
    {0x8086, "Intel", {"Intel", "Clover", "rusticl", NULL}, "install intel-opencl-icd"},
};

static bool has_platform(const Diagnosis *out, const char *const *parts)
{
  for (; *parts; parts++)
    for (uint32_t i = 0; i < out->platform_count; i++)
      if (strstr(out->platforms[i], *parts)) return true;
  return false;
}

// PCI class 03: display controllers, as /sys shows them: 0x10de, 0x030200.
static void gpus_check(Diagnosis *out, const char *place)
{
  bool told[sizeof gpu_vendors / sizeof *gpu_vendors] = {false};
  DIR *folder = opendir(place);
  for (struct dirent *entry; folder && (entry = readdir(folder));) {
    char path[PATH_MAX], text[32];
    snprintf(path, sizeof path, "%s/%s/class", place, entry->d_name);
    line_read(text, sizeof text, path);
    if (strtoul(text, NULL, 16) >> 16 != 0x03) continue;
    snprintf(path, sizeof path, "%s/%s/vendor", place, entry->d_name);
    line_read(text, sizeof text, path);
    for (size_t i = 0; i < sizeof told / sizeof *told; i++) {
      const struct GpuVendor *vendor = &gpu_vendors[i];
      if (vendor->id != strtoul(text, NULL, 16) || told[i] || has_platform(out, vendor->platforms)) continue;
      finding_add(out, "%s GPU (%s): no OpenCL for it: %s", vendor->name, entry->d_name, vendor->hint);
      told[i] = true;
    }
  }
  if (folder) closedir(folder);
}

static void permissions_check(Diagnosis *out)
{
  static const char *const files[] = {"/dev/dri/renderD128", "/dev/nvidia0", "/dev/kfd"};
  for (size_t i = 0; i < sizeof files / sizeof *files; i++)
    if (access(files[i], F_OK) == 0 && access(files[i], R_OK | W_OK) != 0)
      finding_add(out, "%s: %s: add the user to the group that owns it (video or render)", files[i], strerror(errno));
}

void device_diagnose(Diagnosis *out, const DiagnosisPlaces *places)
{
  const char *named = getenv("OCL_ICD_VENDORS");
  *out = (Diagnosis){0};
  vendors_check(out, places->vendors ? places->vendors : named && *named ? named : "/etc/OpenCL/vendors");
  platforms_check(out);
  gpus_check(out, places->pci ? places->pci : "/sys/bus/pci/devices");
  permissions_check(out);
}
