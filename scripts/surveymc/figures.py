"""The figures that belong to a result, as files and in a notebook."""

import base64
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
        return "".join(f'<img style="max-width: 100%" alt="{os.path.basename(p)}" src="data:image/png;base64,{_base64(p)}">'
                       for p in self)


def _base64(path):
    with open(path, "rb") as file:
        return base64.b64encode(file.read()).decode("ascii")


def scripts_folder():
    """The folder of the plot scripts: around this package in a source tree and an installation, within it in a wheel."""
    for folder in (os.path.dirname(_PACKAGE), os.path.join(_PACKAGE, "scripts")):
        if os.path.exists(os.path.join(folder, "draw_result.py")):
            return folder
    raise ResultError(f"{_PACKAGE}: the plot scripts were not installed with this package")


def plot(result, folder=None, point=None):
    """Draws all figures of a result (a Result or a path) and returns their Figures.

    folder: where PNG and SVG files go (deleted with the Figures if it is not given). point: number of the sweep point of
    figures that show one (the first). ResultError, with the reason, if nothing could be drawn.
    """
    temporary = None if folder else tempfile.mkdtemp(prefix="surveymc-figures-")
    folder = os.fspath(folder) if folder else temporary
    command = [sys.executable, os.path.join(scripts_folder(), "draw_result.py"), getattr(result, "path", result), "-o", folder,
               *(["--point", str(point)] if point is not None else [])]
    path = os.pathsep.join(p for p in (os.path.dirname(_PACKAGE), os.environ.get("PYTHONPATH")) if p)
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, "PYTHONPATH": path, "MPLBACKEND": "Agg"})
    figures = Figures([p for p in done.stdout.splitlines() if p.endswith(".png")], temporary)
    if done.returncode:
        raise ResultError((done.stderr.strip().splitlines() or ["no figure"])[-1])
    return figures
