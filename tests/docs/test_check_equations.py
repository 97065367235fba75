#!/usr/bin/python3
"""check_equations.py finds whatever is wrong with docs/equations.md and architecture.md: test_check_equations.py SOURCE

Takes the project's own page and headers, spoils one thing at a time, and asks for the complaint.
"""
import contextlib
import io
import pathlib
import re
import sys
import unittest

SOURCE = pathlib.Path(sys.argv.pop(1)).resolve()
sys.path.insert(0, str(SOURCE / "tests/docs"))
import check_equations  # noqa: E402


class Spoiled:
    """Reads files of the project, one of them with a change."""

    def __init__(self, name, old, new):
        self.path, self.old, self.new = SOURCE / name, old, new

    def __enter__(self):
        self.read = pathlib.Path.read_text

        def read(path, *options):
            text = self.read(path, *options)
            if path == self.path:
                assert self.old in text, f"{path} has no {self.old}"
                text = text.replace(self.old, self.new, 1)
            return text
        pathlib.Path.read_text = read

    def __exit__(self, *_):
        pathlib.Path.read_text = self.read


class CheckEquations(unittest.TestCase):
    def check(self):
        sys.argv = ["check_equations.py", str(SOURCE)]
        with contextlib.redirect_stdout(io.StringIO()) as out:
            return check_equations.main(), out.getvalue()

    def wrong(self, name, old, new, complaint):
        with Spoiled(name, old, new):
            bad, out = self.check()
        self.assertTrue(bad, f"{name}: {new} passes")
        self.assertRegex(out, complaint)

    def page(self, old, new, complaint):
        self.wrong("docs/equations.md", old, new, complaint)

    def test_the_page_is_right(self):
        bad, out = self.check()
        self.assertFalse(bad, out)

    def test_names_that_do_not_exist(self):
        self.page("`frames.h`: `magnetic_T`", "`frame.h`: `magnetic_T`", r"`frame\.h`: no such file")
        self.page("`frames.h`: `magnetic_T`", "`frames.h`: `magnetic_N`", "`frames.h` has no magnetic_N")
        self.page("`Aakr::predict`", "`Aakr::foretell`", "`aakr.h` has no foretell")
        self.page('`test_error_sum.cpp`: "Errors join', '`test_error_sum.cpp`: "Errors part', 'has no test case "Errors part')
        self.page("`test_error_sum.cpp`", "`test_error_sums.cpp`", "no such file")
        self.page("`single_station/axial_correction.h`", "`study.h`", "several files")

    def test_a_name_in_a_comment_is_no_function(self):
        self.page("`frames.h`: `magnetic_T`", "`frames.h`: `thesis`", "`frames.h` has no thesis")

    def test_rows_in_another_form(self):
        self.page("`frames.h`: `magnetic_T`", "magnetic_T of frames.h", "functions must be")
        self.page("`test_stats.cpp`: \"Wishart", "test_stats.cpp \"Wishart", "tests must be")
        self.page("| 33 | balanced", "| 33 | more | balanced", "5 columns")
        self.page('`test_error_sum.cpp`: "Errors join within a station, a survey leg or the well, as their mode says"',
                  "`test_error_sum.cpp`", "say which test case")

    def test_equations_that_are_missing_or_twice_told(self):
        self.page("| 41–47 |", "| 41–46 |", "Vis.*equation 47 is missing")
        self.page("| 48, 49 |", "| 48–50 |", "there is no equation 50")
        self.page("11 (length", "11, 12 (length", "Hanak.*12 is in the table and not built")
        self.page("(44 equations)", "", "no section of Nyrnes")

    def test_citations_without_a_row(self):
        self.page("| 36–40 |", "| 37–40 |", "equation 36 is missing")
        self.page("43, 45 (44", "36, 43, 45 (44", "equation 36 is in the table and not built")
        self.wrong("lib/survey/frames.h", "Thesis eq 49", "Eq 49", "of which source")
        self.wrong("lib/reliability/snooping.h", "(section 2.2.3)", "(eq 4)", "snooping.h: cites eq 4: not named")
        self.wrong("lib/monitoring/metrics.h", "(eq 12)", "(eq 15)", "cites equation 15: no row")
        self.page("Muirhead 1982", "Muirhead", "Muirhead 1982: not on")

    def test_architecture(self):
        self.wrong("docs/architecture.md", "`predict_msa`", "`predict_all`", "`msa_prediction.h` has no predict_all")
        self.wrong("docs/architecture.md", "`montecarlo`", "`casino`", "module montecarlo of lib is not named")

    def test_numbers_are_read_as_written(self):
        self.assertEqual(check_equations.expand("8–10, 19 and 21"), [8, 9, 10, 19, 21])
        self.assertEqual(check_equations.expand("slides"), [])
        self.assertEqual([re.sub(r"\D+", " ", h[1]) for h in check_equations.CITATION.finditer("eqs 4, 7), eq 11 and eq 12")],
                         ["4 7", "11", "12"])


if __name__ == "__main__":
    unittest.main()
