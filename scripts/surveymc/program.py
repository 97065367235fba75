"""Runs the program surveymc: one config to one result, or a sweep to one table."""

import contextlib
import os
import shutil
import subprocess
import tempfile
import tomllib
import weakref

from . import toml
from .result import Result
from .storage import ResultError

_HERE = os.path.dirname(os.path.realpath(__file__))
_EXIT_CODES = {1: "a verdict is not the expected one", 64: "usage", 65: "bad config or data", 70: "internal error",
               74: "cannot read or write a result", 75: "interrupted"}


class RunError(Exception):
    """The program did not run to its end. `exit_code` is the program's (65: bad config or data; None: it could not be
    started or a signal ended it); the message is what the program said, with place, value and rule."""

    def __init__(self, message, exit_code=None):
        super().__init__(message)
        self.exit_code = exit_code


def find_program():
    """Path of the program: $SURVEYMC, or the one in this package (a wheel), or that of this source tree (build/surveymc), or of
    this installation (bin/ of the same prefix), or the one on the PATH. RunError if there is none."""
    named = os.environ.get("SURVEYMC")
    if named:
        if not shutil.which(named):
            raise RunError(f"SURVEYMC={named}: no such program")
        return shutil.which(named)
    tree = os.path.dirname(os.path.dirname(_HERE))  # of scripts/surveymc
    prefix = os.path.dirname(os.path.dirname(tree))
    for place in (os.path.join(_HERE, "_native", "bin", "surveymc"), os.path.join(tree, "build", "surveymc"), os.path.join(prefix, "bin", "surveymc")):
        if os.path.isfile(place) and os.access(place, os.X_OK):
            return place
    found = shutil.which("surveymc")
    if not found:
        raise RunError("the program surveymc is not found: build it, install it, or name it in the environment variable SURVEYMC")
    return found


def run(config, set=None, threads=None, *, trials=None, seed=None, output=None, overwrite=False, folder=None, check=False):
    """Runs a config to its end and returns the Result.

    config: path of a TOML file, or its content as nested dicts, whose file names are relative to `folder` (the current
    one). set: {"noise.scale": 0.5, ...}, keys that are replaced, checked as those of the file are. threads: all cores by
    default; the result does not depend on it. trials, seed: instead of the config's. output: result file to write; by
    default one that is deleted when the Result is no longer used (`Result.path`, copy it to keep it). An existing one is kept
    as NAME.1.h5, or the next free number, unless overwrite. check: RunError with exit_code 1 if a verdict is not the one that
    the config expects.

    What is doubtful in the input is a ResultWarning, and Result.warnings. RunError with the program's message if the config, its data or the output is refused.
    """
    try:
        options = [f"--set={key}={toml.value(new)}" for key, new in (set or {}).items()]
        options += [f"--{name}={int(number)}" for name, number in (("threads", threads), ("trials", trials), ("seed", seed))
                    if number is not None]
        config = config if isinstance(config, dict) else os.fspath(config)
        folder = os.fspath(folder or ".")
        output = output if output is None else os.fspath(output)
    except (AttributeError, TypeError, ValueError, OverflowError, RecursionError) as error:
        raise RunError(f"arguments of run: {error}", 65) from None
    options += ["--check"] if check else []
    with _written(config, folder) if isinstance(config, dict) else contextlib.nullcontext(config) as path:
        if output is not None:
            _call(["run", path, *options, "--output", output, *(["--overwrite"] if overwrite else [])])
            result = _read(output)
            result.warn(stacklevel=2)
            return result
        try:
            keeper = tempfile.TemporaryDirectory(prefix="surveymc-")
        except OSError as error:
            raise RunError(f"{tempfile.gettempdir()}: cannot make a folder for the result: {error.strerror}", 74) from None
        try:
            kept = os.path.join(keeper.name, "result.h5")
            _call(["run", path, *options, "--output", kept])
            result = _read(kept)
        except BaseException:
            keeper.cleanup()
            raise
        weakref.finalize(result, keeper.cleanup)
        result.warn(stacklevel=2)
        return result


def sweep(config, axes, table, set=None, threads=None, *, trials=None, seed=None, output=None, overwrite=False, folder=None):
    """Runs a config at every point of the product of `axes` and returns one of its tables as DataFrame.

    axes: {"noise.scale": [0.5, 1.0], "estimator.name": [...]}: values of keys, taken instead of those that the config's own
    [sweep] has for these keys; its other axes stay. The DataFrame is that of Result.table(table): each axis is a column,
    and the points share their noise. Other arguments: as in `run`; the folder of a config that is a file must be writable,
    because the swept config is beside it as long as the program runs.
    """
    if not isinstance(config, dict):
        config, folder = _settings(config)
    inner = config.get("sweep", {})
    if not isinstance(inner, dict):
        raise RunError("config: sweep: must be a table", 65)
    try:
        swept = {**config, "sweep": {**inner, **{k: list(v) for k, v in axes.items()}}}
    except (AttributeError, TypeError) as error:  # a value in place of a list of them
        raise RunError(f"axes: must have a list of values for each key: {error}", 65) from None
    result = run(swept, set, threads, trials=trials, seed=seed, output=output, overwrite=overwrite, folder=folder)
    return result.table(table)


def _settings(path):
    """A config file as nested dicts, and its folder."""
    try:
        folder = os.path.dirname(os.fspath(path)) or "."
        if os.path.exists(path) and not os.path.isfile(path):
            raise RunError(f"{path}: must be a regular file", 65)
        with open(path, "rb") as file:
            return tomllib.load(file), folder
    except (OSError, RecursionError, TypeError) as error:
        raise RunError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}", 65) from None
    except ValueError as error:  # no TOML, not UTF-8, or a zero byte in the name
        raise RunError(f"{path}: not TOML: {error}", 65) from None


def _read(path):
    try:
        return Result(path)
    except ResultError as error:  # removed or damaged meanwhile
        raise RunError(str(error), 74) from None


@contextlib.contextmanager
def _written(settings, folder):
    """The path of a config that has these settings, in `folder`, where its file names are looked for."""
    try:
        text = toml.dumps(settings).encode()
    except (TypeError, ValueError, RecursionError) as error:
        raise RunError(f"config: {error}", 65) from None
    try:
        handle, path = tempfile.mkstemp(prefix=".surveymc-", suffix=".toml", dir=folder)
    except OSError as error:
        raise RunError(f"{folder}: cannot write the config there: {error.strerror}", 74) from None
    try:
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(text)
        except OSError as error:
            raise RunError(f"{folder}: cannot write the config there: {error.strerror}", 74) from None
        yield path
    except RunError as error:  # nobody knows the file by its name
        raise RunError(str(error).replace(os.path.abspath(path), "config").replace(path, "config"), error.exit_code) from None
    finally:
        with contextlib.suppress(FileNotFoundError):
            os.remove(path)


def _call(arguments):
    program = find_program()
    try:
        done = subprocess.run([program, *arguments], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                              text=True, errors="replace")
    except (OSError, ValueError) as error:  # not a program of this system, a list of options too long, a zero byte in a name
        raise RunError(f"{program}: cannot be run: {getattr(error, 'strerror', None) or error}") from None
    if done.returncode:
        said = done.stderr.strip().splitlines()
        starts = [i for i, line in enumerate(said) if line.startswith("error: ")]  # the last one may be a list of mistakes
        message = "\n".join(said[starts[-1]:]).removeprefix("error: ") if starts else said[-1] if said else ""
        meaning = _EXIT_CODES.get(done.returncode, f"exit code {done.returncode}")
        raise RunError(message or f"surveymc {arguments[0]}: {meaning}", done.returncode if done.returncode > 0 else None)
