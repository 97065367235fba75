"""Starts drawers, within this process."""

import contextlib
import dataclasses
import importlib
import importlib.util
import io
import os
import sys
import tempfile
import traceback

from .. import streams
from . import one_point
from .reading import MOST_POINTS, PlotError, Saved

COMMAND = "surveymc plot"
OF_ANY_SWEEP = ("calibration", "refined", "sensitivity", "thesis")  # they draw something else than the sweep


@dataclasses.dataclass
class Drawn:
    """Figures of one result: SVG files, and what the drawers said where there is no figure."""

    files: list = dataclasses.field(default_factory=list)
    messages: list = dataclasses.field(default_factory=list)
    broken: list = dataclasses.field(default_factory=list)  # drawers that failed with a traceback, or could not write
    kept: list = dataclasses.field(default_factory=list)  # what they said of files that were there before
    notes: list = dataclasses.field(default_factory=list)  # what was chosen
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


def spans(name, keys):
    """Whether a drawer has figures of a whole sweep over these keys: its SPANS, the keys that it knows, or True for all of them. It
    knows cases."""
    known = getattr(importlib.import_module(f"surveymc.plots.{name}"), "SPANS", ())
    return known is True or set(keys) <= {"case", *known}


def draw(result_path, names, folder, point=None):
    """Figures that the drawers of these names make of a result into `folder`.

    Of a sweep over keys that no drawer knows, the overview (plots/sweep.py) comes first; and where it has more than a few points,
    the drawers see one of them: number `point`, or the first. With a `point` they all see that one alone.
    """
    os.makedirs(folder, exist_ok=True)
    drawn = Drawn()
    result_path, folder = (f"./{p}" if p.startswith("-") else p for p in (result_path, folder))  # no options
    count, keys, has_own = one_point.of_sweep(result_path)
    of_points = [n for n in names if n not in OF_ANY_SWEEP]
    if of_points and point is None and count > 2 and not has_own and not any(spans(n, keys) for n in of_points):
        names = ["sweep", *(n for n in names if n != "sweep")]
    with tempfile.TemporaryDirectory() as place:
        cut = None
        for name in names:
            whole = point is None and (count <= MOST_POINTS or spans(name, keys))
            if whole:
                code, saved, err, kept = _run(name, [result_path, "-o", folder])
            if not whole or (code and "choose one with --point" in err):
                try:
                    cut = cut or one_point.extract(result_path, point or 0, place)
                except PlotError as error:
                    drawn.code, drawn.messages = max(drawn.code, error.code), [*drawn.messages, str(error)]
                    break
                code, saved, err, kept = _run(name, [cut[0], "-o", folder])
            if cut:
                err = err.replace(cut[0], result_path)  # the file of the point will be gone
            drawn.files += [f for f in saved if f.endswith(".svg") and f not in drawn.files]
            drawn.kept += kept
            drawn.notes += [line for line in err.splitlines() if not code and line not in kept]
            if code in (1, streams.CANNOT_WRITE):
                said = err.strip().splitlines()[-1] if err.strip() else "failed"
                drawn.broken.append(f"{name}: {said.removeprefix(f'{COMMAND} {name}: ')}")
                drawn.code = max(drawn.code, code)
            elif code:
                drawn.code = max(drawn.code, code)
                drawn.messages.append(err.strip().replace(f"{result_path}: ", ""))
        if cut and point is None:
            drawn.notes.append(f"{result_path}: figures of one point are of point 0 of 0 to {count - 1} ({cut[1]}); of another with --point N")
    if drawn.files:  # that one of several drawers has nothing to draw is no news then
        drawn.notes = [note for note in drawn.notes if ": nothing to draw" not in note]
    return drawn
