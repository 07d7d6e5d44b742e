// What the files of host/device share.
#pragma once

#include <CL/cl.h>

#include "device/device.h"

typedef struct PendingSpan {
  cl_event event;
  const char *sentence;
  double queued_ms;
  uint64_t items;
} PendingSpan;

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
};

// Text of an OpenCL error code, "CL_OUT_OF_RESOURCES" for -5.
const char *device_error_text(cl_int error);
