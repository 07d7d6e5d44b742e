// frugal devices: what there is to render on, whether it works, and what is missing.

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/app.h"
#include "app/command_line.h"
#include "app/self_test.h"
#include "base/clock.h"
#include "device/diagnose.h"
#include "device/kernel_cache.h"
#include "report/profile.h"

typedef struct DevicesOptions {
  bool json, test, help;
} DevicesOptions;

static const Option devices_options[] = {
    OPTION_HEADING("Options:"),
    {"json", 0, NULL, option_read_true, offsetof(DevicesOptions, json), .help = "all of it as JSON"},
    {"no-self-test", 0, NULL, option_read_false, offsetof(DevicesOptions, test),
     .help = "list the devices without trying them"},
};

static const CommandLine devices_command_line = {
    .name = "devices",
    .usage =
        "Examples:\n"
        "  frugal devices\n"
        "  frugal devices --json | jq '.devices[] | select(.self_test.passed) | .name'\n"
        "\n"
        "Usage: frugal devices [OPTIONS]\n"
        "\n"
        "Lists OpenCL devices, best first; --device of other commands takes the index or a part of the name. Each "
        "one\nrenders a small scene whose picture is known. Says what is missing, and which packages bring it.\n",
    .closing = "\nExit codes: 0 a device works, 2 usage, 3 none does.\n",
    .options = devices_options,
    .option_count = sizeof devices_options / sizeof *devices_options,
};

typedef struct TestedDevice {
  DeviceInfo info;
  uint32_t lanes;
  bool tested, passed;
  double ms;
  char message[sizeof((Log *)0)->error];  // why it did not pass
} TestedDevice;

typedef struct DevicesReport {
  TestedDevice *devices;
  uint32_t count;
  Diagnosis diagnosis;
} DevicesReport;

// A device that cannot be opened has failed its test.
static void device_try(TestedDevice *out, uint32_t index, bool test)
{
  Log log = {0};
  Device *device = NULL;
  char choice[16];
  snprintf(choice, sizeof choice, "%u", index);
  double begin_ms = clock_ms();
  Status status = device_open(&device, choice, 0, NULL, &log);
  if (!status) out->lanes = device_traits(device)->lanes;
  if (!status && test) status = self_test(device, &log);
  device_close(device);
  out->tested = test || status;
  out->passed = out->tested && !status;
  out->ms = clock_ms() - begin_ms;
  memcpy(out->message, log.error, sizeof out->message);
}

static Status report_make(DevicesReport *out, bool test, Log *log)
{
  Status status = STATUS_OK;
  DeviceInfo *infos = NULL;
  device_diagnose(&out->diagnosis, &(DiagnosisPlaces){0});
  TRY(device_list(&infos, &out->count, log));
  out->devices = calloc(out->count + 1, sizeof *out->devices);
  if (!out->devices) {
    status = log_no_memory(log, "device list");
    goto done;
  }
  for (uint32_t i = 0; i < out->count; i++) {
    out->devices[i].info = infos[i];
    device_try(&out->devices[i], i, test);
  }

done:
  free(infos);
  return status;
}

static void device_print(const TestedDevice *device, uint32_t index)
{
  const DeviceInfo *info = &device->info;
  printf("%u  %s  %s\n", index, info->is_gpu ? "GPU" : "CPU", info->name);
  printf("   %s, %s, driver %s\n", info->platform, info->version, info->driver);
  printf("   %u units, %.1f GB, buffers of up to %.1f GB, %u %s\n", info->compute_units,
         1e-9 * (double)info->memory_bytes, 1e-9 * (double)info->max_buffer_bytes, device->lanes,
         device->lanes == 1 ? "lane" : "lanes");
  if (device->passed) printf("   self-test passed (%.2f s)\n", 1e-3 * device->ms);
  if (device->tested && !device->passed) printf("   FAILED: %s\n", device->message);
}

static void cache_print(bool nvidia)
{
  KernelCache cache;
  if (!kernel_cache_read(&cache, nvidia)) return;
  printf("kernel cache%s: %s: %.1f MB in %u files%s\n", nvidia ? " (NVIDIA)" : "", cache.folder,
         1e-6 * (double)cache.bytes, cache.files, cache.is_temporary ? ", removed at the end" : "");
  if (cache.is_temporary)
    printf("kernel cache: %s: set POCL_CACHE_DIR to a folder that can be written\n", kernel_cache_unusable());
}

static void report_print(const DevicesReport *report)
{
  for (uint32_t i = 0; i < report->count; i++) device_print(&report->devices[i], i);
  cache_print(false);
  cache_print(true);
  for (uint32_t i = 0; i < report->diagnosis.count; i++) printf("missing: %s\n", report->diagnosis.findings[i]);
}

static json_t *device_json(const TestedDevice *device, uint32_t index)
{
  const DeviceInfo *info = &device->info;
  json_t *object = json_pack("{s:I, s:s, s:s, s:s, s:s, s:s, s:I, s:I, s:I, s:I}", "index", (json_int_t)index, "type",
                             info->is_gpu ? "gpu" : "cpu", "name", info->name, "platform", info->platform, "version",
                             info->version, "driver", info->driver, "compute_units", (json_int_t)info->compute_units,
                             "memory_bytes", (json_int_t)info->memory_bytes, "max_buffer_bytes",
                             (json_int_t)info->max_buffer_bytes, "lanes", (json_int_t)device->lanes);
  if (object && device->tested)
    json_object_set_new(
        object, "self_test",
        json_pack("{s:b, s:f, s:s}", "passed", (int)device->passed, "ms", device->ms, "message", device->message));
  return object;
}

static json_t *caches_json(void)
{
  json_t *list = json_array();
  for (int nvidia = 0; nvidia < 2 && list; nvidia++) {
    KernelCache cache;
    if (!kernel_cache_read(&cache, nvidia)) continue;
    json_array_append_new(list, json_pack("{s:s, s:s, s:I, s:I, s:b}", "runtime", nvidia ? "NVIDIA" : "PoCL", "folder",
                                          cache.folder, "bytes", (json_int_t)cache.bytes, "files",
                                          (json_int_t)cache.files, "temporary", (int)cache.is_temporary));
  }
  return list;
}

static json_t *report_json(const DevicesReport *report)
{
  const Diagnosis *diagnosis = &report->diagnosis;
  json_t *devices = json_array(), *platforms = json_array(), *missing = json_array();
  for (uint32_t i = 0; i < report->count; i++) json_array_append_new(devices, device_json(&report->devices[i], i));
  for (uint32_t i = 0; i < diagnosis->platform_count; i++)
    json_array_append_new(platforms, json_string(diagnosis->platforms[i]));
  for (uint32_t i = 0; i < diagnosis->count; i++) json_array_append_new(missing, json_string(diagnosis->findings[i]));
  return json_pack("{s:s, s:o, s:o, s:o, s:o}", "version", FRUGAL_VERSION, "devices", devices, "platforms", platforms,
                   "kernel_caches", caches_json(), "missing", missing);
}

// 3 and a message unless a device works.
static Status report_judge(const DevicesReport *report, bool tested, Log *log)
{
  if (report->count == 0)
    return log_fail(log, STATUS_NO_DEVICE,
                    "OpenCL: no device: install an OpenCL runtime, e.g. the package pocl-opencl-icd");
  uint32_t failed = 0;
  for (uint32_t i = 0; i < report->count; i++) failed += report->devices[i].tested && !report->devices[i].passed;
  if (failed < report->count) return STATUS_OK;
  return log_fail(log, STATUS_NO_DEVICE, "%s", report->devices[0].message);
}

int app_devices(int argc, char **argv)
{
  Status status = STATUS_OK;
  DevicesOptions options = {.test = true};
  DevicesReport report = {0};
  json_t *json = NULL;
  Log log = {0};
  TRY(command_line_parse(&options.help, NULL, 0, &options, &devices_command_line, argc, argv, &log));
  if (options.help) {
    command_line_help(&devices_command_line, stdout);
    goto done;
  }
  TRY(report_make(&report, options.test, &log));
  if (options.json) {
    json = report_json(&report);
    TRY(json_write("-", json, &log));
  } else {
    report_print(&report);
  }
  TRY(report_judge(&report, options.test, &log));

done:
  json_decref(json);
  free(report.devices);
  if (status) app_fail(&log, status);
  return app_end_output(status_exit_code(status));
}
