// Faults on demand, for tests: FRUGAL_FAULT=launch:3 makes the third launch of the process and all that
// follow fail.
#pragma once

#include <stdbool.h>

// Is the N-th call with this `kind`, or a later one, under way, for FRUGAL_FAULT=kind:N? Kinds, by what calls:
// build, buffer, launch, read, corrupt (the N-th read alone comes back with a wrong number), and stability (a measured
// picture comes out wrong).
bool fault_due(const char *kind);
