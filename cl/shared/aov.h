// Planes of the AOV buffers. Written by cl/shade/aov.cl, read by host/render.
#ifndef SHARED_AOV_H
#define SHARED_AOV_H

enum AovValuePlane { AOV_DEPTH, AOV_POSITION, AOV_NORMAL = 4, AOV_ALBEDO = 7, AOV_VALUE_PLANES = 10 };
enum AovIdPlane { AOV_OBJECT, AOV_PRIMITIVE, AOV_MATERIAL, AOV_ID_PLANES };

#define AOV_NONE 0xffffffffu  // background: -1

#endif
