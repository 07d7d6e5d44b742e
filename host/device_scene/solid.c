#include "device_scene/solid.h"

#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"

// Vertices of a mesh that lie at the same place have the same number.
typedef struct Weld {
  const float **places;  // by number
  uint32_t *table;       // number + 1, open addressing
  uint32_t mask, count;
} Weld;

typedef struct Edge {
  uint32_t low, high;  // numbers of its ends
  int32_t balance;     // triangles that pass it upwards less those that pass it downwards
} Edge;

typedef struct MeshWork {
  Weld weld;
  Edge *edges;  // open addressing; balance and ends 0 where unused
  uint32_t edge_mask;
  uint32_t *parents;  // union-find over vertices
  uint8_t *open;      // by vertex: an edge of its piece is open
  uint32_t (*corners)[3];
} MeshWork;

static uint32_t power_of_two_above(uint64_t count)
{
  uint32_t size = 16;
  while (size < count) size *= 2;
  return size;
}

static uint32_t hash_words(const uint32_t *words, int count)
{
  uint32_t hash = 2166136261u;
  for (int i = 0; i < count; i++) hash = (hash ^ words[i]) * 0x9e3779b1u ^ hash >> 15;
  return hash ^ hash >> 16;
}

static uint32_t weld_number(Weld *weld, const float *place)
{
  uint32_t words[3];
  float clean[3] = {place[0] + 0.0f, place[1] + 0.0f, place[2] + 0.0f};  // -0 is 0
  memcpy(words, clean, sizeof words);
  for (uint32_t at = hash_words(words, 3) & weld->mask;; at = (at + 1) & weld->mask) {
    uint32_t number = weld->table[at];
    if (!number) {
      weld->places[weld->count] = place;
      weld->table[at] = ++weld->count;
      return weld->count - 1;
    }
    const float *other = weld->places[number - 1];
    if (other[0] == place[0] && other[1] == place[1] && other[2] == place[2]) return number - 1;
  }
}

static Edge *edge_find(MeshWork *work, uint32_t from, uint32_t to)
{
  uint32_t ends[2] = {from < to ? from : to, from < to ? to : from};
  uint32_t at = hash_words(ends, 2) & work->edge_mask;
  for (;; at = (at + 1) & work->edge_mask) {
    Edge *edge = &work->edges[at];
    if (edge->low == edge->high) *edge = (Edge){ends[0], ends[1], 0};
    if (edge->low == ends[0] && edge->high == ends[1]) return edge;
  }
}

static uint32_t root_of(uint32_t *parents, uint32_t at)
{
  while (parents[at] != at) at = parents[at] = parents[parents[at]];
  return at;
}

static uint32_t mesh_triangles(const Mesh *mesh)
{
  uint32_t count = 0;
  for (uint32_t p = 0; p < mesh->primitive_count; p++) count += mesh->primitives[p].triangle_count;
  return count;
}

static void work_free(MeshWork *work)
{
  free(work->weld.places);
  free(work->weld.table);
  free(work->edges);
  free(work->parents);
  free(work->open);
  free(work->corners);
}

static bool work_make(MeshWork *out, const Mesh *mesh, uint32_t triangles)
{
  uint64_t vertices = 0;
  for (uint32_t p = 0; p < mesh->primitive_count; p++) vertices += mesh->primitives[p].vertex_count;
  uint32_t table = power_of_two_above(2 * vertices), edges = power_of_two_above(6ull * triangles);
  *out = (MeshWork){
      .weld = {.places = malloc((vertices + 1) * sizeof *out->weld.places),
               .table = calloc(table, sizeof *out->weld.table),
               .mask = table - 1},
      .edges = calloc(edges, sizeof *out->edges),
      .edge_mask = edges - 1,
      .parents = malloc((vertices + 1) * sizeof *out->parents),
      .open = calloc(vertices + 1, 1),
      .corners = malloc((triangles + 1ull) * sizeof *out->corners),
  };
  return out->weld.places && out->weld.table && out->edges && out->parents && out->open && out->corners;
}

// Numbers of the corners of all triangles. Those of a masked or blended material leave their vertices open.
static void mesh_weld(MeshWork *work, const Scene *scene, const Mesh *mesh)
{
  uint32_t triangle = 0;
  for (uint32_t p = 0; p < mesh->primitive_count; p++) {
    const Primitive *primitive = &mesh->primitives[p];
    bool opaque = scene->materials[primitive->material].alpha_mode == ALPHA_OPAQUE;
    for (uint32_t i = 0; i < primitive->triangle_count; i++, triangle++)
      for (int k = 0; k < 3; k++) {
        uint32_t number = weld_number(&work->weld, primitive->positions[primitive->triangles[i][k]]);
        work->corners[triangle][k] = number;
        if (!opaque) work->open[number] = 1;
      }
  }
}

static void pieces_find(uint32_t *piece_of, MeshWork *work, uint32_t triangles)
{
  for (uint32_t i = 0; i < work->weld.count; i++) work->parents[i] = i;
  for (uint32_t t = 0; t < triangles; t++)
    for (int k = 0; k < 3; k++) {
      uint32_t from = work->corners[t][k], to = work->corners[t][(k + 1) % 3];
      if (from == to) continue;
      edge_find(work, from, to)->balance += from < to ? 1 : -1;
      uint32_t a = root_of(work->parents, from), b = root_of(work->parents, to);
      if (a != b) work->parents[a < b ? b : a] = a < b ? a : b;
    }
  for (uint32_t i = 0; i < work->weld.count; i++)
    if (work->open[i]) work->open[root_of(work->parents, i)] = 1;
  for (uint32_t i = 0; i <= work->edge_mask; i++)
    if (work->edges[i].balance) work->open[root_of(work->parents, work->edges[i].low)] = 1;
  for (uint32_t t = 0; t < triangles; t++) {
    uint32_t root = root_of(work->parents, work->corners[t][0]);
    piece_of[t] = work->open[root] ? SOLID_NONE : root;
  }
}

typedef struct MeshSearch {
  Solids *solids;
  bool *failed;  // by mesh
} MeshSearch;

static void mesh_search(void *context, size_t index)
{
  MeshSearch *search = context;
  const Scene *scene = search->solids->scene;
  const Mesh *mesh = &scene->meshes[index];
  MeshWork work = {0};
  uint32_t triangles = mesh_triangles(mesh);
  uint32_t *piece_of = malloc((triangles + 1ull) * sizeof *piece_of);
  search->failed[index] = !work_make(&work, mesh, triangles) || !piece_of;
  search->solids->mesh_pieces[index] = piece_of;
  if (!search->failed[index]) {
    mesh_weld(&work, scene, mesh);
    pieces_find(piece_of, &work, triangles);
  }
  work_free(&work);
}

// Calls for each triangle of an object: its number in the mesh and its corners, world space.
typedef void (*TriangleVisit)(void *context, uint32_t number, const Vec3 corners[3]);

static void object_visit(const Scene *scene, const Object *object, TriangleVisit visit, void *context)
{
  const Mesh *mesh = &scene->meshes[object->mesh];
  bool mirrored = mat4_determinant3(&object->world_from_object) < 0;
  uint32_t number = 0;
  for (uint32_t p = 0; p < mesh->primitive_count; p++) {
    const Primitive *primitive = &mesh->primitives[p];
    for (uint32_t i = 0; i < primitive->triangle_count; i++, number++) {
      Vec3 corners[3];
      for (int k = 0; k < 3; k++) {
        const float *at = primitive->positions[primitive->triangles[i][mirrored ? (3 - k) % 3 : k]];
        corners[k] = mat4_point(&object->world_from_object, vec3_from_floats(at));
      }
      visit(context, number, corners);
    }
  }
}

// The pieces of one object, by the number that is their vertex's in the mesh.
typedef struct PieceList {
  Solids *solids;
  const uint32_t *piece_of;
  uint32_t *place_of;  // by piece number: index into pieces + 1, cleared for each object
  uint32_t object, first_triangle, capacity;
  bool failed;
} PieceList;

static void piece_extend(void *context, uint32_t number, const Vec3 corners[3])
{
  PieceList *list = context;
  Solids *solids = list->solids;
  uint32_t piece = list->piece_of[number], triangle = list->first_triangle + number;
  if (piece == SOLID_NONE || list->failed) return;
  solids->bits[triangle / 32] |= 1u << triangle % 32;
  if (!list->place_of[piece]) {
    if (solids->piece_count == list->capacity) {
      list->capacity = 2 * list->capacity + 64;
      SolidPiece *larger = realloc(solids->pieces, list->capacity * sizeof *larger);
      if (!larger) {
        list->failed = true;
        return;
      }
      solids->pieces = larger;
    }
    solids->pieces[solids->piece_count++] = (SolidPiece){list->object, piece, corners[0], corners[0]};
    list->place_of[piece] = solids->piece_count;
  }
  SolidPiece *at = &solids->pieces[list->place_of[piece] - 1];
  for (int k = 0; k < 3; k++) {
    at->low = vec3_min(at->low, corners[k]);
    at->high = vec3_max(at->high, corners[k]);
  }
}

static Status pieces_list(Solids *solids, Log *log)
{
  const Scene *scene = solids->scene;
  uint32_t most = 0;
  for (uint32_t m = 0; m < scene->mesh_count; m++) {
    uint32_t triangles = mesh_triangles(&scene->meshes[m]);
    if (3 * triangles > most) most = 3 * triangles;
  }
  PieceList list = {.solids = solids, .place_of = malloc((most + 1ull) * sizeof *list.place_of)};
  if (!list.place_of) return log_no_memory(log, "closed surfaces");
  for (uint32_t o = 0; o < scene->object_count && !list.failed; o++) {
    const Object *object = &scene->objects[o];
    uint32_t triangles = mesh_triangles(&scene->meshes[object->mesh]);
    list.piece_of = solids->mesh_pieces[object->mesh];
    list.object = o;
    memset(list.place_of, 0, (3ull * triangles + 1) * sizeof *list.place_of);
    if (!object->shadowless) object_visit(scene, object, piece_extend, &list);
    list.first_triangle += triangles;
  }
  free(list.place_of);
  return list.failed ? log_no_memory(log, "closed surfaces") : STATUS_OK;
}

Status solids_make(Solids *out, const Scene *scene, Log *log)
{
  Status status = STATUS_OK;
  Solids solids = {.scene = scene, .word_count = (uint32_t)(scene_triangle_count(scene) / 32 + 1)};
  MeshSearch search = {&solids, calloc(scene->mesh_count + 1, sizeof *search.failed)};
  solids.mesh_pieces = calloc(scene->mesh_count + 1, sizeof *solids.mesh_pieces);
  solids.bits = calloc(solids.word_count, sizeof *solids.bits);
  if (!search.failed || !solids.mesh_pieces || !solids.bits) {
    status = log_no_memory(log, "closed surfaces");
    goto done;
  }
  parallel_for(scene->mesh_count, mesh_search, &search);
  for (uint32_t m = 0; m < scene->mesh_count; m++)
    if (search.failed[m]) {
      status = log_no_memory(log, "closed surfaces");
      goto done;
    }
  TRY(pieces_list(&solids, log));
  *out = solids;
  solids = (Solids){0};

done:
  free(search.failed);
  solids_free(&solids);
  return status;
}

void solids_free(Solids *solids)
{
  for (uint32_t m = 0; solids->scene && solids->mesh_pieces && m < solids->scene->mesh_count; m++)
    free(solids->mesh_pieces[m]);
  free(solids->mesh_pieces);
  free(solids->pieces);
  free(solids->bits);
  *solids = (Solids){0};
}

// Where a winding number is wanted, and a box that the piece should not reach into.
typedef struct WindingQuery {
  const uint32_t *piece_of;
  uint32_t piece;
  Vec3 point, low, high;
  double solid_angle;
  bool touched;
} WindingQuery;

static void winding_add(void *context, uint32_t number, const Vec3 corners[3])
{
  WindingQuery *query = context;
  if (query->piece_of[number] != query->piece) return;
  Vec3 a = vec3_sub(corners[0], query->point), b = vec3_sub(corners[1], query->point),
       c = vec3_sub(corners[2], query->point);
  double la = vec3_length(a), lb = vec3_length(b), lc = vec3_length(c);
  double over = vec3_dot(a, vec3_cross(b, c));
  double under = la * lb * lc + vec3_dot(a, b) * lc + vec3_dot(b, c) * la + vec3_dot(c, a) * lb;
  query->solid_angle += 2 * atan2(over, under);
  Vec3 low = vec3_min(vec3_min(corners[0], corners[1]), corners[2]),
       high = vec3_max(vec3_max(corners[0], corners[1]), corners[2]);
  query->touched |= low.x <= query->high.x && high.x >= query->low.x && low.y <= query->high.y &&
                    high.y >= query->low.y && low.z <= query->high.z && high.z >= query->low.z;
}

static bool boxes_meet(const SolidPiece *piece, Vec3 low, Vec3 high)
{
  return piece->low.x <= high.x && piece->high.x >= low.x && piece->low.y <= high.y && piece->high.y >= low.y &&
         piece->low.z <= high.z && piece->high.z >= low.z;
}

// The winding number of a piece about all of a box; false where it is not the same for all of it, or not to be had.
static bool piece_winding(double *out, const Solids *solids, const SolidPiece *piece, Vec3 low, Vec3 high)
{
  *out = 0;
  if (!boxes_meet(piece, low, high)) return true;
  const Object *object = &solids->scene->objects[piece->object];
  WindingQuery query = {.piece_of = solids->mesh_pieces[object->mesh],
                        .piece = piece->number,
                        .point = vec3_scale(vec3_add(low, high), 0.5),
                        .low = low,
                        .high = high};
  object_visit(solids->scene, object, winding_add, &query);
  double winding = query.solid_angle / (4 * M_PI);
  *out = rint(winding);
  return !query.touched && fabs(winding - *out) < 1e-3;
}

// A box about where camera rays begin: all of the picture's near plane.
static void camera_start(Vec3 *low, Vec3 *high, const CameraInfo *camera)
{
  Vec3 position = vec3(camera->position.x, camera->position.y, camera->position.z);
  Vec3 right = vec3(camera->right.x, camera->right.y, camera->right.z);
  Vec3 down = vec3(camera->down.x, camera->down.y, camera->down.z);
  Vec3 forward = vec3(camera->forward.x, camera->forward.y, camera->forward.z);
  double w = camera->orthographic ? 1 : camera->near_m;
  *low = vec3(INFINITY, INFINITY, INFINITY);
  *high = vec3(-INFINITY, -INFINITY, -INFINITY);
  for (int i = 0; i < 4; i++) {
    double x = ((i & 1 ? camera->width : 0) + camera->crop_x) * (double)camera->scale - camera->center_x;
    double y = ((i & 2 ? camera->height : 0) + camera->crop_y) * (double)camera->scale - camera->center_y;
    Vec3 point = vec3_add(position, vec3_scale(forward, camera->near_m));
    point = vec3_add(point, vec3_add(vec3_scale(right, x * w), vec3_scale(down, y * w)));
    *low = vec3_min(*low, point);
    *high = vec3_max(*high, point);
  }
}

bool solids_suit(const Solids *solids, const LightInfo *light, const CameraInfo *camera)
{
  Vec3 at = vec3(light->position.x, light->position.y, light->position.z), low, high;
  bool far_away = light->kind == LIGHT_KIND_DIRECTIONAL;
  camera_start(&low, &high, camera);
  for (uint32_t i = 0; i < solids->piece_count; i++) {
    double eye = 0, source = 0;
    const SolidPiece *piece = &solids->pieces[i];
    if (!piece_winding(&eye, solids, piece, low, high)) return false;
    if (!far_away && !piece_winding(&source, solids, piece, at, at)) return false;
    if (source < eye) return false;
  }
  return true;
}
