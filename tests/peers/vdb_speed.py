#!/usr/bin/env python3
"""Reading and writing of VDB files: this project against OpenVDB's C++ library, in one run.

    tests/peers/vdb_speed.py [--rounds 5] [--folder DIR] [--check]

Both sides run alternately, round by round, on the same files (a ball of 52 million active voxels of
noisy floats, which OpenVDB wrote without compression, with zip and with Blosc). Printed are the
median times, their ratio, the peak memory, and whether both sides found the same values.
`--check` fails unless ours is no slower and its peak memory at most 1.3 times the
uncompressed file.

Needs g++, libopenvdb-dev (with TBB and Imath) and cargo; 3 GB on disc.
"""

import argparse
import pathlib
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Peak memory in units of the uncompressed file, which is the voxels and little else.
MOST_MEMORY = 1.3
# OpenVDB may be this much faster before --check fails: noise of a shared machine.
SLACK = 1.05


def build(folder):
    peer = folder / "vdb_speed"
    source = ROOT / "tests/peers/vdb_speed.cc"
    libraries = ["-lopenvdb", "-ltbb", "-lImath-3_1"]
    subprocess.run(["g++", "-O3", "-std=c++17", source, "-o", peer, *libraries], check=True)
    cargo = ["cargo", "build", "--release", "-p", "niji-vdb", "--example", "vdb_speed"]
    lines = subprocess.run(
        [*cargo, "--message-format=json"], cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True
    ).stdout.splitlines()
    marker = '"executable":"'
    paths = [line.split(marker)[1].split('"')[0] for line in lines if marker in line]
    return peer, paths[-1]


def run(program, *arguments):
    line = subprocess.run(
        [program, *arguments], check=True, stdout=subprocess.PIPE, text=True
    ).stdout.split()
    return float(line[0]), (int(line[1]), int(line[2])), float(line[3])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--folder", type=pathlib.Path)
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=options.folder) as folder:
        return compare(pathlib.Path(folder), options)


def compare(folder, options):
    peer, ours = build(folder)
    files = {}
    for name in ["none", "zip", "blosc"]:
        files[name] = folder / f"{name}.vdb"
        subprocess.run([peer, "make", files[name], name], check=True)
    jobs = [(f"read {name}", ["read", path]) for name, path in files.items()]
    out = folder / "out.vdb"
    for name in ["none", "zip"]:
        jobs.append((f"write {name}", ["write", files["none"], out, name]))

    payload = files["none"].stat().st_size / 2**20
    print(f"{payload:.0f} MiB of voxels, medians of {options.rounds} alternating rounds")
    print("job          OpenVDB s     ours s   ours/OpenVDB   peak MiB: OpenVDB   ours   values")
    missed = []
    for title, arguments in jobs:
        theirs, own = [], []
        for _ in range(options.rounds):
            theirs.append(run(peer, *arguments))
            size = out.stat().st_size if out.exists() else 0
            own.append(run(ours, *arguments))
            if title.startswith("write"):
                # What we wrote, OpenVDB reads.
                assert run(peer, "read", out)[1] == own[-1][1], "OpenVDB finds other values"
        median = lambda runs, place: statistics.median(one[place] for one in runs)
        seconds, our_seconds = median(theirs, 0), median(own, 0)
        memory, our_memory = median(theirs, 2), median(own, 2)
        same = theirs[0][1] == own[0][1]
        note = "same" if same else "DIFFER"
        if title.startswith("write"):
            note += f", bytes ours/OpenVDB {out.stat().st_size / size:.3f}"
        ratio = our_seconds / seconds
        print(
            f"{title:12} {seconds:9.3f}  {our_seconds:9.3f}   {ratio:12.2f}"
            f"   {memory:17.0f}   {our_memory:4.0f}   {note}"
        )
        if not same or ratio > SLACK:
            missed.append(title)
        if our_memory > MOST_MEMORY * payload:
            missed.append(f"memory of {title}")
    if missed and options.check:
        print("missed:", ", ".join(missed), file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
