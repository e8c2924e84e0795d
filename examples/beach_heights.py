#!/usr/bin/env python3
"""Makes the heights of `data/scenes/beach-spray.toml`: a PNG of 16 bits of gray, with nothing but Python's own library.

    python3 examples/beach_heights.py data/heights/beach.png

Sand that falls to the sea in the north with low dunes in the south, a headland of rock in the west that ends in stacks,
and a lower one far in the east. The water stands at 5 m. Black is 0 m and white 50 m.
"""

import sys

from gorge_heights import rough, step
from valley_heights import noise, write

WIDTH, DEPTH = 281, 321
SPACING_M = 2.0
WHITE_M = 50.0
STEP = 65


def height_m(x, z):
    """Height at a place east of the eye and south of it."""
    shore = -14.0 + 5.0 * noise(x / 60.0, 3.0)
    sand = 5.0 + 0.055 * (z - shore) + 0.10 * noise(x / 9.0, z / 5.0)
    dunes = 3.0 * step((z - 25.0) / 30.0) * (1.0 + rough(x, z, 40.0))
    # Rock where the coast stands out; stacks are left before it.
    west = step((-52.0 - x - 0.10 * z + 16.0 * rough(x, z, 70.0)) / 12.0) * step((z + 190.0 + 25.0 * noise(x / 20.0, 1.0)) / 30.0)
    east = step((x - 150.0 + 20.0 * rough(x, z, 60.0)) / 25.0) * step((z + 260.0) / 40.0)
    stack = step(0.35 + 1.6 * rough(x + 300.0, z, 26.0) - 1.6) * step((-25.0 - x) / 10.0) * step((z + 230.0) / 20.0)
    rock = west * (21.0 + 10.0 * rough(x, z, 45.0)) + east * (13.0 + 6.0 * rough(x, z, 50.0)) + 9.0 * stack
    crags = 1.4 * rough(x, z, 7.0) * min(west + east + stack, 1.0)
    return min(max(max(sand, 1.0) + dunes + rock + crags, 0.0), WHITE_M)


def main(path):
    rows = []
    for row in range(DEPTH):
        z = (row - 0.8 * (DEPTH - 1)) * SPACING_M
        heights = (height_m((column - 0.5 * (WIDTH - 1)) * SPACING_M, z) for column in range(WIDTH))
        rows.append([round(height / WHITE_M * 65535.0 / STEP) * STEP for height in heights])
    write(path, rows)


if __name__ == "__main__":
    main(sys.argv[1])
