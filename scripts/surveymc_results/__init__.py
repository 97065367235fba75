"""Reads result files of surveymc: tables as pandas, maps as xarray, error ellipses as numpy.

    import surveymc_results
    result = surveymc_results.open("results/thesis/table8.h5")
    result.table("position")
    result.ellipse(propagation="joint", case="test 3").outline(k=2)

Frames and units are those of surveymc's docs/conventions.md: north, east, vertical (down) in metres; azimuths in degrees
clockwise from north. Nothing stays open: every access opens the file, reads, and closes it.
"""

from .ellipse import Ellipse
from .result import NotFound, Result, ResultError

__all__ = ["Ellipse", "NotFound", "Result", "ResultError", "open"]
__version__ = "0.1.0"


def open(path):
    """The result in the file `path`. ResultError if it cannot be read or is not a result of surveymc."""
    return Result(path)
