// Traverse + intersect, LANES rays at a time over the binary BVH: closest hit and any hit.
//
//   in    rays      ray stream (shared/stream.h), world space
//         nodes     both children's boxes in the parent; triangles in the order of the leaves
//   out   closest:  hits t, u, v and triangle id (HIT_NONE where nothing is hit), by ray index
//         any:      adds a ray's weight to radiance[slot] where nothing lies in 0 < t < t_max, and 1 - alpha of it for
//                   each BLEND surface that does; the stream is segment `segment` of several
//         open:     the same for rays that pass single-sided triangles from behind, as closest does
//
//   Pro   coherent rays (camera, shadow, mirror) share node fetches; on a GPU, with one lane, the plain two-child
//         traversal that beats wide nodes where the cache is large.
//   Con   rays that go separate ways visit the union of their nodes: see trace_single.cl for those.
//   Cost  about log2(triangles) node tests a packet; 64 bytes a node, 48 a triangle.
//   From  the sources of lib/packet.cl

#include "lib/packet.cl"

kernel void trace_closest(global const Bvh2Node *nodes, global const BvhTriangle *triangles, global const float *rays,
                          uint capacity, uint ray_count, float t_min, global float *hits, global uint *hit_ids,
                          global const TriangleCorners *corners, global const Float2 *uvs, global const Float4 *colors,
                          uint vertex_count, global const MaterialInfo *materials, global const TextureInfo *textures,
                          global const uchar4 *texels, constant float *linear_from_byte)
{
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  for (uint first = begin; first < end; first += LANES) {
    Packet p = packet_load(rays, capacity, first, ray_count, t_min);
    packet_trace(&p, nodes, triangles, false, true, &attributes);
    LANE_STORE(p.t, hits + HIT_T * capacity, first);
    LANE_STORE(p.u, hits + HIT_U * capacity, first);
    LANE_STORE(p.v, hits + HIT_V * capacity, first);
    LANE_STORE(p.id, hit_ids, first);
  }
}

// Any hit for the rays of one segment; `culls` is a constant.
static inline void trace_segment(global const Bvh2Node *nodes, global const BvhTriangle *triangles,
                                 global const float *rays, uint capacity, uint ray_count, global const uint *slots,
                                 global float4 *radiance, bool culls, const AttributeSources *attributes)
{
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  for (uint first = begin; first < end; first += LANES) {
    Packet p = packet_load(rays, capacity, first, ray_count, 0);
    packet_trace(&p, nodes, triangles, true, culls, attributes);
    FloatL through = FLOATL(1);
#ifdef HAS_BLEND
    through = absorption_through(p.absorption);
#endif
    for (uint bits = lane_bits(!p.occluded & (p.t_max >= FLOATL(0))); bits; bits &= bits - 1)
      stream_add_weight(rays, capacity, first + lowest_bit(bits), slots, radiance,
                        LANE_FLOAT(through, lowest_bit(bits)));
  }
}

kernel void trace_any(global const Bvh2Node *nodes, global const BvhTriangle *triangles, global const float *rays,
                      uint capacity, uint ray_count, uint segment, global const uint *slots, global float4 *radiance,
                      global const TriangleCorners *corners, global const Float2 *uvs, global const Float4 *colors,
                      uint vertex_count, global const MaterialInfo *materials, global const TextureInfo *textures,
                      global const uchar4 *texels, constant float *linear_from_byte)
{
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  trace_segment(nodes, triangles, rays + segment * RAY_FIELD_COUNT * capacity, capacity, ray_count,
                slots + segment * capacity, radiance, false, &attributes);
}

kernel void trace_open(global const Bvh2Node *nodes, global const BvhTriangle *triangles, global const float *rays,
                       uint capacity, uint ray_count, uint segment, global const uint *slots, global float4 *radiance,
                       global const TriangleCorners *corners, global const Float2 *uvs, global const Float4 *colors,
                       uint vertex_count, global const MaterialInfo *materials, global const TextureInfo *textures,
                       global const uchar4 *texels, constant float *linear_from_byte)
{
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  trace_segment(nodes, triangles, rays + segment * RAY_FIELD_COUNT * capacity, capacity, ray_count,
                slots + segment * capacity, radiance, true, &attributes);
}
