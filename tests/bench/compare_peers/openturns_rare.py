#!/usr/bin/python3
"""Rare events by OpenTURNS (Debian's python3-openturns, installed if it is missing) beside surveymc, in turn on one core.

    openturns_rare.py SURVEYMC [--runs N] [--half-width W]

The six published functions of configs/rare_event/functions.toml. What it costs to know p to a 95 % interval of +- W
(.05), preparing included, and whether intervals hold the exact value:
  surveymc          [stop] relative_ci = W; one run a seed
  FORM              AbdoRackwitz, or Cobyla where its slope fails, from the mean value: one number, no interval
  FORM-IS           ImportanceSamplingExperiment about the FORM point until the coefficient of variation is W / 1.96
  subset            SubsetSampling, N = 1000: replicates, as many as their scatter needs for W; "own": the interval that a
                    single one gives
Evaluations are calls of the limit state; seconds are processor time, of surveymc with start and file. OpenTURNS' limit
states are its compiled symbolic functions. Coverage: of N seeds; a row whose interval does not hold says what was found.
"""
import argparse
import json
import math
import os
import resource
import subprocess
import sys
import tempfile
import time

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"

FUNCTIONS = {  # dimension, g, exact probability
    "rp77": (3, "if(4 + x3 <= 5, 10 + x1 / 2 - x2 - (4 + x3), 4 + x3 - x2)", 2.690844e-7),
    "rp107": (10, "5 * sqrt(10) - (" + " + ".join(f"x{i}" for i in range(1, 11)) + ")", 2.866516e-7),
    "rp111": (2, "12.5 - abs(x1 * x2)", 8.035086e-7),
    "rp110": (2, "min(if(x1 <= 3.5, 0.85 - 0.1 * x1, 4 - x1), if(x2 <= 2, 2.3 - x2, 0.5 - 0.1 * x2))", 3.195788e-5),
    "rp25": (2, "max(x1^2 - 8 * x2 + 16, -16 * x1 + x2 + 32)", 4.148566e-5),
    "four branches": (2, "min(min(3 + 0.1 * (x1 - x2)^2 - (x1 + x2) / sqrt(2), 3 + 0.1 * (x1 - x2)^2 + (x1 + x2) / "
                         "sqrt(2)), 7 / sqrt(2) - abs(x1 - x2))", 2.222795e-3),
}


def openturns():
    try:
        import openturns as ot
    except ImportError:
        print("openturns_rare: installing python3-openturns")
        as_root = [] if os.getuid() == 0 else ["sudo"]
        subprocess.run(as_root + ["apt-get", "install", "-y", "--no-install-recommends", "python3-openturns"], check=True,
                       stdout=subprocess.DEVNULL)
        import openturns as ot
    ot.Log.Show(ot.Log.NONE)
    ot.ResourceMap.SetAsUnsignedInteger("TBB-ThreadsNumber", 1)
    return ot


def event_of(ot, name):
    n, formula, _ = FUNCTIONS[name]
    g = ot.SymbolicFunction([f"x{i + 1}" for i in range(n)], [formula])
    vector = ot.RandomVector(ot.Normal(n))
    return g, ot.ThresholdEvent(ot.CompositeRandomVector(g, vector), ot.LessOrEqual(), 0.0)


def form(ot, name):
    """Design point in standard space, FORM's probability, evaluations."""
    g, event = event_of(ot, name)
    n = FUNCTIONS[name][0]
    for solver in (ot.AbdoRackwitz(), ot.Cobyla()):
        try:
            algorithm = ot.FORM(solver, event, [0.1] * n)
            before = g.getEvaluationCallsNumber() + 2 * n * g.getGradientCallsNumber()
            algorithm.run()
            result = algorithm.getResult()
            if result.getEventProbability() > 0.5 or abs(g(result.getPhysicalSpaceDesignPoint())[0]) > 0.1:
                continue
            calls = g.getEvaluationCallsNumber() + 2 * n * g.getGradientCallsNumber() - before
            return result.getStandardSpaceDesignPoint(), result.getEventProbability(), calls
        except Exception:  # no convergence: the next way
            continue
    return None, math.nan, 0


def importance(ot, name, point, half_width, seed):
    ot.RandomGenerator.SetSeed(seed)
    g, event = event_of(ot, name)
    instrumental = ot.Normal(point, ot.CovarianceMatrix(len(point)))
    algorithm = ot.ProbabilitySimulationAlgorithm(event, ot.ImportanceSamplingExperiment(instrumental))
    algorithm.setMaximumCoefficientOfVariation(half_width / 1.96)
    algorithm.setBlockSize(100)
    algorithm.setMaximumOuterSampling(2000)
    algorithm.run()
    result = algorithm.getResult()
    p, half = result.getProbabilityEstimate(), result.getConfidenceLength(0.95) / 2
    return p, half, g.getEvaluationCallsNumber()


def subset(ot, name, seed):
    ot.RandomGenerator.SetSeed(seed)
    g, event = event_of(ot, name)
    algorithm = ot.SubsetSampling(event)
    algorithm.setMaximumOuterSampling(1000)
    algorithm.setBlockSize(1)
    algorithm.run()
    result = algorithm.getResult()
    p, half = result.getProbabilityEstimate(), result.getConfidenceLength(0.95) / 2
    return p, half, g.getEvaluationCallsNumber()


def cpu():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def ours(program, name, half_width, seed, folder):
    config, out = os.path.join(folder, "c.toml"), os.path.join(folder, "r.h5")
    problem = "four_branch" if name == "four branches" else name
    with open(config, "w", encoding="utf-8") as text:
        text.write(f'experiment = "rare_event"\nseed = {seed}\n[stop]\nrelative_ci = {half_width}\nquantities = ["probability"]\n'
                   f'max_trials = 1000000\n[problem]\nname = "{problem}"\n[sampling]\nmethod = "importance"\n'
                   'subset = { replicates = 0 }\n')
    begin = cpu()
    subprocess.run([program, "run", config, "-o", out, "--overwrite", "--quiet", "--threads", "1"], check=True,
                   stdout=subprocess.DEVNULL)
    seconds = cpu() - begin

    def shown(table):
        done = subprocess.run([program, "show", out, table, "--json"], check=True, capture_output=True, text=True)
        return {c["name"]: c["values"][0] for c in json.loads(done.stdout)["columns"]}
    sampling, probability = shown("sampling"), shown("probability")
    holds = probability["monte_carlo_ci_low"] <= FUNCTIONS[name][2] <= probability["monte_carlo_ci_high"]
    return probability["monte_carlo"], holds, sampling["evaluations_preparing"] + sampling["evaluations"], seconds


def median(x):
    return sorted(x)[len(x) // 2]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("surveymc")
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--half-width", type=float, default=0.05)
    a = parser.parse_args()
    ot = openturns()
    print(f"OpenTURNS {ot.__version__}; p to +- {100 * a.half_width:g} % at 95 %, {a.runs} seeds; evaluations, seconds of "
          "processor time, coverage, median p / exact")
    with tempfile.TemporaryDirectory() as folder:
        for name, (_, _, exact) in FUNCTIONS.items():
            runs = [ours(a.surveymc, name, a.half_width, seed + 1, folder) for seed in range(a.runs)]
            print(f"{name}\n  surveymc   {median([r[2] for r in runs]):9.0f} {median([r[3] for r in runs]):8.3f} s  "
                  f"{sum(r[1] for r in runs)} of {a.runs}  {median([r[0] for r in runs]) / exact:.3f}", flush=True)
            begin = time.process_time()
            point, p, calls = form(ot, name)
            print("  FORM       no design point where g = 0" if point is None else
                  f"  FORM       {calls:9.0f} {time.process_time() - begin:8.3f} s  no interval  {p / exact:.3f}", flush=True)
            if point is not None:
                begin = time.process_time()
                found = [importance(ot, name, point, a.half_width, seed + 1) for seed in range(a.runs)]
                seconds = (time.process_time() - begin) / a.runs
                held = sum(abs(q - exact) <= half for q, half, _ in found)
                print(f"  FORM-IS    {calls + median([f[2] for f in found]):9.0f} {seconds:8.3f} s  {held} of {a.runs}  "
                      f"{median([f[0] for f in found]) / exact:.3f}", flush=True)
            begin = time.process_time()
            found = [subset(ot, name, seed + 1) for seed in range(a.runs)]
            seconds = (time.process_time() - begin) / a.runs
            held = sum(abs(q - exact) <= half for q, half, _ in found)
            mean = sum(f[0] for f in found) / a.runs
            relative = math.sqrt(sum((f[0] - mean) ** 2 for f in found) / (a.runs - 1)) / mean
            replicates = max(1, math.ceil((1.96 * relative / a.half_width) ** 2))
            each = sum(f[2] for f in found) / a.runs
            print(f"  subset     {each * replicates:9.0f} {seconds * replicates:8.3f} s  ({replicates} replicates of "
                  f"{each:.0f})  own intervals {held} of {a.runs}  {mean / exact:.3f}", flush=True)


if __name__ == "__main__":
    sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../scripts"))
    from surveymc import streams
    streams.run(main)
