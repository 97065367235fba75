#!/usr/bin/python3
"""Two programs in turn on the same configs: processor seconds of each, and their ratio beside its goal.

    revisions.py OLD NEW [--only NAME ...] [--rounds N] [--threads N] [--old-configs FOLDER] [--all]

OLD and NEW are surveymc programs, e.g. of another revision and of this one. Each work is run by both in turn, `--rounds`
times; the number is the median of user and system time, start, result file and threads included. Works are those of the
table of goals in docs/performance.md; with --all every study of configs/ that run_all.sh runs (of --old-configs those of
the same name), with the ratio of the sums. A config that OLD refuses is left out and named.
"""
import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
sys.path.insert(0, os.path.dirname(HERE))

import studies  # noqa: E402

# name: (config, further arguments, goal of the ratio or None)
WORKS = {
    "by_source": (None, [], 0.25),  # long_well_config()
    "two_outliers": ("configs/gross_error/two_outliers.toml", [], 0.039),
    "delay": ("configs/monitoring/delay.toml", [], 0.2),
    "sub_search": ("configs/chained/unstart.toml", [], 0.1),
}


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


def row(name, found, goal):
    print(f"{name:40} {found[0]:9.2f} {found[1]:9.2f} {found[1] / found[0]:8.3f} {'' if goal is None else goal:>6}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("--only", action="append", default=[], metavar="NAME")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--old-configs", default=os.path.join(ROOT, "configs"))
    parser.add_argument("--all", action="store_true")
    a = parser.parse_args()
    print(f"{'work':40} {'old, s':>9} {'new, s':>9} {'ratio':>8} {'goal':>6}")
    if a.all:
        sums, left = [0.0, 0.0], []
        for config in studies.configs():
            name = config.removeprefix("configs/")
            old = os.path.join(a.old_configs, name)
            if a.only and not any(n in name for n in a.only):
                continue
            found = None
            if os.path.exists(old):
                found = compared([(a.old, old, []), (a.new, os.path.join(ROOT, config), [])], a.rounds, a.threads)
            if found is None:
                left.append(name)
                continue
            sums = [s + f for s, f in zip(sums, found)]
            row(name.removesuffix(".toml"), found, None)
        row("all", sums, 0.4)
        print("left out, as the old program has no such study:", ", ".join(left) or "none")
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
                row(name, found, goal)


if __name__ == "__main__":
    main()
