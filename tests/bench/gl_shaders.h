// The shaders of bench/gl_peer.c.
#pragma once

static const char *const depth_vertex_source =
    "#version 300 es\n"
    "layout(location = 0) in vec3 position;\n"
    "uniform mat4 clip_from_world;\n"
    "void main() { gl_Position = clip_from_world * vec4(position, 1.0); }\n";

static const char *const depth_source = "#version 300 es\nvoid main() {}\n";

static const char *const id_vertex_source =
    "#version 320 es\n"
    "layout(location = 0) in vec3 position;\n"
    "uniform mat4 clip_from_world;\n"
    "void main() { gl_Position = clip_from_world * vec4(position, 1.0); }\n";

static const char *const id_source =
    "#version 320 es\n"
    "precision highp int;\n"
    "out uint id;\n"
    "void main() { id = uint(gl_PrimitiveID); }\n";

// A triangle over the whole target, and the bits of a depth texture as colour.
static const char *const cover_vertex_source =
    "#version 300 es\n"
    "void main() { gl_Position = vec4(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1, 0.0, 1.0); }\n";

static const char *const copy_source =
    "#version 300 es\n"
    "precision highp float;\n"
    "precision highp int;\n"
    "uniform highp sampler2D depth;\n"
    "out highp uint bits;\n"
    "void main() { bits = floatBitsToUint(texelFetch(depth, ivec2(gl_FragCoord.xy), 0).r); }\n";

static const char *const surface_vertex_source =
    "#version 320 es\n"
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 normal;\n"
    "layout(location = 2) in vec2 uv;\n"
    "layout(location = 3) in uint material;\n"
    "layout(location = 4) in vec4 color;\n"
    "uniform mat4 clip_from_world;\n"
    "out vec3 surface_position;\n"
    "out vec3 surface_normal;\n"
    "out vec2 surface_uv;\n"
    "out vec3 surface_color;\n"
    "flat out uint surface_material;\n"
    "void main() {\n"
    "  surface_position = position;\n"
    "  surface_normal = normal;\n"
    "  surface_uv = uv;\n"
    "  surface_color = color.rgb;\n"
    "  surface_material = material;\n"
    "  gl_Position = clip_from_world * vec4(position, 1.0);\n"
    "}\n";

// cl/lib/brdf.cl, with the branches that punctual lights need.
static const char *const surface_source =
    "precision highp float;\n"
    "precision highp int;\n"
    "precision highp sampler2DShadow;\n"
    "in vec3 surface_position;\n"
    "in vec3 surface_normal;\n"
    "in vec2 surface_uv;\n"
    "in vec3 surface_color;\n"
    "flat in uint surface_material;\n"
    "struct Material { vec4 base, emission; float metallic, roughness; vec2 padding; };\n"
    "layout(std140) uniform Materials { Material materials[64]; };\n"
    "#ifdef TEXTURED\n"
    "uniform sampler2D image;\n"
    "#endif\n"
    "uniform vec3 eye, light_position, light_direction;\n"
    "uniform vec3 light_numbers;\n"  // candela, scale, offset
    "uniform mat4 map_from_world;\n"
    "uniform sampler2DShadow map;\n"
    "uniform float texel;\n"
    "out vec4 color;\n"
    "float lit_share(vec3 p) {\n"
    "  vec4 clip = map_from_world * vec4(p, 1.0);\n"
    "  vec3 at = 0.5 * clip.xyz / clip.w + 0.5;\n"
    "  float lit = 0.0;\n"
    "  for (int y = -1; y <= 1; y++)\n"
    "    for (int x = -1; x <= 1; x++) lit += texture(map, vec3(at.xy + texel * vec2(x, y), at.z - 0.0005));\n"
    "  return lit / 9.0;\n"
    "}\n"
    "vec3 brdf(vec3 base, float metallic, float roughness, vec3 n, vec3 v, vec3 l) {\n"
    "  vec3 h = normalize(l + v), nxh = cross(n, h);\n"
    "  vec3 f0 = 0.04 * (1.0 - metallic) + base * metallic;\n"
    "  float nl = max(dot(n, l), 0.0), nv = max(abs(dot(n, v)), 1e-6), vh = abs(dot(v, h));\n"
    "  float nh = dot(n, h);\n"
    "  float alpha = roughness * roughness, alpha2 = max(alpha * alpha, 1e-18);\n"
    "  float denominator = alpha2 * nh * nh + dot(nxh, nxh);\n"
    "  float d = nh > 0.0 ? alpha2 * 0.31830988618 / (denominator * denominator) : 0.0;\n"
    "  float smith_v = nl * sqrt(nv * nv * (1.0 - alpha2) + alpha2);\n"
    "  float smith_l = nv * sqrt(nl * nl * (1.0 - alpha2) + alpha2);\n"
    "  float specular = roughness > 0.0 ? d * 0.5 / max(smith_v + smith_l, 1e-20) : 0.0;\n"
    "  float m = 1.0 - min(vh, 1.0), m2 = m * m;\n"
    "  vec3 f = f0 + (1.0 - f0) * (m2 * m2 * m);\n"
    "  vec3 diffuse = (1.0 - f) * base * ((1.0 - metallic) * 0.31830988618);\n"
    "  return (diffuse + f * specular) * nl;\n"
    "}\n"
    "void main() {\n"
    "  Material material = materials[surface_material];\n"
    "  vec3 base = material.base.rgb * surface_color;\n"
    "#ifdef TEXTURED\n"
    "  base *= texture(image, surface_uv).rgb;\n"
    "#endif\n"
    "  vec3 n = normalize(surface_normal), v = normalize(eye - surface_position);\n"
    "  if (!gl_FrontFacing) n = -n;\n"
    "  vec3 to_light = light_position - surface_position, l = normalize(to_light);\n"
    "  float cone = clamp(-dot(light_direction, l) * light_numbers.y + light_numbers.z, 0.0, 1.0);\n"
    "  float irradiance = light_numbers.x * cone * cone / dot(to_light, to_light);\n"
    "  vec3 f = brdf(base, material.metallic, material.roughness, n, v, l);\n"
    "  color = vec4(material.emission.rgb + f * irradiance * lit_share(surface_position), 1.0);\n"
    "}\n";
