// A scene that moves, as glTF.
#pragma once

#include "support/gltf_build.h"

// Adds corners of a cube from -1 to 1, bit 0 of a corner's number being x, and its sides.
void stage_cube_add(GltfBuild *build);

// An animation that moves a node by a channel of values, whose times are accessor 2.
#define TRACK(name, values, node)                                                                                     \
  "{'name':'" name "','samplers':[{'input':2,'output':" #values "}],'channels':[{'sampler':0,'target':{'node':" #node \
  ",'path':'translation'}}]}"

// Saves a floor with a mirror and two pillars on it, lit by two lamps, and returns the file's path. Its animations, of
// a second each, move one thing alone: "box", in a corner, "kite", which is over what the camera sees, but not its
// shadow, "lamp", the second one, and "eye", the camera.
const char *stage_save(void);
