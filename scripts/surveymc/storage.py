"""Opens result files. Everything of this package and of the plot scripts that reads one goes through `open_file`, so that a
file is checked in one place."""

import os

import h5py
import numpy as np

from surveymc import integrity

FORMAT, FORMAT_VERSION = "surveymc", 1


# What h5py raises where a file is damaged although its seal is right, or changes while it is read.
DAMAGE = (OSError, RuntimeError, KeyError, ValueError, TypeError, AttributeError)


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
    if not os.path.exists(path):
        raise ResultError(f"{path}: no such file")
    if os.path.isdir(path):
        raise ResultError(f"{path}: is a folder, not a result file")
    if not os.access(path, os.R_OK):
        raise ResultError(f"{path}: cannot be read")
    seal = integrity.seal_of(path)
    if seal is False:
        raise ResultError(f"{path}: is damaged or was edited: its checksum does not match")
    try:
        file = h5py.File(path, "r")
    except OSError:
        raise ResultError(f"{path}: not an HDF5 file, or damaged") from None
    try:
        _check(file, path)
        if seal is None:
            _check_contents(file, path)
    except DAMAGE:
        file.close()
        raise ResultError(f"{path}: is damaged: HDF5 cannot read it") from None
    except BaseException:
        file.close()
        raise
    return file


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
