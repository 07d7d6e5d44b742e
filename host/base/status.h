// Status codes of every fallible function, and the exit code each one ends the program with.
#pragma once

typedef enum Status {
  STATUS_OK = 0,
  STATUS_FAILED,       // ran, but the verdict is no
  STATUS_USAGE,        // a command line or scene file that asks for what does not exist
  STATUS_NO_DEVICE,    // no usable OpenCL device
  STATUS_DEVICE,       // kernel build or launch failed
  STATUS_NOT_FOUND,    // an input file is missing or unreadable
  STATUS_BAD_SCENE,    // not a glTF file that can be rendered
  STATUS_BAD_IMAGE,    // not an image that can be decoded
  STATUS_UNSUPPORTED,  // valid input that needs a feature Frugal lacks
  STATUS_TOO_LARGE,    // over a limit the user can raise
  STATUS_NO_MEMORY,
  STATUS_OUTPUT,       // an output could not be written
  STATUS_INTERRUPTED,  // SIGINT or SIGTERM
} Status;

// Exit code of the program: 0 done, 1 verdict no, 2 usage, 3 device, 4 input or memory, 5 output, 130 interrupted.
int status_exit_code(Status status);

// Runs a fallible expression; on failure leaves through the function's one exit, `done`.
#define TRY(expression)    \
  do {                     \
    status = (expression); \
    if (status) goto done; \
  } while (0)
