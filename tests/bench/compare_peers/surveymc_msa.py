#!/usr/bin/python3
"""Runs surveymc and prints the same line of JSON as the peers.

    surveymc_msa.py PROGRAM CONFIG --threads T --runs N --seed S

The time is `elapsed_s` of the result file; CPU seconds are those of the whole process, start and writing included.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile

import h5py

from msa_case import PARAMETERS

NORMAL_QUANTILE = 1.959964  # of the 95 % intervals in the tables


def text(value):
    return value.decode() if isinstance(value, bytes) else str(value)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("config")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--runs", type=int, default=1000000)
    parser.add_argument("--seed", type=int, default=1)
    a = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "run.h5")
        done = subprocess.run([a.program, "run", a.config, "--threads", str(a.threads), "--trials", str(a.runs),
                               "--seed", str(a.seed), "-o", path], capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"surveymc_msa.py: {a.program} failed: {done.stderr.strip()}")
        with h5py.File(path, "r") as f:
            seconds = float(f["run"].attrs["elapsed_s"])
            table = {k: v[()] for k, v in f["tables/parameters"].items()}
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    row = {text(q): i for i, q in enumerate(table["quantity"])}
    failed = int(table["failed"][0])
    kept = a.runs - failed
    mean, sd, kurtosis = [], [], []
    for p in PARAMETERS:
        mean.append(float(table["monte_carlo"][row["mean_" + p]]))
        i = row["sigma3_" + p]
        sigma3 = float(table["monte_carlo"][i])
        error = float(table["monte_carlo_ci_high"][i] - table["monte_carlo_ci_low"][i]) / (2 * NORMAL_QUANTILE)
        sd.append(sigma3 / 3)
        kurtosis.append(1 + 4 * kept * (error / sigma3) ** 2)  # what the interval was made of
    version = subprocess.run([a.program, "--version"], capture_output=True, text=True).stdout.split("\n")[0]
    print(json.dumps({"peer": f"surveymc_{a.threads}", "version": version, "runs": a.runs, "seconds": seconds,
                      "cpu_seconds": used.ru_utime + used.ru_stime, "failed": failed, "mean": mean, "sd": sd,
                      "kurtosis": kurtosis}))


if __name__ == "__main__":
    sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../scripts"))
    from surveymc import streams
    streams.run(main)
