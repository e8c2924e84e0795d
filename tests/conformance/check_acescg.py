#!/usr/bin/env python3
"""Checks a plain image of ACEScg against the same image in Rec.709 with colour-science.

    python check_acescg.py REC709 ACESCG         (needs: colour-science, OpenEXR, numpy)

Both files must name their primaries and white. Where no color was moved into the gamut of Rec.709,
ACEScg must be what colour-science makes of it, adapted to the white of ACES by Bradford's matrix.
Exit status 0 if all of it holds; otherwise 1, and a line that says what was found.
"""

import sys
import warnings

import numpy as np

sys.dont_write_bytecode = True  # check_exr is imported from the source tree.
warnings.filterwarnings("ignore")  # colour-science names the optional packages it lacks.
import colour  # noqa: E402

from check_exr import expect, parts_of  # noqa: E402

# Half floats in both files, each within 2^-11.
TOLERANCE = 2 * 2.0**-11


def plain(path, space):
    _, header, channels = next(parts_of(path))
    space = colour.RGB_COLOURSPACES[space]
    expected = np.append(space.primaries, [space.whitepoint], axis=0).ravel()
    found = np.ravel(header["chromaticities"])
    expect(np.allclose(found, expected, rtol=0, atol=1e-6), f"{path}: chromaticities {found}")
    return np.stack([channels[channel] for channel in "RGB"], axis=-1).astype(float)


def check_acescg(rec709_path, acescg_path):
    rec709 = plain(rec709_path, "ITU-R BT.709")
    acescg = plain(acescg_path, "ACEScg")
    matrix = colour.matrix_RGB_to_RGB("ITU-R BT.709", "ACEScg", "Bradford")
    inside = (rec709 > 0).all(axis=-1) & (acescg > 0).all(axis=-1)
    expect(inside.mean() > 0.2, f"only {inside.mean():.0%} of the pixels lie in the gamut")
    error = np.abs(rec709 @ matrix.T - acescg)[inside].max() / acescg.max()
    expect(error <= TOLERANCE, f"ACEScg differs by {error:.2e} of the brightest")
    print(f"{acescg_path}: {inside.mean():.0%} of the pixels within {error:.1e}: ok")


if __name__ == "__main__":
    expect(len(sys.argv) == 3, "expected two files")
    check_acescg(sys.argv[1], sys.argv[2])
