#!/usr/bin/env python3
"""Checks any EXR file that Niji writes with two readers that share no code with it.

    python check_exr.py FILE...        (needs: OpenEXR, OpenImageIO, numpy)

Every part must open in both, with equal values of 32 bits (16 in the layers for compositors), all finite,
and with the checksum that its header states. A part with `niji:columns` is a table: its axes must ascend and span its pixels.
Exit status 0 if all of it holds; otherwise 1, and a line that says what was found.
"""

import hashlib
import struct
import sys

import numpy as np
import OpenEXR
import OpenImageIO as oiio


def expect(holds, message):
    if not holds:
        raise SystemExit(f"{sys.argv[0]}: {message}")


def parts_of(path):
    """Name, header and channels (name -> pixels) of every part, as the OpenEXR package has them."""
    with OpenEXR.File(path, separate_channels=True) as file:
        for part in file.parts:
            # A copy: the pixels belong to the file.
            pixels = {name: channel.pixels.copy() for name, channel in part.channels.items()}
            yield part.name(), dict(part.header), pixels


def checksum(name, header, channels):
    """The checksum of a part from its definition: see crates/exchange/src/checksum.rs."""
    digest = hashlib.sha256()

    def add(data):
        digest.update(struct.pack("<Q", len(data)) + data)

    add(name.encode())
    for key in sorted(header):
        if key.startswith("niji:") and key != "niji:checksum":
            value = header[key]
            add(key.encode())
            add(value.encode() if isinstance(value, str) else struct.pack("<d", value[0]))
    if "whiteLuminance" in header:
        add(struct.pack("<f", header["whiteLuminance"]))
    for number in np.ravel(header.get("worldToCamera", [])):
        add(struct.pack("<f", number))
    place = np.ravel(header["dataWindow"][0])
    if place.any():
        for number in place:
            add(struct.pack("<i", number))
    for key in sorted(channels):
        pixels = np.ascontiguousarray(channels[key], dtype="<f4")
        add(key.encode())
        add(struct.pack("<Q", pixels.shape[0]))
        add(struct.pack("<Q", pixels.shape[1]))
        add(hashlib.sha256(pixels.tobytes()).digest())
    return digest.hexdigest()


def check_table(name, header, channels):
    """Axes of a table: the columns span the width, the rows (last one fastest) the height."""
    n_rows = 1
    rows = [axis for axis in header["niji:rows"].split(",") if axis]
    for axis in rows + [header["niji:columns"]]:
        values = np.array([float(text) for text in header[f"niji:axis.{axis}"].split(",")])
        expect(f"niji:unit.{axis}" in header, f"part {name}: axis {axis} has no unit")
        expect(np.all(np.diff(values) > 0), f"part {name}: axis {axis} does not ascend")
        n_rows *= len(values) if axis in rows else 1
    shape = (n_rows, len(values))
    for channel, pixels in channels.items():
        expect(pixels.shape == shape, f"part {name}, {channel}: {pixels.shape}, expected {shape}")


def check(path):
    for index, (name, header, channels) in enumerate(parts_of(path)):
        image = oiio.ImageBuf(path, index, 0)
        spec = image.spec()
        expect(not image.has_error, f"OpenImageIO, part {name}: {image.geterror()}")
        expect(set(spec.channelnames) == set(channels), f"part {name}: channels differ")
        values = image.get_pixels(oiio.FLOAT)
        for channel, pixels in channels.items():
            kinds = [np.float32, np.float16] if name == "layers" else [np.float32]
            expect(pixels.dtype in kinds, f"part {name}, {channel}: {pixels.dtype}")
            expect(np.all(np.isfinite(pixels)), f"part {name}, {channel}: not finite")
            other = values[:, :, spec.channelnames.index(channel)]
            expect(np.array_equal(pixels, other), f"part {name}, {channel}: readers disagree")
        found, stated = checksum(name, header, channels), header.get("niji:checksum")
        expect(found == stated, f"part {name}: checksum {found}, header says {stated}")
        if "niji:columns" in header:
            check_table(name, header, channels)
        height, width = next(iter(channels.values())).shape
        print(f"{path}: part {name}: {width} x {height}, {len(channels)} channels: ok")


if __name__ == "__main__":
    expect(len(sys.argv) > 1, "found no file, expected at least one")
    for argument in sys.argv[1:]:
        check(argument)
