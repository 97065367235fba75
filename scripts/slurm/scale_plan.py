#!/usr/bin/python3
"""What a large sweep costs besides its trials, from constants measured here.

    scripts/slurm/scale_plan.py [--points N] [--trials N] [--range N] [--ranges N] [--surveymc PROGRAM] [--config CONFIG]

Sweeps CONFIG (configs/bench/msa_traj4.toml) over `noise.magnetometer_nT`, and measures, in processor seconds of this machine:
`check`, some ranges of points with 512 trials each, one point with many trials, the merge of those ranges, the sizes of parts and
result. The rest is arithmetic: the printed lines.
"""
import argparse
import pathlib
import re
import resource
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from surveymc import streams  # noqa: E402


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, default=100_000)
    parser.add_argument("--trials", type=int, default=100_000)
    parser.add_argument("--range", type=int, default=1000, help="points a task")
    parser.add_argument("--ranges", type=int, default=3, help="ranges that are run")
    parser.add_argument("--surveymc", default=str(ROOT / "build/surveymc"))
    parser.add_argument("--config", default=str(ROOT / "configs/bench/msa_traj4.toml"))
    args = parser.parse_args()

    def seconds(*command):
        """Processor seconds of a child, and the peak memory so far of all children, MB."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([args.surveymc, *map(str, command)], check=True, capture_output=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, after.ru_maxrss / 1024

    with tempfile.TemporaryDirectory(prefix="surveymc-scale-") as name:
        folder = pathlib.Path(name)
        text = pathlib.Path(args.config).read_text()
        survey = re.search(r'^file = "(.*)"', text, re.M)[1]
        text = text.replace(survey, str((pathlib.Path(args.config).parent / survey).resolve()))

        def sweep(points):
            path = folder / f"s{points}.toml"
            path.write_text(f'{text}\n[sweep]\n"noise.magnetometer_nT" = {{ from = 10.0, to = 100.0, count = {points} }}\n')
            return path

        whole, block = sweep(args.points), 512
        checked, _ = seconds("check", whole)
        spent = [seconds("run", whole, "--point", f"{i * args.range}:{(i + 1) * args.range}", "--trials", block, "--threads", 1,
                         "-o", f"{folder}/p/")[0] for i in range(args.ranges)]
        one, _ = seconds("run", whole, "--point", 17, "--trials", args.trials, "--threads", 1, "-o", folder / "one.part")
        part = (folder / "one.part").stat().st_size
        bytes_of_range = max(p.stat().st_size for p in (folder / "p").iterdir())
        merged = sweep(args.range * args.ranges)
        for i in range(args.ranges):
            seconds("run", merged, "--point", f"{i * args.range}:{(i + 1) * args.range}", "--trials", block, "--threads", 1, "-o",
                    f"{folder}/m/")
        merging, memory = seconds("merge", "-o", folder / "m.h5", folder / "m")
        result = (folder / "m.h5").stat().st_size

    a_trial = one / args.trials
    a_point = sum(spent) / args.ranges / args.range - block * a_trial
    a_merge = merging / (args.range * args.ranges)
    trials = args.points * args.trials * a_trial
    print(f"measured: check {checked:.2f} s; a point of {args.trials} trials {one:.3f} s; {args.ranges} ranges of {args.range} points x {block} "
          f"trials {sum(spent):.2f} s; a part {part / 1e3:.1f} kB, of a range {bytes_of_range / 1e6:.2f} MB; merge of "
          f"{args.range * args.ranges} points {merging:.2f} s, {memory:.0f} MB")
    print(f"trials            {trials / 3600:.2f} core hours")
    print(f"tasks besides     {args.points * a_point:.0f} s: {args.points * a_point / trials:.1%} of the trials")
    print(f"merge             {args.points * a_merge:.0f} s: {args.points * a_merge / trials:.1%} of the trials")
    print(f"part files        {-(-args.points // args.range)}, {args.points / args.range * bytes_of_range / 1e6:.0f} MB; "
          f"result {result / (args.range * args.ranges) * args.points / 1e6:.0f} MB")


if __name__ == "__main__":
    streams.run(main)
