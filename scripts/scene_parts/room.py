"""A closed room with a mirror ball, a glossy box, a set table and two lamps."""

import math

from scene_parts import vector as v
from scene_parts.glb import Glb, png
from scene_parts.solid import arc, bevelled_box, box, circle, curve, lathe, skin, sphere, sweep
from scene_parts.surfaces import checker, floor_uv

HALF_WIDTH, HEIGHT, HALF_LENGTH, WALL = 2.0, 3.0, 3.0, 0.2


def _painting(x, y):
    """An abstract landscape, 128 x 128, sRGB."""
    u, w = x / 127, y / 127
    if math.hypot(u - 0.68, (w - 0.33) * 0.75) < 0.13:
        return (236, 120, 50)
    color = (244, 214, 150)
    for base, height, frequency, hill in (
        (0.55, 0.10, 2.3, (196, 146, 110)),
        (0.66, 0.09, 3.1, (96, 120, 128)),
        (0.80, 0.07, 4.7, (36, 62, 84)),
    ):
        if w > base + height * v.noise(u * frequency + base * 40, 0.5, 0.5):
            color = hill
    return color


def _walls(glb):
    white = glb.material("white plaster", (0.76, 0.74, 0.70))
    clay = glb.material("clay wall", (0.62, 0.20, 0.11))
    sea = glb.material("sea-green wall", (0.09, 0.36, 0.36))
    wood = glb.material("dark wood", (0.16, 0.075, 0.035), roughness=0.5)
    tiles = glb.texture("floor tiles", checker((232, 222, 204), (96, 84, 78)))
    floor = glb.material("tiled floor", (1, 1, 1), roughness=0.6, texture=tiles)
    x, z, t = HALF_WIDTH, HALF_LENGTH, WALL
    glb.draw("floor", box((-x - t, -t, -z - t), (x + t, 0, z + t)), floor, uv=floor_uv(1.0))
    glb.draw("ceiling", box((-x - t, HEIGHT, -z - t), (x + t, HEIGHT + t, z + t)), white)
    glb.draw("left wall", box((-x - t, 0, -z - t), (-x, HEIGHT, z + t)), clay)
    glb.draw("right wall", box((x, 0, -z - t), (x + t, HEIGHT, z + t)), sea)
    glb.draw("end wall", box((-x, 0, -z - t), (x, HEIGHT, -z)), white)
    glb.draw("wall behind the camera", box((-x, 0, z), (x, HEIGHT, z + t)), white)
    skirting = box((-x, 0, -z), (-x + 0.025, 0.12, z)).join(
        box((x - 0.025, 0, -z), (x, 0.12, z)),
        box((-x + 0.025, 0, -z), (x - 0.025, 0.12, -z + 0.025)),
        box((-x + 0.025, 0, z - 0.025), (x - 0.025, 0.12, z)),
    )
    glb.draw("skirting boards", skirting, wood)
    canvas = glb.texture("painting", png(128, 128, _painting))
    glb.draw(
        "painting",
        box((-0.6, 1.15, -z), (0.6, 2.05, -z + 0.03)),
        glb.material("painted canvas", (1, 1, 1), texture=canvas),
        uv=lambda p, n: (p[0] / 1.2 + 0.5, (2.05 - p[1]) / 0.9),
    )
    frame = [bevelled_box((-0.68, y, -z), (0.68, y + 0.08, -z + 0.06), 0.012) for y in (1.07, 2.05)]
    frame += [bevelled_box((side, 1.15, -z), (side + 0.08, 2.05, -z + 0.055), 0.012) for side in (-0.68, 0.60)]
    glb.draw("picture frame", frame[0].join(*frame[1:]), glb.material("old gold", (0.72, 0.50, 0.20), 1.0, 0.4))


def _table(glb, at):
    wood = glb.material("oak", (0.42, 0.24, 0.11), roughness=0.45)
    top = lathe([(0.0, 0.70), *arc((0.50, 0.72), 0.02, -90, 90, 4), (0.0, 0.74)], 40)
    leg = lathe(
        [
            (0.0, 0.0),
            (0.22, 0.0),
            (0.22, 0.03),
            (0.07, 0.08),
            (0.045, 0.16),
            (0.06, 0.30),
            (0.045, 0.40),
            (0.04, 0.58),
            (0.09, 0.70),
            (0.0, 0.70),
        ],
        24,
    )
    glb.node("round table", glb.solid("round table", top.join(leg), wood, 40), at)
    glaze = glb.material("blue glaze", (0.05, 0.12, 0.42), roughness=0.12)
    outer = curve([(0.05, 0.0), (0.12, 0.06), (0.155, 0.15), (0.12, 0.25), (0.055, 0.31), (0.075, 0.36)], 2)
    inner = [(max(r - 0.012, 0.01), y) for r, y in reversed(outer) if y > 0.02]
    vase = lathe([(0.0, 0.0), *outer, *inner, (0.0, 0.03)], 28)
    glb.node("vase", glb.solid("vase", vase, glaze, 50), v.add(at, (-0.14, 0.74, -0.10)))
    orange = glb.solid("orange", sphere(0.055, 4), glb.material("orange peel", (0.85, 0.30, 0.03), roughness=0.5))
    for number, offset in enumerate(
        ((0.16, 0.795, 0.12), (0.27, 0.795, 0.05), (0.21, 0.882, 0.09), (0.26, 0.795, 0.16))
    ):
        glb.node(f"orange {number + 1}", orange, v.add(at, offset), v.turn((1, 2, 3), 40 * number))


def _lamps(glb):
    steel = glb.material("black steel", (0.04, 0.04, 0.045), roughness=0.4)
    bulb = glb.material("glowing bulb", (1, 1, 1), emission=(1, 0.86, 0.62), strength=3.0)
    shade = lathe(
        [
            (0.30, 2.18),
            *arc((0.30, 2.188), 0.008, -60, 90, 2),
            (0.20, 2.35),
            (0.05, 2.44),
            (0.018, 2.50),
            (0.018, 2.46),
            (0.04, 2.425),
            (0.19, 2.34),
            (0.288, 2.19),
        ],
        40,
        loop=True,
    )
    glb.draw("pendant shade", shade, glb.material("brass shade", (0.80, 0.55, 0.22), 1.0, 0.35), 45)
    glb.draw(
        "pendant cord",
        lathe([(0.0, 2.36), (0.012, 2.36), (0.012, 2.97), (0.06, 2.98), (0.06, 3.01), (0.0, 3.01)], 12),
        steel,
    )
    glb.draw("pendant bulb", sphere(0.07, 4).moved((0, 2.30, 0)), bulb)
    glb.light("pendant", "point", 8.6, (1.0, 0.90, 0.76), (0, 2.17, 0))
    x, z = 1.45, -2.4
    stand = lathe([(0.0, 0.0), (0.16, 0.0), (0.16, 0.02), (0.02, 0.04), (0.015, 1.55), (0.04, 1.60), (0.0, 1.60)], 20)
    bowl = lathe([(0.0, 1.60), (0.06, 1.605), (0.14, 1.65), (0.18, 1.72), (0.17, 1.72), (0.13, 1.66), (0.0, 1.62)], 32)
    glb.draw("floor lamp", stand.join(bowl).moved((x, 0, z)), steel)
    glb.draw(
        "floor lamp glow", lathe([(0.0, 1.66), (0.13, 1.67), (0.16, 1.705), (0.0, 1.71)], 32).moved((x, 0, z)), bulb
    )
    glb.light("floor lamp", "point", 1.7, (1.0, 0.84, 0.62), (x, 1.78, z))
    glb.light("fill from the left", "point", 6.0, (0.84, 0.91, 1.0), (-1.3, 2.2, 2.7))
    glb.light("fill from the right", "point", 3.5, (1.0, 0.94, 0.86), (1.5, 1.4, 2.8))


def make():
    glb = Glb("room")
    _walls(glb)
    _table(glb, (0.95, 0, -1.55))
    _lamps(glb)
    mirror = glb.material("mirror", (0.95, 0.95, 0.96), 1.0, 0.0)
    glb.node("mirror ball", glb.solid("mirror ball", sphere(0.55, 14), mirror, normal=v.unit), (-0.75, 0.87, -1.2))
    plinth = bevelled_box((-0.36, 0, -0.36), (0.36, 0.28, 0.36), 0.02).join(
        lathe([(0.0, 0.28), (0.20, 0.28), (0.20, 0.32), (0.235, 0.43), (0.205, 0.43), (0.17, 0.33), (0.0, 0.32)], 32)
    )
    glb.node(
        "plinth", glb.solid("plinth", plinth, glb.material("grey stone", (0.42, 0.41, 0.40)), 40), (-0.75, 0, -1.2)
    )
    amber = glb.material("glossy amber", (0.72, 0.36, 0.05), roughness=0.15)
    glb.node(
        "glossy box",
        glb.solid("glossy box", bevelled_box((-0.27, 0, -0.27), (0.27, 0.62, 0.27), 0.03), amber),
        (0.20, 0, -0.35),
        v.turn((0, 1, 0), 24),
    )
    petals = skin(
        [
            circle(r, y, 60, lambda a: 1 + 0.05 * abs(math.cos(5 * a)))
            for r, y in ((0, 0), (0.20, 0), *arc((0.20, 0.17), 0.17, -75, 75, 8), (0.05, 0.345), (0, 0.335))
        ]
    )
    glb.node(
        "pouffe", glb.solid("pouffe", petals, glb.material("plum cloth", (0.30, 0.07, 0.20)), 60), (-1.15, 0, -0.05)
    )
    ring = [
        (0.16 * math.cos(a), 0.16 * math.sin(a), 0.03 * math.sin(3 * a))
        for a in (2 * math.pi * i / 40 for i in range(40))
    ]
    glb.node(
        "copper ring",
        glb.solid("copper ring", sweep(ring, 0.03, 10, loop=True), glb.material("copper", (0.9, 0.5, 0.3), 1.0, 0.25)),
        (0.19, 0.79, -0.35),
        v.turn((0, 1, 0), 15),
    )
    glb.camera("main", (0.25, 1.45, 2.75), (-0.02, 1.18, -1.5), 50)
    glb.camera("ball", (0.15, 1.25, 0.55), (-0.75, 0.85, -1.2), 38)
    return glb
