#include "passes/kept_verdicts.h"

#include "shared/shade.h"

_Static_assert(VERDICT_LIGHTS == LIGHTS_PER_LAUNCH, "those of a launch are kept");
_Static_assert(VERDICT_LIGHTS *SHADOW_VIEWS_MOST <= 32, "a bit a view");
_Static_assert(VERDICT_LIGHTS *VERDICT_BITS <= 32, "a word a slot");

static const uint64_t slots_most = UINT32_MAX / VERDICT_FIELDS;

static uint32_t views_stayed(const SureMaps *maps)
{
  uint32_t stayed = 0;
  for (uint32_t light = 0; light < maps->light_count && light < VERDICT_LIGHTS; light++)
    for (uint32_t view = 0; view < maps->lights[light].view_count; view++)
      stayed |= (uint32_t)maps->stayed[light][view] << (light * SHADOW_VIEWS_MOST + view);
  return stayed;
}

Status kept_verdicts_make(KeptVerdicts *out, KeptVerdicts *before, Device *device, const SureMaps *maps, uint64_t slots,
                          uint64_t bytes_most, Log *log)
{
  Status status = STATUS_OK;
  const uint64_t bytes = slots * VERDICT_FIELDS * sizeof(uint32_t);
  KeptVerdicts kept = {.slots = (uint32_t)slots, .stayed = views_stayed(maps)};
  if (kept.stayed == 0 || bytes > bytes_most || slots > slots_most) return STATUS_OK;
  if (before && before->slots == slots) {
    kept.words = before->words;
    *before = (KeptVerdicts){0};
  } else {
    TRY(buffer_create(&kept.words, device, bytes, NULL, "kept verdicts", log));
    TRY(buffer_fill_part(device, &kept.words, VERDICT_KNOWN * slots, slots, 0, log));
  }
  *out = kept;
  kept = (KeptVerdicts){0};

done:
  kept_verdicts_free(&kept);
  return status;
}

void kept_verdicts_free(KeptVerdicts *kept)
{
  buffer_free(&kept->words);
  *kept = (KeptVerdicts){0};
}
