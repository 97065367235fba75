#!/usr/bin/python3
"""Snakemake and GNU parallel, as docs/cluster.md has them; what sweep.sh asks of Slurm; what refine.sh keeps:
test_workflows.py SURVEYMC SURVEYMC_MPI SOURCE_FOLDER

Without a cluster; under Slurm, Snakemake is in test_slurm.py. What is not installed is skipped by name.
"""
import os
import shlex
import shutil
import subprocess
import sys
import unittest
from pathlib import Path

import h5py

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

    def tools(self, squeue="exit 0"):
        """A PATH with a Slurm that does nothing."""
        tools = self.folder / "tools"
        tools.mkdir(exist_ok=True)
        for name in ("sbatch", "squeue", "scontrol", "flock"):
            (tools / name).write_text({"flock": '#!/bin/sh\nexit "${flock_says:-0}"\n', "squeue": f"#!/bin/sh\n{squeue}\n"}.get(name, "#!/bin/sh\n"))
            (tools / name).chmod(0o755)
        return f"PATH='{tools}':$PATH"

    def test_sweep_script(self):
        """A percent sign in the folder is none of sbatch's; a file system without locks is told of, a taken lock ends it."""
        script = f"{self.tools()} '{SOURCE}/scripts/slurm/sweep.sh' --dry-run small.toml 'a%b'"
        said = self.shell(script)
        self.assertIn("a%%b/logs/%A_%a.log", said)
        self.assertNotIn("no locks", said)
        said = self.shell(f"flock_says=1 {script}")
        self.assertIn("this file system has no locks", said)
        self.assertIn("--array=0-2", said)
        said = self.shell(f"flock_says=99 {script} || echo ended with $?")
        self.assertRegex(said, r"(?s)ended with 75\n.*another sweep.sh is at work")
        self.assertNotIn("--array", said)

    def test_numbers_of_the_sweep_script(self):
        """Leading zeros are none of octal's; what the environment says is looked at as what an option says."""
        sweep = f"{self.tools()} {SOURCE}/scripts/slurm/sweep.sh --dry-run small.toml"
        self.assertIn("--array=0-1 ", self.shell(f"{sweep} a --group 002"))
        self.assertIn("--array=0-8 ", self.shell(f"{sweep} b --shards 09"))
        self.assertIn("--array=0-4 ", self.shell(f"SURVEYMC_SHARDS=09 SURVEYMC_GROUP=02 {sweep} c"))
        self.assertIn("--cpus-per-task=8 ", self.shell(f"SURVEYMC_CPUS=08 {sweep} d"))
        for name, value in (("SHARDS", "x"), ("GROUP", "0"), ("GROUP", "00"), ("TASKS", "-1"), ("CPUS", "1.5"), ("CONCURRENT", "a[$(touch hit)]"),
                            ("MAX_SECONDS", "99999999999999999999")):
            option = "--" + name.lower().replace("_", "-")
            for command in (f"SURVEYMC_{name}={shlex.quote(value)} {sweep} e", f"{sweep} e {option} {shlex.quote(value)}"):
                said = self.shell(f"{command} || echo ended with $?")
                self.assertRegex(said, rf"(?s)ended with 64\nsweep.sh: {option} or SURVEYMC_{name} .*: must be a whole number")
        self.assertFalse((self.folder / "hit").exists() or (self.folder / "e").exists())

    def test_a_dry_run_needs_no_slurm(self):
        sweep = f"{SOURCE}/scripts/slurm/sweep.sh --dry-run small.toml out"
        said = self.shell(f"{self.tools('echo no controller >&2; exit 1')} {sweep}")
        self.assertIn("--array=0-2 ", said)
        self.assertIn("Slurm does not answer: as if its queue were empty", said)
        tools = self.folder / "tools"
        shutil.rmtree(tools)
        tools.mkdir()
        for name in ("bash", "dirname", "basename", "realpath", "mkdir", "cksum", "cut", "awk", "sed", "sort", "comm", "tr", "find", "grep", "wc",
                     "flock", "env"):
            (tools / name).symlink_to(shutil.which(name))
        self.assertIn("--array=0-2 ", self.shell(f"PATH='{tools}' {sweep}"))

    def boundary(self):
        """harm.toml, whose boundary takes two rounds of the shortest."""
        config = (SOURCE / "configs/sweeps/msa_harm_boundary.toml").read_text()
        for old, new in (("count = 14", "count = 4"), ("[10, 30, 100]", "[30]"), ("cell = 0.01", "cell = 0.17")):
            self.assertIn(old, config)
            config = config.replace(old, new)
        (self.folder / "harm.toml").write_text(config)
        return f"{SOURCE}/scripts/slurm/refine.sh harm.toml"

    def attribute(self, name, attribute):
        with h5py.File(self.folder / name) as file:
            return file.attrs[attribute]

    def test_rounds_of_another_seed_are_computed_again(self):
        refine = f"SURVEYMC_LOCAL=yes {self.boundary()} out"
        self.shell(f"{refine} -- --seed 5")
        before = {p: p.stat().st_mtime_ns for p in (self.folder / "out").glob("round-*/harm*.h5")}
        self.assertGreater(len(before), 1)
        self.shell(f"{refine} -- --seed 5")
        self.assertEqual({p: p.stat().st_mtime_ns for p in before}, before)  # nothing runs twice
        first = (self.folder / "out/harm.h5").read_bytes()
        self.assertIn("harm.1.h5", self.shell(f"{refine} -- --seed 6"))
        self.assertEqual(self.attribute("out/harm.h5", "seed"), 6)
        self.assertEqual((self.folder / "out/harm.1.h5").read_bytes(), first)
        self.assertIn("identical", self.call("rerun", "out/harm.h5"))
        self.shell(f"{refine} -- --seed 6 --set sensor.spread.bias_nT=60")
        self.assertIn("bias_nT = 60", self.attribute("out/harm.h5", "config"))
        self.assertFalse(list((self.folder / "out").glob(".surveymc-*")))

    def test_rounds_of_another_seed_on_slurm_are_refused(self):
        refine = f"{self.tools()} {self.boundary()} out"
        (self.folder / "out/round-0").mkdir(parents=True)
        self.call("run", "harm.toml", "--seed", 5, "-o", "out/round-0/harm.h5")
        said = self.shell(f"{refine} -- --seed 6 || echo ended with $?")
        self.assertRegex(said, "(?s)ended with 74\n.*round-0/harm.h5: is of another config, seed or options")
        self.assertFalse((self.folder / "out/harm.h5").exists())
        self.assertRegex(self.shell(f"SURVEYMC_ROUNDS=01 {refine} -- --seed 5 || echo ended with $?"), "ended with 1\n.*after 1 rounds")

    def test_rounds_keep_what_they_have_not_made(self):
        refine = f"SURVEYMC_LOCAL=yes {self.boundary()}"
        (self.folder / "a").mkdir()
        (self.folder / "a/harm.h5").write_text("mine")
        (self.folder / "a/elsewhere.h5").write_text("mine, too")
        self.shell(f"{refine} a")
        self.assertEqual((self.folder / "a/harm.1.h5").read_text(), "mine")
        (self.folder / "a/harm.h5").unlink()
        (self.folder / "a/harm.h5").symlink_to("elsewhere.h5")
        self.shell(f"{refine} a")
        self.assertTrue((self.folder / "a/harm.h5").is_symlink())
        self.assertEqual((self.folder / "a/elsewhere.1.h5").read_text(), "mine, too")
        (self.folder / "b").mkdir()
        (self.folder / "b/harm-1.toml").write_text("mine")
        self.assertRegex(self.shell(f"{refine} b || echo ended with $?"), "(?s)ended with 74\n.*harm-1.toml: is there, and is not of refine.sh")
        self.assertEqual((self.folder / "b/harm-1.toml").read_text(), "mine")
        (self.folder / "c").mkdir()
        os.mkfifo(self.folder / "c/harm.h5")
        self.assertRegex(self.shell(f"{refine} c || echo ended with $?"), "(?s)ended with 74\n.*harm.h5: must be a regular file")


if __name__ == "__main__":
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    SERIAL, _, SOURCE = str(Path(sys.argv.pop(1)).resolve()), sys.argv.pop(1), Path(sys.argv.pop(1)).resolve()
    unittest.main()
