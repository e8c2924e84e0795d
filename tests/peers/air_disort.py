#!/usr/bin/env python3
"""Multiple scattering in a Rayleigh sky against discrete ordinates.

Reads the CSV of the example `sky-column` of crates/atmosphere (a planet so large that its air is
plane) and solves the same plane-parallel columns with PythonicDISORT (pip install PythonicDISORT).
Scalar Rayleigh phase function, conservative, Lambertian ground. PythonicDISORT's own interpolation
between its quadrature angles errs by several per cent near the horizon, so here the radiance along
a direction is the integral of the source function over its discrete-ordinate solution:

    L(mu) = integral over t of S(t, mu, phi) exp(-t/mu) dt/mu,   t optical depth from the observer up

    cargo run --release -p niji-atmosphere --example sky-column > sky.csv
    python3 tests/peers/air_disort.py sky.csv

Prints the worst and the mean relative difference of all light by wavelength and albedo, and the
range of all/single. Exit status 1 if any direction differs by more than 2 %.
"""

import csv
import math
import sys

import numpy as np
from PythonicDISORT import pydisort

STREAMS = 32
DEPTH_NODES = 24
LARGEST_DIFFERENCE = 0.02


def legendre2(x):
    return 1.5 * x * x - 0.5


def associated(mu):
    """Y_00, Y_20, Y_21, Y_22 with P_2 = sum of (2 - delta) Y_2m Y_2m' cos m phi."""
    s = np.sqrt(1.0 - mu * mu)
    return legendre2(mu), math.sqrt(1.5) * mu * s, math.sqrt(0.375) * s * s


class Column:
    """One solved column under one sun; the beam comes down with the direction cosine -mu0."""

    def __init__(self, tau, albedo, mu0):
        self.tau, self.mu0 = tau, mu0
        coefficients = np.zeros(STREAMS)
        coefficients[0], coefficients[2] = 1.0, 0.1
        # Mode 0 in the normalisation of PythonicDISORT: 1 gives back all the flux.
        ground = [albedo] if albedo > 0.0 else []
        self.mu, _, _, _, self.u = pydisort(
            tau, 1.0 - 1e-9, STREAMS, coefficients, mu0, 1.0, 0.0,
            NFourier=3, BDRF_Fourier_modes=ground,
        )[:5]
        half = STREAMS // 2
        _, weights = np.polynomial.legendre.leggauss(half)
        nodes, weights = np.polynomial.legendre.leggauss(half)
        nodes, weights = 0.5 * (nodes + 1.0), 0.5 * weights
        order = [int(np.argmin(np.abs(nodes - abs(m)))) for m in self.mu]
        assert np.allclose(nodes[order], np.abs(self.mu), atol=1e-6)
        self.weights = weights[order]

    def source(self, depth, mu, phi):
        """Diffuse source function and that of single scattering at optical depths from the top."""
        n = 8
        azimuths = 2.0 * math.pi * np.arange(n) / n
        light = np.array([self.u(depth, azimuth) for azimuth in azimuths])
        cos_phi = np.cos(azimuths - phi)
        sines = np.sqrt(1.0 - self.mu**2) * math.sqrt(1.0 - mu * mu)
        cos_theta = self.mu[None, :] * mu + sines[None, :] * cos_phi[:, None]
        phase = 1.0 + 0.5 * legendre2(cos_theta)
        weights = self.weights[None, :] * (2.0 * math.pi / n) * phase / (4.0 * math.pi)
        diffuse = np.einsum("ai,ait->t", weights, light)
        beam_cos = -mu * self.mu0 + math.sqrt((1 - mu * mu) * (1 - self.mu0**2)) * math.cos(phi)
        beam = (1.0 + 0.5 * legendre2(beam_cos)) / (4.0 * math.pi)
        return diffuse, beam * np.exp(-depth / self.mu0)

    def radiance_at_ground(self, view_mu, azimuth):
        """Light that comes down from a direction: once scattered, and all of it."""
        nodes, weights = np.polynomial.legendre.leggauss(DEPTH_NODES)
        up = 0.5 * self.tau * (nodes + 1.0)
        weights = 0.5 * self.tau * weights * np.exp(-up / view_mu) / view_mu
        diffuse, single = self.source(self.tau - up, -view_mu, azimuth)
        return float(weights @ single), float(weights @ (single + diffuse))


def main():
    rows = list(csv.DictReader(open(sys.argv[1], encoding="ascii")))
    columns, found = {}, {}
    for row in rows:
        key = tuple(float(row[name]) for name in ("optical_depth", "albedo", "sun_zenith_deg"))
        # A sun in the very zenith has no azimuth; discrete ordinates want it a little off.
        mu0 = min(math.cos(math.radians(key[2])), 1.0 - 1e-9)
        if key not in columns:
            columns[key] = Column(key[0], key[1], mu0)
        view_mu = math.cos(math.radians(float(row["view_zenith_deg"])))
        # Light from the sun's side travels on with the beam's azimuth, plus the azimuth of the view.
        azimuth = math.radians(float(row["azimuth_deg"]))
        single, everything = columns[key].radiance_at_ground(view_mu, azimuth)
        group = found.setdefault((row["wavelength_nm"], row["albedo"]), [])
        group.append((
            float(row["single"]) / single - 1.0,
            float(row["all"]) / everything - 1.0,
            everything / single,
        ))
    worst = 0.0
    print("wavelength_nm,albedo,worst_single,worst_all,mean_all,least_ratio,largest_ratio")
    for (wavelength, albedo), group in sorted(found.items()):
        values = np.array(group)
        errors = np.abs(values[:, 1])
        worst = max(worst, errors.max())
        print(f"{wavelength},{albedo},{np.abs(values[:, 0]).max():.2e},{errors.max():.2e},"
              f"{errors.mean():.2e},{values[:, 2].min():.3f},{values[:, 2].max():.3f}")
    return 1 if worst > LARGEST_DIFFERENCE else 0


if __name__ == "__main__":
    sys.exit(main())
