// The built program run as a user runs it: what it prints, how it ends, what it leaves behind.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

typedef struct CliRun {
  int exit_code;  // -1 where a signal ended it
  int signal;
  double cpu_s;
  double signal_ms;  // from the signal that was asked for to the end; 0: it was not sent
  long max_rss_kb;
  char *out, *err;  // NUL-terminated
  size_t out_size;
} CliRun;

// What the next run gets besides; zeroed by each run.
typedef struct CliSetting {
  const char *environment[8];  // "NAME=VALUE", or "NAME" to unset it; ends with NULL
  size_t address_space;        // bytes; 0: no limit
  int stdout_fd;               // in place of the pipe that is read; 0: none
  const char *signal_after;    // send `signal` once this has appeared on standard error
  const char *signal_while;    // ... or while this folder holds a file that is being written
  int signal;
  bool ignore_interrupt;  // as a shell starts a background job
  uid_t user;             // run as this user; 0: no change
} CliSetting;

extern CliSetting cli_setting;
extern char cli_folder[];   // of this test program, writable
extern char cli_program[];  // build/frugal
extern char cli_build[];    // build

// For cmocka's group: a folder of its own, in it out/old.png that holds "old", PoCL's cache in the build unless the
// environment names one, processes that are left behind made visible.
int cli_set_up(void **state);
int cli_tear_down(void **state);

// A path in the folder, valid for seven further calls.
const char *cli_path(const char *format, ...) __attribute__((format(printf, 1, 2)));

// Runs the program with the arguments, ended by NULL, and an empty folder as TMPDIR. The test fails where it takes over
// 300 s (it hangs), leaves something in TMPDIR, or a process a second after its end. The caller frees the run.
CliRun cli_run(const char *first, ...) __attribute__((sentinel));
void cli_free(CliRun *run);

// Fails the test unless the run ended so, with `message` on standard error. For a failure the last line there must
// start with `frugal: `, nothing be on standard output, and 5 s of CPU time and 1 GiB suffice.
void cli_expect(const CliRun *run, int exit_code, const char *message, const char *file, int line);

// Runs with these arguments and expects that.
#define CLI_EXPECT(exit_code, message, ...)                    \
  do {                                                         \
    CliRun run_ = cli_run(__VA_ARGS__, NULL);                  \
    cli_expect(&run_, exit_code, message, __FILE__, __LINE__); \
    cli_free(&run_);                                           \
  } while (0)

// Fails the test unless out/ holds old.png alone, as it was.
void cli_old_check(void);

// The bytes of a file, NUL-terminated; the caller frees them. NULL where there is none.
char *cli_load(const char *path, size_t *size);
void cli_save(const char *path, const void *bytes, size_t size);

// Entries of a folder besides . and .., joined by blanks in alphabetical order; valid until the next call.
const char *cli_list(const char *folder);

// A scene of one lit square, turned by 0.2 rad, facing the camera 'front' that sees it with a margin; in the test's
// folder.
const char *cli_scene(void);
