#include "app/verify.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "render/probe_render.h"
#include "report/image_compare.h"

static bool is_random(const Plan *plan)
{
  return plan->lobes || plan_uses_shadows(plan, SHADOW_SET(SHADOWS_AREA)) ||
         plan->environment_light == ENVIRONMENT_LIGHT_SH_AO;
}

static bool same_but_shadows(const Plan *a, const Plan *b)
{
  return a->lobes == b->lobes && a->reflections == b->reflections && a->deep_reflections == b->deep_reflections &&
         a->max_depth == b->max_depth && a->environment_light == b->environment_light &&
         a->max_roughness <= b->max_roughness && a->max_roughness >= b->max_roughness;
}

// Pictures of the same size.
typedef struct Verification {
  float *picture, *reference, *half, *lit;
  bool *edges;
  ProbeSet probes;
} Verification;

// What of the reference is without shadows is asked for by v->lit.
static Status reference_render(Verification *v, const VerifySources *sources, const Plan *plan, uint32_t passes,
                               bool lit, Log *log)
{
  ProbeRender render = {
      .request = sources->frame->request, .passes = passes, .probes = &v->probes, .picture = sources->picture};
  render.request.plan = *plan;
  render.request.aovs = AOV_SET_NONE;
  render.request.progress = NULL;
  const ProbePictures out = {v->reference, v->half, lit ? v->lit : NULL};
  return probes_render(&out, sources->frame->device, sources->frame->scene, &render, log);
}

// What shadows put off, by the reference that was rendered last.
static Status shadows_measure(VerifyResult *out, Verification *v, uint32_t width, Log *log)
{
  Status status = STATUS_OK;
  probe_edges(v->edges, v->lit, width, &v->probes);
  TRY(probe_error_make(&out->shadows, v->picture, v->reference, NULL, width, &v->probes, log));
  TRY(probe_error_make(&out->edges, v->picture, v->reference, v->edges, width, &v->probes, log));

done:
  return status;
}

static Status probes_measure(VerifyResult *out, Verification *v, const VerifySources *sources, Log *log)
{
  Status status = STATUS_OK;
  const RenderSettings *settings = &sources->options->settings;
  const Plan *shown = &sources->frame->request.plan;
  uint32_t width = sources->frame->camera.info.width, samples = settings->samples;
  RenderSettings exact = settings_exact(settings), shadows = *settings;
  shadows.primary = exact.primary;
  shadows.shadows = exact.shadows;
  shadows.allowed_shadows = exact.allowed_shadows;
  Plan reference = plan_make(&exact, sources->facts), partly = plan_make(&shadows, sources->facts);
  uint32_t passes = is_random(&reference) ? (VERIFY_SAMPLES + samples - 1) / samples : 1;
  if (is_random(&reference) && passes < 2) passes = 2;
  TRY(picture_shown(v->picture, sources->frame, sources->picture, log));
  bool shadows_alone = partly.shadow_rays && same_but_shadows(shown, &reference);
  TRY(reference_render(v, sources, &reference, passes, shadows_alone, log));
  TRY(probe_error_make(&out->error, v->picture, v->reference, NULL, width, &v->probes, log));
  out->reference_samples = passes * samples;
  if (passes > 1) {
    ProbeError noise;
    TRY(probe_error_make(&noise, v->half, v->reference, NULL, width, &v->probes, log));
    out->noise = noise.off.share;
  }
  if (!partly.shadow_rays) goto done;
  if (shadows_alone) {
    out->has_shadows = passes == 1 || !shown->lobes;
    TRY(shadows_measure(out, v, width, log));
    goto done;
  }
  // With the same seed all else is the same, noise too; a light's own noise would have to be averaged away with it.
  const bool area = plan_uses_shadows(&partly, SHADOW_SET(SHADOWS_AREA));
  out->has_shadows = !area || !is_random(shown);
  if (!out->has_shadows) goto done;
  TRY(reference_render(v, sources, &partly, area ? passes : 1, true, log));
  TRY(shadows_measure(out, v, width, log));

done:
  return status;
}

Status verify_picture(VerifyResult *out, const VerifySources *sources, Log *log)
{
  Status status = STATUS_OK;
  const RenderOptions *options = sources->options;
  const CameraInfo *camera = &sources->frame->camera.info;
  size_t pixels = (size_t)camera->width * camera->height, values = pixels * 4;
  Verification v = {.picture = malloc(values * sizeof *v.picture),
                    .reference = malloc(values * sizeof *v.reference),
                    .half = malloc(values * sizeof *v.half),
                    .lit = malloc(pixels * sizeof *v.lit),
                    .edges = calloc(pixels, sizeof *v.edges)};
  *out = (VerifyResult){0};
  if (!v.picture || !v.reference || !v.half || !v.lit || !v.edges) {
    status = log_no_memory(log, "--verify");
    goto done;
  }
  uint64_t wanted = options->verify.all ? UINT64_MAX / 2 : options->verify.pixels;
  TRY(probes_choose(&v.probes, camera->width, camera->height, wanted, options->seed, log));
  TRY(probes_measure(out, &v, sources, log));
  out->probes = v.probes.count;
  out->all = v.probes.all;

done:
  probes_free(&v.probes);
  free(v.picture);
  free(v.reference);
  free(v.half);
  free(v.lit);
  free(v.edges);
  return status;
}

void verify_say(const VerifyResult *result, const ShadowBound *bound, const BoundShare *reflections, const char *path,
                Log *log)
{
  const Proportion *off = &result->error.off;
  char how[160], shadows[256] = "", mirrors[64] = "", noise[96] = "";
  if (result->all)
    snprintf(how, sizeof how, "all %llu traced", (unsigned long long)result->error.pixels);
  else
    snprintf(how, sizeof how, "%.3g to %.3g %% with 95 %% confidence: %llu traced in %u tiles", 100 * off->low,
             100 * off->high, (unsigned long long)result->error.pixels, result->probes);
  if (result->has_shadows)
    snprintf(shadows, sizeof shadows,
             "; by shadows %.3g %% too dark, %.3g %% too light; at their edges %.3g and %.3g %% of %llu pixels",
             100 * result->shadows.dark.share, 100 * result->shadows.light.share, 100 * result->edges.dark.share,
             100 * result->edges.light.share, (unsigned long long)result->edges.pixels);
  size_t length = strlen(shadows);
  if (bound) snprintf(shadows + length, sizeof shadows - length, ", %.3g %% stated by their maps", 100 * bound->bound);
  if (reflections) snprintf(mirrors, sizeof mirrors, "; %.3g %% stated by reflection maps", 100 * reflections->bound);
  if (result->noise > 0) snprintf(noise, sizeof noise, "; %.3g %% by the reference's own noise", 100 * result->noise);
  log_info(log, "%s: %.3g %% of the pixels are off by more than 2/255 (%s)%s%s%s", path, 100 * off->share, how, shadows,
           mirrors, noise);
}

static json_t *proportion_json(const Proportion *p)
{
  return json_pack("{s:f, s:f, s:f}", "share", p->share, "low", p->low, "high", p->high);
}

static json_t *shadows_json(const ProbeError *error)
{
  return json_pack("{s:I, s:o, s:o, s:o}", "pixels", (json_int_t)error->pixels, "off", proportion_json(&error->off),
                   "false_dark", proportion_json(&error->dark), "false_light", proportion_json(&error->light));
}

json_t *verify_json(const VerifyResult *result)
{
  json_t *out = json_pack("{s:f, s:f, s:I, s:i, s:b, s:i, s:f, s:o}", "threshold", IMAGE_THRESHOLD, "confidence", 0.95,
                          "pixels", (json_int_t)result->error.pixels, "tiles", (int)result->probes, "all",
                          (int)result->all, "reference_samples", (int)result->reference_samples, "noise", result->noise,
                          "off", proportion_json(&result->error.off));
  if (out && result->has_shadows) {
    json_t *shadows = shadows_json(&result->shadows);
    json_object_set_new(shadows, "edges", shadows_json(&result->edges));
    json_object_set_new(out, "shadows", shadows);
  }
  return out;
}
