#include "passes/known_hits.h"

#include "passes/scene_args.h"

Status known_hits_make(KnownHits *out, Device *device, uint32_t capacity, bool wanted, Log *log)
{
  Status status = STATUS_OK;
  KnownHits known = {0};
  Program *program = NULL;
  TRY(ray_stream_make(&known.rays, device, capacity, wanted, "rays", log));
  if (wanted) {
    TRY(program_build(&program, device, "rays/append_hits.cl", "", log));
    TRY(program_kernel(&known.append, program, "append_hits", log));
    TRY(hit_stream_make(&known.hits, device, capacity, log));
  }
  *out = known;
  known = (KnownHits){0};

done:
  known_hits_free(&known);
  return status;
}

void known_hits_free(KnownHits *known)
{
  kernel_free(&known->append);
  ray_stream_free(&known->rays);
  hit_stream_free(&known->hits);
  *known = (KnownHits){0};
}

Status known_hits_append(const KnownHits *known, Device *device, const LeftRays *left, const RayStream *rays,
                         const HitStream *hits, Log *log)
{
  if (left->known == 0) return STATUS_OK;
  return device_launch(
      device, &known->append, work_items(device, left->known), left->known, "bring in rays whose hits are known",
      ARGS(ARG(left->known), ARG(left->traced), ARG(rays->capacity), ARG_BUFFER(known->rays.rays),
           ARG_BUFFER(known->rays.slots), ARG_BUFFER(known->hits.hits), ARG_BUFFER(known->hits.ids),
           ARG_BUFFER(rays->rays), ARG_BUFFER(rays->slots), ARG_BUFFER(hits->hits), ARG_BUFFER(hits->ids)),
      log);
}
