#!/usr/bin/python3
"""Every byte of a small result, part and journal flipped, and the file cut there: test_every_byte.py SURVEYMC READ_DAMAGED
FAULT_LIBRARY [--sample N] [--only result|part|journal]

Each time the damage is found, with a message that names the file and the documented exit code, or it does no harm: the
same values are shown, merged, gone on from. Never a crash, never other values. All damages of the result are read by the
program's reader (READ_DAMAGED) and by Python's, one in ten is shown by the program.
--sample N: about N of the damages, evenly spread over files and places.
"""
import argparse
import concurrent.futures
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

import h5py

from server import Servers

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from surveymc import integrity, storage  # noqa: E402

SHOWN = 10
DONE, BAD_INPUT, CANNOT_WRITE = 0, 65, 74
MARK = b"SMCJRNL1"
# A map, as its file is small; and events of small probability, whose tallies are.
MAP = ('experiment = "reliability_map"\nseed = 1\nmode = "sse"\nobservation = "bx"\ninclination_deg = 30.0\n'
       "toolface_deg = [0.0, 90.0]\nmagnetic_azimuth_deg = [0.0, 60.0]\n")
EVENT = ('experiment = "rare_event"\nseed = 1\ntrials = 20000\n[problem]\nname = "rp107"\n[sampling]\nmethod = "importance"\n'
         "subset = { samples = 100, replicates = 2 }\n")


def content_hash(path):
    with h5py.File(path, "r") as file:
        return file.attrs["content_hash"]


class Target:
    """A file, a command that reads it, and what says whether that did harm."""

    def __init__(self, call, program, template, name, command, outcome):
        self.call, self.template, self.name, self.command = call, template, name, [program, *command]
        self.data = (template / name).read_bytes()
        self.outcome, self.expected = outcome, None

    def damages(self):
        for at in range(len(self.data)):
            yield self, at, False
            yield self, at, True

    def damaged(self, at, is_cut):
        return self.data[:at] if is_cut else self.data[:at] + bytes([self.data[at] ^ (1 << at % 8)]) + self.data[at + 1:]

    def wrong(self, at, is_cut, work):
        """What is wrong after this damage; nothing if nothing is."""
        with tempfile.TemporaryDirectory(dir=work) as name:
            folder = pathlib.Path(name) / "w"
            shutil.copytree(self.template, folder)
            (folder / self.name).write_bytes(self.damaged(at, is_cut))
            done = self.call(self.command, folder)
            if done.returncode == DONE:
                if self.outcome(done, folder) != self.expected:
                    return "other values, and no word"
            elif done.returncode not in (BAD_INPUT, CANNOT_WRITE):
                return f"exit {done.returncode}: {done.stderr[-300:]}"
            elif self.name.split("/")[-1] not in done.stderr:
                return f"exit {done.returncode} without the name of the file: {done.stderr[-300:]}"
            left = [p.name for p in folder.rglob(".*.tmp")]
            if left:
                return f"left behind: {left}"
        return None


def read_by_python(target, work):
    """Places whose damage Python's reader believes."""
    path, found = work / "python.h5", []
    for _, at, is_cut in target.damages():
        path.write_bytes(target.damaged(at, is_cut))
        try:
            with storage.open_file(str(path)) as file:
                if integrity.content_hash(file) != target.python:
                    found.append(f"Python reads other values: {'cut' if is_cut else 'flipped'} at {at}")
        except storage.ResultError:
            pass
    return found


def targets(call, program, work):
    folders = {}
    for name, config in (("result", MAP), ("part", EVENT), ("journal", EVENT)):
        folders[name] = work / name
        folders[name].mkdir()
        (folders[name] / "c.toml").write_text(config)
    journal = ["run", "c.toml", "-o", "r.h5", "--checkpoint-seconds", "0.001", "--threads", "1"]
    prepare = (("result", ["run", "c.toml", "-o", "r.h5"], ""), ("part", ["run", "c.toml", "--shard", "0/2", "-o", "p/"], ""),
               ("part", ["run", "c.toml", "--shard", "1/2", "-o", "p/"], ""), ("journal", journal, "place:1:EIO"))
    for name, command, fault in prepare:  # with the fault all is computed, and kept, but the result gets no name
        for _ in range(20):  # a run may be faster than the shortest time between two records
            done = call([program, *command], folders[name], fault)
            journals = list(folders[name].glob("r.h5.journal.*"))
            if not fault or len(journals) == 1:
                break
        if done.returncode != (CANNOT_WRITE if fault else DONE):
            sys.exit(f"cannot prepare: {done.stderr}")
    if len(journals) != 1:
        sys.exit("no run has left a journal")
    records = journals[0].read_bytes().split(MARK)  # behind the second one there is nothing new
    journals[0].write_bytes(MARK.join(records[:3]))
    shown = Target(call, program, folders["result"], "r.h5", ["show", "r.h5", "--json"], lambda done, folder: done.stdout)
    shown.python = content_hash(folders["result"] / "r.h5")
    yield shown
    parts = sorted((folders["part"] / "p").glob("*.part"))
    yield Target(call, program, folders["part"], f"p/{parts[0].name}", ["merge", "p", "-o", "m.h5"], lambda done, folder: content_hash(folder / "m.h5"))
    yield Target(call, program, folders["journal"], journals[0].name, ["run", "c.toml", "-o", "r.h5", "--resume"],
                 lambda done, folder: (content_hash(folder / "r.h5"), [p.name for p in folder.glob("*.journal.*")]))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("surveymc")
    parser.add_argument("read_damaged")
    parser.add_argument("library")
    parser.add_argument("--sample", type=int)
    parser.add_argument("--only", choices=("result", "part", "journal"))
    a = parser.parse_args()
    program, reader, library = (str(pathlib.Path(p).resolve()) for p in (a.surveymc, a.read_damaged, a.library))
    call, findings = Servers(library), 0
    with tempfile.TemporaryDirectory(prefix="surveymc-bytes-") as name:
        work, planned = pathlib.Path(name), []
        for target in (t for t in targets(call, program, work) if a.only in (None, t.template.name)):
            whole = work / "whole"
            shutil.copytree(target.template, whole)
            done = call(target.command, whole)
            if done.returncode != DONE:
                sys.exit(f"{target.name}: fails without damage: {done.stderr}")
            target.expected = target.outcome(done, whole)
            shutil.rmtree(whole)
            all_of_it = list(target.damages())
            wanted = min(len(all_of_it), (a.sample or 0) // 3 or len(all_of_it))
            if target.template.name == "result" and not a.sample:
                wanted //= SHOWN
                whole = work / "whole.h5"
                whole.write_bytes(target.data)
                done = subprocess.run([reader, whole, work / "damaged.h5"], capture_output=True, text=True)
                found = read_by_python(target, work)
                print(done.stdout + done.stderr + "\n".join(found), flush=True)
                findings += (done.returncode != DONE) + len(found)
            print(f"{target.name}: {len(target.data)} bytes, {wanted} of {len(all_of_it)} damages", flush=True)
            planned += [all_of_it[i * len(all_of_it) // wanted] for i in range(wanted)]
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            for (target, at, is_cut), wrong in zip(planned, pool.map(lambda p: p[0].wrong(p[1], p[2], work), planned)):
                if wrong:
                    findings += 1
                    print(f"{target.name}, {'cut' if is_cut else 'flipped'} at {at}: {wrong}", flush=True)
    call.close()
    print(f"{len(planned)} damages, {findings} with a finding")
    sys.exit(1 if findings else 0)


main()
