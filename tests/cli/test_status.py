#!/usr/bin/python3
"""surveymc status: what is done of a run in one process, in parts, watched and as a page. test_status.py SURVEYMC SOURCE_FOLDER"""
import html.parser
import re
import signal
import subprocess
import sys
import time
import unittest
from pathlib import Path

import h5py

import test_cli
from test_cli import BAD_INPUT, CANNOT_WRITE, INTERRUPTED, USAGE, Case, column

PATIENCE = 60  # s
SWEEP = '[sweep]\n"noise.scale" = [0.2, 0.4, 0.6, 0.8]\n'


class Text(html.parser.HTMLParser):
    """Tags and words of a page; a tag that is not closed or closes another is an error."""

    def __init__(self, text):
        super().__init__()
        self.open, self.words, self.classes, self.refresh = [], [], [], None
        self.feed(text)
        assert not self.open, self.open

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        if tag == "meta":
            if attrs.get("http-equiv") == "refresh":
                self.refresh = attrs["content"]
            return
        self.open.append(tag)
        if tag == "i":
            self.classes.append(attrs.get("class", ""))
        assert not {"src", "href"} & set(attrs), attrs  # no network, no other files

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


class Status(Case):
    def setUp(self):
        super().setUp()
        self.config("sweep.toml", ("trials = 600", "trials = 40000"), ('title = "Base"', 'title = "A <sweep>"'), append=SWEEP)

    def status(self, *words, **more):
        return self.call("status", *words, timeout=PATIENCE, **more).stdout

    def page(self, name="page.html"):
        return Text((self.folder / name).read_text())

    def interrupted(self, *words):
        """A run that is stopped when one point is done and another has begun, by one thread."""
        child = subprocess.Popen([test_cli.EXECUTABLE, "run", *words, "-o", "out.h5", "--threads", "1", "--checkpoint-seconds", "0.01", "-q"],
                                 cwd=self.folder, stderr=subprocess.PIPE)
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end and child.poll() is None:
            if re.search("^  [1-9] of", self.status(*words, "-o", "out.h5"), re.M):
                break
        child.send_signal(signal.SIGTERM)
        child.communicate()
        self.assertEqual(child.returncode, INTERRUPTED)

    def verdicts(self, path, points):
        """(agrees, differs, undecided) of the first points of the sweep."""
        counts = [0, 0, 0]
        with h5py.File(path) as file:
            judged = [name for name, table in file["tables"].items() if "verdict" in table]
        self.assertGreater(len(judged), 1)
        for table in judged:
            scale = column(path, f"tables/{table}", "noise.scale")
            for s, verdict in zip(scale, column(path, f"tables/{table}", "verdict")):
                if s in points and verdict:
                    counts[["agrees", "differs", "undecided"].index(verdict)] += 1
        return counts

    def said_verdicts(self, text):
        line = re.search(r"verdicts of .*: (.*)", text)[1]
        number = lambda *words: sum(int(n) for w in words for n in re.findall(rf"(\d+) {w}\b", line.split(";")[0]))
        return [number("agrees?"), number("differs?", "findings?"), number("undecided")]

    def test_a_run_in_one_process(self):
        out = self.status("sweep.toml", "-o", "out.h5")
        self.assertRegex(out, "nothing is kept of it there yet.*\n  0 of 4 points done, 0 %")
        self.interrupted("sweep.toml", "--trials", "1000000")
        self.assertRegex(self.status("sweep.toml", "-o", "out.h5"), r"out\.h5\.journal\.\S+: is of another config or build: not counted")
        out = self.status("sweep.toml", "--trials", "1000000", "-o", "out.h5", "--page", "page.html")
        done = int(re.search(r"^  (\d) of 4 points done, (\d+) % of the work$", out, re.M)[1])
        self.assertIn(done, (1, 2, 3))
        share = int(re.search(r"points done, (\d+) %", out)[1])
        self.assertTrue(100 * done / 4 <= share + 1 and share <= 100 * (done + 1) / 4, out)
        self.assertRegex(out, r"computed for .*; the last work was kept .* ago; about .* left at this pace")
        page = self.page()
        self.assertEqual(page.classes.count("d"), done)
        self.assertIsNone(page.refresh)
        self.assertIn("A <sweep>", page.words)
        self.assertTrue(all(line.strip() in page.words for line in out.splitlines()[2:5]), out)

        self.call("run", "sweep.toml", "--trials", "1000000", "-o", "out.h5", "--resume", "-q", timeout=300)
        scales = [0.2, 0.4, 0.6, 0.8]
        self.assertEqual(self.said_verdicts(out), self.verdicts(self.folder / "out.h5", scales[:done]))
        out = self.status("sweep.toml", "--trials", "1000000", "-o", "out.h5", "--watch", "--page", "page.html")  # ends at once
        self.assertRegex(out, "4 of 4 points done, 100 % of the work; the result is written")
        self.assertEqual(self.said_verdicts(out), self.verdicts(self.folder / "out.h5", scales))
        self.assertEqual(self.page().classes, ["d"] * 4)
        self.assertRegex(self.status("sweep.toml", "-o", "out.h5"), r"out\.h5 is there, but of another config or build: .*\n  0 of 4 points")

    def test_a_stopping_rule_ends_points_before_their_trials(self):
        self.config("stops.toml", ("trials = 600", ""), append='[stop]\nrelative_ci = 0.00001\nquantities = ["sigma3_gain_x"]\nmax_trials = 20000000\n[sweep]\n"noise.scale" = [0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1]\n')
        self.interrupted("stops.toml")
        out = self.status("stops.toml", "-o", "out.h5")
        done = int(re.search(r"(\d+) of 10 points done", out)[1])
        self.call("run", "stops.toml", "-o", "out.h5", "--resume", "-q", timeout=300)
        self.assertLess(column(self.folder / "out.h5", "tables/position", "trials")[0], 20000000)
        self.assertEqual(self.said_verdicts(out), self.verdicts(self.folder / "out.h5", [round(0.2 + 0.1 * i, 1) for i in range(done)]))

    def test_parts_and_points_that_cannot_be_run(self):
        for point in (0, 2):
            self.call("run", "sweep.toml", "--point", point, "-o", "p/", "-q")
        for out in (self.status("p", "--page", "page.html"), self.status("sweep.toml", "-o", "p")):
            self.assertRegex(out, r"2 parts, .*; 2 of 4 points done; missing, whole or in part: 1,3\n  2 of 4 points done, 50 % of the work\n")
            self.assertRegex(out, r"slowest: point-0000\d\.part \d.* s, point-0000\d\.part ")
        self.assertEqual(self.page().classes, ["d", "", "d", ""])
        for shard in (0, 1):
            self.call("run", "sweep.toml", "--shard", f"{shard}/2", "-o", "p/", "-q")
        out = self.status("p", "--watch")  # all there: it ends
        self.assertRegex(out, "4 of 4 points done, 100 % of the work\n  verdicts of 4 points: ")
        self.call("merge", "p", "-o", "out.h5", "-q")
        self.assertEqual(self.said_verdicts(out), self.verdicts(self.folder / "out.h5", [0.2, 0.4, 0.6, 0.8]))
        self.refused(USAGE, "status", "p", "--trials", "5", says="a folder of parts needs no options of a config")

        self.config("large.toml", append='[sweep]\n"noise.scale" = { from = -0.0002, to = 1.0, count = 10002 }\n')
        self.call("run", "large.toml", "--point", "0:12", "--trials", "20", "-o", "q/", "-q", timeout=120)
        out = self.status("q", "--page", "large.html")
        self.assertRegex(out, r"cannot be run; the first: point 0 \(noise\.scale = -\S+\): .*noise\.scale")

    def test_a_part_that_is_not_done(self):
        self.call("run", "sweep.toml", "--trials", "1000000", "--point", "3", "-o", "p/", "-q", timeout=120)
        child = subprocess.Popen([test_cli.EXECUTABLE, "run", "sweep.toml", "--trials", "1000000", "--point", "0:3", "-o", "p/", "--threads", "1",
                                  "--checkpoint-seconds", "0.01", "-q"], cwd=self.folder, stderr=subprocess.PIPE)
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end and child.poll() is None and "2 of 4 points done," not in self.status("p"):
            time.sleep(0.01)
        child.send_signal(signal.SIGKILL)
        child.communicate()
        out = self.status("p", "--page", "page.html")
        self.assertRegex(out, r"1 part, .*; 1 of 4 points done; missing, whole or in part: 0-2\n  [23] of 4 points done, [5-9]\d % of the work\n")
        self.assertRegex(out, r"\nunfinished: p/points-00000-00003\.part\.journal\.")
        self.assertEqual([self.page().classes[i] for i in (0, 3)], ["d", "d"])
        self.assertRegex(out, "verdicts of [23] points: ")

    def test_watching_a_run_to_its_end(self):
        command = [test_cli.EXECUTABLE, "run", "sweep.toml", "--trials", "300000", "-o", "out.h5", "--threads", "1", "--checkpoint-seconds", "0.05", "-q"]
        child = subprocess.Popen(command, cwd=self.folder)
        watch = subprocess.Popen([test_cli.EXECUTABLE, "status", "sweep.toml", "--trials", "300000", "-o", "out.h5", "--watch", "--every", "0.1",
                                  "--page", "page.html"], cwd=self.folder, stdout=subprocess.PIPE, text=True)
        refreshed = set()
        end = time.monotonic() + PATIENCE
        while watch.poll() is None and time.monotonic() < end:
            if (self.folder / "page.html").exists():
                refreshed.add(self.page().refresh)  # it is whole at every moment
            time.sleep(0.02)
        said = watch.communicate()[0]
        self.assertEqual((watch.returncode, child.wait(PATIENCE)), (0, 0))
        self.assertEqual((refreshed - {None}, self.page().refresh), ({"1"}, None))
        shares = [int(n) for n in re.findall(r"(\d+) % of the work", said)]
        self.assertEqual(shares, sorted(shares))
        self.assertEqual(shares[-1], 100)
        self.assertGreater(len(set(shares)), 2)
        self.assertRegex(said, r"slowest: point \d \(noise\.scale = 0\.\d\) \d+\.\d s, point \d")
        self.assertEqual([p.name for p in self.folder.glob(".*")], [])

    def test_a_signal_ends_the_looking_alone(self):
        watch = subprocess.Popen([test_cli.EXECUTABLE, "status", "sweep.toml", "--watch"], cwd=self.folder, stdout=subprocess.PIPE)
        self.assertIn(b"A <sweep>", watch.stdout.readline())
        watch.send_signal(signal.SIGINT)
        self.assertEqual(watch.wait(5), 0)
        watch.stdout.close()

    def test_points_without_trials(self):
        self.write("map.toml", 'experiment = "position_covariance"\n[survey]\nfile = "survey.csv"\ntoolface_zero = "y"\n[field]\ntotal_nT = 50000.0\n'
                               'dip_deg = 60.0\n[error_model]\nname = "iscwsa_mwd_rev4"\n[sweep]\n"field.dip_deg" = { from = 20.0, to = 80.0, count = 3000 }\n')
        child = subprocess.Popen([test_cli.EXECUTABLE, "run", "map.toml", "-o", "out.h5", "--threads", "1", "--checkpoint-seconds", "0.01", "-q"],
                                 cwd=self.folder, stderr=subprocess.PIPE)
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end and child.poll() is None and not list(self.folder.glob("out.h5.journal.*")):
            time.sleep(0.01)
        child.send_signal(signal.SIGKILL)
        child.communicate()
        done = int(re.search(r"(\d+) of 3000 points done", self.status("map.toml", "-o", "out.h5", "--page", "page.html"))[1])
        self.assertGreater(done, 0)
        self.assertEqual(self.page().classes.count("d"), done)

    def test_refusals(self):
        self.write("mine.html", "<p>mine</p>")
        self.call("status", "sweep.toml", "--page", "mine.html", code=CANNOT_WRITE)
        self.assertEqual((self.folder / "mine.html").read_text(), "<p>mine</p>")
        self.refused(CANNOT_WRITE, "status", "sweep.toml", "--page", "no/such/page.html", says="page.html: cannot be written")
        self.refused(BAD_INPUT, "status", "survey.csv", says="is no folder of parts and no config, but a survey; commands for it")
        self.refused(BAD_INPUT, "status", "nothing", says="nothing: is no folder of parts and no config")
        self.refused(USAGE, "status", "sweep.toml", "--every", "0", says="--every")


if __name__ == "__main__":
    test_cli.EXECUTABLE, test_cli.SOURCE = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
