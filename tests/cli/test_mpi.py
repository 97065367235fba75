#!/usr/bin/python3
"""surveymc-mpi against surveymc: test_mpi.py SURVEYMC SURVEYMC_MPI MPIRUN SOURCE_FOLDER [unittest arguments]

Any number of ranks and threads writes the content hash of a serial run; interruptions and errors end all ranks.
SURVEYMC_EVERY: every how manyth smoke config is run on two ranks (1: all, with ctest -L nightly).
"""
import contextlib
import os
import random
import re
import signal
import subprocess
import sys
import time
import unittest
from pathlib import Path

from durability import BAD_INPUT, CANNOT_WRITE, DONE, INTERRUPTED, USAGE, Case

SERIAL, MPI, MPIRUN, SOURCE = None, None, None, None


def ranks(n):
    return [MPIRUN, "--allow-run-as-root", "--oversubscribe", "--bind-to", "none", "-n", str(n), MPI]


class Ranks(Case):
    def setUp(self):
        super().setUp()
        self.PROGRAM = [SERIAL]

    def mpi(self, n, *arguments, **more):
        return self.call(*arguments, program=ranks(n), **more)

    def test_ranks_and_threads_give_the_same_result(self):
        self.call("run", "small.toml", "-o", "whole.h5")
        for n, threads in ((1, 2), (2, 1), (3, 1), (2, 3)):
            self.mpi(n, "run", "small.toml", "-o", "m.h5", "--threads", threads)
            self.assertEqual(self.hash_of("m.h5"), self.hash_of("whole.h5"), (n, threads))
        self.assertRegex(self.mpi(3, "rerun", "whole.h5"), "identical")
        for point in range(3):
            self.mpi(2, "run", "small.toml", "--point", point, "--shard", "0/2", "-o", "p/")
            self.call("run", "small.toml", "--point", point, "--shard", "1/2", "-o", "p/")
        self.mpi(2, "merge", "-o", "merged.h5", "p")
        self.assertEqual(self.hash_of("merged.h5"), self.hash_of("whole.h5"))

    def test_smoke_configs(self):
        for config in sorted((SOURCE / "configs/smoke").glob("*.toml"))[::int(os.environ.get("SURVEYMC_EVERY", "1"))]:
            with self.subTest(config.stem):
                self.call("run", config, "-o", "a.h5")
                self.mpi(2, "run", config, "-o", "b.h5", "--threads", 1)
                self.assertEqual(self.hash_of("b.h5"), self.hash_of("a.h5"))

    def test_interrupted_and_resumed_with_any_number_of_ranks(self):
        self.call("run", "large.toml", "-o", "whole.h5")
        run = ("run", "large.toml", "-o", "out.h5", "--checkpoint-seconds", "0.01", "--resume", "--threads", 1)
        interrupted, seconds = 0, 0.05
        for n in (2, 3, 1, 2):
            done = subprocess.run([*ranks(n), *map(str, run), "--max-seconds", str(seconds)], cwd=self.folder, text=True, capture_output=True)
            self.assertIn(done.returncode, (DONE, INTERRUPTED), done.stderr)
            self.assertEqual(len(re.findall("interrupted: ", done.stderr)), done.returncode == INTERRUPTED, done.stderr)
            interrupted += done.returncode == INTERRUPTED
        self.assertGreater(interrupted, 0)
        self.call(*run)  # and without MPI
        self.assertEqual(self.hash_of("out.h5"), self.hash_of("whole.h5"))
        self.assertEqual(self.journals(), [])

    def test_signals(self):
        run = ("run", "endless.toml", "-o", "out.h5", "--checkpoint-seconds", "0.05", "--resume", "--threads", 1)
        # mpirun hands SIGUSR1 on. On SIGTERM and SIGINT it stops the ranks and exits with a code of its own.
        for number, code in ((signal.SIGUSR1, INTERRUPTED), (signal.SIGTERM, None)):
            got, err = self.interrupt(*run, number=number, program=ranks(2))
            if code is not None:
                self.assertEqual(got, code, err)
            self.assertRegex(err, "interrupted: what is done is kept")
            self.assertTrue(self.journals())

    def test_killed_ranks_lose_nothing(self):
        self.call("run", "large.toml", "-o", "whole.h5")
        run = ("run", "large.toml", "-o", "out.h5", "--checkpoint-seconds", "0.01", "--resume", "--threads", 1)
        for n in (2, 3):
            child = subprocess.Popen([*ranks(n), *map(str, run)], cwd=self.folder, stdout=subprocess.DEVNULL,
                                     stderr=subprocess.DEVNULL, start_new_session=True)
            while not self.journals() and child.poll() is None:
                time.sleep(0.005)
            own = subprocess.run(["ps", "-o", "pid=,args=", "--ppid", str(child.pid)], text=True, capture_output=True).stdout
            pids = [int(line.split()[0]) for line in own.splitlines() if "surveymc-mpi" in line]
            if pids:
                with contextlib.suppress(ProcessLookupError):  # it was faster
                    os.kill(random.Random(n).choice(pids), signal.SIGKILL)
            child.wait()
        self.mpi(2, *run)
        self.assertEqual(self.hash_of("out.h5"), self.hash_of("whole.h5"))

    def test_errors_come_once_and_end_all(self):
        for code, rule, *arguments in ((BAD_INPUT, "error: no.toml: ", "run", "no.toml"), (USAGE, "", "run"),
                                       (CANNOT_WRITE, "error: no/x.h5: ", "run", "small.toml", "-o", "no/x.h5"),
                                       (USAGE, "trials", "run", "small.toml", "--trials", "-1")):
            done = subprocess.run([*ranks(3), *arguments], cwd=self.folder, text=True, capture_output=True)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertIn(rule, done.stderr)
            self.assertLessEqual(done.stderr.count("error: "), 1, done.stderr)

    def test_a_rank_that_sees_other_files_is_named(self):
        # Rank 1 runs where the survey is another one.
        other = self.folder / "other"
        other.mkdir()
        for name in ("small.toml", "survey.csv"):
            (other / name).write_text((self.folder / name).read_text().replace("60,18,30,120", "60,18,31,120"))
        (self.folder / "here").symlink_to(".")
        script = self.folder / "rank.sh"
        script.write_text(f'#!/bin/sh\n[ "$OMPI_COMM_WORLD_RANK" = 1 ] && cd other\nexec {MPI} "$@"\n')
        script.chmod(0o755)
        self.call("run", "small.toml", "-o", "x.h5", program=[*ranks(2)[:-1], str(script)], code=CANNOT_WRITE,
                  says="error: rank 1: does not see the same run as rank 0")
        self.assertFalse((self.folder / "x.h5").exists())

    def test_version_and_dependencies(self):
        self.assertRegex(self.mpi(1, "--version"), "MPI v?[0-9]")
        self.assertRegex(self.call("--version"), "no MPI")
        libraries = subprocess.run(["ldd", SERIAL], text=True, capture_output=True).stdout
        self.assertNotIn("libmpi", libraries)


if __name__ == "__main__":
    if len(sys.argv) < 5:
        sys.exit(__doc__)
    SERIAL, MPI = (str(Path(sys.argv.pop(1)).resolve()) for _ in range(2))
    MPIRUN, SOURCE = sys.argv.pop(1), Path(sys.argv.pop(1)).resolve()
    if MPI.endswith("NOTFOUND") or not Path(MPI).exists():
        print("skipped: no MPI here")
        sys.exit(77)
    os.environ.setdefault("OMPI_MCA_btl", "self,tcp")  # loopback is enough, also in a container
    unittest.main()
