// Scenes with mirrors and pictures of them, for tests of what answers reflected rays.
#pragma once

#include "support/picture_fixture.h"

// Square, one sample a pixel; `cube_px` 0: auto.
PictureRequest mirrors_request(uint32_t side, ReflectionMethod method, uint32_t cube_px);

// A mirror's material, of reflectance 0.9.
int mirrors_material(Scene *scene, bool double_sided);

// A sky as smooth as a cosine, so that its second derivative is 1 a radian squared at most.
void mirrors_sky(Scene *scene);
