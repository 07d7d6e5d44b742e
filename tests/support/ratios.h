// Bounds over measured errors, of many pictures.
#pragma once

// Sorts, the least first.
void ratios_sort(double *values, int count);

// Fails unless bounds cover all of `count` pictures but for a share of `missed_most`, and one; and are within 4 times
// the measured error in the median of the `some` that have one. Prints what they are.
void ratios_report(const char *name, double *ratios, int some, int missed, int count, double missed_most);
