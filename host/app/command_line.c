#include "app/command_line.h"

#include <getopt.h>
#include <string.h>

#include "base/nearest.h"

enum { MAX_OPTIONS = 96, HELP_COLUMN = 29, FIRST_LONG = 256 };

// getopt's tables for ours; a long option's code is FIRST_LONG plus its row.
typedef struct GetoptTables {
  struct option longs[MAX_OPTIONS + 2];
  char shorts[2 * MAX_OPTIONS + 4];
} GetoptTables;

static void tables_fill(GetoptTables *tables, const CommandLine *line)
{
  size_t count = 0;
  char *letter = tables->shorts;
  *letter++ = ':';
  *letter++ = 'h';
  for (size_t i = 0; i < line->option_count && count < MAX_OPTIONS; i++) {
    const Option *option = &line->options[i];
    if (!option->name) continue;
    tables->longs[count++] =
        (struct option){option->name, option->value ? required_argument : no_argument, NULL, FIRST_LONG + (int)i};
    if (option->letter) *letter++ = option->letter;
    if (option->letter && option->value) *letter++ = ':';
  }
  tables->longs[count++] = (struct option){"help", no_argument, NULL, 'h'};
  tables->longs[count] = (struct option){0};
  *letter = 0;
}

// getopt has refused something: an unknown option, one whose value is missing, or a flag with a value. It leaves in
// optopt a letter, a long option's code, or 0 for a long name that it does not know.
static Status option_refused(const CommandLine *line, const GetoptTables *tables, const char *word, int code, Log *log)
{
  char name[64];
  if (optopt >= FIRST_LONG)
    snprintf(name, sizeof name, "--%s", line->options[optopt - FIRST_LONG].name);
  else
    snprintf(name, sizeof name, "-%c", optopt);
  if (code == ':') return log_fail(log, STATUS_USAGE, "%s: needs a value: see frugal %s --help", name, line->name);
  if (optopt >= FIRST_LONG) return log_fail(log, STATUS_USAGE, "%s: takes no value: leave it out", name);
  if (optopt && strncmp(word, "--", 2) != 0)
    return log_fail(log, STATUS_USAGE, "%s: no such option: see frugal %s --help", name, line->name);

  const char *names[MAX_OPTIONS + 2] = {0};
  char matches[256] = "";
  snprintf(name, sizeof name, "%s", word + strspn(word, "-"));
  name[strcspn(name, "=")] = 0;
  for (size_t i = 0; tables->longs[i].name; i++) {
    names[i] = tables->longs[i].name;
    size_t used = strlen(matches);
    if (!strncmp(names[i], name, strlen(name)))
      snprintf(matches + used, sizeof matches - used, "%s--%s", used ? ", " : "", names[i]);
  }
  if (*name && *matches) return log_fail(log, STATUS_USAGE, "%s: may be %s: name one", word, matches);
  return log_fail(log, STATUS_USAGE, "%s: no such option: did you mean --%s?", word, nearest_name(name, names));
}

static const Option *option_of(const CommandLine *line, int code)
{
  if (code >= FIRST_LONG) return &line->options[code - FIRST_LONG];
  const Option *option = line->options;
  while (!option->name || option->letter != code) option++;
  return option;
}

Status command_line_parse(bool *help, const char **operands, size_t max_operands, void *settings,
                          const CommandLine *line, int argc, char **argv, Log *log)
{
  Status status = STATUS_OK;
  GetoptTables tables;
  size_t operand_count = 0;
  tables_fill(&tables, line);
  *help = false;
  opterr = 0;
  optind = 0;  // starts anew, also after an earlier call that stopped half-way
  for (int code; (code = getopt_long(argc, argv, tables.shorts, tables.longs, NULL)) != -1;) {
    if (code == '?' || code == ':') return option_refused(line, &tables, argv[optind - 1], code, log);
    if (code == 'h') {
      *help = true;
      return STATUS_OK;
    }
    const Option *option = option_of(line, code);
    TRY(option->read((char *)settings + option->field, option, option->value ? optarg : NULL, log));
  }
  for (int i = optind; i < argc; i++) {
    if (operand_count == max_operands)
      return log_fail(log, STATUS_USAGE, "%s: one too many: see frugal %s --help", argv[i], line->name);
    operands[operand_count++] = argv[i];
  }

done:
  return status;
}

static void option_help(const Option *option, FILE *out)
{
  char left[96];
  int width = snprintf(left, sizeof left, "  %c%c%s --%s%s%s", option->letter ? '-' : ' ',
                       option->letter ? option->letter : ' ', option->letter ? "," : " ", option->name,
                       option->value ? " " : "", option->value ? option->value : "");
  fputs(left, out);
  if (width >= HELP_COLUMN) fputc('\n', out);
  int column = width < HELP_COLUMN ? width : 0;
  for (const char *text = option->help; *text; column = 0) {
    int length = (int)strcspn(text, "\n");
    fprintf(out, "%*s%.*s\n", HELP_COLUMN - column, "", length, text);
    text += length + (text[length] == '\n');
  }
}

void command_line_help(const CommandLine *line, FILE *out)
{
  static const Option help = {.name = "help", .letter = 'h', .help = "this text"};
  fputs(line->usage, out);
  for (size_t i = 0; i < line->option_count; i++) {
    if (line->options[i].name)
      option_help(&line->options[i], out);
    else
      fprintf(out, "\n%s\n", line->options[i].help);
  }
  option_help(&help, out);
  fputs(line->closing, out);
}
