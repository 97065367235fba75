#!/usr/bin/python3
"""Other machines give the same numbers: compare_machines.py OUR_PROGRAM OUR_SMOKE_RESULTS OUTPUT_FOLDER PROGRAM...

PROGRAM... (an emulator and its program, or a program with another instruction set) runs every smoke config; its content hash
must be that of OUR_SMOKE_RESULTS. Where it is not, the tables and columns that differ are named, with the largest difference.
The programs must also call their numerics the same (`--version`): then a shard of each is merged to the result of one run, and
a run that PROGRAM left unfinished is finished here. A program of GCC and one of Clang differ there in the compiler alone, and do
not mix parts.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

import h5py
import numpy as np

CONFIGS = pathlib.Path(__file__).resolve().parents[2] / "configs/smoke"


def values(file):
    out = {}
    file.visititems(lambda name, item: out.__setitem__(name, item[()]) if isinstance(item, h5py.Dataset) and not name.startswith("run/") else None)
    return out


def differences(a, b):
    a, b = values(a), values(b)
    for name in sorted(a.keys() | b.keys()):
        if name not in a or name not in b or a[name].shape != b[name].shape:
            yield f"{name}: only in one, or of another size"
        elif a[name].dtype.kind == "f":
            x, y = a[name], b[name]
            wrong = (x.view("u8") != y.view("u8")) & ~((x != x) & (y != y))
            if wrong.any():
                scale = np.maximum(np.abs(x[wrong]), np.abs(y[wrong]))
                relative = np.nanmax(np.where(scale > 0, np.abs(x[wrong] - y[wrong]) / np.where(scale > 0, scale, 1), 0))
                yield f"{name}: {wrong.sum()} of {x.size} values, relative {relative:.1e}"
        elif not np.array_equal(a[name], b[name]):
            yield f"{name}: other texts or numbers"


def numerics(program):
    said = subprocess.run([*program, "--version"], capture_output=True, text=True, check=True).stdout
    return re.search(r"^numerics: +(.*)$", said, re.M)[1]


def compiler_and_rest(text):
    version, compiler, rest = text.split(", ", 2)
    return compiler.split()[0], (version, rest)


def content_hash(path):
    with h5py.File(path, "r") as file:
        return file.attrs["content_hash"]


def shared_runs(ours, theirs):
    """What is wrong with runs that both programs work at; empty: nothing."""
    config, interrupted = CONFIGS / "msa_position.toml", 75

    def ends_with(program, *arguments):
        return subprocess.run([*program, *map(str, arguments), "--quiet"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE).returncode

    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        run = ("run", config, "--trials", 1500000, "--threads", 1, "-o")
        calls = [(ours, *run, folder / "whole.h5"), (ours, *run, folder / "0.part", "--shard", "0/2"),
                 (theirs, *run, folder / "1.part", "--shard", "1/2"), (ours, "merge", folder / "0.part", folder / "1.part", "-o", folder / "shards.h5")]
        for call in calls:
            if ends_with(*call) != 0:
                yield f"{call[0][-1]} {call[1]} fails"
        seconds = 0.1
        while ends_with(theirs, *run, folder / "resumed.h5", "--max-seconds", seconds) == interrupted and not list(folder.glob("*.journal.*")):
            seconds *= 2  # until it has something to keep
        if not list(folder.glob("*.journal.*")):
            yield "no run was left unfinished"
        elif ends_with(ours, *run, folder / "resumed.h5", "--resume") != 0:
            yield "the run cannot be finished here"
        for result in ("shards.h5", "resumed.h5"):
            if not (folder / result).exists() or content_hash(folder / result) != content_hash(folder / "whole.h5"):
                yield f"{result}: not that of one run"


def main():
    ours, results, output, program = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3]), sys.argv[4:]
    wrong = []
    configs = sorted(CONFIGS.glob("*.toml"))
    for config in configs:
        other = output / f"{config.stem}.h5"
        subprocess.run([*program, "run", config, "-o", other, "--overwrite", "--quiet"], check=True, stdout=subprocess.DEVNULL)
        if content_hash(results / other.name) == content_hash(other):
            print(f"{config.stem}: the same", flush=True)
            continue
        wrong.append(config.stem)
        with h5py.File(results / other.name, "r") as a, h5py.File(other, "r") as b:
            print(f"{config.stem}: differs", *list(differences(a, b))[:12], sep="\n    ", flush=True)
    print(f"{len(configs) - len(wrong)} of {len(configs)} configs have the same content hash")
    here, there = numerics([ours]), numerics(program)
    (compiler, rest), (other_compiler, other_rest) = compiler_and_rest(here), compiler_and_rest(there)
    if here != there and (compiler == other_compiler or rest != other_rest):
        wrong.append("numerics")
        print(f"numerics: {there}\nhere:     {here}")
    elif here == there and not wrong:
        wrong = list(shared_runs([ours], program))
        print(*(wrong or ["shards of both and a run that goes on here: the result of one run"]), sep="\n")
    sys.exit(1 if wrong else 0)


main()
