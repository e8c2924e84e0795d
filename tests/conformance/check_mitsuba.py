#!/usr/bin/env python3
"""Checks with Mitsuba 3 that an exported phase function scatters what the table says.

    python check_mitsuba.py PHASES.xml TABLE.csv        (needs: mitsuba, numpy)

Both files are made by `niji scatter --export` from one table of one drop size. A medium with
extinction pi M2 and the albedo of the XML must scatter pi M2 t: albedo times Mitsuba's own phase
function is t, direction by direction, though Mitsuba divides the values by their integral.
Exit status 0 if it holds; otherwise 1, and a line that says what was found.
"""

import csv
import math
import re
import sys
from xml.etree import ElementTree

import mitsuba as mi
import numpy as np

# Of the peak: the table is linear in the angle, tabphase in its cosine; worst found 1.1e-3.
TOLERANCE = 5e-3


def table(path):
    """Natural light by wavelength: angles in degrees and values in 1/sr."""
    curves = {}
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            natural = 0.5 * (float(row["s_sr1"]) + float(row["p_sr1"]))
            curve = curves.setdefault(float(row["wavelength_nm"]), ([], []))
            curve[0].append(float(row["theta_deg"]))
            curve[1].append(natural)
    return curves


def scattered(phase, theta):
    """Mitsuba's phase function for light that is turned by theta."""
    context = mi.PhaseFunctionContext()
    interaction = mi.MediumInteraction3f()
    # wi points to where the light comes from.
    interaction.wi = mi.Vector3f(0.0, 0.0, -1.0)
    interaction.sh_frame = mi.Frame3f(-interaction.wi)
    value = phase.eval_pdf(context, interaction, mi.Vector3f(math.sin(theta), 0.0, math.cos(theta)))
    return float(np.ravel(value[0] if isinstance(value, tuple) else value)[0])


def main():
    phases_path, table_path = sys.argv[1:3]
    mi.set_variant("scalar_rgb")
    with open(phases_path) as file:
        albedos = re.findall(r"<!-- (\S+) nm: albedo (\S+) -->", file.read())
    mi.load_file(phases_path)
    phases = {
        node.get("id"): mi.load_dict({"type": "tabphase", "values": node[0].get("value")})
        for node in ElementTree.parse(phases_path).getroot()
    }
    curves = table(table_path)
    if not albedos or len(phases) != len(albedos):
        sys.exit(f"found {len(phases)} phase functions and {len(albedos)} albedos")
    worst = 0.0
    for wavelength, albedo in albedos:
        angles, expected = curves[float(wavelength)]
        phase = phases[f"niji_{wavelength}nm"]
        peak = max(expected)
        for theta_deg in np.arange(max(angles[0], 12.0), min(angles[-1], 179.0), 0.37):
            found = float(albedo) * scattered(phase, math.radians(theta_deg))
            right = np.interp(theta_deg, angles, expected)
            if abs(found - right) > TOLERANCE * peak:
                sys.exit(f"{wavelength} nm, {theta_deg:.2f} degrees: found {found}, not {right}")
            worst = max(worst, abs(found - right) / peak)
    print(f"{len(albedos)} phase functions scatter what the table says within {worst:.1e}")


if __name__ == "__main__":
    main()
