#!/usr/bin/python3
"""The numerics version is raised when bits change: check_numerics.py SURVEYMC FOLDER_OF_SMOKE_RESULTS [--record]

tests/formats/numerics.txt has the numerics of the program that wrote it, and a line for every table of every smoke config: a
hash of its names of columns, and one of its numbers. Journals and parts of two builds with one numerics version are merged
(lib/base/numerics.h), so the same version has to give the same numbers. Where they are right but other than before: raise
kNumericsVersion, then --record. Tables with other columns are not compared until the next --record; on a machine whose probe
or compiler is another than that of numerics.txt, nothing is (exit 77). GCC 12 and Clang 14 count as one: they give the same bits.
"""
import pathlib
import re
import subprocess
import sys

import h5py
import numpy as np
import xxhash

RECORD = pathlib.Path(__file__).resolve().parent / "numerics.txt"
SKIPPED = 77


def numerics(program):
    """All that decides bits; not the form of tallies, which decides what journals and parts may be read."""
    said = subprocess.run([program, "--version"], capture_output=True, text=True, check=True).stdout
    return re.search(r"numerics: +(.*?)(, tallies .*)?$", said, re.M)[1]


def lines_of(folder):
    """{(config, table): (hash of the names of its columns, hash of its numbers)}"""
    out = {}
    for path in sorted(folder.glob("*.h5")):
        with h5py.File(path, "r") as file:
            sets = {name: {c: group[c] for c in sorted(group) if c != "row"} for name, group in file["tables"].items()}
            maps = {name: item for name, item in file["maps"].items() if not h5py.h5ds.is_scale(item.id)}
            if maps:
                sets["maps"] = dict(sorted(maps.items()))
            for name, columns in sets.items():
                numbers = {c: d for c, d in columns.items() if d.dtype.kind in "fi"}
                if not numbers:
                    continue
                values = xxhash.xxh3_64()
                for d in numbers.values():
                    values.update(np.ascontiguousarray(d[()]).tobytes())
                out[path.stem, name] = (xxhash.xxh3_64(",".join(numbers).encode()).hexdigest()[:8], values.hexdigest())
    return out


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    now, found = numerics(program), lines_of(folder)
    if sys.argv[3:] == ["--record"]:
        RECORD.write_text("".join([f"{now}\n", *(f"{c} {t} {a} {b}\n" for (c, t), (a, b) in sorted(found.items()))]))
        return
    first, *rest = RECORD.read_text().splitlines()
    kept = {tuple(line.split()[:2]): tuple(line.split()[2:]) for line in rest}
    version = lambda text: text.split(",")[0]
    if version(first) != version(now):
        sys.exit(f"numerics.txt is of numerics {version(first)}, the program has {version(now)}: check_numerics.py SURVEYMC FOLDER --record")
    of_any_compiler = lambda text: re.sub(r"GNU 12\.2\.0|Clang [0-9.]+", "GNU or Clang", text)
    if of_any_compiler(first) != of_any_compiler(now):
        print(f"nothing is compared: numerics.txt is of {first}, this program has {now}")
        sys.exit(SKIPPED)
    both = [key for key in kept if key in found and kept[key][0] == found[key][0]]
    changed = [key for key in both if kept[key] != found[key]]
    print(f"{len(both)} of {len(kept)} tables compared; {len(found) - len(both)} are new or have other columns")
    if 2 * len(both) < len(kept):
        sys.exit("numerics.txt is too old: --record")
    if changed:
        sys.exit("other numbers with the same numerics version: " + ", ".join(f"{c} {t}" for c, t in changed)
                 + "\nIf they are meant to change, raise kNumericsVersion (lib/base/numerics.h) and record anew.")


main()
