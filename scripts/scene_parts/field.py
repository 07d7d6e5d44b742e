"""Rolling meadow with trees, a stone circle, bushes and mushrooms: few meshes, many nodes, a sun and a pond."""

import math
import random

from scene_parts import vector as v
from scene_parts.glb import Glb, shaded
from scene_parts.solid import Solid, box, circle, curve, lathe, skin, sphere, sweep

HALF, CELLS, POND, POND_LEVEL = 75.0, 120, (-9.0, -16.0), -1.35


def height(x, z):
    """Of the ground, metres."""
    rolling = 2.6 * v.noise(x / 34 + 0.3, 0.5, z / 34 + 0.7) + 0.7 * v.noise(x / 11, 3.5, z / 11)
    far = max(0.0, math.hypot(x, z + 10) - 38)
    bowl = 2.4 * math.exp(-((math.hypot((x - POND[0]) / 1.3, z - POND[1]) / 7.5) ** 2))
    return rolling + 0.0035 * far * far - bowl


def _ground():
    """The meadow as a closed slab, denser near the camera."""

    def spread(t):
        return HALF * (0.35 * t + 0.65 * t * abs(t))

    lines = [spread(2 * i / CELLS - 1) for i in range(CELLS + 1)]
    rows = [[(x, height(x, z - 10), z - 10) for x in lines] for z in lines]
    solid = Solid([p for row in rows for p in row])
    side = CELLS + 1
    for j in range(CELLS):
        for i in range(CELLS):
            a = j * side + i
            solid.faces.append((a, a + side, a + side + 1, a + 1))
    rim = [i for i in range(side)] + [j * side + CELLS for j in range(1, side)]
    rim += [CELLS * side + i for i in range(CELLS - 1, -1, -1)] + [j * side for j in range(CELLS - 1, 0, -1)]
    bottom = len(solid.points)
    solid.points += [(solid.points[i][0], -12.0, solid.points[i][2]) for i in rim]
    for k, i in enumerate(rim):
        m = (k + 1) % len(rim)
        solid.faces.append((i, rim[m], bottom + m, bottom + k))
    middle = len(solid.points)
    solid.points.append((0.0, -12.0, -10.0))
    solid.faces += [(middle, bottom + k, bottom + (k + 1) % len(rim)) for k in range(len(rim))]
    return solid


def _ground_color(p):
    patch = v.fractal_noise(p[0] / 7, 0.5, p[2] / 7, 3)
    fine = v.noise(p[0] * 1.3, 7.5, p[2] * 1.3)
    dry = min(1.0, max(0.0, 0.45 + 0.9 * patch + 0.25 * fine))
    grass = tuple(a + dry * (b - a) for a, b in zip((0.10, 0.20, 0.045), (0.30, 0.29, 0.10)))
    wet = min(1.0, max(0.0, (POND_LEVEL + 0.35 - p[1]) / 0.3))
    return tuple(a + wet * (b - a) for a, b in zip(grass, (0.16, 0.11, 0.06)))


def _crown(radius, frequency, seed, rough):
    def move(p):
        n = v.unit(p)
        return v.scale(n, radius * (1 + rough * v.fractal_noise(2.1 * n[0] + seed, 2.1 * n[1], 2.1 * n[2], 3)))

    return sphere(radius, frequency).map(move)


def _broadleaf():
    trunk = sweep(
        curve([(0, -0.3, 0), (0.03, 0.6, 0.02), (0.10, 1.5, -0.04), (0.06, 2.6, 0.05)], 3), lambda t: 0.21 - 0.13 * t, 9
    )
    for x, y, z in ((0.95, 2.75, 0.25), (-0.75, 2.9, 0.4), (0.05, 2.9, -0.85)):
        trunk.join(sweep(curve([(0.08, 1.45, 0), (0.5 * x, 2.1, 0.5 * z), (x, y, z)], 2), lambda t: 0.09 - 0.05 * t, 6))
    crown = Solid()
    for number, (x, y, z, radius) in enumerate(
        ((0, 3.5, 0, 1.15), (0.95, 2.95, 0.25, 0.82), (-0.8, 3.05, 0.4, 0.85), (0.05, 3.0, -0.9, 0.8))
    ):
        crown.join(_crown(radius, 4, 11.3 * number, 0.32).scaled(1, 0.85, 1).moved((x, y, z)))
    return trunk, crown


def _conifer():
    trunk = lathe([(0.0, -0.3), (0.17, -0.3), (0.10, 1.2), (0.0, 1.3)], 8)
    crown = Solid()
    for tier in range(7):
        radius, low = 1.25 * (1 - tier / 7.6), 0.7 + 0.62 * tier

        def ragged(angle, turned=tier):
            return 1 + 0.16 * math.cos(9 * angle + turned) + 0.06 * math.sin(5 * angle + 2 * turned)

        rings = [
            circle(r, y, 24, ragged if r > 0.6 * radius else None)
            for r, y in (
                (0, low + 0.22),
                (radius, low),
                (0.93 * radius, low + 0.1),
                (0.5 * radius, low + 0.5),
                (0, low + 1.15),
            )
        ]
        crown.join(skin(rings))
    return trunk, crown


def _stone():
    def move(p):
        x, y, z = p
        power = 4.0
        size = (abs(x) ** power + abs(y) ** power + abs(z) ** power) ** (-1 / power)
        n = (x * size, y * size, z * size)
        swell = 1 + 0.16 * v.fractal_noise(1.3 * n[0] + 4, 1.3 * n[1], 1.3 * n[2], 3)
        return (
            0.52 * n[0] * swell * (1 - 0.16 * n[1]),
            1.25 * n[1] * swell + 1.0,
            0.30 * n[2] * swell * (1 - 0.1 * n[1]),
        )

    return sphere(1.0, 6).map(move)


def _mushroom():
    stem = lathe([(0.0, -0.05), (0.055, -0.05), (0.045, 0.05), (0.035, 0.16), (0.0, 0.17)], 14)
    cap = lathe(
        [
            (0.0, 0.150),
            (0.035, 0.148),
            (0.13, 0.125),
            *curve([(0.150, 0.128), (0.135, 0.19), (0.08, 0.245), (0.03, 0.262)], 3),
            (0.0, 0.265),
        ],
        22,
    )
    spots = Solid()
    for number, (tilt, around) in enumerate(
        ((0, 0), (30, 20), (33, 100), (28, 190), (34, 285), (55, 60), (57, 150), (54, 240), (58, 330))
    ):
        spot = lathe([(0.0, -0.01), (0.016, -0.01), (0.016, 0.003), (0.0, 0.008)], 7)
        drop = 0.255 if tilt == 0 else 0.243 if tilt < 40 else 0.2
        reach = 0.0 if tilt == 0 else 0.082 if tilt < 40 else 0.125
        spots.join(spot.turned((0, 0, 1), -tilt).moved((reach, drop + 0.006, 0)).turned((0, 1, 0), around))
    return stem.join(spots), cap


def _plant(glb, rng, name, mesh, spots, size, sink=0.0, tilt=0.0):
    for number, (x, z) in enumerate(spots):
        turn = v.turn((0, 1, 0), 360 * rng.random())
        if tilt:
            turn = (
                v.turn((rng.random() - 0.5, 0, rng.random() - 0.5), tilt * (rng.random() - 0.5)) if number % 2 else turn
            )
        s = size[0] + (size[1] - size[0]) * rng.random()
        glb.node(
            f"{name} {number + 1}",
            mesh if isinstance(mesh, int) else mesh[number % len(mesh)],
            (x, height(x, z) - sink, z),
            turn,
            s,
        )


def _scatter(rng, count, near, far, apart, keep):
    """Spots in front of the camera between two distances, not closer to each other than `apart`."""
    spots, tries = [], 0
    while len(spots) < count and tries < 200000:
        tries += 1
        angle = (rng.random() - 0.5) * math.radians(84)
        distance = near + (far - near) * rng.random() ** 0.75
        x, z = distance * math.sin(angle), 8 - distance * math.cos(angle)
        on_land = height(x, z) > POND_LEVEL + 0.15
        if on_land and keep(x, z) and all((x - a) ** 2 + (z - b) ** 2 >= apart * apart for a, b in spots):
            spots.append((x, z))
    return spots


def make():
    glb = Glb("field")
    rng = random.Random(2007)
    ground = _ground()
    ground.check_closed("ground")
    meadow = glb.material("meadow", (1, 1, 1))
    glb.node("ground", glb.mesh("ground", glb.primitive(shaded(ground, 60, color=_ground_color), meadow)))
    water = glb.material("pond water", (0.02, 0.045, 0.045), 0.0, 0.0)
    x, z = POND
    glb.draw("pond", box((x - 13, POND_LEVEL - 0.5, z - 10), (x + 13, POND_LEVEL, z + 10)), water)

    bark = glb.material("bark", (0.13, 0.085, 0.05))
    trunk, crown = (shaded(s, c) for s, c in zip(_broadleaf(), (50, 75)))
    trunk, crown = glb.primitive(trunk, bark), glb.primitive(crown, 0)
    greens = [
        glb.material(name, color)
        for name, color in (
            ("summer leaves", (0.09, 0.21, 0.035)),
            ("spring leaves", (0.19, 0.28, 0.045)),
            ("autumn leaves", (0.42, 0.19, 0.03)),
        )
    ]
    broadleaf = [glb.mesh(f"tree with {glb.materials[m]['name']}", trunk, {**crown, "material": m}) for m in greens]
    trunk, crown = (shaded(s, c) for s, c in zip(_conifer(), (50, 50)))
    needles = glb.material("needles", (0.035, 0.105, 0.055))
    conifer = glb.mesh("conifer", glb.primitive(trunk, bark), glb.primitive(crown, needles))
    stone = glb.solid("stone", _stone(), glb.material("lichened stone", (0.36, 0.35, 0.32)), 40)
    bush_leaves = glb.material("bush leaves", (0.075, 0.15, 0.05))
    bush = glb.solid("bush", _crown(0.5, 4, 3.1, 0.5).scaled(1.2, 0.8, 1.1).moved((0, 0.2, 0)), bush_leaves, 75)
    stem, cap = _mushroom()
    red = glb.material("red cap", (0.62, 0.035, 0.02), roughness=0.35)
    pale = glb.material("pale stem", (0.75, 0.70, 0.60))
    mushroom = glb.mesh("mushroom", glb.primitive(shaded(stem, 45), pale), glb.primitive(shaded(cap, 50), red))

    circle_x, circle_z, ring = 6.5, -15.0, 6.0
    stones = [
        (circle_x + ring * math.cos(a), circle_z + ring * math.sin(a))
        for a in (2 * math.pi * (i + 0.2) / 13 for i in range(13))
    ]
    _plant(glb, rng, "standing stone", stone, stones, (0.95, 1.25), 0.15, 9)
    boulders = _scatter(rng, 60, 6, 70, 2.5, lambda px, pz: math.hypot(px - circle_x, pz - circle_z) > 8)
    _plant(glb, rng, "boulder", stone, boulders, (0.15, 0.42), 0.12, 160)

    def wood(px, pz):
        return v.noise(px / 16 + 5.5, 0.5, pz / 16) > 0.02 and math.hypot(px - circle_x, pz - circle_z) > 10

    woods = _scatter(rng, 210, 22, 92, 2.5, lambda px, pz: wood(px, pz) and px + pz * 0.3 < 12)
    _plant(glb, rng, "tree", broadleaf, woods, (0.8, 1.45), 0.05)
    pines = _scatter(
        rng, 260, 26, 92, 2.2, lambda px, pz: (wood(px, pz) or math.hypot(px, pz) > 62) and px - pz * 0.2 > -2
    )
    _plant(glb, rng, "pine", conifer, pines, (0.9, 1.7), 0.1)
    _plant(glb, rng, "lone tree", broadleaf[0], [(-6.5, -3.5)], (1.25, 1.3), 0.05)
    bushes = _scatter(
        rng,
        280,
        9,
        80,
        1.6,
        lambda px, pz: v.noise(px / 9, 9.5, pz / 9) > 0.08 and math.hypot(px - circle_x, pz - circle_z) > 5,
    )
    _plant(glb, rng, "bush", bush, bushes, (0.6, 1.5), 0.05)
    caps = _scatter(rng, 210, 2.2, 24, 0.35, lambda px, pz: v.noise(px / 2.2 + 9.5, 0.5, pz / 2.2) > 0.2)
    _plant(glb, rng, "mushroom", mushroom, caps, (0.5, 1.35), 0.01, 24)

    glb.light("sun", "directional", 3.0, (1.0, 0.90, 0.74), direction=(0.72, -0.52, -0.46))
    glb.light("sky from behind", "directional", 0.7, (0.70, 0.83, 1.0), direction=(-0.30, -0.75, -0.58))
    glb.camera("main", (0.3, height(0.3, 8) + 1.65, 8.0), (0.2, 0.45, -14.0), 46, zfar=400.0)
    glb.camera("hill", (-22, 13.5, 14), (2, -1, -18), 44, zfar=400.0)
    return glb
