"""A hall in which a carousel of ducks turns for two seconds, and then again; a mirror ball watches it."""

import math

from scene_parts import vector as v
from scene_parts.glb import Glb, look
from scene_parts.solid import Solid, arc, bevelled_box, box, circle, curve, lathe, skin, sphere
from scene_parts.surfaces import checker, floor_uv

SECONDS = 2.0
DUCKS = 6


def _hall(glb):
    x, front, back, height, t = 5.0, 5.6, -4.0, 4.4, 0.25
    tiles = glb.texture("floor tiles", checker((214, 204, 188), (92, 60, 52), 8))
    glb.draw(
        "floor",
        box((-x - t, -t, back - t), (x + t, 0, front + t)),
        glb.material("tiled floor", (1, 1, 1), roughness=0.55, texture=tiles),
        uv=floor_uv(1.5),
    )
    plaster = glb.material("cream plaster", (0.74, 0.70, 0.60))
    teal = glb.material("teal wall", (0.08, 0.30, 0.33))
    glb.draw("ceiling", box((-x - t, height, back - t), (x + t, height + t, front + t)), plaster)
    glb.draw("back wall", box((-x, 0, back - t), (x, height, back)), teal)
    glb.draw("wall behind the camera", box((-x, 0, front), (x, height, front + t)), plaster)
    glb.draw("left wall", box((-x - t, 0, back - t), (-x, height, front + t)), glb.material("red", (0.52, 0.11, 0.08)))
    glb.draw("right wall", box((x, 0, back - t), (x + t, height, front + t)), plaster)
    pillar = bevelled_box((-0.38, 0, -0.38), (0.38, 0.22, 0.38), 0.03).join(
        lathe(
            [
                (0.0, 0.22),
                *arc((0.28, 0.27), 0.05, -90, 90, 4),
                (0.24, 0.34),
                (0.20, height - 0.34),
                *arc((0.24, height - 0.27), 0.05, -90, 90, 4),
                (0.0, height - 0.22),
            ],
            24,
        ),
        bevelled_box((-0.38, height - 0.22, -0.38), (0.38, height, 0.38), 0.03),
    )
    pillars = glb.solid("pillar", pillar, plaster, 40)
    glb.node("left pillar", pillars, (-4.1, 0, -3.1))
    glb.node("right pillar", pillars, (4.1, 0, -3.1))
    pine = glb.material("pine", (0.5, 0.3, 0.13))
    crate = glb.solid("crate", bevelled_box((-0.3, 0, -0.3), (0.3, 0.6, 0.3), 0.03), pine)
    for number, (at, turned) in enumerate((((4.3, 0, -1.7), 8), ((4.42, 0, -0.95), -12), ((4.36, 0.6, -1.4), 31))):
        glb.node(f"crate {number + 1}", crate, at, v.turn((0, 1, 0), turned))


def _duck():
    """Looks along +Z; its middle is where the pole goes through it."""
    body = sphere(1.0, 4).scaled(0.20, 0.17, 0.30)
    body = body.map(lambda p: (p[0], p[1] + 1.6 * max(0.0, -p[2] - 0.12) ** 1.5, p[2]))
    head = sphere(0.125, 3).moved((0, 0.26, 0.22))
    beak = lathe([(0.0, 0.0), (0.06, 0.0), (0.045, 0.06), (0.05, 0.11), (0.0, 0.13)], 10).scaled(1, 1, 0.5)
    return body.join(head, beak.turned((1, 0, 0), 90).moved((0, 0.245, 0.32)))


def _canopy(first):
    """Every second of 12 wedges of a roof, each closed by itself."""
    solid, half = Solid(), math.pi / 12
    for wedge in range(first, 12, 2):
        a = 2 * math.pi * wedge / 12
        low, high = ([(1.95 * math.cos(b), y, 1.95 * math.sin(b)) for b in (a + half, a - half)] for y in (2.30, 2.45))
        points = [(0.0, 2.38, 0.0), *low, (0.0, 3.05, 0.0), *high]
        solid.join(Solid(points, [(0, 2, 1), (3, 4, 5), (1, 2, 5, 4), (0, 1, 4, 3), (2, 0, 3, 5)]))
    return solid


def _carousel(glb):
    wood = glb.material("painted wood", (0.36, 0.05, 0.06), roughness=0.4)
    brass = glb.material("brass", (0.85, 0.62, 0.28), 1.0, 0.3)
    gold = glb.material("yellow enamel", (0.85, 0.58, 0.03), roughness=0.3)
    cream = glb.material("cream canvas", (0.82, 0.76, 0.62))
    red = glb.material("red canvas", (0.60, 0.05, 0.05))
    glb.draw("base", lathe([(0.0, 0.0), (2.0, 0.0), (2.0, 0.12), (1.9, 0.16), (0.0, 0.16)], 40), wood)
    turntable = glb.node("turntable", at=(0, 0.16, 0))
    deck = lathe([(0.0, 0.0), (1.85, 0.0), (1.85, 0.05), (0.0, 0.05)], 40)
    glb.node("deck", glb.solid("deck", deck, cream), parent=turntable)
    post = curve([(0.42, 0.05), (0.30, 0.30), (0.20, 0.9), (0.26, 1.6), (0.20, 2.2)], 3)
    glb.node("post", glb.solid("post", lathe([(0.0, 0.05), *post, (0.0, 2.2)], 20), wood, 50), parent=turntable)
    glb.node("red canopy", glb.solid("red canopy", _canopy(0), red), parent=turntable)
    glb.node("cream canopy", glb.solid("cream canopy", _canopy(1), cream), parent=turntable)
    knob = sphere(0.14, 3).moved((0, 3.12, 0))
    glb.node("knob", glb.solid("knob", knob, brass, normal=lambda p: v.unit(v.sub(p, (0, 3.12, 0)))), parent=turntable)
    pole = glb.solid("pole", lathe([(0.0, 0.05), (0.025, 0.05), (0.025, 2.35), (0.0, 2.35)], 8), brass)
    duck = glb.solid("duck", _duck(), gold, 60)
    for number in range(DUCKS):
        angle = 2 * math.pi * number / DUCKS
        at = (1.35 * math.sin(angle), 0.0, 1.35 * math.cos(angle))
        turned = v.turn((0, 1, 0), 360 * number / DUCKS + 90)
        glb.node(f"pole {number + 1}", pole, at, parent=turntable)
        rider = glb.node(f"duck {number + 1}", duck, (at[0], 0.85, at[2]), turned, parent=turntable)
        # Half a period a second, every other duck against its neighbours: where one ends, the next but one began.
        side = 0.22 * (-1) ** number
        speed = side * math.pi
        keys = ((0.0, 0.85, speed), (0.5, 0.85 + side, 0.0), (1.5, 0.85 - side, 0.0), (2.0, 0.85, speed))
        values = [value for _, y, up in keys for value in ((0, up, 0), (at[0], y, at[2]), (0, up, 0))]
        glb.move(rider, "translation", [t for t, _, _ in keys], values, "CUBICSPLINE")
    glb.move(turntable, "rotation", (0, 1, 2), [v.turn((0, 1, 0), angle) for angle in (0, 60, 120)])


def _jelly(glb):
    """Breathes: it sinks, and grows petals, by turns."""
    stone = glb.material("grey stone", (0.40, 0.40, 0.38))
    plinth = bevelled_box((-0.42, 0, -0.42), (0.42, 0.62, 0.42), 0.03)
    at = (-2.45, 0.62, 1.75)
    glb.node("jelly's plinth", glb.solid("jelly's plinth", plinth, stone), (at[0], 0, at[2]))
    rest = sphere(1.0, 6).scaled(0.34, 0.42, 0.34).moved((0, 0.42, 0))

    def petals(p):
        grow = 1 + 0.32 * math.sin(5 * math.atan2(p[2], p[0])) * math.sin(math.pi * min(1.0, p[1] / 0.84))
        return (p[0] * grow, p[1], p[2] * grow)

    shapes = (rest.scaled(1.3, 0.55, 1.3), rest.map(petals))
    jelly = glb.material("violet jelly", (0.32, 0.07, 0.42), roughness=0.2)
    node = glb.node("jelly", glb.morphing("jelly", rest, shapes, jelly), at)
    weights = ((0, 0), (1, 0), (0.2, 1), (0, 0.6), (0, 0))
    glb.move(node, "weights", [0.5 * i for i in range(5)], weights)


def _clock(glb):
    """Its hand jumps eight times in two seconds."""
    at = (3.0, 2.0, -3.98)
    face = lathe([(0.0, 0.0), (0.5, 0.0), (0.5, 0.05), (0.44, 0.03), (0.0, 0.03)], 36).turned((1, 0, 0), 90)
    glb.node("clock", glb.solid("clock", face, glb.material("clock face", (0.80, 0.80, 0.76))), at)
    hand = bevelled_box((-0.025, -0.08, 0.04), (0.025, 0.38, 0.065), 0.008)
    steel = glb.material("black steel", (0.03, 0.03, 0.03))
    node = glb.node("clock's hand", glb.solid("clock's hand", hand, steel), at)
    ticks = range(9)
    glb.move(node, "rotation", [0.25 * i for i in ticks], [v.turn((0, 0, 1), -45 * i) for i in ticks], "STEP")


def _lamps(glb):
    bulb = glb.material("glowing bulb", (1, 1, 1), emission=(1, 0.88, 0.68), strength=3.0)
    steel = glb.material("grey steel", (0.20, 0.20, 0.22), 1.0, 0.4)
    at = (1.5, 3.55, 2.9)
    glb.node("bulb", glb.solid("bulb", sphere(0.1, 3), bulb, normal=v.unit), v.add(at, (0, 0.16, 0)))
    cord = lathe([(0.0, 0.0), (0.012, 0.0), (0.012, 0.7), (0.0, 0.7)], 8)
    glb.node("cord", glb.solid("cord", cord, steel), v.add(at, (0, 0.24, 0)))
    glb.light("hanging lamp", "point", 30.0, (1.0, 0.88, 0.72), at)
    glb.light("fill from the left", "point", 11.0, (0.86, 0.92, 1.0), (-3.9, 2.6, 4.3))
    glb.draw("rail", box((-3.6, 4.28, 3.16), (3.6, 4.34, 3.24)), steel)
    target, places = (0, 0.8, 0), [(-3.0 + 1.5 * i, 4.0, 3.2) for i in range(5)]
    way = v.sub(target, places[0])
    spot = glb.light("travelling spot", "spot", 190.0, (0.80, 0.90, 1.0), places[0], way, (17, 24))
    can = lathe([(0.0, 0.02), (0.12, 0.02), (0.12, 0.10), (0.06, 0.28), (0.0, 0.28)], 16).turned((1, 0, 0), 90)
    glb.node("lamp can", glb.solid("lamp can", can, steel), parent=spot)
    times = [SECONDS * i / 4 for i in range(5)]
    glb.move(spot, "translation", times, places)
    glb.move(spot, "rotation", times, [look(place, target) for place in places])


def _flight(t):
    """Where the flying camera is, t from 0 to 1: a quarter round the carousel, and up."""
    angle = math.radians(-42 + 84 * t)
    return (4.6 * math.sin(angle), 1.3 + 1.5 * t * t, 4.6 * math.cos(angle))


def _cameras(glb):
    glb.camera("still", (0.5, 1.75, 5.2), (0.1, 1.35, -0.3), 52)
    target, steps, near = (0, 1.2, 0), 4, 1e-4
    flying = glb.camera("flying", _flight(0), target, 48)
    values = []
    for i in range(steps + 1):
        t = i / steps
        speed = v.scale(v.sub(_flight(t + near), _flight(t - near)), 1 / (2 * near * SECONDS))
        values += [speed, _flight(t), speed]
    glb.move(flying, "translation", [SECONDS * i / steps for i in range(steps + 1)], values, "CUBICSPLINE")
    times = [SECONDS * i / 8 for i in range(9)]
    glb.move(flying, "rotation", times, [look(_flight(t / SECONDS), target) for t in times])


def make():
    glb = Glb("carousel")
    _hall(glb)
    _carousel(glb)
    _jelly(glb)
    _clock(glb)
    _lamps(glb)
    mirror = glb.material("mirror", (0.95, 0.95, 0.96), 1.0, 0.0)
    at = (2.75, 1.12, 1.75)
    glb.node("mirror ball", glb.solid("mirror ball", sphere(0.62, 10), mirror, normal=v.unit), at)
    stand = lathe([(0.0, 0.0), (0.34, 0.0), (0.34, 0.08), (0.10, 0.16), (0.08, 0.44), (0.24, 0.58), (0.0, 0.58)], 24)
    oak = glb.material("oak", (0.42, 0.24, 0.11))
    glb.node("ball's stand", glb.solid("ball's stand", stand, oak), (at[0], 0, at[2]))
    _cameras(glb)
    return glb
