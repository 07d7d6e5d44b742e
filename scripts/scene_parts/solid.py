"""Solids: points and flat polygons, counter-clockwise seen from outside, and the shapes the scenes are made of."""

import math

from scene_parts import vector as v


class Solid:
    def __init__(self, points=(), faces=()):
        self.points, self.faces = list(points), list(faces)

    def join(self, *others):
        for other in others:
            first = len(self.points)
            self.points += other.points
            self.faces += [tuple(first + i for i in face) for face in other.faces]
        return self

    def map(self, move):
        """Each point moved; a move that mirrors turns the faces inside out."""
        return Solid([move(p) for p in self.points], self.faces)

    def moved(self, offset):
        return self.map(lambda p: v.add(p, offset))

    def turned(self, axis, degrees):
        q = v.turn(axis, degrees)
        return self.map(lambda p: v.rotate(q, p))

    def scaled(self, x, y, z):
        return self.map(lambda p: (p[0] * x, p[1] * y, p[2] * z))

    def check_closed(self, name):
        """Fails unless each edge has exactly one twin and the volume is positive (faces look outward)."""
        edges = {}
        for face in self.faces:
            for a, b in zip(face, face[1:] + face[:1]):
                edges[a, b] = edges.get((a, b), 0) + 1
        for (a, b), count in edges.items():
            if edges.get((b, a)) != count or count != 1:
                raise ValueError(f"{name}: edge {self.points[a]} {self.points[b]} is open or shared by too many faces")
        volume = 0.0
        for face in self.faces:
            a = self.points[face[0]]
            for i in range(1, len(face) - 1):
                volume += v.dot(a, v.cross(self.points[face[i]], self.points[face[i + 1]]))
        if volume <= 0:
            raise ValueError(f"{name}: inside out")


def skin(rings, loop=False):
    """Surface through rings of points, which run counter-clockwise seen from the last ring. A ring of one point is a
    pole; an end ring of more is closed by a fan around its middle; a loop joins the last ring to the first."""
    solid, index = Solid(), []
    for ring in rings:
        index.append(range(len(solid.points), len(solid.points) + len(ring)))
        solid.points += ring
    for low, high in list(zip(index, index[1:])) + ([(index[-1], index[0])] if loop else []):
        for i in range(max(len(low), len(high))):
            a, b = low[i % len(low)], low[(i + 1) % len(low)]
            c, d = high[(i + 1) % len(high)], high[i % len(high)]
            solid.faces.append((a, b, c) if c == d else (a, c, d) if a == b else (a, b, c, d))
    for ring, outward in ((index[0], False), (index[-1], True)):
        if loop or len(ring) == 1:
            continue
        middle = len(solid.points)
        corners = [solid.points[i] for i in ring]
        solid.points.append(tuple(sum(p[k] for p in corners) / len(corners) for k in range(3)))
        for a, b in zip(ring, [*ring[1:], ring[0]]):
            solid.faces.append((middle, a, b) if outward else (middle, b, a))
    return solid


def circle(radius, y, segments, shape=None):
    """Ring about +Y; `shape(angle)` scales the radius."""
    if radius == 0:
        return [(0.0, y, 0.0)]
    ring = []
    for i in range(segments):
        angle = -2 * math.pi * i / segments
        r = radius * (shape(angle) if shape else 1)
        ring.append((r * math.cos(angle), y, r * math.sin(angle)))
    return ring


def lathe(profile, segments, loop=False):
    """Turned about +Y; profile (radius, y) from bottom to top, a loop counter-clockwise with radius to the right."""
    return skin([circle(r, y, segments) for r, y in profile], loop)


def arc(center, radius, start_degrees, end_degrees, steps):
    """Points of a 2D arc, ends included."""
    points = []
    for i in range(steps + 1):
        a = math.radians(start_degrees + (end_degrees - start_degrees) * i / steps)
        points.append((center[0] + radius * math.cos(a), center[1] + radius * math.sin(a)))
    return points


def curve(points, steps):
    """Catmull-Rom curve through points of any dimension, `steps` pieces a span."""
    padded = [points[0], *points, points[-1]]
    out = []
    for a, b, c, d in zip(padded, padded[1:], padded[2:], padded[3:]):
        for i in range(steps):
            t = i / steps
            out.append(
                tuple(
                    0.5 * (2 * q + (r - p) * t + (2 * p - 5 * q + 4 * r - s) * t * t + (3 * q - p - 3 * r + s) * t**3)
                    for p, q, r, s in zip(a, b, c, d)
                )
            )
    return out + [tuple(points[-1])]


def sweep(path, radius, segments, loop=False):
    """Tube along a path; `radius` is a number or a function of the position 0..1 along it. Frames are carried along
    without twist, what remains at the end of a loop is spread over it."""
    count = len(path)
    tangents = []
    for i in range(count):
        before, after = (
            (path[i - 1], path[(i + 1) % count]) if loop else (path[max(i - 1, 0)], path[min(i + 1, count - 1)])
        )
        tangents.append(v.unit(v.sub(after, before)))
    helper = (0, 1, 0) if abs(tangents[0][1]) < 0.9 else (1, 0, 0)
    side = v.unit(v.cross(helper, tangents[0]))
    sides = []
    for t in tangents + ([tangents[0]] if loop else []):
        side = v.unit(v.sub(side, v.scale(t, v.dot(side, t))))
        sides.append(side)
    twist = 0.0
    if loop:
        twist = math.atan2(v.dot(v.cross(sides[-1], sides[0]), tangents[0]), v.dot(sides[-1], sides[0]))
    rings = []
    for i in range(count):
        other = v.cross(tangents[i], sides[i])
        r = radius(i / (count if loop else count - 1)) if callable(radius) else radius
        ring = []
        for k in range(segments):
            angle = 2 * math.pi * k / segments + twist * i / count
            ring.append(
                v.add(path[i], v.add(v.scale(sides[i], r * math.cos(angle)), v.scale(other, r * math.sin(angle))))
            )
        rings.append(ring)
    return skin(rings, loop)


def box(low, high):
    x, y, z = zip(low, high)
    points = [(x[i & 1], y[i >> 1 & 1], z[i >> 2]) for i in range(8)]
    return Solid(points, [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)])


def bevelled_box(low, high, bevel):
    """Box with its 12 edges cut at 45 degrees."""
    middle = v.scale(v.add(low, high), 0.5)
    half = v.scale(v.sub(high, low), 0.5)
    points, index = [], {}
    for corner in range(8):
        sign = [1 if corner >> k & 1 else -1 for k in range(3)]
        for axis in range(3):
            index[corner, axis] = len(points)
            points.append(tuple(middle[k] + sign[k] * (half[k] - (0 if k == axis else bevel)) for k in range(3)))
    faces = [tuple(index[corner, k] for k in range(3)) for corner in range(8)]
    for axis in range(3):
        a, b = 1 << (axis + 1) % 3, 1 << (axis + 2) % 3
        for side in (0, 1 << axis):
            faces.append(tuple(index[c, axis] for c in (side, side | a, side | a | b, side | b)))
        for p in (0, a, b, a | b):
            q, i, j = p | 1 << axis, (axis + 1) % 3, (axis + 2) % 3
            faces.append((index[p, i], index[q, i], index[q, j], index[p, j]))
    for number, face in enumerate(faces):
        p, q, r = (points[i] for i in face[:3])
        if v.dot(v.cross(v.sub(q, p), v.sub(r, p)), v.sub(p, middle)) < 0:
            faces[number] = face[::-1]
    return Solid(points, faces)


def _ears(polygon):
    """Triangles of a simple counter-clockwise polygon, by ear clipping."""

    def area(a, b, c):
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])

    left, triangles = list(range(len(polygon))), []
    while len(left) > 3:
        best = None
        for k in range(len(left)):
            i, j, m = left[k - 1], left[k], left[(k + 1) % len(left)]
            a, b, c = polygon[i], polygon[j], polygon[m]
            if area(a, b, c) <= 1e-12:
                continue
            inside = any(
                area(a, b, polygon[p]) >= 0 and area(b, c, polygon[p]) >= 0 and area(c, a, polygon[p]) >= 0
                for p in left
                if p not in (i, j, m)
            )
            length = math.dist(a, c)
            if not inside and (best is None or length < best[0]):
                best = (length, k, (i, j, m))
        triangles.append(best[2])
        del left[best[1]]
    return triangles + [tuple(left)]


def extrude(polygon, depth):
    """A counter-clockwise polygon in (x, y), pulled out to z = -depth / 2 .. depth / 2."""
    count = len(polygon)
    points = [(x, y, z) for z in (depth / 2, -depth / 2) for x, y in polygon]
    front = _ears(polygon)
    faces = front + [tuple(count + i for i in reversed(face)) for face in front]
    for i in range(count):
        j = (i + 1) % count
        faces.append((i, i + count, j + count, j))
    return Solid(points, faces)


def sphere(radius, frequency):
    """Icosahedron whose faces are split into frequency^2 triangles, on the sphere: 20 frequency^2 triangles."""
    g = (1 + math.sqrt(5)) / 2
    corners = [
        (-1, g, 0),
        (1, g, 0),
        (-1, -g, 0),
        (1, -g, 0),
        (0, -1, g),
        (0, 1, g),
        (0, -1, -g),
        (0, 1, -g),
        (g, 0, -1),
        (g, 0, 1),
        (-g, 0, -1),
        (-g, 0, 1),
    ]
    triangles = [
        (0, 11, 5),
        (0, 5, 1),
        (0, 1, 7),
        (0, 7, 10),
        (0, 10, 11),
        (1, 5, 9),
        (5, 11, 4),
        (11, 10, 2),
        (10, 7, 6),
        (7, 1, 8),
        (3, 9, 4),
        (3, 4, 2),
        (3, 2, 6),
        (3, 6, 8),
        (3, 8, 9),
        (4, 9, 5),
        (2, 4, 11),
        (6, 2, 10),
        (8, 6, 7),
        (9, 8, 1),
    ]
    solid, known = Solid(), {}

    def point(weights):
        key = tuple(sorted((corner, weight) for corner, weight in weights if weight))
        if key not in known:
            p = (0, 0, 0)
            for corner, weight in key:
                p = v.add(p, v.scale(corners[corner], weight))
            known[key] = len(solid.points)
            solid.points.append(v.scale(v.unit(p), radius))
        return known[key]

    n = frequency
    for a, b, c in triangles:
        grid = {(i, j): point(((a, n - i - j), (b, i), (c, j))) for i in range(n + 1) for j in range(n + 1 - i)}
        for i in range(n):
            for j in range(n - i):
                solid.faces.append((grid[i, j], grid[i + 1, j], grid[i, j + 1]))
                if i + j < n - 1:
                    solid.faces.append((grid[i + 1, j], grid[i + 1, j + 1], grid[i, j + 1]))
    return solid
