#include "base/clock.h"
#include "device/device_internal.h"
#include "device/fault.h"

static void pending_collect(Device *device)
{
  for (uint32_t i = 0; i < device->pending_count; i++) {
    PendingSpan *span = &device->pending[i];
    cl_ulong queued = 0, begin = 0, end = 0;
    clGetEventProfilingInfo(span->event, CL_PROFILING_COMMAND_QUEUED, sizeof queued, &queued, NULL);
    clGetEventProfilingInfo(span->event, CL_PROFILING_COMMAND_START, sizeof begin, &begin, NULL);
    clGetEventProfilingInfo(span->event, CL_PROFILING_COMMAND_END, sizeof end, &end, NULL);
    timeline_add(device->timeline, (Span){
                                       .name = span->sentence,
                                       .begin_ms = span->queued_ms + 1e-6 * (double)(begin - queued),
                                       .end_ms = span->queued_ms + 1e-6 * (double)(end - queued),
                                       .items = span->items,
                                       .on_device = true,
                                   });
    clReleaseEvent(span->event);
  }
  device->pending_count = 0;
}

Status device_finish(Device *device, Log *log)
{
  cl_int error = clFinish(device->queue);
  if (error != CL_SUCCESS)
    return log_fail(log, STATUS_DEVICE, "%s: the queue failed (%s, %d): try another --device", device->info.name,
                    device_error_text(error), error);
  pending_collect(device);
  return STATUS_OK;
}

Status span_open(cl_event **out, Device *device, PendingSpan *span, const char *sentence, uint64_t items, Log *log)
{
  Status status = STATUS_OK;
  if (device->timeline && device->pending_count == MAX_PENDING_SPANS) TRY(device_finish(device, log));
  *span = (PendingSpan){.sentence = sentence, .items = items, .queued_ms = clock_ms()};
  *out = device->timeline ? &span->event : NULL;

done:
  return status;
}

void span_queued(Device *device, const PendingSpan *span)
{
  if (device->timeline) device->pending[device->pending_count++] = *span;
}

Status device_launch(Device *device, const Kernel *kernel, size_t work_items, uint64_t items, const char *sentence,
                     const KernelArg *args, size_t arg_count, Log *log)
{
  Status status = STATUS_OK;
  PendingSpan span;
  cl_event *event;
  if (work_items == 0) return STATUS_OK;
  cl_int error = fault_due("launch") ? CL_OUT_OF_RESOURCES : CL_SUCCESS;
  for (size_t i = 0; i < arg_count && error == CL_SUCCESS; i++)
    error = clSetKernelArg(kernel->kernel, (cl_uint)i, args[i].bytes, args[i].value);
  TRY(span_open(&event, device, &span, sentence, items, log));
  size_t local = device->traits.group_size;
  size_t global = (work_items + local - 1) / local * local;
  if (error == CL_SUCCESS)
    error = clEnqueueNDRangeKernel(device->queue, kernel->kernel, 1, NULL, &global, &local, 0, NULL, event);
  if (error != CL_SUCCESS) {
    status = log_fail(log, STATUS_DEVICE, "%s: kernel %s (%s) failed (%s, %d): try another --device", device->info.name,
                      kernel->name, sentence, device_error_text(error), error);
    goto done;
  }
  span_queued(device, &span);

done:
  return status;
}
