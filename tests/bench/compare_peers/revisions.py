#!/usr/bin/python3
"""Two programs in turn on the same configs: processor seconds of each, and their ratio beside its goal.

    revisions.py OLD NEW [--only NAME ...] [--rounds N] [--threads N] [--old-configs FOLDER] [--all [--limit SECONDS]]

OLD and NEW are surveymc programs, e.g. of another revision and of this one. Each work is run by both in turn, `--rounds`
times; the number is the median of user and system time, start, result file and threads included. Works with a goal
are those that once were slow.

With --all: every study that run_all.sh runs and --old-configs has (a folder of the other revision: both programs run
its configs, so that both do the same), with the ratio of the sums. Studies that one program refuses are left out and
named. Both run a config whole where OLD is expected to take at most --limit processor seconds by its run of a 64th of
the trials. Of others both run T / 2^k of the T trials, k the smallest that keeps OLD within the limit, and a quarter of
these; what a trial costs is the difference, what is left is fixed cost, and the whole is scaled from the two. Realisations
for calibration (OTHER_COUNTS) are fewer in the same proportion.
"""
import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import tomllib

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.abspath(os.path.join(HERE, "../../.."))
sys.path.insert(0, os.path.join(ROOT, "scripts"))

from surveymc import studies  # noqa: E402

# name: (config, further arguments, goal of the ratio or None)
WORKS = {
    "by_source": (None, [], 0.25),  # long_well_config()
    "two_outliers": ("configs/gross_error/two_outliers.toml", [], 0.039),
    "delay": ("configs/monitoring/delay.toml", [], 0.2),
    "sub_search": ("configs/chained/unstart.toml", [], 0.1),
}

OTHER_COUNTS = [("baselines", "calibration_trials")]


def long_well_config(folder, stations=10000):
    """Covariances by source of a made-up well of 12 km: build to horizontal, turn and go on."""
    with open(os.path.join(folder, "long_well.csv"), "w") as file:
        file.write("md_m,inclination_deg,azimuth_deg\n")
        for k in range(stations):
            md = 12000 * k / stations
            file.write(f"{md:.3f},{min(90, 0.03 * md):.4f},{(75 + 0.005 * md) % 360:.4f}\n")
    path = os.path.join(folder, "long_well.toml")
    with open(path, "w") as file:
        file.write('experiment = "position_covariance"\nseed = 1\n'
                   '[survey]\nfile = "long_well.csv"\nazimuth_reference = "true"\n'
                   "[field]\ntotal_nT = 50000.0\ndip_deg = 72.0\n"
                   '[error_model]\nname = "iscwsa_mwd_rev5.10"\n')
    return path


def processor_seconds(command):
    """User and system time of a command; None if it fails."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode not in (0, 1):  # 1: verdicts that are not as expected
        return None
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def compared(programs, rounds, threads):
    """Medians of the programs' times, each of (program, config, arguments), in turn."""
    times = [[] for _ in programs]
    with tempfile.TemporaryDirectory() as folder:
        for r in range(rounds):
            for i, (program, config, arguments) in enumerate(programs):
                output = os.path.join(folder, f"{i}_{r}.h5")
                seconds = processor_seconds([program, "run", config, "--threads", str(threads), "-o", output, *arguments])
                if seconds is None:
                    return None
                os.remove(output)
                times[i].append(seconds)
    return [statistics.median(t) for t in times]


def whole_study(programs, config, limit, rounds, threads):
    """([seconds of each program for all trials of the config], how they were found); None if one of them refuses it."""
    with open(config, "rb") as file:
        settings = tomllib.load(file)
    trials = settings.get("trials", 0)

    def fewer(part):
        arguments = ["--trials", str(part)]
        for table, key in OTHER_COUNTS:
            if key in settings.get(table, {}):
                arguments += ["--set", f"{table}.{key}={max(1, settings[table][key] * part // trials)}"]
        return arguments if part < trials else []

    def run(part, turns):
        return compared([(p, config, fewer(part)) for p in programs], turns, threads)

    part = trials
    if trials >= 128:
        probe = compared([(programs[0], config, fewer(trials // 64))], 1, threads)
        if probe is None:
            return None
        while part > trials // 32 and probe[0] * 64 * part / trials > limit:
            part //= 2
    if part == trials:
        found = run(trials, 1)
        if found and rounds > 1 and found[0] < limit / 4:
            found = run(trials, rounds)
        return found and (found, "whole")
    many, few = run(part, rounds), run(part // 4, rounds)
    if many is None or few is None:
        return None
    each = [(m - f) / (part - part // 4) for m, f in zip(many, few)]
    return [m + e * (trials - part) for m, e in zip(many, each)], f"{part} of {trials} trials"


def row(name, found, note):
    print(f"{name:40} {found[0]:9.2f} {found[1]:9.2f} {found[1] / max(found[0], 1e-9):8.3f} {note}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("--only", action="append", default=[], metavar="NAME")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--old-configs", default=os.path.join(ROOT, "configs"))
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--limit", type=float, default=20, metavar="SECONDS")
    a = parser.parse_args()
    print(f"{'work':40} {'old, s':>9} {'new, s':>9} {'ratio':>8} {'how' if a.all else 'goal'}")
    if a.all:
        sums, left = [0.0, 0.0], []
        for config in studies.configs():
            name = config.removeprefix("configs/")
            old = os.path.join(a.old_configs, name)
            if a.only and not any(n in name for n in a.only):
                continue
            found = os.path.exists(old) and whole_study((a.old, a.new), old, a.limit, a.rounds, a.threads)
            if not found:
                left.append(name)
                continue
            sums = [s + f for s, f in zip(sums, found[0])]
            row(name.removesuffix(".toml"), *found)
        row("all", sums, "goal: 0.4")
        print("left out, as one of the programs has no such study:", ", ".join(left) or "none")
        return
    with tempfile.TemporaryDirectory() as folder:
        well = long_well_config(folder)
        for name, (config, arguments, goal) in WORKS.items():
            if a.only and name not in a.only:
                continue
            old, new = well, well
            if config:
                old = os.path.join(a.old_configs, config.removeprefix("configs/"))
                new = os.path.join(ROOT, config)
            found = compared([(a.old, old, arguments), (a.new, new, arguments)], a.rounds, a.threads)
            if found is None:
                print(f"{name:40} one of the programs refuses {config or well}")
            else:
                row(name, found, "" if goal is None else goal)


if __name__ == "__main__":
    sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../scripts"))
    from surveymc import streams
    streams.run(main)
