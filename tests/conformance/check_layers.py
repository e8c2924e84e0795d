#!/usr/bin/env python3
"""Checks a picture for compositors that Niji writes against the spectral image beside it.

    python check_layers.py LAYERS SPECTRAL         (needs: OpenEXR, numpy)

The file must be one part with channels by the names that compositors look for. Its layers must add up to R, G and B,
and each have the luminance of the AOV of its name, within what half floats hold; A must be what the drops cover.
Exit status 0 if all of it holds; otherwise 1, and a line that says what was found.
"""

import sys

import numpy as np

sys.dont_write_bytecode = True  # check_exr is imported from the source tree.
from check_exr import expect, parts_of  # noqa: E402

# Relative error of rounding to half, and half of the smallest step of small numbers.
HALF, LEAST = 2.0**-11, 2.0**-25
LUMINANCE_OF_REC709 = np.array([0.2126390, 0.7151687, 0.0721923])


def rgb(channels, layer=""):
    return np.stack([channels[layer + channel] for channel in "RGB"], axis=-1).astype(float)


def check_layers(path, spectral_path):
    parts = list(parts_of(path))
    expect(len(parts) == 1, f"{len(parts)} parts, expected one")
    _, header, channels = parts[0]
    expect({"R", "G", "B", "A", "Z"} <= set(channels), f"channels {sorted(channels)}")
    names = sorted({name.rsplit(".", 1)[0] for name in channels if name.endswith(".R")})
    expect(len(names) >= 4, f"layers {names}, expected bows, air and sky at least")
    expect(all(name.replace("_", "").isalpha() for name in names), f"layers {names}")
    layers = {name: rgb(channels, name + ".") for name in names}
    picture = rgb(channels)
    rounding = HALF * (np.abs(picture) + sum(np.abs(layer) for layer in layers.values()))
    off = np.abs(sum(layers.values()) - picture)
    worst = np.max(off / (rounding + LEAST * (1 + len(layers))))
    expect(worst <= 1.01, f"the sum of layers is off by {worst:.2f} times the rounding")

    aovs = {name: aov for name, _, aov in parts_of(spectral_path)}
    white = header["niji:whiteLuminanceCdM2"][0]
    for name, layer in layers.items():
        expected = aovs[name]["Y"].astype(float) / white
        slack = HALF * np.abs(layer) @ LUMINANCE_OF_REC709 + LEAST + 1e-6 * np.abs(expected)
        error = np.max(np.abs(layer @ LUMINANCE_OF_REC709 - expected) / slack)
        expect(error <= 1.01, f"{name}: luminance off by {error:.2f} times the rounding")
        expect(np.max(expected) > 0, f"{name} is black")
    covered = 1 - aovs["transmittance"]["Y"].astype(float)
    error = np.max(np.abs(channels["A"] - covered) - HALF * np.abs(covered) - 1e-7)
    expect(error <= 0, "A is not what the drops cover")
    print(f"{path}: {', '.join(names)}: sum within {worst:.2f} times the rounding: ok")


if __name__ == "__main__":
    expect(len(sys.argv) == 3, "expected two files")
    check_layers(sys.argv[1], sys.argv[2])
