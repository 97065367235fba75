#!/usr/bin/python3
"""Everything that Python writes: whole or not at all, regular files only, through links, nothing of a user lost.
test_writers.py SURVEYMC SMOKE_FOLDER"""
import contextlib
import errno
import html
import json
import os
import pty
import re
import resource
import runpy
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import traceback
import unittest
import xml.dom.minidom
from pathlib import Path
from unittest import mock

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
SCRIPTS = ROOT / "scripts"
COMMANDS = {"plot": "surveymc.plots", "report": "surveymc.report", "import": "surveymc.importer", "studies": "surveymc.run_studies"}
sys.path.insert(0, str(SCRIPTS))
import surveymc  # noqa: E402
from surveymc import whole_file  # noqa: E402
from surveymc.report import figures  # noqa: E402
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from sealed import result_file  # noqa: E402

SMOKE = SURVEYMC = ""
PATIENCE = 600  # s: the machine may be busy
KEPT_FIGURES = "figures of a report"
MINE = b"my own file\n"
SURVEY = "MD (m),Incl (deg),Azimuth Grid (deg)\n0,0,0\n30,1,10\n60,2,20\n"


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def started(self, script, *arguments, code=0, **how):
        """A command as a user starts it."""
        run = subprocess.run([sys.executable, SCRIPTS / "surveymc", script, *arguments], cwd=self.folder, stderr=subprocess.PIPE, timeout=PATIENCE, **how)
        self.assertEqual(run.returncode, code, run.stderr.decode(errors="replace"))
        self.assertNotIn(b"Traceback", run.stderr)
        self.assertNotIn(b"Exception ignored", run.stderr)
        return run

    def go(self, script, *arguments, code=0, before=lambda: None):
        """The same in a fork of this process, which has loaded Matplotlib already: (stdout, stderr)."""
        pipes = os.pipe(), os.pipe()
        child = os.fork()
        if child == 0:
            ended = 99
            try:
                signal.alarm(PATIENCE)
                for number, (_, write) in enumerate(pipes, 1):
                    os.dup2(write, number)
                sys.stdout, sys.stderr = sys.__stdout__, sys.__stderr__
                os.chdir(self.folder)
                before()
                ended = script_here(script, arguments)
                sys.stdout.flush()
                sys.stderr.flush()
            finally:
                os._exit(ended)
        said = []
        for read, write in pipes:
            os.close(write)
            with os.fdopen(read, "rb") as file:
                said.append(file.read())
        ended = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        self.assertEqual(ended, ended if code is None else code, said[1].decode(errors="replace"))
        self.assertNotIn(b"Traceback", said[1])
        return said

    def no_temporaries(self):
        self.assertEqual([p.name for p in self.folder.rglob("*") if p.suffix in (".tmp", ".part")], [])


def script_here(script, arguments):
    """Runs a command, or a script of this path, or draws as the report does, in this process; its exit code."""
    if script == KEPT_FIGURES:
        drawn = figures._draw("well.h5", "well", ["gross_error"], "out/figures", "stamp")
        print(*drawn.kept, *drawn.broken, file=sys.stderr)
        return drawn.code
    name, *drawer = script.split()
    sys.argv = [name, *drawer, *map(os.fsdecode, arguments)]
    try:
        if name in COMMANDS:
            runpy.run_module(COMMANDS[name], run_name="__main__")
        else:
            sys.path.insert(0, os.path.dirname(ROOT / name))
            runpy.run_path(str(ROOT / name), run_name="__main__")
        return 0
    except SystemExit as end:
        return end.code or 0
    except BaseException:
        traceback.print_exc()
        return 1


class Writer:
    """One thing that Python writes: what makes it, its name in the folder out/, and whether a file of its own is replaced."""

    def __init__(self, script, name, *arguments, refuses=False):
        self.script, self.name, self.arguments, self.refuses = script, name, arguments, refuses


@contextlib.contextmanager
def copy_of_well(path):
    """Another result, open to be changed."""
    with result_file(path) as file, h5py.File(os.path.join(SMOKE, "gross_error_detection.h5")) as whole:
        for name in whole:
            whole.copy(name, file)
        for name, value in whole.attrs.items():
            file.attrs[name] = value
        yield file


def writers(folder):
    """All kinds of them. The result is a copy, for some have their output beside it."""
    shutil.copy(os.path.join(SMOKE, "gross_error_detection.h5"), folder / "well.h5")
    (folder / "in.csv").write_text(SURVEY)
    (folder / "out").mkdir()
    survey = ("in.csv", "-o", "out/survey.csv", "--azimuth-reference", "grid")
    return [Writer("plot gross_error", "well.png", "well.h5", "-o", "out"),
            Writer("report", "index.html", "well.h5", "-o", "out", "--no-figures"),
            Writer(KEPT_FIGURES, "figures/well.svg"),
            Writer(KEPT_FIGURES, "figures/.well.figures.json"),
            Writer("import", "survey.csv", *survey, refuses=True),
            Writer("import", "survey.csv", *survey, "--overwrite")]


class Writing(Case):
    def each(self, only=lambda writer: True):
        for writer in filter(only, writers(self.folder)):
            with self.subTest(script=writer.script, name=writer.name):
                shutil.rmtree(self.folder / "out")
                target = self.folder / "out" / writer.name
                target.parent.mkdir(parents=True)
                yield writer, target
                self.no_temporaries()

    def test_a_file_of_the_user_is_kept(self):
        for writer, target in self.each(lambda w: "--overwrite" not in w.arguments):
            target.write_bytes(MINE)
            out, err = self.go(writer.script, *writer.arguments, code=74 if writer.refuses else 0)
            kept = target if writer.refuses else target.with_suffix(".1" + target.suffix)
            self.assertEqual(kept.read_bytes(), MINE)
            if not writer.refuses:
                self.assertNotEqual(target.read_bytes(), MINE)
            if writer.refuses or target.suffix != ".json":  # nobody looks for a record
                self.assertIn(kept.name.encode(), err)

    def test_what_it_made_itself_is_replaced_until_somebody_changes_it(self):
        for writer, target in self.each(lambda w: w.script != "import"):
            self.go(writer.script, *writer.arguments)
            first = target.read_bytes()
            os.utime(target, (0, 0))
            if target.suffix == ".svg" and writer.script == KEPT_FIGURES:  # else it is not drawn again
                (target.parent / ".well.figures.json").unlink()
            self.go(writer.script, *writer.arguments)
            self.assertEqual(target.read_bytes(), first)
            self.assertEqual([p.name for p in target.parent.iterdir() if ".1." in p.name], [])
            if target.suffix in (".json", ".html"):  # a page is told by its mark as figures are
                continue
            target.write_bytes(first.replace(b"</svg>", b"<!-- my arrow --></svg>") if target.suffix == ".svg" else first + b"x")
            edited = target.read_bytes()
            self.go(writer.script, *writer.arguments)
            self.assertEqual(target.with_suffix(".1" + target.suffix).read_bytes(), edited)
            self.assertEqual(target.read_bytes(), first)

    def test_links_are_followed(self):
        for writer, target in self.each(lambda w: not w.refuses):
            other = self.folder / "elsewhere"
            other.unlink(missing_ok=True)
            target.symlink_to(other)  # to nothing yet
            self.go(writer.script, *writer.arguments)
            self.assertTrue(target.is_symlink() and other.is_file())

    def test_devices_pipes_and_folders_are_no_targets(self):
        for writer, target in self.each():
            for make in (os.mkfifo, os.mkdir, lambda p: os.symlink("/dev/null", p)):
                make(target)
                kind = os.lstat(target).st_mode
                is_record = target.suffix == ".json"
                out, err = self.go(writer.script, *writer.arguments, code=0 if is_record else 74)
                if not is_record:  # a record that cannot be kept only costs time
                    self.assertIn(b"regular file", err)
                self.assertEqual(os.lstat(target).st_mode, kind)
                self.assertTrue(os.path.exists("/dev/null") and not os.path.isfile("/dev/null"))
                (os.rmdir if os.path.isdir(target) else os.unlink)(target)

    def test_a_full_disk_leaves_what_was_there(self):
        for writer, target in self.each():
            if not writer.refuses:
                self.go(writer.script, *writer.arguments)
                before = target.read_bytes()
            if target.suffix == ".svg" and writer.script == KEPT_FIGURES:
                (target.parent / ".well.figures.json").unlink()
            elif target.suffix == ".json":  # asks for new figures, which cannot be written either
                target.write_text(json.dumps({"stamp": "old", "files": {}, "messages": []}))
                before = target.read_bytes()
            out, err = self.go(writer.script, *writer.arguments, code=74,
                               before=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (40, 40)))
            self.assertRegex(err, b"cannot (write|be written)[^\n]*File too large")
            if writer.refuses:
                self.assertFalse(target.exists())
            else:
                self.assertEqual(target.read_bytes(), before)

    def test_planted_names_are_not_written_through(self):
        for writer, target in self.each():
            victim = self.folder / "victim"
            victim.write_bytes(MINE)
            for name in (target.name + ".part", f".{target.name}.tmp", target.name + ".tmp"):
                (target.parent / name).symlink_to(victim)
            self.go(writer.script, *writer.arguments)
            self.assertEqual(victim.read_bytes(), MINE)
            for name in (target.name + ".part", f".{target.name}.tmp", target.name + ".tmp"):
                (target.parent / name).unlink()

    def test_one_failed_write_is_not_for_ever(self):
        writers(self.folder)
        report = ("report", "well.h5", "-o", "out")
        figure = self.folder / "out/figures/well.svg"
        figure.mkdir(parents=True)
        self.go(*report, code=74)
        self.assertTrue('<p class="broken">' in (self.folder / "out/index.html").read_text())
        figure.rmdir()
        self.go(*report)
        self.assertFalse('<p class="broken">' in (self.folder / "out/index.html").read_text())
        figure.write_bytes(b"<svg/>")  # not what the record is of: it does not come into the page
        self.go(*report)
        self.assertEqual(figure.with_suffix(".1.svg").read_bytes(), b"<svg/>")

    def test_a_page_without_a_name_keeps_what_is_there(self):
        writers(self.folder)
        (self.folder / "report").mkdir()
        for name in ("index", "notes"):
            (self.folder / "report" / f"{name}.html").write_bytes(MINE)
        self.go("report", "well.h5", "--no-figures")
        self.assertEqual((self.folder / "report/index.1.html").read_bytes(), MINE)
        self.assertEqual((self.folder / "report/notes.html").read_bytes(), MINE)

    def test_pages_that_the_report_has_no_longer_go(self):
        writers(self.folder)
        for name in ("one", "two"):
            shutil.copy(self.folder / "well.h5", self.folder / f"{name}.h5")
            with result_file(self.folder / f"{name}.h5", "a") as file:
                file.attrs["command"] = "surveymc run mine.toml"  # of no config that is shipped: a page for each
        self.go("report", "one.h5", "two.h5", "--no-figures")
        pages = lambda: {p.name for p in (self.folder / "report").glob("*.html")}  # noqa: E731
        self.assertEqual(pages(), {"index.html", "one.html", "two.html", "paper.html"})
        self.go("report", "one.h5", "--no-figures")
        self.assertEqual(pages(), {"index.html"})

    def test_figures_of_another_result_with_that_name_are_kept(self):
        writers(self.folder)
        with copy_of_well(self.folder / "out/well.h5") as file:
            file.attrs["title"] = "Another well"
        self.go("plot gross_error", "well.h5", "-o", ".")
        first = (self.folder / "well.png").read_bytes()
        self.go("plot gross_error", "out/well.h5", "-o", ".")
        self.assertEqual((self.folder / "well.1.png").read_bytes(), first)

    def test_writers_at_once_leave_one_whole_file_and_that_of_the_user(self):
        target = self.folder / "x.svg"
        contents = [b"%d" % i * 1000 for i in range(6)]
        for _ in range(10):
            target.write_bytes(MINE)
            (self.folder / "x.1.svg").unlink(missing_ok=True)
            at_once = threading.Barrier(len(contents))

            def write(data):
                at_once.wait()
                whole_file.write(target, data, lambda name: Path(name).read_bytes() in contents)

            threads = [threading.Thread(target=write, args=(data,)) for data in contents]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            self.assertIn(target.read_bytes(), contents)
            self.assertEqual((self.folder / "x.1.svg").read_bytes(), MINE)
            self.no_temporaries()

    def test_a_file_system_without_second_names(self):
        def link(old, new):
            raise OSError(errno.EPERM, os.strerror(errno.EPERM), new)

        name, kept = self.folder / "x.png", self.folder / "x.1.png"
        with mock.patch.object(os, "link", link):
            self.assertEqual(whole_file.write(name, b"one", lambda name: False), "")
            self.assertEqual(whole_file.write(name, b"two", lambda name: False), os.path.realpath(kept))
            self.assertEqual([name.read_bytes(), kept.read_bytes()], [b"two", b"one"])
            with self.assertRaises(FileExistsError):
                whole_file.write_new(name, b"three")
            whole_file.write_new(self.folder / "y.png", b"three")
        self.assertEqual((self.folder / "y.png").read_bytes(), b"three")
        self.no_temporaries()

    def test_nothing_else_writes_a_file(self):
        """Configs and results of a moment, in a temporary folder, are left."""
        for path in SCRIPTS.rglob("*.py"):
            text = path.read_text()
            if path.name in ("whole_file.py", "streams.py", "scale_plan.py"):
                continue
            if path.parent == SCRIPTS:  # makers of the pages and pictures of docs/, which nobody has work in
                continue
            for words in ('"w"', '"wb"', "os.replace(", "os.rename(", ".part\"", "write_text(", "write_bytes("):
                left = text.replace('os.fdopen(handle, "wb")', "") if path.name == "program.py" else text  # mkstemp
                if path.name == "storage.py":  # results of one point, in a temporary folder
                    left = left.replace('def sealed_file(path, mode="w")', "").replace('mode == "w"', "")
                self.assertFalse(words in left, f"{path.name}: {words}")
            self.assertTrue("savefig(" not in text or path.name == "saving.py", path.name)


class Reading(Case):
    def test_pipes_are_refused_and_results_beside_them_read(self):
        shutil.copy(os.path.join(SMOKE, "gross_error_detection.h5"), self.folder / "well.h5")
        os.mkfifo(self.folder / "pipe.h5")
        out, err = self.go("report", ".", "--no-figures")
        self.assertIn(b"pipe.h5: is not a regular file", err)
        for script in ("plot", "plot gross_error", "plot refined", "plot calibration"):
            self.assertIn(b"pipe.h5: is not a regular file", self.go(script, "pipe.h5", code=65)[1])

    def test_columns_that_claim_more_than_the_file_holds(self):
        shutil.copy(os.path.join(SMOKE, "gross_error_detection.h5"), self.folder / "well.h5")
        with copy_of_well(self.folder / "large.h5") as file:
            table = file["tables"][next(iter(file["tables"]))]
            table.create_dataset("large", shape=(1 << 40,), dtype="f8", chunks=(1 << 16,))
        out, err = self.go("report", "well.h5", "large.h5", "-o", "page", "--no-figures",
                           before=lambda: resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30)))
        self.assertIn(b"large.h5: /tables/", err)
        self.assertIn(b"claims more values than the file can hold", err)
        self.assertIn(b": 1 result,", out)
        self.assertIn(b"claims more", self.go("plot gross_error", "large.h5", code=65)[1])

    def test_names_that_are_not_utf8_or_move_the_cursor(self):
        odd = (b"w\xffell.h5", b"w\x1b[31mell.h5", "w\u202eell.h5".encode(), b"$(touch hit) 'q'.h5", b"-s.h5", b"a\nb.h5")
        for name in odd:
            shutil.copy(os.path.join(SMOKE, "gross_error_detection.h5"), os.fsencode(self.folder) + b"/" + name)
        out, err = self.go("report", ".")
        self.assertIn(b": %d results," % len(odd), out)
        page = b"".join(p.read_bytes() for p in (self.folder / "report").glob("*.html") if p.name != "paper.html")
        page.decode("utf-8")
        self.assertFalse(b"\x1b" in page or "\u202e".encode() in page)
        self.assertFalse(b'<p class="broken">' in page)
        self.assertEqual(page.count(b'alt="Rates of detection'), len(odd))  # the caption of its figure, by its name
        commands = [html.unescape(c) for c in re.findall(r"build/surveymc rerun ([^\n]*?)</pre>", page.decode("utf-8"))]
        self.assertEqual(len(commands), len(odd))
        names = [subprocess.run(["bash", "-c", f"printf %s {c}"], cwd=self.folder, capture_output=True).stdout for c in commands]
        self.assertEqual(sorted(n.removeprefix(b"./") for n in names), sorted(odd))
        self.assertFalse((self.folder / "hit").exists())
        for name in odd[:3]:
            out, err = self.go("plot gross_error", b"./" + name, "-o", os.fsencode(self.folder) + b"/f")
            for line in out.splitlines():  # a figure's name is what is printed
                self.assertTrue(os.path.exists(line), line)
            for said in (out, err, *self.go("plot", b"./no" + name, code=65)):
                said.decode("utf-8")
                self.assertFalse(b"\x1b" in said or "\u202e".encode() in said, said)
        drawn = surveymc.plot(os.fsdecode(os.fsencode(self.folder) + b"/" + odd[0]), folder=self.folder / "f\x1b\udcff")
        self.assertTrue(drawn and all(os.path.exists(p) for p in drawn))

    def test_what_is_not_utf8_in_a_result_is_no_traceback(self):
        with copy_of_well(self.folder / "title.h5") as file:
            file.attrs["title"] = np.bytes_(b"\xff")
        with copy_of_well(self.folder / "word.h5") as file:
            words = file["tables/detection/case"]
            words[()] = [b"\xff", *words[1:]]
        for name in ("title.h5", "word.h5"):
            self.assertIn(b"codec can't decode", self.go("plot gross_error", name, code=65)[1])

    def test_a_title_spoils_no_figure(self):
        with copy_of_well(self.folder / "well.h5") as file:
            file.attrs["title"] = "w\x1b[31m \u202ell\x07 \uffff"
        self.go("plot gross_error", "well.h5")
        text = (self.folder / "well.svg").read_text()
        xml.dom.minidom.parseString(text)
        self.assertNotIn("\u202e", text)

    def test_a_terminal_sees_no_escape_sequence(self):
        name = "w\x1b]0;title\x07\u202ell\x9b2J.h5"
        shutil.copy(os.path.join(SMOKE, "gross_error_detection.h5"), self.folder / name)
        for command in (["plot gross_error", name], ["report", name, "--no-figures"], ["report", name + "x"],
                        ["import", name], ["studies", "--only", name], ["plot gross_error", name, "--" + name]):
            ours, theirs = pty.openpty()
            try:
                self.go(*command, code=None, before=lambda: (os.dup2(theirs, 1), os.dup2(theirs, 2)))
                os.set_blocking(ours, False)
                said = b""
                with contextlib.suppress(BlockingIOError):
                    while piece := os.read(ours, 1 << 16):
                        said += piece
            finally:
                os.close(ours)
                os.close(theirs)
            self.assertTrue(said)
            for part in (b"\x1b", b"\x07", "\u202e".encode(), "\x9b".encode()):
                self.assertNotIn(part, said, command)


class Output(Case):
    def commands(self):
        if not (self.folder / "well.h5").exists():
            writers(self.folder)
        return [["plot gross_error", "well.h5", "-o", "out"], ["plot", "well.h5", "-o", "out"],
                ["report", "well.h5", "--no-figures"], ["import", "in.csv", "--azimuth-reference", "grid"],
                ["studies", "--list", "--only", "thesis/test4", "--program", SURVEYMC], ["scripts/check_layers.py"], ["tests/docs/check_docs.py", "--help"],
                ["scripts/slurm/scale_plan.py", "--help"], ["plot difference", "--help"],
                *([f"tests/bench/compare_peers/{n}.py", "--help"] for n in ("report", "revisions", "figures_of_merit", "numpy_reliability")),
                ["plot thesis", "--help"]]  # all drawers are started by one function

    def test_output_that_is_lost_is_no_success_and_no_traceback(self):
        read, write = os.pipe()
        os.close(read)
        with open("/dev/full", "wb") as full, open(write, "wb") as unread:
            for how, code, says in ((lambda: os.dup2(full.fileno(), 1), 74, rb"standard output: cannot write: No space left[^\n]*\n$"),
                                    (lambda: os.close(1), 74, rb"standard output: cannot write: Bad file[^\n]*\n$"),
                                    (lambda: os.dup2(unread.fileno(), 1), 141, rb"^(?!.*standard output)")):
                for command in self.commands()[:None if b"No space" in says else 5]:  # all end by one function
                    with self.subTest(command=command, code=code, says=says):
                        self.assertRegex(self.go(*command, code=code, before=how)[1], says)
                for command in self.commands()[3:4]:  # to the end of the interpreter
                    self.assertRegex(self.started(*command, code=code, preexec_fn=how).stderr, says)

    def test_errors_that_nobody_hears_keep_their_exit_code(self):
        with open("/dev/full", "wb") as full:
            for command, code in ((["plot gross_error", "none.h5"], 65), (["report", "none.h5"], 65), (["import", "none.csv"], 74),
                                  (["plot"], 64)):
                for how in (lambda: os.dup2(full.fileno(), 2), lambda: os.close(2)):
                    self.go(*command, code=code, before=how)
            self.started("plot", "gross_error", "none.h5", code=65, preexec_fn=lambda: os.dup2(full.fileno(), 2))


if __name__ == "__main__":
    SMOKE = os.path.abspath(sys.argv.pop())
    SURVEYMC = os.path.abspath(sys.argv.pop())
    unittest.main()
