#!/usr/bin/env python3
"""Checks that Blender reads a drop volume as it was written.

    niji info drops.vdb --json > drops.json
    python check_blender.py drops.vdb drops.json        (needs: bpy, Blender as a module)

Blender must load every grid as a volume of floats, in its place and size; the OpenVDB inside Blender
must find as many active voxels with the same smallest, largest and mean value.
Exit status 0 if all of it holds; otherwise 1, and a line that says what was found.
"""

import glob
import json
import os
import sys

import bpy

# Means are added up in another order.
MEAN_TOLERANCE = 1e-6


def expect(what, found, expected):
    if found != expected:
        sys.exit(f"{what}: found {found}, expected {expected}")


def expect_near(what, found, expected, tolerance):
    if abs(found - expected) > tolerance * max(abs(found), abs(expected)):
        sys.exit(f"{what}: found {found}, expected {expected}")


def blenders_openvdb():
    """OpenVDB's module belongs to the Python inside Blender."""
    folder = bpy.utils.resource_path("LOCAL")
    sys.path.extend(glob.glob(f"{folder}/python/lib/python*/site-packages"))
    import openvdb

    return openvdb


def main():
    vdb_path, json_path = (os.path.abspath(path) for path in sys.argv[1:3])
    with open(json_path) as file:
        described = {grid["name"]: grid for grid in json.load(file)["grids"]}
    volume = bpy.data.volumes.new("drops")
    volume.filepath = vdb_path
    if not volume.grids.load():
        sys.exit(f"Blender does not load {vdb_path}: {volume.grids.error_message}")
    expect("grids", sorted(grid.name for grid in volume.grids), sorted(described))
    openvdb = blenders_openvdb()
    for grid in volume.grids:
        told = described[grid.name]
        expect(f"{grid.name}: type", grid.data_type, "FLOAT")
        for axis in range(3):
            name = f"{grid.name}: axis {axis}"
            expect_near(f"{name}, voxel", grid.matrix_object[axis][axis], told["voxel_m"][axis], 1e-6)
            expect_near(f"{name}, origin", grid.matrix_object[axis][3], told["origin_m"][axis], 1e-6)
        values = openvdb.read(vdb_path, grid.name)
        expect(f"{grid.name}: active voxels", values.activeVoxelCount(), told["active_voxels"])
        low, high = values.evalMinMax()
        expect(f"{grid.name}: smallest", float(low), told["min"])
        expect(f"{grid.name}: largest", float(high), told["max"])
        total = sum(item.value * item.count for item in values.citerOnValues())
        mean = total / values.activeVoxelCount()
        expect_near(f"{grid.name}: mean", mean, told["mean"], MEAN_TOLERANCE)
    print(f"Blender {bpy.app.version_string} reads {len(described)} grids")


if __name__ == "__main__":
    main()
