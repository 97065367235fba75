#!/usr/bin/python3
"""Figures depend on the data only: same_bytes.py RESULT.h5 ... Every drawer that studies.toml names for a result, and the
one of any sweep, draws it twice, as programs of their own with other seeds of Python's hashes: the same files with the same bytes. Some minutes.
"""
import os
import subprocess
import sys
import tempfile
from pathlib import Path

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
sys.path.insert(0, str(SCRIPTS))
import surveymc  # noqa: E402
from surveymc import studies  # noqa: E402

CHOOSE_A_POINT = 64


def drawn(script, result, seed):
    """{name: bytes} of what a script draws; None where it draws nothing of such a result."""
    for point in ([], ["--point", "0"]):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, SCRIPTS / "surveymc", "plot", script, result, "-o", folder, *point], capture_output=True, text=True,
                                  env={**os.environ, "PYTHONHASHSEED": seed})
            if done.returncode == 0:
                return {p.name: p.read_bytes() for p in Path(folder).iterdir()}
            if done.returncode == 1 or "Traceback" in done.stderr:
                sys.exit(f"{script} {result}: {done.stderr}")
            if done.returncode != CHOOSE_A_POINT:
                return None


def main(results):
    known, wrong, figures = studies.load(), [], 0
    for result in results:
        for script in [*known[surveymc.open(result).experiment].drawers_for(result), "sweep"]:
            first = drawn(script, result, "1")
            second = drawn(script, result, "2") if first else first
            figures += len(first or {})
            if first != second:
                wrong.append(f"{script} {result}: " + ", ".join(n for n in sorted({*first, *second}) if first.get(n) != second.get(n)))
    print("\n".join(wrong) or f"{figures} files of {len(results)} results: the same bytes")
    return bool(wrong) or not figures


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]) if sys.argv[1:] else __doc__)
