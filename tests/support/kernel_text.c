#include "support/kernel_text.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "device/kernel_source.h"

const char *const scene_flags[SCENE_FLAGS] = {"HAS_TEXTURES",    "HAS_SECOND_UVS", "HAS_VERTEX_COLORS", "HAS_MASK",
                                              "HAS_NORMAL_MAPS", "HAS_BLEND",      "HAS_SHADOWLESS"};

enum { FILES_MOST = 64, DEPTH_MOST = 16, ITEMS_MOST = 4096, NAME_MOST = 64, LINE_MOST = 1024 };

// A function, type or macro of a source.
typedef struct Item {
  char name[NAME_MOST];
  char *text;  // and the conditions that it stands under
  bool is_kernel, seen;
} Item;

typedef struct Condition {
  int value;  // 1 true, 0 false, -1 who knows
  char text[LINE_MOST];
} Condition;

// A source being read.
typedef struct Reading {
  const char *options;
  char *whole;  // included files in place
  const char *included[FILES_MOST];
  int included_count;
  Item *items;
  int item_count;
  Condition conditions[DEPTH_MOST];
  int depth;
} Reading;

static bool is_word(char c)
{
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

// The next identifier at *text, which moves behind it; false at the end.
static bool word_next(char out[NAME_MOST], const char **text)
{
  const char *at = *text;
  while (*at && !is_word(*at)) at++;
  const char *end = at;
  while (is_word(*end)) end++;
  const size_t length = (size_t)(end - at);
  snprintf(out, NAME_MOST, "%.*s", (int)(length < NAME_MOST ? length : NAME_MOST - 1), at);
  *text = end;
  return length > 0;
}

static bool text_has_word(const char *text, const char *before, const char *word)
{
  char sought[NAME_MOST + 16];
  const int length = snprintf(sought, sizeof sought, "%s%s", before, word);
  for (const char *at = strstr(text, sought); at; at = strstr(at + 1, sought))
    if (!is_word(at[length])) return true;
  return false;
}

static uint32_t flag_bit(const char *word)
{
  for (int i = 0; i < SCENE_FLAGS; i++)
    if (!strcmp(word, scene_flags[i])) return 1u << i;
  return 0;
}

uint32_t scene_flags_given(const char *options)
{
  uint32_t given = 0;
  for (int i = 0; i < SCENE_FLAGS; i++) given |= (uint32_t)text_has_word(options, "-D ", scene_flags[i]) << i;
  return given;
}

// Appends a file, with what it includes in place, each once.
static void file_read(FILE *to, Reading *reading, const char *path)
{
  const KernelSource *source = kernel_sources;
  for (int i = 0; i < reading->included_count; i++)
    if (!strcmp(reading->included[i], path)) return;
  while (source->path && strcmp(source->path, path) != 0) source++;
  assert_non_null(source->path);
  assert_in_range(reading->included_count, 0, FILES_MOST - 1);
  reading->included[reading->included_count++] = source->path;
  for (const char *line = source->text, *end; *line; line = end) {
    char included[NAME_MOST];
    end = strchr(line, '\n');
    end = end ? end + 1 : line + strlen(line);
    if (*line == '#' && sscanf(line, "#include \"%63[^\"]\"", included) == 1)
      file_read(to, reading, included);
    else
      fwrite(line, 1, (size_t)(end - line), to);
  }
}

// Is a macro defined: 1, 0, or -1 where that is not known here?
static int defined(const Reading *reading, const char *name)
{
  if (flag_bit(name)) return -1;
  if (text_has_word(reading->options, "-D ", name)) return 1;
  return strncmp(name, "HAS_", 4) != 0 || text_has_word(reading->whole, "define ", name) ? -1 : 0;
}

static int condition_value(const Reading *reading, const char *text)
{
  char name[NAME_MOST];
  int value = 0;
  if (sscanf(text, "ifdef %63s", name) == 1) return defined(reading, name);
  if (sscanf(text, "ifndef %63s", name) == 1) return (value = defined(reading, name)) < 0 ? -1 : !value;
  if (strpbrk(text, "&<>=!")) return -1;
  for (const char *at = strstr(text, "defined("); at; at = strstr(at + 1, "defined(")) {
    if (sscanf(at, "defined(%63[^)])", name) != 1) return -1;
    const int one = defined(reading, name);
    value = value == 1 || one == 1 ? 1 : value < 0 || one < 0 ? -1 : 0;
  }
  return strstr(text, "defined(") ? value : -1;
}

static void conditions_add(FILE *to, const Reading *reading)
{
  for (int i = 0; i < reading->depth; i++) fprintf(to, "%s\n", reading->conditions[i].text);
}

static bool is_reached(const Reading *reading)
{
  for (int i = 0; i < reading->depth; i++)
    if (reading->conditions[i].value == 0) return false;
  return true;
}

// What an item is called: a function by what stands before its parenthesis, others by their last word.
static void item_name(Item *item, const char *text)
{
  char word[NAME_MOST];
  const char *kernel = strstr(text, "kernel void "), *at = kernel ? kernel + strlen("kernel void ") : text;
  const bool is_type = !strncmp(text, "typedef", 7) || !strchr(text, '(');
  item->is_kernel = kernel && !is_type;
  while (word_next(word, &at)) {
    strcpy(item->name, word);
    if (!is_type && *at == '(' && strcmp(word, "__attribute__") != 0 && strcmp(word, "always_inline") != 0) return;
  }
}

static void item_add(Reading *reading, const char *name, char *text, const char *own)
{
  assert_in_range(reading->item_count, 0, ITEMS_MOST - 1);
  Item *item = &reading->items[reading->item_count++];
  *item = (Item){.text = text};
  if (name)
    strcpy(item->name, name);
  else
    item_name(item, own);
}

static void macro_add(Reading *reading, const char *line)
{
  char name[NAME_MOST], *text = NULL;
  size_t size;
  FILE *stream = open_memstream(&text, &size);
  const char *at = line + strlen("define");
  word_next(name, &at);
  conditions_add(stream, reading);
  fputs(at, stream);
  fclose(stream);
  item_add(reading, name, text, NULL);
}

// Follows a line that begins with #.
static void directive_follow(Reading *reading, const char *line)
{
  Condition *top = reading->conditions + (reading->depth ? reading->depth - 1 : 0);
  while (*line == '#' || *line == ' ') line++;
  if (!strncmp(line, "if", 2)) {
    assert_in_range(reading->depth, 0, DEPTH_MOST - 1);
    top = &reading->conditions[reading->depth++];
    top->value = condition_value(reading, line);
    snprintf(top->text, sizeof top->text, "%s", line);
  } else if (!strncmp(line, "el", 2)) {
    top->value = top->value < 0 ? -1 : top->value == 1 ? 0 : line[2] == 'i' ? condition_value(reading, line) : 1;
  } else if (!strncmp(line, "endif", 5)) {
    reading->depth--;
  } else if (!strncmp(line, "define", 6) && is_reached(reading)) {
    macro_add(reading, line);
  }
}

// Cuts what is read into items.
static void items_find(Reading *reading)
{
  char *own = NULL, line[LINE_MOST];
  size_t size = 0;
  int braces = 0;
  FILE *stream = NULL, *whole = fmemopen(reading->whole, strlen(reading->whole), "r");
  assert_non_null(whole);
  while (fgets(line, sizeof line, whole)) {
    char *comment = strstr(line, "//");
    line[comment ? (size_t)(comment - line) : strcspn(line, "\n")] = 0;
    const size_t length = strlen(line);
    if (line[strspn(line, " ")] == '#') directive_follow(reading, line + strspn(line, " "));
    if (line[strspn(line, " ")] == '#' || line[strspn(line, " ")] == 0 || !is_reached(reading)) continue;
    if (!stream) stream = open_memstream(&own, &size);
    fprintf(stream, "%s\n", line);
    if (stream && reading->depth > 0) conditions_add(stream, reading);
    for (const char *c = line; *c; c++) braces += (*c == '{') - (*c == '}');
    if (braces > 0 || (line[length - 1] != '}' && line[length - 1] != ';')) continue;
    fclose(stream);
    stream = NULL;
    item_add(reading, NULL, own, own);
  }
  assert_null(stream);
  fclose(whole);
}

static int items_compare(const void *a, const void *b)
{
  return strcmp(((const Item *)a)->name, ((const Item *)b)->name);
}

// The flags that an item and all that it names look at.
static uint32_t item_looks(Reading *reading, Item *item)
{
  uint32_t flags = 0;
  Item sought;
  item->seen = true;
  for (const char *at = item->text; word_next(sought.name, &at);) {
    flags |= flag_bit(sought.name);
    if (!strcmp(sought.name, "HAS_ALPHA")) continue;
    Item *found = bsearch(&sought, reading->items, (size_t)reading->item_count, sizeof *found, items_compare);
    while (found && found > reading->items && items_compare(found - 1, &sought) == 0) found--;
    for (Item *end = reading->items + reading->item_count; found && found < end; found++) {
      if (items_compare(found, &sought) != 0) break;
      if (!found->seen) flags |= item_looks(reading, found);
    }
  }
  return flags;
}

static Reading reading_begin(const char *path, const char *options)
{
  size_t size = 0;
  Reading reading = {.options = options, .items = calloc(ITEMS_MOST, sizeof(Item))};
  assert_non_null(reading.items);
  FILE *to = open_memstream(&reading.whole, &size);
  file_read(to, &reading, path);
  fclose(to);
  return reading;
}

static void reading_end(Reading *reading)
{
  for (int i = 0; i < reading->item_count; i++) free(reading->items[i].text);
  free(reading->items);
  free(reading->whole);
}

uint32_t scene_flags_looked_at(const char *path, const char *options)
{
  uint32_t flags = 0;
  Reading reading = reading_begin(path, options);
  items_find(&reading);
  qsort(reading.items, (size_t)reading.item_count, sizeof *reading.items, items_compare);
  for (int i = 0; i < reading.item_count; i++)
    if (reading.items[i].is_kernel && !reading.items[i].seen) flags |= item_looks(&reading, &reading.items[i]);
  reading_end(&reading);
  return flags;
}

bool kernel_file_holds(const char *path, const char *other)
{
  bool holds = false;
  Reading reading = reading_begin(path, "");
  for (int i = 0; i < reading.included_count; i++) holds |= !strcmp(reading.included[i], other);
  reading_end(&reading);
  return holds;
}
