// What the files of host/device share.
#pragma once

#include <CL/cl.h>
#include <pthread.h>

#include "device/device.h"

typedef struct PendingSpan {
  cl_event event;
  const char *sentence;
  double queued_ms;
  uint64_t items;
} PendingSpan;

// A device keeps the programs that it has built until it is closed.
struct Program {
  Program *next;
  cl_program program;           // NULL while it is being built
  char path[64], options[512];  // all that the compiler is given
};

enum { MAX_PENDING_SPANS = 512 };

struct Device {
  DeviceInfo info;
  DeviceTraits traits;
  cl_platform_id platform;
  cl_device_id id;
  cl_context context;
  cl_command_queue queue;
  bool exact_division;  // -cl-fp32-correctly-rounded-divide-sqrt is there
  Timeline *timeline;
  PendingSpan pending[MAX_PENDING_SPANS];
  uint32_t pending_count;
  pthread_mutex_t programs_lock;  // of the list and of what is NULL in it
  pthread_cond_t program_built;
  Program *programs;
  double build_ms;  // spent on them, until the user has been told
};

// Releases all of a device's programs.
void programs_release(Device *device);

// Makes room for the span of a command that is about to be queued, and says where its event goes: NULL where no
// timeline is kept. span_queued keeps the span once the command is queued. Errors: those of device_finish.
Status span_open(cl_event **out, Device *device, PendingSpan *span, const char *sentence, uint64_t items, Log *log);
void span_queued(Device *device, const PendingSpan *span);

// Text of an OpenCL error code, "CL_OUT_OF_RESOURCES" for -5.
const char *device_error_text(cl_int error);
