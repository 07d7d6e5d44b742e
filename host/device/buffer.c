#include <stdlib.h>

#include "base/large_array.h"
#include "device/device_internal.h"
#include "device/fault.h"

enum { LEAST_ADOPTED = 65536 };  // bytes that are worth it

static Status buffer_fail(Log *log, Device *device, const char *what, size_t bytes, cl_int error)
{
  bool memory = error == CL_MEM_OBJECT_ALLOCATION_FAILURE || error == CL_OUT_OF_RESOURCES ||
                error == CL_OUT_OF_HOST_MEMORY || error == CL_INVALID_BUFFER_SIZE;
  return log_fail(log, memory ? STATUS_NO_MEMORY : STATUS_DEVICE,
                  "%s: %.1f MB for %s failed (%s, %d): use a smaller scene or picture, or another --device",
                  device->info.name, 1e-6 * (double)bytes, what, device_error_text(error), error);
}

// CL_OUT_OF_RESOURCES here is no lack of memory: drivers report by it that an earlier launch has crashed.
static Status transfer_fail(Log *log, Device *device, const char *what, cl_int error)
{
  return log_fail(log, STATUS_DEVICE, "%s: %s failed (%s, %d): try another --device", device->info.name, what,
                  device_error_text(error), error);
}

uint64_t device_budget(const Device *device, uint64_t asked, uint64_t usual_most)
{
  uint64_t quarter = device->info.memory_bytes / 4, most = asked;
  if (!asked) most = quarter < usual_most ? quarter : usual_most;
  return most < device->info.max_buffer_bytes ? most : device->info.max_buffer_bytes;
}

static void CL_CALLBACK memory_free(cl_mem buffer, void *memory) { free(memory); }

static bool is_cpu(const Device *device) { return device->info.is_pocl && !device->info.is_gpu; }

// A buffer in memory that it frees in the end. NULL, and the memory is as it was, where there can be none.
static cl_mem memory_adopt(Device *device, size_t bytes, void *memory)
{
  cl_int error;
  if (!memory) return NULL;
  cl_mem buffer = clCreateBuffer(device->context, CL_MEM_READ_WRITE | CL_MEM_USE_HOST_PTR, bytes, memory, &error);
  if (buffer && clSetMemObjectDestructorCallback(buffer, memory_free, memory) == CL_SUCCESS) return buffer;
  if (buffer) clReleaseMemObject(buffer);
  return NULL;
}

// On a CPU device what is large and `dense`, written from end to end, lies in huge pages: most of what such buffers
// take is page faults. Others would take up memory that nobody asks for.
static cl_mem memory_create(Device *device, size_t bytes, bool dense, cl_int *error)
{
  void *pages = dense && is_cpu(device) && has_huge_pages(bytes) ? large_array(bytes, 1) : NULL;
  cl_mem adopted = memory_adopt(device, bytes, pages);
  if (adopted) return adopted;
  free(pages);
  return clCreateBuffer(device->context, CL_MEM_READ_WRITE, bytes, NULL, error);
}

static Status buffer_make(DeviceBuffer *out, Device *device, size_t bytes, bool dense, const void *initial,
                          const char *what, Log *log)
{
  if (bytes > device->info.max_buffer_bytes)
    return log_fail(log, STATUS_TOO_LARGE,
                    "%s: %.1f MB for %s are over the largest buffer of %.1f MB: use another --device",
                    device->info.name, 1e-6 * (double)bytes, what, 1e-6 * (double)device->info.max_buffer_bytes);
  bool copy = initial && bytes > 0;
  size_t allocated = bytes > 4 ? bytes : 4;
  cl_int error = CL_SUCCESS;
  cl_mem memory = NULL;
  if (fault_due("buffer"))
    error = CL_MEM_OBJECT_ALLOCATION_FAILURE;
  else
    memory = memory_create(device, allocated, dense, &error);
  if (error == CL_SUCCESS && copy)
    error = clEnqueueWriteBuffer(device->queue, memory, CL_TRUE, 0, bytes, initial, 0, NULL, NULL);
  if (error != CL_SUCCESS) {
    if (memory) clReleaseMemObject(memory);
    return buffer_fail(log, device, what, bytes, error);
  }
  *out = (DeviceBuffer){.memory = memory, .bytes = bytes};
  return STATUS_OK;
}

Status buffer_create(DeviceBuffer *out, Device *device, size_t bytes, const void *initial, const char *what, Log *log)
{
  return buffer_make(out, device, bytes, initial != NULL, initial, what, log);
}

Status buffer_create_whole(DeviceBuffer *out, Device *device, size_t bytes, const char *what, Log *log)
{
  return buffer_make(out, device, bytes, true, NULL, what, log);
}

Status buffer_adopt(DeviceBuffer *out, Device *device, size_t bytes, void *memory, const char *what, Log *log)
{
  const bool fits = is_cpu(device) && bytes >= LEAST_ADOPTED && bytes <= device->info.max_buffer_bytes &&
                    (uintptr_t)memory % ARRAY_ALIGNMENT == 0;
  Status status = STATUS_OK;
  cl_mem adopted = NULL;
  if (fits && fault_due("buffer"))
    status = buffer_fail(log, device, what, bytes, CL_MEM_OBJECT_ALLOCATION_FAILURE);
  else if (fits)
    adopted = memory_adopt(device, bytes, memory);
  if (adopted) {
    *out = (DeviceBuffer){.memory = adopted, .bytes = bytes};
    return STATUS_OK;
  }
  if (!status) status = buffer_create(out, device, bytes, memory, what, log);
  free(memory);
  return status;
}

Status buffer_reserve(DeviceBuffer *buffer, Device *device, size_t bytes, const char *what, Log *log)
{
  if (buffer->memory && buffer->bytes >= bytes) return STATUS_OK;
  buffer_free(buffer);
  return buffer_make(buffer, device, bytes, false, NULL, what, log);
}

Status buffer_put(DeviceBuffer *buffer, Device *device, size_t bytes, const void *from, const char *what, Log *log)
{
  Status status = buffer_reserve(buffer, device, bytes, what, log);
  return status == STATUS_OK ? buffer_write(device, buffer, from, bytes, log) : status;
}

void buffer_free(DeviceBuffer *buffer)
{
  if (buffer->memory) clReleaseMemObject(buffer->memory);
  *buffer = (DeviceBuffer){0};
}

// A pattern to fill with is copied when it is queued: what fits into the largest one need not wait for the queue.
static bool is_pattern(size_t bytes) { return bytes <= 128 && (bytes & (bytes - 1)) == 0; }

Status buffer_write(Device *device, DeviceBuffer *buffer, const void *from, size_t bytes, Log *log)
{
  if (bytes == 0) return STATUS_OK;
  cl_int error = is_pattern(bytes)
                     ? clEnqueueFillBuffer(device->queue, buffer->memory, from, bytes, 0, bytes, 0, NULL, NULL)
                     : clEnqueueWriteBuffer(device->queue, buffer->memory, CL_TRUE, 0, bytes, from, 0, NULL, NULL);
  return error == CL_SUCCESS ? STATUS_OK : transfer_fail(log, device, "a transfer to it", error);
}

Status buffer_write_part(Device *device, const DeviceBuffer *buffer, size_t offset, const void *from, size_t bytes,
                         Log *log)
{
  if (bytes == 0) return STATUS_OK;
  cl_int error = clEnqueueWriteBuffer(device->queue, buffer->memory, CL_FALSE, offset, bytes, from, 0, NULL, NULL);
  return error == CL_SUCCESS ? STATUS_OK : transfer_fail(log, device, "a transfer to it", error);
}

Status buffer_zero(Device *device, DeviceBuffer *buffer, Log *log) { return buffer_fill_words(device, buffer, 0, log); }

Status buffer_fill_words(Device *device, DeviceBuffer *buffer, uint32_t word, Log *log)
{
  return buffer_fill_part(device, buffer, 0, buffer->bytes / sizeof word, word, log);
}

Status buffer_fill_part(Device *device, const DeviceBuffer *buffer, size_t first, size_t count, uint32_t word, Log *log)
{
  Status status = STATUS_OK;
  PendingSpan span;
  cl_event *event;
  if (count == 0) return STATUS_OK;
  size_t pattern = word == (word & 0xff) * 0x01010101u ? 1 : sizeof word;  // bytes are set the quickest
  TRY(span_open(&event, device, &span, "clear buffers", count, log));
  cl_int error = clEnqueueFillBuffer(device->queue, buffer->memory, &word, pattern, first * sizeof word,
                                     count * sizeof word, 0, NULL, event);
  if (error != CL_SUCCESS) return transfer_fail(log, device, "filling a buffer", error);
  span_queued(device, &span);

done:
  return status;
}

Status buffer_copy_words(Device *device, const DeviceBuffer *from, size_t from_first, const DeviceBuffer *to,
                         size_t to_first, size_t count, Log *log)
{
  if (count == 0) return STATUS_OK;
  const size_t word = sizeof(uint32_t);
  cl_int error = clEnqueueCopyBuffer(device->queue, from->memory, to->memory, from_first * word, to_first * word,
                                     count * word, 0, NULL, NULL);
  return error == CL_SUCCESS ? STATUS_OK : transfer_fail(log, device, "a copy within it", error);
}

Status buffer_read(Device *device, const DeviceBuffer *buffer, void *to, size_t bytes, Log *log)
{
  return buffer_read_part(device, buffer, 0, to, bytes, log);
}

static Status read_check(Device *device, cl_int error, void *read, size_t bytes, Log *log)
{
  if (error != CL_SUCCESS) return transfer_fail(log, device, "a transfer from it", error);
  if (fault_due("corrupt")) ((unsigned char *)read)[bytes > 3 ? 3 : 0] ^= 0x41;
  return STATUS_OK;
}

Status buffer_read_part(Device *device, const DeviceBuffer *buffer, size_t offset, void *to, size_t bytes, Log *log)
{
  if (bytes == 0) return STATUS_OK;
  cl_int error = fault_due("read")
                     ? CL_OUT_OF_RESOURCES
                     : clEnqueueReadBuffer(device->queue, buffer->memory, CL_TRUE, offset, bytes, to, 0, NULL, NULL);
  return read_check(device, error, to, bytes, log);
}

Status buffer_view_open(BufferView *out, Device *device, const DeviceBuffer *buffer, const char *what, Log *log)
{
  Status status = STATUS_OK;
  BufferView view = {.device = device, .memory = buffer->memory};
  if (device->info.is_gpu) {
    view.data = view.copy = large_array(buffer->bytes, 1);
    if (!view.copy) return log_no_memory(log, what);
    TRY(buffer_read(device, buffer, view.copy, buffer->bytes, log));
  } else {
    cl_int error = CL_OUT_OF_RESOURCES;
    if (!fault_due("read"))
      view.data = clEnqueueMapBuffer(device->queue, buffer->memory, CL_TRUE, CL_MAP_READ, 0, buffer->bytes, 0, NULL,
                                     NULL, &error);
    TRY(read_check(device, error, view.data, buffer->bytes, log));
  }
  *out = view;
  view = (BufferView){0};

done:
  buffer_view_close(&view);
  return status;
}

void buffer_view_close(BufferView *view)
{
  free(view->copy);
  if (view->data && !view->copy) clEnqueueUnmapMemObject(view->device->queue, view->memory, view->data, 0, NULL, NULL);
  *view = (BufferView){0};
}
