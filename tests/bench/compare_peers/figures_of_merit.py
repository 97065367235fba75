#!/usr/bin/python3
"""Time to a verdict: figures of merit of thesis test 4 (north, east, vertical), by surveymc and by a plain Ceres Monte Carlo.

    figures_of_merit.py SURVEYMC [--rounds N] [--trials N] [--ceres PROGRAM | --ceres-rate TRIALS_PER_SECOND]

The figure of merit of a quantity is 1 / (relative half width of its 95 % interval ^2 x processor seconds), from the table
`cost` of the result (surveymc show --cost). A plain Monte Carlo of n Gaussian draws knows a standard deviation with a
relative half width of 1.96 / sqrt(2 n), so that its figure of merit is 2 / 1.96^2 trials per processor second. Both programs
run in turn, `--rounds` times, on the 53 stations of test 4; numbers are medians. Ceres (normal equations by Cholesky) is the
program that run.sh builds in build/compare_peers; without it a rate can be given.
"""
import argparse
import csv
import io
import json
import os
import statistics
import subprocess
import sys
import tempfile

ROOT = os.path.abspath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../.."))
HERE = os.path.dirname(os.path.abspath(__file__))
CERES = os.path.join(ROOT, "build/compare_peers/ceres_msa")
CERES_RUNS = 20000
DIRECTIONS = ("north", "east", "vertical")


def costs(program, trials):
    """{(table, formulation, quantity): figure of merit} of thesis test 4 on one thread."""
    with tempfile.TemporaryDirectory() as folder:
        output = os.path.join(folder, "test4.h5")
        subprocess.run([program, "run", os.path.join(ROOT, "configs/thesis/test4.toml"), "--threads", "1", "--quiet",
                        "--trials", str(trials), "-o", output], check=True)
        text = subprocess.run([program, "show", "--cost", "--csv", output], check=True, capture_output=True, text=True).stdout
    rows = csv.DictReader(io.StringIO("\n".join(line for line in text.splitlines() if not line.startswith("#"))))
    return {(r["table"], r["formulation"], r["quantity"]): float(next(v for k, v in r.items() if k.startswith("figure_of_merit")))
            for r in rows}


def ceres_rate(ceres, seed):
    """Trials a processor second of a plain Monte Carlo, noise included."""
    with tempfile.TemporaryDirectory() as folder:
        geometry = os.path.join(folder, "geometry.txt")
        subprocess.run([sys.executable, os.path.join(HERE, "scipy_msa.py"), os.path.join(ROOT, "configs/bench/msa_traj4.toml"),
                        "--geometry", geometry], check=True, stdout=subprocess.DEVNULL)
        text = subprocess.run([ceres, geometry, "normal_cholesky", "--runs", str(CERES_RUNS), "--seed", str(seed)], check=True,
                              capture_output=True, text=True).stdout
    found = json.loads(text)
    return found["runs"] / found["cpu_seconds"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("surveymc")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--trials", type=int, default=100000)
    parser.add_argument("--ceres", default=CERES)
    parser.add_argument("--ceres-rate", type=float)
    a = parser.parse_args()
    if not a.ceres_rate and not os.path.exists(a.ceres):
        sys.exit(f"figures_of_merit.py: {a.ceres}: is not there: run tests/bench/compare_peers/run.sh first, or give --ceres-rate")
    ours, rates = [], []
    for seed in range(a.rounds):
        ours.append(costs(os.path.abspath(a.surveymc), a.trials))
        rates.append(a.ceres_rate or ceres_rate(a.ceres, 1 + seed))
    found = {key: statistics.median(o[key] for o in ours) for key in ours[0]}
    rate = statistics.median(rates)
    peer = 2 / 1.96**2 * rate
    print(f"plain Monte Carlo by Ceres: {rate:.3g} trials per processor second, figure of merit of a standard deviation "
          f"{peer:.3g} 1/s")
    print(f"{'':10} {'plain':>10} {'ratio':>8} {'control variate':>16} {'ratio':>8}")
    for d in DIRECTIONS:
        plain = found[("position", "joint", f"sigma3_{d}")]
        control = found[("control_variate", "", f"sigma3_{d}")]
        print(f"{d:10} {plain:10.3g} {plain / peer:8.1f} {control:16.3g} {control / peer:8.0f}")


if __name__ == "__main__":
    sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../scripts"))
    from surveymc import streams
    streams.run(main)
