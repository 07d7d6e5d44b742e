// Which reflectors get cube maps, and how these are filled.
#pragma once

#include "render/frame.h"
#include "render/mirrors_seen.h"

enum { CUBE_LEAST_PX = 32, CUBE_MOST_PX = 512, CUBES_MOST = 256, CUBES_MOST_BYTES = 512000000 };

// Makes what the plan's reflections look up, once everything else of the frame is there.
//
// A reflector is an object of which the camera sees a surface of roughness 0 (by the factor; one whose roughness is a
// texture's is traced; render/mirrors_seen.h), or, where maps answer for rough surfaces, one that reflects and is no
// rougher than the plan's max_roughness. What only other mirrors show has no cube, and its rays are traced; rough
// surfaces there show the environment. Its cube is captured from the centre of its bounds, without itself; with
// plan->cubes.size_px 0 a face has, of powers of two from CUBE_LEAST_PX to CUBE_MOST_PX, as many texels a side as the
// reflector is pixels wide, taken for a disc. The largest on screen come first; what is over plan->cubes.max_bytes or
// CUBES_MOST is left out, with a warning, and traced. Of a reflector without mirrors it is no larger than its narrowest
// lobe needs (four texels for alpha), its centre is before what is seen of it where it is flat or large, and it comes
// after all mirrors; left out, it shows the environment. Rough surfaces ask prefiltered levels (shared/cube.h). In a
// cube itself they see lights and the environment alone. What is near is listed as render/near_objects.h has it. Of
// reflectors that hybrid reflections would ask those have none that are seen to be flat, and, unless the size is given,
// those for which rays are predicted to be quicker. In a cube, mirrors show what plan->deep_reflections shows: rays, or
// where that is a map, the environment.
//
// Errors: those of rendering; STATUS_NO_MEMORY.
Status reflectors_prepare(Frame *frame, Log *log);

// The cube that an object has which covers so many of the picture's pixels; first_texel is 0.
CubeInfo reflector_cube(const Frame *frame, uint32_t object, double pixels);

// The same for an object of which rough surfaces alone are seen, of whose pixels each is `factor` of the picture's
// wide.
CubeInfo reflector_rough_cube(const Frame *frame, const Reflector *reflector, uint32_t factor);
