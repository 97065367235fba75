#!/usr/bin/python3
"""What a sweep of 10,000 points x 1e6 trials on 1,000 cores costs, from constants measured here.

    scripts/slurm/scale_plan.py [--points N] [--trials N] [--cores N] [--group N] [--surveymc PROGRAM] [--config CONFIG]

Makes sweeps of CONFIG (configs/bench/msa_traj4.toml) over `noise.magnetometer_nT`, and measures, in processor seconds of
this machine: reading a sweep of N points (every `run --point` does it), preparing and running a point, the size of a part and of a journal
record, merging 100, 200 and 400 real parts. The rest is arithmetic: the printed formulas. Takes about a minute.
"""
import argparse
import pathlib
import re
import resource
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--points", type=int, default=10_000)
parser.add_argument("--trials", type=int, default=1_000_000)
parser.add_argument("--cores", type=int, default=1000)
parser.add_argument("--group", type=int, default=10, help="points a task")
parser.add_argument("--surveymc", default=str(ROOT / "build/surveymc"))
parser.add_argument("--config", default=str(ROOT / "configs/bench/msa_traj4.toml"))
args = parser.parse_args()


def seconds(*command):
    """Processor seconds of a child and its peak memory so far of all children, MB."""
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
        values = ", ".join(f"{1 + 0.01 * i:.2f}" for i in range(points))
        path.write_text(text + f'\n[sweep]\n"noise.magnetometer_nT" = [{values}]\n')
        return path

    # A journal record in a large sweep, from a run that ends before it is done
    one = sweep(args.points)
    reading, _ = seconds("plan", one, "--count", "--trials", args.trials)
    whole, _ = seconds("run", one, "--point", 3, "--trials", args.trials, "--threads", 1, "-o", folder / "a.part")
    part_bytes = (folder / "a.part").stat().st_size
    compute = max(whole - reading, 0.0)
    done = subprocess.run([args.surveymc, "run", sweep(1), "-o", folder / "j.h5", "--trials", str(10**10), "--threads", "1",
                           "--checkpoint-seconds", "0.5", "--max-seconds", "3"], capture_output=True, text=True)
    journal, = folder.glob("j.h5.journal.*")
    journal_rate = journal.stat().st_size / 3 / 2  # written every 0.5 s here, every 5 s by default; few records a write

    merges = []
    for points in (100, 200, 400):
        path, parts = sweep(points), folder / f"p{points}"
        for i in range(points):
            subprocess.run([args.surveymc, "run", path, "--point", str(i), "--trials", "1024", "--threads", "1", "-o", f"{parts}/"],
                           check=True, capture_output=True)
        spent, memory = seconds("merge", "-o", folder / "m.h5", parts)
        merges.append((points, spent, memory, (folder / "m.h5").stat().st_size, sum(p.stat().st_size for p in parts.iterdir())))

n, tasks = args.points, -(-args.points // args.group)
core_hours = n * (reading + compute) / 3600
print(f"measured: reading {n} points {reading:.2f} s; a point of {args.trials:.0e} trials {compute:.2f} s; a part {part_bytes / 1e3:.1f} kB; "
      f"a journal {journal_rate / 1e3:.1f} kB/s")
for points, spent, memory, result_bytes, bytes_in in merges:
    print(f"measured: merging {points} parts ({bytes_in / 1e6:.2f} MB) {spent:.3f} s, peak {memory:.0f} MB, result {result_bytes / 1e6:.2f} MB")
a, b = merges[-2], merges[-1]
# time of a merge: c1 N (a point's tables) + c2 N^2 (every part carries the list of all points)
c2 = max((b[1] / b[0] - a[1] / a[0]) / (b[0] - a[0]), 0.0)
c1 = max(b[1] / b[0] - c2 * b[0], 0.0)
result = (b[3] - a[3]) / (b[0] - a[0]) * n
print(f"part files        {n}, {n * part_bytes / 1e6:.0f} MB (a part carries the resolved config, so N parts of an N-point list grow as N^2)")
print(f"processor time    {core_hours:.1f} core hours, {reading / (reading + compute):.0%} of it reading; on {args.cores} cores {core_hours * 3600 / args.cores:.0f} s")
print(f"tasks             {tasks} of {args.group} points, {args.group * (reading + compute):.0f} s each; {tasks / max(args.group * (reading + compute), 1e-9) * min(1, args.cores / tasks):.0f} starts and ends a second")
print(f"journals          {min(args.cores, tasks)} at once; nothing for points shorter than --checkpoint-seconds (5 s)")
print(f"merge             {c1 * n + c2 * n * n:.0f} s, {n * part_bytes / 1e6:.0f} MB of parts in memory; result {result / 1e6:.0f} MB")
