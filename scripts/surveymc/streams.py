"""Standard output and error of the scripts, and how a script ends: as the program does.

What names and titles hold moves no cursor and turns no words around: control characters, marks of writing direction and
bytes that are not UTF-8 are printed as escapes. Output that is lost is no success: exit code 74, and 141 where the reader of
a pipe has gone.
"""

import errno
import io
import os
import re
import signal
import sys

CANNOT_WRITE, STOPPED, NO_READER = 74, 130, 141
_HIDDEN = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff\ufffe\uffff\ud800-\udfff]")


class Failure(Exception):
    """Ends a script with this message and exit code, without a traceback."""

    def __init__(self, message, code):
        super().__init__(message)
        self.code = code


class _OutputLost(Exception):
    """Standard output could not be written; no OSError, which scripts catch for their own files."""


def visible(text):
    """A text as it may stand on a terminal."""

    def escaped(found):
        code = ord(found[0])
        if 0xDC80 <= code <= 0xDCFF:  # a byte of a name that is not UTF-8, as Python holds it
            code -= 0xDC00
        return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}"

    return _HIDDEN.sub(escaped, text)


class _Stream(io.TextIOWrapper):
    def __init__(self, file, is_error):
        at = io.FileIO(file, "w", closefd=False)
        super().__init__(io.BufferedWriter(at), getattr(sys.stdout, "encoding", None) or "utf-8", "backslashreplace",
                         line_buffering=is_error or at.isatty())
        self._is_error = is_error

    def write(self, text):
        return self._guarded(super().write, visible(text))

    def flush(self):
        self._guarded(super().flush)

    def raw(self, data):
        """Bytes that are not to be escaped."""
        self.flush()
        self._guarded(self.buffer.write, data)
        self.flush()

    def _guarded(self, write, *text):
        try:
            return write(*text)
        except OSError as error:
            os.dup2(os.open(os.devnull, os.O_WRONLY), self.fileno())  # or Python tries once more when it ends
            if not self._is_error:  # what a full disk keeps stderr from saying, nobody can be told
                raise _OutputLost(error.errno) from None


def _take():
    """Streams that do as this module says. One that is closed is taken by nothing else: a file that is opened would be it."""
    for file in range(3):
        try:
            os.fstat(file)
        except OSError:
            os.open(os.devnull, os.O_RDONLY)  # writing to it fails as writing to a closed one does
    if sys.stdout is sys.__stdout__:  # else it was redirected within this process
        sys.stdout = _Stream(1, False)
    if sys.stderr is sys.__stderr__:
        sys.stderr = _Stream(2, True)


def run(main, command=None):
    """Calls main(), the command of this name, and exits with the code that it returns unless that is 0; a Failure becomes one line on stderr. Signals end it
    at once."""
    if command:
        sys.argv[0] = command
    _take()
    signal.signal(signal.SIGTERM, lambda number, _: sys.exit(128 + number))  # not without what ends its workers
    try:
        code = _code_of(main)
        sys.stdout.flush()
    except _OutputLost as lost:
        code = NO_READER if lost.args[0] == errno.EPIPE else CANNOT_WRITE
        if code == CANNOT_WRITE:
            print(f"{_script()}: standard output: cannot write: {os.strerror(lost.args[0])}", file=sys.stderr)
    if code:
        sys.exit(code)


def _script():
    return os.path.basename(sys.argv[0])


def _code_of(main):
    try:
        return main()
    except Failure as failure:
        print(f"{_script()}: {' '.join(str(failure).split())}", file=sys.stderr)
        return failure.code
    except KeyboardInterrupt:
        return STOPPED
    except SystemExit as end:
        if isinstance(end.code, str):
            print(end.code, file=sys.stderr)
            return 1
        return end.code
