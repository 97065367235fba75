#!/usr/bin/python3
"""Processor time of a trial against the noise level: thesis tests 1 to 4 by every estimator, and the bench config.

    noise_scales.py SURVEYMC [SURVEYMC ...] [--only NAME ...] [--trials N] [--rounds N]

Sweeps over noise.scale are the main job, and a trial at less noise must not cost more. Each line is a work, its columns
are values of noise.scale from 1 down, its values the least user time of `--rounds` runs of one thread over that of the
first program at noise.scale 1; the seconds of that run stand in front. Several programs (of other revisions) run in
turn. Start and result file are in the times; `--trials` (of msa; an eighth of it of the others, which take longer) makes
them small.
"""
import argparse
import os
import resource
import subprocess
import sys
import tempfile

ROOT = os.path.abspath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../.."))
SCALES = [1.0, 0.9, 0.7, 0.5, 0.3, 0.1, 0.03, 0.01]
ESTIMATORS = ["msa", "msa_weighted", "msa_joint", "wls", "wls_consider"]


def works(trials):
    """{name: arguments of `run`}"""
    found = {"bench": ["configs/bench/msa_traj4.toml", "--point", "0", "--trials", str(trials)]}
    for estimator in ESTIMATORS:
        for test in range(4):
            found[f"test {test + 1}, {estimator}"] = [
                "configs/thesis/table5.toml", "--point", str(test), "--set", f"estimator.name={estimator}",
                "--trials", str(trials if estimator == "msa" else trials // 8)]
    return found


def user_seconds(program, arguments, scale):
    with tempfile.TemporaryDirectory() as folder:
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        done = subprocess.run([program, "run", *arguments, "--set", f"noise.scale={scale}", "--threads", "1", "-q",
                               "-o", os.path.join(folder, "result.part")], cwd=ROOT, capture_output=True, text=True)
        if done.returncode not in (0, 1):  # 1: verdicts that are not as expected
            sys.exit(done.stderr)
        return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("programs", nargs="+", type=os.path.abspath, metavar="SURVEYMC")
    parser.add_argument("--only", action="append", default=[], metavar="NAME")
    parser.add_argument("--trials", type=int, default=400000)
    parser.add_argument("--rounds", type=int, default=3)
    a = parser.parse_args()
    print(f"{'work':24}{'s':>7}", *(f"{s:6g}" for s in SCALES))
    for name, arguments in works(a.trials).items():
        if a.only and not any(n in name for n in a.only):
            continue
        least = {}
        for _ in range(a.rounds):
            for scale in SCALES:
                for i in range(len(a.programs)):
                    seconds = user_seconds(a.programs[i], arguments, scale)
                    least[i, scale] = min(least.get((i, scale), seconds), seconds)
        for i in range(len(a.programs)):
            print(f"{name if i == 0 else '':24}{least[i, 1.0]:7.2f}",
                  *(f"{least[i, s] / least[0, 1.0]:6.2f}" for s in SCALES), flush=True)


if __name__ == "__main__":
    sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../scripts"))
    from surveymc import streams
    streams.run(main)
