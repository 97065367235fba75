#!/usr/bin/python3
"""Reliability maps by vectorised numpy, beside surveymc, in turn on one core: points per second and the largest difference.

    numpy_reliability.py SURVEYMC [--rounds N]

The same work: 181 x 181 attitudes, SSE, redundancy number, minimal detectable error and the effects on I, tau, A of all
nine observations. numpy takes the form of the paper, X (9 x 6) and (X'PX)^-1 by batched inverse, 32,761 points at once in
blocks of 4096 (the fastest of 512 ... 32,761), the Jacobian analytic. surveymc is timed by its benchmark
reliability_map_181 if that is built, and as a whole process, start and file included. Both run in one thread, and both
write the same arrays into memory that is used again, after a first call that is not timed.
"""
import argparse
import os
import re
import subprocess
import sys
import tempfile
import time

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"

import h5py  # noqa: E402
import numpy as np  # noqa: E402

DEGREE = np.pi / 180
LAMBDA = 4.560637719029
G, B, DIP = 9.82, 51000.0, 75 * DEGREE
CONFIG = os.path.join(os.path.dirname(__file__), "../../../configs/bench/reliability_181.toml")


def reliability(inclination, toolface, azimuth):
    """r, nabla_0 and effects on (I, tau, A) in degrees: arrays (points, 9), (points, 9), (points, 9, 3)."""
    si, ci, st, ct = np.sin(inclination), np.cos(inclination), np.sin(toolface), np.cos(toolface)
    sa, ca, sd, cd = np.sin(azimuth), np.cos(azimuth), np.sin(DIP), np.cos(DIP)
    y = np.empty((si.size, 9))
    y[:, 0], y[:, 1], y[:, 2] = -si * st, -si * ct, ci
    east, north = cd * sa, cd * ci * ca - sd * si
    y[:, 3], y[:, 4], y[:, 5] = north * st + east * ct, north * ct - east * st, cd * si * ca + sd * ci
    x = np.zeros((si.size, 9, 6))  # relative units: g/G, b/B, dG/G, dB/B
    x[:, 0, 0], x[:, 1, 0], x[:, 2, 0] = -ci * st, -ci * ct, -si
    x[:, 0, 1], x[:, 1, 1] = -si * ct, si * st
    x[:, :3, 3] = y[:, :3]
    d_inc = -cd * si * ca - sd * ci
    x[:, 3, 0], x[:, 4, 0], x[:, 5, 0] = d_inc * st, d_inc * ct, north
    x[:, 3, 1], x[:, 4, 1] = y[:, 4], -y[:, 3]
    a_north, a_east = -cd * ci * sa, cd * ca
    x[:, 3, 2], x[:, 4, 2], x[:, 5, 2] = a_north * st + a_east * ct, a_north * ct - a_east * st, -cd * si * sa
    x[:, 3:6, 4] = y[:, 3:6]
    t_north, t_east = -sd * ci * ca - cd * si, -sd * sa
    x[:, 3, 5], x[:, 4, 5], x[:, 5, 5] = t_north * st + t_east * ct, t_north * ct - t_east * st, -sd * si * ca + cd * ci
    x[:, 6, 3] = x[:, 7, 4] = x[:, 8, 5] = 1
    bias = np.array([0.0039 / G] * 3 + [70 / B, 70 / B, np.hypot(150, 70) / B])
    noise = np.array([0.003 / G] * 3 + [70 / B] * 3)
    scale = np.array([5e-4] * 3 + [1.6e-3] * 3)
    v = np.empty((si.size, 9))
    v[:, :6] = bias**2 + noise**2 + (scale * y[:, :6]) ** 2
    v[:, 6:] = (0.003 / G) ** 2, (65 / B) ** 2, (0.12 * DEGREE) ** 2
    xp = x.transpose(0, 2, 1) / v[:, None, :]
    effect = np.linalg.inv(xp @ x) @ xp  # (points, 6, 9)
    r = 1 - np.einsum("pij,pji->pi", x, effect)
    r[r < 1e-10] = 0
    with np.errstate(divide="ignore", invalid="ignore"):
        nabla = LAMBDA * np.sqrt(v / r)
        external = (effect[:, :3, :] * nabla[:, None, :]).transpose(0, 2, 1) / DEGREE
    return r, nabla * np.array([G] * 3 + [B] * 3 + [G, B, 1 / DEGREE]), external


def grid():
    toolface, azimuth = np.meshgrid(np.arange(181.0), np.arange(181.0), indexing="ij")
    return np.full(toolface.size, 30.0) * DEGREE, toolface.ravel() * DEGREE, azimuth.ravel() * DEGREE


def by_numpy(angles, out, block=4096):
    for i in range(0, angles[0].size, block):
        for whole, part in zip(out, reliability(*(a[i:i + block] for a in angles))):
            whole[i:i + block] = part


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("surveymc")
    parser.add_argument("--rounds", type=int, default=5)
    arguments = parser.parse_args()
    bench = os.path.join(os.path.dirname(os.path.abspath(arguments.surveymc)), "tests/bench/surveymc_bench")
    numpy_rate, call_rate, process_rate = [], [], []
    angles = grid()
    points = angles[0].size
    r, nabla, external = out = np.empty((points, 9)), np.empty((points, 9)), np.empty((points, 9, 3))
    by_numpy(angles, out)  # both write into memory that is used again: the first call is not timed
    with tempfile.TemporaryDirectory() as folder:
        result = os.path.join(folder, "map.h5")
        for _ in range(arguments.rounds):
            start = time.process_time()
            by_numpy(angles, out)
            numpy_rate.append(points / (time.process_time() - start))
            start = time.perf_counter()
            subprocess.run([arguments.surveymc, "run", CONFIG, "-o", result, "--threads", "1"], check=True,
                           capture_output=True)
            process_rate.append(points / (time.perf_counter() - start))
            if os.path.exists(bench):
                text = subprocess.run([bench, "--benchmark_filter=reliability_map_181", "--benchmark_format=csv"],
                                      check=True, capture_output=True, text=True).stdout
                rate = re.search(r'"reliability_map_181",[^,]*,[^,]*,[^,]*,[^,]*,[^,]*,([^,]*),', text)
                call_rate.append(float(rate[1]))
        with h5py.File(result) as f:
            maps = {k: f["maps"][k][()].reshape(9, -1).T for k in
                    ("redundancy_number", "minimal_detectable_error", "external_azimuth_deg")}
    well = r > 1e-3  # elsewhere r of numpy is a difference of nearly equal numbers
    difference = max(np.max(np.abs(maps["redundancy_number"][well] / r[well] - 1)),
                     np.max(np.abs(maps["minimal_detectable_error"][well] / nabla[well] - 1)))
    print(f"largest relative difference of r and nabla_0 where r > 1e-3: {difference:.1e}")
    reference = np.median(numpy_rate)
    print(f"numpy {np.__version__}, points per CPU second: {reference:.3g}")
    for name, rates in (("surveymc, library call", call_rate), ("surveymc, whole process", process_rate)):
        if rates:
            print(f"{name}, points per second: {np.median(rates):.3g} = {np.median(rates) / reference:.0f} x numpy")
    return 0


if __name__ == "__main__":
    sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../scripts"))
    from surveymc import streams
    streams.run(main)
