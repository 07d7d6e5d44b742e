"""A chrome teapot and a mirror ball among small coloured things near them, in a hall with a checker floor."""

import math

from scene_parts import vector as v
from scene_parts.glb import Glb
from scene_parts.solid import Solid, arc, bevelled_box, box, circle, curve, extrude, lathe, skin, sphere, sweep
from scene_parts.surfaces import checker, floor_uv


def _teapot():
    """Stands on y = 0, 1.6 m wide without spout and handle: larger than life, as in every laboratory."""
    body = curve([(0.48, 0.04), (0.62, 0.10), (0.79, 0.38), (0.74, 0.70), (0.52, 0.93), (0.40, 0.985)], 7)
    rim = arc((0.40, 1.00), 0.022, -60, 120, 5)
    lid = curve([(0.36, 1.02), (0.30, 1.10), (0.16, 1.17), (0.06, 1.20)], 4)
    knob = curve([(0.045, 1.23), (0.10, 1.29), (0.085, 1.36), (0.03, 1.39)], 4)
    pot = lathe(
        [
            (0.0, 0.0),
            (0.44, 0.0),
            *arc((0.46, 0.02), 0.02, -70, 30, 3),
            *body,
            *rim,
            (0.37, 1.01),
            *lid,
            *knob,
            (0.0, 1.395),
        ],
        72,
    )
    spout = curve([(0.58, 0.34, 0), (0.86, 0.42, 0), (1.02, 0.66, 0), (1.10, 0.88, 0), (1.27, 1.02, 0)], 7)
    pot.join(sweep(spout, lambda t: 0.19 - 0.115 * t**0.7 + 0.02 * t**6, 24))
    handle = curve(
        [(-0.62, 0.80, 0), (-0.90, 0.86, 0), (-1.12, 0.78, 0), (-1.14, 0.56, 0), (-0.98, 0.34, 0), (-0.66, 0.26, 0)], 7
    )
    return pot.join(sweep(handle, lambda t: 0.055 + 0.03 * (2 * t - 1) ** 4, 20))


def _spring():
    path = []
    for i in range(181):
        a = 2 * math.pi * 5 * i / 180
        path.append((0.17 * math.cos(a), 0.05 + 0.62 * i / 180, 0.17 * math.sin(a)))
    return sweep(path, 0.035, 10)


def _gear():
    teeth, outline = 14, []
    for i in range(teeth):
        for share, radius in ((-0.30, 0.27), (-0.17, 0.34), (0.17, 0.34), (0.30, 0.27)):
            a = 2 * math.pi * (i + share) / teeth
            outline.append((radius * math.cos(a), radius * math.sin(a)))
    gear = extrude(outline, 0.12)
    hub = lathe([(0.0, -0.11), (0.11, -0.11), (0.13, -0.09), (0.13, 0.09), (0.11, 0.11), (0.0, 0.11)], 28).turned(
        (1, 0, 0), 90
    )
    return gear.join(hub).turned((0, 0, 1), 180 / teeth * 0.5).moved((0, 0.335, 0))


def _spikes():
    """A ball with a spike on each face of a coarse sphere."""
    core = sphere(0.20, 2)
    solid = Solid(core.points)
    for face in core.faces:
        middle = v.unit(v.add(v.add(core.points[face[0]], core.points[face[1]]), core.points[face[2]]))
        tip = len(solid.points)
        solid.points.append(v.scale(middle, 0.36))
        solid.faces += [(face[0], face[1], tip), (face[1], face[2], tip), (face[2], face[0], tip)]
    return solid.moved((0, 0.34, 0))


def _knot(p, q, size, thick, steps, segments):
    """Torus knot in the xz plane, that winds p times about the axis and q times about the ring."""
    path = []
    for i in range(steps):
        a = 2 * math.pi * i / steps
        r = size * (1 + 0.42 * math.cos(q * a))
        path.append((r * math.cos(p * a), 0.5 * size * math.sin(q * a), r * math.sin(p * a)))
    return sweep(path, thick, segments, loop=True)


def _cup():
    outer = curve([(0.10, 0.0), (0.12, 0.02), (0.17, 0.14), (0.21, 0.30)], 5)
    inner = [(r - 0.018, y) for r, y in reversed(outer) if y > 0.025]
    cup = lathe([(0.0, 0.0), *outer, *inner, (0.0, 0.03)], 40)
    handle = curve([(0.165, 0.10, 0), (0.26, 0.09, 0), (0.31, 0.17, 0), (0.27, 0.25, 0), (0.19, 0.24, 0)], 5)
    return cup.join(sweep(handle, 0.02, 10))


def _twist():
    def section(angle):
        return 1 + 0.22 * math.cos(5 * angle)

    return skin(
        [
            [
                v.rotate(v.turn((0, 1, 0), 150 * i / 24), p)
                for p in circle(0.17 - 0.05 * i / 24, 0.75 * i / 24, 50, section)
            ]
            for i in range(25)
        ]
    )


def _near_things(glb):
    things = (
        ("red spring", _spring(), (0.75, 0.03, 0.03), 0.30),
        ("green gear", _gear(), (0.04, 0.46, 0.08), 0.5),
        ("blue spikes", _spikes(), (0.03, 0.10, 0.70), 0.4),
        ("yellow knot", _knot(2, 3, 0.23, 0.055, 120, 12).moved((0, 0.175, 0)), (0.85, 0.62, 0.02), 0.35),
        ("orange cup", _cup(), (0.85, 0.26, 0.02), 0.2),
        ("violet twist", _twist(), (0.30, 0.06, 0.50), 0.5),
        ("white die", bevelled_box((-0.2, 0, -0.2), (0.2, 0.4, 0.2), 0.04), (0.80, 0.80, 0.78), 0.4),
        (
            "cyan ring",
            sweep(
                [(0.24 * math.cos(a), 0.30 + 0.24 * math.sin(a), 0) for a in (2 * math.pi * i / 48 for i in range(48))],
                0.06,
                16,
                loop=True,
            ),
            (0.02, 0.50, 0.58),
            0.35,
        ),
    )
    places = (
        (-0.95, 1.15),
        (1.42, 0.55),
        (-1.62, 0.42),
        (-0.10, 1.50),
        (0.62, 1.30),
        (-1.40, -0.55),
        (1.15, -1.25),
        (1.55, -0.65),
    )
    for number, ((name, solid, color, roughness), (x, z)) in enumerate(zip(things, places)):
        mesh = glb.solid(name, solid, glb.material(name.split()[0] + " enamel", color, roughness=roughness), 35)
        glb.node(name, mesh, (x, 0, z), v.turn((0, 1, 0), 61 * number - 40))


def _hall(glb):
    x, z, height, t = 7.0, 6.0, 4.6, 0.3
    tiles = glb.texture("checker", checker((226, 224, 218), (62, 66, 76), 6))
    glb.draw(
        "floor",
        box((-x - t, -t, -z - t), (x + t, 0, z + t)),
        glb.material("checker floor", (1, 1, 1), roughness=0.5, texture=tiles),
        uv=floor_uv(1.6),
    )
    white = glb.material("white plaster", (0.74, 0.73, 0.70))
    walls = (
        ("end wall", (-x, 0, -z - t), (x, height, -z), (0.72, 0.56, 0.32)),
        ("left wall", (-x - t, 0, -z - t), (-x, height, z + t), (0.50, 0.12, 0.10)),
        ("right wall", (x, 0, -z - t), (x + t, height, z + t), (0.13, 0.24, 0.46)),
        ("wall behind the camera", (-x, 0, z), (x, height, z + t), (0.24, 0.40, 0.22)),
    )
    for name, low, high, color in walls:
        glb.draw(name, box(low, high), glb.material(f"{name} paint", color))
    glb.draw("ceiling", box((-x - t, height, -z - t), (x + t, height + t, z + t)), white)
    beam = glb.solid("beam", bevelled_box((-x - 0.1, height - 0.28, -0.16), (x + 0.1, height + 0.1, 0.16), 0.02), white)
    pillar = bevelled_box((-0.36, 0, -0.36), (0.36, 0.24, 0.36), 0.03).join(
        bevelled_box((-0.36, height - 0.5, -0.36), (0.36, height - 0.24, 0.36), 0.03),
        lathe(
            [
                (0.0, 0.24),
                *arc((0.28, 0.29), 0.05, -90, 90, 5),
                (0.25, 0.36),
                (0.21, height - 0.62),
                *arc((0.25, height - 0.555), 0.055, -90, 90, 5),
                (0.0, height - 0.5),
            ],
            28,
        ),
    )
    pillars = glb.solid("pillar", pillar, white, 40)
    for i, along in enumerate((-4.4, 0.0, 4.4)):
        glb.node(f"beam {i + 1}", beam, (0, 0, along))
        glb.node(f"left pillar {i + 1}", pillars, (-4.9, 0, along))
        glb.node(f"right pillar {i + 1}", pillars, (4.9, 0, along))
    brass = glb.material("brass", (0.85, 0.62, 0.28), 1.0, 0.3)
    globe = glb.material("glowing globe", (1, 1, 1), emission=(1, 0.92, 0.78), strength=2.5)
    glb.draw(
        "lamp chain", lathe([(0.0, 3.74), (0.02, 3.74), (0.02, 4.64), (0.0, 4.64)], 12).moved((-0.6, 0, 2.6)), brass
    )
    glb.draw(
        "lamp globe",
        sphere(0.2, 6).moved((-0.6, 3.56, 2.6)),
        globe,
        normal=lambda p: v.unit(v.sub(p, (-0.6, 3.56, 2.6))),
    )


def make():
    glb = Glb("chrome")
    _hall(glb)
    _near_things(glb)
    chrome = glb.material("chrome", (0.93, 0.94, 0.96), 1.0, 0.0)
    stand = lathe(
        [
            (0.0, 0.0),
            (0.66, 0.0),
            (0.66, 0.03),
            (0.62, 0.07),
            (0.62, 0.16),
            *arc((0.64, 0.18), 0.02, -60, 90, 3),
            (0.0, 0.20),
        ],
        48,
    )
    glb.draw("stand", stand, glb.material("black stone", (0.03, 0.03, 0.035), roughness=0.3), 40)
    glb.node("teapot", glb.solid("teapot", _teapot(), chrome, 40), (0, 0.2, 0), v.turn((0, 1, 0), -22))
    glb.node("mirror ball", glb.solid("mirror ball", sphere(0.42, 14), chrome, normal=v.unit), (2.35, 0.42, 0.75))
    glb.light("lamp", "point", 21.0, (1.0, 0.94, 0.84), (-0.6, 3.30, 2.6))
    glb.light("spot", "spot", 42.0, (1.0, 0.97, 0.92), (4.2, 4.0, 3.6), (-4.2, -3.6, -3.8), cone_degrees=(16, 30))
    glb.light("fill", "point", 15.0, (0.82, 0.89, 1.0), (-3.6, 2.6, -1.6))
    glb.camera("main", (0.55, 1.95, 5.2), (0.22, 0.72, 0.0), 38)
    glb.camera("teapot", (0.5, 1.45, 3.0), (0.05, 0.80, 0.0), 42)
    return glb
