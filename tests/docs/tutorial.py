#!/usr/bin/python3
"""The code of a tutorial, taken from its page and used as a reader would.

    tutorial.py run PAGE SOURCE BUILD          files, commands and their output, in a temporary copy
    tutorial.py extract PAGE SOURCE FOLDER     files and patched files into FOLDER, for the build

A fenced block does what the comment before it says: `<!-- file: PATH -->` is a file, `<!-- patch -->` a diff,
`<!-- not run: WHY -->` only shown. A block ```sh is run; every line of a block ```output behind it must be a line that
it printed, in this order ("..." stands for what varies or is left out).
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
from typing import NamedTuple


class Block(NamedTuple):
    line: int
    comment: str  # of the line before, without <!-- -->
    language: str
    text: str


def blocks_of(page):
    found, lines, number = [], page.read_text().splitlines(), 0
    comment = ""
    while number < len(lines):
        line = lines[number]
        if line.startswith("```"):
            end = next(i for i in range(number + 1, len(lines)) if lines[i] == "```")
            found.append(Block(number + 1, comment, line[3:].strip(), "\n".join(lines[number + 1:end]) + "\n"))
            number, comment = end, ""
        elif hit := re.fullmatch(r"<!-- (.*) -->", line):
            comment = hit[1]
        elif line:
            comment = ""
        number += 1
    return found


def apply_patch(block, source, target):
    """What the page shows must go through `git apply` as a reader would use it."""
    for name in re.findall(r"^\+\+\+ b/(.*)\n", block.text, flags=re.M):
        path = target / name
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(source / name, path)
    # Not the repository around a build folder: its index knows nothing of these copies.
    environment = {**os.environ, "GIT_CEILING_DIRECTORIES": str(target.resolve().parent)}
    done = subprocess.run(["git", "apply", "-"], input=block.text, text=True, cwd=target, capture_output=True, env=environment)
    assert done.returncode == 0, f"line {block.line}: git apply: {done.stderr}"


def write_files(blocks, source, target):
    for block in blocks:
        if block.comment.startswith("file: "):
            path = target / block.comment[len("file: "):]
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(block.text)
        elif block.comment == "patch":
            apply_patch(block, source, target)


def check_output(block, printed):
    """The lines of an output block, in order, among those that were printed."""
    rest = [line.rstrip() for line in printed.splitlines()]
    wanted = [line.rstrip() for line in block.text.splitlines()]
    for number, line in enumerate(wanted, block.line + 1):
        if line == "...":
            continue
        pattern = ".*".join(re.escape(part) for part in line.split("..."))
        while rest and not re.fullmatch(pattern, rest[0]):
            rest.pop(0)
        assert rest, f"line {number}: not printed (or not in this order): {line}\n--- printed:\n{printed}"
        rest.pop(0)


def run(page, source, build):
    with tempfile.TemporaryDirectory(prefix="surveymc-tutorial-") as name:
        folder = pathlib.Path(name)
        for part in ["configs", "scripts"]:
            shutil.copytree(source / part, folder / part)
        (folder / "build/tests").mkdir(parents=True)
        programs = {"surveymc": "surveymc", "tests/tutorial_estimator": "tests/estimate_tests"}
        if page.stem == "add_study":  # there the program is the one with the study of the page
            programs = {"tests/tutorial_study": "surveymc"}
        for program, at in programs.items():
            if (build / program).exists():
                shutil.copy(build / program, folder / "build" / at)  # no link: the scripts beside it are those of the copy
        commands, printed = 0, None
        for block in blocks_of(page):
            if block.comment.startswith("not run: "):
                printed = None
            elif block.language == "sh":
                done = subprocess.run(["bash", "-euo", "pipefail", "-c", block.text], cwd=folder, text=True, timeout=300,
                                      stdout=subprocess.PIPE, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL,
                                      env={**os.environ, "MPLBACKEND": "Agg", "SURVEYMC_SOURCE_DIR": str(source)})
                assert done.returncode == 0, f"line {block.line}: exit {done.returncode}\n{done.stdout}\n{done.stderr}"
                printed = done.stdout
                commands += 1
                if os.environ.get("SURVEYMC_TUTORIAL_PRINT"):
                    print(f"--- line {block.line}\n{printed}")
            elif block.language == "output":
                assert printed is not None, f"line {block.line}: output of no command"
                assert block.text.strip(), f"line {block.line}: says nothing"
                check_output(block, printed)
            elif block.comment.startswith("file: "):
                write_files([block], source, folder)
        assert commands > 0, "nothing was run"
        print(f"{page.name}: {commands} blocks of commands run")


def main():
    action, page, source, folder = sys.argv[1], *map(pathlib.Path, sys.argv[2:5])
    if action == "run":
        run(page, source.resolve(), folder.resolve())
    elif action == "extract":
        write_files([b for b in blocks_of(page) if b.comment], source, folder)
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
