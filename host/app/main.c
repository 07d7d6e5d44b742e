// frugal: renders glTF scenes with OpenCL kernels. This file chooses the subcommand.

#include <signal.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "app/app.h"
#include "base/nearest.h"
#include "device/kernel_cache.h"
#include "image/image.h"
#include "render/compile_ahead.h"

// The subcommands: a new one is a row here and a declaration in app.h.
static const struct Command {
  const char *name, *arguments;
  int (*run)(int argc, char **argv);  // argv[0] is the name; returns the exit code
  const char *help;
} commands[] = {
    {"render", "SCENE -o OUT", app_render, "render a picture of a .glb, .gltf or scene file"},
    {"compare", "A B", app_compare, "say how far one picture is from another"},
    {"stability", "", app_stability, "measure where methods fail, and whether they say so"},
    {"info", "SCENE", app_info, "say what a scene holds, and what of it will not be rendered"},
    {"devices", "", app_devices, "list and test OpenCL devices"},
};

enum { COMMAND_COUNT = sizeof commands / sizeof *commands, COMMAND_COLUMN = 22 };

static void help_print(FILE *out)
{
  fputs(
      "Examples:\n"
      "  frugal render scene.glb -o picture.png\n"
      "  frugal render scene.glb -o picture.exr -s 1920x1080 -n 16 --aov depth,normal\n"
      "  frugal render scene.glb -o picture.png --environment studio.hdr --camera fit\n"
      "  frugal compare reference.exr picture.exr --fail-over over=0.001\n"
      "  frugal stability --quick\n"
      "  frugal info scene.glb\n"
      "  frugal devices\n"
      "\n"
      "Usage: frugal COMMAND [OPTIONS]\n"
      "\n"
      "Commands:\n",
      out);
  for (int i = 0; i < COMMAND_COUNT; i++) {
    int width = fprintf(out, "  %s %s", commands[i].name, commands[i].arguments);
    fprintf(out, "%*s%s\n", width < COMMAND_COLUMN + 2 ? COMMAND_COLUMN + 2 - width : 1, "", commands[i].help);
  }
  fputs("\nOptions: --help, also after a command; --version\n", out);
}

static void aborted(int signal_number);

// For signal handlers, where little else is allowed. No half-written output stays: outputs are renamed when whole. The
// first thread that leaves says how; others, which may now miss the kernel cache and give up, wait for the end.
static void leave(const char *message, int exit_code)
{
  static _Atomic pid_t leaver;
  pid_t self = gettid(), first = 0;
  if (!atomic_compare_exchange_strong(&leaver, &first, self)) {
    while (first != self) pause();
    return;
  }
  signal(SIGABRT, aborted);  // LLVM's while PoCL builds
  compile_ahead_kill();
  image_remove_temporaries();
  kernel_cache_remove_temporary();
  ssize_t written = isatty(STDERR_FILENO) ? write(STDERR_FILENO, "\n", 1) : 0;
  written += write(STDERR_FILENO, message, strlen(message));
  (void)written;
  _exit(exit_code);
}

static void interrupted(int signal_number) { leave("frugal: interrupted\n", 128 + signal_number); }

static const char runtime_message[] =
    "frugal: OpenCL: the runtime gave up, see above: free memory or disk space, or use another --device\n";

static void aborted(int signal_number) { leave(runtime_message, status_exit_code(STATUS_DEVICE)); }

// OpenCL runtimes end the program where they see no way on: PoCL's LLVM by abort or exit(1) when memory or disk runs
// out.
static bool is_finished;

static void finish_check(void)
{
  if (!is_finished) leave(runtime_message, status_exit_code(STATUS_DEVICE));
}

// A signal that the caller has set to be ignored (nohup, a shell's background job) stays ignored.
static void signals_set_up(void)
{
  static const int signals[] = {SIGINT, SIGTERM, SIGHUP};
  for (size_t i = 0; i < sizeof signals / sizeof *signals; i++) {
    struct sigaction action;
    if (sigaction(signals[i], NULL, &action) == 0 && action.sa_handler == SIG_DFL) signal(signals[i], interrupted);
  }
  signal(SIGABRT, aborted);
  atexit(finish_check);
  signal(SIGPIPE, SIG_IGN);  // a write to a closed pipe is an output that failed
}

static int command_unknown(const char *word)
{
  const char *names[COMMAND_COUNT + 3] = {0};
  for (int i = 0; i < COMMAND_COUNT; i++) names[i] = commands[i].name;
  names[COMMAND_COUNT] = "--help";
  names[COMMAND_COUNT + 1] = "--version";
  fprintf(stderr, "frugal: %s: no such command: did you mean '%s'? (frugal --help)\n", word, nearest_name(word, names));
  return 2;
}

// This program, called by itself.
static int compile_ahead(void)
{
  Log log = {0};
  Status status = compile_ahead_run(STDIN_FILENO, &log);
  return status ? app_fail(&log, status) : 0;
}

static int command_run(int argc, char **argv)
{
  if (argc < 2) {
    help_print(stderr);
    return 2;
  }
  const char *word = argv[1];
  for (int i = 0; i < COMMAND_COUNT; i++)
    if (!strcmp(word, commands[i].name)) return commands[i].run(argc - 1, argv + 1);
  if (!strcmp(word, "--help") || !strcmp(word, "-h") || !strcmp(word, "help"))
    help_print(stdout);
  else if (!strcmp(word, "--version") || !strcmp(word, "-V"))
    printf("frugal %s\n", FRUGAL_VERSION);
  else if (!strcmp(word, COMPILE_AHEAD_COMMAND))
    return compile_ahead();
  else
    return command_unknown(word);
  return app_end_output(0);
}

int main(int argc, char **argv)
{
  signals_set_up();
  int exit_code = command_run(argc, argv);
  is_finished = true;
  return exit_code;
}
