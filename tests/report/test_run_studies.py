#!/usr/bin/python3
"""Tests of surveymc.run_studies (run_all.sh without the build): test_run_studies.py SURVEYMC"""
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

SCRIPTS = os.path.abspath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts"))
sys.path.insert(0, SCRIPTS)
import surveymc  # noqa: E402
from surveymc import run_studies, studies  # noqa: E402

SURVEYMC = ""


class Running(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def command(self, *arguments, program=None):
        return [sys.executable, os.path.join(SCRIPTS, "surveymc"), "studies", "--program", program or SURVEYMC, "--output", self.folder,
                "--threads", "1", *arguments]

    def go(self, *arguments, code=0, program=None):
        run = subprocess.run(self.command(*arguments, program=program), capture_output=True, text=True, timeout=120)
        self.assertEqual(run.returncode, code, run.stdout + run.stderr)
        return run.stdout + run.stderr

    def result(self, name):
        return os.path.join(self.folder, name + ".h5")

    def test_lists_every_study_and_no_other_config(self):
        quick = os.path.join(self.folder, "surveymc")  # no study is prepared to be named
        with open(quick, "w", encoding="utf-8") as file:
            file.write('#!/bin/sh\n[ "$1" = check ] && echo "# 1 sweep point, 1 trials in all; config hash 0" && exit\n'
                       f'exec {SURVEYMC} "$@"\n')
        os.chmod(quick, 0o755)
        names = [line.split()[0] for line in self.go("--list", program=quick).splitlines()]
        self.assertEqual(sorted(names), sorted(c.removeprefix("configs/").removesuffix(".toml") for c in studies.configs()))
        self.assertFalse([n for n in names if n.split("/")[0] in ("bench", "smoke", "examples", "new", "error_models")])
        self.assertEqual(len(names), len(set(names)))

    def test_options_are_read_before_the_build(self):
        cmake = os.path.join(self.folder, "cmake")
        with open(cmake, "w", encoding="utf-8") as file:
            file.write(f'#!/bin/sh\necho "$*" >> {self.folder}/calls\n[ "$1" != --build ]\n')
        os.chmod(cmake, 0o755)
        environment = {**os.environ, "PATH": f"{self.folder}:{os.environ['PATH']}"}
        for words, code, calls in ((["--build", "--qiuck"], 64, None),
                                   (["--build", "--list"], 1, "--preset release\n--build --preset release --target surveymc\n")):
            run = subprocess.run(self.command(*words), env=environment, capture_output=True, text=True, timeout=120)
            self.assertEqual(run.returncode, code, run.stdout + run.stderr)
            self.assertEqual(os.path.exists(cmake.replace("cmake", "calls")), calls is not None)
        with open(os.path.join(self.folder, "calls"), encoding="utf-8") as file:
            self.assertEqual(file.read(), calls)

    def test_what_is_done_is_kept_and_what_changed_is_run_again(self):
        chosen = ("--quick", "--no-report", "--only", "reliability/fig[12]", "--only", "thesis/test4")
        first = self.go(*chosen)
        self.assertIn("3 studies: 0 done already, 3 to run", first)
        self.assertIn("left)", first)  # time left, from the second study on
        stamps = {n: os.stat(self.result(n)).st_mtime_ns for n in ("reliability/fig1", "reliability/fig2", "thesis/test4")}
        result = surveymc.open(self.result("thesis/test4"))
        self.assertEqual(result.trials, studies.load()["msa_position"].quick_trials)
        self.assertIn("run configs/thesis/test4.toml", result.command)
        self.assertEqual(result.settings["verdict"]["confidence"], 0.95)
        self.assertIn("3 done already, 0 to run", self.go(*chosen))
        self.assertEqual(stamps, {n: os.stat(self.result(n)).st_mtime_ns for n in stamps})
        with open(self.result("reliability/fig1"), "r+b") as file:  # damaged: surveymc does not write over what it cannot read
            file.truncate(1000)
        os.remove(self.result("reliability/fig2"))
        again = self.go(*chosen, code=1)
        self.assertIn("1 done already, 2 to run", again)
        self.assertIn("refusing to overwrite", again)
        os.remove(self.result("reliability/fig1"))
        self.assertIn("2 done already, 1 to run", self.go(*chosen))
        self.assertEqual(os.stat(self.result("thesis/test4")).st_mtime_ns, stamps["thesis/test4"])
        self.assertIn("thesis/test4", [l.split()[0] for l in self.go("--list", *chosen).splitlines() if l.endswith("done")])
        # full size is another config hash than the quick one
        self.assertIn("to run", self.go("--list", "--only", "thesis/test4"))

    def test_another_program_version_runs_everything_again(self):
        self.go("--quick", "--no-report", "--only", "reliability/fig1")
        newer = os.path.join(self.folder, "surveymc")
        with open(newer, "w", encoding="utf-8") as file:
            file.write(f'#!/bin/sh\n[ "$1" = --version ] && echo "surveymc 9.9.9 (abc), GNU" && exit\nexec {SURVEYMC} "$@"\n')
        os.chmod(newer, 0o755)
        self.assertIn("to run", self.go("--list", "--quick", "--only", "reliability/fig1", program=newer))

    def test_a_result_of_another_config_is_kept(self):
        own = os.path.join(studies.ROOT, "configs", "smoke", "vertical_well.toml")
        path = self.result("reliability/fig1")
        os.makedirs(os.path.dirname(path))
        subprocess.run([SURVEYMC, "run", own, "--quiet", "--trials", "60", "-o", path], check=True, capture_output=True)
        with open(path, "rb") as file:
            first = file.read()
        self.go("--quick", "--no-report", "--only", "reliability/fig1")
        with open(self.result("reliability/fig1.1"), "rb") as file:
            self.assertTrue(file.read() == first)
        self.assertEqual(surveymc.open(path).experiment, "reliability_map")

    def test_a_study_that_fails_does_not_stop_the_others(self):
        failing = os.path.join(self.folder, "surveymc")
        with open(failing, "w", encoding="utf-8") as file:
            file.write(f'#!/bin/sh\ncase "$*" in run*fig1*) echo "no luck" >&2; exit 70 ;; esac\nexec {SURVEYMC} "$@"\n')
        os.chmod(failing, 0o755)
        text = self.go("--quick", "--no-report", "--only", "reliability/fig[12]", code=1, program=failing)
        self.assertIn("failed (exit code 70)\n  no luck", text)
        self.assertIn("failed: reliability/fig1", text)
        self.assertTrue(os.path.exists(self.result("reliability/fig2")))

    def test_interrupted_it_stops_and_leaves_only_whole_results(self):
        process = subprocess.Popen(self.command("--no-report", "--only", "reliability/fig2", "--only", "gross_error/false_alarms"),
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True)
        deadline = time.monotonic() + 60
        while not os.path.exists(self.result("reliability/fig2")) and time.monotonic() < deadline:
            time.sleep(0.02)
        time.sleep(0.5)  # in the second one, which takes minutes
        os.killpg(process.pid, signal.SIGINT)
        text = process.communicate(timeout=60)[0]
        self.assertEqual(process.returncode, 130, text)
        self.assertIn("finished results are kept", text)
        self.assertNotIn("Traceback", text)
        left = [os.path.join(f, n) for f, _, names in os.walk(self.folder) for n in names]
        journal = self.result("gross_error/false_alarms") + ".journal."  # of the one that was running
        self.assertEqual([path for path in left if not path.startswith(journal)], [self.result("reliability/fig2")])

    def test_report_and_figures_come_with_it(self):
        text = self.go("--quick", "--only", "reliability/fig1")
        left, _ = re.search(r", about ([\d.]+) s left\) \.\.\. .*\nfigures and report \(about [\d.]+ (s|min)\) ", text).groups()
        self.assertGreaterEqual(float(left), run_studies.Pace.FIGURES / min(2, os.cpu_count()) + run_studies.Pace.PAGE)
        self.assertIn("report/index.html: 1 result,", text)
        self.assertTrue(os.path.exists(os.path.join(self.folder, "report", "figures", "reliability", "fig1_inclination.svg")))
        with open(os.path.join(self.folder, "report", "index.html"), encoding="utf-8") as file:
            self.assertTrue(run_studies.QUICK_NOTE in file.read())

    def test_refusals(self):
        self.assertIn("no study fits nonsense", self.go("--only", "nonsense", code=64))
        self.assertIn("not built", self.go("--list", code=64, program="/nowhere/surveymc"))


class TimeLeft(unittest.TestCase):
    def test_by_experiment_and_trials(self):
        def job(experiment, trials):
            return run_studies.Job("n", "c", "o", [], experiment, trials)

        known = {"a": studies.Study("a", 0, "a", trial_us=1e6), "b": studies.Study("b", 1, "b", run_s=2.7)}
        pace, start = run_studies.Pace(known, 2), run_studies.Pace.START
        self.assertAlmostEqual(pace.left([job("a", 10), job("b", 0)]), 5 + 2.7 + 2 * start)  # told before anything has run
        pace.add(job("b", 0), 2 * (2.7 + start))  # this machine takes twice as long
        self.assertAlmostEqual(pace.left([job("a", 10)]), 2 * (5 + start))
        pace.add(job("a", 100), 3 * (50 + start))  # and thrice for this one
        self.assertAlmostEqual(pace.left([job("a", 10)]), 3 * (5 + start))
        self.assertAlmostEqual(pace.left([job("b", 0)]), 2 * (2.7 + start))

    def test_figures_and_page_are_counted(self):
        with tempfile.TemporaryDirectory() as folder:
            job = run_studies.Job("a/b", "c", os.path.join(folder, "a/b.h5"), [], "a")
            record = os.path.join(folder, "report/figures/a/.b.figures.json")
            self.assertFalse(run_studies.is_drawn(job, folder))
            for path in (record, job.output):
                os.makedirs(os.path.dirname(path), exist_ok=True)
                with open(path, "w", encoding="utf-8"):
                    pass
            os.utime(job.output, (1000, 1000))
            self.assertTrue(run_studies.is_drawn(job, folder))
            os.utime(record, (999, 999))  # of an older result
            self.assertFalse(run_studies.is_drawn(job, folder))
        pace = run_studies.Pace({"a": studies.Study("a", 0, "a", run_s=1.0)}, 2)
        page, both = pace.page(10, 0), pace.page(10, 4)
        self.assertAlmostEqual(page, 10 * pace.PAGE)
        self.assertAlmostEqual(both - page, 4 * pace.FIGURES / min(2, os.cpu_count()))
        pace.add(run_studies.Job("n", "c", "o", [], "a"), 3 * (1.0 + pace.START))  # this machine takes thrice as long
        self.assertAlmostEqual(pace.page(10, 4), 3 * both)

    def test_every_study_says_what_it_costs(self):
        for name, study in studies.load().items():
            self.assertTrue(study.trial_us != studies.Study.trial_us or study.run_s > 0, name)


if __name__ == "__main__":
    SURVEYMC = os.path.abspath(sys.argv.pop())
    unittest.main()
