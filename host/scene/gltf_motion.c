#include "scene/gltf_motion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene/gltf_animation.h"
#include "scene/gltf_nodes.h"

struct GltfMotion {
  char *path;
  GltfOptions options;
  Gltf gltf;  // its model's nodes are `nodes`
  GltfAnimation animation;
  GltfNode *nodes;   // [node_count], as posed last
  double **weights;  // [node_count]: of a node whose weights move, where nodes[].weights points, else NULL
  GltfPlaces places;
};

// An animation of the file by name or index, or its first; false where it has none and none is asked for.
static Status animation_choose(bool *out, uint32_t *index, Gltf *gltf, const char *choice)
{
  uint32_t count = gltf->model->animation_count;
  *index = 0;
  *out = choice || count > 0;
  if (choice) return gltf_animation_find(index, gltf, choice);
  if (count > 1)
    log_info(gltf->log, "%s: animation 0 '%.64s' of %u is followed: choose with --animation", gltf->path,
             gltf_animation_name(gltf, 0), count);
  return STATUS_OK;
}

// A node whose weights move has its own from the start, so that what it draws is a mesh of its own.
static Status weights_own(GltfMotion *motion, const GltfTrack *track)
{
  Status status = STATUS_OK;
  GltfNode *node = &motion->nodes[track->node];
  const GltfMesh *mesh = &motion->gltf.model->meshes[node->mesh];
  const double *rest = node->weights ? node->weights : mesh->weights;
  uint32_t rest_count = node->weights ? node->weight_count : mesh->weight_count;
  double *own = NULL;
  TRY(gltf_allocate(&own, &motion->gltf, track->width, sizeof *own));
  for (uint32_t i = 0; i < track->width && i < rest_count; i++) own[i] = rest[i];
  motion->weights[track->node] = own;
  node->weights = own;
  node->weight_count = track->width;

done:
  return status;
}

static Status nodes_own(GltfMotion *motion)
{
  Status status = STATUS_OK;
  GltfModel *model = motion->gltf.model;
  TRY(gltf_allocate(&motion->weights, &motion->gltf, model->node_count, sizeof(double *)));
  TRY(gltf_allocate(&motion->nodes, &motion->gltf, model->node_count, sizeof *motion->nodes));
  for (uint32_t i = 0; i < model->node_count; i++) motion->nodes[i] = model->nodes[i];
  model->nodes = motion->nodes;
  for (uint32_t i = 0; i < motion->animation.track_count; i++)
    if (motion->animation.tracks[i].path == TRACK_WEIGHTS) TRY(weights_own(motion, &motion->animation.tracks[i]));

done:
  return status;
}

Status gltf_motion_open(GltfMotion **out, Scene *scene, const char *path, const GltfOptions *options,
                        const char *animation, ImageHelper *images, Log *log)
{
  Status status = STATUS_OK;
  bool moves = false;
  uint32_t index = 0;
  GltfMotion *motion = calloc(1, sizeof *motion);
  if (!motion || !(motion->path = strdup(path))) {
    status = log_no_memory(log, path);
    goto done;
  }
  motion->options = *options;
  motion->gltf = (Gltf){.path = motion->path, .options = &motion->options, .images_helper = images, .log = log};
  TRY(gltf_open(&motion->gltf));
  TRY(animation_choose(&moves, &index, &motion->gltf, animation));
  if (moves) TRY(gltf_animation_read(&motion->animation, &motion->gltf, index));
  TRY(nodes_own(motion));
  TRY(gltf_scene_read(scene, &motion->places, &motion->gltf));
  motion->gltf.images_helper = NULL;
  *out = motion;
  motion = NULL;

done:
  gltf_motion_close(motion);
  return status;
}

double gltf_motion_length_s(const GltfMotion *motion) { return motion->animation.length_s; }

static void nodes_pose(GltfMotion *motion, double time_s)
{
  for (uint32_t i = 0; i < motion->animation.track_count; i++) {
    const GltfTrack *track = &motion->animation.tracks[i];
    GltfNode *node = &motion->nodes[track->node];
    double *const places[TRACK_PATH_COUNT] = {node->translation, node->rotation, node->scale,
                                              motion->weights[track->node]};
    gltf_track_sample(places[track->path], track, time_s);
  }
}

static Status mesh_pose(GltfMotion *motion, Mesh *mesh, const GltfNode *node, const Mat4 *worlds)
{
  Status status = STATUS_OK;
  GltfPose pose;
  Mat4 *joints = NULL;
  TRY(gltf_node_pose(&pose, &joints, &motion->gltf, node, worlds));
  TRY(gltf_mesh_pose(mesh, &motion->gltf, node->mesh, &pose));

done:
  free(joints);
  return status;
}

Status gltf_motion_pose(GltfMotion *motion, Scene *scene, double time_s, Log *log)
{
  Status status = STATUS_OK;
  Gltf *gltf = &motion->gltf;
  uint64_t used_bytes = gltf->used_bytes;
  Mat4 *worlds = NULL;
  gltf->log = log;
  if (isnan(time_s))
    return log_fail(log, STATUS_USAGE, "%s: a pose at a time that is not a number: name one", gltf->path);
  nodes_pose(motion, time_s);
  TRY(gltf_world_transforms(&worlds, gltf));
  TRY(gltf_places_apply(scene, gltf, &motion->places, worlds));
  for (uint32_t i = 0; i < scene->mesh_count; i++) {
    int node = motion->places.meshes[i];
    if (node == NONE || (motion->nodes[node].skin == NONE && !motion->weights[node])) continue;
    TRY(mesh_pose(motion, &scene->meshes[i], &motion->nodes[node], worlds));
  }

done:
  gltf->used_bytes = used_bytes;  // all that a pose needs is freed with it
  free(worlds);
  return status;
}

void gltf_motion_close(GltfMotion *motion)
{
  if (!motion) return;
  for (uint32_t i = 0; motion->weights && i < motion->gltf.model->node_count; i++) free(motion->weights[i]);
  free(motion->weights);
  free(motion->nodes);
  gltf_animation_free(&motion->animation);
  gltf_places_free(&motion->places);
  gltf_close(&motion->gltf);
  free(motion->path);
  free(motion);
}
