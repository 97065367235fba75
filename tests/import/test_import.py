#!/usr/bin/python3
"""surveymc.importer: every form it reads, with no digit lost, and every bad input told with place, value, rule, way out.

    test_import.py [SURVEYMC]      with the program: it reads what is written
"""
import contextlib
import io
import math
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest
import zipfile
from unittest import mock

PACKAGE = pathlib.Path(__file__).resolve().parents[2] / "scripts/surveymc"
sys.path.insert(0, str(PACKAGE.parent))
from surveymc.importer import __main__ as import_survey  # noqa: E402
from surveymc.importer import output  # noqa: E402
from surveymc.importer.problem import Problem  # noqa: E402

PROGRAM = None
STATIONS = [("1000.10", "2.50", "45.00"), ("1030.0", "4.8", "46.25"), ("1060.55", "7.125", "46.5")]
METRES = "md_m,inclination_deg,azimuth_deg\n" + "".join(",".join(s) + "\n" for s in STATIONS)
FEET = METRES.replace("md_m", "md_ft")


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="surveymc-import-"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(self.folder)
        synced = mock.patch.object(output.os, "fsync")  # a disk takes its time; test_as_a_program has the real one
        self.synced = synced.start()
        self.addCleanup(synced.stop)

    def run_on(self, content, *options, name="in.csv"):
        """(code, what was printed or the message, what was written or None)."""
        data = content if isinstance(content, bytes) else content.encode()
        (self.folder / name).write_bytes(data)
        target, printed = self.folder / "out.csv", io.StringIO()
        target.unlink(missing_ok=True)
        code = 0
        try:
            with contextlib.redirect_stdout(printed):
                import_survey.run(import_survey.arguments([name, "-o", "out.csv", *options]))
        except Problem as problem:
            code = problem.code
            printed.write(str(problem))
        left = sorted(p.name for p in self.folder.iterdir())
        self.assertFalse([n for n in left if n.startswith(".")], "a temporary file is left")
        return code, printed.getvalue(), target.read_text() if target.exists() else None

    def gives(self, content, wanted, *options, says=(), name="in.csv"):
        code, said, written = self.run_on(content, *options, name=name)
        self.assertEqual((code, written), (0, wanted), said)
        self.assertGreaterEqual(self.synced.call_count, 2, "file and folder must be synced")
        for text in says:
            self.assertIn(text, said)
        return said

    def refused(self, content, *texts, options=(), code=65, name="in.csv"):
        got, said, written = self.run_on(content, *options, name=name)
        self.assertEqual(got, code, said)
        self.assertIsNone(written)
        self.assertNotIn("\n", said)
        for text in texts:
            self.assertIn(text, said)


def table(separator=",", head=("MD (m)", "Incl (deg)", "Azimuth Grid (deg)"), rows=STATIONS, end="\n"):
    return end.join(separator.join(r) for r in [head, *rows]) + end


class Text(Case):
    def test_separators_and_line_ends(self):
        for separator in ",;\t|":
            for end in "\n", "\r\n", "\r":
                self.gives(table(separator, end=end), METRES)
        self.gives(table(" ", ("MD_m", "Inc", "AziG")), METRES)

    def test_usual_headings(self):
        for md in "MD", "md", "Measured Depth", "MEAS. DEPTH", "Meas Depth", "Measured_Depth", "MeasuredDepth", "Depth", "DEPT", "MD (RKB)":
            for inc, azi in [("INC", "AZI"), ("Incl.", "Azim"), ("Inclination", "Azimuth"), ("DEVI", "HAZI"), ("Hole Inclination", "AZIMUTH"),
                             ("inclination_deg", "azimuth_deg"), ("Inc (°)", "Azi (°)"), ("Drift", "AZM"), ("Incl [degrees]", "Azimuth Angle [degrees]")]:
                self.gives(table(head=(f"{md} [m]", inc, azi)), METRES, "--azimuth-reference", "grid")

    def test_depth_units(self):
        for unit in "(ft)", "[feet]", "ft", "(FT)", "_ft":
            self.gives(table(head=(f"Measured Depth {unit}", "INC", "AZI TRUE")), FEET)
        self.gives(table(head=("MD", "INC", "AZI TRUE")), FEET, "--depth-unit", "ft")
        self.refused(table(head=("MD", "INC", "AZI TRUE")), "in.csv:line 1: column 'MD': no unit", "--depth-unit m|ft|usft")
        self.refused(table(head=("MD (ft)", "INC", "AZI TRUE")), "heading says ft", options=["--depth-unit", "m"])
        self.refused(table(head=("MD (m)", "INC", "AZI TRUE")), "heading says m", options=["--depth-unit", "usft"])
        self.refused(table(head=("MD (deg)", "INC", "AZI TRUE")), "unit 'deg': must be one of ft, m, usft")

    def test_us_survey_feet_are_not_feet(self):
        rows = [("3937", "1", "10"), ("39370.00", "2", "12")]
        wanted = "md_m,inclination_deg,azimuth_deg\n1200,1,10\n12000,2,12\n"  # exactly, by the definition of the unit
        for unit in "usft", "ftUS", "US ft", "ft[US]", "US Survey Feet":
            self.gives(table(head=(f"MD ({unit})", "INC", "AZI GRID"), rows=rows), wanted, says=["1200/3937"])
        self.gives(table(head=("MD (ft)", "INC", "AZI GRID"), rows=rows), wanted, "--depth-unit", "usft")

    def test_north(self):
        for word, name in [("True", "true"), ("TN", "true"), ("Grid", "grid"), ("GN", "grid"), ("Magnetic", "magnetic"), ("Mag", "magnetic")]:
            self.gives(table(head=("MD (m)", "Inc", f"Azimuth {word} (deg)")), METRES, says=[f'azimuth_reference = "{name}"'])
            self.gives(table(head=("MD (m)", "Inc", f"Azi ({word})")), METRES, says=[f'azimuth_reference = "{name}"'])
        self.refused(table(head=("MD (m)", "Inc", "Azi Mag Corr")), "more than one north, or one that was corrected")
        plain = table(head=("MD (m)", "Inc", "Azi"))
        for said in "North Reference: Magnetic/Grid", "Azimuth ref: true to grid corr applied", "Azimuth reference: True (raw: magnetic)":
            self.refused(said + "\n" + plain, "more than one north", "line 1")
            self.gives(said + "\n" + plain, METRES, "--azimuth-reference", "grid", says=["grid north (--azimuth-reference)"])
        self.gives("North Reference: Grid   Geo datum: true ellipsoid\n" + plain, METRES, says=['"grid"'])
        self.refused(plain, "which north", "--azimuth-reference true|magnetic|grid")
        self.gives("North Reference:,Grid\n\n" + plain, METRES, says=['"grid"', "line 1"])
        self.refused("North Reference: Grid\nNorth Reference: True\n" + plain, "more than one north")
        self.refused(table(), "says grid north, --azimuth-reference says true", options=["--azimuth-reference", "true"])
        both = table(head=("MD (m)", "Inc", "Azi True", "Azi Grid"), rows=[(*s, "99") for s in STATIONS])
        self.refused(both, "2 columns are the azimuth", "--azimuth-reference or --columns")
        self.gives(both, METRES, "--azimuth-reference", "true", says=["ignored          Azi Grid"])

    def test_titles_units_notes_and_more_columns(self):
        text = ("Survey of a well\nCompany: A\nField,50000,72.1,63.0\n\nMD,TVD,Incl,Azim,Comment\n(m),(m),(deg),(deg),\n"
                "1000.10,1000,2.50,45.00,tie-on\n\n1030.0,1029,4.8,46.25,\n1060.55,1059,7.125,46.5,\nEnd of survey\nprinted by A\n")
        said = self.gives(text, METRES, "--azimuth-reference", "true", says=["header: lines 5-6", "TVD", "Comment", "lines 11, 12"])
        self.assertIn("3 stations, md_m 1000.10 to 1060.55; largest inclination 7.125 deg, largest dogleg 2.31 deg/30 m (line 9)", said)

    def test_heading_over_two_lines(self):
        self.gives("Measured,Hole,Grid,Vertical\nDepth,Incl,Azimuth,Depth\nm,deg,deg,m\n" + "".join(",".join(s) + ",9\n" for s in STATIONS), METRES,
                   says=['"grid"', "ignored          Vertical Depth m"])

    def test_a_line_above_an_empty_one_is_no_heading(self):
        for separator in ",", "  ":
            rows = "".join(separator.join(s) + "\n" for s in STATIONS)
            line = lambda *words: separator.join(words) + "\n"
            title, names, units = line("Survey", "Measured", "Azimuth"), line("MD", "Inc", "Azi_Grid"), line("m", "deg", "deg")
            self.gives(f"{title}\n{names}{units}{rows}", METRES, says=["header: lines 3-4"])
            self.gives(f"{title}\n{names}\n{units}\n{rows}", METRES, says=["header: lines 3-5"])  # units may stand apart
            self.refused(f"{title}\n{line('Depth', 'Inc', 'Angle')}{rows}", "line 3: ", "found no azimuth")

    def test_decimal_commas_and_thousands(self):
        comma = [tuple(c.replace(".", ",") for c in s) for s in STATIONS]
        wanted = METRES
        self.gives(table(";", rows=comma), wanted, says=["decimal comma"])
        self.gives(table(",", rows=[tuple(f'"{c}"' for c in s) for s in comma]), wanted)
        self.gives(table(" ", ("MD_m", "Inc", "AziG"), comma), wanted)
        groups = lambda sep, rows: [(s[0][0] + sep + s[0][1:], *s[1:]) for s in rows]
        self.gives(table(";", rows=groups(".", comma)), wanted)
        self.gives(table(";", rows=groups(" ", comma)), wanted)
        self.gives(table(";", rows=groups("\u00a0", comma)), wanted)
        self.gives(table("\t", rows=groups(",", STATIONS)), wanted)
        self.refused(table(","  , rows=comma), "6 values: must be 3", "quoted")

    def test_a_comma_that_may_be_either_is_asked_for(self):
        text = table(";", rows=[("1,234", "10", "20"), ("1,264", "12", "21")])
        self.refused(text, "in.csv:line 2: MD (m): '1,234'", "--decimal comma or --decimal point")
        self.gives(text, "md_m,inclination_deg,azimuth_deg\n1234,10,20\n1264,12,21\n", "--decimal", "point")
        said = self.gives(text, "md_m,inclination_deg,azimuth_deg\n1.234,10,20\n1.264,12,21\n", "--decimal", "comma")
        self.assertIn("decimal comma", said)
        self.refused(table(";", rows=[("1000,5", "10.5", "20"), ("1010", "12", "21")]), "'10.5'", "decimal comma", "decimal point")
        self.refused(table(";", rows=[("10,00.5", "10.5", "20"), ("1010", "12", "21")]), "'10,00.5': must be a number", "groups")

    def test_encodings(self):
        text = table(head=("MD (m)", "Incl (°)", "Azimuth Grid (°)"))
        for encoding in "utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "latin-1", "utf-32":
            self.gives(text.encode(encoding), METRES)
        self.gives(text.encode("cp037"), METRES, "--encoding", "cp037")
        self.refused(text, "unknown", options=["--encoding", "klingon"], code=64)
        self.refused(text.encode("latin-1"), "byte", "--encoding", options=["--encoding", "utf-8"])

    def test_every_digit(self):
        rows = [("1000.123456789012345678", "1.00000000000000000001", "1e1"), ("2000.10", "2.5000", "10.50")]
        self.gives(table(rows=rows), "md_m,inclination_deg,azimuth_deg\n" + "".join(",".join(r) + "\n" for r in rows))

    def test_columns_by_option(self):
        bare = "".join(",".join(("7", *s)) + "\n" for s in STATIONS)
        options = ["--columns", "md=2,inc=3,azi=4", "--depth-unit", "m", "--azimuth-reference", "grid"]
        self.gives(bare, METRES, *options)
        self.refused(bare, "no header", "--columns md=NUMBER")
        self.gives(table(head=("a [m]", "b", "c")), METRES, "--columns", "md=a [m],inc=b,azi=3", "--azimuth-reference", "grid")
        self.refused(table(), "md=9: must be in [1, 3]", options=["--columns", "md=9"], code=64)
        self.refused(table(), "no column has this heading", options=["--columns", "md=zz"], code=64)
        self.refused(table(), "unknown; must be one of md, inc, azi, tf", options=["--columns", "x=1"], code=64)
        self.refused(table(), "taken twice", options=["--columns", "md=2,inc=2"], code=64)
        self.refused(table(head=("MD (m)", "what", "Azi Grid")), "headings 1 'MD (m)', 2 'what'", "--columns")
        self.refused(table(head=("MD (m)", "Measured Depth (ft)", "Inc", "Azi Grid"), rows=[("5", *s) for s in STATIONS]), "2 columns are the measured depth")

    def test_az_is_the_azimuth(self):
        self.gives(table(head=("MD (m)", "Inc", "Az Grid")), METRES)

    def test_grad_is_degree_or_gon(self):
        for unit in "Grad", "gr":
            text = table(head=("MD (m)", f"Inc ({unit})", f"Azi Grid [{unit}]"))
            self.refused(text, f"unit '{unit}': is the degree in some languages", "--angle-unit deg|gon")
            self.gives(text, METRES, "--angle-unit", "deg")

    def test_digits_of_other_scripts_are_no_numbers(self):
        self.refused(table(rows=[("\uff11\uff10\uff10", "2", "45"), ("130", "3", "46")]), "in.csv:line 2: MD (m) = ", "must be a number")
        self.refused(table(rows=[("130", "3", "46"), ("140", "\u0663", "46")]), "in.csv:line 3: Incl (deg) = ", "must be a number")

    def test_a_point_that_may_be_either_is_asked_for(self):
        text = table(";", rows=[("1.000", "10", "20"), ("1.030", "12", "21")])
        self.refused(text, "in.csv:line 2: MD (m): '1.000': the point may be", "--decimal point or --decimal comma")
        self.gives(text, "md_m,inclination_deg,azimuth_deg\n1000,10,20\n1030,12,21\n", "--decimal", "comma")
        rows = [("100.250", "10.000", "20.500"), ("130.250", "12.125", "21.000")]  # an angle of ten thousand there is not
        self.gives(table(rows=rows), "md_m,inclination_deg,azimuth_deg\n" + "".join(",".join(r) + "\n" for r in rows))

    def test_headings_in_quotes_over_lines(self):
        rows = "".join(",".join(s) + "\n" for s in STATIONS)
        self.gives('"MD\n(m)","Incl\n(deg)","Azi\nGrid\n(deg)"\n' + rows, METRES, says=["header: line 5"])
        self.refused('"MD (m),Incl,Azi Grid\n' + rows.replace("2.50", '2.50"'), "in.csv")  # no row of data goes into a heading

    def test_comments_below_the_header(self):
        self.gives("MD (m),Incl,Azi Grid\n# tool 5\n" + "".join(",".join(s) + "\n" for s in STATIONS), METRES)

    def test_a_bad_first_row_is_named(self):
        self.refused(table(rows=[("1000", "2\u00b030'", "45.0"), *STATIONS]), "in.csv:line 2: Incl (deg) = '2\u00b030'': must be a number", "--skip-lines 2")

    def test_another_header_further_down(self):
        first, rows = table(head=("MD (m)", "Inc (deg)", "Azi Grid (deg)")), [("1090", "8", "47"), ("1120", "9", "48")]
        for head, says in [(("MD (ft)", "Inc (deg)", "Azi Grid (deg)"), "'MD (ft)'"), (("MD (m)", "Inc (deg)", "Azi True (deg)"), "'Azi True (deg)'"),
                           (("MD (m)", "Azi Grid (deg)", "Inc (deg)"), "'Azi Grid (deg)'"), (("(ft)", "(deg)", "(deg)"), "'(ft)'")]:
            self.refused(first + "\n" + table(head=head, rows=rows), "in.csv:line 6: " + says, "another header", "--skip-lines 6")
        wanted = METRES + "".join(",".join(r) + "\n" for r in rows)
        self.gives(first + "\nPage 2\n" + table(head=("MD (m)", "Inc (deg)", "Azi Grid (deg)"), rows=rows), wanted)
        self.gives(first + "\nPage 2\n" + table(head=("Depth m", "Incl", "Azim"), rows=rows), wanted)
        fixed = "MD      Inc     Azi\n(m)    (deg)   (grid)\n100.0  1.0     20.0\n130.0  1.0     20.0\n"
        again = fixed.replace("100.0 ", "160.0 ").replace("130.0 ", "190.0 ")
        self.gives(fixed + again, "md_m,inclination_deg,azimuth_deg\n" + "".join(f"{m}.0,1.0,20.0\n" for m in (100, 130, 160, 190)))
        self.refused(fixed + again.replace("(m) ", "(ft)"), "in.csv:line 6: '(ft)': another header")

    def test_toolface(self):
        text = table(head=("MD (m)", "Inc", "Azi Grid", "GTF"), rows=[(*s, "120.0") for s in STATIONS])
        self.refused(text, "--toolface-zero x|y, or --no-toolface")
        wanted = METRES.replace("\n", ",120.0\n").replace("deg,120.0", "deg,toolface_deg")
        self.gives(text, wanted, "--toolface-zero", "x", says=['toolface_zero = "x"'])
        self.gives(text, METRES, "--no-toolface")


REPORT = """\
                             Example Drilling
                              Survey Report
Company:    Example AS                     North Reference:      Grid
Site:       Pad 7                          Survey Calculation Method:   Minimum Curvature

Survey
   Measured                              Vertical                          Dogleg
    Depth    Inclination   Azimuth        Depth      +N/-S      +E/-W       Rate
    (usft)       (°)         (°)         (usft)     (usft)     (usft)   (°/100usft)

       0.00       0.00         0.00         0.00       0.00       0.00        0.00
   3,937.00       2.50        45.00     3,936.00      10.00      10.00        0.10
                 KOP
\f   Measured                              Vertical                          Dogleg
    Depth    Inclination   Azimuth        Depth      +N/-S      +E/-W       Rate
    (usft)       (°)         (°)         (usft)     (usft)     (usft)   (°/100usft)

   7,874.00      12.50        46.00     7,850.00     100.00     100.00        0.25

  22 November                            Page 2                        Example 5.0
"""


class Titles(Case):
    """What lines besides the table say of units: never overruled in silence."""
    def under(self, title, head="MD (m)"):
        return title + "\n" + table(head=(head, "Incl (deg)", "Azimuth Grid (deg)"))

    def test_a_unit_of_depth_must_be_that_of_the_heading(self):
        for title in ("Depth Units: Feet", "Units: ft", '"Units","ft"', "# units = feet", "Depths are in feet.", "MD unit\tft",
                      "Measured Depth Units: ft (RKB)"):
            self.refused(self.under(title), "in.csv:line 1", "says ft, the heading 'MD (m)' m: must agree", "--depth-unit m")
            self.gives(self.under(title), METRES, "--depth-unit", "m")
        self.refused(self.under("Depth Units: Feet", "MD"), "no unit", "--depth-unit")

    def test_us_survey_feet_are_no_feet(self):
        content = self.under("Units: US survey feet", "MD (ft)")
        self.refused(content, "says usft, the heading 'MD (ft)' ft", "--depth-unit ft or --depth-unit usft")
        self.gives(content, FEET, "--depth-unit", "ft")
        code, said, written = self.run_on(content, "--depth-unit", "usft")
        self.assertEqual((code, written.split(",")[0]), (0, "md_m"), said)

    def test_titles_that_agree_or_are_of_other_things(self):
        for title in ("Depth Units: m", "Units: metres", "Units: m, deg, deg/30m", "Map units: ft", "DLS unit: deg/100ft",
                      "Inclination from vertical", "Horizontal section in ft", "Kick off depth: 1200 ft"):
            self.gives(self.under(title), METRES)

    def test_inclinations_from_the_horizontal(self):
        content = self.under("Inclination measured from horizontal")
        self.refused(content, "in.csv:line 1", "must be from the vertical", "--skip-lines 1")
        self.gives(content, METRES, "--skip-lines", "1")


class Doubts(Case):
    """What stands beside the three columns. The script says it; surveymc asks (tests/cli)."""
    @staticmethod
    def well(turn=0.0, scale=1.0, stations=20, build=2.0, height=0.0):
        """Rows of a well on one azimuth, exact: md, inc, azi, tvd, north, east."""
        radius, rows = 30 / math.radians(build), []
        for k in range(stations):
            angle = math.radians(build * k)
            out, down = radius * (1 - math.cos(angle)) * scale, radius * math.sin(angle) * scale
            azimuth = math.radians(60 + turn)
            rows.append((f"{30 * k}", f"{build * k:.2f}", "60", f"{down + height:.2f}", f"{out * math.cos(azimuth):.2f}", f"{out * math.sin(azimuth):.2f}"))
        return rows

    HEAD = ("MD (m)", "Inc (deg)", "Azi Grid (deg)", "TVD", "+N/-S", "+E/-W")

    def warned(self, content, *texts, options=()):
        code, said, written = self.run_on(content, *options)
        self.assertEqual(code, 0, said)
        warnings = [line for line in said.splitlines() if line.startswith("warning: ")]
        for text in texts:
            self.assertTrue(any(re.search(text, w) for w in warnings), said)
        self.assertTrue(texts or not warnings, warnings)
        return said

    def test_listed_positions_that_agree(self):
        for head in self.HEAD, ("MD (m)", "Inc", "Azi Grid", "True Vertical Depth (m)", "Northing (m)", "Easting (m)"), ("MD (m)", "Inc", "Azi Grid", "TVDSS", "NS", "EW"):
            self.warned(table(head=head, rows=self.well(height=-25)))
        heights = [(*r[:3], f"{25 - float(r[3]):.2f}", *r[4:]) for r in self.well()]
        self.warned(table(head=(*self.HEAD[:3], "TVDSS (m)", *self.HEAD[4:]), rows=heights))
        letters = [(*r[:4], r[4] + " N", r[5] + " E") for r in self.well()]
        self.warned(table(head=self.HEAD, rows=letters))
        feet = [(*r[:3], *(f"{float(c) / 0.3048:.2f}" for c in r[3:])) for r in self.well()]
        self.warned(table(head=(*self.HEAD[:3], "TVD (ft)", "N (ft)", "E (ft)"), rows=feet))

    def test_listed_positions_that_contradict(self):
        gon = [(r[0], f"{float(r[1]) / 0.9:.4f}", *r[2:]) for r in self.well(build=3.5)]
        self.warned(table(head=self.HEAD, rows=gon), r"line \d+: 'TVD' = \S+ \S+ m from the row before, where the angles give")
        self.warned(table(head=self.HEAD, rows=self.well(turn=180)), "lie [+-]180 deg from where the azimuths lead")
        mirrored = [(r[0], r[1], f"{60 + k}", *r[3:]) for k, r in enumerate(self.well(build=3.0, stations=30))]
        self.warned(table(head=self.HEAD, rows=mirrored), r"'\+N/-S', '\+E/-W'")
        self.warned(table(head=self.HEAD, rows=self.well(turn=2.5)), r"lie \+2\.5 deg .* are they from another north")
        self.warned(table(head=self.HEAD, rows=self.well(scale=1.01)), r"'TVD' = \S+ \S+ m off what minimum curvature gives from the angles over 570 m")
        self.warned(table(head=self.HEAD, rows=[(*r[:3], "7", *r[4:]) for r in self.well()]), "'TVD' holds 7 in all rows: not compared")
        self.warned(table(head=(*self.HEAD[:3], "TVD (ft)", *self.HEAD[4:]), rows=self.well()), "'TVD .ft.' = .* ft from the row before, where the angles give 98")

    def test_a_hole_straight_north_is_compared_too(self):
        rows = [(str(1000 + 30 * k), "30", "90", "", f"{15.0 * k:.1f}", "0.0") for k in range(6)]
        self.warned(table(head=self.HEAD, rows=rows), "lie -90 deg from where the azimuths lead")

    def test_wells_in_one_table(self):
        rows = [("A-1", *s) for s in STATIONS] + [("A-1 T2", f"{1100 + 30 * k}", "9", "40") for k in range(3)]
        for head in "Well", "Wellbore Name", "HoleID", "UWI":
            content = table(head=(head, "MD (m)", "Incl", "Azi Grid"), rows=rows)
            self.refused(content, f"in.csv:line 1: column 1 '{head}' names 2 wells: 'A-1', 'A-1 T2'", "--trajectory NAME")
            self.gives(content, METRES, "--trajectory", "A-1")
        self.refused(content, "must be one of 'A-1', 'A-1 T2'", options=["--trajectory", "B"], code=64)
        self.gives(table(head=("Hole Size", "MD (m)", "Incl", "Azi Grid"), rows=[(f"{12 - k}", *s) for k, s in enumerate(STATIONS)]), METRES)

    def test_stations_that_do_not_count(self):
        for head, word in [("QC", "FAIL"), ("Status", "Rejected"), ("Survey Quality", "bad"), ("Use", "N"), ("Accepted", "0"), ("Comment", "do not use")]:
            good = "" if head == "Comment" else {"N": "Y", "0": "1"}.get(word, "OK")
            rows = [(*s, word if k == 1 else good) for k, s in enumerate(STATIONS)]
            self.warned(table(head=("MD (m)", "Inc", "Azi Grid", head), rows=rows), f"line 3: column 4 '{head}' = '{word}'.*--skip-lines 3")
        for word in "Projected to TD", "PROJ", "Extrapolated", "bit projection":
            rows = [(*s, word if k == 2 else "") for k, s in enumerate(STATIONS)]
            self.warned(table(head=("MD (m)", "Inc", "Azi Grid", "Remark"), rows=rows), "line 4: column 4 'Remark' = .* is no measurement.*--skip-lines 4")
        self.warned(table(head=("MD (m)", "Inc", "Azi Grid", "QC"), rows=[(*s, "PASS") for s in STATIONS]))

    def test_lines_between_stations_that_name_a_well(self):
        more = "1100,9,48\n1130,10,49\n"
        self.warned("Well: A-1\n" + table() + "Well: A-2\n" + more, "line 6: 'Well: A-2' stands between stations: does another well begin.*--skip-lines 6-8")
        self.warned("Well: A-1\n" + table() + "Well: A-1\n" + more)
        self.warned(table() + "Sidetrack ST1\n" + more, "'Sidetrack ST1' stands between stations")

    def test_a_hole_that_begins_horizontal(self):
        self.warned(table(rows=[("0", "89", "40"), ("30", "88", "40")]), "inclination 89 deg at depth 0: .* from the horizontal")

    def test_minutes_of_angle_and_letters_of_the_compass(self):
        for head in "", "min", "Minutes", "Azi Min":
            rows = [(*s, f"{20 * k}") for k, s in enumerate(STATIONS)]
            self.warned(table(head=("MD (m)", "Inc", "Azi Grid", head), rows=rows), "column 4.* right of the azimuth .* minutes of angle")
        rows = [(s[0], s[1], "S", s[2], "W") for s in STATIONS]
        self.warned(table(head=("MD (m)", "Inc", "NS", "Azi Grid", "EW"), rows=rows), "column 3 'NS' beside the azimuth holds letters of the compass")

    def test_units_with_their_datum(self):
        for unit in "m RKB", "m MD", "mMDRT", "m KB":
            self.gives(table(head=(f"MD ({unit})", "Inc", "Azi Grid")), METRES)
            self.gives(table(head=(f"Depth ({unit})", "Inc", "Azi Grid")), METRES)
        self.gives(table(head=("MD (ft KB)", "Inc", "Azi Grid")), FEET)
        self.gives("MD,Inc,Azi Grid,TVD\nft RKB,deg,deg,ft RKB\n" + "".join(",".join(s) + ",1\n" for s in STATIONS), FEET)


class Bounds(Case):
    """Files made to take minutes end in seconds, with a message that names the bound and quotes a line at the most."""
    def test_a_clock_of_the_processor(self):
        self.addCleanup(signal.setitimer, signal.ITIMER_PROF, 0)
        with mock.patch.object(import_survey, "MOST_SECONDS", 0.05), self.assertRaisesRegex(Problem, "in.csv: takes more than 0.05 s of processor time"):
            import_survey.give_up("in.csv")
            re.search("(a+)+b", "a" * 60)  # ends in years: the clock is heard within an expression, too

    def test_many_attributes(self):
        for value in '"1"', "'>'":
            text = "<trajectorys><trajectory " + "\n".join(f"a{i}={value}" for i in range(200_000)) + "/></trajectorys>"
            self.refused(text, "in.csv:line 1: an element of 500 attributes or more")

    def test_lines_of_blanks(self):
        for line in "X" + " " * 19_000, " X." + " " * 9000 + "Y" + " " * 9000 + "Z":
            code, said, _ = self.run_on(LAS.replace("~Curve", line + "\n~Curve"))
            self.assertLess(len(said), 2000)

    def test_messages_quote_a_line_at_the_most(self):
        for content in (",".join(f"h{i}" for i in range(3000)) + "\n" + ",".join("1" * 3000) + "\n",
                        "<trajectorys>" + "".join(f'<trajectory uid="{i}"/>' for i in range(9000)) + "</trajectorys>",
                        table(head=("MD (m)", "Inc", "Azi Grid", *(f"well {i}" for i in range(2000))), rows=[(*s, *"1" * 2000) for s in STATIONS[:1]])):
            self.assertLess(len(self.run_on(content)[1]), 2500)


class Pairing(Case):
    """Headings and columns of text between spaces: paired where there is one way only."""
    ROWS = [("1500.00", "2.00", "130.00", "3.05"), ("1530.00", "5.00", "131.00", "3.05"), ("1560.00", "8.00", "132.00", "3.05")]
    WANTED = "md_m,inclination_deg,azimuth_deg\n" + "".join(",".join(r[:3]) + "\n" for r in ROWS)
    OPTIONS = ("--depth-unit", "m", "--azimuth-reference", "grid")

    def listing(self, name, gaps=(6, 9, 7, 4), head="Well             MD        INC        Azimuth    DLS"):
        return head + "\n" + "".join(name + "".join(" " * g + c for g, c in zip(gaps, r)) + "\n" for r in self.ROWS)

    def test_names_of_several_words(self):
        for name in "A-11", "A-11 T", "Pad X well no", "Øst B":
            self.gives(self.listing(name), self.WANTED, *self.OPTIONS)
            self.gives(self.listing(name, (1, 1, 1, 1)), self.WANTED, *self.OPTIONS)

    def test_what_does_not_pair_is_asked_for(self):
        for name in "Well 7", "7 A 2", "A 1 T":  # the number is a column of its own
            self.refused(self.listing(name, (3, 9, 7, 4)), "which belongs to which cannot be seen", "--columns md=NUMBER", options=self.OPTIONS)
        self.refused(table(head=("MD", "Inc", "Azi", "Remark"), rows=[("A", *r[:3], "x") for r in self.ROWS]), "5 values, as in all rows, below 4 headings",
                     options=self.OPTIONS)
        self.gives("   MD     Inc    Azi    TVD\n" + "".join(f"{k} {r[0]}  {r[1]}  {r[2]} {r[0]}\n" for k, r in enumerate(self.ROWS, 1)), self.WANTED, *self.OPTIONS)

    def test_a_column_without_a_heading_right_of_others(self):
        text = "MD      Inc     Azi\n" + "".join(f"{k:<8}{m:<8}{i:<8}{a}\n" for k, (m, i, a, _) in enumerate(self.ROWS, 1))
        self.refused(text, "column 4 has no heading: which belongs to which cannot be seen", "--columns md=NUMBER", options=self.OPTIONS)

    def test_bearings(self):
        rows = [("400.0", "1.00", "S 40.00 W"), ("430.0", "2.00", "N 41.25 E"), ("460.0", "4.00", "S 42.00 E"), ("490.0", "6.00", "N 43.5 W")]
        wanted = "md_m,inclination_deg,azimuth_deg\n400.0,1.00,220.00\n430.0,2.00,41.25\n460.0,4.00,138.00\n490.0,6.00,316.5\n"
        head = "Measured   Drift   Drift\n Depth     Angle   Direction\n  (m)      (deg)   (deg)\n"
        self.gives(head + "".join(f"  {m}    {i}   {a}\n" for m, i, a in rows), wanted, "--azimuth-reference", "grid")
        for write in (lambda a: a), (lambda a: a.replace(" ", "")), (lambda a: a.replace(" W", "° W")):
            self.gives(table(head=("MD (m)", "Inc", "Azi Grid"), rows=[(m, i, write(a)) for m, i, a in rows]), wanted)
        self.refused(table(head=("MD (m)", "Inc", "Azi Grid"), rows=[*rows, ("520", "6", "S 95 E")]), "line 6: Azi Grid = 'S 95 E': must be at most 90")

    def test_tables_below(self):
        more = "\nCasing Points\nMeasured,Vertical,Casing\nDepth (m),Depth (m),Diameter\n1090,1080,13\n"
        self.refused(table() + more, "in.csv:line 7: 'Measured Vertical Casing': another table begins here, below 3 stations", "--skip-lines 7-")
        self.gives(table() + more, METRES, "--skip-lines", "7-9")

    def test_norths_that_contradict(self):
        content = "North Reference: True\n" + table()
        self.refused(content, "says grid north, line 1 'North Reference: True' says true: must agree", "--azimuth-reference true|magnetic|grid")
        self.gives(content, METRES, "--azimuth-reference", "grid", says=['"grid"'])
        self.gives(content, METRES, "--azimuth-reference", "true", says=['"true"'])

    def test_a_vertical_hole_has_no_azimuth(self):
        rows = [("0", "0", ""), ("500", "0.0", ""), *STATIONS]
        said = self.gives(table(rows=rows), METRES.replace("_deg\n", "_deg\n0,0,45.00\n500,0.0,45.00\n"))
        self.assertIn("warning: in.csv:line 2: Azimuth Grid (deg) is empty at inclination 0 (and in 1 row more): taken from the next station, 45.00", said)
        self.refused(table(rows=[("0", "0.5", ""), *STATIONS]), "line 2: Azimuth Grid (deg) is empty")

    def test_from_the_bottom_up(self):
        self.assertIn("depths decrease from 1060.55 (line 2) to 1000.10 (line 4): read from the bottom up", self.gives(table(rows=STATIONS[::-1]), METRES))

    def test_forms_that_are_not_read(self):
        self.refused('[{"md": 1, "inc": 2}]', "is JSON: a survey must be a table")
        self.refused('{"stations": [[1, 2, 3]]}', "is JSON", "for six-axis readings: --readings")
        for page in "<html><body><table><tr><td>1</td></tr></table></body></html>", "<!DOCTYPE html>\n<p>", "<table><tr><td>MD</table>":
            self.refused(page, "is HTML", ".xlsx or CSV", name="in.xls")
        self.refused('<?xml version="1.0"?><Workbook xmlns="urn:schemas-microsoft-com:office:spreadsheet"/>', "Excel 2003")
        for angle in "2°30'", "2° 30.5' ", "S 2° 30' W":
            self.refused(table(rows=[("1000", "2.5", angle), ("1030", "3", angle)]), "degrees and minutes are not read: must be degrees with decimals")
        self.refused(table(head=("X", "Y", "TVD (m)")), "found no measured depth, no inclination, no azimuth; positions alone are not read")

    def test_columns_by_number_find_their_rows(self):
        records = "H1,3,0,1.0,9,8\nC,0,0,0,note\n" + "".join(f"P,0,1,,D,{','.join(s)}\n" for s in STATIONS)
        self.gives(records, METRES, "--columns", "md=6,inc=7,azi=8", *self.OPTIONS)


class Reports(Case):
    def test_fixed_columns_with_pages(self):
        self.gives(REPORT, "md_m,inclination_deg,azimuth_deg\n0,0.00,0.00\n1200,2.50,45.00\n2400,12.50,46.00\n",
                   says=["fixed-width text", "header: lines 7-9", '"grid"', "line 3", "Vertical Depth (usft)"])

    def test_a_missing_value_is_seen_by_its_place(self):
        self.refused(REPORT.replace("   3,937.00       2.50        45.00", "   3,937.00                   45.00"), "in.csv:line 12", "is empty", "--skip-lines 12")

    def test_a_space_for_thousands_is_no_column(self):
        self.refused("    MD (m)   Inc   Azi (True)\n  1 000.00  1.00   10.00\n  1 030.00  2.00   10.00\n", "'1 000.00'", "--columns")

    def test_ragged(self):
        text = "MD_ft Inc Azi_true TVD\n0 0 0 0\n30.5 1 10 3\n1000.25 20 10\n"
        self.refused(text, "in.csv:line 4: ")
        self.gives(text, "md_ft,inclination_deg,azimuth_deg\n0,0,0\n30.5,1,10\n", "--skip-lines", "4")


LAS = """\
~VERSION INFORMATION
 VERS.   2.0 : CWLS LOG ASCII STANDARD
 WRAP.   NO  : ONE LINE A DEPTH
~Well
 STRT.M  1000.10 : START
 STOP.M  1060.55 : STOP
 NULL.   -999.25 : NULL VALUE
 WELL.   Example-1 : WELL
~Curve
 DEPT.M        : Measured depth
 DEVI.DEG      : Deviation
 GR  .GAPI     : Gamma ray
 HAZI.DEG      : Hole azimuth, grid north
# a comment
~A  DEPT DEVI GR HAZI
 1000.10  2.50 80 45.00
 1010.00 -999.25 81 -999.25
 1030.0   4.8 -999.25 46.25
 1060.55  7.125 83 46.5
"""


class Las(Case):
    def test_versions(self):
        self.gives(LAS, METRES, says=["LAS 2.0", "GR", '"grid"', "1 rows that hold only the null value -999.25"])
        self.gives(LAS.replace("2.0 :", "1.2 :").replace("M  ", "M "), METRES, says=["LAS 1.2"])
        self.gives(LAS.replace("DEPT.M ", "DEPT.F ").replace("STRT.M", "STRT.F").replace("STOP.M", "STOP.FT"), FEET)
        commas = LAS.replace("~Well", " DLM. COMMA : x\n~Well").replace("1000.10  2.50 80 45.00", "1000.10, 2.50,,45.00")
        self.gives(re.sub(r"(?m)^ (\d\S*) +(\S+) (\S+) (\S+)$", r" \1,\2,\3,\4", commas), METRES)
        body = LAS.replace("WRAP.   NO", "WRAP.   YES").replace(" 1000.10  2.50 80 45.00", " 1000.10\n 2.50 80\n 45.00")
        self.gives(body, METRES, says=["wrapped"])

    def test_bad(self):
        self.refused(LAS.replace("2.0 :", "3.0 :"), "VERS = '3.0': must be 1.2 or 2.0")
        self.refused(LAS.replace(" 1000.10  2.50 80 45.00", " 1000.10  2.50 45.00"), "in.csv:line 16: 3 values: must be 4")
        self.refused(LAS.replace("1030.0   4.8", "1030.0   -999.25"), "in.csv:line 18: DEVI is empty")
        self.refused(LAS.replace("DEPT.M ", "DEPT.  "), "DEPT", "--depth-unit")
        self.refused(LAS.split("~A")[0], "~A is missing")
        self.refused(LAS.replace(", grid north", ""), "--azimuth-reference")
        self.refused(LAS.replace("STOP.M", "STOP.FT"), "in.csv:line 6: STOP is in FT, the depth curve 'DEPT' (line 10) in M: must agree")
        self.refused(LAS.replace(": Measured depth", ": True vertical depth"), "no column is the measured depth", "'DEPT True vertical depth'")
        self.gives(LAS.replace(": Deviation", ": Deviation from the vertical"), METRES)
        for said in "Deviation from horizontal", "Dip of the hole", "Deviation (0 = horizontal)", "angle above the horizontal", "90 deg is vertical":
            self.assertIn("counts from the horizontal", self.run_on(LAS.replace(": Deviation", ": " + said))[1])
        self.refused(LAS.replace("~Curve", "~Other\nInclinations are measured from the horizontal\n~Curve"), "must be from the vertical")
        self.refused(LAS.replace("~Curve", "~P\n AZREF. TRUE : Azimuth reference\n~Curve"), "names more than one north")
        self.refused(LAS.replace("~Curve", "~P\n NREF. : North Reference: True\n~Curve"), "names more than one north")
        self.gives(re.sub(r"(?m)^ (\d.*)$", lambda m: " " + m[1].replace(".", ","), LAS).replace("-999,25", "-999.25"), METRES, "--decimal", "comma")


def witsml(version="1.4.1.1", md="md", station="trajectoryStation", uom="m", stations=STATIONS, azi_ref="<aziRef>grid north</aziRef>", name="A"):
    incl, azi = ("Incl", "Azi") if md == "Md" else ("incl", "azi")
    rows = "".join(f'<{station} uid="{i}">\n<{md} uom="{uom}">{s[0]}</{md}><tvd uom="m">1</tvd><{incl} uom="dega">{s[1]}</{incl}>'
                   f'<{azi} uom="dega">{s[2]}</{azi}></{station}>\n' for i, s in enumerate(stations))
    return f'<trajectory uid="t{name}"><name>{name}</name>{azi_ref}\n{rows}</trajectory>\n', version


def document(*trajectories):
    return ('<?xml version="1.0" encoding="UTF-8"?>\n<trajectorys xmlns="http://www.witsml.org/schemas/1series" version="'
            f'{trajectories[0][1]}">\n' + "".join(t[0] for t in trajectories) + "</trajectorys>\n")


class Witsml(Case):
    def test_versions(self):
        for version in "1.3.1.1", "1.4.1.1":
            self.gives(document(witsml(version)), METRES, says=[f"WITSML {version} trajectory 'A'", '"grid"', "tvd"])
        new, _ = witsml(md="Md", station="TrajectoryStation", azi_ref="<AziRef>true north</AziRef>")
        new = new.replace('<trajectory uid="tA"', '<Trajectory uuid="tA" schemaVersion="2.0" xmlns="http://www.energistics.org/energyml/data/witsmlv2"')
        new = new.replace("</trajectory>", "</Trajectory>").replace("<name>A</name>", "<Citation><Title>A</Title></Citation>")
        self.gives(new, METRES, says=["WITSML 2.0 trajectory 'A'", '"true"'])
        deeper = new.replace('<Md uom="m">', '<Md><MeasuredDepth uom="m">').replace("</Md>", "</MeasuredDepth></Md>")
        self.gives(deeper.replace('"2.0"', '"2.1"'), METRES, says=["WITSML 2.1"])

    def test_units(self):
        self.gives(document(witsml(uom="ft")), FEET)
        self.gives(document(witsml(uom="ftUS", stations=[("3937", "1", "2"), ("7874", "2", "3")])), "md_m,inclination_deg,azimuth_deg\n1200,1,2\n2400,2,3\n",
                   "--angle-unit", "deg")
        self.refused(document(witsml(uom="km")), "uom = 'km': must be one of")
        self.refused(document(witsml()).replace(' uom="m"', ""), "attribute uom is missing")
        self.refused(document(witsml(azi_ref="")), "--azimuth-reference")
        self.refused(document(witsml(azi_ref="<aziRef>grid north</aziRef><aziRef>true north</aziRef>")), "aziRef stands 2 times")

    def test_stations_that_do_not_count(self):
        def with_status(*words):
            parts = document(witsml(stations=[*STATIONS, ("1080", "9", "60")])).split("</trajectoryStation>")
            return "".join(p + (f"<statusTrajStation>{w}</statusTrajStation></trajectoryStation>" if w else "") for p, w in zip(parts, [*words, ""]))
        good = ["position"] * 3
        for word in "rejected", "open", "Rejected":
            self.gives(with_status(*good, word), METRES, says=[f"statusTrajStation = '{word.lower()}', md 1080: does not count, left out"])
        self.assertIn("is used: no station is of status 'position'", self.run_on(with_status(*["open"] * 4))[1])
        self.refused(with_status(*good, "doubtful"), "statusTrajStation = 'doubtful': must be one of position, open, rejected", "--skip-lines")
        content = with_status(*["position"] * 4)
        line = content[:content.index(">1080<")].count("\n") + 1
        self.gives(content, METRES, "--skip-lines", str(line), says=[f"left out         lines {line}"])
        self.refused(content, "no station of in.csv stands there", options=["--skip-lines", "1"], code=64)
        projected = content.replace("<md uom", "<typeTrajStation>extrapolated</typeTrajStation><md uom", 1)
        self.assertIn("'extrapolated': is no measurement", self.run_on(projected)[1])

    def test_listed_positions(self):
        text = document(witsml()).replace('<tvd uom="m">1</tvd>', '<tvd uom="m">1</tvd>', 1)
        for value in "1000", "1029", "1002":
            text = text.replace('<tvd uom="m">1</tvd>', f'<tvd uom="m">{value}</tvd>', 1)
        self.assertRegex(self.run_on(text)[1], "warning: .*'tvd' = 1002: -27 m from the row before, where the angles give 30.38")

    def test_a_north_that_is_not_known(self):
        self.refused(document(witsml(azi_ref="<aziRef>unknown</aziRef>")), "--azimuth-reference")
        self.gives(document(witsml(azi_ref="<aziRef>unknown</aziRef>")), METRES, "--azimuth-reference", "grid")

    def test_several(self):
        two = document(witsml(name="A"), witsml(name="B", stations=[("1", "1", "1"), ("2", "1", "1")]))
        self.refused(two, "2 trajectories: 1 'A', 2 'B'", "--trajectory")
        for which in "A", "tA", "1":
            self.gives(two, METRES, "--trajectory", which)
        self.refused(two, "must be meant", options=["--trajectory", "C"], code=64)

    def test_hostile(self):
        secret = self.folder / "secret"
        secret.write_text("1000")
        text = document(witsml())
        outside = text.replace("<trajectorys", f'<!DOCTYPE t [<!ENTITY x SYSTEM "file://{secret}">]>\n<trajectorys').replace("1000.10", "&x;")
        self.refused(outside, "document type")
        bomb = "".join(f'<!ENTITY a{i} "{f"&a{i - 1};" * 10 if i else "ha"}">' for i in range(12))
        self.refused(text.replace("<trajectorys", f"<!DOCTYPE t [{bomb}]>\n<trajectorys").replace("1000.10", "&a11;"), "in.csv")
        self.refused(text[:-30], "must be well-formed XML")
        self.refused("<a/>", "must hold a WITSML trajectory")
        self.refused("<a>" * 5000, "well-formed")


@unittest.skipUnless(__import__("importlib").util.find_spec("openpyxl"), "python3-openpyxl is not installed: scripts/bootstrap.sh import")
class Excel(Case):
    def book(self, sheets):
        import openpyxl
        book = openpyxl.Workbook()
        book.remove(book.active)
        for name, rows in sheets.items():
            sheet = book.create_sheet(name)
            for row in rows:
                sheet.append(row)
        held = io.BytesIO()
        book.save(held)
        return held.getvalue()

    ROWS = [["A survey"], [], ["MD", "Incl", "Azimuth Grid", "TVD"], ["(m)", "(deg)", "(deg)", "(m)"],
            [1000, 0.1, 45.5, 1], [1030, 4.8, 46.25, 2], [1060.55, 7.125, 46.5, 3], ["end"]]
    WANTED = "md_m,inclination_deg,azimuth_deg\n1000,0.1,45.5\n1030,4.8,46.25\n1060.55,7.125,46.5\n"

    def test_sheets(self):
        self.gives(self.book({"S": self.ROWS, "empty": []}), self.WANTED, says=["sheet 'S'", "rows 3-4", "row 8", '"grid"'])
        two = self.book({"S": self.ROWS, "T": [["x"]]})
        self.refused(two, "2 sheets with content: 'S', 'T'", "--sheet NAME")
        self.gives(two, self.WANTED, "--sheet", "S")
        self.refused(two, "must be one of 'S', 'T'", options=["--sheet", "U"], code=64)

    def test_bad(self):
        broken = [r[:] for r in self.ROWS]
        broken[5][1] = "n.m."
        self.refused(self.book({"S": broken}), "row 6: Incl (deg) = 'n.m.': must be a number", "--skip-lines 6")
        formula = [r[:] for r in self.ROWS]
        formula[5][1] = "=A6/2"  # without a value that a spreadsheet program kept
        self.refused(self.book({"S": formula}), "row 6: Incl (deg): formula '=A6/2': must have a value", "save it")
        formula[5][:3] = ["=A5+30", "=B5", "=C5"]  # a station, not a row without data
        self.refused(self.book({"S": formula}), "row 6: MD (m): formula '=A5+30': must have a value")
        self.refused(self.book({"S": [self.ROWS[2], *[["=1", "=2", "=3"]] * 3]}), "row 2: '=1': formulas must have values")
        self.refused(self.book({"S": self.ROWS})[:900], "must be an Excel workbook")
        self.refused(b"\xd0\xcf\x11\xe0" + bytes(100), "must be .xlsx")

    def rewritten(self, data, change):
        """The workbook with another text of its first sheet."""
        held = io.BytesIO()
        with zipfile.ZipFile(io.BytesIO(data)) as old, zipfile.ZipFile(held, "w") as new:
            for name in old.namelist():
                part = old.read(name)
                new.writestr(name, change(part) if name.endswith("sheet1.xml") else part)
        return held.getvalue()

    def test_formulas_of_an_empty_text(self):
        """Templates have them below the last station: their value is there, and is empty."""
        book = self.book({"S": [*self.ROWS[2:7], ['=""', '=""', '=""']]})
        self.refused(book, "row 6: MD (m): formula")
        kept = self.rewritten(book, lambda part: re.sub(rb'<c r="([ABC]6)"', rb'<c r="\1" t="str"', part))
        self.assertNotEqual(kept, book)
        self.gives(kept, self.WANTED)

    def test_hidden_rows_are_told(self):
        hide = lambda part: part.replace(b'<row r="6"', b'<row r="6" hidden="1"')
        self.gives(self.rewritten(self.book({"S": self.ROWS}), hide), self.WANTED, says=["hidden           row 6, read as any other"])

    def test_too_many_cells(self):
        import openpyxl
        far = openpyxl.Workbook()
        far.active["XFD1048576"] = 1.0  # one cell, and all rows and columns before it
        held = io.BytesIO()
        far.save(held)
        self.refused(held.getvalue(), "more than 500,000 cells", "as CSV")
        whole, many = self.book({"S": self.ROWS}), io.BytesIO()
        with zipfile.ZipFile(io.BytesIO(whole)) as old, zipfile.ZipFile(many, "w", zipfile.ZIP_DEFLATED) as new:
            for name in old.namelist():
                data = old.read(name)
                if name.endswith("sheet1.xml"):
                    data = data.replace(b"</sheetData>", b'<row r="9"><c/>' * 510_000 + b"</sheetData>")  # refused before it is parsed
                new.writestr(name, data)
        self.refused(many.getvalue(), "more than 500,000 cells", "as CSV")


    def with_format(self, head, number_format):
        import openpyxl
        book = openpyxl.Workbook()
        book.active.append([head, "Incl (deg)", "Azimuth Grid (deg)"])
        for row in STATIONS:
            book.active.append([float(cell) for cell in row])
            book.active.cell(book.active.max_row, 1).number_format = number_format
        held = io.BytesIO()
        book.save(held)
        return held.getvalue()

    def test_a_unit_in_a_number_format_must_be_that_of_the_heading(self):
        for number_format in ('0.0" ft"', '0.00\\ "ft"', '#,##0.0"ft";-0.0"ft"'):
            content = self.with_format("MD (m)", number_format)
            self.refused(content, "row 2: number format 'ft' says ft, the heading 'MD (m)' m", "--depth-unit m", name="in.xlsx")
            self.assertEqual(self.run_on(content, "--depth-unit", "m", name="in.xlsx")[0], 0)
        for head, number_format in (("MD (m)", '0.0" m"'), ("MD (ft)", '0.0" ft"'), ("MD (m)", '0.0" approx"'), ("MD (m)", "0.00")):
            self.assertEqual(self.run_on(self.with_format(head, number_format), name="in.xlsx")[0], 0, number_format)


class Readings(Case):
    HEAD = ("Depth (m)", "Gx", "Gy", "Gz", "Bx", "By", "Bz", "Temp")
    ROWS = [("100.0", "0.1", "-0.25", "0.95", "15000", "-2000.5", "44000", "30"), ("130.0", "0.15", "-0.2", "0.96", "15100", "2000", "44100", "31")]

    def make(self, g, b, rows=None):
        head = [h if i in (0, 7) else f"{h} ({g if i < 4 else b})" for i, h in enumerate(self.HEAD)]
        return table(";", head, rows or self.ROWS)

    def test_units(self):
        head = "md_m,gx_{g},gy_{g},gz_{g},bx_{b},by_{b},bz_{b}\n"
        mg = [("100", "-250", "950"), ("150", "-200", "960")]
        nt, ut = [r[4:7] for r in self.ROWS], [("15.000", "-2.0005", "44.000"), ("15.1", "2", "44.1")]
        write = lambda g, b, gs, bs: head.format(g=g, b=b) + "".join(",".join((r[0], *x, *y)) + "\n" for r, x, y in zip(self.ROWS, gs, bs))
        self.gives(self.make("g", "nT"), write("mg", "nT", [("100", "-250", "950"), ("150", "-200", "960")], nt), "--readings", says=["Temp"])
        rows = [(r[0], *m, *u, r[7]) for r, m, u in zip(self.ROWS, mg, ut)]
        for micro in "uT", "µT":
            self.gives(self.make("mg", micro, rows), write("mg", "uT", mg, ut), "--readings")
        si = [(r[0], "1.0", "-2.5", "9.4", *r[4:]) for r in self.ROWS]
        for name in "m/s2", "m/s^2", "m/s²":
            self.gives(self.make(name, "nT", si), write("mps2", "nT", [r[1:4] for r in si], nt), "--readings")
        gauss = [(*r[:4], "0.15", "-0.020005", "0.44", "3") for r in self.ROWS]
        self.gives(self.make("g", "gauss", gauss), write("mg", "uT", mg, [("15", "-2.0005", "44")] * 2), "--readings")

    def test_asked_for(self):
        self.refused(table(";", self.HEAD, self.ROWS), "column 'Gx': no unit", "--gravity-unit", options=["--readings"])
        code, said, _ = self.run_on(table(";", self.HEAD, self.ROWS), "--readings", "--gravity-unit", "g", "--field-unit", "nT")
        self.assertEqual(code, 0, said)
        self.refused(self.make("mps2", "nT"), "g long: must be in (0.5, 2)", "--gravity-unit", options=["--readings"])
        self.refused(self.make("g", "uT"), "uT long: must be in (5, 300)", options=["--readings"])
        self.refused(self.make("g", "nT").replace("Gy (g)", "Gy (mps2)"), "three axes must have one", options=["--readings"])
        self.refused(self.make("g", "nT").replace("Gx", "-Gx"), "'-Gx (g)'", "must name", options=["--readings"])
        self.refused(self.make("g", "nT"), "have no angles", options=["--readings", "--azimuth-reference", "grid"], code=64)

    def test_several_shots_at_one_depth(self):
        rows = [("100.0", *r[1:]) for r in self.ROWS]
        code, said, written = self.run_on(self.make("g", "nT", rows), "--readings")
        self.assertEqual(code, 0, said)
        self.assertEqual([line.split(",")[0] for line in written.splitlines()], ["md_m", "100.0", "100.0"])
        self.assertIn("1 rows repeat", said)
        self.refused(self.make("g", "nT", [self.ROWS[1], self.ROWS[0]]), "md_m = 100.0: must be greater", options=["--readings"])


    def test_without_a_header(self):
        text = "49.999,-0.25,0.01,0.95,-8057,802,60512\n70.5,-0.20,-0.012,0.96,5685,-5197,60163\n"
        self.gives(text, "md_m,gx_mg,gy_mg,gz_mg,bx_nT,by_nT,bz_nT\n49.999,-250,10,950,-8057,802,60512\n70.5,-200,-12,960,5685,-5197,60163\n",
                   "--readings", "--columns", "md=1,gx=2,gy=3,gz=4,bx=5,by=6,bz=7", "--depth-unit", "m", "--gravity-unit", "g", "--field-unit", "nT",
                   says=["no header, rows from line 1"])


class Json(Case):
    SHOTS = '{"mag": [[-17.25, -2.050, 47.025], [-17.425, 40.7375, 4.9875]], "grav": [[1.38, 0.05, -9.55], [-9.72, 0.13, -0.13]]}'
    HEAD = "md_m,gx_mps2,gy_mps2,gz_mps2,bx_uT,by_uT,bz_uT\n"
    OPTIONS = ["--readings", "--gravity-unit", "mps2", "--field-unit", "uT", "--depth-step", "0.5"]

    def test_shots(self):
        said = self.gives(self.SHOTS, self.HEAD + "0.5,1.38,0.05,-9.55,-17.25,-2.050,47.025\n1.0,-9.72,0.13,-0.13,-17.425,40.7375,4.9875\n", *self.OPTIONS,
                          says=["JSON", "header: grav, mag"])
        self.assertIn("warning: in.csv: has no measured depth: made up, 0.5 m from shot to shot", said)

    def test_axes(self):
        self.gives(self.SHOTS, self.HEAD + "0.5,-0.05,-1.38,-9.55,-17.25,-2.050,-47.025\n1.0,-0.13,9.72,-0.13,-17.425,40.7375,-4.9875\n", *self.OPTIONS,
                   "--axes", "g=-y-x+z,b=+x+y-z", says=["accelerometers x, y, z are -y, -x, +z of the file"])
        for wrong in "g=-y-y+z", "g=xyz", "a=+x+y+z":
            with self.assertRaises(Problem) as caught:
                import_survey.arguments(["in.csv", *self.OPTIONS, "--axes", wrong])
            self.assertIn("three axes with signs", str(caught.exception))

    def test_flat_lists_that_are_longer_than_their_shots(self):
        content = '{"shots": {"mag": [6.5, -72, -94, NaN], "grav": [-6.2, -0.3, -7.7, NaN]}, "axes": {"mag": [4, 0, 2], "accel": [3, 4, 5]}}'
        self.refused(content, "2 lists are accelerometers (shots.grav, axes.accel): must be one", "--columns g=NAME", options=self.OPTIONS)
        self.gives(content, self.HEAD + "0.5,-6.2,-0.3,-7.7,6.5,-72,-94\n", *self.OPTIONS, "--columns", "g=shots.grav,b=shots.mag")
        self.refused(content, "--columns: g=grav: must be one of shots.mag, shots.grav", options=[*self.OPTIONS, "--columns", "g=grav,b=shots.mag"], code=64)
        self.refused(content.replace("-94, NaN", "-94, 1"), "shots.mag: 4 numbers: must be three a shot", options=[*self.OPTIONS, "--columns", "g=shots.grav,b=shots.mag"])

    def test_refused(self):
        self.refused(self.SHOTS, "no measured depth", "--depth-step METRES", options=self.OPTIONS[:-2])
        self.refused(self.SHOTS.replace("-2.050", "NaN"), "shot 1: by has no value", "--skip-lines 1", options=self.OPTIONS)
        self.refused(self.SHOTS.replace("-2.050", "1e999"), "mag: shot 1 = '1e999': must be a number", options=self.OPTIONS)
        self.refused(self.SHOTS.replace(", [-9.72, 0.13, -0.13]", ""), "grav has 1 shots, mag 2: must be as many", options=self.OPTIONS)
        self.refused(self.SHOTS[:-3], "line 1", "must be JSON from here on", options=self.OPTIONS)
        self.refused(self.SHOTS.replace("grav", "shake"), "no list is named as accelerometers", "--columns g=NAME", options=self.OPTIONS)
        self.refused("[" * 100_000 + "1", "in.csv", options=self.OPTIONS)
        self.refused(Readings().make("g", "nT"), "--depth-step: is for JSON", options=["--readings", "--depth-step", "1"], code=64)


class Checks(Case):
    def rows(self, *rows):
        return table(rows=[tuple(map(str, r)) for r in rows])

    def test_depths(self):
        self.refused(self.rows((100, 1, 1), (130, 2, 9), (130, 2, 9)), "in.csv:line 4: md_m = 130: must be greater", "stands twice", "--skip-lines 4")
        self.refused(self.rows((100, 1, 1), (90, 2, 9), (120, 2, 9)), "in.csv:line 3: md_m = 90: must be greater")
        self.refused(self.rows((100, 1, 1), (130, 2, 9), (1600, 2, 9), (190, 3, 9)), "in.csv:line 4: md_m = 1600: must be between its neighbours", "jumps out and back")
        self.refused(self.rows((-1, 1, 1), (130, 2, 9)), "must not be negative")
        self.refused(self.rows((1, 1, 1), (30000, 2, 9)), "at most 20000 m", "--accept-depths")
        last = [(100 + 30 * i, i, 9) for i in range(8)] + [(3400, 8, 9)]
        self.assertIn("warning: in.csv:line 10: md_m = 3400: 3090 after", self.run_on(self.rows(*last))[1])

    def test_angles(self):
        self.refused(self.rows((100, 1, 1), (130, 181, 9)), "in.csv:line 3: inclination_deg = 181: must be in [0, 180]")
        self.refused(self.rows((100, -1, 1), (130, 1, 9)), "inclination_deg = -1")
        self.refused(self.rows((100, 1, 1), (130, 2, 361)), "azimuth_deg = 361: must be in [0, 360]")
        self.refused(self.rows((100, 1, 1), (130, 2, -9)), "plus 360")
        self.gives(self.rows((100, 0, 0), (130, 180, 360)), "md_m,inclination_deg,azimuth_deg\n100,0,0\n130,180,360\n", "--accept-doglegs")

    def test_radians(self):
        rows = [("100", "0.5", "1.5"), ("130", "0.6", "1.6")]
        open_units = table(head=("MD (m)", "Inc", "Azi Grid"), rows=rows)
        self.refused(open_units, "may be radians", "--angle-unit deg|rad|gon")
        self.gives(open_units, "md_m,inclination_deg,azimuth_deg\n100,0.5,1.5\n130,0.6,1.6\n", "--angle-unit", "deg")
        code, said, written = self.run_on(open_units, "--angle-unit", "rad", "--accept-doglegs")
        self.assertEqual(code, 0, said)
        self.assertEqual(written.splitlines()[1], "100,28.64788975654116,85.943669269623481")
        self.assertIn("are they radians?", self.run_on(table(rows=rows))[1])
        self.gives(table(head=("MD (m)", "Inc (gon)", "Azi Grid (gon)"), rows=[("1", "10", "100"), ("31", "10", "100")]),
                   "md_m,inclination_deg,azimuth_deg\n1,9.0,90.0\n31,9.0,90.0\n")

    def test_doglegs(self):
        code, said, _ = self.run_on(self.rows((100, 30, 10), (130, 30, 190)))
        self.assertEqual(code, 0)
        self.assertIn("warning: in.csv:line 2 to line 3: dogleg 60 deg/30 m", said)
        self.refused(self.rows((100, 90, 10), (160, 90, 190)), "line 2 to line 3", "turns by 180 deg", "--accept-doglegs")
        self.refused(self.rows((100, 10, 10), (105, 50, 10)), "turns by 40 deg over 5 m")
        self.assertEqual(self.run_on(self.rows((100, 10, 10), (105, 50, 10)), "--accept-doglegs")[0], 0)
        self.assertNotIn("warning", self.run_on(self.rows((100, 1, 10), (130, 30.9, 10)))[1])

    def test_half_rows(self):
        self.refused(self.rows((100, 1, 1), (130, "x", 9), (160, 1, 1)), "in.csv:line 3: Incl (deg) = 'x': must be a number", "--skip-lines 3")
        self.refused(self.rows((100, 1, 1), (130, "", 9), (160, 1, 1)), "in.csv:line 3: Incl (deg) is empty")
        for mark in "*", "m", " deg", "?":  # a station with marks is no note
            self.refused(self.rows((100, 1, 1), *[[f"{x}{mark}" for x in (130, 2, 9)]], (160, 1, 1)), f"in.csv:line 3: MD (m) = '130{mark}': must be a number")
        self.gives(self.rows((100, 1, 11)) + "Page 2,x,y\n130,2,12\n", "md_m,inclination_deg,azimuth_deg\n100,1,11\n130,2,12\n")
        self.refused(table() + "1090,1", "in.csv:line 5", "is empty")
        self.refused(self.rows((100, 1, 1)), "1 station: must be at least 2")
        self.gives(table() + "1090,1", METRES, "--skip-lines", "5", says=["left out         lines 5"])


class Files(Case):
    def test_bad_files(self):
        self.refused("", "in.csv: is empty")
        self.refused("\n \r\n", "is empty")
        self.refused(bytes(range(256)) * 4, "binary")
        self.refused(b"\x7fELF\x02\x01\x01" + bytes(200), "binary")
        self.refused("no survey\nat all\n", "no header")
        self.refused(b"\xff\xfe\x41", "utf-16")
        self.refused(table() + "x" * 30000, "in.csv:line 5: 30000 characters: must be at most 20000")
        self.refused("1,2,3\n" * 500_001, "500002 lines: must be at most 500000")
        for path in "/dev/zero", "missing.csv", ".":
            with self.assertRaises(Problem) as caught:
                import_survey.run(import_survey.arguments([path]))
            self.assertEqual(caught.exception.code, 74)
        os.mkfifo("pipe")
        with self.assertRaisesRegex(Problem, "must be a regular file"):
            import_survey.run(import_survey.arguments(["pipe"]))
        with open("large.csv", "wb") as file:
            file.truncate(output.MOST_BYTES + 1)
        with self.assertRaisesRegex(Problem, "at most 64 MiB"):
            import_survey.run(import_survey.arguments(["large.csv"]))

    def test_damaged_files_end_in_a_message_or_a_survey(self):
        chance = random.Random(17)
        forms = [table(), REPORT, LAS, document(witsml()), table(";"), table(" ", ("MD_m", "Inc", "AziG"))]
        ends = set()
        for k in range(240):
            data = bytearray(forms[k % len(forms)].encode())
            for _ in range(chance.randint(1, 6)):
                at = chance.randrange(len(data))
                what = chance.choice(["byte", "cut", "double", "drop"])
                if what == "byte":
                    data[at] = chance.choice(b"0,;.\t \"-<>&~[(\xff\x00eE\n")
                elif what == "cut" and at > 20:
                    del data[at:]
                elif what == "double":
                    data[at:at] = data[at:at + chance.randint(1, 60)]
                else:
                    del data[at:at + chance.randint(1, 20)]
                data = data or bytearray(b"x")
            code, said, written = self.run_on(bytes(data), *(["--azimuth-reference", "grid"] if k % 2 else []))
            self.assertIn(code, (0, 65), (bytes(data), said))
            self.assertEqual(written is None, code == 65)
            ends.add(code)
        self.assertEqual(ends, {0, 65})

    def test_no_file_is_touched(self):
        (self.folder / "in.csv").write_text(table())
        (self.folder / "mine.csv").write_text("mine")
        cases = [(["in.csv", "-o", "mine.csv"], 74), (["in.csv", "-o", "in.csv", "--overwrite"], 64), (["in.csv", "-o", "no/such.csv"], 74),
                 (["in.csv", "-o", "/dev/null", "--overwrite"], 74), (["in.csv", "-o", "mine.csv", "--overwrite", "--depth-unit", "ft"], 65)]
        for given, code in cases:
            with self.assertRaises(Problem) as caught:
                import_survey.run(import_survey.arguments(given))
            self.assertEqual(caught.exception.code, code, str(caught.exception))
        self.assertEqual((self.folder / "mine.csv").read_text(), "mine")
        self.assertEqual((self.folder / "in.csv").read_text(), table())
        with contextlib.redirect_stdout(io.StringIO()):
            import_survey.run(import_survey.arguments(["in.csv", "-o", "mine.csv", "--overwrite"]))
        self.assertEqual((self.folder / "mine.csv").read_text(), METRES)

    def test_as_a_program(self):
        (self.folder / "in.csv").write_text(table())
        run = lambda *given: subprocess.run([sys.executable, PACKAGE, "import", *given], capture_output=True, text=True, timeout=60)
        done = run("in.csv", "-o", "out.csv")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertTrue(done.stdout.endswith('In the config beside it:\n  [survey]\n  file = "out.csv"\n  azimuth_reference = "grid"\n'))
        self.assertEqual(run("in.csv", "-o", "out.csv").returncode, 74)
        done = run("in.csv", "--azimuth-referense", "grid")
        self.assertEqual((done.returncode, done.stdout), (64, ""))
        self.assertIn("did you mean --azimuth-reference?", done.stderr)
        self.assertEqual(run().returncode, 64)
        self.assertEqual(run("in.csv", "--depth-unit", "km").returncode, 64)
        self.assertEqual(run("in.csv", "--skip-lines", "x").returncode, 64)

    def test_the_program_reads_what_is_written(self):
        if not PROGRAM:
            self.skipTest("no program was named")
        said = self.gives(table(rows=[("1000", "02.50", "+45."), ("1030", ".5e1", "046"), ("1060", "7", "46")]),
                          "md_m,inclination_deg,azimuth_deg\n1000,02.50,45.\n1030,.5e1,046\n1060,7,46\n")
        survey = said.split("In the config beside it:\n")[1]
        (self.folder / "c.toml").write_text('experiment = "position_covariance"\nseed = 1\n' + survey +
                                            '[field]\ntotal_nT = 50000.0\ndip_deg = 70.0\ndeclination_deg = 2.0\nconvergence_deg = -1.0\n'
                                            '[error_model]\nname = "iscwsa_mwd_rev5.10"\n')
        done = subprocess.run([PROGRAM, "check", "c.toml"], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)


if __name__ == "__main__":
    if len(sys.argv) > 1 and os.path.exists(sys.argv[1]):
        PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
