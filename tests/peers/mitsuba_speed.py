#!/usr/bin/env python3
"""Time to equal error: this project's ray integral against Mitsuba 3 on the same two scenes.

    python mitsuba_speed.py path/to/niji [--spp 64] [--rounds 3]

Needs NumPy, OpenEXR and mitsuba 3.9 in the Python that runs it, OpenVDB's module in another (Debian:
python3-openvdb, --openvdb-python), and a libLLVM that Mitsuba loads (19 does; 15 aborts the process):
DRJIT_LIBLLVM_PATH=/usr/lib/x86_64-linux-gnu/libLLVM.so.19.1.

A camera of 640 x 480 pixels, 90 degrees across, looks at drops of 0.1 mm in 400 x 150 x 200 m, the sun
20 degrees high behind it; extinction without diffraction, one scattering, one wavelength (560 nm).
`homogeneous`: 24000 drops in a cubic metre. `grid_64`: as many in the mean, waves and holes on 64
nodes along the depth. Mitsuba gets llvm_ad_mono, volpath with max_depth = 2, a box filter, the same
nodes, and the phase function and albedo that `niji scatter --export mitsuba` writes, so that both
compute the same radiance: their means over blocks of 16 x 16 pixels must agree.

The error of Mitsuba is the RMS difference of two pictures with other seeds over sqrt(2); it falls as
1/sqrt(spp), so that its time to another error follows. Ours is that against 8 x 8 rays a pixel. The
time of Mitsuba is that of a second render of the same scene, without compilation; ours is the whole
stage `render`, with reading and writing.
"""

import argparse
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import time
from xml.etree import ElementTree

import mitsuba as mi
import numpy as np
import OpenEXR

ROOT = pathlib.Path(__file__).resolve().parents[2]

WIDTH, HEIGHT, FOV_DEG, ELEVATION_DEG = 640, 480, 90.0, 8.0
SUN_DEG = 20.0
WAVELENGTH_NM = 560
RADIUS_M = 1e-4
BOX_MIN, BOX_MAX = np.array([-200.0, 0.0, -260.0]), np.array([200.0, 150.0, -60.0])
DENSITY_M3 = 24000.0
VOXEL_M = {"homogeneous": 10.0, "grid_64": 200.0 / 64}
# Blocks of 16 x 16 pixels, over the mean: bias beyond Mitsuba's own noise.
MOST_BIAS = 0.01

SCENE = """
format = 1
name = "peer"
[sun]
elevation_deg = {sun}
azimuth_deg = 180.0
[camera]
position_m = [0.0, 2.0, 0.0]
azimuth_deg = 0.0
elevation_deg = {elevation}
horizontal_fov_deg = {fov}
width_px = {width}
height_px = {height}
[spectrum]
first_nm = {nm}.0
step_nm = 10.0
n_wavelengths = 1
[drops]
file = "drops.vdb"
[effects]
primary_bow = "on"
secondary_bow = "on"
higher_orders = "off"
drop_flattening = "off"
supernumeraries = "on"
sun_disc = "on"
size_spread = "off"
drop_extinction = "on"
drop_shadow = "on"
[accuracy]
preset = "standard"
pixel_footprint = {footprint}
"""

WRITE_VOLUME = """
import sys
import numpy, pyopenvdb
nodes, origin, voxel, radius, path = numpy.load(sys.argv[1]), *eval(sys.argv[2])
def grid(name, values):
    found = pyopenvdb.FloatGrid()
    found.copyFromArray(values)
    found.name, found.gridClass = name, pyopenvdb.GridClass.FOG_VOLUME
    found.transform = pyopenvdb.createLinearTransform(voxel)
    found.transform.translate(origin)
    return found
sizes = numpy.where(nodes > 0, radius, 0.0).astype(nodes.dtype)
pyopenvdb.write(path, grids=[grid("number_density", nodes), grid("effective_radius", sizes)])
"""


def densities(name):
    """Number density on the nodes (x, y, z), with a border of zeros, and the first node."""
    voxel = VOXEL_M[name]
    counts = np.round((BOX_MAX - BOX_MIN) / voxel).astype(int) + 1
    axes = [low + voxel * np.arange(count) for low, count in zip(BOX_MIN, counts)]
    x, y, z = np.meshgrid(*axes, indexing="ij")
    if name == "homogeneous":
        values = np.full(x.shape, DENSITY_M3)
    else:
        waves = 1 + 0.8 * np.sin(x / 23) * np.cos(z / 31) * np.cos(y / 17)
        hole = (x + 60) ** 2 + (y - 70) ** 2 + (z + 160) ** 2 < 40**2
        values = np.where(hole, 0.0, DENSITY_M3 * waves)
    return np.pad(values, 1).astype(np.float32), BOX_MIN - voxel


def run(*command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stderr}")
    return done.stdout


def ours(niji, folder, footprint):
    """Radiance and seconds of the stage that renders."""
    parts = {"sun": SUN_DEG, "elevation": ELEVATION_DEG, "fov": FOV_DEG, "nm": WAVELENGTH_NM}
    text = SCENE.format(**parts, width=WIDTH, height=HEIGHT, footprint=footprint)
    (folder / "scene.toml").write_text(text)
    out = folder / "out"
    # What is up to date would not be made again.
    (out / "image.exr").unlink(missing_ok=True)
    run(niji, "run", folder / "scene.toml", "-o", out, "--force", "-q")
    report = json.loads((out / "report.json").read_text())
    seconds = next(stage["seconds"] for stage in report["stages"] if stage["stage"] == "render")
    with OpenEXR.File(str(out / "image.exr"), separate_channels=True) as file:
        channels = file.channels()
        name = next(name for name in channels if re.fullmatch(r"S0\.[0-9,]+nm", name))
        return np.array(channels[name].pixels, dtype=np.float64), seconds


def phase(niji, folder):
    """Phase function and albedo of the table of the run."""
    path = folder / "phase.xml"
    run(niji, "scatter", "--table", folder / "out/scatter.exr", "--export", "mitsuba", "-o", path)
    albedo = float(re.search(r"<!-- \S+ nm: albedo (\S+) -->", path.read_text())[1])
    node = ElementTree.parse(path).getroot()[0]
    return {"type": "tabphase", "values": node[0].get("value")}, albedo


def mitsuba_scene(name, nodes, origin, phase_function, albedo):
    """The same scene for Mitsuba; its cells are centered on our nodes."""
    extinction = math.pi * RADIUS_M**2 * nodes
    voxel = VOXEL_M[name]
    low = origin - voxel / 2
    size = voxel * np.array(nodes.shape)
    to_box = mi.ScalarTransform4f().translate(low.tolist()).scale(size.tolist())
    volume = mi.VolumeGrid(np.ascontiguousarray(extinction.transpose(2, 1, 0))[..., None])
    medium = {
        "type": "heterogeneous",
        "albedo": albedo,
        "sigma_t": {"type": "gridvolume", "grid": volume, "to_world": to_box, "raw": True},
        "phase": phase_function,
    }
    shape = to_box
    if name == "homogeneous":
        # Half a voxel of the ramps on either side holds as much as their whole length.
        half = 0.5 * voxel
        size = BOX_MAX - BOX_MIN + 2 * half
        shape = mi.ScalarTransform4f().translate((BOX_MIN - half).tolist()).scale(size.tolist())
        sigma = math.pi * RADIUS_M**2 * DENSITY_M3
        medium = {
            "type": "homogeneous",
            "albedo": albedo,
            "sigma_t": sigma,
            "phase": phase_function,
        }
    unit = mi.ScalarTransform4f().translate([0.5] * 3).scale([0.5] * 3)
    elevation, sun = math.radians(ELEVATION_DEG), math.radians(SUN_DEG)
    eye = [0.0, 2.0, 0.0]
    towards = [0.0, 2.0 + math.sin(elevation), -math.cos(elevation)]
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "volpath", "max_depth": 2, "hide_emitters": True},
            "sensor": {
                "type": "perspective",
                "fov": FOV_DEG,
                "fov_axis": "x",
                "to_world": mi.ScalarTransform4f().look_at(eye, towards, [0, 1, 0]),
                "film": {
                    "type": "hdrfilm",
                    "width": WIDTH,
                    "height": HEIGHT,
                    "rfilter": {"type": "box"},
                    "pixel_format": "luminance",
                },
                "sampler": {"type": "independent"},
            },
            "sun": {
                "type": "directional",
                "direction": [0.0, -math.sin(sun), -math.cos(sun)],
                "irradiance": sun_irradiance(),
            },
            "drops": {
                "type": "cube",
                "to_world": shape @ unit,
                "bsdf": {"type": "null"},
                "interior": medium,
            },
        }
    )


def theirs(scene, spp, rounds):
    """Two pictures with other seeds, and the least time of one."""

    def render(seed):
        started = time.perf_counter()
        pixels = np.array(mi.render(scene, spp=spp, seed=seed), dtype=np.float64)
        return pixels.reshape(HEIGHT, WIDTH), time.perf_counter() - started

    render(0)
    pictures = [render(seed) for seed in range(1, max(rounds, 2) + 1)]
    return pictures[0][0], pictures[1][0], min(seconds for _, seconds in pictures)


def rms(values):
    return math.sqrt(np.mean(values**2))


def blocks(picture):
    return picture.reshape(HEIGHT // 16, 16, WIDTH // 16, 16).mean(axis=(1, 3))


def compare(name, arguments, folder):
    nodes, origin = densities(name)
    np.save(folder / "nodes.npy", nodes)
    settings = (origin.tolist(), VOXEL_M[name], RADIUS_M, str(folder / "drops.vdb"))
    run(arguments.openvdb_python, "-c", WRITE_VOLUME, folder / "nodes.npy", repr(settings))
    reference, _ = ours(arguments.niji, folder, '{ level = "grid", n = 8 }')
    found, seconds = ours(arguments.niji, folder, '"prefiltered"')
    for _ in range(arguments.rounds - 1):
        seconds = min(seconds, ours(arguments.niji, folder, '"prefiltered"')[1])
    error = rms(found - reference) / reference.mean()

    phase_function, albedo = phase(arguments.niji, folder)
    scene = mitsuba_scene(name, nodes, origin, phase_function, albedo)
    first, second, their_seconds = theirs(scene, arguments.spp, arguments.rounds)
    mean = (first + second) / 2
    their_error = rms(first - second) / math.sqrt(2) / reference.mean()
    bias = (mean.mean() - reference.mean()) / reference.mean()
    noise = their_error / math.sqrt(2 * mean.size)
    to_equal = their_seconds * (their_error / error) ** 2
    block_error = rms(blocks(mean) - blocks(reference)) / reference.mean()
    expected = their_error / math.sqrt(2) / 16
    print(f"{name}: mean of Mitsuba over ours - 1: {bias:+.2e} (its noise {noise:.1e})")
    print(f"  blocks of 16 x 16: RMS difference {block_error:.2e}, its noise {expected:.2e}")
    print(f"  niji     {seconds:8.3f} s, relative RMSE {error:.2e}")
    print(f"  mitsuba  {their_seconds:8.3f} s, relative RMSE {their_error:.2e} at {arguments.spp} spp")
    print(f"  time to equal error: {to_equal:.3g} s, ratio {to_equal / seconds:.2e}")
    if abs(bias) > MOST_BIAS + 4 * noise:
        sys.exit("the two programs do not compute the same picture")


def sun_irradiance():
    """E_sun above the air, mean of the bin of 10 nm [W m^-2 nm^-1]."""
    table = np.loadtxt(ROOT / "data/solar_irradiance_g173.csv", delimiter=",", skiprows=3)
    low, high = WAVELENGTH_NM - 5, WAVELENGTH_NM + 5
    fine = np.linspace(low, high, 2001)
    return np.interp(fine, *table.T).mean()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("niji", type=pathlib.Path)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--openvdb-python", default="/usr/bin/python3")
    arguments = parser.parse_args()
    arguments.niji = arguments.niji.resolve()
    mi.set_variant("llvm_ad_mono")
    for name in VOXEL_M:
        with tempfile.TemporaryDirectory() as folder:
            compare(name, arguments, pathlib.Path(folder))


if __name__ == "__main__":
    main()
