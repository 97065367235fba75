"""The benchmarks still fit the library: their sources are parsed and checked, not compiled to code.

    test_compiles.py BUILD
"""
import json
import shlex
import subprocess
import sys
from pathlib import Path

build = Path(sys.argv[1])
sources = 0
failed = []
for entry in json.loads((build / "compile_commands.json").read_text()):
    words = shlex.split(entry["command"])
    output = words[words.index("-o") + 1]
    # The kernels of one instruction set stand for both; what a build precompiles for all is not of interest.
    if "surveymc_bench" not in output or "surveymc_bench_v4" in output:
        continue
    sources += 1
    done = subprocess.run([*words, "-fsyntax-only"], cwd=entry["directory"], text=True, capture_output=True)
    if done.returncode != 0:
        failed.append(f"{entry['file']}\n{done.stderr}")
print(f"{sources} sources parsed")
sys.exit("\n".join(failed) if failed else 0 if sources >= 10 else "too few sources: where are the benchmarks?")
