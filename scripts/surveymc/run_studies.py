"""Runs the studies of configs/ one after the other, keeps what is done, and writes the report. See run_all.sh.

A result is done if its file can be read and has the config hash (config with seed, and input files) and the program
version (and revision) that a new run would have. Another result of its name is kept (NAME.1.h5, or the next free number).
Results are written whole or not at all; of the study that an
interruption falls into, the finished blocks stay in a journal beside its result, and the next run goes on from there.
"""

import argparse
import dataclasses
import fnmatch
import os
import re
import subprocess
import sys
import time
import tomllib

import surveymc

from . import streams, studies
from .arguments import Parser, USAGE

UNEXPECTED, INTERRUPTED = 1, 75
# Its intervals are those of the configs. What differs by chance among some 7,000 rows is kept apart by the family of the page
# (report/page.py: judged_together): the chance that it accuses one right prediction is at most 5 %.
QUICK_NOTE = "A quick run: far fewer trials than the configs ask for, to see that everything works. Do not quote its numbers."


@dataclasses.dataclass
class Job:
    """One config, and what becomes of it."""

    name: str  # "thesis/table8"
    config: str
    output: str
    arguments: list  # of surveymc run, for a quick run
    experiment: str
    trials: int = 0  # in all
    config_hash: str = ""
    error: str = ""


def jobs_of(patterns, output, quick, program):
    """The jobs that the patterns choose, in the order of the report; those whose config is wrong have an error."""
    known, found = studies.load(), []
    for config in studies.configs():
        name = config.removeprefix("configs/").removesuffix(".toml")
        if patterns and not any(fnmatch.fnmatch(name, p) or p in name for p in patterns):
            continue
        with open(config, "rb") as file:
            settings = tomllib.load(file)
        study = studies.study_of(known, settings.get("experiment", ""))
        few = quick and settings.get("trials", 0) > study.quick_trials
        arguments = ["--trials", str(study.quick_trials)] if few else []
        job = Job(name, config, os.path.join(output, name + ".h5"), arguments, study.experiment)
        checked = subprocess.run([program, "check", config, *arguments], capture_output=True, text=True, errors="replace")
        last = re.search(r"# \d+ sweep points?, (\d+) trials in all; config hash (\w+)", checked.stdout)
        if checked.returncode or not last:
            job.error = checked.stderr.strip() or "surveymc check says no config hash"
        else:
            job.trials, job.config_hash = int(last[1]), last[2]
        found.append((study.order, name, job))
    return [job for _, _, job in sorted(found, key=lambda f: f[:2])]


def program_version(program):
    """(version, revision) of the program, as its results have them."""
    text = subprocess.run([program, "--version"], capture_output=True, text=True, errors="replace").stdout
    found = re.match(r"surveymc (\S+) \(([^)]*)\)", text)
    return (found[1], found[2]) if found else (text.strip(), "")


def is_done(job, version):
    try:
        result = surveymc.Result(job.output)
    except surveymc.ResultError:
        return False
    return (result.config_hash, result.version, result.revision) == (job.config_hash, *version)


def duration(seconds):
    return f"{seconds:.1f} s" if seconds < 10 else f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.0f} min"


class Pace:
    """How long what is left will take: by what a trial of each experiment costs (studies.toml), corrected by how long the runs
    took, those of the same experiment if there are any."""

    START = 0.3  # s, of a run: program, predictions, writing
    FIGURES, PAGE = 1.3, 0.1  # s of a core, of a result: drawing, and its part of the pages; means of 82 results

    def __init__(self, known, threads):
        self.known, self.given, self.threads, self.runs = known, threads, threads or len(os.sched_getaffinity(0)), []

    def page(self, shown, drawn):
        """Seconds for a page of so many results, with the figures of so many."""
        return (self.FIGURES * drawn / min(2, os.cpu_count() or 1) + self.PAGE * shown) * self._factor(None)

    def cost(self, job):
        """Seconds that studies.toml lets expect."""
        study = studies.study_of(self.known, job.experiment)
        return self.START + study.run_s + 1e-6 * study.trial_us * job.trials / self.threads

    def add(self, job, seconds):
        self.runs.append((job.experiment, self.cost(job), seconds))

    def left(self, waiting):
        """Seconds for the jobs."""
        return sum(self.cost(job) * self._factor(job.experiment) for job in waiting)

    def _factor(self, experiment):
        runs = [r for r in self.runs if r[0] == experiment] or self.runs
        return sum(r[2] for r in runs) / sum(r[1] for r in runs) if runs else 1.0


def run_job(job, program, threads):
    """Runs one config; its exit code and what it said last. Ctrl-C reaches the program too, which keeps its finished blocks."""
    try:
        os.makedirs(os.path.dirname(job.output), exist_ok=True)
    except OSError as error:
        return streams.CANNOT_WRITE, [f"{error.filename}: cannot make the folder: {error.strerror}"]
    command = [program, "run", job.config, "-o", job.output, "--resume", *job.arguments,
               *(["--threads", str(threads)] if threads else [])]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace") as process:
        try:
            text = process.communicate()[0]
        except KeyboardInterrupt:
            try:
                process.communicate(timeout=20)
            except (subprocess.TimeoutExpired, KeyboardInterrupt):
                process.kill()
            raise
    verdicts = next((line for line in text.splitlines() if line.startswith("verdicts: ")), "")
    return process.returncode, verdicts.removeprefix("verdicts: ") if process.returncode == 0 else text.strip().splitlines()[-1:]


def is_drawn(job, output):
    """Whether figures for the page in this folder were made of the result that is there."""
    folder, name = os.path.split(os.path.join(output, "report", "figures", job.name))
    try:
        return os.path.getmtime(os.path.join(folder, f".{name}.figures.json")) >= os.path.getmtime(job.output)
    except OSError:
        return False


def run_jobs(jobs, version, program, pace, output=None):
    """Runs what is not done. Returns the names of the jobs that failed; raises KeyboardInterrupt when it is stopped. output:
    folder of the page that is made of them afterwards; None: none is."""
    waiting = [j for j in jobs if not j.error and not is_done(j, version)]
    broken = [j for j in jobs if j.error]
    kept = len(jobs) - len(waiting) - len(broken)
    print(f"{len(jobs)} studies: {kept} done already, {len(waiting)} to run", flush=True)
    for job in broken:
        print(f"  {job.name}: {job.error}", file=sys.stderr)
    failed = [j.name for j in broken]
    to_draw = [j for j in jobs if not j.error and (j in waiting or not is_drawn(j, output))] if output else []
    for i, job in enumerate(waiting):
        size = f"{job.trials:,} trials".replace(",", " ") if job.trials else "no trials"
        left = pace.left(waiting[i:]) + (pace.page(kept + len(waiting), len(to_draw)) if output else 0)
        print(f"[{i + 1}/{len(waiting)}] {job.name} ({size}, about {duration(left)} left) ... ", end="", flush=True)
        start = time.monotonic()
        code, words = run_job(job, program, pace.given)
        seconds = time.monotonic() - start
        if code == INTERRUPTED or code < 0:
            raise KeyboardInterrupt
        pace.add(job, seconds)
        if code:
            failed.append(job.name)
            print(f"failed (exit code {code})\n  {' '.join(words)}", flush=True)
        else:
            print(duration(seconds) + (f"; {words}" if words and not job.arguments else ""), flush=True)  # few trials decide little
    return failed


def build():
    """Builds the program of this clone; the exit code of CMake."""
    make = subprocess.run(["cmake", "--preset", "release"], cwd=studies.ROOT, stdout=subprocess.DEVNULL)
    if not make.returncode:
        make = subprocess.run(["cmake", "--build", "--preset", "release", "--target", "surveymc"], cwd=studies.ROOT)
    return make.returncode


def main():
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="few trials; into results/quick")
    parser.add_argument("--only", action="append", default=[], metavar="PATTERN", help="studies whose name fits (thesis/*)")
    parser.add_argument("--list", action="store_true", help="list the studies and whether they are done; run nothing")
    parser.add_argument("--threads", type=int, metavar="N", help="of each run (all cores)")
    parser.add_argument("--no-report", action="store_true", help="only the results")
    parser.add_argument("--output", metavar="FOLDER", help="where results go (results, or results/quick)")
    parser.add_argument("--program", help=argparse.SUPPRESS)
    parser.add_argument("--build", action="store_true", help=argparse.SUPPRESS)  # for run_all.sh, whose options are read here
    arguments = parser.parse_args()
    if arguments.build and (code := build()):
        return code
    base = studies.ROOT if studies.is_source() else os.getcwd()  # an installation is not written to
    output = os.path.abspath(arguments.output or os.path.join(base, "results", "quick" if arguments.quick else ""))
    try:
        program = os.path.abspath(arguments.program or surveymc.find_program())
    except surveymc.RunError as error:
        print(f"surveymc studies: {error}; scripts/run_all.sh builds it", file=sys.stderr)
        return USAGE
    os.chdir(studies.ROOT)  # configs are named as the README names them, and so in the results
    output = os.path.relpath(output)
    if not os.path.isfile(program) or not os.access(program, os.X_OK):
        print(f"surveymc studies: {program}: not built: scripts/run_all.sh builds it", file=sys.stderr)
        return USAGE
    jobs = jobs_of(arguments.only, output, arguments.quick, program)
    if not jobs:
        print(f"surveymc studies: no study fits {', '.join(arguments.only)}: see --list", file=sys.stderr)
        return USAGE
    version = program_version(program)
    if arguments.list:
        for job in jobs:
            state = "wrong config" if job.error else "done" if is_done(job, version) else "to run"
            print(f"{job.name:36} {job.experiment:24} {state}")
        return 0
    start = time.monotonic()
    try:
        pace = Pace(studies.load(), arguments.threads)
        failed = run_jobs(jobs, version, program, pace, None if arguments.no_report else output)
        code = UNEXPECTED if failed else 0
        there = [j.output for j in jobs if os.path.exists(j.output) and j.name not in failed]
        if there and not arguments.no_report:
            to_draw = [j for j in jobs if j.output in there and not is_drawn(j, output)]
            print(f"figures and report (about {duration(pace.page(len(there), len(to_draw)))}) ...", flush=True)
            note = ["--note", QUICK_NOTE] if arguments.quick else []
            pages = os.path.join(output, "report")
            code = max(code, subprocess.run([sys.executable, studies.PACKAGE, "report", *there, "--base", output, "-o", pages,
                                             *note]).returncode)
    except KeyboardInterrupt:
        print("\nstopped; finished results are kept: the same command goes on from there", file=sys.stderr)
        return streams.STOPPED
    print(f"done in {duration(time.monotonic() - start)}" + (f"; failed: {', '.join(failed)}" if failed else ""))
    return code


def command():
    streams.run(main, "surveymc studies")


if __name__ == "__main__":
    command()
