// Processes that work for this one.
#pragma once

#include <sys/types.h>

// Starts the program at a path, in a process group of its own: `input` is its standard input, what it prints is thrown
// away, and it gets nothing else of this process, neither descriptors nor ignored signals nor those of the terminal.
// Returns 0, or an error number.
int process_spawn(pid_t *out, const char *program, char *const arguments[], int input);

// Kills the process, with its group, and reaps it. Returns its wait status: how it ended, where it was dead already.
int process_bury(pid_t pid);
