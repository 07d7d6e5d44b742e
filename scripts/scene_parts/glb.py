"""Writes glTF 2.0 binary files: shaded meshes, nodes that share them, cameras, KHR_lights_punctual, small textures,
morph targets and an animation."""

import json
import math
import struct
import zlib
from array import array

from scene_parts import vector as v


class Mesh:
    """Triangles as flat arrays: positions and normals (three floats a vertex), or none: uvs (two), colours (RGBA bytes)."""

    def __init__(self, positions, normals, indices, uvs=None, colors=None):
        self.positions, self.normals, self.indices, self.uvs, self.colors = positions, normals, indices, uvs, colors


def shaded(solid, crease_degrees=35, uv=None, normal=None, color=None):
    """Mesh of a solid. A corner's normal is the area-weighted mean over the faces at its point that are within the
    crease angle of its own face, or `normal(point)`; `uv(point, face_normal)` gives texture coordinates and
    `color(point)` linear RGB."""
    points, limit = solid.points, math.cos(math.radians(crease_degrees))
    areas, units, at_point = [], [], [[] for _ in points]
    for number, face in enumerate(solid.faces):
        total = (0.0, 0.0, 0.0)
        for i in range(1, len(face) - 1):
            a = points[face[0]]
            total = v.add(total, v.cross(v.sub(points[face[i]], a), v.sub(points[face[i + 1]], a)))
        areas.append(total)
        units.append(v.unit(total))
        for p in face:
            at_point[p].append(number)
    positions, normals, uvs, colors, indices, known = array("f"), array("f"), array("f"), bytearray(), array("I"), {}
    for number, face in enumerate(solid.faces):
        corners = []
        for p in face:
            n = (0.0, 0.0, 0.0)
            for other in at_point[p]:
                if v.dot(units[other], units[number]) >= limit:
                    n = v.add(n, areas[other])
            n = normal(points[p]) if normal else v.unit(n)
            t = uv(points[p], units[number]) if uv else ()
            key = (p, *(round(c, 4) for c in n), *(round(c, 5) for c in t))
            if key not in known:
                known[key] = len(positions) // 3
                positions.extend(points[p])
                normals.extend(n)
                uvs.extend(t)
                if color:
                    colors += bytes([min(255, max(0, round(255 * c))) for c in color(points[p])] + [255])
            corners.append(known[key])
        for i in range(1, len(corners) - 1):
            indices.extend((corners[0], corners[i], corners[i + 1]))
    return Mesh(positions, normals, indices, uvs if uv else None, bytes(colors) if color else None)


def png(width, height, pixel):
    """RGB image file; pixel(x, y) gives sRGB bytes. Stored, not compressed: the same bytes with every zlib."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = b"".join(b"\0" + b"".join(bytes(pixel(x, y)) for x in range(width)) for y in range(height))
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 0)) + chunk(b"IEND", b"")


def _rounded(values, digits=6):
    return [round(x, digits) + 0.0 for x in values]


class Glb:
    def __init__(self, name):
        self.name = name
        self.data = bytearray()
        self.views, self.accessors, self.meshes, self.nodes, self.materials = [], [], [], [], []
        self.cameras, self.lights, self.images, self.textures, self.samplers = [], [], [], [], []
        self.extensions, self.triangles, self.mesh_triangles = set(), 0, []
        self.animation = {"samplers": [], "channels": []}

    def _view(self, data, target=None):
        self.data += b"\0" * (-len(self.data) % 4)
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)}
        if target:
            view["target"] = target
        self.data += data
        self.views.append(view)
        return len(self.views) - 1

    def _accessor(self, data, component, kind, count, target, **more):
        view = self._view(bytes(data), target)
        self.accessors.append({"bufferView": view, "componentType": component, "count": count, "type": kind, **more})
        return len(self.accessors) - 1

    def primitive(self, mesh, material):
        """Stores the arrays of a mesh; the result may be used in several meshes with other materials."""
        count = len(mesh.positions) // 3
        low, high = [min(mesh.positions[k::3]) for k in range(3)], [max(mesh.positions[k::3]) for k in range(3)]
        attributes = {
            "POSITION": self._accessor(mesh.positions, 5126, "VEC3", count, 34962, min=low, max=high),
            "NORMAL": self._accessor(mesh.normals, 5126, "VEC3", count, 34962),
        }
        if mesh.uvs:
            attributes["TEXCOORD_0"] = self._accessor(mesh.uvs, 5126, "VEC2", count, 34962)
        if mesh.colors:
            attributes["COLOR_0"] = self._accessor(mesh.colors, 5121, "VEC4", count, 34962, normalized=True)
        indices = mesh.indices if count > 65535 else array("H", mesh.indices)
        component = 5125 if count > 65535 else 5123
        return {
            "attributes": attributes,
            "material": material,
            "indices": self._accessor(indices, component, "SCALAR", len(indices), 34963),
        }

    def mesh(self, name, *primitives):
        self.meshes.append({"name": name, "primitives": list(primitives)})
        self.mesh_triangles.append(sum(self.accessors[p["indices"]]["count"] // 3 for p in primitives))
        return len(self.meshes) - 1

    def solid(self, name, solid, material, crease_degrees=35, **shading):
        """A mesh of one closed solid."""
        solid.check_closed(name)
        return self.mesh(name, self.primitive(shaded(solid, crease_degrees, **shading), material))

    def morphing(self, name, solid, shapes, material):
        """A mesh of a closed solid, smooth all over, and of others made of the same faces, which its weights add."""
        solid.check_closed(name)
        base = shaded(solid, 180)
        primitive = {**self.primitive(base, material), "targets": []}
        for shape in shapes:
            shape.check_closed(name)
            target = shaded(shape, 180)
            count = len(base.positions) // 3
            moved, turned = (
                array("f", [b - a for a, b in zip(before, after)])
                for before, after in ((base.positions, target.positions), (base.normals, target.normals))
            )
            bounds = {"min": [min(moved[k::3]) for k in range(3)], "max": [max(moved[k::3]) for k in range(3)]}
            primitive["targets"].append(
                {
                    "POSITION": self._accessor(moved, 5126, "VEC3", count, 34962, **bounds),
                    "NORMAL": self._accessor(turned, 5126, "VEC3", count, 34962),
                }
            )
        mesh = self.mesh(name, primitive)
        self.meshes[mesh]["weights"] = [0] * len(shapes)
        return mesh

    def move(self, node, path, times, values, interpolation="LINEAR"):
        """Keys of what moves of a node: its translation, rotation, scale or weights; CUBICSPLINE wants three values a
        key: in tangent, value, out tangent. All of a scene is one animation."""
        flat = array("f", [x for value in values for x in value])
        kind = "SCALAR" if path == "weights" else f"VEC{len(values[0])}"
        count = len(flat) if path == "weights" else len(values)
        first, last = array("f", [times[0], times[-1]])
        source = self._accessor(array("f", times), 5126, "SCALAR", len(times), None, min=[first], max=[last])
        sampler = {"input": source, "output": self._accessor(flat, 5126, kind, count, None)}
        if interpolation != "LINEAR":
            sampler["interpolation"] = interpolation
        self.animation["samplers"].append(sampler)
        target = {"node": node, "path": path}
        self.animation["channels"].append({"sampler": len(self.animation["samplers"]) - 1, "target": target})

    def node(self, name, mesh=None, at=(0, 0, 0), rotation=(0, 0, 0, 1), scale=1, parent=None, **more):
        """Adds a node, below another where `parent` names one; returns its index."""
        node = {"name": name, **more}
        if mesh is not None:
            node["mesh"] = mesh
            self.triangles += self.mesh_triangles[mesh]
        if any(at):
            node["translation"] = _rounded(at, 5)
        if tuple(rotation) != (0, 0, 0, 1):
            node["rotation"] = _rounded(rotation, 7)
        if scale != 1:
            node["scale"] = _rounded(scale if isinstance(scale, tuple) else (scale,) * 3, 5)
        self.nodes.append(node)
        if parent is not None:
            self.nodes[parent].setdefault("children", []).append(len(self.nodes) - 1)
        return len(self.nodes) - 1

    def draw(self, name, solid, material, crease_degrees=35, **shading):
        """A solid drawn once, where it was made."""
        return self.node(name, self.solid(name, solid, material, crease_degrees, **shading))

    def material(self, name, color, metallic=0.0, roughness=0.9, emission=None, strength=1.0, texture=None):
        """Linear base colour; emission up to 1 a channel, times strength."""
        pbr = {"baseColorFactor": [*color, 1], "metallicFactor": metallic, "roughnessFactor": roughness}
        if texture is not None:
            pbr["baseColorTexture"] = {"index": texture}
        material = {"name": name, "pbrMetallicRoughness": pbr}
        if emission:
            material["emissiveFactor"] = list(emission)
        if strength != 1:
            material["extensions"] = {"KHR_materials_emissive_strength": {"emissiveStrength": strength}}
            self.extensions.add("KHR_materials_emissive_strength")
        self.materials.append(material)
        return len(self.materials) - 1

    def texture(self, name, image, nearest=False):
        """A PNG file, repeated in both directions."""
        sampler = {"magFilter": 9728, "minFilter": 9728} if nearest else {"magFilter": 9729, "minFilter": 9729}
        if sampler not in self.samplers:
            self.samplers.append(sampler)
        self.images.append({"name": name, "mimeType": "image/png", "bufferView": self._view(image)})
        self.textures.append({"name": name, "sampler": self.samplers.index(sampler), "source": len(self.images) - 1})
        return len(self.textures) - 1

    def camera(self, name, position, target, yfov_degrees, znear=0.05, zfar=200.0):
        self.cameras.append(
            {
                "name": name,
                "type": "perspective",
                "perspective": {"yfov": round(math.radians(yfov_degrees), 6), "znear": znear, "zfar": zfar},
            }
        )
        return self.node(f"camera {name}", at=position, rotation=look(position, target), camera=len(self.cameras) - 1)

    def light(self, name, kind, intensity, color=(1, 1, 1), at=(0, 0, 0), direction=None, cone_degrees=None):
        """point, spot (candela) or directional (lux); cone_degrees: inner and outer half angle."""
        light = {"name": name, "type": kind, "color": list(color), "intensity": intensity}
        if kind == "spot":
            inner, outer = (round(math.radians(a), 6) for a in cone_degrees)
            light["spot"] = {"innerConeAngle": inner, "outerConeAngle": outer}
        self.lights.append(light)
        self.extensions.add("KHR_lights_punctual")
        rotation = v.look_along(direction) if direction else (0, 0, 0, 1)
        return self.node(
            f"light {name}",
            at=at,
            rotation=rotation,
            extensions={"KHR_lights_punctual": {"light": len(self.lights) - 1}},
        )

    def bytes(self):
        below = {child for node in self.nodes for child in node.get("children", ())}
        document = {
            "asset": {"version": "2.0", "generator": "Frugal make_scenes"},
            "scene": 0,
            "scenes": [{"name": self.name, "nodes": [i for i in range(len(self.nodes)) if i not in below]}],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": self.materials,
            "cameras": self.cameras,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": len(self.data)}],
        }
        if self.images:
            document.update(images=self.images, textures=self.textures, samplers=self.samplers)
        if self.animation["channels"]:
            document["animations"] = [{"name": self.name, **self.animation}]
        if self.lights:
            document["extensions"] = {"KHR_lights_punctual": {"lights": self.lights}}
        if self.extensions:
            document["extensionsUsed"] = sorted(self.extensions)
        text = json.dumps(document, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        data = bytes(self.data) + b"\0" * (-len(self.data) % 4)
        return (
            struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(data))
            + struct.pack("<I4s", len(text), b"JSON")
            + text
            + struct.pack("<I4s", len(data), b"BIN\0")
            + data
        )


def look(position, target):
    return v.look_along(v.sub(target, position))
