// The sources under cl/, embedded in the program by scripts/embed_kernels.
#pragma once

typedef struct KernelSource {
  const char *path;  // as an #include names it: "rays/trace_packet.cl"
  const char *text;
} KernelSource;

extern const KernelSource kernel_sources[];  // ends with a NULL path
