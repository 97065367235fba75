#!/usr/bin/python3
"""Snakemake and GNU parallel, as docs/cluster.md has them; what sweep.sh asks of Slurm: test_workflows.py SURVEYMC SURVEYMC_MPI
SOURCE_FOLDER

Without a cluster; under Slurm, Snakemake is in test_slurm.py. What is not installed is skipped by name.
"""
import os
import shlex
import shutil
import subprocess
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "cli"))
from durability import Case  # noqa: E402

SERIAL, SOURCE = None, None


class Workflows(Case):
    def setUp(self):
        super().setUp()
        self.PROGRAM = [SERIAL]
        self.call("run", "small.toml", "-o", "serial.h5")
        self.serial = self.hash_of("serial.h5")

    # A name is no command.
    CONFIG, FOLDER = "s m;touch bad;$(touch bad).toml", "a b;touch bad;`touch bad`|&<'\"$HOME"

    def shell(self, command):
        done = subprocess.run(["bash", "-c", command], cwd=self.folder, text=True, capture_output=True,
                              env={**os.environ, "SURVEYMC": SERIAL, "HOME": str(self.folder)})
        self.assertEqual(done.returncode, 0, f"{command}\n{done.stdout}{done.stderr}")
        return done.stdout + done.stderr

    @unittest.skipUnless(shutil.which("snakemake"), "no snakemake")
    def test_snakemake(self):
        start = f"snakemake -s {SOURCE}/scripts/snakemake/Snakefile --cores 2 --config surveymc={SERIAL}"
        snakemake = f"{start} config=small.toml"
        self.shell(f"{snakemake} out=out")
        self.assertEqual(self.hash_of("out/small.h5"), self.serial)
        self.assertIn("Nothing to be done", self.shell(f"{snakemake} out=out"))
        (self.folder / "out/parts/points-1.part").unlink()
        self.shell(f"{snakemake} out=out shards=5 threads=2")
        self.assertEqual(self.hash_of("out/small.h5"), self.serial)
        self.shell(f"{snakemake} out=two tasks=2")
        self.assertEqual(sorted(p.name for p in (self.folder / "two/parts").iterdir()), ["points-0-2.part", "points-2.part"])
        self.assertEqual(self.hash_of("two/small.h5"), self.serial)
        shutil.copy(self.folder / "small.toml", self.folder / self.CONFIG)
        self.shell(f"{start} {shlex.quote('config=' + self.CONFIG)} {shlex.quote('out=' + self.FOLDER)}")
        self.assertEqual(self.hash_of(f"{self.FOLDER}/{Path(self.CONFIG).stem}.h5"), self.serial)
        self.assertFalse((self.folder / "bad").exists())

    @unittest.skipUnless(shutil.which("parallel"), "no GNU parallel")
    def test_gnu_parallel(self):
        line = ('parallel --joblog log --resume-failed -j 2 "$SURVEYMC" run small.toml --point {} --threads 1 --resume -o parts/ '
                '::: $("$SURVEYMC" plan small.toml --groups 2) && "$SURVEYMC" merge -o out.h5 parts')
        self.shell(line)
        self.assertEqual(self.hash_of("out.h5"), self.serial)
        self.shell(line)  # again: nothing to do but the merge
        self.assertEqual(self.hash_of("out.h5"), self.serial)

    def test_sweep_script(self):
        """A percent sign in the folder is none of sbatch's; a file system without locks is told of, a taken lock ends it."""
        tools = self.folder / "tools"
        tools.mkdir()
        for name in ("sbatch", "squeue", "scontrol", "flock"):
            (tools / name).write_text('#!/bin/sh\nexit "${flock_says:-0}"\n' if name == "flock" else "#!/bin/sh\n")
            (tools / name).chmod(0o755)
        script = f"PATH='{tools}':$PATH '{SOURCE}/scripts/slurm/sweep.sh' --dry-run small.toml 'a%b'"
        said = self.shell(script)
        self.assertIn("a%%b/logs/%A_%a.log", said)
        self.assertNotIn("no locks", said)
        said = self.shell(f"flock_says=1 {script}")
        self.assertIn("this file system has no locks", said)
        self.assertIn("--array=0-2", said)
        said = self.shell(f"flock_says=99 {script} || echo ended with $?")
        self.assertRegex(said, r"(?s)ended with 75\n.*another sweep.sh is at work")
        self.assertNotIn("--array", said)


if __name__ == "__main__":
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    SERIAL, _, SOURCE = str(Path(sys.argv.pop(1)).resolve()), sys.argv.pop(1), Path(sys.argv.pop(1)).resolve()
    unittest.main()
