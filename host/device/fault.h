// Faults on demand, for tests: FRUGAL_FAULT=launch:3 makes the third launch of the process fail.
#pragma once

#include <stdbool.h>

// Is the N-th call with this `kind` under way, for FRUGAL_FAULT=kind:N? Kinds, by what calls: build, buffer, launch,
// read, and corrupt (a read whose first number comes back wrong).
bool fault_due(const char *kind);
