// Scene files (.json): a glTF and what glTF cannot say, described by scenes/scene.schema.json.
#pragma once

#include "scene/scene.h"

typedef struct SceneFile {
  char *path;
  char *scene_path;         // of the glTF
  struct json_t *document;  // all that it holds; NULL: there is no scene file
} SceneFile;

// Keys that say what the scene is, besides the options of `frugal render`; ends with NULL.
extern const char *const scene_file_keys[];

// Does the name end in .json?
bool scene_file_is(const char *path);

// Reads a scene file and finds its glTF. What its other keys hold is not looked at here. Unless `allow_outside`, the
// glTF must lie in the folder of `path` or below.
//
// Errors: STATUS_NOT_FOUND, STATUS_BAD_SCENE (not JSON, a key twice, no "scene", ...), STATUS_TOO_LARGE,
// STATUS_NO_MEMORY.
Status scene_file_read(SceneFile *out, const char *path, bool allow_outside, Log *log);
void scene_file_free(SceneFile *file);

// The path of another file that a scene file names, by the same rule; the caller frees *out. Errors: STATUS_NOT_FOUND,
// STATUS_BAD_SCENE, STATUS_NO_MEMORY.
Status scene_file_resolve(char **out, const SceneFile *file, const char *named, bool allow_outside, Log *log);

// Changes the objects of the scene as "nodes" says; all that a node's name is of. Errors: STATUS_BAD_SCENE: a key or
// type that is not known, a name that no object has (the nearest is named).
Status scene_file_change(Scene *scene, const SceneFile *file, Log *log);
