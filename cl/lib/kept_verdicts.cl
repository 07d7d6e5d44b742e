// Verdicts of shadow rays that a sequence keeps from frame to frame (shared/shadow.h).

#include "lib/sure_named.cl"

// Where a picture's are; `slots` of 0: nowhere. Bit VIEWS x light + view of `stayed`: what that view sees did not move.
typedef struct KeptVerdicts {
  global float *words;
  uint slots, stayed;
} KeptVerdicts;

// Those of LANES neighbouring slots: as they were, and as they are.
typedef struct SlotVerdicts {
  UintL before, now;
} SlotVerdicts;

static inline global uint *verdicts_known(const KeptVerdicts *kept, uint slot)
{
  return (global uint *)(kept->words + VERDICT_KNOWN * kept->slots) + slot;
}

// What was known of slots whose shadow rays begin at `origin` as they did.
static inline SlotVerdicts verdicts_load(const KeptVerdicts *kept, uint slot, Vec3L origin, IntL hit)
{
  SlotVerdicts v = {UINTL(0), UINTL(0)};
  if (!kept->slots) return v;
  UintL known = LANE_LOAD(verdicts_known(kept, slot), 0);
  IntL same = hit & (known != UINTL(0));
  if (!any_lane(same)) return v;
  global const float *from = kept->words + slot;
  same = same & (LANE_LOAD(from, 0) == origin.x) & (LANE_LOAD(from + kept->slots, 0) == origin.y) &
         (LANE_LOAD(from + 2 * kept->slots, 0) == origin.z);
  v.before = same ? known : v.before;
  return v;
}

// Forgets those of slots that hit nothing.
static inline void verdicts_forget(const KeptVerdicts *kept, uint slot)
{
  if (kept->slots) LANE_STORE(UINTL(0), verdicts_known(kept, slot), 0);
}

static inline void verdicts_store(const KeptVerdicts *kept, uint slot, const SlotVerdicts *v, Vec3L origin)
{
  if (!kept->slots) return;
  global float *to = kept->words + slot;
  LANE_STORE(v->now, verdicts_known(kept, slot), 0);
  LANE_STORE(origin.x, to, 0);
  LANE_STORE(origin.y, to + kept->slots, 0);
  LANE_STORE(origin.z, to + 2 * kept->slots, 0);
}

// Judges the rays `active` to light `light` of the first, of which some may be known.
static inline Verdicts kept_judge(SlotVerdicts *v, const KeptVerdicts *kept, uint light, const SureRays *rays,
                                  global const ShadowInfo *info, global const ShadowView *views, const SureSources *of,
                                  IntL active, const AttributeSources *attributes)
{
  Verdicts verdicts = {INTL(0), INTL(0), INTL(0), UINTL(0), FLOATL(0)};
  UintL view = UINTL(0), known = UINTL(0), zero = UINTL(0);
  if (kept->slots) {
    UintL entry = v->before >> (light * VERDICT_BITS) & UINTL((1u << VERDICT_BITS) - 1);
    UintL stayed = UINTL(kept->stayed >> light * SHADOW_VIEWS_MOST) >> (entry >> 2u) & UINTL(1);
    known = (active & (stayed != zero)) ? entry : zero;
  }
  IntL asks = active & ((known & UINTL(VERDICT_LIT | VERDICT_DARK)) == zero);
  if (any_lane(asks)) {
    verdicts = sure_judge(&view, rays, info, views, of, asks, attributes);
    UintL found = verdicts.lit ? UINTL(VERDICT_LIT) : verdicts.dark ? UINTL(VERDICT_DARK) : zero;
    known = (asks & (found != zero)) ? found | view << 2u : known;
  }
  verdicts.lit = verdicts.lit | ((known & UINTL(VERDICT_LIT)) != zero);
  verdicts.dark = verdicts.dark | ((known & UINTL(VERDICT_DARK)) != zero);
  v->now |= known << (light * VERDICT_BITS);
  return verdicts;
}
