// A subcommand's command line as a table of options: what getopt_long reads and --help prints.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "base/log.h"

typedef struct Option Option;

// Reads an option's value into the field of the settings that it belongs to. A flag's `text` is NULL.
// Errors: STATUS_USAGE, saying what is expected.
typedef Status (*OptionReader)(void *field, const Option *option, const char *text, Log *log);

// Kinds of value that an option may have as a key of a scene file, where its own reader judges what they say.
enum {
  OPTION_JSON_FLAG = 1,  // true or false
  OPTION_JSON_NUMBER = 2,
  OPTION_JSON_TEXT = 4,
  OPTION_JSON_NUMBERS = 8,  // a list
  OPTION_JSON_TEXTS = 16,
  OPTION_JSON_PAIRS = 32,  // an object of texts by name: NAME=TEXT, joined
};

struct Option {
  const char *name;   // after the two dashes; NULL: this row is a heading
  char letter;        // short name; 0: none
  const char *value;  // what --help calls the value; NULL: takes none
  OptionReader read;
  size_t field;              // offset of the field in the command's settings
  double low, high;          // of a number
  const char *const *words;  // that a value is chosen from, ends with NULL
  const char *help;          // lines after the first are set under it
  uint32_t json;             // OPTION_JSON_*; 0: says how to run, and is no key of a scene file
  char between;              // joins a list's values; 0: a comma
};

#define OPTION_HEADING(text) \
  {                          \
    .help = text             \
  }

typedef struct CommandLine {
  const char *name;     // of the subcommand
  const char *usage;    // what --help prints before the options: examples first
  const char *closing;  // and after them
  const Option *options;
  size_t option_count;
} CommandLine;

// Reads argv[1..argc): options into `settings`, which holds the defaults, and up to `max_operands` words that are none
// into `operands` (the rest stay NULL). Of options given twice the last counts. `*help` is set by --help or -h, and
// then nothing after it is read.
//
// Errors: STATUS_USAGE: an unknown option (the nearest is named), a value missing or wrong, too many operands.
Status command_line_parse(bool *help, const char **operands, size_t max_operands, void *settings,
                          const CommandLine *line, int argc, char **argv, Log *log);

// Prints usage, options and closing.
void command_line_help(const CommandLine *line, FILE *out);

// STATUS_USAGE with `--name text: not valid: expected ...`.
Status option_fail(Log *log, const Option *option, const char *text, const char *expected);

// Readers, by the type of the field.
Status option_read_true(void *field, const Option *option, const char *text, Log *log);     // bool
Status option_read_false(void *field, const Option *option, const char *text, Log *log);    // bool
Status option_read_text(void *field, const Option *option, const char *text, Log *log);     // const char *, not copied
Status option_read_u32(void *field, const Option *option, const char *text, Log *log);      // low..high
Status option_read_u64(void *field, const Option *option, const char *text, Log *log);      // low..high
Status option_read_float(void *field, const Option *option, const char *text, Log *log);    // low..high
Status option_read_bytes(void *field, const Option *option, const char *text, Log *log);    // uint64_t; k, M, G: 1024^n
Status option_read_radians(void *field, const Option *option, const char *text, Log *log);  // double, from degrees
Status option_read_word(void *field, const Option *option, const char *text, Log *log);     // enum: index in `words`
Status option_read_name(void *field, const Option *option, const char *text, Log *log);  // const char *: one of `words`
Status option_read_color(void *field, const Option *option, const char *text, Log *log);  // float[3]: #rrggbb to linear
