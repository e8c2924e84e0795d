#!/usr/bin/env python3
"""Light of lit surfaces against Mitsuba 3: the same mesh, albedo, sun and sky.

    python mitsuba_lit.py path/to/niji [--spp 512] [--variant scalar_rgb] [--curves]

Needs NumPy, OpenEXR and mitsuba 3.9. One wavelength (560 nm), clear air of molecules over black ground, the
sun 35 degrees high; meshes of albedo 0.5, metres large, seen from 15 m. Mitsuba gets the panorama of the same
air (`niji atmosphere --sky`) as its surroundings and the sun's irradiance at the ground as a directional
light, and paths of two lengths: `max_depth` 2 is direct light, 64 all light from surface to surface.

A convex mesh (a ball of flat faces) must have the direct light of Mitsuba to 1 % in the mean. Of all light on
the meshes the script prints how far ours is from the full paths, and fails where the AOV `error` does not
cover it in the mean of a mesh.

`--curves` prints what direct light costs: seconds and error of pictures four times as wide, by samples a pixel and by
tolerance. Both errors are RMS differences from Mitsuba's picture of `--spp` samples, over its mean, on the mesh; that
picture's own noise is printed. Seconds of Mitsuba are those of its renders of sun and of sky, without reading the scene; ours
are those of the whole command.
"""

import argparse
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import time

import mitsuba as mi
import numpy as np
import OpenEXR

ROOT = pathlib.Path(__file__).resolve().parents[2]

FOV_DEG, LOOK_DEG = 40.0, -21.0
SIZE, LARGE = (96, 64), (384, 256)
EYE = np.array([0.0, 6.0, 14.0])
SUN_DEG, SUN_AZIMUTH_DEG = 35.0, 150.0
WAVELENGTH_NM = 560
ALBEDO = 0.5
PANORAMA_PX = 720
# Of the mean light of a convex mesh.
MOST_BIAS = 0.01
# Of the curves.
SAMPLES = (1, 4, 16, 64)
TOLERANCES = (0.1, 0.03, 0.01, 0.003, 0.001)


def scene_text(size, accuracy):
    return f"""
format = 1
name = "peer"
[sun]
elevation_deg = {SUN_DEG}
azimuth_deg = {SUN_AZIMUTH_DEG}
[camera]
position_m = {EYE.tolist()}
azimuth_deg = 0.0
elevation_deg = {LOOK_DEG}
horizontal_fov_deg = {FOV_DEG}
width_px = {size[0]}
height_px = {size[1]}
[spectrum]
first_nm = {WAVELENGTH_NM}.0
step_nm = 10.0
n_wavelengths = 1
[drops]
shape = "uniform"
box_min_m = [-50.0, 0.0, 200.0]
box_max_m = [50.0, 50.0, 300.0]
number_density_m3 = 1.0
law = {{ monodisperse = {{ radius_um = 500.0 }} }}
voxel_m = 50.0
[air]
constituents = ["rayleigh"]
[ground]
albedo = 0.0
[occluders]
meshes = [{{ file = "mesh.obj", albedo = {ALBEDO} }}]
[effects]
lit_surfaces = "on"
sky = "on"
drop_shadow = "off"
[accuracy]
{accuracy}
"""


def run(*command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    # 5: a picture whose estimate is above its tolerance, which is what is looked at here.
    if done.returncode not in (0, 5):
        sys.exit(f"{' '.join(map(str, command))}\n{done.stderr}")
    return done.stdout


def timed(make):
    started = time.perf_counter()
    made = make()
    return made, time.perf_counter() - started


def ball():
    """Corners and triangles of a ball above the ground."""
    rings, sectors, radius = 48, 96, 3.0
    corners = [
        radius * np.array([math.sin(t) * math.cos(p), math.cos(t), math.sin(t) * math.sin(p)])
        for t in np.linspace(0, math.pi, rings + 1)
        for p in np.linspace(0, 2 * math.pi, sectors, endpoint=False)
    ]
    faces = []
    for ring in range(rings):
        for sector in range(sectors):
            a, b = ring * sectors + sector, ring * sectors + (sector + 1) % sectors
            if ring > 0:
                faces.append((a, b, a + sectors))
            if ring < rings - 1:
                faces.append((b, b + sectors, a + sectors))
    return np.array(corners) + [0, 3.2, 0], faces


def quads(*corners_of_each):
    """Corners and triangles of quadrilaterals."""
    firsts = range(0, 4 * len(corners_of_each), 4)
    faces = [(n, n + a, n + a + 1) for n in firsts for a in (1, 2)]
    return np.concatenate([np.array(corners, float) for corners in corners_of_each]), faces


def floor():
    """A level square just above the ground."""
    return quads([(-9, 0.01, -9), (-9, 0.01, 9), (9, 0.01, 9), (9, 0.01, -9)])


def corner():
    """Two walls that meet, on a floor; the sun stands in the open side."""
    return quads(
        [(-4, 0.01, -4), (-4, 0.01, 4), (4, 0.01, 4), (4, 0.01, -4)],
        [(-4, 0.01, -4), (4, 0.01, -4), (4, 5, -4), (-4, 5, -4)],
        [(-4, 0.01, 4), (-4, 0.01, -4), (-4, 5, -4), (-4, 5, 4)],
    )


def yard():
    """A floor within four walls, the nearest of them low."""
    return quads(
        [(-4, 0.01, -4), (-4, 0.01, 4), (4, 0.01, 4), (4, 0.01, -4)],
        [(-4, 0.01, -4), (4, 0.01, -4), (4, 5, -4), (-4, 5, -4)],
        [(-4, 0.01, 4), (-4, 0.01, -4), (-4, 3, -4), (-4, 3, 4)],
        [(4, 0.01, -4), (4, 0.01, 4), (4, 3, 4), (4, 3, -4)],
        [(4, 0.01, 4), (-4, 0.01, 4), (-4, 1, 4), (4, 1, 4)],
    )


def table():
    """A board that hovers over a floor."""
    return quads(
        [(-6, 0.01, -6), (-6, 0.01, 6), (6, 0.01, 6), (6, 0.01, -6)],
        [(-3, 2, -3), (-3, 2, 3), (3, 2, 3), (3, 2, -3)],
    )


def still_life():
    """The ball over a floor."""
    (corners, faces), (more, others) = ball(), floor()
    others = [tuple(index + len(corners) for index in face) for face in others]
    return np.concatenate([corners, more]), faces + others


def layers(path):
    """Channels of every part, by name or by number where it has none."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        found = {}
        for index, part in enumerate(file.parts):
            values = {name: np.float64(c.pixels) for name, c in part.channels.items()}
            found[index] = found[part.name()] = values
        return found


def spectral(found):
    return next(values for name, values in found.items() if re.fullmatch(r"S0\.[0-9,]+nm", name))


def ours(niji, folder, mesh, size=SIZE, accuracy='preset = "standard"'):
    """The layers of a picture of a mesh, and seconds of the command that made it."""
    corners, faces = mesh
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in corners]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces]
    (folder / "mesh.obj").write_text("\n".join(lines) + "\n")
    (folder / "scene.toml").write_text(scene_text(size, accuracy))
    command = (niji, "run", folder / "scene.toml", "-o", folder / "out", "--force", "-q")
    _, seconds = timed(lambda: run(*command))
    return layers(folder / "out/image.exr"), seconds


def gray(value):
    return {"type": "rgb", "value": [value] * 3}


def mitsuba_scene(mesh_file, panorama, sun, size=SIZE):
    elevation, look = math.radians(SUN_DEG), math.radians(LOOK_DEG)
    azimuth = math.radians(SUN_AZIMUTH_DEG)
    level = math.cos(elevation)
    from_sun = [-level * math.sin(azimuth), -math.sin(elevation), level * math.cos(azimuth)]
    towards = EYE + [0, math.sin(look), -math.cos(look)]
    bitmap = mi.Bitmap(np.repeat(panorama[..., None], 3, axis=2).astype(np.float32))
    # The middle of Mitsuba's map is +z; that of ours is north, -z.
    north = mi.ScalarTransform4f().rotate([0, 1, 0], 180)
    return {
        "type": "scene",
        "sensor": {
            "type": "perspective",
            "fov": FOV_DEG,
            "fov_axis": "x",
            "to_world": mi.ScalarTransform4f().look_at(EYE.tolist(), towards.tolist(), [0, 1, 0]),
            "film": {
                "type": "hdrfilm",
                "width": size[0],
                "height": size[1],
                "rfilter": {"type": "box"},
                "pixel_format": "luminance",
                "component_format": "float32",
            },
            "sampler": {"type": "independent"},
        },
        "sun": {"type": "directional", "direction": from_sun, "irradiance": gray(sun)},
        "sky": {"type": "envmap", "bitmap": bitmap, "to_world": north},
        "mesh": {
            "type": "obj",
            "filename": str(mesh_file),
            "face_normals": True,
            "bsdf": {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": gray(ALBEDO)}},
        },
    }


def sun_irradiance(niji):
    """Irradiance across the sunlight at the ground, mean of the bin of 10 nm [W m^-2 nm^-1]."""
    table = np.loadtxt(ROOT / "data/solar_irradiance_g173.csv", delimiter=",", skiprows=3)
    above = np.interp(np.linspace(WAVELENGTH_NM - 5, WAVELENGTH_NM + 5, 2001), *table.T).mean()
    zenith = 90 - SUN_DEG
    rays = ("--sun-zenith-deg", zenith, "--view-zenith-deg", zenith)
    bins = ("--wavelengths-nm", WAVELENGTH_NM, "--bin-nm", 10)
    head, row = run(niji, "eval", "air", *rays, *bins).strip().splitlines()[-2:]
    return above * float(dict(zip(head.split(","), row.split(",")))["sun_transmittance"])


def theirs(scene, max_depth, spp, seed=0):
    """Radiance of paths up to a length; sun and sky one by one, because a path samples one light a step."""
    path = {"type": "path", "max_depth": max_depth, "rr_depth": 100, "hide_emitters": True}
    scene = scene | {"integrator": path}
    radiance = 0.0
    for other in ("sun", "sky"):
        lights = mi.load_dict({key: part for key, part in scene.items() if key != other})
        radiance = radiance + np.float64(mi.render(lights, spp=spp, seed=seed))[..., 0]
    return radiance


def same_place(niji, folder, size=SIZE):
    """The scene of the picture that was made last in a folder, for Mitsuba."""
    sky = folder / "sky.exr"
    run(niji, "atmosphere", "--scene", folder / "scene.toml", "--sky", sky, "--width-px", PANORAMA_PX)
    panorama = spectral(layers(sky)[0])
    return mitsuba_scene(folder / "mesh.obj", panorama, sun_irradiance(niji), size)


def curves(name, mesh, arguments):
    """What direct light on a mesh costs."""
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        ours(arguments.niji, folder, mesh, LARGE)
        scene = same_place(arguments.niji, folder, LARGE)
        truth = theirs(scene, 2, arguments.spp)
        lit = truth > 0

        def error(picture, of=truth):
            return math.sqrt(np.mean((picture - of)[lit] ** 2)) / truth[lit].mean()

        # Two pictures of few samples differ by sqrt(2) times the noise of one, which falls with the root of their number.
        noise = error(theirs(scene, 2, SAMPLES[-1], 1), theirs(scene, 2, SAMPLES[-1], 2))
        noise *= math.sqrt(SAMPLES[-1] / arguments.spp / 2)
        print(f"{name}: {lit.sum()} pixels, the truth's own noise {noise:.2%}")
        for spp in SAMPLES:
            picture, seconds = timed(lambda: theirs(scene, 2, spp, 3))
            print(f"  mitsuba  {spp:>5} samples {seconds:8.2f} s, error {error(picture):.2%}")
        for tolerance in TOLERANCES:
            accuracy = f"tolerance = {tolerance}"
            parts, seconds = ours(arguments.niji, folder, mesh, LARGE, accuracy)
            is_lit = parts["lit_surfaces"]["Y"] > 0
            picture = np.where(is_lit, spectral(parts["spectral"]), 0.0)
            print(f"  niji     within {tolerance:5.1%} {seconds:8.2f} s, error {error(picture):.2%}")


def compare(name, mesh, is_convex, arguments):
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        parts, _ = ours(arguments.niji, folder, mesh)
        scene = same_place(arguments.niji, folder)
        direct, full = (theirs(scene, depth, arguments.spp) for depth in (2, 64))
    lit = parts["lit_surfaces"]["Y"] > 0
    # Radiance of a luminance, alike for all pixels of one wavelength.
    found = spectral(parts["spectral"])[lit]
    scale = found.sum() / parts["lit_surfaces"]["Y"][lit].sum()
    error, surfaces = (scale * parts["error"][key][lit] for key in ("Y", "surfaces"))
    direct, full = direct[lit], full[lit]
    mean = found.mean()
    of_direct, of_full = mean / direct.mean() - 1, mean / full.mean() - 1
    missed = np.abs(found - full)
    covered = np.mean(missed <= error + MOST_BIAS * full)
    print(f"{name}: our mean over Mitsuba's - 1: direct {of_direct:+.2%}, all paths {of_full:+.2%}")
    print(f"  missed {missed.mean() / mean:.2%} of the light, told {error.mean() / mean:.2%}", end=", ")
    print(f"of surfaces {surfaces.mean() / mean:.2%}", end="; ")
    print(f"of {lit.sum()} pixels covered to {MOST_BIAS:.0%}: {covered:.1%}")
    if is_convex and abs(of_direct) > MOST_BIAS:
        sys.exit("the two programs do not compute the same direct light")
    if abs(mean - full.mean()) > error.mean() + MOST_BIAS * mean:
        sys.exit("the told error does not cover the light that is not followed")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("niji", type=pathlib.Path)
    parser.add_argument("--spp", type=int, default=512)
    parser.add_argument("--variant", default="scalar_rgb")
    parser.add_argument("--curves", action="store_true")
    arguments = parser.parse_args()
    arguments.niji = arguments.niji.resolve()
    mi.set_variant(arguments.variant)
    if arguments.curves:
        curves("ball", ball(), arguments)
        curves("floor", floor(), arguments)
        return
    compare("ball", ball(), True, arguments)
    compare("floor", floor(), True, arguments)
    for mesh in (corner, yard, table, still_life):
        compare(mesh.__name__, mesh(), False, arguments)


if __name__ == "__main__":
    main()
