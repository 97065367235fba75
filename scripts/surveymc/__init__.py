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

The package also holds the commands: surveymc.plots draws results, surveymc.report makes a page of them, surveymc.importer
reads surveys in other forms, surveymc.run_studies runs all configs. Each is loaded when it is asked for; `surveymc plot`, or
`python3 -m surveymc plot` without the program, starts one (__main__.py).
"""

import importlib as _importlib
import importlib.util as _util

_PLACES = {"Ellipse": "ellipse", "Figures": "figures", "NotFound": "result", "Result": "result", "ResultError": "storage",
           "ResultWarning": "result",
           "RunError": "program", "find_program": "program", "plot": "figures", "run": "program", "sweep": "program"}
__all__ = [*sorted(_PLACES), "open"]
__version__ = "0.2.0"


def __getattr__(name):
    """What reads results needs h5py; the importer, in the same package, must do without it."""
    if name not in _PLACES:
        raise AttributeError(f"module 'surveymc' has no attribute '{name}'")
    missing = [m for m in ("h5py", "numpy", "xxhash") if _util.find_spec(m) is None]
    if missing:
        import sys

        raise ImportError(
            f"surveymc needs {', '.join(missing)}, which {sys.executable} does not have. Install what is missing "
            f"({sys.executable} -m pip install {' '.join(missing)}; on Debian: sudo apt install "
            f"{' '.join('python3-' + m for m in missing)}), or use the Python that has it: on Debian /usr/bin/python3.",
            name=missing[0])
    found = getattr(_importlib.import_module(f".{_PLACES[name]}", __name__), name)
    globals()[name] = found
    return found


def __dir__():
    return sorted({*globals(), *_PLACES})


def open(path):
    """The result in the file `path`. ResultError if it cannot be read or is not a result of surveymc. What it says that its
    input was doubtful of is a ResultWarning, and Result.warnings."""
    result = __getattr__("Result")(path)
    result.warn()
    return result
