// frugal: renders glTF scenes with OpenCL kernels. This file chooses the subcommand.

#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "app/app.h"
#include "image/image.h"

static const char usage[] =
    "Examples:\n"
    "  frugal render scene.glb -o picture.png\n"
    "  frugal render scene.glb -o picture.exr -s 1920x1080 -n 16 --aov depth,normal\n"
    "  frugal render scene.glb -o picture.png --environment studio.hdr --camera fit\n"
    "  frugal devices\n"
    "\n"
    "Usage: frugal COMMAND [OPTIONS]\n"
    "\n"
    "Commands:\n"
    "  render SCENE -o OUT   render a picture of a .glb or .gltf file (frugal render --help)\n"
    "  devices               list OpenCL devices\n"
    "\n"
    "Options: --help, --version\n";

// Leaves at once: no half-written output stays, since outputs are renamed into place when whole.
static void interrupted(int signal_number)
{
  image_remove_temporaries();
  static const char message[] = "\nfrugal: interrupted: nothing was written\n";
  ssize_t written = write(STDERR_FILENO, message, sizeof message - 1);
  (void)written;
  _exit(128 + signal_number);
}

int main(int argc, char **argv)
{
  signal(SIGINT, interrupted);
  signal(SIGTERM, interrupted);
  if (argc < 2) {
    fputs(usage, stderr);
    return 2;
  }
  const char *command = argv[1];
  if (!strcmp(command, "render")) return app_render(argc - 1, argv + 1);
  if (!strcmp(command, "devices")) return app_devices(argc - 1, argv + 1);
  if (!strcmp(command, "--help") || !strcmp(command, "-h") || !strcmp(command, "help")) {
    fputs(usage, stdout);
    return 0;
  }
  if (!strcmp(command, "--version") || !strcmp(command, "-V")) {
    printf("frugal %s\n", FRUGAL_VERSION);
    return 0;
  }
  static const char *const commands[] = {"render", "devices", "--help", "--version", NULL};
  fprintf(stderr, "frugal: %s: no such command: did you mean '%s'? (frugal --help)\n", command, app_nearest(command, commands));
  return 2;
}
