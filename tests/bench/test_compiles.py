"""The benchmarks still fit the library: their sources are parsed and checked, not compiled to code.

    test_compiles.py BUILD

Sources of the same command are parsed as one, so that the headers are read once; each alone if that fails, as then their names
may only be in each other's way.
"""
import collections
import json
import shlex
import subprocess
import sys
from pathlib import Path

build = Path(sys.argv[1])
alike = collections.defaultdict(list)
for entry in json.loads((build / "compile_commands.json").read_text()):
    words = shlex.split(entry["command"])
    output = words[words.index("-o") + 1]
    # The kernels of one instruction set stand for both; what a build precompiles for all is not of interest.
    if "surveymc_bench" in output and "surveymc_bench_v4" not in output:
        alike[entry["directory"], tuple(words[:words.index("-o")])].append(entry["file"])


def faults(folder, words, sources):
    """What the compiler says; nothing where it accepts them."""
    text = "".join(f'#include "{source}"\n' for source in sources)
    done = subprocess.run([*words, "-fsyntax-only", "-x", "c++", "-"], input=text, cwd=folder, text=True, capture_output=True)
    return done.stderr or "not compiled\n" if done.returncode else ""


failed = []
for (folder, words), sources in alike.items():
    if faults(folder, words, sources):
        failed += [f"{source}\n{said}" for source in sources if (said := faults(folder, words, [source]))]
count = sum(map(len, alike.values()))
print(f"{count} sources parsed")
sys.exit("\n".join(failed) if failed else 0 if count >= 10 else "too few sources: where are the benchmarks?")
