"""Texture images and texture coordinates that several scenes use."""

from scene_parts import vector as v
from scene_parts.glb import png


def checker(light, dark, grain=10):
    """Checker of 2 x 2 fields with a little grain; sRGB bytes."""
    size = 64

    def pixel(x, y):
        color = light if (x * 2 // size + y * 2 // size) % 2 == 0 else dark
        shift = grain * v.fractal_noise(x / 9 + 0.13, y / 9 + 0.37, 0.5, 3)
        return [min(255, max(0, round(c + shift))) for c in color]

    return png(size, size, pixel)


def marble():
    """White with grey veins, to multiply a stone's colour; sRGB bytes."""
    size = 128

    def pixel(x, y):
        u, w = x / 28, y / 28
        vein = abs(v.fractal_noise(u + 0.8 * v.noise(u, w, 3.5), w + 0.8 * v.noise(u, w, 9.5), 0.3, 4))
        shade = 255 - round(60 * max(0.0, 1 - vein / 0.16) ** 2)
        return (shade, shade, shade)

    return png(size, size, pixel)


def floor_uv(metres):
    """Coordinates on a horizontal plane, one turn of the texture in so many metres."""
    return lambda p, n: (p[0] / metres, p[2] / metres)
