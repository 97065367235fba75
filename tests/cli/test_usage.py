#!/usr/bin/python3
"""Wrong command lines, files that never end, signals and limits: test_usage.py SURVEYMC SOURCE_FOLDER [unittest arguments]"""
import os
import re
import resource
import signal
import subprocess
import sys
import time
import unittest
from pathlib import Path

import test_cli
from test_cli import BAD_INPUT, CANNOT_WRITE, INTERRUPTED, USAGE, Case

NO_MEANS = 71


class CommandLine(Case):
    def test_the_nearest_word_is_offered(self):
        for words, says in [
            (["rnu", "base.toml"], "surveymc: rnu is not expected: did you mean run\\?"),
            (["chekc"], "did you mean check\\?"), (["compl"], "did you mean completion\\?"), (["shwo", "x.h5"], "did you mean show\\?"),
            (["repotr", "x.h5"], "did you mean report\\?"), (["nothing"], "nothing is not expected\n"),
            (["run", "base.toml", "--trails", "100"], "surveymc run: --trails is not expected: did you mean --trials\\?"),
            (["run", "--trails", "100", "base.toml"], "did you mean --trials\\?"), (["run", "--trails"], "did you mean --trials\\?"),
            (["run", "base.toml", "--outptu=x"], "--outptu=x is not expected: did you mean --output\\?"),
            (["show", "x.h5", "--cvs"], "did you mean --csv\\?"), (["check", "base.toml", "--resume"], "--resume of surveymc run\\?"),
            (["-version"], "did you mean --version\\?"), (["run", "base.toml", "other.toml"], "other.toml is not expected\n"),
        ]:
            with self.subTest(words=words):
                self.refused(USAGE, *words, says=says)

    def test_a_wrong_command_line_is_64_for_every_command(self):
        out = self.call("--help").stdout
        commands = re.findall(r"(?m)^  ([a-z]+)  ", out.split("Subcommands:")[1])
        self.assertGreaterEqual(len(commands), 11)
        for command in commands:
            with self.subTest(command=command):
                by_python = command in ("plot", "report", "import", "studies")
                self.refused(USAGE, command, "--nonsense", says=f"surveymc {command}: " if by_python else "--nonsense is not expected")
        for words, says in [
            (["run", "base.toml", "--trial", "600"], "--trial 600: .*numbered 0 to 599"),
            *[(["run", "base.toml", "--trials", n], f"--trials {re.escape(n)}: must be a whole number, 0 or more, such as 20000, 2e4 or 20k")
              for n in ["many", "1.5", "10 k", "10kk", "k", "1e", "-1", "1,000", "1e16", "nan", "inf"]],
            (["run", "base.toml", "--max-seconds", "nan"], "--max-seconds: must be a finite number, not nan"),
            (["run", "base.toml", "--checkpoint-seconds", "nan"], "must be a finite number"),
            (["diff", "a.h5", "b.h5", "--level", "nan"], "must be a finite number"),
            (["diff", "a.h5", "b.h5", "--tolerance", "inf"], "must be a finite number"),
            (["run", "base.toml", "--seed", "-1"], "--seed -1"), (["run", "base.toml", "--point", "1"], "--point 1: .*0 to 0"),
            (["run", "base.toml", "--max-seconds", "0"], "--max-seconds: must be a number > 0, not 0\n"),
            (["run", "base.toml", "--shard", "0/0"], "--shard 0/0: there must be at least one shard"),
            (["run", "base.toml", "--point", "0", "--units", "ft"], "--units ft: a part prints no tables"),
            (["run", "base.toml", "--shard", "0/2", "--compress", "3"], "--compress 3: a part is not compressed"),
            *[(["run", "base.toml", "--trial", "3", *others], f"--trial excludes {others[0]}|{others[0]} excludes --trial") for others in
              (["--output", "x.h5"], ["--check"], ["--shard", "1/4"], ["--units", "ft"], ["--compress", "3"], ["--resume"],
               ["--overwrite"], ["--array"])],
            (["show", "x.h5", "t", "--csv", "--rows", "2"], "excludes --"), (["show", "x.h5", "--json", "--rows", "2"], "excludes --"),
            (["show", "x.h5", "--rows", "-1"], "--rows: must be a number, 0 or more, not -1\n"),
            (["diff", "a.h5", "b.h5", "--tolerance", "-.5"], "--tolerance: must be a number, 0 or more, not -.5\n"),
            (["run", "base.toml", "--shard", "1"], "must be I/N"), (["run", "base.toml", "--shard", "4/4"], "numbered 0 to 3"),
            (["run", "base.toml", "--array"], "SLURM_ARRAY_TASK_ID is not set"), (["run", "base.toml", "--shards", "2"], "--array"),
            (["run", "base.toml", "--point", "0", "--check"], "--check: a part has no verdicts"),
            (["plan", "base.toml"], "say --count, --missing"), (["plan", "base.toml", "--count", "--shards", "0"], "--shards 0"),
            (["models", "MWD+IFR9"], 'did you mean "MWD\\+IFR1"\\?'), (["completion", "csh"], "csh"),
            (["check", "base.toml", "--set", "trials"], "--set trials: must be KEY=VALUE"),
        ]:
            with self.subTest(words=words):
                self.refused(USAGE, *words, says=says)

    def test_numbers_of_trials_as_people_write_them(self):
        for words, trials in [(["--trials", "1e3"], 1000), (["--trials", "2.5k"], 2500), (["--trials", "2M"], 2000000), (["--trials", "700"], 700),
                              (["--set", "trials=1e3"], 1000)]:
            with self.subTest(words=words):
                out = self.call("check", "base.toml", *words).stdout
                self.assertRegex(out, rf"(?m)^trials = {trials}(\.0)?$")
                self.assertIn(f", {trials} trials in all", out)

    def test_a_file_of_another_kind_is_named_with_the_commands_for_it(self):
        self.call("run", "base.toml", "-o", "out.h5", timeout=60)
        (self.folder / "parts").mkdir()
        self.call("run", "base.toml", "--shard", "0/2", "-o", "parts/a.part", timeout=60)
        self.write("tool.toml", self.call("models", "MWD+IFR1").stdout)
        self.write("readings.csv", "# six axes\nmd_m,gx_mps2,gy_mps2,gz_mps2,bx_nT,by_nT,bz_nT\n")
        self.write("gauges.csv", "timestamp,pdg_kPa\n")
        self.write("run.h5.journal.host.12", "SMCJRNL1")
        kinds = {
            "base.toml": ("a config", ["surveymc check base.toml", "surveymc run base.toml"]),
            "out.h5": ("a result", ["surveymc show out.h5", "surveymc plot out.h5", "surveymc rerun out.h5"]),
            "parts/a.part": ("a part of a run", ["surveymc status parts", "surveymc merge parts -o result.h5"]),
            "survey.csv": ("a survey", ["surveymc new position_covariance -o well.toml", "surveymc run well.toml --set survey.file=survey.csv"]),
            "readings.csv": ("a table of readings", ["surveymc new estimate -o readings.toml", "surveymc run readings.toml --set readings=readings.csv"]),
            "gauges.csv": ("a table of gauges over time", ["surveymc new drift_monitoring -o gauges.toml"]),
            "tool.toml": ("a file of error models", ["surveymc models --file tool.toml"]),
            "run.h5.journal.host.12": ("the finished work of an interrupted run", ["surveymc run CONFIG --resume -o run.h5"]),
        }
        wants = {"check": "a config", "run": "a config", "plan": "a config", "show": "a result", "rerun": "a result", "refine": "a result",
                 "diff": "a result", "merge": "a part of a run", "models --file": "a file of error models"}
        rest = {"plan": ["--count"], "refine": ["-o", "next.toml"], "diff": ["out.h5"], "merge": ["-o", "new.h5"]}
        for command, wanted in wants.items():
            for file, (kind, commands) in kinds.items():
                if kind == wanted:
                    continue
                with self.subTest(command=command, file=file):
                    self.refused(USAGE, *command.split(), file, *rest.get(command, []), says=re.escape(
                        f"error: {command} {file}: must be {wanted}, but this is {kind}; commands for it:\n  " + "\n  ".join(commands)))
        self.refused(USAGE, "base.toml", says="base.toml is not expected: a command comes first, and this is a config; commands for it:\n"
                                              "  surveymc check base.toml\n")
        self.refused(BAD_INPUT, "status", "parts/a.part", says="parts/a.part: is no folder of parts and no config, but a part of a run; .*:\n  surveymc status parts")
        for command in ("keys", "new"):
            self.refused(USAGE, command, "base.toml", says=f"this is a config of one:\n  surveymc {command} msa_position")
        self.refused(USAGE, "models", "tool.toml", says="this is a file of error models; .*:\n  surveymc models --file tool.toml")
        self.call(*self.call("show", "base.toml", code=USAGE).stderr.splitlines()[1].split()[1:])  # the first command works as it stands

    def test_an_empty_file_is_called_empty(self):
        for name in ("empty.toml", "empty.h5", "empty.csv"):
            self.write(name, "")
        for command, wanted in [(["check"], "a config"), (["run"], "a config"), (["models", "--file"], "a file of error models")]:
            self.refused(BAD_INPUT, *command, "empty.toml", says=f"^error: empty.toml: is empty: must be {wanted}\n$")
        for command in ("show", "rerun"):
            self.refused(CANNOT_WRITE, command, "empty.h5", says="^error: empty.h5: is empty: must be a result\n$")
        self.refused(CANNOT_WRITE, "merge", "empty.h5", "-o", "out.h5", says="^error: empty.h5: is empty: must be a part of a run\n$")
        self.refused(BAD_INPUT, "check", "base.toml", "--set", "survey.file=empty.csv", says="empty.csv: is empty")

    def test_the_name_that_is_meant_is_offered_whatever_the_case(self):
        for code, words, says in [
            (USAGE, ["keys", "MSA_Position"], "did you mean msa_position\\?"), (USAGE, ["new", "Clearence"], "did you mean clearance\\?"),
            (USAGE, ["keys", "msa"], "did you mean msa_benefit or msa_position\\?"), (USAGE, ["new", "xyz"], "there are msa_position, "),
            (USAGE, ["models", "mwd+ifr1"], 'did you mean "MWD\\+IFR1"\\?'), (USAGE, ["SHOW", "x.h5"], "did you mean show\\?"),
            (USAGE, ["run", "base.toml", "--Trials", "5"], "did you mean --trials\\?"),
            (BAD_INPUT, ["check", "base.toml", "--set", "experiment=MSA_Position"], 'must be one of .*; did you mean "msa_position"\\?'),
            (BAD_INPUT, ["check", "base.toml", "--set", "estimator=MSA_Weighted"], 'must be one of .*; did you mean "msa_weighted"\\?'),
            (BAD_INPUT, ["check", "base.toml", "--set", "survey.toolface_zero=X"], 'must be one of "x", "y"; did you mean "x"\\?'),
            (BAD_INPUT, ["check", "base.toml", "--set", "FIELD.dip_deg=60"], "did you mean field\\?"),
            (BAD_INPUT, ["check", "base.toml", "--set", "Trials=600"], "did you mean trials\\?"),
        ]:
            with self.subTest(words=words):
                self.refused(code, *words, says=says)
        self.call("run", "base.toml", "-o", "out.h5", timeout=60)
        self.refused(BAD_INPUT, "show", "out.h5", "Postion", says='not in this file, which has .*; did you mean "position"\\?')

    def test_what_the_config_forbids_is_65(self):
        self.refused(BAD_INPUT, "run", "base.toml", "--trials", "1", says="trials = 1: must be in")
        self.refused(BAD_INPUT, "check", "base.toml", "--set", "nonsense=1", says="unknown key")

    def test_scripts_of_users_end_so_too(self):
        for words in (["report", "--nonsense", "x.h5"], ["import", "--nonsense", "x.csv"], ["import"], ["studies", "--nonsense"], ["plot"],
                      ["plot", "msa_position", "x.h5", "--nonsense"], ["plot", "nothing", "x.h5"]):
            with self.subTest(words=words):
                self.refused(USAGE, *words, says=f"surveymc {words[0]}")
        self.refused(USAGE, "studies", "--qiuck", says="did you mean --quick\\?")
        self.refused(USAGE, "plot", "MSA_Positon", "x.h5", says="surveymc plot: MSA_Positon: no drawer has this name: did you mean msa_position\\?")
        self.refused(USAGE, "import", "x.txt", "--Depth-Unt", "m", says="surveymc import: .*; did you mean --depth-unit\\?")

    def test_a_slurm_that_does_not_answer_is_said_so(self):
        (self.folder / "bin").mkdir()
        for name in ("sbatch", "squeue", "scontrol"):
            tool = self.folder / "bin" / name
            tool.write_text("#!/bin/sh\necho no controller >&2\nexit 1\n")
            tool.chmod(0o755)
        environment = {**os.environ, "PATH": f"{self.folder}/bin:{os.environ['PATH']}", "SURVEYMC": str(test_cli.EXECUTABLE)}
        done = subprocess.run([Path(test_cli.SOURCE) / "scripts/slurm/sweep.sh", "base.toml", "out"], cwd=self.folder, env=environment,
                              stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, NO_MEANS, done.stderr)
        self.assertRegex(done.stderr, r"(?m)^sweep.sh: squeue: Slurm does not answer: run this where .* surveymc run \S+base.toml --resume -o ")


class Inputs(Case):
    def test_what_is_no_file_is_refused_at_once(self):
        os.mkfifo(self.folder / "pipe")
        for name in ["pipe", "/dev/zero"]:
            with self.subTest(name=name):
                says = "it is a pipe or a device: save what it gives as a file"
                for command in ["check", "run", "plan"]:
                    self.refused(BAD_INPUT, command, name, *(["--count"] if command == "plan" else []), says=says, timeout=5)
                self.refused(BAD_INPUT, "check", "base.toml", "--set", f"survey.file={name}", says=says, timeout=5)
                self.refused(BAD_INPUT, "models", "--file", name, says=says, timeout=5)
                self.refused(CANNOT_WRITE, "merge", name, "-o", "out.h5", says=says, timeout=5)
                self.refused(CANNOT_WRITE, "show", name, says="not a regular file", timeout=5)
                self.refused(CANNOT_WRITE, "rerun", name, says="not a regular file", timeout=5)
                self.refused(CANNOT_WRITE, "run", "base.toml", "-o", name, says="refusing to overwrite", timeout=5)
        (self.folder / "parts").mkdir()
        os.mkfifo(self.folder / "parts/a.part")
        self.assertRegex(self.call("status", "parts", timeout=5, code=(0, BAD_INPUT, CANNOT_WRITE)).stderr, "parts/a.part: .*pipe or a device")
        self.refused(CANNOT_WRITE, "merge", "parts", "-o", "out.h5", says="parts/a.part: .*pipe or a device", timeout=5)
        os.mkfifo(self.folder / "base.h5.journal.x.1")  # no journal: passed over
        self.call("run", "base.toml", "-o", "base.h5", timeout=20)

    def test_what_is_too_large_is_refused_unread(self):
        for name, size, says, words in [("large.toml", 17, "17 MiB, at most 16 are read: a config has keys; data go to a CSV", []),
                                        ("large.csv", 257, "257 MiB, at most 256 are read: give only the rows", ["survey"])]:
            with open(self.folder / name, "wb") as file:
                file.truncate(size << 20)
            self.refused(BAD_INPUT, "check", *(["base.toml", "--set", f"survey.file={name}"] if words else [name]), says=says, timeout=5)


    def test_results_without_a_sweep_are_no_rounds(self):
        self.call("run", "base.toml", "-o", "a.h5", timeout=60)
        self.refused(BAD_INPUT, "merge", "a.h5", "a.h5", "-o", "out.h5", says=r"a\.h5: has no \[sweep\]: only rounds of a sweep are merged")


class Limits(Case):
    def test_threads_that_cannot_be_started(self):
        def little():  # room for one stack of a thread, not for seven
            resource.setrlimit(resource.RLIMIT_STACK, (1 << 30, 1 << 30))
            resource.setrlimit(resource.RLIMIT_AS, (3 << 29, 3 << 29))

        # OpenMP says it and ends the program: what there was stays.
        self.call("run", "base.toml", "-o", "out.h5", "--seed", "5")
        before = (self.folder / "out.h5").read_bytes()
        done = subprocess.run([test_cli.EXECUTABLE, "run", "base.toml", "-o", "out.h5", "--threads", "8"], cwd=self.folder,
                              capture_output=True, text=True, timeout=120, preexec_fn=little, env={**os.environ, "OMP_STACKSIZE": "512M"})
        self.assertNotEqual(done.returncode, 0)
        self.assertRegex(done.stderr, "(?i)thread")
        self.assertEqual((self.folder / "out.h5").read_bytes(), before)
        self.assertEqual([path.name for path in self.folder.glob(".out*")], [])
        self.call("run", "base.toml", "-o", "out.h5", "--threads", "1", before=little)


class Signals(Case):
    def stopped(self, words, after, number):
        """Seconds from the signal to the end, and what was said."""
        child = subprocess.Popen([test_cli.EXECUTABLE, *words], cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        time.sleep(after)
        self.assertIsNone(child.poll(), "ended before the signal came")
        start = time.monotonic()
        child.send_signal(number)
        said = child.communicate(timeout=60)[1]
        seconds = time.monotonic() - start
        self.assertEqual(child.returncode, INTERRUPTED, said)
        self.assertRegex(said, "(?m)^(\r.*)?interrupted: ")
        return seconds, said

    def test_while_a_million_points_are_run(self):
        for number, after in [(signal.SIGINT, 0.5), (signal.SIGTERM, 2)]:
            seconds, said = self.stopped(["run", "base.toml", "-o", f"x{number}.h5", "--set",
                                          "sweep.noise.scale={from = 1.0, to = 1000000.0, step = 1.0}"], after, number)
            self.assertLess(seconds, 20)  # measured: 0.2 s; a loaded machine gets its time
            self.assertFalse((self.folder / f"x{number}.h5").exists())

    def test_while_a_point_is_prepared(self):
        # A search of the bandwidth that takes minutes and looks at no flag.
        self.write("drift.toml", (test_cli.SOURCE / "configs/smoke/drift_monitoring.toml").read_text())
        search = "model.search.bandwidths={from = 0.1, to = 5.0, step = 0.00001}"
        seconds, said = self.stopped(["run", "drift.toml", "-o", "x.h5", "--set", search], 3, signal.SIGTERM)
        self.assertIn("nothing was written", said)
        self.assertLess(seconds, 20)
        self.assertEqual(sorted(os.listdir(self.folder)), ["base.toml", "drift.toml", "survey.csv"])

    def test_the_default_action_where_nothing_is_computed(self):
        self.call("run", "base.toml", "-o", "x.h5", "--set", "save_samples=600")
        child = subprocess.Popen([test_cli.EXECUTABLE, "show", "x.h5", "--json"], cwd=self.folder, stdout=subprocess.PIPE)
        time.sleep(0.5)  # it waits for a reader of what it prints
        child.terminate()
        self.assertEqual(child.wait(timeout=20), -signal.SIGTERM)
        child.stdout.close()


if __name__ == "__main__":
    test_cli.EXECUTABLE, test_cli.SOURCE = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
