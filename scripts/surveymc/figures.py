"""The figures that belong to a result, as files and in a notebook."""

import base64
import html
import os
import shutil
import subprocess
import sys
import tempfile
import weakref

from .storage import ResultError

_PACKAGE = os.path.dirname(os.path.realpath(__file__))


class Figures(list):
    """Paths of PNG files; the SVG of each lies beside it. A notebook shows the figures. They are deleted with this list
    unless a folder was given."""

    def __init__(self, paths, temporary=None):
        super().__init__(paths)
        if temporary:
            weakref.finalize(self, shutil.rmtree, temporary, ignore_errors=True)

    def _repr_html_(self):
        return "".join(f'<img style="max-width: 100%" alt="{html.escape(os.path.basename(p))}" src="data:image/png;base64,{_base64(p)}">'
                       for p in self)


def _base64(path):
    with open(path, "rb") as file:
        return base64.b64encode(file.read()).decode("ascii")


def plot(result, folder=None, point=None):
    """Draws all figures of a result (a Result or a path) and returns their Figures.

    folder: where PNG and SVG files go (deleted with the Figures if it is not given). point: number of the sweep point of
    figures that show one (the first). ResultError, with the reason, if nothing could be drawn.
    """
    try:
        temporary = None if folder else tempfile.mkdtemp(prefix="surveymc-figures-")
    except OSError as error:
        raise ResultError(f"{tempfile.gettempdir()}: cannot make a folder for the figures: {error.strerror}") from None
    folder = os.fspath(folder) if folder else temporary
    result_path, folder = (f"./{p}" if p.startswith("-") else p for p in (os.fspath(getattr(result, "path", result)), folder))  # no options
    command = [sys.executable, "-P", "-m", "surveymc.plots", result_path, "-o", folder,
               *(["--point", str(point)] if point is not None else [])]
    path = os.pathsep.join(p for p in (os.path.dirname(_PACKAGE), os.environ.get("PYTHONPATH")) if p)
    try:
        done = subprocess.run(command, capture_output=True, env={**os.environ, "PYTHONPATH": path, "MPLBACKEND": "Agg"})
    except (OSError, ValueError) as error:  # no memory for a process, a zero byte in a name
        raise ResultError(f"{result_path}: cannot be drawn: {getattr(error, 'strerror', None) or error}") from None
    names = [os.path.basename(p) for p in done.stdout.decode(errors="replace").split("\n")]  # the folder may be printed as escapes
    figures = Figures([os.path.join(folder, n) for n in names if n.endswith(".png")], temporary)
    if done.returncode:
        raise ResultError((done.stderr.decode(errors="replace").strip().splitlines() or ["no figure"])[-1])
    return figures
