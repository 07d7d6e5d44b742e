// Reflected rays against the lists of what is near their reflectors' cube maps: the nearest triangle, as trace_closest
// finds it of the whole scene.
//
//   in    rays             reflected rays; those of mirrors say where they start (RAY_FROM_MIRROR)
//         cube_of_object   CUBE_NONE where an object has none, [object_count]
//         nears            shared/near.h, by cube: where its list's nodes and triangles begin
//   out   hits             t, u, v and triangle id by ray index; HIT_NONE for rays that have no list, or hit nothing
//
//   Cost  that of rays/trace_packet.cl for a tree as small as the list; rays of different cubes walk one after another.
//   From  the sources of lib/packet.cl

#include "lib/packet.cl"
#include "lib/reflected.cl"
#include "shared/near.h"

kernel void near_trace(global const uint *object_starts, uint object_count, global const uint *cube_of_object,
                       global const NearInfo *nears, global const Bvh2Node *nodes, global const BvhTriangle *triangles,
                       global const float *rays, uint capacity, uint ray_count, global float *hits,
                       global uint *hit_ids, global const TriangleCorners *corners, global const Float2 *uvs,
                       global const Float4 *colors, uint vertex_count, global const MaterialInfo *materials,
                       global const TextureInfo *textures, global const uchar4 *texels,
                       constant float *linear_from_byte)
{
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  ReflectorCubes reflectors = {object_starts, object_count, cube_of_object};
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  for (uint first = begin; first < end; first += LANES) {
    Packet p = packet_load(rays, capacity, first, ray_count, 0);
    FloatL density = LANE_LOAD(rays + RAY_DENSITY * capacity, first);
    UintL source = LANE_AS_UINT(density), number = UINTL(CUBE_NONE);
    IntL waiting = (p.t_max > FLOATL(0)) & ((source & UINTL(RAY_FROM_MIRROR)) != UINTL(0));
    for (uint bits = lane_bits(waiting); bits; bits &= bits - 1) {
      uint lane = lowest_bit(bits);
      LANE_UINT(number, lane) = reflector_cube(reflectors, LANE_UINT(source, lane));
    }
    waiting = waiting & (number != UINTL(CUBE_NONE));
    for (uint bits = lane_bits(waiting); bits; bits = lane_bits(waiting)) {
      uint cube = LANE_UINT(number, lowest_bit(bits));
      IntL group = waiting & (number == UINTL(cube));
      packet_trace_lanes(&p, group, nodes + nears[cube].first_node, triangles + nears[cube].first_triangle, false, true,
                         &attributes);
      waiting = waiting & !group;
    }
    LANE_STORE(p.t, hits + HIT_T * capacity, first);
    LANE_STORE(p.u, hits + HIT_U * capacity, first);
    LANE_STORE(p.v, hits + HIT_V * capacity, first);
    LANE_STORE(p.id, hit_ids, first);
  }
}
