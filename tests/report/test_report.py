#!/usr/bin/python3
"""Tests of the pages that surveymc.report made of smoke results: test_report.py REPORT_FOLDER SMOKE_FOLDER"""
import contextlib
import html.parser
import importlib
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import types
import unittest
import unittest.mock
import urllib.parse
import xml.etree.ElementTree
from pathlib import Path

import h5py
import numpy as np

SCRIPTS = os.path.abspath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts"))
if SCRIPTS not in sys.path:  # in a spawned process the copy of plots_with stands before it
    sys.path.insert(0, SCRIPTS)
import surveymc  # noqa: E402
from surveymc import integrity, studies, view3d  # noqa: E402
from surveymc.plots import runner  # noqa: E402
from surveymc.report import explore, figures, headlines, page, pages, tables, templating, text  # noqa: E402
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from sealed import result_file  # noqa: E402

REPORT = SMOKE = ""
VOID = {"meta", "link", "img", "br", "hr", "input"}


class Page(html.parser.HTMLParser):
    """Tags, ids and links of a page; faults of its structure."""

    def __init__(self, source):
        super().__init__()
        self.stack, self.faults, self.ids, self.tags, self.words = [], [], [], [], []
        self.feed(source)
        self.close()
        self.faults += [f"<{t}> is never closed" for t in self.stack]

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        if len(attributes) != len(attrs):
            self.faults.append(f"<{tag}> has an attribute twice")
        if "id" in attributes:
            self.ids.append(attributes["id"])
        self.tags.append((tag, attributes))
        if tag not in VOID:
            self.stack.append(tag)

    def handle_endtag(self, tag):
        if not self.stack or self.stack.pop() != tag:
            self.faults.append(f"</{tag}> at {self.getpos()} closes nothing")

    def handle_data(self, data):
        self.words.append(data)

    def named(self, tag):
        return [a for t, a in self.tags if t == tag]


def make(*arguments, environment=None):
    return subprocess.run([sys.executable, os.path.join(SCRIPTS, "surveymc"), "report", *arguments], capture_output=True, text=True,
                          timeout=120, env={**os.environ, **(environment or {})})


def read(folder):
    """{name: text} of the pages in a folder."""
    return {name: Path(folder, name).read_text(encoding="utf-8") for name in sorted(os.listdir(folder)) if name.endswith(".html")}


RESULTS = {"estimate": "estimate", "msa_benefit": "msa_benefit", "msa_sweep": "msa_position", "mwd_drift": "mwd_drift",
           "reliability_map": "reliability_map", "sensor_monte_carlo": "sensor_monte_carlo", "vertical_well": "vertical_well",
           "clearance": "clearance"}  # their files, and the pages that they are on


class Structure(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.sources = read(REPORT)
        cls.pages = {name: Page(source) for name, source in cls.sources.items()}

    def test_a_front_page_one_for_each_study_and_one_for_paper(self):
        self.assertEqual(set(self.sources), {"index.html", "paper.html", *(f"{p}.html" for p in RESULTS.values())})
        for name, source in self.sources.items():
            if name != "paper.html":
                self.assertLess(len(source.encode()), 3e6, name)

    def test_they_are_well_formed(self):
        for name, parsed in self.pages.items():
            self.assertEqual(parsed.faults, [], name)
            self.assertTrue(self.sources[name].startswith("<!DOCTYPE html>"), name)
            self.assertEqual(parsed.named("html")[0]["lang"], "en")
            levels = [int(t[1]) for t, _ in parsed.tags if re.fullmatch(r"h[1-6]", t)]
            self.assertEqual(levels[0], 1)
            self.assertTrue(name == "paper.html" or levels.count(1) == 1, name)
            self.assertTrue(all(b <= a + 1 for a, b in zip(levels, levels[1:])), f"{name}: a level of headings is left out")

    def test_ids_are_unique_and_links_lead_somewhere(self):
        for name, parsed in self.pages.items():
            self.assertEqual(len(parsed.ids), len(set(parsed.ids)))
            links = [a["href"] for a in parsed.named("a")]
            self.assertGreater(len(links), 10 if name == "index.html" else 0)
            for link in links:
                file, _, target = link.partition("#")
                self.assertIn(file or name, self.pages, link)
                self.assertTrue(not target or target in self.pages[file or name].ids, link)
            for _, attributes in parsed.tags:
                for key in ("aria-labelledby", "for", "data-source"):
                    if key in attributes:
                        self.assertIn(attributes[key], parsed.ids)

    def test_they_load_nothing(self):
        for name, parsed in self.pages.items():
            for tag, attributes in parsed.tags:
                self.assertFalse(tag in ("iframe", "object", "embed", "base", "form"), tag)
                for key in ("src", "href", "srcset", "action", "data", "poster"):
                    if key in attributes:
                        self.assertRegex(attributes[key], r"^(#|data:|[a-z0-9_-]+\.html(#|$))", tag)
                self.assertFalse([a for a in attributes if a.startswith("on")])
            styles = re.findall(r"<style>(.*?)</style>", self.sources[name], re.S)
            self.assertEqual([w for s in styles for w in re.findall(r"@import|url\(.{0,40}", s)], [])
            scripts = re.findall(r"<script>(.*?)</script>", self.sources[name], re.S)
            ours = [s for s in scripts if "THREE.REVISION" not in s and "exports.REVISION" not in s]  # the library has a loader, unused
            self.assertEqual(len(scripts) - len(ours), 1 if name in ("estimate.html", "clearance.html") and view3d.is_installed() else 0, name)
            self.assertEqual([w for s in ours for w in re.findall(r"fetch\(|XMLHttpRequest|import\(|https?://(?!www.w3.org/2000/svg).{0,40}", s)], [])
            policy = next(a["content"] for a in parsed.named("meta") if a.get("http-equiv") == "Content-Security-Policy")
            self.assertIn("default-src 'none'", policy)

    def test_every_figure_that_was_drawn_is_there_whole(self):
        drawn = [os.path.join(folder, f) for folder, _, names in os.walk(os.path.join(REPORT, "figures"))
                 for f in names if f.endswith(".svg") and not re.search(r"\.\d+\.svg$", f)]  # which were kept
        self.assertGreater(len(drawn), 8)
        pictures = [i for name, parsed in self.pages.items() if name not in ("index.html", "paper.html") for i in parsed.named("img")]
        self.assertEqual(len(pictures), len(drawn))
        self.assertEqual(len(self.pages["paper.html"].named("img")), len(RESULTS))  # the first of each result
        for picture in pictures:
            self.assertTrue(picture["alt"])
            self.assertEqual(picture["src"][:5], "data:")
            if picture["src"].startswith("data:image/svg+xml,"):
                root = xml.etree.ElementTree.fromstring(urllib.parse.unquote(picture["src"].split(",", 1)[1]))
                width = float(root.get("viewBox").split()[2])
                self.assertAlmostEqual(int(picture["width"]), width * 96 / 72, delta=1)
                ids = [e.get("id") for e in root.iter() if e.get("id")]
                self.assertEqual(len(ids), len(set(ids)))
                for e in root.iter():
                    for key, value in e.attrib.items():
                        if key.endswith("href"):
                            self.assertRegex(value, r"^(#|data:)")

    def test_each_result_says_what_it_is_and_how_it_came_out(self):
        for name, on in RESULTS.items():
            result = surveymc.open(os.path.join(REPORT, "..", "results", name + ".h5"))
            part = re.search(rf'<article class="result" id="result-{name.replace("_", "-")}">(.*?)</article>', self.sources[f"{on}.html"], re.S)[1]
            self.assertTrue(text.escape(result.title) in part, name)
            for words in (result.content_hash, text.escape(result.config), f"<dt>seed</dt><dd>{result.seed}</dd>",
                          "build/surveymc rerun ", f"build/surveymc run configs/smoke/{name}.toml"):
                self.assertTrue(words in part, f"{name}: {words[:60]}")
            counts = result.verdicts
            if counts["agrees"]:
                self.assertTrue(f"{text.grouped(counts['agrees'])} agree" in part, name)
            for table, frame in result.tables.items():
                in_box = table in ("answer", "warnings")
                self.assertEqual(len(frame) > 0 and not in_box, f'aria-label="Table {table}"' in part, (name, table))
                for message in frame["message"] if table == "warnings" else []:
                    self.assertTrue(text.prose(message) in part, (name, message))

    def test_the_front_page_has_a_card_for_each_study(self):
        source = self.sources["index.html"]
        cards = re.findall(r'<li class="card">(.*?)</li>', source, re.S)
        self.assertEqual(len(cards), len(RESULTS))
        for card in cards:
            self.assertRegex(card, r'<a href="[a-z_]+\.html"><img src="data:image/png;base64,')
        self.assertEqual({re.search(r'href="(.*?)"', c)[1] for c in cards}, {f"{p}.html" for p in RESULTS.values()})
        result = surveymc.open(os.path.join(SMOKE, "vertical_well.h5"))
        self.assertTrue(text.escape(result.answer[0]) in next(c for c in cards if "vertical_well.html" in c))

    def test_what_runs_a_result_again_has_its_options(self):
        for command, options in (("surveymc run a.toml -o a.h5", ""), ("surveymc run a.toml --seed 77 -o a.h5", " --seed 77"),
                                 ("surveymc run a.toml --trials=50 --set verdict.margin=0.5 --set estimator.name=msa --quiet",
                                  " --trials 50 --set verdict.margin=0.5 --set estimator.name=msa"),
                                 ("surveymc run a.toml --set sensor.bias_nT=[250, -1.5, 0] -o a.h5", " --set 'sensor.bias_nT=[250, -1.5, 0]'"),
                                 ("surveymc run a.toml -o a.h5 --set 'sensor.bias_nT=[250, 0]'", " --set 'sensor.bias_nT=[250, 0]'"),
                                 ("surveymc run --set title=\"a b\" a.toml", " --set 'title=\"a b\"'")):
            self.assertEqual(page.own_numbers(command), options)
        result = surveymc.open(os.path.join(SMOKE, "vertical_well.h5"))
        result.command = "surveymc run configs/smoke/vertical_well.toml --seed 77 -o x.h5"
        part = page.result_part(result, studies.load()["vertical_well"], runner.Drawn(), "r", "x.h5", 1)
        html = templating.render(templating.environment(), "result.html", r=part, heading="h2", paper=False)
        self.assertIn("build/surveymc run configs/smoke/vertical_well.toml --seed 77\nbuild/surveymc rerun x.h5", html)
        self.assertIn("Run with other numbers than the config has", html)

    def test_verdicts_are_marks_with_words(self):
        cells = re.findall(r'<td class="v"><span class="verdict (\w+)"><i aria-hidden="true">(.)</i> ([^<]+)', "".join(self.sources.values()))
        self.assertEqual({(c, w) for c, _, w in cells} - {("agrees", "agrees"), ("differs", "differs"), ("undecided", "undecided"), ("undecided", "differs, may be chance"),
                                                          ("finding", "finding")}, set())
        self.assertGreaterEqual(len({m for _, m, _ in cells}), 3)


class FirstScreen(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.sources = read(REPORT)

    def test_findings_stand_first_and_lead_to_their_results(self):
        source = self.sources["index.html"]
        head = source[:source.index('id="studies"')]
        links = re.findall(r'<li><a href="([^"]*)">([^<]*)</a></li>', head[head.index('class="headlines"'):])
        self.assertEqual(len(links), headlines.MOST)
        self.assertEqual(links[0][0], "msa_position.html#result-msa-sweep")
        result = surveymc.open(os.path.join(SMOKE, "msa_sweep.h5"))
        self.assertEqual(html.unescape(links[0][1]), f"{result.title}: {result.answer[0]}")
        self.assertEqual(head.count("<img"), 1)

    def test_each_kind_of_study_has_a_sentence_and_none_breaks_the_page(self):
        for name in sorted(os.listdir(SMOKE)):
            if name.endswith(".h5"):
                result = surveymc.open(os.path.join(SMOKE, name))
                said = headlines.sentence(result, result.verdicts)
                self.assertEqual(said, said.strip())
                self.assertNotRegex(said, "<|nan|_m2", name)
                if sum(result.verdicts.values()):
                    self.assertTrue(said.endswith("."), name)
        found = [("a", headlines.Headline(5, "A.", "x")), ("a", headlines.Headline(2, "B.", "y")), ("b", headlines.Headline(3, "", "z")),
                 *((c, headlines.Headline(9, "C.", c)) for c in "cdef")]
        self.assertEqual([h.result for h in headlines.chosen(found)], ["y", "c", "d"])

    def test_a_result_begins_with_its_answer(self):
        for name in ("msa_sweep", "vertical_well", "reliability_map"):
            result = surveymc.open(os.path.join(REPORT, "..", "results", name + ".h5"))
            source = self.sources[f"{RESULTS[name]}.html"]
            start = source.index(f'id="result-{name.replace("_", "-")}"')
            part = html.unescape(source[start:source.index("</article>", start)])
            places = [part.index(sentence) for sentence in result.answer]
            self.assertTrue(2 <= len(places) and places == sorted(places), name)
            self.assertLess(places[-1], part.index("<table"))

    def test_says_how_many_rows_may_differ_by_chance(self):
        rows = {}
        for name in ("msa_sweep", "vertical_well", "sensor_monte_carlo", "mwd_drift"):
            result = surveymc.open(os.path.join(SMOKE, name + ".h5"))
            for table in result.tables.values():
                if "verdict" in table and "ratio" in table:
                    confidence = round(table.attrs["confidence"], 9)
                    rows[confidence] = rows.get(confidence, 0) + int((table["verdict"] != "").sum())
        words = page.chance({0.95: 1000})
        self.assertIn("1\u202f000 rows are judged by Monte-Carlo intervals at 95\N{NO-BREAK SPACE}%", words)
        self.assertIn("at most 25 may differ by chance", words)
        self.assertIn("a chance below 0.036 that even one differs", page.chance({0.99999: 7200}))
        said = re.search(r'id="chance">(.*?)</p>', self.sources["index.html"])[1]
        self.assertEqual(len(rows), 1)
        self.assertGreaterEqual(int(re.match(r"[\d\u202f]+", said)[0].replace("\u202f", "")), sum(rows.values()))

    def test_the_report_is_one_family(self):
        frame = surveymc.open(os.path.join(SMOKE, "msa_sweep.h5")).table("position")
        odd = frame[(frame["verdict"] == "differs") & (frame["expected"] != "differs") & (frame["family"] == "differs")]
        asked = frame[(frame["verdict"] == "differs") & (frame["expected"] == "differs")]
        chosen = odd if len(odd) else asked
        self.assertGreater(len(chosen), 0)
        one = chosen.copy()
        one.attrs, one["expected"], one["family"] = frame.attrs, "", "differs"
        p = float(one["p_differs"].max())
        for limit, kind in ((p, "differs"), (-1.0, "may be chance")):
            counts = tables.counts_of(page.judged_together(one, limit))
            self.assertEqual(counts[kind], len(one))
            self.assertEqual(sum(counts.values()), len(one))
        family = page.family_of([frame, surveymc.open(os.path.join(SMOKE, "msa_sweep.h5")).table("covariance_tests")])
        rates = page.error_rates(family)
        self.assertGreater(rates["tests"], 0)
        self.assertEqual(rates["verdicts"] + rates["tests"], len(family))
        whole = surveymc.open(os.path.join(SMOKE, "msa_sweep.h5"))  # the same p-values without the tables
        self.assertEqual(sorted(whole.family), sorted(d for _, d, _ in page.family_of(whole.table(t) for t in whole.tables)))

    def test_verdicts_are_the_last_column(self):
        frame = surveymc.open(os.path.join(SMOKE, "msa_sweep.h5")).table("position")
        self.assertEqual(tables.table(frame).heads[-1].style, "v")


class Numbers(unittest.TestCase):
    def test_digits_follow_the_interval(self):
        for numbers, expected in (((1.00234, 0.9912, 1.0135), ("1.002", "[0.991, 1.014]")),
                                  ((4831.2, 4700.0, 4960.0), ("4831", "[4700, 4960]")),
                                  ((-0.0231, -0.0432, -0.0031), ("−0.023", "[−0.043, −0.003]")),
                                  ((2.5, float("nan"), float("nan")), ("2.500", ""))):
            self.assertEqual(text.interval(*numbers), expected)
        self.assertEqual([text.number(v) for v in (float("inf"), float("nan"), 0.0, 1234.5678, 3e-9, 20000)],
                         ["∞", "–", "0", "1235", "3.000·10<sup>−9</sup>", "20\u202f000"])

    def test_large_maps_are_thinned_on_their_grid(self):
        class Map:
            maps = ["m"]

            def map(self, name):
                import xarray
                a = np.arange(0.0, 361.0)
                return xarray.DataArray(np.add.outer(a, 1000 * a)[None], dims=("case", "x", "y"), name=name,
                                        coords={"case": np.array(["one"], object), "x": a, "y": a})

        data = explore.maps(Map())
        sizes = [len(a["values"]) for a in data["axes"]]
        self.assertLessEqual(np.prod(sizes), explore.MAP_POINTS)
        self.assertGreater(np.prod(sizes), explore.MAP_POINTS / 5)
        self.assertEqual(data["axes"][1]["values"][-1], 360.0)
        import base64
        values = np.frombuffer(base64.b64decode(data["maps"][0]["data"]), "<f2").reshape(sizes).astype(float) * data["maps"][0]["scale"]
        exact = np.add.outer(np.array(data["axes"][1]["values"]), 1000 * np.array(data["axes"][2]["values"]))[None]
        np.testing.assert_allclose(values, exact, rtol=2.0**-11, atol=data["maps"][0]["scale"] * 2.0**-24)


class InSpace(unittest.TestCase):
    def ellipsoids(self, name):
        return surveymc.Result(os.path.join(SMOKE, f"{name}.h5")), view3d.wells(surveymc.Result(os.path.join(SMOKE, f"{name}.h5")))

    def test_semi_axes_give_the_covariance_back(self):
        random = np.random.default_rng(7)
        for rank in (1, 2, 3):
            roots = random.normal(size=(3, rank)) * 10.0 ** random.uniform(-3, 3, rank)
            covariance = roots @ roots.T
            axes = np.array(view3d.semi_axes(covariance))
            np.testing.assert_allclose(axes.T @ axes, covariance, atol=1e-12 * np.trace(covariance))  # sum of a a' over the axes
            self.assertTrue(np.all(np.diff(np.linalg.norm(axes, axis=1)) <= 1e-9 * np.sqrt(np.trace(covariance))))

    def test_ellipsoids_are_those_that_the_program_wrote(self):
        """Lengths and directions of the table `ellipsoid`, which is not what they are computed from."""
        result, found = self.ellipsoids("position_covariance")
        table, compared = result.table("ellipsoid"), 0
        for scene in found["scenes"][:1]:
            self.assertEqual([w["name"] for w in scene["wells"]], ["well"])
            keys = table.attrs["sweep_keys"]
            rows = table[(table[keys] == table[keys].iloc[0]).all(axis=1)] if keys else table
            for e in scene["ellipsoids"]:
                row = rows.iloc[(rows["md_m"] - e["md"]).abs().argmin()]
                np.testing.assert_allclose(e["centre"], row[["north_m", "east_m", "tvd_m"]].astype(float), atol=1e-3)
                for k, axis in enumerate(np.array(e["axes"]), 1):
                    self.assertAlmostEqual(np.linalg.norm(axis) / row["axis1_m"], row[f"axis{k}_m"] / row["axis1_m"], delta=2e-5)  # five digits
                    a, i = np.radians(row[f"axis{k}_azimuth_deg"]), np.radians(row[f"axis{k}_inclination_deg"])
                    apart = row["axis1_m"] > 1.01 * row["axis2_m"] > 1.0201 * row["axis3_m"]  # equal axes have no directions of their own
                    if apart and row[f"axis{k}_m"] > 1e-3 * row["axis1_m"]:
                        direction = [np.sin(i) * np.cos(a), np.sin(i) * np.sin(a), np.cos(i)]
                        self.assertAlmostEqual(abs(axis @ direction) / np.linalg.norm(axis), 1, delta=1e-3)
                        compared += 1
        self.assertGreater(compared, 3)

    def test_every_kind_of_well_has_its_place(self):
        for name, wells in (("estimate", {"corrected", "as read"}), ("clearance", {"reference", "winding", "sidetrack"}),
                            ("collision", {"reference", "winding", "sidetrack"})):
            result, found = self.ellipsoids(name)
            scene = found["scenes"][0]
            self.assertEqual({w["name"] for w in scene["wells"]}, wells, name)
            self.assertGreater(len(scene["ellipsoids"]), 0, name)
            for e in scene["ellipsoids"]:  # on the well that it is of
                own = scene["wells"][e["well"]]
                path = np.array([np.interp(e["md"], own["md"], own[k]) for k in ("north", "east", "down")])
                np.testing.assert_allclose(e["centre"], path, atol=1e-3, err_msg=name)
        self.assertIsNone(view3d.wells(surveymc.Result(os.path.join(SMOKE, "vertical_well.h5"))))
        self.assertIsNone(view3d.cylinder(surveymc.Result(os.path.join(SMOKE, "collision.h5"))))

    def test_the_cylinder_is_that_of_the_table(self):
        result = surveymc.Result(os.path.join(SMOKE, "clearance.h5"))
        table = result.table("clearance")
        for offset in view3d.cylinder(result)["scenes"][0]["offsets"]:
            for md, limit, distance, factor in zip(offset["md"], offset["limit"], offset["distance"], offset["factor"]):
                row = table[(table["offset"] == offset["name"]) & (table["direction"] == "reference") & (table["minimum"] == 1)
                            & ((table["ref_md_m"] - md).abs() < 1e-2)].iloc[0]
                self.assertAlmostEqual(distance, row["distance_m"], delta=1e-4 * max(1, distance))
                if factor and distance > 0:  # the factor says on which side of its limit the offset is
                    self.assertEqual(factor < 1, distance < limit, (offset["name"], md))


    def test_plot_writes_the_page(self):
        command = lambda name, folder: subprocess.run([sys.executable, os.path.join(SCRIPTS, "surveymc"), "plot", os.path.join(SMOKE, f"{name}.h5"),  # noqa: E731
                                                       "--3d", "-o", folder], capture_output=True, text=True, timeout=120)
        with tempfile.TemporaryDirectory() as folder:
            run = command("clearance", folder)
            if view3d.is_installed():
                self.assertEqual((run.returncode, run.stdout), (0, os.path.join(folder, "clearance_3d.html\n")), run.stderr)
                source = Path(folder, "clearance_3d.html").read_text(encoding="utf-8")
                self.assertEqual(Page(source).faults, [])
                self.assertLess(len(source.encode()), 3e6)
                self.assertIn("The MIT License", source)
            run = command("vertical_well", folder)
            self.assertEqual(run.returncode, 65)
            self.assertIn("has no wells to draw", run.stderr)


class Templates(unittest.TestCase):
    def test_the_users_own_come_first_and_may_extend(self):
        with tempfile.TemporaryDirectory() as folder:
            own = Path(folder, "mine")
            own.mkdir()
            (own / "study.html").write_text('{% extends "surveymc/study.html" %}{% block footer %}<p>Example &amp; Sons {{ study.name }}</p>{% endblock %}')
            arguments = (os.path.join(SMOKE, "vertical_well.h5"), "-o", os.path.join(folder, "r"), "--no-figures", "--templates", str(own))
            self.assertEqual(make(*arguments).returncode, 0)
            source = read(os.path.join(folder, "r"))["index.html"]
            self.assertIn("Example &amp; Sons Cross-axis", source)
            self.assertEqual(Page(source).faults, [])
            for wrong, words in (("{% block %}", "study.html:1: "), ("{{ nothing.here }}", "template study.html: 'nothing' is undefined")):
                (own / "study.html").write_text(wrong)
                run = make(*arguments)
                self.assertEqual(run.returncode, 65)
                self.assertIn(words, run.stderr)
                self.assertNotIn("Traceback", run.stderr)


class AnyResult(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.output = os.path.join(self.folder, "r")

    def changed(self, name, change):
        path = os.path.join(self.folder, f"{name}.h5")
        shutil.copy(os.path.join(SMOKE, "msa_sweep.h5"), path)
        with result_file(path, "a") as file:
            change(file)
        return path

    def report(self, *arguments):
        run = make(*arguments, "-o", self.output, "--no-figures")
        self.assertEqual(run.returncode, 0, run.stderr)
        found = read(self.output)
        for name, source in found.items():
            self.assertEqual(Page(source).faults, [], name)
        return "".join(source for name, source in found.items() if name != "paper.html"), run

    def test_all_smoke_results_make_a_page(self):
        there = [f for f in os.listdir(SMOKE) if f.endswith(".h5")]  # other tests may be adding to them
        source, _ = self.report(SMOKE)
        self.assertGreaterEqual(source.count("<article"), len(there))

    def test_a_result_of_the_users_own_has_a_page_of_its_own(self):
        def mine(file):
            file.attrs["command"] = "surveymc run my_well.toml"
            file.attrs["title"] = "My well & more"

        paths = [self.changed(name, mine) for name in ("one", "two")]
        front, _ = self.report(*paths, os.path.join(SMOKE, "vertical_well.h5"))
        found = read(self.output)
        self.assertEqual(set(found), {"index.html", "one.html", "two.html", "vertical_well.html", "paper.html"})
        self.assertLess(found["index.html"].index('id="own"'), found["index.html"].index('id="studies"'))
        self.assertIn("<h1>My well &amp; more</h1>", found["one.html"])
        result = surveymc.open(paths[0])
        part = html.unescape(found["one.html"])
        places = [part.index(words) for words in (result.answer[0], "<table", result.content_hash)]
        self.assertEqual(places, sorted(places))  # answer, tables, provenance
        source, _ = self.report(paths[0])
        self.assertEqual(set(read(self.output)), {"index.html"})
        self.assertIn("<h1>My well &amp; more</h1>", source)

    def test_a_study_that_is_too_large_for_a_page_has_several(self):
        paths = []
        for k in range(4):
            paths.append(os.path.join(self.folder, f"copy{k}.h5"))
            shutil.copy(os.path.join(SMOKE, "reliability_map.h5"), paths[-1])
        with unittest.mock.patch.object(pages, "LARGEST_PAGE", 220_000), unittest.mock.patch.object(pages.view3d, "is_installed", lambda: False):
            report = pages.Report([surveymc.Result(p) for p in paths], self.folder, None, 1, "", lambda done, of: None)
            found = dict(report.files())
        self.assertGreater(len(report.pages), 1)
        self.assertEqual([p.name for p in report.pages][:2], ["reliability_map", "reliability_map-2"])
        ids = [i for p in report.pages for i in re.findall(r'<article class="result" id="([^"]*)"', found[f"{p.name}.html"])]
        self.assertEqual(ids, [f"result-copy{k}" for k in range(4)])
        for p in report.pages:
            self.assertIn(f"Part {p.of[0]} of {len(report.pages)}", found[f"{p.name}.html"])
            for link in re.findall(r'href="([a-z0-9_-]+\.html)', found[f"{p.name}.html"]):
                self.assertIn(link, found)

    def test_an_unknown_experiment_is_shown_too(self):
        def unknown(file):
            file.attrs["experiment"] = "brand_new_study"
            file.attrs["title"] = "A <script>alert(1)</script> & \"title\""
            table = file.create_group("tables/rms")
            table["row"] = np.arange(3)
            table["quantity"] = np.array(["azimuth", "</script>", "c"], h5py.string_dtype())
            table["value"] = np.array([1.0, np.inf, np.nan])
            table["value"].attrs["units"] = "furlong"
            file.create_group("tables/empty")["row"] = np.zeros(0)

        source, _ = self.report(self.changed("new", unknown))
        for words in ("Brand new study", "furlong", "A &lt;script&gt;alert(1)"):
            self.assertTrue(words in source, words)
        self.assertFalse("<script>alert" in source)

    def test_rows_that_are_not_as_expected_stand_out(self):
        def wrong(file):
            table = file["tables/position"]
            expected = table["expected"].asstr()[()]
            verdicts = list(table["verdict"].asstr()[()])
            expected[verdicts.index("agrees")] = "differs"
            expected[verdicts.index("differs")] = "agrees"
            verdicts[verdicts.index("agrees", verdicts.index("agrees") + 1)] = "undecided"
            expected[verdicts.index("undecided")] = "agrees"
            table["expected"][...] = expected
            table["verdict"][...] = verdicts

        source, _ = self.report(self.changed("wrong", wrong))
        self.assertTrue("<strong>3 are not as the config expects</strong> (marked in the tables); 1 of them is undecided" in source)
        self.assertEqual(source.count("<tr class=unexpected>"), 3)
        front, _ = self.report(os.path.join(SMOKE, "vertical_well.h5"), os.path.join(self.folder, "wrong.h5"))
        self.assertTrue("<strong>3 not as expected</strong>" in front)

    def test_same_names_in_two_folders_and_files_that_are_no_results(self):
        for part in ("a", "b"):
            os.makedirs(os.path.join(self.folder, part))
            shutil.copy(os.path.join(SMOKE, "mwd_drift.h5"), os.path.join(self.folder, part, "fig1.h5"))
        with open(os.path.join(self.folder, "a", "broken.h5"), "w", encoding="utf-8") as file:
            file.write("no")
        source, run = self.report(self.folder)
        self.assertIn("left out", run.stderr)
        self.assertIn("broken.h5", run.stderr)
        self.assertEqual(re.findall(r'<article class="result" id="([^"]*)"', source), ["result-a-fig1", "result-b-fig1"])

    def test_damaged_results_are_no_pages(self):
        """A byte of the contents, of the seal and of its mark; a cut in the seal, and before it; contents edited behind its back."""
        with open(os.path.join(SMOKE, "mwd_drift.h5"), "rb") as file:
            whole = file.read()
        seal, damaged = integrity.SEAL_SIZE, {}
        for name, at in (("contents", len(whole) // 2), ("mark", len(whole) - seal), ("seal", len(whole) - 1)):
            damaged[name] = bytearray(whole)
            damaged[name][at] ^= 0x10
        damaged.update(cut=whole[:-3], shorter=whole[:-seal - 3])
        paths = [os.path.join(self.folder, f"{name}.h5") for name in (*damaged, "edited")]
        for path, data in zip(paths, damaged.values()):
            with open(path, "wb") as file:
                file.write(data)
        with open(paths[-1], "wb") as file:
            file.write(whole[:-seal])
        with h5py.File(paths[-1], "r+") as file:
            column = next(c for t in file["tables"].values() for c in t.values() if c.dtype == np.float64 and np.isfinite(c[0]))
            column[0] += 1
        run = make(*paths, "-o", self.output, "--no-figures")
        self.assertEqual(run.returncode, 65, run.stderr)
        self.assertFalse(os.path.exists(self.output))
        self.assertNotIn("Traceback", run.stderr)
        lines = run.stderr.splitlines()
        self.assertEqual(lines[-1], "surveymc report: no result file could be read")
        for path, line in zip(paths, lines):
            self.assertRegex(line, rf"^surveymc report: left out: {re.escape(path)}: .*(damaged|do not match)")
        self.assertEqual(len(lines), len(paths) + 1, run.stderr)

    def test_a_result_that_is_not_whole_is_left_out(self):
        def uneven(file):
            del file["tables/position/ratio"]
            file["tables/position/ratio"] = np.zeros(2)

        good = os.path.join(SMOKE, "mwd_drift.h5")
        source, run = self.report(good, self.changed("uneven", uneven))
        self.assertIn("uneven.h5", run.stderr)
        self.assertEqual(source.count("<article"), 1)

    def test_a_column_that_is_none_takes_no_other_result_with_it(self):
        def odd(file):
            del file["tables/position/verdict"]
            file.create_group("tables/position/verdict")

        for seal, path in ((False, self.changed("odd", odd)), (True, os.path.join(self.folder, "resealed.h5"))):
            if seal:  # what no check of bytes finds
                with open(os.path.join(self.folder, "odd.h5"), "rb") as file:
                    data = file.read()
                with open(path, "wb") as file:
                    file.write(data + integrity.seal_for(data))
            source, run = self.report(os.path.join(SMOKE, "mwd_drift.h5"), path)
            self.assertRegex(run.stderr, rf"^surveymc report: left out: {re.escape(path)}: [^\n]*\n$")
            self.assertEqual(source.count("<article"), 1)
            self.assertIn(": 1 result,", run.stdout)

    def test_refusals(self):
        for arguments, code, word in (([os.path.join(self.folder, "none.h5")], 65, "no such file"),
                                      ([self.folder], 65, "run_all.sh"), (["--colour"], 64, "usage"),
                                      ([os.path.join(SMOKE, "msa_sweep.h5"), "-o", "/proc/r"], 74, "/proc/r: cannot write: "),
                                      ([os.path.join(SMOKE, "msa_sweep.h5"), "-o", "r.html"], 64, "name a folder (-o r)"),
                                      ([os.path.join(SMOKE, "msa_sweep.h5"), "--templates", "/nowhere"], 64, "no such folder")):
            run = make(*arguments)
            self.assertEqual(run.returncode, code, run.stderr)
            self.assertIn(word, run.stderr)
            self.assertNotIn("Traceback", run.stderr)


@contextlib.contextmanager
def plots_with(**bodies):
    """Drawers of these names and bodies beside the others, for processes that are started meanwhile, too."""
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(os.path.join(SCRIPTS, "surveymc"), os.path.join(folder, "surveymc"), ignore=shutil.ignore_patterns("__pycache__"))
        for name, body in bodies.items():
            with open(os.path.join(folder, "surveymc", "plots", f"{name}.py"), "w", encoding="utf-8") as file:
                file.write(f"import os, sys\nfrom . import reading\n\n\ndef main():\n    {body}\n")
        plots = sys.modules["surveymc.plots"].__path__
        plots.append(os.path.join(folder, "surveymc", "plots"))
        importlib.invalidate_caches()
        sys.path.insert(0, folder)  # a spawned process gets it
        try:
            yield
        finally:
            sys.path.remove(folder)
            plots.pop()


class Drawers(unittest.TestCase):
    def test_figures_of_every_kind_of_result_are_known(self):
        for name, suffixes in (("mwd_drift", {"detection", "point0_tracks", "verdicts"}), ("estimate_chained", {"run_filter", "run_smoother"})):
            path = os.path.join(SMOKE, f"{name}.h5")
            result = surveymc.open(path)
            study = studies.load()[result.experiment]
            with tempfile.TemporaryDirectory() as folder:
                drawn = runner.draw(path, study.drawers_for(path), folder)
            self.assertEqual(drawn.broken, [])
            self.assertEqual({os.path.basename(f)[len(name) + 1:-4] for f in drawn.files}, suffixes)
            for suffix in suffixes:
                self.assertIn(study.caption(suffix), study.figures.values())

    def test_what_a_drawer_says_is_kept_apart_from_what_breaks(self):
        with plots_with(fine="print('a.svg')", refuses="sys.exit(65)", breaks="1 / 0"):
            for name, code, word in (("fine", 0, ""), ("refuses", 65, ""), ("breaks", 1, "ZeroDivisionError")):
                got = runner._run(name, ["x"])
                self.assertEqual(got[0], code)
                self.assertIn(word, got[2])

    def test_a_process_that_ends_amid_its_work_takes_no_other_figure_with_it(self):
        ends = "'bad' in sys.argv[1] and os.kill(os.getpid(), 9)\n    reading.Saved.paths.append('a.svg')"  # as HDF5 does on some files
        with tempfile.TemporaryDirectory() as folder, plots_with(some_drawer=ends):
            result = surveymc.open(os.path.join(SMOKE, "mwd_drift.h5"))
            tasks = []
            for name in ("bad", "good", "fine"):
                copy = types.SimpleNamespace(path=os.path.join(folder, name + ".h5"), content_hash=result.content_hash)
                tasks.append((name, copy, ["some_drawer"], os.path.join(folder, name)))
            drawn = figures.draw_all(tasks, 2, lambda done, of: None)
        self.assertEqual({k: len(d.files) for k, d in drawn.items()}, {"bad": 0, "good": 1, "fine": 1})
        self.assertIn("was ended", drawn["bad"].broken[0])

    def test_a_signal_ends_the_workers_too(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in "ab":
                shutil.copy(os.path.join(SMOKE, "clearance.h5"), os.path.join(folder, f"{name}.h5"))
            process = subprocess.Popen([sys.executable, os.path.join(SCRIPTS, "surveymc"), "report", folder],
                                       stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            drawn = lambda: [n for _, _, names in os.walk(folder) for n in names if n.endswith((".svg", ".html"))]  # noqa: E731
            deadline = time.monotonic() + 120
            while not drawn() and time.monotonic() < deadline:
                time.sleep(0.02)
            process.terminate()
            process.communicate(timeout=120)  # of all that have its pipes
            self.assertEqual(process.returncode, 143)
            self.assertLess(len(drawn()), 12)  # either has six

    def test_figures_are_drawn_again_only_when_something_changed(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "well.h5")
            shutil.copy(os.path.join(SMOKE, "mwd_drift.h5"), path)
            first = figures._draw(path, "well", ["estimate"], folder, "one")
            self.assertEqual(len(first.messages), 1)  # a result of another experiment: said, not broken
            self.assertEqual(first.broken, [])
            record = os.path.join(folder, ".well.figures.json")
            stamp = os.stat(record).st_mtime_ns
            self.assertEqual(figures._draw(path, "well", ["estimate"], folder, "one").messages, first.messages)
            self.assertEqual(os.stat(record).st_mtime_ns, stamp)
            figures._draw(path, "well", ["estimate"], folder, "two")
            self.assertNotEqual(os.stat(record).st_mtime_ns, stamp)


class Declarations(unittest.TestCase):
    def test_drawers_that_are_named_exist_and_no_other_is_forgotten(self):
        known = studies.load()
        named = {p for s in known.values() for p in s.plots}
        there = {f[:-3] for f in os.listdir(os.path.join(studies.PACKAGE, "plots")) if f.endswith(".py") and runner.is_drawer(f[:-3])}
        self.assertEqual(there - named, {"difference", "sweep"}, "declare them in studies.toml")  # which draw two results, and any sweep
        self.assertEqual(named - there, set())

    def test_every_study_config_is_of_a_known_experiment(self):
        import tomllib
        known = studies.load()
        for config in studies.configs():
            with open(os.path.join(studies.ROOT, config), "rb") as file:
                self.assertIn(tomllib.load(file)["experiment"], known, config)
            self.assertTrue(studies.description(config), f"{config}: a comment at its head says what it shows")

    def test_captions(self):
        study = studies.load()["msa_position"]
        self.assertEqual(study.caption("point3_ratio"), study.figures["ratio"])
        self.assertEqual(study.caption("position_test1"), study.figures["position"])
        self.assertEqual(study.caption("something_new"), "Something new.")
        self.assertEqual(study.drawers_for("results/thesis/table8.h5"), ["thesis"])
        self.assertEqual(study.drawers_for("mine/well.h5"), study.plots)
        of_tests = {path.stem for path in Path(__file__).resolve().parents[2].glob("configs/smoke/*.toml")}
        self.assertEqual(set(study.plots_for) - {os.path.basename(c)[:-5] for c in studies.configs()} - of_tests, set())


if __name__ == "__main__":
    SMOKE = os.path.abspath(sys.argv.pop())
    REPORT = os.path.abspath(sys.argv.pop())
    unittest.main()
