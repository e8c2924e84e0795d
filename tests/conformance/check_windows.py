#!/usr/bin/env python3
"""Checks the windows of an EXR image with two readers that share no code with Niji.

    python check_windows.py FILE DATA DISPLAY      (needs: OpenEXR, OpenImageIO, numpy)

DATA and DISPLAY are X,Y,WIDTH,HEIGHT: where the pixels lie, and the frame. Every part must have both.
Exit status 0 if all of it holds; otherwise 1, and a line that says what was found.
"""

import sys

import numpy as np
import OpenEXR
import OpenImageIO as oiio


def expect(holds, message):
    if not holds:
        raise SystemExit(f"{sys.argv[0]}: {message}")


def region(window):
    """X, Y, width and height of a window of corners that both belong to it."""
    first, last = (np.ravel(corner) for corner in window)
    return [int(n) for n in (*first, *(last - first + 1))]


def main(path, data, display):
    data, display = ([int(n) for n in text.split(",")] for text in (data, display))
    n_parts = 0
    with OpenEXR.File(path, separate_channels=True) as file:
        for part in file.parts:
            found = region(part.header["dataWindow"]), region(part.header["displayWindow"])
            expect(found == (data, display), f"OpenEXR: {part.name()} has {found}")
            for name, channel in part.channels.items():
                shape = channel.pixels.shape
                expect(shape == (data[3], data[2]), f"OpenEXR: {name} is {shape}")
            n_parts += 1
    image = oiio.ImageInput.open(path)
    for index in range(n_parts):
        spec = image.spec(index, 0)
        found = (
            [spec.x, spec.y, spec.width, spec.height],
            [spec.full_x, spec.full_y, spec.full_width, spec.full_height],
        )
        expect(found == (data, display), f"OpenImageIO: part {index} has {found}")
    image.close()
    print(f"{path}: {n_parts} parts, data {data}, display {display}")


if __name__ == "__main__":
    main(*sys.argv[1:])
