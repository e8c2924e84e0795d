#!/usr/bin/env python3
"""Check that OpenVDB reads a VDB file as it was meant.

    check_vdb.py FILE EXPECTED.json

Reads FILE with OpenVDB's Python module and with vdb_print, and compares every value, every active
voxel, the transforms and the metadata with EXPECTED.json (made by vdb_expected.rs).
Run it with the python3 of the system: Debian's python3-openvdb is not seen by others.
"""

import json
import subprocess
import sys

import pyopenvdb

# Positions come out of the same double arithmetic, up to the order of the products.
WORLD_TOLERANCE = 1e-12


def plain(value):
    """A value as JSON holds it."""
    return [plain(part) for part in value] if isinstance(value, (tuple, list)) else value


def check(what, found, expected):
    if plain(found) != expected:
        sys.exit(f"{what}: OpenVDB reads {found!r}, expected {expected!r}")


def check_items(what, found, expected):
    for name, value in expected.items():
        if name not in found:
            sys.exit(f"{what}: OpenVDB finds no item {name}")
        check(f"{what}, item {name}", found[name], value)


def check_transform(what, grid, points):
    for index, world in points:
        found = grid.transform.indexToWorld(tuple(index))
        for ours, theirs in zip(world, found):
            if abs(ours - theirs) > WORLD_TOLERANCE * max(1.0, abs(ours)):
                sys.exit(f"{what}: index {index} is at {found}, expected {world}")


def check_grid(grid, expected):
    what = f"grid {expected['name']}"
    check(what + ", name", grid.name, expected["name"])
    check(what + ", class", str(grid.gridClass), expected["class"])
    check(what + ", type", grid.valueTypeName, expected["type"])
    check(what + ", background", grid.background, expected["background"])
    check(what + ", active voxels", grid.activeVoxelCount(), expected["n_active"])
    check_items(what, grid.metadata, expected["items"])
    check_transform(what, grid, expected["world"])
    if expected["bounds"] is not None:
        check(what + ", bounds", grid.evalActiveVoxelBoundingBox(), expected["bounds"])
    accessor = grid.getConstAccessor()
    for x, y, z, active, value in expected["voxels"]:
        check(f"{what}, voxel {x} {y} {z}", accessor.probeValue((x, y, z)), [value, active])


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    path = sys.argv[1]
    with open(sys.argv[2], encoding="utf-8") as file:
        expected = json.load(file)
    grids, items = pyopenvdb.readAll(path)
    check_items("file", items, expected["items"])
    check("number of grids", len(grids), len(expected["grids"]))
    # OpenVDB gives the grids of a file by name.
    in_order = sorted(expected["grids"], key=lambda grid: grid["name"])
    for grid, grid_expected in zip(grids, in_order):
        check_grid(grid, grid_expected)
    printed = subprocess.run(["vdb_print", "-l", path], capture_output=True, text=True, check=True)
    if printed.stderr:
        sys.exit(f"vdb_print: {printed.stderr}")
    for grid in expected["grids"]:
        for line in (f"Name: {grid['name']}", f"active voxels:       {grid['n_active']:,}\n"):
            if line not in printed.stdout:
                sys.exit(f"vdb_print does not print `{line}`")


if __name__ == "__main__":
    main()
