"""Writes files as the program does (lib/store/atomic_file.h): whole or not at all, regular files only, through links, and
never in the place of a file that somebody else has made. Every file of the scripts is written here.
"""

import contextlib
import errno
import hashlib
import itertools
import os
import secrets
import stat
import struct
import zlib

_ONE_NAME = (errno.EPERM, errno.EMLINK, errno.EINVAL, errno.ENOSYS, errno.ENOTSUP)  # of a file that cannot have a second name
_MOST_MARKED = 256 << 20  # bytes; no figure or page of ours is larger
_PNG_END = b"\0\0\0\0IEND\xaeB`\x82"


class NotRegular(OSError):
    """A folder, pipe or device where a file must be."""

    def __init__(self, path):
        super().__init__(errno.EINVAL, "must be a regular file, or none yet", path)


def read_regular(path, most=None):
    """All bytes of a regular file, or the first `most` + 1. OSError for a pipe or device, before it can block."""
    handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    if not stat.S_ISREG(os.fstat(handle).st_mode):
        os.close(handle)
        raise NotRegular(path)
    with os.fdopen(handle, "rb") as file:
        return file.read(-1 if most is None else most + 1)


def check_target(path):
    """OSError if write() would refuse what is there."""
    with contextlib.suppress(FileNotFoundError):
        if not stat.S_ISREG(os.stat(path).st_mode):
            raise NotRegular(path)


def write(path, data, is_ours):
    """Writes bytes to `path`; returns the name under which a file that was there is kept, or "".

    is_ours(name): whether the file may be replaced; any other is kept as NAME.1.ext, or the next free number. OSError if it
    cannot be written; what was there is there then, and no temporary file.
    """
    check_target(path)
    target = os.path.realpath(path)
    with _temporary(target, data) as temporary:
        check_target(target)
        kept = _keep(target) if os.path.lexists(target) and not is_ours(target) else ""
        os.replace(temporary, target)
    _sync_folder(target)
    return kept


def write_new(path, data):
    """Writes bytes to `path`, where no file may be: FileExistsError, also if one comes meanwhile."""
    check_target(path)
    target = os.path.realpath(path)
    with _temporary(target, data) as temporary:
        _rename_new(temporary, target)
    _sync_folder(target)


@contextlib.contextmanager
def _temporary(target, data):
    """A whole file with a random name beside its target, on the disk; removed if it still has that name afterwards."""
    name = os.path.join(os.path.dirname(target), f".surveymc-{secrets.token_hex(8)}.tmp")
    handle = os.open(name, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666)
    try:
        with os.fdopen(handle, "wb") as file:
            with contextlib.suppress(OSError):  # who may read the old file may read the new one
                os.fchmod(handle, stat.S_IMODE(os.stat(target).st_mode))
            file.write(data)
            file.flush()
            os.fsync(handle)
        yield name
    finally:
        with contextlib.suppress(FileNotFoundError):
            os.unlink(name)


def _rename_new(old, new):
    """Renames to a name that is free; FileExistsError if it is not."""
    try:
        os.link(old, new)
    except OSError as error:
        if error.errno not in _ONE_NAME:
            raise
        if os.path.lexists(new):
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), new) from None
        os.rename(old, new)
    else:
        os.unlink(old)


def _keep(target):
    """Gives a file the name NAME.1.ext, or the next free number, besides its own, which it has until it is replaced; where
    files have one name only, instead of its own."""
    stem, extension = os.path.splitext(target)
    for number in itertools.count(1):
        kept = f"{stem}.{number}{extension}"
        try:
            os.link(target, kept)
            return kept
        except FileExistsError:
            if os.path.samefile(target, kept):  # a killed attempt gave it that name
                return kept
        except OSError as error:
            if error.errno not in _ONE_NAME:
                raise
            if not os.path.lexists(kept):
                os.rename(target, kept)
                return kept


def _sync_folder(target):
    try:
        folder = os.open(os.path.dirname(target), os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    except OSError:  # one that may be written, but not read: the entry reaches the disk a little later
        return
    try:
        os.fsync(folder)
    except OSError as error:
        if error.errno == errno.EIO:  # others: a file system without fsync of folders
            raise
    finally:
        os.close(folder)


# --- files that say of themselves who has made them -----------------------------------------------------------------


def marked(data, maker):
    """A PNG, SVG or HTML file with a mark of its maker, over all its bytes: one that was edited since has no longer its mark."""
    mark = hashlib.sha256(maker.encode("utf-8", "surrogatepass") + b"\0" + data).hexdigest().encode()
    if data.endswith(_PNG_END):
        chunk = b"tEXtsurveymc\0" + mark
        return data[:-len(_PNG_END)] + struct.pack(">I", len(chunk) - 4) + chunk + struct.pack(">I", zlib.crc32(chunk)) + _PNG_END
    return data + b"<!-- surveymc " + mark + b" -->\n"


def is_marked_by(maker):
    """For write(): replaces what has the mark of this maker."""

    def is_ours(name):
        try:
            data = read_regular(name, _MOST_MARKED)
        except OSError:
            return False
        added = len(marked(_PNG_END, maker)) - len(_PNG_END) if data.endswith(_PNG_END) else len(marked(b"", maker))
        plain = data[:-added - len(_PNG_END)] + _PNG_END if data.endswith(_PNG_END) else data[:-added]
        return len(data) >= added and marked(plain, maker) == data

    return is_ours
