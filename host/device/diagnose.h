// What keeps OpenCL devices from being found, and what to install or change.
#pragma once

#include <stdint.h>

#include "base/log.h"

enum { MAX_FINDINGS = 16 };

// Findings as `what: cause: hint`, the hint by Debian's and Ubuntu's names of packages.
typedef struct Diagnosis {
  char findings[MAX_FINDINGS][512];
  uint32_t count;
  char platforms[MAX_FINDINGS][128];  // OpenCL platforms that are there, with or without devices
  uint32_t platform_count;
} Diagnosis;

// Where to look. NULL members: the machine's own places ($OCL_ICD_VENDORS or /etc/OpenCL/vendors,
// /sys/bus/pci/devices).
typedef struct DiagnosisPlaces {
  const char *vendors, *pci;
} DiagnosisPlaces;

// Looks for vendor files that name no library that loads, platforms without devices, GPUs without a platform, and
// device files that may not be opened. Loads the vendors' libraries (0.1 s).
void device_diagnose(Diagnosis *out, const DiagnosisPlaces *places);
