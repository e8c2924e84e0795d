#!/usr/bin/env python3
"""All orders of scattering in clear and hazy air against discrete ordinates.

Reads the CSV of the example `sky-column` of crates/atmosphere (a planet so large that its air is
plane) and solves the same plane-parallel columns with PythonicDISORT (pip install PythonicDISORT):
molecules and an aerosol of Cornette and Shanks, each falling exponentially with height, in layers
that keep the columns of both, over a Lambertian ground. PythonicDISORT's own interpolation between
its quadrature angles errs by several per cent near the horizon, so here the radiance along a
direction is the integral of the source function over its discrete-ordinate solution:

    L(mu) = integral over t of S(t, mu, phi) exp(-t/mu) dt/mu,   t optical depth from the observer up

    cargo run --release -p niji-atmosphere --example sky-column > sky.csv
    python3 tests/peers/air_disort.py sky.csv

Prints the worst and the mean relative difference of all light by air, wavelength and albedo, and the
range of all/single; with `--reference FILE` also writes the radiances found, direction by direction.
Exit status 1 if any direction differs by more than 2 %.
"""

import argparse
import csv
import math
import sys

import numpy as np
from numpy.polynomial import legendre
from PythonicDISORT import pydisort

STREAMS = 32
# Azimuths on one side of the sun.
N_AZIMUTHS = 36
N_LAYERS = 28
NODES_PER_LAYER = 3
TOP_M = 1e5
LARGEST_DIFFERENCE = 0.02
# What a column is, as the example names it.
COLUMN = ("molecules_depth", "molecules_height_m", "king_factor",
          "haze_depth", "haze_height_m", "haze_albedo", "haze_parameter",
          "albedo", "sun_zenith_deg")


def rayleigh(king_factor, cosine):
    """Bucholtz's phase function, mean over the sphere 1."""
    depolarization = 6.0 * (king_factor - 1.0) / (3.0 + 7.0 * king_factor)
    gamma = depolarization / (2.0 - depolarization)
    return 0.75 / (1.0 + 2.0 * gamma) * (1.0 + 3.0 * gamma + (1.0 - gamma) * cosine**2)


def cornette_shanks(g, cosine):
    """Cornette and Shanks, mean over the sphere 1."""
    henyey = (1.0 - g * g) / (1.0 + g * g - 2.0 * g * cosine) ** 1.5
    return henyey * 1.5 * (1.0 + cosine**2) / (2.0 + g * g)


def moments(phase):
    """Legendre moments, 1 for the first."""
    x, weights = legendre.leggauss(400)
    polynomials = legendre.legvander(x, STREAMS - 1)
    return 0.5 * polynomials.T @ (weights * phase(x))


class Column:
    """One solved column under one sun; the beam comes down with the direction cosine -mu0."""

    def __init__(self, key):
        (air_depth, air_m, king, haze_depth, haze_m, haze_albedo, parameter, albedo, sun_deg) = key
        # A sun in the very zenith has no azimuth; discrete ordinates want it a little off.
        self.mu0 = min(math.cos(math.radians(sun_deg)), 1.0 - 1e-9)
        self.phases = [lambda c: rayleigh(king, c), lambda c: cornette_shanks(parameter, c)]
        heights = TOP_M * np.linspace(1.0, 0.0, N_LAYERS + 1) ** 3
        above = np.array([depth * (np.exp(-heights / scale) - math.exp(-TOP_M / scale))
                          for depth, scale in ((air_depth, air_m), (haze_depth, haze_m))])
        extinction = np.diff(above, axis=1)
        scattering = extinction * np.array([[1.0 - 1e-9], [haze_albedo]])
        self.tau = above.sum(axis=0)
        self.omega = scattering.sum(axis=0) / extinction.sum(axis=0)
        self.shares = scattering / scattering.sum(axis=0)
        by_kind = np.array([moments(phase) for phase in self.phases])
        ground = [albedo] if albedo > 0.0 else []
        self.mu, _, _, _, self.u = pydisort(
            self.tau[1:], self.omega, STREAMS, self.shares.T @ by_kind, self.mu0, 1.0, 0.0,
            NFourier=24, BDRF_Fourier_modes=ground, cache_asso_leg="no_mu0")[:5]
        nodes, weights = legendre.leggauss(STREAMS // 2)
        nodes, weights = 0.5 * (nodes + 1.0), 0.5 * weights
        order = [int(np.argmin(np.abs(nodes - abs(m)))) for m in self.mu]
        assert np.allclose(nodes[order], np.abs(self.mu), atol=1e-6)
        self.weights = weights[order]
        self.lay_nodes()

    def lay_nodes(self):
        """Nodes in every layer, and the light of all directions at them."""
        x, weights = legendre.leggauss(NODES_PER_LAYER)
        thickness = np.diff(self.tau)
        self.depth = (self.tau[:-1, None] + thickness[:, None] * 0.5 * (x + 1.0)).ravel()
        self.step = (thickness[:, None] * 0.5 * weights).ravel()
        self.layer = np.repeat(np.arange(N_LAYERS), NODES_PER_LAYER)
        # Even azimuths all around; the light is the same on both sides of the sun.
        self.azimuths = math.pi * (np.arange(N_AZIMUTHS) + 0.5) / N_AZIMUTHS
        self.light = np.array([self.u(self.depth, azimuth) for azimuth in self.azimuths])

    def radiance_at_ground(self, view_mu, azimuth):
        """Light that comes down from a direction: once scattered, and all of it."""
        mu = -view_mu
        sine = math.sqrt(1.0 - mu * mu)
        single, diffuse = 0.0, 0.0
        beam_cos = mu * -self.mu0 + sine * math.sqrt(1.0 - self.mu0**2) * math.cos(azimuth)
        beam = np.exp(-self.depth / self.mu0) / (4.0 * math.pi)
        for phase, share in zip(self.phases, self.shares):
            single = single + share[self.layer] * phase(beam_cos) * beam
            for side in (azimuth, -azimuth):
                cos_phi = np.cos(self.azimuths - side)
                sines = np.sqrt(1.0 - self.mu**2) * sine
                cosines = self.mu[None, :] * mu + sines[None, :] * cos_phi[:, None]
                weights = self.weights * phase(cosines) * (math.pi / N_AZIMUTHS / (4.0 * math.pi))
                diffuse = diffuse + share[self.layer] * np.einsum("ai,ait->t", weights, self.light)
        arriving = self.step * np.exp(-(self.tau[-1] - self.depth) / view_mu) / view_mu
        arriving *= self.omega[self.layer]
        return float(arriving @ single), float(arriving @ (single + diffuse))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("csv")
    parser.add_argument("--reference")
    arguments = parser.parse_args()
    rows = list(csv.DictReader(open(arguments.csv, encoding="ascii")))
    column, key, found, lines = None, None, {}, []
    for row in rows:
        wanted = tuple(float(row[name]) for name in COLUMN)
        if wanted != key:
            column, key = Column(wanted), wanted
        view_mu = math.cos(math.radians(float(row["view_zenith_deg"])))
        # Light from the sun's side travels on with the beam's azimuth, plus the azimuth of the view.
        azimuth = math.radians(float(row["azimuth_deg"]))
        single, everything = column.radiance_at_ground(view_mu, azimuth)
        group = found.setdefault((row["air"], row["wavelength_nm"], row["albedo"]), [])
        group.append((float(row["single"]) / single - 1.0, float(row["all"]) / everything - 1.0,
                      everything / single))
        names = ("air", "wavelength_nm", "albedo", "sun_zenith_deg", "view_zenith_deg", "azimuth_deg")
        lines.append(",".join([row[name] for name in names] + [f"{everything:.6e}"]))
    if arguments.reference:
        with open(arguments.reference, "w", encoding="ascii") as file:
            file.write("\n".join(lines) + "\n")
    worst = 0.0
    print("air,wavelength_nm,albedo,worst_single,worst_all,mean_all,least_ratio,largest_ratio")
    for (air, wavelength, albedo), group in found.items():
        values = np.array(group)
        errors = np.abs(values[:, 1])
        worst = max(worst, errors.max())
        print(f"{air},{wavelength},{albedo},{np.abs(values[:, 0]).max():.2e},{errors.max():.2e},"
              f"{errors.mean():.2e},{values[:, 2].min():.3f},{values[:, 2].max():.3f}")
    return 1 if worst > LARGEST_DIFFERENCE else 0


if __name__ == "__main__":
    sys.exit(main())
