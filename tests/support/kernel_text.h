// What kernels' sources look at, read as text: which macros a kernel's code hangs on, through all that it calls.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// What device_scene_options tells kernels of a scene, by bits.
enum { SCENE_FLAGS = 7 };
extern const char *const scene_flags[SCENE_FLAGS];

// Flags that stand in build options as "-D FLAG".
uint32_t scene_flags_given(const char *options);

// Flags on which code hangs that the kernels of a file under cl/ reach, compiled with these options otherwise. Code
// under other conditions is taken for reached unless the options say whether it is. Alpha that is decoded for those who
// look at HAS_MASK or HAS_BLEND counts as theirs (HAS_ALPHA). 0 where there are no kernels.
//
// Holds for sources in the project's format: definitions begin in the first column, and end with `}` or `;`.
uint32_t scene_flags_looked_at(const char *path, const char *options);

// Is a file the other, or part of it by #include?
bool kernel_file_holds(const char *path, const char *other);
