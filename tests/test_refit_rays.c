// Rays meet in a refitted tree what they meet in one built anew, hit by hit.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/picture_fixture.h"
#include "support/trace_rays.h"

static uint32_t spans_named(const Timeline *timeline, const char *name)
{
  uint32_t count = 0;
  for (size_t i = 0; i < timeline->count; i++) count += strcmp(timeline->spans[i].name, name) == 0;
  return count;
}

enum { RAYS = 24000 };

// Tracing sets the traits of one width or another; scenes are made with both trees.
static void device_walk_both_trees(Device *device)
{
  DeviceTraits traits = *device_traits(device);
  traits.wide_bvh = true;
  device_override_traits(device, &traits);
}

// All kernels find the same hits, and block the same rays, in both scenes.
static void assert_same_hits(TraceFixture *fixture, const DeviceScene *a, const DeviceScene *b, const TraceRay *rays)
{
  TraceHit *hits[2];
  bool *lit[2];
  for (int kernel = 0; kernel < TRACE_KERNELS; kernel++) {
    for (int i = 0; i < 2; i++) {
      hits[i] = oracle_array(RAYS, sizeof *hits[i]);
      lit[i] = oracle_array(RAYS, sizeof *lit[i]);
      fixture->scene = i ? *b : *a;
      trace_fixture_closest(hits[i], fixture, (TraceKernel)kernel, rays, RAYS, 0);
      trace_fixture_lit(lit[i], fixture, (TraceKernel)kernel, rays, RAYS);
    }
    uint32_t found = 0, blocked = 0;
    for (uint32_t r = 0; r < RAYS; r++) {
      if (memcmp(&hits[0][r], &hits[1][r], sizeof hits[0][r]) || lit[0][r] != lit[1][r]) {
        trace_ray_print(trace_kernel_names[kernel], &rays[r], r);
        fail_msg("triangle %u at %.9g, lit %d; refitted %u at %.9g, lit %d", hits[1][r].triangle, hits[1][r].t,
                 lit[1][r], hits[0][r].triangle, hits[0][r].t, lit[0][r]);
      }
      found += hits[0][r].triangle != ORACLE_MISS;
      blocked += !lit[0][r];
    }
    assert_in_range(found, RAYS / 20, RAYS - 1);
    assert_in_range(blocked, RAYS / 20, RAYS - 1);
    for (int i = 0; i < 2; i++) free(hits[i]), free(lit[i]);
  }
}

// Triangles of many kinds, and all flags.
static Soup soup_make(void)
{
  static const float center[3] = {1, 0.5f, 0};
  Soup soup = {0};
  soup_sphere(&soup, 20, 1, center, 0.2f);
  soup_random(&soup, 3000, 2, 0.2f, 21);
  soup_coplanar(&soup, 200, 0.5f, 22);
  soup_slivers(&soup, 300, 23);
  for (uint32_t i = 0; i < soup.triangle_count; i++) soup.flags[i] = i / 64 % 4;
  return soup;
}

static void soup_move(Soup *soup, Random *random, float shake)
{
  for (uint32_t i = 0; i < soup->vertex_count; i++) {
    float *at = soup->positions[i], x = at[0];
    at[0] = 0.96f * x - 0.28f * at[2] + random_between(random, -shake, shake);
    at[2] = 0.28f * x + 0.96f * at[2] + 0.25f * at[1];
  }
}

// The model has vertices of its own for each triangle, in the soup's order, primitive by primitive.
static void model_follow(Scene *model, const Soup *soup)
{
  uint32_t triangle = 0;
  for (uint32_t p = 0; p < model->meshes[0].primitive_count; p++) {
    Primitive *primitive = &model->meshes[0].primitives[p];
    for (uint32_t i = 0; i < primitive->vertex_count; i++)
      memcpy(primitive->positions[i], soup->positions[soup->triangles[triangle + i / 3][i % 3]],
             sizeof *primitive->positions);
    triangle += primitive->triangle_count;
  }
}

static void rays_meet_the_same_in_a_refitted_tree(void **state)
{
  Soup soup = soup_make();
  TraceFixture fixture;
  trace_fixture_make(&fixture, &soup);
  const DeviceScene own = fixture.scene;
  Timeline timeline = {0};
  DeviceScene moving, fresh;
  device_walk_both_trees(fixture.device);
  picture_assert_ok(device_scene_make_movable(&moving, fixture.device, &fixture.model, NULL, &picture_log));
  Random random = random_make(5);
  TraceRay *rays = oracle_array(RAYS, sizeof *rays);
  for (int frame = 0; frame < 3; frame++) {
    soup_move(&soup, &random, frame == 2 ? 0.05f : 0);
    model_follow(&fixture.model, &soup);
    device_walk_both_trees(fixture.device);
    picture_assert_ok(device_scene_move(&moving, fixture.device, &timeline, &picture_log));
    assert_int_equal(moving.mover_count, 1);
    picture_assert_ok(device_scene_make(&fresh, fixture.device, &fixture.model, NULL, &picture_log));
    trace_rays_make(rays, RAYS, &soup, (uint64_t)frame);
    assert_same_hits(&fixture, &moving, &fresh, rays);
    device_scene_free(&fresh);
  }
  assert_int_equal(spans_named(&timeline, "refit the BVH"), 3);
  assert_in_range(spans_named(&timeline, "build the BVH"), 0, 1);  // at least two trees were refitted ones
  timeline_free(&timeline);
  free(rays);
  device_scene_free(&moving);
  fixture.scene = own;
  trace_fixture_free(&fixture);
  soup_free(&soup);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(rays_meet_the_same_in_a_refitted_tree),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
