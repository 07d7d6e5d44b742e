#include "app/light_shadows.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_NAMED = 8 };

// NAME=METHOD at the start of a text.
typedef struct LightMethod {
  const char *name;
  size_t name_length;
  ShadowMethod method;
} LightMethod;

// The method that a text begins with, up to a comma or its end; SHADOWS_AUTO + 1: none.
static ShadowMethod method_read(const char *text)
{
  const size_t length = strcspn(text, ",");
  int method = 0;
  while (shadow_words[method] && (strncmp(shadow_words[method], text, length) != 0 || shadow_words[method][length]))
    method++;
  return (ShadowMethod)method;
}

// Reads one of a list. A name may hold what separates them: it ends before the first = that a method comes after.
// Returns what is behind it, NULL: it is none.
static const char *light_method_read(LightMethod *out, const char *text)
{
  for (const char *equals = strchr(text, '='); equals; equals = strchr(equals + 1, '=')) {
    *out = (LightMethod){text, (size_t)(equals - text), method_read(equals + 1)};
    if (!shadow_words[out->method]) continue;
    const char *end = equals + 1 + strcspn(equals + 1, ",");
    if (out->name_length == 0 || (*end && !end[1])) return NULL;
    return *end ? end + 1 : end;
  }
  return NULL;
}

Status option_read_light_shadows(void *field, const Option *option, const char *text, Log *log)
{
  LightMethod one;
  char word[32];
  int index;
  const char *rest = text, *next;
  for (; *rest && (next = light_method_read(&one, rest)); rest = next) continue;
  if (*text && !*rest) {
    *(const char **)field = text;
    return STATUS_OK;
  }
  const char *equals = strchr(rest, '=');
  if (!equals || equals == rest || !equals[1]) return option_fail(log, option, text, "NAME=METHOD,NAME=METHOD,...");
  snprintf(word, sizeof word, "%.*s", (int)strcspn(equals + 1, ","), equals + 1);
  Option of_method = *option;
  of_method.words = shadow_words;
  Status status = option_read_word(&index, &of_method, word, log);
  return status ? status : option_fail(log, option, text, "a name and a method behind each comma");
}

static bool light_fits(const LightMethod *wanted, const Scene *scene, uint32_t light)
{
  const char *name = scene->lights[light].name;
  char *end = NULL;
  if (wanted->name[0] == '#' && wanted->name_length > 1) {
    unsigned long number = strtoul(wanted->name + 1, &end, 10);
    if (end == wanted->name + wanted->name_length) return number == light + 1ul;
  }
  return name && strlen(name) == wanted->name_length && !memcmp(name, wanted->name, wanted->name_length);
}

static Status light_unknown(const LightMethod *wanted, const Scene *scene, Log *log)
{
  char lights[512] = "none";
  size_t used = 0;
  for (uint32_t i = 0; i < scene->light_count && i < MOST_NAMED; i++)
    used += (size_t)snprintf(lights + used, sizeof lights - used, "%s#%u '%.32s'", i ? ", " : "", i + 1,
                             scene->lights[i].name ? scene->lights[i].name : "");
  if (scene->light_count > MOST_NAMED)
    snprintf(lights + used, sizeof lights - used, " and %u more: see frugal info", scene->light_count - MOST_NAMED);
  return log_fail(log, STATUS_USAGE, "--light-shadows: no light is called '%.*s': lights are: %s",
                  wanted->name_length > 64 ? 64 : (int)wanted->name_length, wanted->name, lights);
}

Status light_shadows_resolve(uint8_t **out, const RenderOptions *options, const Scene *scene, Log *log)
{
  Status status = STATUS_OK;
  LightMethod one;
  uint8_t *methods = NULL;
  *out = NULL;
  if (!options->light_shadows) return STATUS_OK;
  methods = malloc(scene->light_count + 1ull);
  if (!methods) return log_no_memory(log, "--light-shadows");
  memset(methods, (int)options->settings.shadows, scene->light_count + 1ull);
  for (const char *rest = options->light_shadows; *rest;) {
    rest = light_method_read(&one, rest);
    bool found = false;
    for (uint32_t i = 0; i < scene->light_count; i++) {
      if (!light_fits(&one, scene, i)) continue;
      methods[i] = (uint8_t)one.method;
      found = true;
    }
    if (!found) TRY(light_unknown(&one, scene, log));
  }
  *out = methods;
  methods = NULL;

done:
  free(methods);
  return status;
}
