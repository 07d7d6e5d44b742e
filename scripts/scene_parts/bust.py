"""A bust such as a scanner would give: a closed noisy surface, triangulated irregularly.

The surface is the zero of a signed distance field, followed from cell to cell on a jittered grid and extracted by naive
surface nets (Gibson, "Constrained Elastic Surface Nets", 1998): a vertex in each cell that the surface passes, a quad
across each grid edge that pierces it."""

import math
from array import array

from scene_parts import vector as v
from scene_parts.glb import Glb, Mesh
from scene_parts.solid import arc, bevelled_box, box, lathe
from scene_parts.surfaces import checker, floor_uv

CELLS_M = {"bust_70k": 0.00928, "bust_870k": 0.002662, "bust_300k": 0.00448}
BRICK = 16  # cells along the side of a block that knows which parts can reach it
BOTTOM_M = 0.05
_STEP = (1, 1 << 12, 1 << 24)  # a grid corner (i, j, k) has the key i + j * 2^12 + k * 2^24, offset to be positive

# Ellipsoids: centre, radii, softness of the joint (metres); negative softness carves.
_PARTS = (
    ((0.0, 0.80, -0.02), (0.205, 0.255, 0.235), 0.0),  # skull
    ((0.0, 0.66, 0.045), (0.158, 0.190, 0.168), 0.06),  # face
    ((0.0, 0.535, 0.150), (0.070, 0.048, 0.055), 0.06),  # chin
    ((0.0, 0.45, -0.045), (0.115, 0.22, 0.118), 0.07),  # neck
    ((0.0, 0.20, -0.05), (0.40, 0.165, 0.185), 0.13),  # shoulders
    ((0.0, 0.11, 0.03), (0.26, 0.21, 0.17), 0.10),  # chest
    ((0.0, 0.815, 0.185), (0.120, 0.030, 0.040), 0.04),  # brow
    ((0.0, 0.715, 0.232), (0.026, 0.080, 0.042), 0.03),  # ridge of the nose
    ((0.0, 0.672, 0.252), (0.036, 0.030, 0.038), 0.025),  # tip of the nose
    ((0.075, 0.765, 0.215), (0.048, 0.032, 0.040), -0.03),
    ((-0.075, 0.765, 0.215), (0.048, 0.032, 0.040), -0.03),  # sockets of the eyes
    ((0.072, 0.765, 0.172), (0.034, 0.030, 0.034), 0.008),
    ((-0.072, 0.765, 0.172), (0.034, 0.030, 0.034), 0.008),  # eyes
    ((0.098, 0.690, 0.130), (0.055, 0.050, 0.055), 0.05),
    ((-0.098, 0.690, 0.130), (0.055, 0.050, 0.055), 0.05),  # cheeks
    ((0.0, 0.612, 0.205), (0.055, 0.016, 0.026), 0.014),
    ((0.0, 0.588, 0.200), (0.046, 0.017, 0.026), 0.014),  # lips
    ((0.0, 0.600, 0.236), (0.058, 0.0055, 0.022), -0.008),  # mouth
    ((0.205, 0.735, -0.01), (0.022, 0.070, 0.045), 0.02),
    ((-0.205, 0.735, -0.01), (0.022, 0.070, 0.045), 0.02),  # ears
    ((0.222, 0.740, 0.010), (0.014, 0.045, 0.026), -0.012),
    ((-0.222, 0.740, 0.010), (0.014, 0.045, 0.026), -0.012),  # shells of the ears
)


def _blend(field, other, softness):
    """Smooth minimum, or, for a negative softness, smooth difference."""
    if softness < 0:
        h = max(-softness - abs(field + other), 0) / softness
        return max(field, -other) - h * h * softness / 4
    if softness == 0:
        return min(field, other)
    h = max(softness - abs(field - other), 0) / softness
    return min(field, other) - h * h * softness / 4


def _ellipsoid(x, y, z, part):
    """Signed distance to first order; exact on the surface."""
    (cx, cy, cz), (rx, ry, rz), _ = part
    x, y, z = (x - cx) / rx, (y - cy) / ry, (z - cz) / rz
    scaled = math.sqrt(x * x + y * y + z * z)
    x, y, z = x / rx, y / ry, z / rz
    return scaled * (scaled - 1) / (math.sqrt(x * x + y * y + z * z) + 1e-9)


def _relief(x, y, z):
    """Curls of hair over the back and top of the head, worn stone elsewhere, and a scanner's noise."""
    hairline = min(1.0, max(0.0, (y - 0.60) / 0.06)) * min(1.0, max(0.0, (0.60 * (y - 0.77) - (z - 0.05)) / 0.04))
    worn = (
        0.004 * v.noise(9 * x, 9 * y, 9 * z)
        + 0.0014 * v.noise(31 * x, 31 * y, 31 * z)
        + 0.0005 * v.noise(140 * x, 140 * y, 140 * z)
    )
    if hairline == 0:
        return worn
    swirl = 1.1 * v.noise(11 * x, 11 * y, 11 * z + 40)
    strand = abs(v.noise(26 * x + swirl, 12 * y + swirl, 26 * z + 3))
    return worn - hairline * (0.020 - 0.055 * strand)


def _field(x, y, z, parts):
    field = 1e3
    for part in parts:
        field = _blend(field, _ellipsoid(x, y, z, part), part[2])
    return max(field + _relief(x, y, z), BOTTOM_M - y)


class _Grid:
    """Corners of jittered cells: position and field value, each made once."""

    def __init__(self, cell):
        self.cell, self.corners, self.bricks = cell, {}, {}

    def parts(self, i, j, k):
        key = (i // BRICK, j // BRICK, k // BRICK)
        if key not in self.bricks:
            side = self.cell * BRICK
            middle = [(n + 0.5) * side for n in key]
            reach = 1.4 * side + 0.04
            self.bricks[key] = [part for part in _PARTS if _ellipsoid(*middle, part) < reach + 1.5 * abs(part[2])]
        return self.bricks[key]

    def corner(self, key):
        found = self.corners.get(key)
        if found is None:
            i, j, k = (key & 4095) - 2048, (key >> 12 & 4095) - 2048, (key >> 24) - 2048
            h = (key * 2654435761 ^ key >> 13) * 2246822519 & 0xFFFFFFFF
            h = (h ^ h >> 15) * 3266489917 & 0xFFFFFFFF
            shift = 0.5 / 1023
            x = self.cell * (i + ((h & 1023) * shift - 0.25))
            y = self.cell * (j + ((h >> 10 & 1023) * shift - 0.25))
            z = self.cell * (k + ((h >> 20 & 1023) * shift - 0.25))
            found = self.corners[key] = (_field(x, y, z, self.parts(i, j, k)), x, y, z)
        return found


_CORNERS = [(n & 1) * _STEP[0] + (n >> 1 & 1) * _STEP[1] + (n >> 2) * _STEP[2] for n in range(8)]
_EDGES = [(n, n | 1 << axis) for axis in range(3) for n in range(8) if not n >> axis & 1]
_FACES = [
    (sign * _STEP[axis], [n for n in range(8) if (n >> axis & 1) == (sign > 0)])
    for axis in range(3)
    for sign in (-1, 1)
]


def _surface(cell):
    """Vertices (flat array) and triangles of the bust."""
    grid = _Grid(cell)
    seed = 2048 * sum(_STEP) + round(0.80 / cell) * _STEP[1]
    while grid.corner(seed)[0] < 0 and grid.corner(seed + _STEP[2])[0] < 0:
        seed += _STEP[2]
    vertex_of, positions, waiting = {seed: 0}, array("d"), [seed]
    for key in waiting:
        corners = [grid.corner(key + step) for step in _CORNERS]
        x = y = z = 0.0
        count = 0
        for a, b in _EDGES:
            (fa, xa, ya, za), (fb, xb, yb, zb) = corners[a], corners[b]
            if (fa < 0) != (fb < 0):
                t = fa / (fa - fb)
                x, y, z, count = x + xa + t * (xb - xa), y + ya + t * (yb - ya), z + za + t * (zb - za), count + 1
        positions.extend((x / count, y / count, z / count))
        for step, face in _FACES:
            inside = sum(corners[n][0] < 0 for n in face)
            if 0 < inside < 4 and key + step not in vertex_of:
                vertex_of[key + step] = len(waiting)
                waiting.append(key + step)
    triangles = array("I")
    for key in waiting:
        inside = grid.corner(key)[0] < 0
        for axis in range(3):
            if (grid.corner(key + _STEP[axis])[0] < 0) == inside:
                continue
            b, c = _STEP[(axis + 1) % 3], _STEP[(axis + 2) % 3]
            quad = [vertex_of[key - b - c], vertex_of[key - c], vertex_of[key], vertex_of[key - b]]
            if not inside:
                quad.reverse()
            p, q, r, s = (positions[3 * n : 3 * n + 3] for n in quad)
            p, q, r, s = (
                (quad[0], quad[1], quad[2], quad[3]) if math.dist(p, r) < math.dist(q, s) else (*quad[1:], quad[0])
            )
            triangles.extend((p, q, r, p, r, s))
    return positions, triangles


def _smooth_normals(positions, triangles):
    normals = array("d", bytes(8 * len(positions)))
    for t in range(0, len(triangles), 3):
        a, b, c = 3 * triangles[t], 3 * triangles[t + 1], 3 * triangles[t + 2]
        x, y, z = positions[a], positions[a + 1], positions[a + 2]
        ux, uy, uz = positions[b] - x, positions[b + 1] - y, positions[b + 2] - z
        wx, wy, wz = positions[c] - x, positions[c + 1] - y, positions[c + 2] - z
        nx, ny, nz = uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx
        for n in (a, b, c):
            normals[n] += nx
            normals[n + 1] += ny
            normals[n + 2] += nz
    for n in range(0, len(normals), 3):
        normals[n : n + 3] = array("d", v.unit(normals[n : n + 3]))
    return normals


def make(name, cell):
    glb = Glb(name)
    positions, triangles = _surface(cell)
    normals = _smooth_normals(positions, triangles)
    marble = glb.material("grey marble", (0.66, 0.63, 0.58), roughness=0.55)
    mesh = glb.mesh("bust", glb.primitive(Mesh(array("f", positions), array("f", normals), triangles), marble))
    glb.node("bust", mesh, (0, 0.175, 0), v.turn((0, 1, 0), 24))
    socle = lathe(
        [
            (0.0, 0.05),
            (0.19, 0.05),
            (0.19, 0.08),
            *arc((0.19, 0.14), 0.06, 260, 110, 8),
            (0.15, 0.205),
            (0.16, 0.24),
            (0.0, 0.24),
        ],
        64,
    )
    glb.draw(
        "socle",
        socle.join(bevelled_box((-0.23, 0, -0.23), (0.23, 0.06, 0.23), 0.01)),
        glb.material("dark stone", (0.06, 0.055, 0.05), roughness=0.35),
        40,
    )
    tiles = glb.texture("floor", checker((190, 178, 160), (140, 122, 104)))
    glb.draw("floor", box((-5, -0.2, -4), (5, 0, 5)), glb.material("floor", (1, 1, 1), texture=tiles), uv=floor_uv(1.2))
    glb.draw("back wall", box((-5, -0.2, -4.2), (5, 5, -4)), glb.material("blue wall", (0.16, 0.22, 0.30)))
    glb.draw(
        "mirror on the floor",
        bevelled_box((-0.8, -0.05, -0.6), (0.8, 0.012, 1.0), 0.006),
        glb.material("mirror", (0.90, 0.92, 0.92), 1.0, 0.0),
        20,
    )
    glb.light("lamp", "point", 30.0, (1.0, 0.93, 0.82), (-2.0, 2.7, 2.2))
    glb.light("fill", "point", 9.0, (0.75, 0.85, 1.0), (2.8, 1.4, 2.0))
    glb.camera("main", (0.5, 0.86, 2.45), (0.0, 0.52, 0.0), 38)
    return glb
