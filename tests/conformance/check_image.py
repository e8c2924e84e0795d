#!/usr/bin/env python3
"""Checks a spectral image that Niji writes with colour-science, OpenEXR and OpenImageIO.

    python check_image.py FILE         (needs: colour-science, OpenEXR, OpenImageIO, numpy)

The image must open with `colour.read_spectral_image_Fichet2021`, as emission, with the wavelengths
and values that the file holds; its R, G, B times `whiteLuminance` must be the luminance that the
spectra have under the CIE 1931 color matching functions of colour-science.
Exit status 0 if all of it holds; otherwise 1, and a line that says what was found.
"""

import sys
import warnings

import numpy as np

sys.dont_write_bytecode = True  # check_exr is imported from the source tree.
warnings.filterwarnings("ignore")  # colour-science names the optional packages it lacks.
import colour  # noqa: E402

from check_exr import check, expect, parts_of  # noqa: E402

LUMINANCE_OF_REC709 = np.array([0.2126390, 0.7151687, 0.0721923])
# Worst found 1.2e-4, from f32 and from the edges of the bins.
LUMINANCE_TOLERANCE = 2e-3


def luminance(wavelengths, radiance):
    """683 lm/W times the sum over bins of radiance, mean of y-bar and width [cd/m^2]."""
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    fine = np.arange(300.0, 1000.0, 0.05)
    y_bar = np.interp(fine, observer.wavelengths, observer.values[:, 1], left=0.0, right=0.0)
    step = wavelengths[1] - wavelengths[0] if len(wavelengths) > 1 else 1.0
    weights = [y_bar[np.abs(fine - center) <= step / 2].mean() for center in wavelengths]
    return 683.0 * step * radiance @ np.array(weights)


def check_image(path):
    name, header, channels = next(parts_of(path))
    for attribute, expected in [
        ("spectralLayoutVersion", "1.0"),
        ("emissiveUnits", "W.m^-2.sr^-1"),
        ("niji:spectralUnit", "W.m^-2.sr^-1.nm^-1"),
    ]:
        found = header.get(attribute)
        expect(found == expected, f"found {attribute} {found!r}, expected {expected!r}")
    expect({"R", "G", "B"} <= set(channels), "no R, G, B in the spectral part")

    components, specification = colour.read_spectral_image_Fichet2021(path, additional_data=True)
    expect(specification.is_emissive, "colour-science does not see emission")
    expect(not specification.is_polarised, "colour-science sees polarisation")
    expect(list(components) == ["S0"], f"components {list(components)}, expected S0")
    wavelengths, radiance = components["S0"]

    spectral = [channel for channel in channels if channel.startswith("S0.")]
    first, step = header["niji:wavelengthFirstNm"][0], header["niji:wavelengthStepNm"][0]
    expected = first + step * np.arange(len(spectral))
    expect(np.allclose(wavelengths, expected, rtol=0, atol=1e-6), f"wavelengths {wavelengths}")
    for index, center in enumerate(expected):
        digits = f"{center:.6f}".replace(".", ",")
        pixels = channels[f"S0.{digits}nm"]
        expect(np.array_equal(radiance[:, :, index], pixels), f"{center} nm: values differ")

    rgb = np.stack([channels[channel] for channel in "RGB"], axis=-1).astype(float)
    expect(np.all(rgb >= 0), "R, G, B below zero")
    shown = header["whiteLuminance"] * (rgb @ LUMINANCE_OF_REC709)
    true = luminance(wavelengths, radiance.astype(float))
    error = np.max(np.abs(shown - true)) / max(np.max(np.abs(true)), 1e-30)
    expect(error <= LUMINANCE_TOLERANCE, f"luminance differs by {error:.2e} of its maximum")
    print(f"{path}: {len(spectral)} wavelengths, luminance within {error:.1e}: ok")


if __name__ == "__main__":
    expect(len(sys.argv) == 2, "expected one file")
    check(sys.argv[1])
    check_image(sys.argv[1])
