"""Starts drawers, within this process."""

import contextlib
import dataclasses
import importlib
import importlib.util
import io
import os
import sys
import traceback

from .. import streams
from ..arguments import USAGE
from .reading import Saved

COMMAND = "surveymc plot"


@dataclasses.dataclass
class Drawn:
    """Figures of one result: SVG files, and what the drawers said where there is no figure."""

    files: list = dataclasses.field(default_factory=list)
    messages: list = dataclasses.field(default_factory=list)
    broken: list = dataclasses.field(default_factory=list)  # drawers that failed with a traceback, or could not write
    kept: list = dataclasses.field(default_factory=list)  # what they said of files that were there before
    code: int = 0  # exit code of the drawers that failed or drew nothing, the largest


def is_drawer(name):
    """Whether surveymc.plots has a drawer of this name."""
    if not name.isidentifier() or name.startswith("_") or importlib.util.find_spec(f"surveymc.plots.{name}") is None:
        return False
    return hasattr(importlib.import_module(f"surveymc.plots.{name}"), "main")


def start(name, arguments):
    """Runs a drawer with a command line of its own; exits unless it ends with 0."""
    sys.argv = [f"{COMMAND} {name}", *arguments]
    streams.run(importlib.import_module(f"surveymc.plots.{name}").main)


def _run(name, arguments):
    """A drawer in this process: its exit code, the figures it has saved, its error output, and what it has kept."""
    out, err = io.StringIO(), io.StringIO()
    Saved.paths, Saved.kept, Saved.results = [], [], []
    argv = sys.argv
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                start(name, arguments)
                code = 0
            except SystemExit as end:
                code = end.code or 0
            except Exception:
                traceback.print_exc()
                code = 1
    finally:
        sys.argv = argv
    return code, Saved.paths, err.getvalue(), Saved.kept


def draw(result_path, names, folder, point=None):
    """Figures that the drawers of these names make of a result into `folder`. point: number of the sweep point of figures that
    show one; None: all that can be drawn of the whole sweep, and otherwise the first point."""
    os.makedirs(folder, exist_ok=True)
    drawn = Drawn()
    result_path, folder = (f"./{p}" if p.startswith("-") else p for p in (result_path, folder))  # no options
    for name in names:
        arguments = [result_path, "-o", folder]
        chosen = [*arguments, "--point", str(point or 0)]
        code, saved, err, kept = _run(name, arguments if point is None else chosen)
        if point is None and code and "choose one with --point" in err:
            code, saved, err, kept = _run(name, chosen)
        elif code == USAGE and "unrecognized arguments: --point" in err:  # it draws all points
            code, saved, err, kept = _run(name, arguments)
        drawn.files += [f for f in saved if f.endswith(".svg") and f not in drawn.files]
        drawn.kept += kept
        if code in (1, streams.CANNOT_WRITE):
            said = err.strip().splitlines()[-1] if err.strip() else "failed"
            drawn.broken.append(f"{name}: {said.removeprefix(f'{COMMAND} {name}: ')}")
            drawn.code = max(drawn.code, code)
        elif code:
            drawn.code = max(drawn.code, code)
            drawn.messages.append(err.strip().replace(f"{result_path}: ", ""))
    return drawn
