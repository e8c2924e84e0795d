"""Lorenz-Mie sums against other programs: time and error in one run.

    cargo build --release -p niji-mie --example whole-job
    pip install mpmath gmpy2 lxmie miepython numba
    python tests/peers/mie_speed.py target/release/examples/whole-job

A job is one sphere of m = 1.333, coefficients included: S1 and S2 at N angles equally spaced from 0
to 180 degrees, in one thread. The programs take turns, and the shortest of their times counts. The
ratio is the time of the faster of the other programs over the time of ours. The error is the
largest relative one of p11 at the angles below, against arbitrary precision
(crates/mie/tests/spheres/reference.py). A program that is not installed is left out.

lxmie takes the cosine of the angle, and so does miepython, whose first call compiles it.
"""
import os

for variable in ("OMP_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[variable] = "1"
os.environ["MIEPYTHON_USE_JIT"] = "1"

import argparse
import pathlib
import subprocess
import sys
import time

import mpmath as mp
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "crates/mie/tests/spheres"))
import reference

M = 1.333
CASES = [(1e3, 1801), (1e4, 1801), (2e4, 1801), (1e4, 18001)]
# Of 1800 steps: the poles, their surroundings, and some between.
REFERENCE_STEPS = [0, 1, 10, 300, 900, 1200, 1291, 1380, 1500, 1790, 1799, 1800]
CALLS_IN_A_ROUND = 3


def reference_p11(x):
    """p11 at the reference angles in arbitrary precision."""
    mp.mp.dps = reference.digits(x, complex(M))
    a, b = reference.mie(mp.mpf(x), mp.mpc(M, 0))
    _, q_sca, _ = reference.efficiencies(mp.mpf(x), a, b)
    values = []
    for step in REFERENCE_STEPS:
        s1, s2 = reference.amplitudes(a, b, 180.0 * step / 1800)
        values.append(2 * (abs(s1) ** 2 + abs(s2) ** 2) / (mp.mpf(x) ** 2 * q_sca))
    return values


def p11(x, s1, s2, q_sca):
    return 2 * (abs(s1) ** 2 + abs(s2) ** 2) / (x**2 * q_sca)


def timed(job):
    start = time.perf_counter()
    result = job()
    return time.perf_counter() - start, result


def lxmie_job(x, degrees, indices):
    import lxmie

    cosines = np.cos(np.radians(degrees))
    seconds, (q, s1, s2) = timed(lambda: lxmie.mie_amplitudes(M, 0.0, x, cosines))
    return {"lxmie": (seconds, [p11(x, s1[i], s2[i], q.q_sca) for i in indices])}


def miepython_job(x, degrees, indices):
    import miepython

    cosines = np.cos(np.radians(degrees))
    seconds, (s1, s2) = timed(lambda: miepython.S1_S2(M, x, cosines, norm="wiscombe"))
    q_sca = miepython.efficiencies_mx(M, x)[1]
    return {"miepython": (seconds, [p11(x, s1[i], s2[i], q_sca) for i in indices])}


def our_job(program):
    def run(x, degrees, indices):
        arguments = [program, repr(x), str(len(degrees)), str(CALLS_IN_A_ROUND), *map(str, indices)]
        lines = subprocess.run(arguments, check=True, capture_output=True, text=True).stdout
        results = {}
        for line in lines.splitlines():
            name, seconds, *values = line.split(",")
            results[f"niji, {name}"] = (float(seconds), [float(value) for value in values])
        return results

    return run


def installed(jobs):
    found = []
    for name, job in jobs:
        try:
            job(10.0, np.array([0.0, 90.0]), [0])  # Also compiles miepython.
            found.append(job)
        except ImportError:
            print(f"{name} is not installed")
    return found


def measure(jobs, x, n_angles, n_rounds):
    degrees = 180.0 * np.arange(n_angles) / (n_angles - 1)
    indices = [step * (n_angles - 1) // 1800 for step in REFERENCE_STEPS]
    best = {}
    for _ in range(n_rounds):
        for job in jobs:
            for name, (seconds, values) in job(x, degrees, indices).items():
                best[name] = (min(seconds, best.get(name, (seconds,))[0]), values)
    return best


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", help="the built example whole-job of crates/mie")
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    peers = installed([("lxmie", lxmie_job), ("miepython", miepython_job)])
    references = {x: reference_p11(x) for x in sorted({x for x, _ in CASES})}
    print("| x | angles | program | time, ms | ratio | error of p11 |\n|---|---|---|---|---|---|")
    for x, n_angles in CASES:
        best = measure([*peers, our_job(options.program)], x, n_angles, options.rounds)
        peer_times = [seconds for name, (seconds, _) in best.items() if not name.startswith("niji")]
        for name, (seconds, values) in best.items():
            error = max(float(abs(v / r - 1)) for v, r in zip(values, references[x]))
            ratio = f"{min(peer_times) / seconds:.1f}" if peer_times else "-"
            cells = (f"{x:g}", n_angles, name, f"{1e3 * seconds:.2f}", ratio, f"{error:.1e}")
            print("|", " | ".join(map(str, cells)), "|", flush=True)


if __name__ == "__main__":
    main()
