"""An open nave between two rows of fluted columns with arches, polished tiles down its middle, under a sun."""

import math

from scene_parts import vector as v
from scene_parts.glb import Glb, shaded
from scene_parts.solid import Solid, arc, bevelled_box, box, circle, curve, extrude, lathe, skin, sphere
from scene_parts.surfaces import checker, floor_uv, marble

BAYS, BAY, ROW_X = 7, 3.4, 3.3  # bays a side, metres from column to column, rows at x = -ROW_X and ROW_X
CAPITAL_TOP, WALL_TOP, CORNICE_TOP = 4.9, 7.1, 7.75
LENGTH = BAYS * BAY


def _shaft():
    flutes, steps = 20, 4

    def section(angle):
        t = (-angle * flutes / (2 * math.pi)) % 1 * 2 - 1
        return 1 - 0.065 * (1 - t * t)

    heights = (0.42, 0.46, 1.2, 2.0, 2.8, 3.5, 3.98, 4.02)
    rings = []
    for y in heights:
        t = (y - 0.42) / 3.6
        radius = 0.42 - 0.07 * t**1.7
        fluted = 0.46 <= y <= 3.98
        rings.append(circle(radius if fluted else radius * 0.985, y, flutes * steps, section if fluted else None))
    return skin(rings)


def _base():
    profile = [
        (0.0, 0.14),
        *arc((0.50, 0.205), 0.065, -90, 90, 6),
        (0.47, 0.285),
        *arc((0.50, 0.315), 0.035, 225, 135, 3)[1:],
        *arc((0.46, 0.375), 0.035, -60, 90, 4),
        (0.42, 0.43),
        (0.0, 0.43),
    ]
    return lathe(profile, 40).join(bevelled_box((-0.6, 0, -0.6), (0.6, 0.15, 0.6), 0.012))


def _capital():
    """A bell with two tiers of eight leaves, under a slab."""
    bell = lathe(
        [
            (0.0, 4.0),
            *arc((0.355, 4.03), 0.03, -90, 90, 3),
            (0.335, 4.08),
            (0.34, 4.3),
            (0.38, 4.52),
            (0.46, 4.68),
            (0.0, 4.68),
        ],
        32,
    )
    leaves = Solid()
    for tier, (low, high, reach, turned) in enumerate(((4.05, 4.36, 0.13, 0.0), (4.20, 4.62, 0.19, 22.5))):
        for leaf in range(8):
            leaves.join(
                _leaf(high - low, reach).moved((0.335 + 0.01 * tier, low, 0)).turned((0, 1, 0), turned + 45 * leaf)
            )
    slab = bevelled_box((-0.56, 4.76, -0.56), (0.56, CAPITAL_TOP, 0.56), 0.015)
    return bell.join(leaves, lathe([(0.0, 4.66), *arc((0.47, 4.71), 0.05, -90, 90, 4), (0.0, 4.76)], 32), slab)


def _leaf(height, reach):
    """A leaf that climbs along +Y and curls outward along +X."""
    spine = curve(
        [
            (0.0, 0.0),
            (0.025, 0.35 * height),
            (0.05, 0.72 * height),
            (0.62 * reach, 0.97 * height),
            (reach, 0.88 * height),
        ],
        2,
    )
    rings = []
    for i, (x, y) in enumerate(spine):
        t = i / (len(spine) - 1)
        half = 0.115 * math.sqrt(max(1 - t**3, 0.04))
        thick = 0.018
        before, after = spine[max(i - 1, 0)], spine[min(i + 1, len(spine) - 1)]
        slope = v.unit((after[0] - before[0], after[1] - before[1], 0))
        out = (slope[1] * thick, -slope[0] * thick, 0)
        middle, edge = (x, y, 0), (x - 0.35 * out[0] - 0.02, y - 0.35 * out[1], half)
        rings.append([v.add(middle, out), (edge[0], edge[1], -half), v.sub((x - 0.02, y, 0), out), edge])
    return skin(rings)


def _arch():
    """One bay of the wall over the columns, along x; an arch is cut out of its foot."""
    radius = BAY / 2 - 0.47
    inner = arc((0, CAPITAL_TOP), radius, 180, 0, 28)
    wall = extrude(
        [(-BAY / 2, CAPITAL_TOP), *inner, (BAY / 2, CAPITAL_TOP), (BAY / 2, WALL_TOP), (-BAY / 2, WALL_TOP)], 0.80
    )
    band = Solid()
    for low, high, depth in ((radius - 0.02, radius + 0.12, 0.88), (radius + 0.10, radius + 0.22, 0.94)):
        band.join(extrude(arc((0, CAPITAL_TOP), high, 0, 180, 28) + arc((0, CAPITAL_TOP), low, 180, 0, 28), depth))
    top = CAPITAL_TOP + radius
    key = extrude([(-0.10, top - 0.06), (0.10, top - 0.06), (0.16, top + 0.36), (-0.16, top + 0.36)], 1.04)
    profile = [
        (0.0, 0.0),
        (0.26, 0.0),
        *arc((0.26, 0.035), 0.035, -45, 100, 4),
        (0.20, 0.03),
        (0.12, 0.045),
        (0.0, 0.09),
    ]
    for side in (-1, 1):
        disc = lathe(profile, 24).turned((1, 0, 0), 90 * side).moved((-BAY / 2, WALL_TOP - 0.72, 0.39 * side))
        key.join(disc)
    return wall, band.join(key)


def _cornice():
    """The moulding that runs along a row, over the nave's length; profile in (x, y), drawn out along z."""
    half = [
        (0.40, WALL_TOP),
        (0.44, WALL_TOP + 0.05),
        (0.44, WALL_TOP + 0.22),
        (0.62, WALL_TOP + 0.34),
        (0.62, WALL_TOP + 0.44),
        *curve([(0.66, WALL_TOP + 0.46), (0.70, WALL_TOP + 0.53), (0.78, WALL_TOP + 0.57), (0.80, CORNICE_TOP)], 3),
    ]
    return extrude(half + [(-x, y) for x, y in reversed(half)], LENGTH + 1.2)


def _dentils():
    teeth = Solid()
    for side in (-1, 1):
        for i in range(10):
            z = (i + 0.5) * BAY / 10 - BAY / 2
            teeth.join(
                box(
                    (min(0.42 * side, 0.56 * side), WALL_TOP + 0.08, z - 0.085),
                    (max(0.42 * side, 0.56 * side), WALL_TOP + 0.21, z + 0.085),
                )
            )
    return teeth


def _rows(glb, stone, trim):
    shaft, base = glb.primitive(shaded(_shaft(), 22), stone), glb.primitive(shaded(_base(), 40), trim)
    column = glb.mesh("column", shaft, base, glb.primitive(shaded(_capital(), 42), trim))
    wall, band = _arch()
    wall.check_closed("arch wall")
    arch = glb.mesh("arch", glb.primitive(shaded(wall, 20), stone), glb.primitive(shaded(band, 30), trim))
    dentils = glb.solid("dentils", _dentils(), trim)
    cornice = glb.solid("cornice", _cornice(), trim, 25)
    for side, x in (("left", -ROW_X), ("right", ROW_X)):
        for i in range(BAYS + 1):
            glb.node(f"{side} column {i + 1}", column, (x, 0, -BAY * i), v.turn((0, 1, 0), 90 * (i % 4)))
        for i in range(BAYS):
            glb.node(f"{side} arch {i + 1}", arch, (x, 0, -BAY * (i + 0.5)), v.turn((0, 1, 0), 90))
            glb.node(f"{side} dentils {i + 1}", dentils, (x, 0, -BAY * (i + 0.5)))
        glb.node(f"{side} cornice", cornice, (x, 0, -LENGTH / 2))
    rib = extrude(arc((0, CORNICE_TOP), ROW_X + 0.45, 0, 180, 40) + arc((0, CORNICE_TOP), ROW_X, 180, 0, 40), 0.6)
    rib.join(
        extrude(arc((0, CORNICE_TOP), ROW_X + 0.37, 0, 180, 40) + arc((0, CORNICE_TOP), ROW_X - 0.1, 180, 0, 40), 0.32)
    )
    ribs = glb.solid("rib", rib, trim, 20)
    for i in range(1, BAYS + 1, 2):
        glb.node(f"rib {i // 2 + 1}", ribs, (0, 0, -BAY * i))


def _floor(glb, stone):
    tiles = glb.texture("paving", checker((205, 190, 165), (178, 160, 134), 18))
    paving = glb.material("paving", (1, 1, 1), roughness=0.8, texture=tiles)
    for step, (grow, low, high) in enumerate(((0.0, -0.16, 0.0), (0.4, -0.32, -0.16), (0.8, -0.5, -0.32))):
        x, z = ROW_X + 1.1 + grow, 1.2 + grow
        glb.draw(
            f"step {3 - step}",
            box((-x, low, -LENGTH - z - 4), (x, high, z + 5)),
            paving if step == 0 else stone,
            uv=floor_uv(1.7) if step == 0 else None,
        )
    veins = glb.texture("veins", marble())
    dark = glb.material("polished serpentine", (0.045, 0.10, 0.08), 0.0, 0.0, texture=veins)
    light = glb.material("polished marble", (0.62, 0.58, 0.52), 0.12, 0.0, texture=veins)
    tile = bevelled_box((-0.594, -0.05, -0.594), (0.594, 0.012, 0.594), 0.006)
    meshes = [
        glb.solid(f"{name} tile", tile, material, 20, uv=floor_uv(1.2))
        for name, material in (("dark", dark), ("light", light))
    ]
    for row in range(21):
        for column in range(3):
            glb.node(
                f"tile {row + 1}.{column + 1}", meshes[(row + column) % 2], (1.2 * (column - 1), 0, 1.6 - 1.2 * row)
            )


def _surroundings(glb, stone, trim):
    ground = glb.material("dry grass", (0.30, 0.29, 0.13))
    glb.draw("ground", box((-90, -1, -120), (90, -0.5, 60)), ground)
    plaster = glb.material("ochre plaster", (0.60, 0.36, 0.17))
    glb.draw("side wall", box((-9.0, -0.5, -LENGTH - 9), (-8.2, 6.2, 7)), plaster)
    glb.draw("side wall coping", bevelled_box((-9.15, 6.2, -LENGTH - 9.1), (-8.05, 6.45, 7.1), 0.05), trim)
    pier = glb.solid("pier", bevelled_box((-0.35, -0.5, -0.45), (0.3, 6.1, 0.45), 0.03), stone)
    for i in range(BAYS + 2):
        glb.node(f"pier {i + 1}", pier, (-8.1, 0, -BAY * i))
    z = -LENGTH - 4.6
    opening = arc((0, 4.2), 1.9, 180, 0, 32)
    portal = extrude([(-8.2, -0.5), (-1.9, -0.5), *opening, (1.9, -0.5), (8.2, -0.5), (8.2, 8.6), (-8.2, 8.6)], 1.0)
    glb.node("portal", glb.solid("portal", portal, plaster, 20), (0, 0, z))
    frame = extrude(
        [
            (1.9 + 0.3, -0.5),
            *arc((0, 4.2), 2.2, 0, 180, 32),
            (-2.2, -0.5),
            (-1.85, -0.5),
            *arc((0, 4.2), 1.85, 180, 0, 32),
            (1.85, -0.5),
        ],
        1.16,
    )
    glb.node("portal frame", glb.solid("portal frame", frame, trim, 20), (0, 0, z))
    glb.draw("portal coping", bevelled_box((-8.4, 8.6, z - 0.7), (8.4, 8.95, z + 0.7), 0.06), trim)
    tree = lathe(
        [
            (0.0, 0.0),
            (0.12, 0.0),
            (0.10, 0.8),
            *curve([(0.45, 0.7), (0.75, 1.9), (0.62, 4.0), (0.30, 6.0), (0.03, 7.2)], 5),
            (0.0, 7.25),
        ],
        26,
    )

    def ragged(p):
        grow = 1 + (0.45 * v.fractal_noise(4 * p[0], 2 * p[1], 4 * p[2] + 7, 2) if p[1] > 0.75 else 0)
        return (p[0] * grow, p[1], p[2] * grow)

    tree = tree.map(ragged)
    cypress = glb.solid("cypress", tree, glb.material("cypress", (0.045, 0.10, 0.04)), 60)
    for i in range(9):
        glb.node(
            f"cypress {i + 1}",
            cypress,
            (7.2 + 0.5 * (i % 2), -0.5, 1.5 - 3.6 * i),
            v.turn((0, 1, 0), 77 * i),
            0.8 + 0.06 * (i * 5 % 7),
        )
    for i, (x, size) in enumerate(((-3.6, 1.5), (0.7, 1.7), (3.2, 1.4))):
        glb.node(f"far cypress {i + 1}", cypress, (x, -0.5, z - 9 - 2 * i), v.turn((0, 1, 0), 50 * i), size)


def _fountain(glb, stone):
    """A basin with a chrome ball over it, at the end of the nave."""
    basin = [
        (0.0, 0.0),
        (0.55, 0.0),
        (0.55, 0.12),
        (0.22, 0.2),
        (0.16, 0.55),
        (0.22, 0.72),
        *arc((0.80, 0.98), 0.06, -60, 150, 6),
        (0.70, 0.95),
        (0.0, 0.80),
    ]
    glb.node("basin", glb.solid("basin", lathe(basin, 48), stone, 40), (0, 0, -LENGTH + 1.2))
    glb.node(
        "ball",
        glb.solid("ball", sphere(0.5, 12), glb.material("gilded mirror", (0.95, 0.72, 0.36), 1.0, 0.0), normal=v.unit),
        (0, 1.32, -LENGTH + 1.2),
    )


def make():
    glb = Glb("colonnade")
    stone = glb.material("limestone", (0.66, 0.59, 0.47))
    trim = glb.material("pale limestone", (0.74, 0.69, 0.60), roughness=0.7)
    _rows(glb, stone, trim)
    _floor(glb, stone)
    _surroundings(glb, stone, trim)
    _fountain(glb, stone)
    glb.light("sun", "directional", 2.7, (1.0, 0.93, 0.80), direction=(-0.62, -0.66, -0.42))
    glb.light("sky from behind", "directional", 0.75, (0.74, 0.85, 1.0), direction=(-0.22, -0.42, -0.88))
    glb.light("light off the floor", "point", 4.0, (1.0, 0.88, 0.70), at=(-0.9, 1.7, -2.5))
    glb.light("light off the far floor", "point", 4.0, (1.0, 0.88, 0.70), at=(-0.9, 1.7, -13.5))
    glb.camera("main", (-1.35, 1.65, 4.6), (0.25, 2.55, -12.0), 56, zfar=300.0)
    return glb
