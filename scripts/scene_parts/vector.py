"""Small vectors as tuples, rotations as unit quaternions (x, y, z, w) and hash-based gradient noise."""

import math


def add(a, b):
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def scale(a, s):
    return (a[0] * s, a[1] * s, a[2] * s)


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    length = math.sqrt(dot(a, a))
    return (a[0] / length, a[1] / length, a[2] / length)


def turn(axis, degrees):
    """Quaternion of a turn about an axis."""
    half = math.radians(degrees) / 2
    x, y, z = scale(unit(axis), math.sin(half))
    return (x, y, z, math.cos(half))


def rotate(q, v):
    u = q[:3]
    t = scale(cross(u, v), 2)
    return add(add(v, scale(t, q[3])), cross(u, t))


def quaternion_from_axes(x, y, z):
    """Rotation whose matrix has these orthonormal columns."""
    candidates = (1 + x[0] - y[1] - z[2], 1 - x[0] + y[1] - z[2], 1 - x[0] - y[1] + z[2], 1 + x[0] + y[1] + z[2])
    largest = candidates.index(max(candidates))
    s = 2 * math.sqrt(candidates[largest])
    xy, xz, yz = (y[0] + x[1]) / s, (z[0] + x[2]) / s, (z[1] + y[2]) / s
    wx, wy, wz = (y[2] - z[1]) / s, (z[0] - x[2]) / s, (x[1] - y[0]) / s
    return ((s / 4, xy, xz, wx), (xy, s / 4, yz, wy), (xz, yz, s / 4, wz), (wx, wy, wz, s / 4))[largest]


def look_along(direction, up=(0, 1, 0)):
    """Rotation that turns -Z to a direction, as cameras and lights need it."""
    z = scale(unit(direction), -1)
    if abs(dot(z, up)) > 0.9999:
        up = (0, 0, -1)
    x = unit(cross(up, z))
    return quaternion_from_axes(x, cross(z, x), z)


_GRADIENTS = (
    (1, 1, 0),
    (-1, 1, 0),
    (1, -1, 0),
    (-1, -1, 0),
    (1, 0, 1),
    (-1, 0, 1),
    (1, 0, -1),
    (-1, 0, -1),
    (0, 1, 1),
    (0, -1, 1),
    (0, 1, -1),
    (0, -1, -1),
    (1, 1, 0),
    (0, -1, 1),
    (-1, 1, 0),
    (0, -1, -1),
)


def _shuffled_table():
    table, state = list(range(256)), 2007
    for i in range(255, 0, -1):
        state = (state * 1664525 + 1013904223) & 0xFFFFFFFF
        j = (state >> 8) % (i + 1)
        table[i], table[j] = table[j], table[i]
    return table + table + table[:2]


_TABLE = _shuffled_table()
_LATTICE = [_GRADIENTS[h & 15] for h in _TABLE]


def noise(x, y, z):
    """Gradient noise, about -0.8 to 0.8, cells of side 1. From Perlin, "Improving Noise", 2002."""
    xf, yf, zf = math.floor(x), math.floor(y), math.floor(z)
    x -= xf
    y -= yf
    z -= zf
    table, lattice = _TABLE, _LATTICE
    zi = zf & 255
    a = table[xf & 255] + (yf & 255)
    b = table[(xf & 255) + 1] + (yf & 255)
    aa, ab, ba, bb = table[a] + zi, table[a + 1] + zi, table[b] + zi, table[b + 1] + zi
    u = x * x * x * (x * (x * 6 - 15) + 10)
    v = y * y * y * (y * (y * 6 - 15) + 10)
    w = z * z * z * (z * (z * 6 - 15) + 10)
    x1, y1, z1 = x - 1, y - 1, z - 1
    g, h = lattice[aa], lattice[ba]
    p = g[0] * x + g[1] * y + g[2] * z
    n00 = p + u * (h[0] * x1 + h[1] * y + h[2] * z - p)
    g, h = lattice[ab], lattice[bb]
    p = g[0] * x + g[1] * y1 + g[2] * z
    n10 = p + u * (h[0] * x1 + h[1] * y1 + h[2] * z - p)
    g, h = lattice[aa + 1], lattice[ba + 1]
    p = g[0] * x + g[1] * y + g[2] * z1
    n01 = p + u * (h[0] * x1 + h[1] * y + h[2] * z1 - p)
    g, h = lattice[ab + 1], lattice[bb + 1]
    p = g[0] * x + g[1] * y1 + g[2] * z1
    n11 = p + u * (h[0] * x1 + h[1] * y1 + h[2] * z1 - p)
    n0 = n00 + v * (n10 - n00)
    return n0 + w * (n01 + v * (n11 - n01) - n0)


def fractal_noise(x, y, z, octaves):
    total, weight = 0.0, 1.0
    for _ in range(octaves):
        total += weight * noise(x, y, z)
        x, y, z, weight = 2.03 * x + 17.1, 2.03 * y + 5.7, 2.03 * z + 31.3, weight / 2
    return total
