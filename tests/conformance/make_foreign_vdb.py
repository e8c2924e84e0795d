#!/usr/bin/env python3
"""Let OpenVDB write clouds on lattices that are turned, stretched, in centimetres with z up, or a camera's frustum.

    make_foreign_vdb.py OUTDIR

Each file has a grid `density`, a ball that fades outwards, and `temperature` on a coarser lattice of its own. Prints a
line of JSON for each: its name, the integral of the density in its own world, and the centre of the ball. Needs
OpenVDB's Python module.
"""

import json
import math
import pathlib
import sys

try:
    import openvdb as vdb
except ImportError:
    import pyopenvdb as vdb

RADIUS = 12


def turned(scale, angle):
    """Rows for row vectors on the left, as OpenVDB has matrices: scaled, turned about z, then about x, moved."""
    c, s = math.cos(angle), math.sin(angle)
    about_z = [[c, s, 0], [-s, c, 0], [0, 0, 1]]
    about_x = [[1, 0, 0], [0, c, s], [0, -s, c]]
    product = [
        [scale[i] * sum(about_z[i][k] * about_x[k][j] for k in range(3)) for j in range(3)]
        for i in range(3)
    ]
    return [row + [0] for row in product] + [[5.0, -3.0, 20.0, 1]]


def ball(transform):
    grid = vdb.FloatGrid()
    grid.name = "density"
    grid.gridClass = vdb.GridClass.FOG_VOLUME
    grid.transform = transform
    access, total = grid.getAccessor(), 0.0
    reach = range(-RADIUS, RADIUS + 1)
    for i in reach:
        for j in reach:
            for k in reach:
                value = max(0.0, 1 - math.hypot(i, j, k) / RADIUS)
                if value > 0:
                    access.setValueOn((i, j, k), value)
                    total += access.getValue((i, j, k))
    return grid, total


def warmth():
    """Rises by 2 a unit along x of the world, around the ball."""
    grid = vdb.FloatGrid()
    grid.name = "temperature"
    grid.transform = vdb.createLinearTransform(voxelSize=2.0)
    access = grid.getAccessor()
    for i in range(-20, 21):
        for j in range(-20, 21):
            for k in range(-5, 26):
                access.setValueOn((i, j, k), 100.0 + 4.0 * i)
    return grid


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    folder = pathlib.Path(sys.argv[1])
    for name, scale, angle in [
        ("turned", (0.5, 0.5, 0.5), 0.4),
        ("stretched", (0.5, 0.8, 1.1), 0.0),
        ("askew", (0.4, 0.6, 0.9), 1.0),
    ]:
        grid, total = ball(vdb.createLinearTransform(turned(scale, angle)))
        vdb.write(str(folder / f"{name}.vdb"), grids=[grid, warmth()])
        integral = total * scale[0] * scale[1] * scale[2]
        print(json.dumps({"name": name, "integral": integral, "centre": [5.0, -3.0, 20.0]}))
    frustum = vdb.createFrustumTransform((-20, -20, -20), (20, 20, 20), 0.5, 10.0)
    vdb.write(str(folder / "frustum.vdb"), grids=[ball(frustum)[0]])


if __name__ == "__main__":
    main()
