"""Opens result files. Everything of this package and of the drawers that reads one goes through `open_file`, so that a
file is checked in one place."""

import contextlib
import math
import os
import stat

import h5py
import numpy as np

from . import integrity

FORMAT, FORMAT_VERSION = "surveymc", 1


# What h5py raises where a file is damaged although its seal is right, or changes while it is read.
DAMAGE = (OSError, RuntimeError, KeyError, ValueError, TypeError, AttributeError, MemoryError)


def _hint(path):
    """What to do with a file of another kind that the program writes or reads."""
    path = os.fspath(path)
    if path.endswith(".toml"):
        return "; a config has its result by: surveymc run"
    return "; the parts of a run become a result by: surveymc merge" if os.path.splitext(path)[1][1:] == "part" else ""


class ResultError(Exception):
    """The file cannot be read, or is not what was asked for; the message is one line."""


def plain(value):
    """An attribute as int, float or str, whichever way HDF5 stored it."""
    if isinstance(value, bytes):
        return value.decode("utf-8")
    return value.item() if isinstance(value, np.generic) else value


def open_file(path):
    """The result file `path` as h5py.File, open for reading; use it in a `with` statement.

    ResultError if it is not there, cannot be read, is damaged, or is no result of a known format.
    """
    path = os.fspath(path)
    try:
        kind = os.stat(path).st_mode
    except (OSError, ValueError) as error:  # a name with a zero byte
        missing = isinstance(error, (FileNotFoundError, NotADirectoryError))
        raise ResultError(f"{path}: {'no such file' if missing else f'cannot be read: {error}'}") from None
    if stat.S_ISDIR(kind):
        raise ResultError(f"{path}: is a folder, not a result file")
    if not stat.S_ISREG(kind):
        raise ResultError(f"{path}: is not a regular file")
    try:
        seal = integrity.seal_of(path)
    except OSError as error:
        raise ResultError(f"{path}: cannot be read: {error.strerror}") from None
    if seal is False:
        raise ResultError(f"{path}: is damaged or was edited: its checksum does not match")
    try:
        file = h5py.File(path, "r")
    except OSError:
        raise ResultError(f"{path}: not an HDF5 file, or damaged{_hint(path)}") from None
    try:
        _check(file, path)
        _check_sizes(file, path)
        if seal is None:
            _check_contents(file, path)
    except DAMAGE:
        file.close()
        raise ResultError(f"{path}: is damaged: HDF5 cannot read it") from None
    except BaseException:
        file.close()
        raise
    return file


@contextlib.contextmanager
def sealed_file(path, mode="w"):
    """h5py.File to write into; sealed behind it as the program seals its own, so that readers believe it."""
    with h5py.File(path, mode, track_order=mode == "w" or None) as file:
        yield file
    with open(path, "rb+") as written:
        written.write(integrity.seal_for(written.read()))


_sizes_checked = set()  # files as os.stat() tells them apart: each is opened for every table


def _check_sizes(file, path):
    """ResultError if a dataset claims more values than the file can hold: reading it would ask for all the memory. 128: no
    compression makes a value smaller than 1/128 byte."""
    found = os.stat(path)
    size, known = found.st_size, (found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns)
    if known in _sizes_checked:
        return

    def check(name, item):
        if isinstance(item, h5py.Dataset) and math.prod(item.shape or ()) > 128 * size:
            raise ResultError(f"{path}: /{name} claims more values than the file can hold")

    file.visititems(check)
    _sizes_checked.add(known)


def _check_contents(file, path):
    """ResultError unless a file without a seal has the contents that its hash is of."""
    try:
        intact = integrity.content_hash(file) == plain(file.attrs["content_hash"])
    except (KeyError, OSError, RuntimeError, TypeError, ValueError, UnicodeDecodeError):
        intact = False
    if not intact:
        raise ResultError(f"{path}: is damaged or was edited: its contents do not match its content_hash")


def _check(file, path):
    """ResultError unless the open file is a result that this package knows how to read."""
    if plain(file.attrs.get("format", "")) != FORMAT:
        raise ResultError(f"{path}: not a result file of surveymc (attribute 'format' is not \"{FORMAT}\")")
    version = plain(file.attrs.get("format_version", FORMAT_VERSION))
    if version != FORMAT_VERSION:
        raise ResultError(f"{path}: format version {version} is not known here")
