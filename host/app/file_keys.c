#include "app/file_keys.h"

#include <stdlib.h>
#include <string.h>

#include <jansson.h>

#include "base/nearest.h"

enum { MOST_TEXT = 512, MOST_SHOWN = 60 };

typedef struct KeyText {
  char text[MOST_TEXT];
  size_t length;
} KeyText;

static bool text_add(KeyText *out, const char *text)
{
  size_t length = strlen(text);
  if (out->length + length >= sizeof out->text) return false;
  memcpy(out->text + out->length, text, length + 1);
  out->length += length;
  return true;
}

static bool number_add(KeyText *out, const json_t *value)
{
  char number[64];
  if (json_is_integer(value))
    snprintf(number, sizeof number, "%" JSON_INTEGER_FORMAT, json_integer_value(value));
  else
    snprintf(number, sizeof number, "%.17g", json_real_value(value));
  return text_add(out, number);
}

static bool list_add(KeyText *out, const Option *option, const json_t *list)
{
  const char between[] = {option->between ? option->between : ',', 0};
  size_t i;
  json_t *value;
  json_array_foreach(list, i, value)
  {
    bool is_number = option->json & OPTION_JSON_NUMBERS && json_is_number(value);
    bool is_text = option->json & OPTION_JSON_TEXTS && json_is_string(value);
    if (i > 0 && !text_add(out, between)) return false;
    if (is_text && strpbrk(json_string_value(value), ", ")) return false;
    if (!(is_number ? number_add(out, value) : is_text && text_add(out, json_string_value(value)))) return false;
  }
  return true;
}

// The value as the command line would have it; false where it is of none of the option's kinds.
static bool value_read(KeyText *out, const Option *option, const json_t *value)
{
  if (json_is_boolean(value)) return option->json & OPTION_JSON_FLAG;
  if (json_is_number(value)) return option->json & OPTION_JSON_NUMBER && number_add(out, value);
  if (json_is_array(value))
    return option->json & (OPTION_JSON_NUMBERS | OPTION_JSON_TEXTS) && list_add(out, option, value);
  return json_is_string(value) && option->json & OPTION_JSON_TEXT;
}

static Status kind_wrong(const SceneFile *file, const Option *option, const json_t *value, Log *log)
{
  static const char *const kinds[] = {"true or false", "a number", "a text", "a list of numbers", "a list of texts"};
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
  const Option *option = line->options, *end = line->options + line->option_count;
  while (option < end && (!option->name || strcmp(option->name, key) != 0)) option++;
  if (!strcmp(key, "help") || (option < end && !option->json))
    return log_fail(log, STATUS_BAD_SCENE, "%s: %s: says how to run, not what to show: give --%s on the command line",
                    file->path, key, key);
  if (option == end) return key_unknown(line, file, key, log);
  KeyText text = {0};
  if (!value_read(&text, option, value)) return kind_wrong(file, option, value, log);
  if (json_is_false(value)) return STATUS_OK;
  if (!json_is_string(value) && !json_is_boolean(value)) {
    value = json_string(text.text);
    if (json_object_set_new(file->document, key, value) != 0) return log_no_memory(log, file->path);
  }
  Log own = {0};
  Status status = option->read((char *)settings + option->field, option, json_string_value(value), &own);
  if (!status) return STATUS_OK;
  const char *message = own.error + (strncmp(own.error, "--", 2) == 0 ? 2 : 0);
  return log_fail(log, status == STATUS_USAGE ? STATUS_BAD_SCENE : status, "%s: %s", file->path, message);
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
