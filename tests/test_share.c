// What is installed beside the program: the manual page and the completion know every option; install and uninstall.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "app/options.h"
#include "support/cli.h"

enum { MAX_WORDS = 128 };

// Standard output of a shell command, run from the root of the sources, that must succeed; the caller frees it.
static char *output_of(const char *format, ...)
{
  char command[4096], *text = NULL;
  size_t size = 0;
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(command, sizeof command, format, arguments);
  va_end(arguments);
  FILE *pipe = popen(command, "r"), *copy = open_memstream(&text, &size);
  assert_true(pipe && copy);
  for (int c; (c = getc(pipe)) != EOF;) putc(c, copy);
  fclose(copy);
  int ending = pclose(pipe);
  if (ending != 0) fail_msg("exit code %d: %s\n%s", WEXITSTATUS(ending), command, text);
  return text;
}

// The lines of a text, which is cut up.
static size_t lines_split(char *words[MAX_WORDS], char *text)
{
  size_t count = 0;
  for (char *rest = NULL, *line = strtok_r(text, "\n", &rest); line; line = strtok_r(NULL, "\n", &rest)) {
    assert_true(count < MAX_WORDS);
    words[count++] = line;
  }
  return count;
}

static bool among(const char *word, char *const *words, size_t count)
{
  for (size_t i = 0; i < count; i++)
    if (!strcmp(word, words[i])) return true;
  return false;
}

// What bash would offer for the last of the words, one a line.
static char *completions(const char *words)
{
  return output_of(
      "bash -c '. scripts/share/frugal.bash; COMP_WORDS=(\"$@\"); "
      "COMP_CWORD=$(($# - 1)); _frugal; printf \"%%s\\n\" \"${COMPREPLY[@]}\"' bash '%s' %s",
      cli_program, words);
}

// Commands, as `frugal --help` lists them.
static size_t commands_list(char *words[MAX_WORDS], char **text)
{
  *text = output_of("'%s' --help | sed -n '/^Commands:/,/^$/s/^  \\([a-z]*\\) .*/\\1/p'", cli_program);
  return lines_split(words, *text);
}

static char *long_options(const char *command)
{
  return output_of("'%s' %s --help | grep -oE '^ *(-[a-zA-Z], )?--[a-z][-a-z0-9]*' | sed 's/.*--/--/'", cli_program,
                   command);
}

static void the_manual_has_every_option_of_the_help(void **state)
{
  char *text, *commands[MAX_WORDS], *page = output_of("scripts/make_man '%s' | sed 's/\\\\-/-/g'", cli_program);
  size_t command_count = commands_list(commands, &text);
  assert_true(command_count >= 3);
  for (size_t i = 0; i < command_count; i++) {
    char *options[MAX_WORDS], *list = long_options(commands[i]), line[96], *section, *next;
    size_t count = lines_split(options, list);
    snprintf(line, sizeof line, ".SH FRUGAL %s\n", commands[i]);
    for (char *c = line + 4; *c; c++)
      if (*c >= 'a' && *c <= 'z') *c -= 32;
    section = strstr(page, line);
    if (!section) fail_msg("no section for %s", commands[i]);
    next = strstr(section + 1, "\n.SH ");
    assert_non_null(next);
    for (size_t k = 0; k < count; k++) {
      char *found = section - 1;
      size_t length = strlen(options[k]);
      do found = strstr(found + 1, options[k]);
      while (found && (found[length] == '-' || (found[length] >= 'a' && found[length] <= 'z')));
      if (!found || found > next) fail_msg("%s %s is not in the manual", commands[i], options[k]);
    }
    assert_true(count >= 2);
    free(list);
  }
  free(page);
  free(text);
}

static void the_manual_is_sound_roff(void **state)
{
  if (system("command -v groff >/dev/null") != 0) {
    fprintf(stderr, "SKIPPED: roff of the manual: no groff\n");
    return;
  }
  char *complaints = output_of("scripts/make_man '%s' | groff -man -ww -z -Tascii 2>&1", cli_program);
  assert_string_equal(complaints, "");
  free(complaints);
}

static void completion_offers_every_option_of_the_help(void **state)
{
  char *text, *commands[MAX_WORDS];
  size_t command_count = commands_list(commands, &text);
  for (size_t i = 0; i < command_count; i++) {
    char words[64], *offered[MAX_WORDS], *options[MAX_WORDS], *list = long_options(commands[i]);
    snprintf(words, sizeof words, "%s --", commands[i]);
    char *reply = completions(words);
    size_t offered_count = lines_split(offered, reply), count = lines_split(options, list);
    for (size_t k = 0; k < count; k++)
      if (!among(options[k], offered, offered_count)) fail_msg("%s %s is not offered", commands[i], options[k]);
    free(reply);
    free(list);
  }
  char *reply = completions("''"), *offered[MAX_WORDS];
  size_t offered_count = lines_split(offered, reply);
  for (size_t i = 0; i < command_count; i++) assert_true(among(commands[i], offered, offered_count));
  free(reply);
  free(text);
}

// The words that an option chooses from are offered, and no others that it would refuse.
static void completion_offers_the_words_of_an_option(void **state)
{
  for (size_t i = 0; i < render_command_line.option_count; i++) {
    const Option *option = &render_command_line.options[i];
    char words[96], *offered[MAX_WORDS];
    if (!option->words) continue;
    snprintf(words, sizeof words, "render a.glb --%s ''", option->name);
    char *reply = completions(words);
    size_t count = lines_split(offered, reply), word_count = 0;
    while (option->words[word_count]) word_count++;
    if (count != word_count) fail_msg("--%s: %zu words offered, %zu known", option->name, count, word_count);
    for (size_t k = 0; k < word_count; k++)
      if (!among(option->words[k], offered, count)) fail_msg("--%s %s is not offered", option->name, option->words[k]);
    free(reply);
  }
  char *reply = completions("render a.glb --aov depth,nor");
  assert_string_equal(reply, "depth,normal\n");
  free(reply);
}

static void completion_offers_what_the_scene_has(void **state)
{
  char words[600];
  snprintf(words, sizeof words, "render '%s' --camera ''", cli_scene());
  char *reply = completions(words);
  assert_string_equal(reply, "0\n1\nfit\n");
  free(reply);
  snprintf(words, sizeof words, "render '%s' --light-shadows ''", cli_scene());
  reply = completions(words);
  assert_string_equal(reply, "#1=\n");
  free(reply);
  reply = completions("render a.glb --device ''");
  assert_int_equal(strncmp(reply, "cpu\ngpu\n0\n", 10), 0);
  free(reply);
}

static void install_puts_all_in_place_and_uninstall_takes_it_back(void **state)
{
  const char *root = cli_path("root");
  free(output_of("scripts/install '%s' /opt/frugal '%s'", cli_build, root));
  char *files = output_of("cd '%s' && find . -type f -printf '%%m %%p\\n' | sort -k 2", root);
  assert_string_equal(files,
                      "755 ./opt/frugal/bin/frugal\n"
                      "755 ./opt/frugal/libexec/frugal/frugal-image\n"
                      "644 ./opt/frugal/share/bash-completion/completions/frugal\n"
                      "644 ./opt/frugal/share/frugal/scene.schema.json\n"
                      "644 ./opt/frugal/share/man/man1/frugal.1\n");
  free(files);
  // What is installed works where it is, with the image helper that came with it.
  snprintf(cli_program, 4096, "%s/opt/frugal/bin/frugal", root);
  CLI_EXPECT(0, "", "render", cli_scene(), "-o", cli_path("installed.png"), "-s", "16x16");
  snprintf(cli_program, 4096, "%s/frugal", cli_build);
  free(output_of("scripts/install --uninstall /opt/frugal '%s'", root));
  files = output_of("cd '%s' && find . -type f -o -name frugal ! -path '*/opt/frugal'", root);
  assert_string_equal(files, "");
  free(files);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_manual_has_every_option_of_the_help),
      cmocka_unit_test(the_manual_is_sound_roff),
      cmocka_unit_test(completion_offers_every_option_of_the_help),
      cmocka_unit_test(completion_offers_the_words_of_an_option),
      cmocka_unit_test(completion_offers_what_the_scene_has),
      cmocka_unit_test(install_puts_all_in_place_and_uninstall_takes_it_back),
  };
  return cmocka_run_group_tests(tests, cli_set_up, cli_tear_down);
}
