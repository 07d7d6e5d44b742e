// Which reflectors get cube maps, and how these are filled.
#pragma once

#include "render/frame.h"
#include "render/mirrors_seen.h"

enum { CUBES_MOST = 256, CUBES_MOST_BYTES = 512000000 };

// Makes what the plan's reflections look up, once everything else of the frame is there.
//
// A reflector is an object of which the camera sees a surface of roughness 0 (by the factor; one whose roughness is a
// texture's is traced; render/mirrors_seen.h), or, where maps answer for rough surfaces, one that reflects and is no
// rougher than the plan's max_roughness. Its cube is captured from the centre of its bounds, without itself; with
// plan->cubes.size_px 0 a face has, of powers of two from CUBE_LEAST_PX to CUBE_MOST_PX, as many texels a side as the
// reflector is pixels wide, taken for a disc. The largest on screen come first; what is over plan->cubes.max_bytes or
// CUBES_MOST is left out, with a warning, and traced. Of a reflector without mirrors it is no larger than its narrowest
// lobe needs (four texels for alpha), its centre is before what is seen of it where it is flat or large, and it comes
// after all mirrors; left out, it shows the environment. Rough surfaces ask prefiltered levels (shared/cube.h). What is
// near is listed as render/near_objects.h has it. Of reflectors that hybrid reflections would ask those have none that
// are seen to be flat, and, unless the size is given, those for which rays are predicted to be quicker.
//
// Where plan->deep_reflections is a cube map, mirrors that the camera sees in mirrors (render/mirrors_within.h) have
// deep cubes, whether it sees them or not, twice as many texels wide as they are pixels there; lists have none. Mirrors
// that are seen neither way have no cube: rays that meet them all the same are traced.
//
// What cubes show of reflectors: first deep cubes are drawn, in whose mirrors the environment is seen, then those of
// rough surfaces alone, the same; then mirrors', in which mirrors show their deep cubes, and the environment where they
// have none. So what a cube shows depends on no order among its like, and the third mirror in a row shows the
// environment: rays of two reflections and of eight differ by over 2/255 in .0007 of the pixels of chrome, in one pixel
// of colonnade, in none of room. Where plan->deep_reflections are rays, all show them. Rough surfaces in cubes see
// lights and the environment alone. That they asked maps there too was tried: mean FLIP against rays of impostors in
// room, chrome, Hall and MetalRoughSpheresNoTextures went from .0490, .0533, .0557, .0065 to .0465, .0541, .0562,
// .0067, with twice the cubes and 1.1 to 1.8 times the time; nor do the cubes of rough surfaces gain by what mirrors
// show there (.0484, .0553, .0555, .0065), as few texels hold a lamp's image for more than it is.
//
// Errors: those of rendering; STATUS_NO_MEMORY.
Status reflectors_prepare(Frame *frame, Log *log);
