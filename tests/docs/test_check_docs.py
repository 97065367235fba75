#!/usr/bin/python3
"""check_docs.py: a right number passes, and whatever is wrong with a page is found: test_check_docs.py SOURCE

Runs on pages of its own and on a program that stands in for surveymc: it writes a result file at once, so that the values
are known: 100 in large runs, 103 ± 4 in small ones.
"""
import contextlib
import io
import pathlib
import sys
import tempfile
import unittest

import h5py
import numpy as np

SOURCE = pathlib.Path(sys.argv.pop(1)).resolve()
sys.path.insert(0, str(SOURCE / "scripts"))
sys.path.insert(0, str(SOURCE / "tests" / "support"))
import check_docs  # noqa: E402
from sealed import result_file  # noqa: E402

PROGRAM = """#!/bin/bash
if [ "$1" = check ]; then
  [[ "$*" == *bad.key=1* ]] && { echo "unknown key bad.key" >&2; exit 65; }
  echo "# 1 sweep point, 10 trials in all; config hash $(echo "$*" | tr -dc a-z0-9)"
  exit
fi
size=small
[[ "$*" == *1000000* ]] && size=large
cp "${0%/*}/$size.h5" "${@: -1}"
"""


def write_result(path, north, half):
    with result_file(path) as file:
        file.attrs["format"] = "surveymc"
        def text(*words):
            return np.array(words, h5py.string_dtype())
        table = file.create_group("tables/position")
        table["case"] = text("test 1", "test 1", "test 2", "test 2")
        table["quantity"] = text("north", "east", "north", "east")
        values = np.array([north, 2.5, 0.125, np.inf])
        table["monte_carlo"] = values
        table["monte_carlo_ci_low"], table["monte_carlo_ci_high"] = values - half, values + half
        table["exact"] = np.array([1e-12, 2.0, -3.0, 0.0])
        table["noise.scale"] = np.array([1.0, 1.0, 0.1, 0.1])
        table["verdict"] = text("agrees", "agrees", "differs", "agrees")
        axis = file.create_dataset("inclination", data=[0.0, 45.0, 90.0])
        axis.make_scale("inclination")
        file["maps/ratio"] = np.array([1.0, 2.0, np.inf])
        file["maps/ratio"].dims[0].attach_scale(axis)


PAGE = """# Studies
## One
`surveymc run configs/thesis/table5.toml --trials 1000000` gives 100.0 m to the north, a ratio of 40.0,
and −3 exactly, 75 % agree, at 90° infinity: ∞.
"""
CLAIMS = """
[[numbers]]
section = "One"
of = "surveymc run configs/thesis/table5.toml --trials 1000000"
small = "--trials 10"
held = '''
100.0 m = position(case="test 1", quantity="north").monte_carlo [nightly]
40.0 = position(case="test 1", quantity="north").monte_carlo / position(case="test 1", quantity="east").monte_carlo [full]
−3 exactly = position(noise_scale=0.1, quantity="north").exact
75 % = share(position().verdict == "agrees")
90° infinity: ∞ = 90, ratio(inclination=90)
'''
"""
BOTH = PAGE + "~~~" + CLAIMS  # the page, and the file of its claims


class CheckDocs(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        (self.folder / "studies").mkdir()
        (self.folder / "claims").mkdir()
        self.program = self.folder / "surveymc"
        self.program.write_text(PROGRAM)
        self.program.chmod(0o755)
        write_result(self.folder / "large.h5", 100.0, 0.01)
        write_result(self.folder / "small.h5", 103.0, 4.0)

    def check(self, text, *options):
        """(exit, output) of the check of a page docs/studies/one.md with this text, and with the claims behind ~~~."""
        page = self.folder / "studies/one.md"
        text, _, claims = text.partition("~~~")
        page.write_text(text)
        (self.folder / "claims/one.toml").write_text(claims)
        sys.argv = ["check_docs.py", str(self.program), str(page), *options]
        with contextlib.redirect_stdout(io.StringIO()) as out:
            bad = check_docs.main()
        return bad, out.getvalue()

    def wrong(self, text, word, *options):
        bad, out = self.check(text, *options)
        self.assertTrue(bad, f"passes, but {word} is wrong:\n{out}")
        self.assertIn(word, out)

    def change(self, old, new, count=-1):
        self.assertIn(old, BOTH)
        return BOTH.replace(old, new, count)

    def test_right_page(self):
        bad, out = self.check(BOTH, "--full")
        self.assertFalse(bad, out)
        self.assertIn("6 numbers of 1 commands", out)
        bad, out = self.check(BOTH)
        self.assertFalse(bad, out)
        self.assertIn("5 numbers", out)  # one is of the full run alone

    def test_wrong_number_in_text_and_quote(self):
        for old, new, word in [("100.0 m", "100.2 m", "100.2: 100"), ("−3 exactly", "−4 exactly", "−4: -3"),
                               ("75 %", "77 %", "77 %: 0.75"), ("40.0", "41.0", "41.0: 40"),
                               ("infinity: ∞", "infinity: 8", "8: inf")]:
            self.wrong(self.change(old, new), word, "--full")

    def test_small_run_has_the_interval_of_its_own(self):
        # 103 ± 4: 100 is within it, and so is 110 when all six numbers of the page share one chance in a hundred
        # (4 √2 3.1 / 1.96 = 9), but not 120. The full run knows better.
        self.assertFalse(self.check(self.change("100.0 m", "110 m"))[0])
        self.wrong(self.change("100.0 m", "110 m"), "110", "--full")
        self.wrong(self.change("100.0 m", "120 m"), "120")

    def test_tolerance_of_the_small_run(self):
        page = self.change(" [nightly]", " [small ± 1]")
        self.wrong(page, "100.0")
        self.assertFalse(self.check(page.replace("[small ± 1]", "[nightly, small ± 3.1]"))[0])

    def test_a_number_that_the_small_run_does_not_hold_has_to_be_said(self):
        self.wrong(self.change(" [nightly]", ""), "would pass if it were wrong by 5 %")
        self.wrong(self.change(" [nightly]", " [small ± 3.1]"), "would pass if it were wrong by 5 %")
        self.assertFalse(self.check(self.change(" [nightly]", ""), "--full")[0])
        self.assertEqual(self.check(BOTH, "--list"), (False, "one.md: One: 100.0, 40.0\n"))

    def test_bounds(self):
        page = self.change("−3 exactly", "below 4·10⁻¹²").replace(
            'below 4·10⁻¹² = position(noise_scale=0.1, quantity="north").exact',
            'below 4·10⁻¹² >= position(case="test 1", quantity="north").exact')
        self.assertFalse(self.check(page, "--full")[0])
        self.wrong(page.replace("4·10⁻¹²", "4·10⁻¹³"), "10⁻¹³", "--full")
        self.wrong(page.replace(">= position", "<= position"), "4·10⁻¹²", "--full")

    def test_quote_has_to_stand_in_the_text(self):
        self.wrong(self.change("gives 100.0 m", "gives 99.9 m"), "does not stand")
        # in its own section
        self.wrong(self.change("and −3", "### Deeper\nand −3"), "does not stand")
        self.assertFalse(self.check(self.change("to the north, a", "to the\nnorth, a"))[0])

    def test_sections_are_those_of_the_page(self):
        self.wrong(self.change('section = "One"', 'section = "Two"'), "has 0 sections 'Two'")
        self.wrong(self.change("~~~", "## One\n~~~"), "has 2 sections 'One'")
        self.wrong(self.change("~~~", "<!-- numbers of: configs/thesis/table5.toml -->\n~~~"), "no more in the page")

    def test_command_has_to_stand_in_the_text(self):
        self.wrong(self.change("--trials 1000000` gives", "--trials 100000` gives"), "does not say")
        self.wrong(self.change("run configs/thesis/table5.toml --trials 1000000`", "run table5.toml --trials 1000000`"), "does not say")

    def test_commands_are_whole_and_run(self):
        for more, word in [("`run table5.toml --trials 2`", "not whole"), ("`surveymc run table5.toml --trials 2`", "not whole"),
                           ("`surveymc run configs/thesis/table6.toml --trials 7`", "no number is tied"),
                           ("\n```sh\nbuild/surveymc run configs/thesis/table6.toml --seed 7\n```\n", "no number is tied")]:
            self.wrong(PAGE + more + "~~~" + CLAIMS, word)
        self.wrong("# Studies\n## One\nNothing.\n", "no number is tied")
        more = PAGE + "`surveymc run configs/thesis/table6.toml --seed 7` ~~~" + CLAIMS
        self.assertFalse(self.check(more + '[not_run]\n"surveymc run configs/thesis/table6.toml --seed 7" = "it takes a day"\n')[0])
        self.assertFalse(self.check(PAGE + "`surveymc run CONFIG`~~~" + CLAIMS)[0])

    def test_mistakes_in_claims(self):
        for old, new, word in [("75 % = share", "75 % : share", "must be QUOTE"),
                               ('of = "surveymc run', 'of = "surveymc show', "must be a config"),
                               ("held =", "kept =", "unknown key kept"), ("[[numbers]]", "[[numbers]", "line"),
                               ('quantity="north").exact', 'quantity="up").exact', "no row"),
                               ('quantity="north").exact', 'quantity="north").exacter', "no column 'exacter'"),
                               ("= share(position()", "= share(positions()", "positions"),
                               ("ratio(inclination=90)", "ratio(inclination=91)", "no inclination"),
                               ("= 90, ratio(inclination=90)", "= ratio(inclination=90)", "2 numbers, the expression 1"),
                               ('small = "--trials 10"', 'small = "--set bad.key=1"', "unknown key")]:
            self.wrong(self.change(old, new), word)

    def test_numbers_are_read_as_written(self):
        for text, values in {"1.06, 1.05": [1.06, 1.05], "−.5 and 1,000": [-0.5, 1000], "4·10⁻¹²": [4e-12], "10⁶": [1e6],
                             "12 %, 3%": [0.12, 0.03], "∞, −∞": [float("inf"), -float("inf")], "s0 and trajectory-3": [],
                             "5.08e-5": [5.08e-5], "2–3": [2, 3], "14.3°, 50 nT": [14.3, 50], "8.4·10⁷": [8.4e7]}.items():
            found = check_docs.numbers_in(text)
            self.assertEqual(len(found), len(values), text)
            for number, value in zip(found, values):
                self.assertAlmostEqual(number.value, value, delta=1e-12 * abs(value) if abs(value) < float("inf") else None)
        halves = {"1.06": 0.005, ".5": 0.05, "6800": 50, "20": 0.5, "12 %": 0.005, "1.5·10³": 50, "0": 0, "1": 0, "1.0": 0.05}
        for text, half in halves.items():
            self.assertAlmostEqual(check_docs.numbers_in(text)[0].rounding, half, delta=1e-12)

    def test_values_of_monte_carlo_carry_their_intervals(self):
        a, b = check_docs.Measured([2.0], 0.3), check_docs.Measured([4.0], 0.4)
        self.assertAlmostEqual((a + b).half[0], 0.5)
        self.assertAlmostEqual((a - b).half[0], 0.5)
        self.assertAlmostEqual((a / b).half[0], 0.5 * (0.15**2 + 0.1**2) ** 0.5)
        self.assertAlmostEqual((a * b).half[0], 8 * (0.15**2 + 0.1**2) ** 0.5)
        self.assertAlmostEqual((1 / b).half[0], 0.025)
        self.assertAlmostEqual((b**0.5).half[0], 0.1)
        self.assertEqual((1 - a).values[0], -1)


if __name__ == "__main__":
    unittest.main()
