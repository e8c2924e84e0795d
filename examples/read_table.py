#!/usr/bin/env python3
"""Reads a scattering table of Niji with nothing but the OpenEXR package (pip install OpenEXR).

    niji scatter ... -o table.exr
    python examples/read_table.py table.exr

A scattering table is an EXR image: one column per scattering angle, one row per effective radius and
effective variance (the last runs fastest), one channel per polarization and wavelength: `s.560nm`
perpendicular and `p.560nm` parallel to the scattering plane. Values are (dsigma/dOmega) / (pi <r^2>) in
1/sr. The axes stand in the header as text. Rows of single sizes (niji:rowUse is sums) add up to any size
law. Tables for flattened drops hold the light of each bow once more, in parts called moved.2 and moved.3 with
angles of their own.
"""

import sys

import numpy as np
import OpenEXR

WAVELENGTH_NM = 560

with OpenEXR.File(sys.argv[1], separate_channels=True) as file:
    header = dict(file.header())
    s, p = (file.channels()[f"{j}.{WAVELENGTH_NM}nm"].pixels.copy() for j in "sp")


def axis(name):
    return np.array([float(value) for value in header[f"niji:axis.{name}"].split(",")])


theta_deg = np.degrees(axis("theta"))
radii, variances = axis("effective_radius"), axis("effective_variance")
names = ["theta", "effective_radius", "effective_variance"]
print(f"theory {header['niji:theory']}, orders {header['niji:orders']}")
for name in names:
    values, unit = axis(name), header[f"niji:unit.{name}"]
    print(f"{name}: {len(values)} values, {values[0]:g} to {values[-1]:g} {unit}")

# Natural light is half the sum of both polarizations.
natural = ((s + p) / 2).reshape(len(radii), len(variances), len(theta_deg))

# The primary bow lies behind the split, at larger scattering angles; the secondary in front of it.
split_deg = np.degrees(header["niji:splitThetaRad"][0])
primary = np.where(theta_deg >= split_deg, natural, 0.0)

print(f"peak of the primary bow at {WAVELENGTH_NM} nm:")
for i, radius in enumerate(radii):
    for j, variance in enumerate(variances):
        peak = np.argmax(primary[i, j])
        print(
            f"  r_e = {radius:g} um, v_e = {variance:g}: "
            f"theta = {theta_deg[peak]:.2f} deg, "
            f"{180 - theta_deg[peak]:.2f} deg from the antisolar point, "
            f"{primary[i, j, peak]:.4g} / sr"
        )
