#!/usr/bin/python3
"""scripts/slurm on a real Slurm: test_slurm.py SURVEYMC SURVEYMC_MPI|none SOURCE_FOLDER [unittest arguments]

Starts a private cluster of three nodes on loopback (slurm_sandbox.sh) and ends only that. Every result is compared with
the content hash of a serial run. Exit 77: skipped, since Slurm or munge is missing, or we are not root.
"""
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "cli"))
from durability import DONE, Case  # noqa: E402

HERE = Path(__file__).resolve().parent
SERIAL, MPI, SOURCE = None, None, None
LATER = 240  # s: patience; the machine may be busy
TOOLS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "scancel", "srun")


def free_ports(count):
    """The first of so many ports in a row that are free on loopback."""
    for first in range(21000 + os.getpid() % 500 * 20, 32000, 20):
        sockets = []
        try:
            for i in range(count):
                s = socket.socket()
                sockets.append(s)
                s.bind(("127.0.0.1", first + i))
            return first
        except OSError:
            continue
        finally:
            for s in sockets:
                s.close()
    raise OSError("no free ports")


class Sandbox:
    def __init__(self):
        self.folder = tempfile.mkdtemp(prefix="smc-slurm-", dir="/tmp")  # a short name: unix sockets
        os.environ.update(SLURM_SANDBOX_DIR=self.folder, SLURM_SANDBOX_PORT=str(free_ports(5)), SLURM_SANDBOX_CRED_EXPIRE="5")
        try:
            self.call("start")
        except Exception:
            self.stop()
            raise
        os.environ["SLURM_CONF"] = self.folder + "/etc/slurm.conf"

    def call(self, *arguments):
        done = subprocess.run(["bash", HERE / "slurm_sandbox.sh", *arguments], text=True, capture_output=True)
        if done.returncode:
            raise RuntimeError(f"slurm_sandbox.sh {' '.join(arguments)}: {done.stderr}")
        return done.stderr

    def stop(self):
        self.call("stop", "--wipe")
        shutil.rmtree(self.folder, ignore_errors=True)


class Slurm(Case):
    @classmethod
    def setUpClass(cls):
        cls.sandbox = Sandbox()
        cls.addClassCleanup(cls.sandbox.stop)

    def setUp(self):
        super().setUp()
        self.PROGRAM = [SERIAL]
        self.environment = {**os.environ, "SURVEYMC": SERIAL, "SURVEYMC_MPI": MPI or "", "SURVEYMC_HOME": str(SOURCE),
                            "OMPI_MCA_btl": "self,tcp"}
        self.addCleanup(lambda: self.slurm("scancel", "--user", "root"))

    def slurm(self, *command, code=DONE):
        done = subprocess.run(list(map(str, command)), cwd=self.folder, env=self.environment, text=True, capture_output=True)
        self.assertEqual(done.returncode, code, f"{command}\n{done.stdout}{done.stderr}\n{self.logs()}")
        return done.stdout

    def sweep(self, config, out, *options, code=DONE):
        return self.slurm(SOURCE / "scripts/slurm/sweep.sh", *options[:options.index("--")] if "--" in options else options, config,
                          out, *options[options.index("--"):] if "--" in options else (), code=code)

    def logs(self):
        return "\n".join(f"== {p.name}\n{p.read_text()}" for p in sorted(self.folder.glob("**/*.log")) + sorted(self.folder.glob("slurm-*")))

    def wait_for(self, what, condition, step=0.05):
        """step: seconds between two looks; to ask Slurm costs as much as to run a task of these tests."""
        end = time.monotonic() + LATER
        while not (found := condition()):
            self.assertLess(time.monotonic(), end, f"waited in vain for {what}\n{self.slurm('squeue', '-r')}\n{self.logs()}")
            time.sleep(step)
        return found

    def wait_for_empty_queue(self):
        self.wait_for("the end of all jobs", lambda: not self.slurm("squeue", "-h").strip(), step=0.4)

    def tasks(self, fmt="%i", states="R"):
        return self.slurm("squeue", "-h", "-r", "-t", states, "-o", fmt).split()

    def serial(self, config, *options):
        self.call("run", config, "-o", "serial.h5", *options)
        return self.hash_of("serial.h5")

    def large(self, trials):
        """The name of a config of three points that end later than what a test does in the middle."""
        path = self.folder / "large.toml"
        path.write_text(re.sub("trials = .*", f"trials = {trials}", path.read_text()))
        return path.name

    def program(self, line):
        """The program, whose `run` gets the options $more that a line of shell sets."""
        path = self.folder / "program"
        path.write_text(f'#!/bin/sh\n{line}\n[ "$1" = run ] || more=""\nexec {SERIAL} "$@" $more\n')
        path.chmod(0o755)
        self.environment["SURVEYMC"] = str(path)

    def test_a_sweep_is_submitted_once_and_merged(self):
        serial = self.serial("small.toml")
        self.assertIn("--array=0-2", subprocess.run([SOURCE / "scripts/slurm/sweep.sh", "--dry-run", "small.toml", "out"], cwd=self.folder,
                                                    env=self.environment, text=True, capture_output=True).stderr)
        self.assertRegex(self.sweep("small.toml", "out"), r"array \d+: tasks 0-2\nmerge \d+: .*/out/small.h5")
        self.wait_for_empty_queue()
        self.assertEqual(self.hash_of("out/small.h5"), serial, self.logs())
        self.assertRegex(self.sweep("small.toml", "out"), "all 3 parts are done")
        whole = (self.folder / "out/small.h5").read_bytes()
        (self.folder / "out/parts/point-00001.part").unlink()
        self.assertRegex(self.sweep("small.toml", "out"), r"array \d+: tasks 1\n")
        self.wait_for_empty_queue()
        self.assertEqual((self.folder / "out/small.h5").read_bytes(), whole)

    def test_groups_shards_and_changed_configs(self):
        changes = ("--", "--seed", "7", "--set", "field.dip_deg=61")
        serial = self.serial("small.toml", *changes[1:])
        self.assertRegex(self.sweep("small.toml", "g", "--group", 2, *changes), "tasks 0-1\n")
        self.assertRegex(self.sweep("small.toml", "s", "--shards", 5, "--group", 3, "--cpus", 2, *changes), "tasks 0-1\n")
        self.wait_for_empty_queue()
        for folder in "gs":
            self.assertEqual(self.hash_of(f"{folder}/small.h5"), serial, self.logs())
        self.assertEqual(len(list((self.folder / "s/parts").glob("*.part"))), 5)

    def test_rounds_along_a_boundary(self):
        config = (SOURCE / "configs/sweeps/msa_harm_boundary.toml").read_text()
        for old, new in (("count = 14", "count = 4"), ("[10, 30, 100]", "[30]"), ("cell = 0.01", "cell = 0.17")):
            self.assertIn(old, config)
            config = config.replace(old, new)
        (self.folder / "harm.toml").write_text(config)
        script = SOURCE / "scripts/slurm/refine.sh"
        self.environment["SURVEYMC_WAIT"] = "1"
        self.assertRegex(self.slurm(script, "--tasks", 2, "harm.toml", "out"), r"\n[2-9] round\(s\): .*/out/harm.h5")
        self.assertNotIn("array", self.slurm(script, "--tasks", 2, "harm.toml", "out"))  # nothing runs twice
        self.environment["SURVEYMC_LOCAL"] = "yes"
        self.slurm(script, "harm.toml", "here")
        self.assertEqual(self.hash_of("out/harm.h5"), self.hash_of("here/harm.h5"), self.logs())

    def test_an_incomplete_sweep_is_not_merged(self):
        (self.folder / "out/parts").mkdir(parents=True)
        (self.folder / "out/parts/point-00002.part").write_text("my notes")
        self.sweep("small.toml", "out")
        self.wait_for_empty_queue()
        self.assertRegex((self.folder / "out/logs/merge.log").read_text(), "points 2 are missing: see the logs, run sweep.sh again")
        self.assertFalse((self.folder / "out/small.h5").exists())
        self.assertEqual((self.folder / "out/parts/point-00002.part").read_text(), "my notes")

    def test_interrupted_lost_and_frozen_tasks(self):
        config = self.large(1_500_000)
        serial = self.serial(config)
        self.program('more="--checkpoint-seconds 0.05"')
        self.sweep(config, "out", "--sbatch", "--exclusive")
        frozen = self.wait_for("a journal of every task", self.freeze_all)
        self.assertRegex(self.sweep(config, "out", "--sbatch", "--exclusive"), "nothing to submit: 3 tasks and the merge")
        where = dict(zip(self.tasks("%K"), self.tasks("%N")))
        # Task 0 gets Slurm's signal (as 120 s before its time limit) and goes back in the queue by itself.
        job = self.tasks("%F")[0]
        self.slurm("scancel", "--signal=TERM", "--batch", f"{job}_0")
        os.kill(frozen["0"], signal.SIGCONT)
        self.wait_for("the requeue", lambda: "back in the queue" in self.logs())
        # The node of task 1 is lost with all that runs there; the one of task 2 only seems to be: its task is frozen ...
        self.sandbox.call("lose-node", where["1"][1:])
        self.sandbox.call("kill-node", where["2"][1:])
        for node in (where["1"], where["2"]):  # as SlurmdTimeout would find out
            self.slurm("scontrol", "update", f"NodeName={node}", "State=DOWN", "Reason=lost")
        self.wait_for("the other attempt at task 2", lambda: len(self.processes("point 2 ")) == 2 or self.part(2).exists())
        os.kill(frozen["2"], signal.SIGCONT)  # ... and comes back: two attempts at once
        self.wait_for_empty_queue()
        for node in (where["1"], where["2"]):
            self.sandbox.call("start-node", node[1:])
            self.wait_for(f"node {node}", lambda: self.back_in_service(node), step=0.4)
        self.assertEqual(self.hash_of("out/large.h5"), serial, self.logs())
        self.wait_for("the end of the first attempt", lambda: not self.processes("point "))
        self.assertEqual(self.journals(), [])
        self.wait_for("all nodes", lambda: self.slurm("sinfo", "-h", "-N", "-o", "%T").split() == ["idle"] * 3, step=0.4)

    def back_in_service(self, node):
        """Resumes a node that was set down. Slurm refuses to resume one that has come back by itself."""
        subprocess.run(["scontrol", "update", f"NodeName={node}", "State=RESUME"], env=self.environment, capture_output=True)
        return self.slurm("sinfo", "-h", "-n", node, "-o", "%T").strip() == "idle"

    def part(self, point):
        return self.folder / f"out/parts/point-{point:05d}.part"

    def processes(self, word):
        """Ours: pids of the tasks whose command has `word`."""
        found = []
        for p in Path("/proc").glob("[0-9]*/cmdline"):
            try:
                command = p.read_bytes().decode(errors="replace").replace("\0", " ")
            except OSError:
                continue
            if command.startswith(SERIAL) and str(self.folder) in command and word in command:
                found.append(int(p.parent.name))
        return found

    def freeze_all(self):
        """{task: pid} once every task has kept something; each is stopped as soon as it has."""
        pids = {}
        for point in range(3):
            own = self.processes(f"--point {point} ")
            if own and list((self.folder / "out/parts").glob(f"point-{point:05d}.part.journal.*")):
                os.kill(own[0], signal.SIGSTOP)
                pids[str(point)] = own[0]
            self.assertFalse(self.part(point).exists(), "a task was done before it could be interrupted: more trials")
        return pids if len(pids) == 3 else None

    def test_exit_75_and_cancelled_tasks(self):
        config = self.large(1_000_000)
        serial = self.serial(config)
        self.sweep(config, "cancelled", "--", "--trials", "10000000000")  # would last for hours
        self.wait_for("running tasks", lambda: len(self.processes("run ")) == 3)
        self.slurm("scancel", *{j for j in self.tasks("%F") if j})
        self.wait_for_empty_queue()  # none comes back
        self.program('[ -n "$SLURM_RESTART_COUNT" ] || more="--max-seconds 0.05 --checkpoint-seconds 0.01"')  # the first time
        self.sweep(config, "out", "--concurrent", 2)
        self.wait_for_empty_queue()
        self.assertEqual(self.logs().count("interrupted: back in the queue"), 3, self.logs())
        self.assertEqual(self.hash_of("out/large.h5"), serial, self.logs())

    @unittest.skipUnless(shutil.which("snakemake"), "no snakemake")
    def test_snakemake_on_slurm(self):
        serial = self.serial("small.toml")
        self.environment["HOME"] = str(self.folder)
        self.slurm("snakemake", "-s", SOURCE / "scripts/snakemake/Snakefile", "--profile", SOURCE / "scripts/snakemake/slurm", "--jobs", 6,
                   "--config", f"surveymc={SERIAL}", "config=small.toml", "out=out")
        self.assertEqual(self.hash_of("out/small.h5"), serial, self.logs())
        self.assertEqual(len(list(self.folder.glob("slurm-*.log"))), 4)  # three parts and the merge were jobs

    def test_a_job_of_ranks(self):
        if not MPI:
            self.skipTest("no surveymc-mpi")
        plugins = subprocess.run(["srun", "--mpi=list"], text=True, capture_output=True, env=self.environment)
        if "pmix" not in plugins.stdout + plugins.stderr:
            self.skipTest("this Slurm has no pmix")
        config = self.large(1_000_000)
        serial = self.serial(config)
        self.slurm("sbatch", "--ntasks=4", "--cpus-per-task=1", "--output=slurm-mpi.log", SOURCE / "scripts/slurm/mpi.sbatch", config, "mpi.h5",
                   "--max-seconds", "2", "--checkpoint-seconds", "0.2")
        self.wait_for_empty_queue()
        self.assertTrue((self.folder / "mpi.h5").exists(), self.logs())
        self.assertEqual(self.hash_of("mpi.h5"), serial, self.logs())


def why_not():
    for tool in TOOLS:
        if not shutil.which(tool):
            return f"{tool} is missing (Debian: slurm-wlm munge)"
    return "slurmctld wants root" if os.geteuid() else None


def name_on_loopback():
    try:
        return socket.gethostbyname(socket.gethostname().split(".")[0]).startswith("127.")
    except OSError:
        return False


if __name__ == "__main__":
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    if reason := why_not():
        print("skipped:", reason)
        sys.exit(77)
    if not name_on_loopback() and "SURVEYMC_OWN_HOST_NAME" not in os.environ:  # a host name of our own, which is
        os.environ["SURVEYMC_OWN_HOST_NAME"] = "yes"
        inner = ["unshare", "--uts", "sh", "-c", 'hostname localhost && exec "$@"', "sh", sys.executable, *sys.argv]
        sys.exit(subprocess.run(inner).returncode)
    SERIAL, mpi, SOURCE = str(Path(sys.argv.pop(1)).resolve()), sys.argv.pop(1), Path(sys.argv.pop(1)).resolve()
    MPI = str(Path(mpi).resolve()) if Path(mpi).exists() else None
    unittest.main()
