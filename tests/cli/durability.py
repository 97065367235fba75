"""What the durability tests share: a folder with a survey and configs, runs that are killed, content hashes."""
import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

import h5py

DONE, USAGE, BAD_INPUT, CANNOT_WRITE, INTERRUPTED = 0, 64, 65, 74, 75
PATIENCE = 900  # s: the machine may be busy; no test depends on how fast it is

SURVEY = """\
md_m,inclination_deg,azimuth_deg,toolface_deg
0,10,20,0
30,14,25,50
60,18,30,120
90,22,37,200
120,28,44,300
150,33,52,40
"""
CONFIG = """\
experiment = "msa_position"
seed = 1
trials = {trials}
estimator = "msa"
save_samples = 3
[survey]
file = "survey.csv"
toolface_zero = "y"
[field]
total_nT = 50000.0
dip_deg = 60.0
[noise]
magnetometer_nT = 50.0
[sweep]
noise.scale = [1.0, 0.5, 0.1]
"""
MAPS = """\
experiment = "reliability_map"
seed = 1
mode = "sse"
observation = "bx"
inclination_deg = 30.0
toolface_deg = { from = 0.0, to = 180.0, step = 45.0 }
magnetic_azimuth_deg = [0.0, 60.0, 90.0]
[sweep]
alpha = [1e-4, 1e-3]
"""


def content_hash(path):
    with h5py.File(path, "r") as f:
        return f.attrs["content_hash"]


class Case(unittest.TestCase):
    PROGRAM = []  # command that starts surveymc

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="surveymc-durability-")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        (self.folder / "survey.csv").write_text(SURVEY)
        (self.folder / "small.toml").write_text(CONFIG.format(trials=5000))
        (self.folder / "large.toml").write_text(CONFIG.format(trials=400_000))
        (self.folder / "endless.toml").write_text(CONFIG.format(trials=10_000_000_000))
        (self.folder / "maps.toml").write_text(MAPS)

    def call(self, *arguments, code=DONE, says=r"(?s).*", env=None, program=None):
        done = subprocess.run([*(program or self.PROGRAM), *map(str, arguments)], cwd=self.folder, text=True, capture_output=True,
                              timeout=PATIENCE, env={**os.environ, **(env or {})})
        told = f"{arguments}\n{done.stdout}{done.stderr}"
        self.assertEqual(done.returncode, code, told)
        self.assertNotRegex(done.stdout + done.stderr, "internal error|terminate called|Sanitizer", told)
        self.assertRegex(done.stdout + done.stderr, says)
        return done.stdout

    def hash_of(self, name):
        return content_hash(self.folder / name)

    def journals(self):
        return sorted(self.folder.glob("**/*.journal.*"))

    def temporaries(self):
        return [p.name for p in self.folder.iterdir() if p.name.startswith(".")]

    def start(self, *arguments, program=None):
        return subprocess.Popen([*(program or self.PROGRAM), *map(str, arguments)], cwd=self.folder, stdout=subprocess.DEVNULL,
                                stderr=subprocess.PIPE, text=True)

    def interrupt(self, *arguments, number=signal.SIGKILL, after=None, program=None):
        """Exit code and stderr of a run that gets a signal after so many seconds; None: when its journal has grown."""
        child = self.start(*arguments, program=program)
        if after is None:
            size = lambda: sum(p.stat().st_size for p in self.journals())
            before, end = size(), time.monotonic() + PATIENCE
            while size() <= before and child.poll() is None and time.monotonic() < end:
                time.sleep(0.005)
        else:
            time.sleep(after)
        child.send_signal(number)
        _, err = child.communicate(timeout=PATIENCE)
        return child.returncode, err

    def run_until_done(self, *arguments, program=None):
        """Runs with --max-seconds and --resume, longer each time, until it is done; how often it was interrupted."""
        seconds, interrupted = 0.02, 0
        while True:
            done = subprocess.run([*(program or self.PROGRAM), *map(str, arguments), "--resume", "--max-seconds", f"{seconds:.4f}"],
                                  cwd=self.folder, capture_output=True, text=True, timeout=PATIENCE)
            if done.returncode == DONE:
                return interrupted
            self.assertEqual(done.returncode, INTERRUPTED, done.stderr)
            interrupted += 1
            seconds *= 1.5
            self.assertLess(seconds, PATIENCE)


def program_from_arguments(doc):
    """The executable; the rest of the arguments are unittest's."""
    if len(sys.argv) < 2:
        sys.exit(doc)
    Case.PROGRAM = [str(Path(sys.argv.pop(1)).resolve())]
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # nohup has it ignored, and the program would ignore it too
