#include "app/file_keys.h"

#include <stdlib.h>
#include <string.h>

#include <jansson.h>

#include "base/nearest.h"

enum { MOST_SHOWN = 60 };

static void number_add(FILE *out, const json_t *value)
{
  if (json_is_integer(value))
    fprintf(out, "%" JSON_INTEGER_FORMAT, json_integer_value(value));
  else
    fprintf(out, "%.17g", json_real_value(value));
}

// Adds a text in a list, which may not hold what separates them.
static bool word_add(FILE *out, const json_t *value)
{
  if (!json_is_string(value) || strpbrk(json_string_value(value), ", ")) return false;
  fputs(json_string_value(value), out);
  return true;
}

static bool list_add(FILE *out, const Option *option, const json_t *list)
{
  size_t i;
  json_t *value;
  json_array_foreach(list, i, value)
  {
    bool is_number = option->json & OPTION_JSON_NUMBERS && json_is_number(value);
    if (i > 0) fputc(option->between ? option->between : ',', out);
    if (is_number)
      number_add(out, value);
    else if (!(option->json & OPTION_JSON_TEXTS && word_add(out, value)))
      return false;
  }
  return true;
}

static bool pairs_add(FILE *out, json_t *pairs)
{
  const char *name, *between = "";
  json_t *value;
  json_object_foreach(pairs, name, value)
  {
    if (!*name || strchr(name, '=')) return false;
    fprintf(out, "%s%s=", between, name);
    if (!word_add(out, value)) return false;
    between = ",";
  }
  return true;
}

// The kinds that a value may be of.
static uint32_t kinds_of(const json_t *value)
{
  if (json_is_boolean(value)) return OPTION_JSON_FLAG;
  if (json_is_number(value)) return OPTION_JSON_NUMBER;
  if (json_is_string(value)) return OPTION_JSON_TEXT;
  if (json_is_array(value)) return OPTION_JSON_NUMBERS | OPTION_JSON_TEXTS;
  return json_is_object(value) ? OPTION_JSON_PAIRS : 0;
}

// A number, list or object as the command line would have it; false where something in it is not as it must be.
static bool value_add(FILE *out, const Option *option, json_t *value)
{
  if (json_is_object(value)) return pairs_add(out, value);
  if (json_is_array(value)) return list_add(out, option, value);
  number_add(out, value);
  return true;
}

static Status kind_wrong(const SceneFile *file, const Option *option, const json_t *value, Log *log)
{
  static const char *const kinds[] = {"true or false",     "a number",        "a text",
                                      "a list of numbers", "a list of texts", "an object of texts by name"};
  char expected[128] = "";
  for (uint32_t left = option->json, i = 0; left; left &= ~(1u << i), i++) {
    if (!(left >> i & 1)) continue;
    size_t used = strlen(expected);
    snprintf(expected + used, sizeof expected - used, "%s%s", used ? " or " : "", kinds[i]);
  }
  char *shown = json_dumps(value, JSON_ENCODE_ANY | JSON_COMPACT);
  Status status = log_fail(log, STATUS_BAD_SCENE, "%s: %s %.*s: not valid: expected %s", file->path, option->name,
                           MOST_SHOWN, shown ? shown : "", expected);
  free(shown);
  return status;
}

// Puts a number, list or object into the document as a text.
static Status value_join(json_t **value, SceneFile *file, const Option *option, Log *log)
{
  Status status = STATUS_OK;
  char *text = NULL;
  size_t size = 0;
  FILE *stream = open_memstream(&text, &size);
  if (!stream) return log_no_memory(log, file->path);
  const bool is_valid = value_add(stream, option, *value);
  const bool failed = fclose(stream) != 0;
  if (!is_valid) {
    status = kind_wrong(file, option, *value, log);
  } else {
    *value = failed ? NULL : json_string(text);
    if (json_object_set_new(file->document, option->name, *value) != 0) status = log_no_memory(log, file->path);
  }
  free(text);
  return status;
}

static Status key_unknown(const CommandLine *line, const SceneFile *file, const char *key, Log *log)
{
  const char **names = calloc(line->option_count + 8, sizeof *names);
  if (!names) return log_no_memory(log, file->path);
  size_t count = 0;
  for (size_t i = 0; scene_file_keys[i]; i++) names[count++] = scene_file_keys[i];
  for (size_t i = 0; i < line->option_count; i++)
    if (line->options[i].json) names[count++] = line->options[i].name;
  Status status = log_fail(log, STATUS_BAD_SCENE, "%s: %.100s: no such key: did you mean '%s'?", file->path, key,
                           nearest_name(key, names));
  free(names);
  return status;
}

static Status key_read(void *settings, const CommandLine *line, SceneFile *file, const char *key, json_t *value,
                       Log *log)
{
  Status status = STATUS_OK;
  Log own = {0};
  const Option *option = line->options, *end = line->options + line->option_count;
  while (option < end && (!option->name || strcmp(option->name, key) != 0)) option++;
  if (!strcmp(key, "help") || (option < end && !option->json))
    return log_fail(log, STATUS_BAD_SCENE, "%s: %s: says how to run, not what to show: give --%s on the command line",
                    file->path, key, key);
  if (option == end) return key_unknown(line, file, key, log);
  if (!(option->json & kinds_of(value))) return kind_wrong(file, option, value, log);
  if (json_is_false(value)) return STATUS_OK;
  if (!json_is_string(value) && !json_is_boolean(value)) TRY(value_join(&value, file, option, log));
  status = option->read((char *)settings + option->field, option, json_string_value(value), &own);
  if (!status) return STATUS_OK;
  const char *message = own.error + (strncmp(own.error, "--", 2) == 0 ? 2 : 0);
  status = log_fail(log, status == STATUS_USAGE ? STATUS_BAD_SCENE : status, "%s: %s", file->path, message);

done:
  return status;
}

Status file_keys_read(void *settings, const CommandLine *line, SceneFile *file, Log *log)
{
  Status status = STATUS_OK;
  const char *key;
  json_t *value;
  json_object_foreach(file->document, key, value)
  {
    bool is_scene = false;
    for (size_t i = 0; scene_file_keys[i]; i++) is_scene |= !strcmp(key, scene_file_keys[i]);
    if (!is_scene) TRY(key_read(settings, line, file, key, value, log));
  }

done:
  return status;
}
