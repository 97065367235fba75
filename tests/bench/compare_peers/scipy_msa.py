#!/usr/bin/python3
"""Monte-Carlo MSA with SciPy, one trial after the other.

    scipy_msa.py CONFIG --runs N --seed S [--solver least_squares|leastsq]     prints one line of JSON
    scipy_msa.py CONFIG --geometry FILE                                        writes the input of ceres_msa

Both solvers are MINPACK's Levenberg-Marquardt (lmder) with the analytic Jacobian; `leastsq` is SciPy's older and
thinner door to it.
"""

import argparse
import json
import time

import numpy as np
import scipy
from scipy.optimize import least_squares, leastsq

from msa_case import Case, streams

EPS = 1.01 * np.finfo(float).eps  # the smallest tolerance SciPy allows: that criterion is off
BATCH = 64                        # trials whose noise is drawn in one call


class Trial:
    """Residuals and Jacobian of one trial at x = (p, q / total), fields in units of the total field:

        b = p m - q,  Bv = u.b,  Bh = sqrt(b.b - Bv^2),  r = (Bh - Bh_ref, Bv - Bv_ref) of all stations
        dBh/dp = n m,  dBh/dq = -n,  dBv/dp = u m,  dBv/dq = -u,  n = (b - Bv u) / Bh

    Station runs along the contiguous axis; buffers are used again; the rows of Bv are constant in a trial.
    """

    def __init__(self, case):
        n = case.stations
        self.n, self.down = n, case.down
        self.reference = np.repeat([case.bh / case.total, case.bv / case.total], n)
        self.transposed = np.empty((6, 2 * n))  # of the Jacobian
        self.jacobian_view = self.transposed.T
        self.dp_h, self.dq_h = self.transposed[:3, :n], self.transposed[3:, :n]
        self.dp_v = self.transposed[:3, n:]
        self.transposed[3:, n:] = -case.down
        self.v_rows = self.transposed[:, n:]
        self.values = np.empty(2 * n)
        self.h, self.v = self.values[:n], self.values[n:]

    def load(self, m):
        self.m = m
        self.evaluations = 0
        np.multiply(self.down, m, out=self.dp_v)

    def fields(self, x):
        """b, Bv, Bh: the last two are views of a buffer."""
        self.evaluations += 1
        b = self.m * x[:3, None]
        b -= x[3:, None]
        v = np.dot(x, self.v_rows, out=self.v)
        h = np.einsum("ij,ij->j", b, b, out=self.h)
        h -= v * v
        np.sqrt(h, out=h)
        return b, v, h

    def residuals(self, x):
        self.fields(x)
        return self.values - self.reference

    def jacobian(self, x):
        b, v, h = self.fields(x)
        b -= v * self.down
        b /= h
        np.multiply(b, self.m, out=self.dp_h)
        np.negative(b, out=self.dq_h)
        return self.jacobian_view


class Solver:
    """solve(m) -> (x, calls of residuals or Jacobian, converged) for readings m in units of the total field.

    MINPACK stops when its trust radius, twice the last step once that is trusted, is below xtol |x|; |x| is sqrt(3).
    With xtol as here no step is demanded that is shorter than max_i |dx_i| < step_tolerance would demand.
    The unknowns are of order one: x_scale 1 (with 'jac' it takes the same steps and a little longer).
    """

    START = np.array([1.0, 1, 1, 0, 0, 0])

    def __init__(self, case, name):
        self.trial = Trial(case)
        self.xtol = 2 * np.sqrt(6.0 / 3) * case.step_tolerance
        self.solve = {"least_squares": self.least_squares, "leastsq": self.leastsq}[name]

    def least_squares(self, m):
        self.trial.load(m)
        r = least_squares(self.trial.residuals, self.START, self.trial.jacobian, method="lm", xtol=self.xtol, ftol=EPS,
                          gtol=EPS, x_scale=1.0)
        return r.x, self.trial.evaluations, r.success

    def leastsq(self, m):
        self.trial.load(m)
        x, _, _, _, status = leastsq(self.trial.residuals, self.START, Dfun=self.trial.jacobian, full_output=True,
                                  xtol=self.xtol, ftol=EPS, gtol=EPS)
        return x, self.trial.evaluations, 1 <= status <= 4


def gains_and_biases(x, total):
    """g = 1 / p, bias = q / p (nT) from rows of x = (p, q / total)."""
    x = np.atleast_2d(x)
    return np.hstack([1 / x[:, :3], total * x[:, 3:] / x[:, :3]])


def monte_carlo(case, solver_name, runs, seed):
    """Statistics and times of `runs` trials, as a dict."""
    solver = Solver(case, solver_name)
    solve = solver.solve
    random = np.random.Generator(np.random.SFC64(seed))  # the fastest of numpy's; ziggurat normals
    clean, size = case.clean / case.total, case.noise / case.total
    found = np.empty((runs, 6))
    kept = evaluations = 0
    noise_seconds = 0.0
    start, cpu_start = time.perf_counter(), time.process_time()
    for first in range(0, runs, BATCH):
        before = time.perf_counter()
        readings = random.standard_normal((min(BATCH, runs - first), 3, case.stations))
        readings *= size
        readings += clean
        noise_seconds += time.perf_counter() - before
        for m in readings:
            x, n, converged = solve(m)
            evaluations += n
            if converged:
                found[kept] = x
                kept += 1
    estimates = gains_and_biases(found[:kept], case.total)
    mean, sd = estimates.mean(axis=0), estimates.std(axis=0, ddof=1)
    seconds, cpu_seconds = time.perf_counter() - start, time.process_time() - cpu_start
    kurtosis = np.mean(((estimates - mean) / sd) ** 4, axis=0)
    version = f"SciPy {scipy.__version__}, NumPy {np.__version__}"
    return {"peer": solver_name, "version": version, "runs": runs, "seconds": seconds, "cpu_seconds": cpu_seconds,
            "noise_seconds": noise_seconds, "failed": runs - kept, "evaluations": evaluations / runs,
            "mean": mean.tolist(), "sd": sd.tolist(), "kurtosis": kurtosis.tolist()}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("config")
    parser.add_argument("--runs", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--solver", choices=("least_squares", "leastsq"), default="least_squares")
    parser.add_argument("--geometry", metavar="FILE")
    a = parser.parse_args()
    case = Case(a.config)
    if a.geometry:
        case.write_geometry(a.geometry)
    else:
        print(json.dumps(monte_carlo(case, a.solver, a.runs, a.seed)))


if __name__ == "__main__":
    streams.run(main)
