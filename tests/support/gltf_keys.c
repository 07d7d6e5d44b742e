#include "support/gltf_keys.h"

GltfMotion *gltf_keys_open(Scene *scene, const Keys *keys)
{
  GltfBuild build = gltf_targets_build();
  int width = keys->type[0] == 'S' ? 1 : keys->type[3] - '0';
  gltf_array(&build, 5126, "SCALAR", keys->times, sizeof(float) * (size_t)keys->count, keys->count, "");
  gltf_array(&build, 5126, keys->type, keys->values, sizeof(float) * (size_t)(width * keys->value_count),
             keys->value_count, "");
  return gltf_motion_fine(scene,
                          gltf_save(&build,
                                    ONE_NODE "," GLTF_MORPHED_TRIANGLE ",'animations':[{'samplers':[{'input':3,'output'"
                                             ":4,'interpolation':'%s'}],'channels':[{'sampler':0,'target':{'node':0,"
                                             "'path':'%s'}}]}]",
                                    keys->interpolation, keys->path),
                          NULL);
}
