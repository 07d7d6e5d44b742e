#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "device/device_internal.h"
#include "device/fault.h"
#include "device/kernel_source.h"

typedef struct Text {
  char *bytes;
  size_t length, capacity;
} Text;

static Status text_append(Text *text, const char *from, size_t length, Log *log)
{
  if (text->length + length + 1 > text->capacity) {
    size_t capacity = 2 * (text->length + length + 1);
    char *bytes = realloc(text->bytes, capacity);
    if (!bytes) return log_no_memory(log, "kernel source");
    text->bytes = bytes;
    text->capacity = capacity;
  }
  memcpy(text->bytes + text->length, from, length);
  text->length += length;
  text->bytes[text->length] = 0;
  return STATUS_OK;
}

enum { MAX_INCLUDES = 64 };

// An expansion in progress: the text so far and the files already in it (each goes in once, as by #pragma once).
typedef struct Expansion {
  Text text;
  char included[MAX_INCLUDES][64];
  int included_count;
} Expansion;

static Status source_from_folder(Text *out, const char *folder, const char *path, Log *log)
{
  Status status = STATUS_OK;
  char full[4096];
  snprintf(full, sizeof full, "%s/%s", folder, path);
  FILE *file = fopen(full, "rb");
  if (!file)
    return log_fail(log, STATUS_DEVICE, "%s: %s: FRUGAL_KERNELS must name a copy of cl/", full, strerror(errno));
  char block[4096];
  for (size_t n; (n = fread(block, 1, sizeof block, file)) > 0;) TRY(text_append(out, block, n, log));

done:
  fclose(file);
  return status;
}

static Status source_find(Text *out, const char *path, Log *log)
{
  const char *folder = getenv("FRUGAL_KERNELS");
  if (folder) return source_from_folder(out, folder, path, log);
  for (const KernelSource *source = kernel_sources; source->path; source++)
    if (!strcmp(source->path, path)) return text_append(out, source->text, strlen(source->text), log);
  return log_fail(log, STATUS_DEVICE, "%s: no such kernel source in this program: rebuild it", path);
}

// Appends the file with each line `#include "..."` replaced by that file.
static Status source_expand(Expansion *expansion, const char *path, Log *log)
{
  Status status = STATUS_OK;
  Text source = {0};
  for (int i = 0; i < expansion->included_count; i++)
    if (!strcmp(expansion->included[i], path)) return STATUS_OK;
  if (expansion->included_count == MAX_INCLUDES)
    return log_fail(log, STATUS_DEVICE, "%s: over %d included files: rebuild the program", path, MAX_INCLUDES);
  snprintf(expansion->included[expansion->included_count++], sizeof expansion->included[0], "%s", path);

  TRY(source_find(&source, path, log));
  char marker[160];
  snprintf(marker, sizeof marker, "#line 1 \"%s\"\n", path);
  TRY(text_append(&expansion->text, marker, strlen(marker), log));
  int number = 0;
  for (char *line = source.bytes; line && *line;) {
    char *end = strchr(line, '\n');
    size_t length = end ? (size_t)(end - line) + 1 : strlen(line);
    char included[64];
    number++;
    if (*line == '#' && sscanf(line, "#include \"%63[^\"]\"", included) == 1) {
      TRY(source_expand(expansion, included, log));
      snprintf(marker, sizeof marker, "#line %d \"%s\"\n", number + 1, path);
      TRY(text_append(&expansion->text, marker, strlen(marker), log));
    } else {
      TRY(text_append(&expansion->text, line, length, log));
    }
    line += length;
  }

done:
  free(source.bytes);
  return status;
}

static Status build_fail(Log *log, Device *device, cl_program program, const char *path, cl_int error)
{
  char build_log[900] = "";
  char *whole = NULL;
  size_t size = 0;
  if (program && clGetProgramBuildInfo(program, device->id, CL_PROGRAM_BUILD_LOG, 0, NULL, &size) == CL_SUCCESS)
    whole = malloc(size + 1);
  if (whole) {
    clGetProgramBuildInfo(program, device->id, CL_PROGRAM_BUILD_LOG, size, whole, NULL);
    whole[size] = 0;
    for (size_t end = strlen(whole); end > 0 && whole[end - 1] == '\n'; end--) whole[end - 1] = 0;
    snprintf(build_log, sizeof build_log, "%s", whole);
    free(whole);
  }
  return log_fail(log, STATUS_DEVICE, "%s: kernel build failed on %s (%s, %d): %s", path, device->info.name,
                  device_error_text(error), error, build_log[0] ? build_log : "no compiler log");
}

// Compiles one program, without the lock. PoCL's cache makes this 15 ms; a first build takes a second or two.
static Status program_compile(cl_program *out, Device *device, const char *path, const char *options, Log *log)
{
  Status status = STATUS_OK;
  Expansion expansion = {0};
  cl_int error = CL_SUCCESS;
  cl_program program = NULL;
  double begin_ms = clock_ms();
  TRY(source_expand(&expansion, path, log));

  const char *text = expansion.text.bytes;
  program = clCreateProgramWithSource(device->context, 1, &text, NULL, &error);
  if (error == CL_SUCCESS && fault_due("build")) error = CL_BUILD_PROGRAM_FAILURE;
  if (error == CL_SUCCESS) {
    struct sigaction on_abort;  // PoCL's LLVM takes it over when it first builds, and keeps it
    sigaction(SIGABRT, NULL, &on_abort);
    error = clBuildProgram(program, 1, &device->id, options, NULL, NULL);
    sigaction(SIGABRT, &on_abort, NULL);
  }
  if (error != CL_SUCCESS) {
    status = build_fail(log, device, program, path, error);
    goto done;
  }
  if (device->timeline) timeline_end(device->timeline, "build kernels", begin_ms);
  *out = program;
  program = NULL;

done:
  free(expansion.text.bytes);
  if (program) clReleaseProgram(program);
  return status;
}

// The device's program of that path and options, waiting for another thread that builds it; a new one, still to be
// built by the caller, where there is none. Called with the lock held.
static Program *program_find(Device *device, const char *path, const char *options)
{
  for (Program *program = device->programs; program; program = program->next) {
    if (strcmp(program->path, path) != 0 || strcmp(program->options, options) != 0) continue;
    if (program->program) return program;
    pthread_cond_wait(&device->program_built, &device->programs_lock);
    return program_find(device, path, options);
  }
  Program *program = calloc(1, sizeof *program);
  if (!program) return NULL;
  snprintf(program->path, sizeof program->path, "%s", path);
  snprintf(program->options, sizeof program->options, "%s", options);
  program->next = device->programs;
  device->programs = program;
  return program;
}

static void program_forget(Device *device, Program *program)
{
  Program **at = &device->programs;
  while (*at != program) at = &(*at)->next;
  *at = program->next;
  free(program);
}

// Tells the user, once, why nothing is to be seen: kernels that are in no cache take their time. Called with the lock
// held.
static void build_announce(Device *device, double ms, Log *log)
{
  const double patience_ms = 300;
  if (device->build_ms > patience_ms) return;
  device->build_ms += ms;
  if (device->build_ms > patience_ms)
    log_info(log, "%s: compiling kernels: seconds on a first run, later ones find them compiled", device->info.name);
}

void program_registers_option(char *out, size_t size, uint32_t registers)
{
  snprintf(out, size, registers ? "-cl-nv-maxrregcount=%u " : "", registers);
}

Status program_build(Program **out, Device *device, const char *path, const char *options, Log *log)
{
  Status status = STATUS_OK;
  char all_options[512];
  snprintf(all_options, sizeof all_options, "-cl-std=CL1.2 %s%s-D LANES=%u -D RAYS_PER_ITEM=%u %s",
           device->exact_division ? "-cl-fp32-correctly-rounded-divide-sqrt " : "",
           device->traits.fast_fma ? "-D FAST_FMA " : "", device->traits.lanes, device->traits.rays_per_item, options);
  pthread_mutex_lock(&device->programs_lock);
  Program *program = program_find(device, path, all_options);
  if (!program) {
    status = log_no_memory(log, "program");
    goto done;
  }
  if (!program->program) {
    cl_program compiled = NULL;
    double begin_ms = clock_thread_ms();
    pthread_mutex_unlock(&device->programs_lock);
    status = program_compile(&compiled, device, path, all_options, log);
    pthread_mutex_lock(&device->programs_lock);
    build_announce(device, clock_thread_ms() - begin_ms, log);
    program->program = compiled;
    pthread_cond_broadcast(&device->program_built);
    if (status) {
      program_forget(device, program);
      goto done;
    }
  }
  *out = program;

done:
  pthread_mutex_unlock(&device->programs_lock);
  return status;
}

void programs_release(Device *device)
{
  while (device->programs) {
    Program *program = device->programs;
    device->programs = program->next;
    if (program->program) clReleaseProgram(program->program);
    free(program);
  }
}

Status program_kernel(Kernel *out, const Program *program, const char *name, Log *log)
{
  cl_int error = CL_SUCCESS;
  cl_kernel kernel = clCreateKernel(program->program, name, &error);
  if (error != CL_SUCCESS)
    return log_fail(log, STATUS_DEVICE, "%s: no kernel %s (%s, %d): rebuild the program", program->path, name,
                    device_error_text(error), error);
  *out = (Kernel){.kernel = kernel, .name = name};
  return STATUS_OK;
}

void kernel_free(Kernel *kernel)
{
  if (kernel->kernel) clReleaseKernel(kernel->kernel);
  *kernel = (Kernel){0};
}
