// A soup as a scene model, so that tests drive the passes as a file's scene would.
#pragma once

#include "scene/scene.h"
#include "support/soup.h"

// One object; its triangles' ids are their numbers in the soup, whose flags (TRIANGLE_* of cl/shared/bvh.h) are the
// index of their material, of four. Masked triangles show parts of two textures of 8 x 8 texels whose alpha is 0 or 1
// at random: filtered nearest and repeated (double-sided), or bilinear and mirrored (single-sided); their texture
// coordinates are quarters in [-2, 2], which a device holds exactly. Ends the program where memory runs out.
Scene scene_from_soup(const Soup *soup);
