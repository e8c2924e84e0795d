#!/usr/bin/env python3
"""Let OpenVDB write VDB files of every kind, with its own account of each.

    make_vdb_matrix.py OUTDIR

Builds tests/peers/vdb_matrix.cc in OUTDIR and runs it there. Needs g++ and, on Debian,
libopenvdb-dev, libtbb-dev, libboost-dev, libboost-iostreams-dev, libimath-dev, libblosc-dev.
"""

import pathlib
import subprocess
import sys

SOURCE = pathlib.Path(__file__).resolve().parent.parent / "peers" / "vdb_matrix.cc"
LIBRARIES = ["-lopenvdb", "-ltbb", "-lImath-3_1"]


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    directory = pathlib.Path(sys.argv[1])
    directory.mkdir(parents=True, exist_ok=True)
    program = directory / "vdb_matrix"
    built = program.exists() and program.stat().st_mtime > SOURCE.stat().st_mtime
    if not built:
        command = ["g++", "-O1", "-std=c++17", str(SOURCE), "-o", str(program), *LIBRARIES]
        subprocess.run(command, check=True)
    subprocess.run([str(program), str(directory)], check=True)


if __name__ == "__main__":
    main()
