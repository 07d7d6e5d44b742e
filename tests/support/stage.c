#include "support/stage.h"

#include <string.h>

void stage_cube_add(GltfBuild *build)
{
  float corners[8][3];
  for (int i = 0; i < 8; i++)
    for (int axis = 0; axis < 3; axis++) corners[i][axis] = i >> axis & 1 ? 1 : -1;
  const uint16_t sides[36] = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                              2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
  gltf_array(build, 5126, "VEC3", corners, sizeof corners, 8, ",'min':[-1,-1,-1],'max':[1,1,1]");
  gltf_array(build, 5123, "SCALAR", sides, sizeof sides, 36, "");
}

const char *stage_save(void)
{
  static GltfBuild build;
  memset(&build, 0, sizeof build);
  stage_cube_add(&build);
  GLTF_FLOATS(&build, "SCALAR", 2, 0, 1);
  GLTF_FLOATS(&build, "VEC3", 2, 5, 0.5f, -3, 5, 0.5f, 3);
  GLTF_FLOATS(&build, "VEC3", 2, -3, 4, 1, 1, 4, 2);
  GLTF_FLOATS(&build, "VEC3", 2, 0, 2, 9, 1, 2.2f, 8.5f);
  GLTF_FLOATS(&build, "VEC3", 2, 1.2f, 5.7f, 3, 1.05f, 5.7f, 3);
  return gltf_save(
      &build, "%s",
      "'scene':0,'scenes':[{'nodes':[0,1,2,3,4,5,6,7,8]}],"
      "'nodes':[{'name':'floor','mesh':0,'translation':[0,-0.1,0],'scale':[8,0.1,8]},"
      "{'name':'mirror','mesh':1,'translation':[0,1.2,0],'rotation':[0,0.3826834,0,0.9238795]},"
      "{'name':'pillar','mesh':0,'translation':[-3,1,0],'scale':[0.4,1,0.4]},"
      "{'name':'pillar','mesh':0,'translation':[-2,1,3],'scale':[0.3,1,0.3]},"
      "{'name':'box','mesh':0,'translation':[5,0.5,-3],'scale':[0.5,0.5,0.5]},"
      "{'name':'still','translation':[1,7,3.2],'extensions':{'KHR_lights_punctual':{'light':0}}},"
      "{'name':'moving','translation':[-3,4,1],'extensions':{'KHR_lights_punctual':{'light':1}}},"
      "{'name':'eye','translation':[0,2,9],'camera':0},"
      "{'name':'kite','mesh':0,'translation':[1.2,5.7,3],'scale':[0.12,0.05,0.12]}],"
      "'cameras':[{'type':'perspective','perspective':{'yfov':0.9,'znear':0.1}}],"
      "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1,'material':0}]},"
      "{'primitives':[{'attributes':{'POSITION':0},'indices':1,'material':1}]}],"
      "'materials':[{'pbrMetallicRoughness':{'metallicFactor':0}},"
      "{'pbrMetallicRoughness':{'metallicFactor':1,'roughnessFactor':0}}],"
      "'extensionsUsed':['KHR_lights_punctual'],"
      "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point','intensity':60},"
      "{'type':'point','intensity':40}]}},"
      "'animations':[" TRACK("box", 3, 4) "," TRACK("lamp", 4, 6) "," TRACK("eye", 5, 7) "," TRACK("kite", 6, 8) "]");
}
