"""surveymc from Python: runs configs, and reads results as pandas, xarray and numpy.

    import surveymc
    result = surveymc.run("configs/examples/own_well.toml", set={"noise.magnetometer_nT": 50.0})
    result.table("position")
    result.ellipse(propagation="joint").outline(k=2)
    surveymc.sweep("configs/examples/own_well.toml", {"noise.scale": [0.5, 1.0]}, table="position")
    surveymc.open("results/thesis/table8.h5").tables
    surveymc.plot(result)

Frames and units are those of surveymc's docs/conventions.md: north, east, vertical (down) in metres; azimuths in degrees
clockwise from north. Nothing stays open: every access opens the file, reads, and closes it.
"""

import importlib.util as _importlib

_missing = [name for name in ("h5py", "numpy", "xxhash") if _importlib.find_spec(name) is None]
if _missing:
    import sys as _sys

    raise ImportError(
        f"surveymc needs {', '.join(_missing)}, which {_sys.executable} does not have. Install what is missing "
        f"({_sys.executable} -m pip install {' '.join(_missing)}; on Debian: sudo apt install "
        f"{' '.join('python3-' + name for name in _missing)}), or use the Python that has it: on Debian /usr/bin/python3.",
        name=_missing[0])

from .ellipse import Ellipse  # noqa: E402
from .figures import Figures, plot  # noqa: E402
from .program import RunError, find_program, run, sweep  # noqa: E402
from .result import NotFound, Result  # noqa: E402
from .storage import ResultError  # noqa: E402

__all__ = ["Ellipse", "Figures", "NotFound", "Result", "ResultError", "RunError", "find_program", "open", "plot", "run",
           "sweep"]
__version__ = "0.1.0"


def open(path):
    """The result in the file `path`. ResultError if it cannot be read or is not a result of surveymc."""
    return Result(path)
