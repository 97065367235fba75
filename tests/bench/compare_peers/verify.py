#!/usr/bin/python3
"""Do all programs find the same minimum on the same readings?

    verify.py CONFIG --surveymc PROGRAM --ceres PROGRAM [--trials N]

Makes the readings of trials 0 .. N-1 from the documented random numbers (docs/conventions.md; first the published
known answers of Philox), solves them with every peer to a step of 1e-9, and holds the estimates against what surveymc
prints for these trials: gains to 1e-6, biases to 1e-6 of the total field. For information also how far from the
minimum each peer stops at the tolerance of the config. Exit code 1 if anything is further off.
"""

import argparse
import copy
import os
import subprocess
import sys
import tempfile

import numpy as np

import scipy_msa
from msa_case import PARAMETERS, Case, philox4x32

TOLERANCE = 1e-6
TIGHT_STEP = 1e-9
CERES_SOLVERS = ("normal_cholesky", "qr", "tiny")
SCIPY_SOLVERS = ("least_squares", "leastsq")

# Random123, kat_vectors: counter, key, answer of philox4x32-10
KNOWN_ANSWERS = (
    ("00000000 00000000 00000000 00000000", "00000000 00000000", "6627e8d5 e169c58d bc57ac4c 9b00dbd8"),
    ("ffffffff ffffffff ffffffff ffffffff", "ffffffff ffffffff", "408f276d 41c83b0e a20bc7c6 6d5451fd"),
    ("243f6a88 85a308d3 13198a2e 03707344", "a4093822 299f31d0", "d16cfe09 94fdcceb 5001e420 24126ea1"),
)


def check_philox():
    for counter, key, answer in KNOWN_ANSWERS:
        words = philox4x32(*([int(w, 16) for w in s.split()] for s in (counter, key)))
        if [int(w) for w in words] != [int(w, 16) for w in answer.split()]:
            sys.exit("verify.py: philox4x32 does not give its published answers")


def from_surveymc(program, config, trial):
    text = subprocess.run([program, "run", config, "--trial", str(trial)], capture_output=True, text=True,
                          check=True).stdout
    if "converged" not in text or "not converged" in text:
        sys.exit(f"verify.py: trial {trial} of surveymc did not converge")
    found = {w[0]: float(w[1]) for w in (line.split() for line in text.splitlines()) if w and w[0] in PARAMETERS}
    return [found[p] for p in PARAMETERS]


def from_scipy(case, solver, readings):
    solver = scipy_msa.Solver(case, solver)
    x = []
    for m in readings:
        solution, _, converged = solver.solve(m / case.total)
        x.append(solution if converged else np.full(6, np.nan))
    return scipy_msa.gains_and_biases(x, case.total)


def from_ceres(program, case, solver, readings):
    with tempfile.TemporaryDirectory() as folder:
        geometry, given = os.path.join(folder, "geometry"), os.path.join(folder, "readings")
        case.write_geometry(geometry)
        np.savetxt(given, [m.ravel() for m in readings], fmt="%.17g")
        text = subprocess.run([program, geometry, solver, "--readings", given], capture_output=True, text=True,
                              check=True).stdout
    return np.array([[float(w) for w in line.split()] for line in text.splitlines()])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("config")
    parser.add_argument("--surveymc", required=True)
    parser.add_argument("--ceres", required=True)
    parser.add_argument("--trials", type=int, default=8)
    a = parser.parse_args()
    check_philox()
    case = Case(a.config)
    tight = copy.copy(case)
    tight.step_tolerance = TIGHT_STEP
    trials = range(a.trials)
    readings = [case.readings(t) for t in trials]
    ours = np.array([from_surveymc(a.surveymc, a.config, t) for t in trials])
    scale = np.array([1, 1, 1, case.total, case.total, case.total])

    def off(other):
        return np.max(np.abs(other - ours) / scale)  # NaN stays NaN

    print(f"same readings, trials 0 .. {a.trials - 1}: largest difference from surveymc's estimates, in units of 1"
          " and of the total field")
    print(f"{'peer':<22} {'step < %g' % TIGHT_STEP:>12} {'step < %g' % case.step_tolerance:>12}")
    good = True
    for name, solve in ([(f"Ceres {s}", lambda c, s=s: from_ceres(a.ceres, c, s, readings)) for s in CERES_SOLVERS] +
                        [(f"SciPy {s}", lambda c, s=s: from_scipy(c, s, readings)) for s in SCIPY_SOLVERS]):
        difference = off(solve(tight))
        same = bool(difference <= TOLERANCE)
        good = good and same
        print(f"{name:<22} {difference:12.1e} {off(solve(case)):12.1e}{'' if same else '   NOT THE SAME MINIMUM'}")
    if not good:
        sys.exit(f"verify.py: the peers differ by more than {TOLERANCE:g}")


if __name__ == "__main__":
    sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../scripts"))
    from surveymc import streams
    streams.run(main)
