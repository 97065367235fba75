"""What tests of the figures share: a drawer is run, and what it draws is read.

Matplotlib is loaded once: each drawer runs in a fork of this process, with arguments of its own. What one drawer does to
its interpreter, no other sees. A drawer whose figure has texts upon each other, cut off, or with a raw key in
place of words ends with the exit code ILLEGIBLE. test_plotting.py starts one as users do, too.
"""
import os
import signal
import sys
import tempfile
import traceback
import unittest
from pathlib import Path
from typing import NamedTuple

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
sys.path.insert(0, str(SCRIPTS))
import legible  # noqa: E402
import matplotlib  # noqa: E402
import matplotlib.pyplot as plt  # noqa: E402
from surveymc.plots import runner, saving  # noqa: E402

PATIENCE = 300  # s
ILLEGIBLE = 3


class Done(NamedTuple):
    returncode: int
    stdout: str
    stderr: str


def _run(drawer, arguments, names_only=False):
    """The drawer in this process: its exit code."""
    signal.alarm(PATIENCE)
    if names_only:
        saving.save = lambda figure, folder, name: print(os.path.join(folder, name + ".png"))
    said = []
    close = plt.close

    def look(figure=None):  # `save` closes a figure when it is as it is written
        if isinstance(figure, matplotlib.figure.Figure):
            said.extend(legible.faults(figure))
        close(figure)

    plt.close = look
    try:
        if callable(drawer):
            drawer()
        else:
            runner.start(drawer, arguments)
        print(*said, sep="\n", end="\n" if said else "", file=sys.stderr)
        return ILLEGIBLE if said else 0
    except SystemExit as end:
        if end.code is None or isinstance(end.code, int):
            return end.code or 0
        print(end.code, file=sys.stderr)
        return 1
    except BaseException:
        traceback.print_exc()
        return 1


def draw(drawer, *arguments, names_only=False):
    """A drawer (its name, or a function) with these arguments: its exit code, what it printed and what it said of errors.

    names_only: it makes its figures and says their names, but writes none.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        child = os.fork()
        if child == 0:
            code = 1
            try:
                os.dup2(out.fileno(), 1)
                os.dup2(err.fileno(), 2)
                sys.stdout, sys.stderr = open(1, "w", closefd=False), open(2, "w", closefd=False)
                code = _run(drawer, list(map(str, arguments)), names_only)
                sys.stdout.flush()
                sys.stderr.flush()
            finally:
                os._exit(code)
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        texts = []
        for file in (out, err):
            file.seek(0)
            texts.append(file.read())
        return Done(code, *texts)


class Drawing(unittest.TestCase):
    """The drawer `script` draws figures; test_plotting.py and same_bytes.py test that the same result gives the same bytes."""
    script = None

    def figures(self, *arguments):
        """Names and contents of the figures that the script says it has written; it has written no other file."""
        with tempfile.TemporaryDirectory() as folder:
            run = draw(self.script, "-o", folder, *arguments)
            self.assertEqual((run.returncode, run.stderr), (0, ""))
            content = {Path(path).name: Path(path).read_bytes() for path in run.stdout.split()}
            self.assertEqual(sorted(content), sorted(os.listdir(folder)))
        for name, data in content.items():
            self.assertTrue(data.startswith(b"\x89PNG\r\n\x1a\n" if name.endswith(".png") else b"<?xml"), name)
            self.assertGreater(len(data), 8_000, name)
        return content

    def assert_drawn(self, names, *arguments):
        """Exactly the figures of these names are drawn, each in both forms."""
        self.assertEqual(sorted(self.figures(*arguments)), sorted(n + e for n in names for e in (".png", ".svg")))

    def refused(self, code, word, *arguments):
        run = draw(self.script, *arguments)
        self.assertEqual(run.returncode, code, run.stderr)
        self.assertIn(word, run.stderr)
        self.assertNotIn("Traceback", run.stderr)
