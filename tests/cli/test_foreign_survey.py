#!/usr/bin/python3
"""Surveys and readings in the forms of other programs, run directly: test_foreign_survey.py SURVEYMC SOURCE_FOLDER

Each form holds the same well. A run of it must give the very covariances that the CSV of surveymc's own form gives, say what
was read, and run again from the result alone.
"""
import contextlib
import importlib.util
import io
import os
import re
import shutil
import signal
import subprocess
import sys
import time
import unittest
from pathlib import Path

import h5py
import numpy as np

import test_cli
from test_cli import BAD_INPUT, Case, column, contents, stored_config

STATIONS = [("1000.10", "2.50", "45.00"), ("1030.0", "4.8", "46.25"), ("1060.55", "7.125", "46.5"), ("1090.5", "9", "48.25")]
OWN = "md_m,inclination_deg,azimuth_deg\n" + "".join(",".join(s) + "\n" for s in STATIONS)
CONFIG = """\
experiment = "position_covariance"
error_model = "iscwsa_mwd_rev5.10"
[survey]
file = "FILE"
[field]
total_nT = 50000.0
dip_deg = 72.0
declination_deg = -4.0
convergence_deg = 2.0
"""
COMMA = [tuple(c.replace(".", ",") for c in s) for s in STATIONS]
PATIENCE = 20  # s


def table(separator, head, rows=STATIONS):
    return "".join(separator.join(r) + "\n" for r in [head, *rows])


REPORT = """\
                             Example Drilling
Company:    Example AS                     North Reference:      Grid

   Measured                              Vertical        Dogleg
    Depth    Inclination   Azimuth        Depth           Rate
      (m)        (°)         (°)           (m)         (°/30m)

   1,000.10       2.50        45.00     1,000.00        0.00
   1,030.0        4.8         46.25     1,029.00        2.31
                 KOP
   1,060.55       7.125       46.5      1,059.00        2.29
   1,090.5        9           48.25     1,089.00        1.93

  22 November                            Page 2                        Example 5.0
"""
LAS = """\
~VERSION INFORMATION
 VERS.   2.0 : CWLS LOG ASCII STANDARD
 WRAP.   NO  : ONE LINE A DEPTH
~Well
 NULL.   -999.25 : NULL VALUE
~Curve
 DEPT.M        : Measured depth
 DEVI.DEG      : Deviation
 HAZI.DEG      : Hole azimuth, grid north
~A
""" + "".join(" " + " ".join(s) + "\n" for s in STATIONS)


def witsml(new):
    trajectory, station, md, incl, azi = (("Trajectory", "TrajectoryStation", "Md", "Incl", "Azi") if new else
                                          ("trajectory", "trajectoryStation", "md", "incl", "azi"))
    rows = "".join(f'<{station} uid="{i}"><{md} uom="m">{s[0]}</{md}><{incl} uom="dega">{s[1]}</{incl}><{azi} uom="dega">{s[2]}</{azi}>'
                   f"</{station}>\n" for i, s in enumerate(STATIONS))
    if new:
        return (f'<Trajectory uuid="t" schemaVersion="2.0" xmlns="http://www.energistics.org/energyml/data/witsmlv2">'
                f"<Citation><Title>A</Title></Citation><AziRef>grid north</AziRef>\n{rows}</Trajectory>\n")
    return ('<?xml version="1.0" encoding="UTF-8"?>\n<trajectorys xmlns="http://www.witsml.org/schemas/1series" version="1.4.1.1">\n'
            f'<trajectory uid="t"><name>A</name><aziRef>grid north</aziRef>\n{rows}</trajectory></trajectorys>\n')


def workbook():
    import openpyxl
    book = openpyxl.Workbook()
    for row in [["A survey"], [], ["MD", "Incl", "Azimuth Grid", "TVD"], ["(m)", "(deg)", "(deg)", "(m)"],
                *[[*map(float, s), 1] for s in STATIONS], ["end"]]:
        book.active.append(row)
    held = io.BytesIO()
    book.save(held)
    return held.getvalue()


# name: (content, --set options, what is said of it)
FORMS = {
    "usual headings.csv": (table(",", ("Measured Depth (m)", "INC", "AZIMUTH GRID (deg)")), [], "comma-separated text"),
    "-s.txt": (table(",", ("Measured Depth (m)", "INC", "AZIMUTH GRID (deg)")), [], "comma-separated text"),
    "titles units notes.csv": ("Survey of a well\nNorth Reference:,Grid\n\nMD,TVD,Incl,Azim,Comment\n(m),(m),(deg),(deg),\n"
                               + "".join(f"{m},1,{i},{a},x\n" for m, i, a in STATIONS) + "End of survey\n", [], "ignored TVD"),
    "decimal commas.txt": (table(";", ("MD (m)", "Incl.", "Azi (GN)"), COMMA), [], "decimal comma"),
    "thousands.tsv": (table("\t", ("MD [m]", "DEVI", "HAZI grid"), [(m[0] + "," + m[1:], i, a) for m, i, a in STATIONS]), [], "tab-separated"),
    "unicode text.txt": (table("\t", ("MD [m]", "Incl (°)", "Azi Grid (°)")).encode("utf-16"), [], "UTF-16"),
    "no units.csv": (table(",", ("md", "inc", "azi")), ["survey.depth_unit=m", 'survey.azimuth_reference="grid"'], "md_m from column 1 'md', m"),
    "no header.txt": (table("|", STATIONS[0], STATIONS[1:]), ['survey.columns="md=1,inc=2,azi=3"', "survey.depth_unit=m",
                                                            'survey.azimuth_reference="grid"'], "bar-separated"),
    "report.txt": (REPORT, [], "fixed-width text"),
    "log.las": (LAS, [], "LAS 2.0"),
    "witsml 1.xml": (witsml(False), [], "WITSML 1.4.1.1 trajectory 'A'"),
    "witsml 2.xml": (witsml(True), [], "WITSML 2.0 trajectory 'A'"),
    "book.xlsx": (workbook, [], "Excel"),
}
NEEDS = {"witsml 1.xml": "lxml", "witsml 2.xml": "lxml", "book.xlsx": "openpyxl"}


class Forms(Case):
    def setUp(self):
        super().setUp()
        self.write("own.csv", OWN)
        self.write("base.toml", CONFIG.replace("FILE", "own.csv"))

    def covariance(self, *options, output="out.h5"):
        path = self.run_config(*[f"--set={o}" for o in options], output=output)
        return path, np.array([column(path, "tables/covariance", c) for c in ("md_m", "nn_m2", "ee_m2", "vv_m2", "ne_m2")])

    def test_every_form_gives_what_its_own_csv_gives(self):
        _, wanted = self.covariance('survey.azimuth_reference="grid"', output="own.h5")
        self.assertGreater(wanted[1:, -1].min(), -1)
        for name, (content, options, says) in FORMS.items():
            if name in NEEDS and not importlib.util.find_spec(NEEDS[name]):
                continue
            with self.subTest(form=name):
                self.write(name, content() if callable(content) else content)
                checked = self.call("check", "base.toml", "--set", f'survey.file="{name}"', *[f"--set={o}" for o in options]).stdout
                self.assertIn(f"# {name} read as ", checked)
                self.assertIn(says, checked.replace("Bar", "bar"))
                self.assertIn(f"# survey {name}: 4 stations, measured depth 1000.1 to 1090.5 m", checked)
                self.assertIn("azimuths from grid north", checked)
                path, found = self.covariance(f'survey.file="{name}"', *options)
                np.testing.assert_array_equal(found, wanted)
                self.assertIn(name, self.stored_inputs(path))
                (self.folder / name).unlink()
                self.assertIn("identical: ", self.call("rerun", "out.h5").stdout)

    def stored_inputs(self, path):
        with h5py.File(path) as file:
            return [str(g.attrs.get("path", name)) for name, g in file["inputs"].items()]

    def test_what_is_ambiguous_is_asked_for_by_key(self):
        plain = table(",", ("md", "inc", "azi"))
        for content, options, says in [
                (plain, [], r"mine\.txt:line 1: column 'md': no unit: must be known: survey\.depth_unit = \"m\", \"ft\" or \"usft\"; or make a CSV of it: "
                            r"surveymc import mine\.txt -o survey\.csv"),
                (plain, ["survey.depth_unit=m"], r"mine\.txt: .*which north.*survey\.azimuth_reference"),
                (table(",", ("MD (m)", "Inc", "Azi Grid")), ['survey.azimuth_reference="true"'], "says grid north, survey.azimuth_reference says true"),
                (table(";", ("MD (m)", "Inc", "Azi Grid"), [("1,234", "10", "20"), ("1,264", "12", "21")]), [], r'survey\.decimal = "comma" or survey\.decimal = "point"'),
                (table(",", ("MD (m)", "Inc", "Azi Grid"), [("1", "0.5", "1.5"), ("9", "0.6", "1.6")]), [], r'survey\.angle_unit = "deg", "rad" or "gon"; or'),
                ("1,2,3\n4,5,6\n", [], r'no header.*survey\.columns = "md=NUMBER,inc=NUMBER,azi=NUMBER"; or'),
                (table(",", ("MD (m)", "Inc", "Azi Grid"), [("1", "20", "30"), ("9", "x", "30")]), [], r'survey\.skip_lines = "3"; or'),
                (table(",", ("MD (m)", "Inc", "Azi Grid")), ["survey.sheet=x"], r"survey\.sheet: is for Excel"),
                (table(",", ("MD (m)", "Inc", "Azi Grid")), ["survey.depth_unit=ft"], "heading says m, survey.depth_unit says ft"),
                (table(",", ("MD (m)", "Inc", "Azi Grid")), ["survey.depth_unit=km"], r'survey\.depth_unit = "km": must be one of'),
                (table(",", ("MD (m)", "Inc", "Azi Grid"), [*STATIONS, ("1080", "9", "48")]), [], r"mine\.txt:6: md_m = 1080: must be greater"),
                (table(",", ("MD (m)", "Inc", "Azi Grid"), [*STATIONS, ("1120", "90", "228")]), ["survey.depth_units=m"], "did you mean survey.depth_unit"),
                (table(",", ("MD (m)", "Inc", "Azi Grid"), [*STATIONS, ("1120", "9", "408")]), [], r"mine\.txt:6: azimuth_grid_deg = 408: must be in \[0, 360\]"),
        ]:
            with self.subTest(says=says):
                self.write("mine.txt", content)
                self.refused(BAD_INPUT, "run", "base.toml", "-o", "bad.h5", "--set", "survey.file=mine.txt", *[f"--set={o}" for o in options], says=says)
        self.write("-my well.txt", plain)
        self.refused(BAD_INPUT, "check", "base.toml", "--set", 'survey.file="-my well.txt"', says=r"surveymc import '\./-my well\.txt' -o survey\.csv")
        self.refused(BAD_INPUT, "run", "base.toml", "-o", "bad.h5", "--set", "survey.depth_unit=m", says="own.csv: .*must be without survey.depth_unit")

    def test_what_is_doubtful_is_refused_until_it_is_allowed(self):
        head = ("MD (m)", "Inc", "Azi Grid", "TVD (m)", "QC")
        for column, rows, says in [(4, ["PASS", "FAIL"], r"column 5 'QC' = 'FAIL'.*survey.skip_lines = \"3\""),
                                   (3, ["1000", "1500"], r"'TVD \(m\)' = 1500: 500 m from the row before, where the angles give")]:
            cells = [[*s, "", ""] for s in STATIONS]
            for row, cell in zip(cells, rows):
                row[column] = cell
            self.write("mine.txt", table(",", head, cells))
            self.refused(BAD_INPUT, "check", "base.toml", "--set", "survey.file=mine.txt", says=says + r'.*if the file is meant so: survey.unusual = "allow"')
            allowed = self.call("check", "base.toml", "--set", "survey.file=mine.txt", "--set", "survey.unusual=allow").stdout
            self.assertRegex(allowed, rf"(?m)^# warning: mine\.txt:.*{says}")
        self.run_config("--set", "survey.file=mine.txt", "--set", "survey.unusual=allow")
        (self.folder / "mine.txt").unlink()
        self.assertIn("identical: ", self.call("rerun", "out.h5").stdout)

    @unittest.skipUnless(importlib.util.find_spec("openpyxl"), "no openpyxl")
    def test_a_sheet_is_asked_for_by_key(self):
        import openpyxl
        book = openpyxl.load_workbook(io.BytesIO(workbook()))
        book.create_sheet("Notes").append(["a note"])
        book.save(self.folder / "book.xlsx")
        self.refused(BAD_INPUT, "run", "base.toml", "-o", "bad.h5", "--set", "survey.file=book.xlsx",
                     says=r"""book\.xlsx: 2 sheets .* one must be meant: survey\.sheet = "NAME"; or""")

    def test_a_signal_leaves_no_reader_behind(self):
        name = f"long{os.getpid()}.txt"
        self.write(name, "MD (m);Inc;Azi Grid\n" + "".join(f"{i / 100};1.0;2.0\n" for i in range(100_000)))

        def readers():
            for place in Path("/proc").glob("[0-9]*/cmdline"):
                with contextlib.suppress(OSError):  # it has ended
                    if name in (words := place.read_text(errors="replace")) and "scripts/surveymc\0import\0" in words:
                        yield int(place.parent.name)

        def wait(until):
            end = time.monotonic() + PATIENCE
            while not until() and time.monotonic() < end:
                time.sleep(0.01)

        for number in (signal.SIGTERM, signal.SIGKILL):
            child = subprocess.Popen([test_cli.EXECUTABLE, "check", "base.toml", "--set", f"survey.file={name}"], cwd=self.folder,
                                     stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            wait(lambda: any(readers()) or child.poll() is not None)
            reader, = readers()
            status = Path(f"/proc/{reader}/status")
            wait(lambda: int(re.search(r"VmHWM:\s+(\d+)", status.read_text())[1]) > 60_000)  # kB: it has begun to read
            os.kill(reader, signal.SIGSTOP)  # by itself it does not end
            self.addCleanup(lambda pid=reader: pid in readers() and os.kill(pid, signal.SIGKILL))
            child.send_signal(number)
            self.assertEqual(child.wait(), -number)
            wait(lambda: not list(readers()))
            self.assertEqual(list(readers()), [])

    def test_one_file_is_not_read_in_two_ways(self):
        self.write("mine.txt", table(",", ("md", "inc", "azi grid")))
        self.refused(BAD_INPUT, "run", "base.toml", "-o", "bad.h5", "--set", "survey.file=mine.txt", "--set", 'sweep.survey.depth_unit=["m", "ft"]',
                     says=r'survey\.file = "mine\.txt": is read in two ways \(depth-unit m; depth-unit ft\)')

    def test_a_north_in_the_column_of_our_own_form(self):
        _, wanted = self.covariance('survey.azimuth_reference="grid"', output="own.h5")
        self.write("named.csv", OWN.replace("azimuth_deg", "azimuth_grid_deg"))
        path, found = self.covariance("survey.file=named.csv")
        np.testing.assert_array_equal(found, wanted)
        self.assertEqual(stored_config(path)["survey"]["azimuth_reference"], "grid")
        self.refused(BAD_INPUT, "run", "base.toml", "-o", "bad.h5", "--set", "survey.file=named.csv", "--set", 'survey.azimuth_reference="true"',
                     says="named.csv says grid north: must agree")
        said = self.call("check", "base.toml", "--set", "survey.file=named.csv", "--set", "field.convergence_deg=0").stdout
        self.assertIn("# warning: named.csv: azimuths are from grid north, and the convergence is 0; if that is not meant, set field.convergence_deg or field.grid", said)

    def test_without_the_script_our_own_form_is_said(self):
        shutil.copy(test_cli.EXECUTABLE, self.folder / "alone")
        self.write("mine.txt", table(",", ("MD (m)", "Inc", "Azi Grid")))
        done = subprocess.run([self.folder / "alone", "check", "base.toml", "--set", "survey.file=mine.txt"], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(done.returncode, BAD_INPUT)
        self.assertRegex(done.stderr, r"mine\.txt: is no CSV of our own form \(md_m, .*what reads other forms is not there: .*scripts/surveymc is not beside ")


class Readings(Case):
    def test_readings_of_another_program(self):
        source = test_cli.SOURCE / "configs/examples"
        text = (source / "readings.csv").read_text()
        head = text.index("\nmd_m,") + 1
        own = text[head:].splitlines()
        self.assertEqual(own[0], "md_m,gx_mps2,gy_mps2,gz_mps2,bx_nT,by_nT,bz_nT")
        self.write("readings.csv", text)
        self.write("base.toml", (source / "readings.toml").read_text())
        wanted = contents(self.run_config(output="own.h5"))
        self.write("tool.txt", "\n".join(["Depth (m);Gx (m/s2);Gy (m/s2);Gz (m/s2);Bx (nT);By (nT);Bz (nT);Temp",
                                          *[line.replace(",", ";") + ";80" for line in own[1:]]]) + "\n")
        path = self.run_config("--set", "readings=tool.txt")
        found = contents(path)
        for name, values in wanted.items():
            if name.startswith("tables/") and "message" not in name:
                self.assertEqual(found[name], values, name)
        self.assertRegex(self.call("check", "base.toml", "--set", "readings=tool.txt").stdout, r"(?m)^# tool\.txt read as semicolon-separated text.*ignored Temp")
        (self.folder / "tool.txt").unlink()
        self.assertIn("identical: ", self.call("rerun", "out.h5").stdout)

    def test_readings_have_no_keys_and_are_asked_for_by_the_option_of_the_script(self):
        self.write("base.toml", (test_cli.SOURCE / "configs/examples/readings.toml").read_text())
        row = "1000;1.0;2.0;9.5;14000;-14000;46000\n"
        for head, says in [("MD;Gx (m/s2);Gy (m/s2);Gz (m/s2);Bx (nT);By (nT);Bz (nT)", r"--depth-unit m\|ft\|usft"),
                           ("MD (m);Gx;Gy;Gz;Bx (nT);By (nT);Bz (nT)", r"--gravity-unit g\|mg\|mps2"),
                           ("MD (m);Gx (m/s2);Gy (m/s2);Gz (m/s2);Bx;By;Bz", r"--field-unit nT\|uT\|gauss\|mgauss")]:
            with self.subTest(says=says):
                self.write("tool.txt", head + "\n" + row)
                self.refused(BAD_INPUT, "check", "base.toml", "--set", "readings=tool.txt",
                             says=rf"tool\.txt:line 1: .*no unit: must be known: {says}; make a CSV of it: surveymc import tool\.txt --readings -o")


if __name__ == "__main__":
    test_cli.EXECUTABLE, test_cli.SOURCE = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
