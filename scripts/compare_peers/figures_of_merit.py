#!/usr/bin/python3
"""Time to a verdict: figures of merit of thesis test 4 (north, east, vertical), by surveymc and by a plain Ceres Monte Carlo.

    figures_of_merit.py SURVEYMC [--ceres-rate TRIALS_PER_SECOND] [--trials N]

The figure of merit of a quantity is 1 / (relative half width of its 95 % interval ^2 x processor seconds), from the table
`cost` of the result (surveymc show --cost). A plain Monte Carlo of n Gaussian draws knows a standard deviation with a
relative half width of 1.96 / sqrt(2 n), so that its figure of merit is 2 / 1.96^2 trials a second. Ceres' rate is that of
run.sh, 53 stations as in test 4, with normal equations by Cholesky: the 1.01e5 of docs/performance.md, or --ceres-rate.
"""
import argparse
import csv
import io
import os
import subprocess
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
CERES_RATE = 1.01e5  # docs/performance.md: normal equations by Cholesky
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


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("surveymc")
    parser.add_argument("--ceres-rate", type=float, default=CERES_RATE)
    parser.add_argument("--trials", type=int, default=100000)
    a = parser.parse_args()
    peer = 2 / 1.96**2 * a.ceres_rate
    found = costs(os.path.abspath(a.surveymc), a.trials)
    print(f"plain Monte Carlo by Ceres: {a.ceres_rate:.3g} trials/s, figure of merit of a standard deviation {peer:.3g} 1/s")
    print(f"{'':10} {'plain':>10} {'ratio':>8} {'control variate':>16} {'ratio':>8}")
    for d in DIRECTIONS:
        plain = found[("position", "joint", f"sigma3_{d}")]
        control = found[("control_variate", "", f"sigma3_{d}")]
        print(f"{d:10} {plain:10.3g} {plain / peer:8.1f} {control:16.3g} {control / peer:8.0f}")


if __name__ == "__main__":
    main()
