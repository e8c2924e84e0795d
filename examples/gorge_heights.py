#!/usr/bin/env python3
"""Makes the heights of `data/scenes/white-water.toml`: a PNG of 16 bits of gray, with nothing but Python's own library.

    python3 examples/gorge_heights.py data/heights/gorge.png

A cliff of 40 m across the picture with buttresses and ledges, its top uneven but for the lip of the fall, walls on both
sides that come nearer, and a floor of boulders. Black is 0 m and white 100 m.
"""

import sys

from valley_heights import noise, write

WIDTH, DEPTH = 301, 241
SPACING_M = 1.0
FALL_M = 40.0
WHITE_M = 100.0
STEP = 65


def rough(x, y, size_m):
    """Noise of four octaves, the largest so wide."""
    return sum(0.5**k * noise(x * 2**k / size_m + 9.7 * k, y * 2**k / size_m - 3.1 * k) for k in range(4))


def step(t):
    """From 0 to 1 over unit length."""
    t = min(max(t, 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)


def height_m(x, z):
    """Height at a place east of the middle of the fall and south of its foot."""
    in_fall = 1.0 - step((abs(x) - 28.0) / 8.0)
    # The cliff stands back from the water, with ribs that lean forward beside it.
    edge = -3.0 + (1.0 - in_fall) * (4.0 * rough(x, 40.0, 18.0) + 2.0)
    back = step((edge - z) / 3.5 + 0.12 * noise(x / 5.0, z / 2.0))
    top = FALL_M + (1.0 - in_fall) * (5.0 + 7.0 * rough(x, z, 35.0) + 0.25 * max(abs(x) - 40.0, 0.0))
    side = 62.0 + 9.0 * rough(7.0, z, 40.0) + 0.12 * max(z, 0.0)
    wall = step((abs(x) - side) / 22.0) * (46.0 + 9.0 * rough(x, z, 30.0))
    floor = 1.0 + 1.6 * max(rough(x, z, 9.0), 0.0) * step(z / 10.0)
    return max(floor, back * top, wall)


def main():
    rows = []
    for row in range(DEPTH):
        z = (row + 0.5 - DEPTH / 2) * SPACING_M + 60.0
        codes = []
        for column in range(WIDTH):
            x = (column + 0.5 - WIDTH / 2) * SPACING_M
            value = min(max(height_m(x, z) / WHITE_M, 0.0), 1.0) * 65535
            codes.append(min(int(value / STEP) * STEP, 65535))
        rows.append(codes)
    write(sys.argv[1], rows)


if __name__ == "__main__":
    main()
