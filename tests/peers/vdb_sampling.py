#!/usr/bin/env python3
"""Trilinear sampling: this project's bricks against OpenVDB and NanoVDB, in one run.

    tests/peers/vdb_sampling.py [--nanovdb DIR] [--baseline] [--rounds 5]

Both sides sample the same 4 million points of the same volumes: a gradient of 64 cubed voxels, and
eleven clouds that fill a twentieth of 512 cubed voxels. `random` points lie in random leaves of the
tree; `coherent` ones follow each other by half a voxel on lines between two such points.

`openvdb` is BoxSampler over an accessor and `nanovdb` SampleFromVoxels<1> with its stencil cache over
an accessor, each for one float, as is `bricks` (Bricks::m2); `nanovdb3` is the cached sampler for
three floats in one grid, and `bricks4` (Bricks::sample) gives the four floats that a renderer of drops
needs. The programs time short stretches of points, each at its best of nine, and this script takes the
best of its rounds, in which the sides alternate, so that a busy machine hardly shows. The peer is
built for this machine's processor, with --baseline for any x86-64 as our side always is.

Needs g++, libopenvdb-dev (with TBB and Imath) and cargo. Debian packs no headers of NanoVDB; they are
in the source of the same package: `apt-get source openvdb`, then DIR is openvdb-*/nanovdb.
"""

import argparse
import pathlib
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Sums of f32 interpolation over all points may differ by this much.
TOLERANCE = 1e-5


def build(folder, nanovdb, baseline):
    peer = folder / "vdb_sampling"
    source = ROOT / "tests/peers/vdb_sampling.cc"
    flags = ["-O3", "-std=c++17"]
    if not baseline:
        flags.append("-march=native")
    if nanovdb:
        flags += ["-DWITH_NANOVDB", f"-I{nanovdb}"]
    libraries = ["-lopenvdb", "-ltbb", "-lImath-3_1"]
    subprocess.run(["g++", *flags, source, "-o", peer, *libraries], check=True)
    cargo = ["cargo", "build", "--release", "-p", "niji-dropfield", "--example", "sampling_speed"]
    lines = subprocess.run(
        [*cargo, "--message-format=json"], cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True
    ).stdout.splitlines()
    marker = '"executable":"'
    paths = [line.split(marker)[1].split('"')[0] for line in lines if marker in line]
    return peer, paths[-1]


def run(*command):
    lines = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    rows = (line.split() for line in lines.splitlines())
    return {(row[1], row[0]): (float(row[2]), float(row[3])) for row in rows if len(row) == 4}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nanovdb", type=pathlib.Path)
    parser.add_argument("--baseline", action="store_true")
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        compare(pathlib.Path(folder), options)


def compare(folder, options):
    peer, ours = build(folder, options.nanovdb, options.baseline)
    for kind in ["gradient", "sparse"]:
        path = folder / f"{kind}.vdb"
        subprocess.run([peer, "make", path, kind], check=True)
        best = {}
        for _ in range(options.rounds):
            for key, found in {**run(peer, "sample", path), **run(ours, path)}.items():
                best[key] = min(found, best.get(key, found))
        print(f"{kind}: ns a sample, bricks and bricks4 over it")
        for (order, name), (nanoseconds, total) in sorted(best.items()):
            sides = [best[order, side] for side in ("bricks", "bricks4")]
            assert abs(total / sides[0][1] - 1.0) < TOLERANCE, "the sums differ"
            ratios = "  ".join(f"{side[0] / nanoseconds:5.2f}" for side in sides)
            print(f"  {order:9} {name:9} {nanoseconds:7.1f}   {ratios}")


if __name__ == "__main__":
    main()
