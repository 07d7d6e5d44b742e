// frugal devices: what there is to render on.

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/app.h"
#include "device/device.h"

int app_devices(int argc, char **argv)
{
  if (argc > 1) {
    bool help = !strcmp(argv[1], "--help") || !strcmp(argv[1], "-h");
    fputs("Usage: frugal devices\n\nLists OpenCL devices, best first; --device of other commands takes their index or a part of"
          " the name.\n",
          help ? stdout : stderr);
    return help ? 0 : 2;
  }
  Log log = {0};
  DeviceInfo *infos = NULL;
  uint32_t count = 0;
  Status status = device_list(&infos, &count, &log);
  if (status) return app_fail(&log, status);
  for (uint32_t i = 0; i < count; i++) {
    const DeviceInfo *info = &infos[i];
    printf("%u  %s  %s  %u units, %.1f GB, %s, driver %s\n", i, info->is_gpu ? "GPU" : "CPU", info->name, info->compute_units,
           1e-9 * (double)info->memory_bytes, info->platform, info->driver);
  }
  if (count == 0) {
    status = log_fail(&log, STATUS_NO_DEVICE,
                      "OpenCL: no device: install an OpenCL runtime, e.g. the package pocl-opencl-icd");
    app_fail(&log, status);
  }
  free(infos);
  return status_exit_code(status);
}
