// Scene files: what the schema allows is read, what it forbids is refused, and both know the same options.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <jansson.h>

#include "app/options.h"
#include "support/cli.h"

static Log test_log;

// Whether the parser takes a value for a key.
static bool takes(const char *key, json_t *value)
{
  RenderOptions options = {0};
  json_t *document = json_pack("{s:s, s:O}", "scene", "scene.glb", key, value);
  char *text = json_dumps(document, 0);
  const char *path = cli_path("taken.json");
  cli_scene();
  cli_save(path, text, strlen(text));
  test_log = (Log){0};
  Status status = render_options_read_file(&options, path, false, &test_log);
  render_options_free(&options);
  json_decref(document);
  free(text);
  return status == STATUS_OK;
}

static void must_take(const char *key, json_t *value, bool wanted)
{
  char *text = json_dumps(value, JSON_ENCODE_ANY);
  if (takes(key, value) != wanted) fail_msg("%s %s is %s: %s", key, text, wanted ? "refused" : "taken", test_log.error);
  free(text);
}

static void must_take_number(const char *key, double value, bool wanted)
{
  json_t *number = value == floor(value) ? json_integer((json_int_t)value) : json_real(value);
  must_take(key, number, wanted);
  json_decref(number);
}

// What one alternative of a property allows is taken, and a step beyond its limits is not. Returns its kind.
static uint32_t alternative_check(const Option *option, const json_t *allowed)
{
  size_t i;
  json_t *value, *words = json_object_get(allowed, "enum");
  const char *type = json_string_value(json_object_get(allowed, "type"));
  json_array_foreach(words, i, value) must_take(option->name, value, true);
  json_array_foreach(json_object_get(allowed, "examples"), i, value) must_take(option->name, value, true);
  if (json_object_get(allowed, "const")) must_take(option->name, json_object_get(allowed, "const"), true);
  if (!type) return OPTION_JSON_TEXT;
  if (!strcmp(type, "array")) {
    bool of_numbers = json_object_get(json_object_get(allowed, "items"), "type") != NULL;
    return of_numbers ? OPTION_JSON_NUMBERS : OPTION_JSON_TEXTS;
  }
  if (!strcmp(type, "object")) return OPTION_JSON_PAIRS;
  if (!strcmp(type, "boolean")) {
    must_take(option->name, json_true(), true);
    must_take(option->name, json_false(), true);
    return OPTION_JSON_FLAG;
  }
  if (!strcmp(type, "string")) return OPTION_JSON_TEXT;
  json_t *low = json_object_get(allowed, "minimum"), *high = json_object_get(allowed, "maximum");
  json_t *above = json_object_get(allowed, "exclusiveMinimum");
  if (low) must_take_number(option->name, json_number_value(low), true);
  if (above) must_take_number(option->name, json_number_value(above), false);
  if (high && !json_object_get(allowed, "multipleOf")) must_take_number(option->name, json_number_value(high), true);
  if (!option->high) return OPTION_JSON_NUMBER;  // told later: which camera, what the format's compression knows
  assert_true(json_number_value(low ? low : above) == option->low && json_number_value(high) == option->high);
  must_take_number(option->name, option->low - 1, false);
  must_take_number(option->name, option->high + 1, false);
  return OPTION_JSON_NUMBER;
}

// A value of each kind that is not among `kinds`.
static void others_check(const Option *option)
{
  json_t *values[] = {json_true(),         json_integer(1),       json_string("x"),
                      json_pack("[i]", 1), json_pack("[s]", "x"), json_pack("{s:s}", "x", "x")};
  for (uint32_t i = 0; i < 6; i++) {
    if (!(option->json >> i & 1)) must_take(option->name, values[i], false);
    json_decref(values[i]);
  }
  json_t *none[] = {json_null(), json_object(), json_pack("[[]]")};
  for (uint32_t i = 0; i < 3; i++) {
    must_take(option->name, none[i], false);
    json_decref(none[i]);
  }
}

static bool has_word(json_t *property, const char *word)
{
  char *text = json_dumps(property, JSON_COMPACT), quoted[64];
  snprintf(quoted, sizeof quoted, "\"%s\"", word);
  bool found = strstr(text, quoted) != NULL;
  free(text);
  return found;
}

static void the_schema_and_the_parser_agree(void **state)
{
  json_t *schema = json_load_file("scenes/scene.schema.json", JSON_REJECT_DUPLICATES, NULL);
  assert_non_null(schema);
  json_t *properties = json_object_get(schema, "properties"), *property, *value;
  size_t count = 0, k;
  for (const char *const *key = scene_file_keys; *key; key++, count++)
    if (!json_object_get(properties, *key)) fail_msg("the schema lacks %s", *key);
  for (size_t i = 0; i < render_command_line.option_count; i++) {
    const Option *option = &render_command_line.options[i];
    if (!option->name) continue;
    property = json_object_get(properties, option->name);
    if (!property != !option->json)
      fail_msg("%s: is a key of the %s alone", option->name, property ? "schema" : "parser");
    if (!property) continue;
    count++;
    uint32_t kinds = 0;
    json_t *alternatives = json_object_get(property, "anyOf");
    if (!alternatives) kinds = alternative_check(option, property);
    json_array_foreach(alternatives, k, value) kinds |= alternative_check(option, value);
    if (kinds != option->json) fail_msg("%s: kinds %u in the schema, %u read", option->name, kinds, option->json);
    others_check(option);
    for (int w = 0; option->words && option->words[w]; w++)
      if (!has_word(property, option->words[w])) fail_msg("%s: the schema lacks %s", option->name, option->words[w]);
  }
  assert_int_equal(count, json_object_size(properties));
  json_decref(schema);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_schema_and_the_parser_agree),
  };
  return cmocka_run_group_tests(tests, cli_set_up, cli_tear_down);
}
