#!/usr/bin/python3
"""Man pages and completions of bash are those of the program: test_texts.py SURVEYMC_EXECUTABLE SOURCE_FOLDER

The oracle is --help of every command, which CLI11 prints from the same definitions by code of its own, and for the commands of
the Python side argparse, from definitions of its own.
"""
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

EXECUTABLE, SOURCE = None, None


def call(*arguments):
    return subprocess.run([EXECUTABLE, *arguments], check=True, capture_output=True, text=True).stdout


def commands():
    """{command: its options}, read from --help; "" is the program."""
    top = call("--help")
    names = re.findall(r"^  ([a-z]+) ", top[top.index("Subcommands:"):], re.M)
    options = lambda text: set(re.findall(r"(?<![\w-])--[a-z0-9-]+|(?<![\w-])-[a-z](?![\w-])", text))  # noqa: E731

    def of(text):
        """Options at the beginning of a line: "-o,--output FILE" of CLI11, "-o FILE, --output FILE" of argparse."""
        return {f for line in re.findall(r"^  (-[^ ,]*(?: [A-Z][A-Za-z.]*)?(?:, ?-[^ ,]*)*)", text, re.M) for f in options(line.replace(",", " "))}

    return {"": of(top), **{name: of(call(name, "--help")) for name in names}}


class ManPage(unittest.TestCase):
    def test_every_command_and_option_is_in_it(self):
        page = call("man").replace("\\-", "-")
        known = commands()
        self.assertIn("show", known)
        self.assertIn("--trials", known["run"])
        self.assertIn("--3d", known["plot"])
        for command, options in known.items():
            if command:
                self.assertIn(f"\n.B {command}\n", page)
            own = call("man", command).replace("\\-", "-") if command else page
            for option in options - {"-h", "--help"}:
                self.assertIn(f"\\fB{option}\\fR", own, command)
        self.assertIn("\\fB--help\\fR", page)
        done = subprocess.run([EXECUTABLE, "man", "rnu"], capture_output=True, text=True)
        self.assertEqual((done.returncode, 'did you mean "run"' in done.stderr), (64, True), done.stderr)

    def test_the_page_of_the_program_is_read_in_one_go(self):
        if not shutil.which("mandoc"):
            self.skipTest("no mandoc")
        text = subprocess.run(["mandoc", "-Tutf8", "-Owidth=100"], input=call("man"), capture_output=True, text=True, check=True).stdout
        self.assertLessEqual(len(text.splitlines()), 100)

    def test_it_is_clean(self):
        if not shutil.which("mandoc"):
            self.skipTest("no mandoc")
        with tempfile.TemporaryDirectory() as folder:
            call("man", "-o", folder)
            pages = sorted(Path(folder).iterdir())
            self.assertEqual({p.name for p in pages}, {"surveymc.1"} | {f"surveymc-{c}.1" for c in commands() if c})
            self.assertEqual((Path(folder) / "surveymc-run.1").read_text(), call("man", "run"))
            out = subprocess.run(["mandoc", "-Tlint", "-Wwarning", *pages], capture_output=True, text=True).stdout
        wrong = [line for line in out.splitlines() if "missing date" not in line]  # a date would change it every day
        self.assertEqual(wrong, [])


class Completions(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="surveymc-completion-")
        cls.folder = Path(cls.temporary.name)
        subprocess.run([EXECUTABLE, "run", str(SOURCE / "configs/smoke/reliability_map.toml"), "-o", "maps.h5"],
                       cwd=cls.folder, check=True, capture_output=True)
        (cls.folder / "mine.toml").write_text('# mine\nexperiment = "position_covariance"\n')
        (cls.folder / "notes.txt").touch()
        (cls.folder / "sub").mkdir()

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def offers(self, *words):
        """What bash offers for the last of these words."""
        line = " ".join(f"'{w}'" for w in words)
        script = (f"source <('{EXECUTABLE}' completion bash)\nCOMP_WORDS=('{EXECUTABLE}' {line})\n"
                  f"COMP_CWORD={len(words)}\n_surveymc\nprintf '%s\\n' \"${{COMPREPLY[@]}}\"\n")
        done = subprocess.run(["bash", "--norc", "-u", "-c", script], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(done.stderr, "")
        return set(done.stdout.split("\n")) - {""}

    def test_bash_offers_every_command_and_option(self):
        known = commands()
        self.assertEqual(self.offers(""), set(known) - {""} | known[""])
        for command, options in known.items():
            if command:
                self.assertEqual(self.offers(command, "-"), options, command)

    def test_bash_offers_files_and_tables(self):
        self.assertEqual(self.offers("run", ""), {"mine.toml", "sub"})
        self.assertEqual(self.offers("run", "--threads", "2", ""), {"mine.toml", "sub"})
        self.assertEqual(self.offers("run", "mine.toml", "-o", ""), {"maps.h5", "sub"})
        self.assertEqual(self.offers("run", "mine.toml", "--seed", ""), set())
        self.assertEqual(self.offers("show", "m"), {"maps.h5"})
        self.assertEqual(self.offers("show", "maps.h5", "re"), {"redundancy_number"})
        self.assertEqual(self.offers("show", "--csv", "maps.h5", "s"), {"summary", "statements",
                                                                       "share_of_toolfaces_within_tolerance"})
        self.assertEqual(self.offers("completion", ""), {"bash"})

    def test_bash_offers_models_keys_and_their_words(self):
        self.assertEqual(self.offers("models", "MWD+IFR1+M"), {"MWD+IFR1+MS", "MWD+IFR1+MS_Fl"})
        self.assertEqual(self.offers("run", "mine.toml", "--set", "field.d"), {"field.date=", "field.declination_deg=", "field.dip_deg="})
        self.assertEqual(self.offers("run", "mine.toml", "--set", "leg"), set())  # keys in arrays of tables: not by --set
        # bash parts words at =
        for words in (["run", "mine.toml", "--set", "error_model", "="], ["check", "mine.toml", "--set", "error_model.name", "=", "MWD+IFR1+M"]):
            self.assertLessEqual({"MWD+IFR1+MS", "MWD+IFR1+MS_Fl"}, self.offers(*words))
        self.assertEqual(self.offers("run", "mine.toml", "--set", "survey.azimuth_reference", "="), {"true", "grid", "magnetic"})
        self.assertEqual(self.offers("run", "mine.toml", "--set", "survey.azimuth_reference", "=", "g"), {"grid"})
        self.assertEqual(self.offers("run", "mine.toml", "--set", "field.dip_deg", "="), set())
        self.assertEqual(self.offers("run", "mine.toml", "--set", "field.dip_deg", "=", "60", "--thre"), {"--threads"})
        self.assertEqual(self.offers("run", "sub/none.toml", "--set", ""), set())
        self.assertEqual(self.offers("man", "re"), {"report", "rerun", "refine"})
        self.assertEqual(self.offers("plot", "m"), {"maps.h5"})

    def test_bash_does_not_run_what_it_offers(self):
        self.assertEqual(self.offers("show", "maps.h5", "$(touch ran)"), set())
        self.assertFalse((self.folder / "ran").exists())


if __name__ == "__main__":
    EXECUTABLE, SOURCE = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
