#!/usr/bin/env python3
"""Makes the meshes of `data/scenes/fountain-in-a-park.toml`, with nothing but Python's own library.

    python3 examples/park.py data/meshes/park.glb

A mown lawn with a path of gravel around a basin of stone, a clipped hedge behind it and old trees behind that. Colors
are plausible, not measured; textures have few shades, which compress.
"""

import math
import sys

from gltf_parts import Meshes, grid, joined, png, scattered
from valley_heights import noise

FOUNTAIN_M = (0.0, -11.0)
LAWN_M = 60.0
MOWN_M = 3.2


def lawn_color(x, y):
    """Stripes of a mower."""
    speck = int(3.0 * noise(1.7 * x, 1.7 * y) + 2.0 * noise(x / 5.0, y / 5.0))
    mown = 8 if x < 64 else 0
    return (74 + mown + 5 * speck, 106 + mown + 5 * speck, 42 + 4 * speck)


def gravel_color(x, y):
    speck = int(3.0 * noise(1.3 * x, 1.3 * y) + 2.0 * noise(x / 3.0, y / 3.0))
    return (178 + 7 * speck, 164 + 7 * speck, 138 + 7 * speck)


def leaves_color(x, y):
    """Leaves in light and shade."""
    shade = int(5.0 * noise(x / 2.3, y / 2.3) + 4.0 * noise(x / 7.0 + 9.0, y / 7.0))
    return (62 + 7 * shade, 88 + 9 * shade, 34 + 5 * shade)


def stone_color(x, y):
    joint = y % 32 < 2 or (x + (16 if y // 32 % 2 else 0)) % 64 < 2
    shade = int(3.0 * noise(x / 3.0, y / 3.0) + 2.0 * noise(x / 17.0, y / 17.0))
    return (120, 112, 100) if joint else (182 + 6 * shade, 174 + 6 * shade, 158 + 6 * shade)


def lawn():
    """A sheet, a little uneven far away."""

    def point(u, v):
        east, south = (u - 0.5) * 2.0 * LAWN_M, (v - 0.5) * 2.0 * LAWN_M
        far = min(max((math.hypot(east, south) - 16.0) / 20.0, 0.0), 1.0)
        return (east, 0.02 + 0.5 * far * (1.0 + noise(east / 14.0, south / 14.0)), south)

    points, normals, _, triangles = grid(48, 48, point)
    places = [((east + 0.35 * south) / MOWN_M, south / MOWN_M) for east, _, south in points]
    return points, normals, places, triangles


def around(radius_m, height_m):
    """Turns a radius and a share of the turn into a point beside the fountain."""
    return lambda u, v: (
        FOUNTAIN_M[0] + radius_m(v) * math.cos(-2.0 * math.pi * u),
        height_m,
        FOUNTAIN_M[1] + radius_m(v) * math.sin(-2.0 * math.pi * u),
    )


def path():
    """Gravel around the basin, and a way to it."""
    ring = grid(96, 1, around(lambda v: 5.4 - 2.8 * v, 0.035))
    way = grid(1, 1, lambda u, v: (3.6 + 1.8 * u, 0.03, -8.0 + 40.0 * v))
    points, normals, _, triangles = joined([ring, way])
    return points, normals, [(east / 1.5, south / 1.5) for east, _, south in points], triangles


def basin():
    """A ring of stone turned on a lathe: outer wall, rounded rim, inner wall."""
    outline = [(2.75, 0.0), (2.7, 0.42), (2.78, 0.46), (2.78, 0.55), (2.35, 0.55), (2.35, 0.46), (2.42, 0.42), (2.42, 0.2)]

    def between(side):
        (r0, y0), (r1, y1) = outline[side], outline[side + 1]

        def point(u, v):
            turn, r = -2.0 * math.pi * u, r1 + v * (r0 - r1)
            return (FOUNTAIN_M[0] + r * math.cos(turn), y1 + v * (y0 - y1), FOUNTAIN_M[1] + r * math.sin(turn))

        points, normals, places, triangles = grid(64, 1, point)
        return points, normals, [(8.0 * u, 0.25 * v) for u, v in places], triangles

    return joined(between(side) for side in range(len(outline) - 1))


def water():
    """The dark water in the basin."""
    return grid(48, 2, around(lambda v: 2.42 * (1.0 - v), 0.34))


def crown(center, radii, seed):
    """A crown of leaves: a sphere with bulges, as branches have them."""

    def point(u, v):
        turn, down = 2.0 * math.pi * u, math.pi * v
        n = (math.sin(down) * math.sin(turn), math.cos(down), math.sin(down) * math.cos(turn))
        a, b = 3.1 * n[0] + 1.7 * n[1] + seed, 3.1 * n[2] - 1.3 * n[1] - seed
        bulge = 1.0 + 0.22 * noise(a, b) + 0.10 * noise(2.6 * a + 5.0, 2.6 * b) + 0.03 * noise(6.0 * a, 6.0 * b + 3.0)
        return tuple(center[k] + radii[k] * bulge * n[k] for k in range(3))

    points, normals, places, triangles = grid(40, 26, point)
    return points, normals, [(3.0 * u, 2.0 * v) for u, v in places], triangles


def trunk(x, z, height, r):
    def point(u, v):
        turn = -2.0 * math.pi * u
        wide = r * (1.0 + 0.6 * v**6)
        return (x + wide * math.cos(turn), height * (1.0 - v), z + wide * math.sin(turn))

    return grid(10, 4, point)


def hedge():
    """Clipped, and uneven by a hand's breadth."""

    def face(z_m, top):
        def point(u, v):
            x = (u - 0.5) * 70.0
            bump = 0.07 * noise(2.1 * x, 7.0 * v) + 0.04 * noise(5.3 * x, 15.0 * v)
            if top:
                return (x, 2.1 + bump, z_m - 1.2 + 1.2 * v)
            return (x, 2.1 * (1.0 - v), z_m + bump)

        points, normals, places, triangles = grid(120, 8, point)
        return points, normals, [(24.0 * u, 0.8 * v) for u, v in places], triangles

    return joined([face(-24.0, False), face(-24.0, True)])


def main(file):
    meshes = Meshes()
    meshes.part(meshes.painted(png(128, 128, lawn_color)), lawn())
    meshes.part(meshes.painted(png(64, 64, gravel_color)), path())
    meshes.part(meshes.painted(png(128, 128, stone_color)), basin())
    meshes.part(meshes.plain(0.03, 0.05, 0.05), water())
    leaves = meshes.painted(png(128, 128, leaves_color))
    meshes.part(leaves, hedge())
    draw, trunks = scattered(4), []
    for index in range(11):
        x, z = -44.0 + 8.6 * index + draw.uniform(-2.0, 2.0), draw.uniform(-46.0, -31.0)
        r, height = draw.uniform(3.4, 5.2), draw.uniform(2.6, 3.8)
        tall = r * draw.uniform(1.0, 1.4)
        meshes.part(leaves, crown((x, height + 0.8 * tall, z), (r, tall, r), 7.3 * index))
        trunks.append(trunk(x, z, height + 0.4 * tall, draw.uniform(0.25, 0.4)))
    meshes.part(meshes.plain(0.09, 0.07, 0.05), joined(trunks))
    meshes.write(file)


if __name__ == "__main__":
    main(sys.argv[1])
