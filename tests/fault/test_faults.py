#!/usr/bin/python3
"""A fault at every call: test_faults.py SURVEYMC WRITE_STREAMED FAULT_LIBRARY [--sample N] [--only TEXT]

One call of the system fails (fault.c), then another, for every call of a run, a resumed run, a shard, a merge, a rerun, a
status, a diff. After each:
* the program ends by itself with an exit code that docs/results-format.md lists, and says no "internal error" of an unknown kind.
  Without memory it may also crash, as HDF5 and the C library then do;
* a result that was there before is whole: the old bytes, or the new contents and the old bytes as out.1.h5;
* exit 0 means that the new result is there, or that what is printed is what a run without faults prints
  (`status` may name a part that it cannot read, and goes on); any other exit comes with a message that names a file or the resource;
* no temporary file is left;
* the same command without a fault (with --resume where it has that) then gives the contents of a run without faults.
--sample N: about N of the sites, evenly spread over calls and scenarios. --gone: nothing fails, but at each of these sites of a
resumed run another host has just removed the journal: the run must do all that without a word of error.
"""
import argparse
import concurrent.futures
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile

import h5py

from server import Servers

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from surveymc import integrity  # noqa: E402

DONE, BAD_INPUT, INTERNAL, CANNOT_WRITE, INTERRUPTED = 0, 65, 70, 74, 75
FAULTS = {"open": ["EMFILE", "EACCES", "EINTR"], "read": ["EIO", "EINTR", "short"], "write": ["ENOSPC", "EIO", "EINTR", "short", "ENOSPC+"],
          "fsync": ["EIO", "EINTR"], "rename": ["EIO", "ENOSPC"], "place": ["EIO", "ENOSPC", "EINVAL", "EINVAL+"], "ftruncate": ["EIO"], "close": ["EIO", "EDQUOT"], "mkdir": ["EACCES"],
          "unlink": ["EACCES", "EIO"], "link": ["EPERM", "EIO", "ENOSPC"], "lock": ["ENOLCK", "EAGAIN", "EINTR"], "mode": ["EPERM"],
          "seek": ["EIO"], "stat": ["EIO", "EACCES", "ESTALE"], "list": ["EIO", "EACCES"], "fork": ["EAGAIN", "ENOMEM"], "pipe": ["EMFILE"],
          "mmap": ["ENOMEM", "ENOMEM+"], "malloc": ["ENOMEM", "ENOMEM+"]}
# Every call that has to do with files; of thousands of requests for memory the first, and then fewer and fewer.
MOST_SITES = {"malloc": 40, "mmap": 20}

SURVEY = "md_m,inclination_deg,azimuth_deg,toolface_deg\n0,10,20,0\n30,14,25,50\n60,18,30,120\n90,22,37,200\n120,28,44,300\n150,33,52,40\n"
FIELD = '[survey]\nfile = "survey.csv"\ntoolface_zero = "y"\n[field]\ntotal_nT = 50000.0\ndip_deg = 60.0\n'
MSA = f'experiment = "msa_position"\nseed = 1\ntrials = 3000\nestimator = "msa"\nsave_samples = 3\n{FIELD}[noise]\nmagnetometer_nT = 50.0\n[sweep]\nnoise.scale = [1.0, 0.1]\n'
COVARIANCE = ('experiment = "position_covariance"\n[survey]\nfile = "survey.csv"\nazimuth_reference = "true"\n[field]\ntotal_nT = 50000.0\n'
              'dip_deg = 60.0\ndeclination_deg = 1.0\n[error_model]\nname = "iscwsa_mwd_rev5.10"\n')
MAPS = ('experiment = "reliability_map"\nseed = 1\nmode = "sse"\nobservation = "bx"\ninclination_deg = 30.0\n'
        'toolface_deg = { from = 0.0, to = 180.0, step = 45.0 }\nmagnetic_azimuth_deg = [0.0, 60.0, 90.0]\n')
WELL = 'experiment = "vertical_well"\nseed = 1\ntrials = 3000\ndepth_m = 300.0\nspacing_m = 30.0\n[drilling]\nmode = "rotating"\n[field]\ntotal_nT = 50000.0\ndip_deg = 72.0\n[sensor_errors]\naccelerometer_bias_mps2 = 0.004\n'
EVENT = ('experiment = "rare_event"\nseed = 1\ntrials = 20000\n[problem]\nname = "rp107"\n[sampling]\nmethod = "importance"\n'
         "subset = { samples = 100, replicates = 2 }\n")


class Scenario:
    """A command, the commands before it, the result that it makes; commands that end the work without a fault. Without a
    result it only reads: what is printed is the result, and no file may change. begun: a run of which half a journal is there."""

    def __init__(self, name, command, output=None, prepare=(), again=None, final=None, keeps=True, begun=None):
        self.name, self.command, self.output, self.prepare, self.begun = name, command, output, prepare, begun
        self.again, self.final, self.keeps = again or [command], final or output, keeps
        self.printed = None  # without faults
        self.template = self.expected = self.files = None


def contents(path):
    """Content hash of a result whose seal is right; the bytes of another file. OSError if it is neither."""
    data = path.read_bytes()
    if not data.startswith(b"\x89HDF"):
        return data
    if not integrity.seal_of(path):
        raise OSError("without a right seal")
    with h5py.File(path, "r") as file:
        return file.attrs["content_hash"]


def all_bytes(folder):
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def scenarios(program, streamed):
    run = lambda config, *more: [program, "run", config, "-o", "out.h5", "--threads", "2", *more]
    old = [program, "run", "msa.toml", "-o", "out.h5", "--seed", "9"]
    halves = [[program, "run", "msa.toml", "--shard", f"{i}/2", "-o", "parts/"] for i in (0, 1)]
    begun = run("msa.toml", "--checkpoint-seconds", "0.001")
    yield Scenario("run", run("msa.toml"), "out.h5", again=[run("msa.toml", "--resume")])
    yield Scenario("run over an old result", run("msa.toml"), "out.h5", [old], [run("msa.toml", "--resume")])
    yield Scenario("resume", run("msa.toml", "--resume", "--checkpoint-seconds", "0.001"), "out.h5", begun=begun)
    merge = [program, "merge", "parts", "-o", "out.h5"]
    yield Scenario("shard", halves[1], None, [halves[0]], [halves[1], merge], "out.h5")
    yield Scenario("merge over an old result", merge, "out.h5", [*halves, old])
    yield Scenario("status", [program, "status", "parts"], prepare=halves)
    yield Scenario("covariance", run("covariance.toml"), "out.h5", again=[run("covariance.toml", "--resume")])
    yield Scenario("maps", run("maps.toml"), "out.h5", again=[run("maps.toml", "--resume")])
    yield Scenario("well", run("well.toml"), "out.h5", again=[run("well.toml", "--resume")])
    yield Scenario("rare event", run("event.toml"), "out.h5", again=[run("event.toml", "--resume")])
    small = lambda name, *more: [program, "run", "covariance.toml", "-o", name, "--threads", "2", *more]
    yield Scenario("rerun", [program, "rerun", "out.h5"], prepare=[small("out.h5")])
    yield Scenario("show", [program, "show", "out.h5", "position"], prepare=[run("msa.toml")])
    yield Scenario("diff", [program, "diff", "other.h5", "out.h5"], prepare=[[*old[:4], "other.h5", *old[5:]], run("msa.toml")])
    yield Scenario("streamed maps", [streamed, "out.h5"], "out.h5", [old], keeps=False)


def fill(folder):
    for name, text in (("survey.csv", SURVEY), ("msa.toml", MSA), ("covariance.toml", COVARIANCE), ("maps.toml", MAPS), ("well.toml", WELL),
                       ("event.toml", EVENT)):
        (folder / name).write_text(text)


def sites_of(counts, gone):
    for name, count in counts.items():
        if gone:
            yield from (f"{name}:{n}:gone" for n in range(1, count + 1) if name in ("open", "stat"))
            continue
        most = MOST_SITES.get(name, count)
        numbers = range(1, count + 1) if count <= most else sorted({round(count ** (i / (most - 1))) for i in range(most)})
        for n in numbers:
            for fault in FAULTS[name]:
                yield f"{name}:{n}:{fault}"


def spread(sites, share):
    """Of all sites the share that is asked for, evenly."""
    return [s for i, s in enumerate(sites) if int((i + 1) * share) > int(i * share)]


ENDINGS = (DONE, BAD_INPUT, INTERNAL, CANNOT_WRITE, INTERRUPTED)
# What runs long or takes time says so in its text: "identical: HASH (6000 trials in 0.1 s)", "kept 0.5 s ago".
TIMES = re.compile(r"[0-9.e-]+ (m?s|min)\b")
CANNOT_REMOVE = ("unlink", "list", "lock", "stat")  # calls without which a file that is of no use any more stays


def wrong_end(site, done):
    """What is wrong with how the program ended; nothing if nothing is."""
    is_memory = site.startswith(("malloc", "mmap"))
    if is_memory:
        return None
    if site.endswith(":gone") and done.returncode != DONE:
        return f"exit {done.returncode} without a journal: {done.stderr[-300:]}"
    if done.returncode not in ENDINGS:
        return f"exit {done.returncode}: {done.stderr[-300:]}"
    if done.returncode == INTERNAL:
        return f"exit 70: {done.stderr[-300:]}"
    if done.returncode != DONE and not re.search(r"error: .*(\.h5|\.toml|\.csv|\.part|parts|journal)", done.stderr):
        return f"exit {done.returncode} without a message that names a file: {done.stderr[-300:]!r}"
    return None


def wrong_result(scenario, site, done, folder):
    """What is wrong with the result and what was there before it."""
    output, old = folder / scenario.output, scenario.template / scenario.output
    before = contents(old) if old.exists() else None
    try:
        after = contents(output) if output.exists() else None
    except OSError as e:
        return f"exit {done.returncode}, and the result is unreadable: {e}"
    if done.returncode == DONE and after != scenario.expected:
        return "exit 0 without the result"
    if after not in (before, scenario.expected):
        return f"exit {done.returncode}, and the result is neither the old nor the new one"
    kept = folder / "out.1.h5"
    is_new = after == scenario.expected and before and before != scenario.expected
    if is_new and scenario.keeps and not (kept.exists() and kept.read_bytes() == old.read_bytes()):
        return f"exit {done.returncode}: the old result is lost"
    if after == before and before and output.read_bytes() != old.read_bytes():
        return f"exit {done.returncode}: the old result has other bytes"
    if after == before and done.returncode != DONE and kept.exists() and not site.startswith(("malloc", "mmap", *CANNOT_REMOVE)):
        return f"exit {done.returncode}: the old result has two names"
    return None


def wrong_reading(scenario, site, done, folder):
    """What is wrong with what was printed, or with the files that were read."""
    if all_bytes(folder) != scenario.files:
        return f"exit {done.returncode}, and a file has changed"
    if done.returncode != DONE or TIMES.sub("", done.stdout) == scenario.printed:
        return None
    told = not site.endswith(":short") and re.search(r"\.part: cannot be read", done.stdout + done.stderr)  # status goes on to the others
    return None if told else f"exit 0, and prints something else: {done.stdout[-300:]!r}, {done.stderr[-300:]!r}"


def check(call, scenario, site, work):
    """What is wrong after this fault; nothing if nothing is."""
    with tempfile.TemporaryDirectory(dir=work) as name:
        folder = pathlib.Path(name) / "w"
        shutil.copytree(scenario.template, folder)
        try:
            done = call(scenario.command, folder, site)
        except subprocess.TimeoutExpired:
            return "does not end"
        wrong = wrong_end(site, done) or (scenario.output and wrong_result(scenario, site, done, folder))
        if wrong:
            return wrong
        if not scenario.final:
            return wrong_reading(scenario, site, done, folder)
        left = [p.name for p in folder.rglob(".*.tmp")]
        if left and done.returncode in ENDINGS and not site.startswith(CANNOT_REMOVE):
            return f"exit {done.returncode}, left behind: {left}"
        for command in scenario.again:
            again = call(command, folder)
            if again.returncode != DONE:
                return f"exit {done.returncode} ({done.stderr[-200:]}); the next run: exit {again.returncode}: {again.stderr[-300:]}"
        if contents(folder / scenario.final) != scenario.expected:
            return "the next run gives other contents"
        left = [p.name for p in (*folder.rglob("*.journal.*"), *folder.rglob(".*.tmp"))]
        is_removed = all(command[1] == "run" for command in scenario.again)  # its next run removes what stayed
        return f"files are left: {left}" if left and (is_removed or not site.startswith(CANNOT_REMOVE)) else None


def half_of(journal):
    """Its first half, in whole records."""
    data, ends = journal.read_bytes(), [0]
    while ends[-1] < len(data):
        ends.append(ends[-1] + 16 + struct.unpack_from("<Q", data, ends[-1] + 8)[0] + 16)
    if len(ends) < 3:
        sys.exit(f"{journal.name}: has {len(ends) - 1} record, which has no half")
    return data[:ends[len(ends) // 2]]


def prepared(call, scenario, work, gone):
    """Fills the scenario's folder; the sites of its command."""
    scenario.template = work / "template"
    scenario.template.mkdir(parents=True)
    fill(scenario.template)
    for command in scenario.prepare:
        done = call(command, scenario.template)
        if done.returncode not in (DONE, INTERRUPTED):
            sys.exit(f"{scenario.name}: cannot prepare: {done.stderr}")
    if scenario.begun:  # all is computed, but the result gets no name
        for _ in range(20):  # it may be faster than the shortest time between two records
            done = call(scenario.begun, scenario.template, "place:1:EIO")
            journals = list(scenario.template.glob("*.journal.*"))
            if journals:
                break
        if done.returncode != CANNOT_WRITE or len(journals) != 1:
            sys.exit(f"{scenario.name}: cannot prepare: {done.stderr}")
        journals[0].write_bytes(half_of(journals[0]))
    trial = work / "trial"
    shutil.copytree(scenario.template, trial)
    done = call(scenario.command, trial, "open:0:EIO", work / "counts")
    if done.returncode != DONE:
        sys.exit(f"{scenario.name}: fails without a fault: {done.stderr}")
    if scenario.begun and not re.search("going on from [1-9]", done.stderr):
        sys.exit(f"{scenario.name}: does not go on from its journal: {done.stderr}")
    scenario.printed, scenario.files = TIMES.sub("", done.stdout), all_bytes(scenario.template)
    for command in scenario.again if scenario.final and not scenario.output else ():
        call(command, trial)
    scenario.expected = scenario.final and contents(trial / scenario.final)
    counts = {k: int(v) for k, v in (line.split() for line in (work / "counts").read_text().splitlines())}
    return [(scenario, site) for site in sites_of(counts, gone)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("surveymc")
    parser.add_argument("write_streamed")
    parser.add_argument("library")
    parser.add_argument("--sample", type=int)
    parser.add_argument("--only", default="", help="only scenarios whose names contain this")
    parser.add_argument("--gone", action="store_true")
    parser.add_argument("--calls", default="", help="only these calls, with commas")
    parser.add_argument("--no-exchange", action="store_true", help="as on a file system that cannot exchange two names")
    a = parser.parse_args()
    if a.no_exchange:
        os.environ["SURVEYMC_FAULT_NO_EXCHANGE"] = "1"
    program, streamed, library = (str(pathlib.Path(p).resolve()) for p in (a.surveymc, a.write_streamed, a.library))
    call, planned, findings = Servers(library), [], 0
    with tempfile.TemporaryDirectory(prefix="surveymc-faults-") as name:
        work = pathlib.Path(name)
        for number, scenario in enumerate(scenarios(program, streamed)):
            if a.only in scenario.name and (not a.gone or scenario.name == "resume"):
                planned += prepared(call, scenario, work / f"{number}", a.gone)
        planned = [p for p in planned if not a.calls or p[1].split(":")[0] in a.calls.split(",")]
        chosen = spread(planned, min(1, a.sample / max(1, len(planned))) if a.sample else 1)
        if not chosen:
            sys.exit("no site was chosen: nothing is tested")
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            answers = pool.map(lambda p: check(call, *p, work), chosen)
            checked, last = 0, chosen[0][0].name
            for (scenario, site), wrong in zip(chosen, answers):
                if scenario.name != last:
                    print(f"{last}: {checked} sites", flush=True)
                    checked, last = 0, scenario.name
                checked += 1
                if wrong:
                    findings += 1
                    print(f"{scenario.name}: {site}: {wrong}", flush=True)
            print(f"{last}: {checked} sites", flush=True)
    call.close()
    print(f"{len(chosen)} of {len(planned)} faults in {len({p[0].name for p in planned})} scenarios, {findings} with a finding")
    sys.exit(1 if findings else 0)


main()
