"""What tests of the figures share: a plot script is run, and what it draws is read."""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SCRIPTS = Path(__file__).resolve().parent / "../../scripts"


def draw(script, *arguments):
    return subprocess.run([sys.executable, SCRIPTS / script, *arguments], capture_output=True, text=True, timeout=120)


class Drawing(unittest.TestCase):
    """`script` draws figures; test_plotting.py tests that the same result gives the same bytes."""
    script = None

    def figures(self, *arguments):
        """Names and contents of the figures that the script says it has written."""
        with tempfile.TemporaryDirectory() as folder:
            run = draw(self.script, "-o", folder, *arguments)
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertEqual(run.stderr, "")
            content = {Path(path).name: Path(path).read_bytes() for path in run.stdout.split()}
        for name, data in content.items():
            self.assertGreater(len(data), 10_000, name)
        return content

    def refused(self, code, word, *arguments):
        run = draw(self.script, *arguments)
        self.assertEqual(run.returncode, code, run.stderr)
        self.assertIn(word, run.stderr)
        self.assertNotIn("Traceback", run.stderr)
