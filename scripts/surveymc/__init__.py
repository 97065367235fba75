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

from .ellipse import Ellipse
from .figures import Figures, plot
from .program import RunError, find_program, run, sweep
from .result import NotFound, Result
from .storage import ResultError

__all__ = ["Ellipse", "Figures", "NotFound", "Result", "ResultError", "RunError", "find_program", "open", "plot", "run",
           "sweep"]
__version__ = "0.1.0"


def open(path):
    """The result in the file `path`. ResultError if it cannot be read or is not a result of surveymc."""
    return Result(path)
