#!/usr/bin/env python3
"""Makes the heights of `data/scenes/lit-valley.toml`: a PNG of 16 bits of gray, with nothing but Python's own library.

    python3 examples/valley_heights.py data/heights/valley.png

A valley winds northwards between two ridges, through noise of seven octaves whose hollows are smoothed as rivers and
frost do. Black is 0 m and white 1000 m; steps are of a quarter of a metre, which compresses.
"""

import math
import struct
import sys
import zlib

SIZE = 289
SPACING_M = 30.0
NORTH_M = -6500.0
WHITE_M = 1000.0
STEP = 16


def hashed(x, y):
    """A number from 0 to 1 for each node of a lattice."""
    n = (x * 374761393 + y * 668265263 + 1013904223) & 0xFFFFFFFF
    n = ((n ^ (n >> 13)) * 1274126177) & 0xFFFFFFFF
    return ((n ^ (n >> 16)) & 0xFFFF) / 65535.0


def noise(x, y):
    """Smooth noise from -1 to 1 over a lattice of unit cells."""
    i, j = math.floor(x), math.floor(y)
    u, v = (t * t * t * (t * (6.0 * t - 15.0) + 10.0) for t in (x - i, y - j))
    near = hashed(i, j) * (1.0 - u) + hashed(i + 1, j) * u
    far = hashed(i, j + 1) * (1.0 - u) + hashed(i + 1, j + 1) * u
    return 2.0 * (near * (1.0 - v) + far * v) - 1.0


def rough(x, y):
    """Ridges where noise changes its sign, finer and lower octave by octave, more on heights than in hollows."""
    total, weight, scale = 0.0, 1.0, 1.0 / 2100.0
    for octave in range(7):
        ridge = 1.0 - abs(noise(x * scale + 17.3 * octave, y * scale - 5.1 * octave))
        total += weight * ridge * ridge
        weight *= 0.5 * min(1.0, 0.35 + 0.8 * ridge * ridge)
        scale *= 2.03
    return total


def height_m(x, z):
    """Height at a place east and south of the origin."""
    axis = 260.0 * math.sin(z / 1150.0) - 0.04 * z
    across = (x - axis) / (620.0 + 0.03 * -min(z, 0.0))
    slope = 1.0 - math.exp(-across * across)
    head = 1.0 / (1.0 + math.exp((z + 6000.0) / 500.0))
    rise = max(slope, 0.85 * head)
    floor = 18.0 + 6.0 * noise(x / 400.0, z / 400.0)
    return floor + rise * (90.0 + 400.0 * rough(x, z))


def write(path, rows):
    """Writes rows of codes of 16 bits as a PNG."""
    lines, above = [], [0] * len(rows[0])
    for codes in rows:
        # The filter Paeth byte by byte, as PNG has it.
        line, over = (b"".join(struct.pack(">H", code) for code in it) for it in (codes, above))
        out = bytearray([4])
        for index, value in enumerate(line):
            a = line[index - 2] if index >= 2 else 0
            b = over[index]
            c = over[index - 2] if index >= 2 else 0
            p = a + b - c
            nearest = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))
            out.append((value - nearest[2]) & 0xFF)
        lines.append(bytes(out))
        above = codes

    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    header = struct.pack(">IIBBBBB", len(rows[0]), len(rows), 16, 0, 0, 0, 0)
    data = zlib.compress(b"".join(lines), 9)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b""))


def main():
    west = -0.5 * SPACING_M * (SIZE - 1)
    rows = []
    for row in range(SIZE):
        codes = []
        for column in range(SIZE):
            height = height_m(west + SPACING_M * column, NORTH_M + SPACING_M * row)
            code = round(height / WHITE_M * 65535.0 / STEP) * STEP
            codes.append(min(max(code, 0), 65535))
        rows.append(codes)
    write(sys.argv[1], rows)


if __name__ == "__main__":
    main()
