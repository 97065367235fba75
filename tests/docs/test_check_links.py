#!/usr/bin/python3
"""check_links.py --html finds what is wrong with a built site: test_check_links.py. Skipped (77) without Sphinx."""
import json
import pathlib
import re
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import check_links  # noqa: E402

try:
    import sphinx  # noqa: F401
except ImportError:
    print("skipped: not installed: python3-sphinx")
    sys.exit(77)


class Site(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        (self.folder / "docs").mkdir()
        (self.folder / "docs/keys.md").write_text("| key | meaning |\n|---|---|\n| `survey.file` | a file |\n")
        for n, name in enumerate(["index", "one", "two", "three"]):
            following = ["one", "two", "three", "index"][n]
            self.page(name, f'<h1 id="top">{name}</h1><a href="{following}.html#top">on</a><link rel="stylesheet" href="a.css?digest=1">')
        (self.folder / "a.css").write_text("body { background: url(data:image/png;base64,x) }")
        self.search({"survey": 0, "file": [0, 1]})

    def page(self, name, body):
        (self.folder / f"{name}.html").write_text(f"<html><body>{body}</body></html>")

    def search(self, terms, entries=("survey.file",)):
        entries = {entry: [] for entry in entries}
        (self.folder / "searchindex.js").write_text(f"Search.setIndex({json.dumps({'terms': terms, 'titleterms': {}, 'indexentries': entries})})")

    def check(self):
        return check_links.check_site(self.folder, self.folder)[0]

    def wrong(self, words):
        found = self.check()
        self.assertTrue(any(re.search(words, line) for line in found), found)

    def test_a_good_site(self):
        self.assertEqual(self.check(), [])

    def test_links_and_anchors(self):
        self.page("three", '<h1 id="top">three</h1><a href="four.html">on</a>')
        self.wrong("four.html: no such file")
        self.page("three", '<h1 id="top">three</h1><a href="index.html#bottom">on</a>')
        self.wrong("no such anchor")

    def test_a_page_of_four_clicks(self):
        self.page("three", '<h1 id="top">three</h1><a href="four.html">on</a>')
        self.page("four", "far")
        self.wrong("four.html: not within three clicks")
        self.page("index", '<h1 id="top">index</h1><a href="one.html#top">on</a><a href="four.html">on</a>')
        self.assertEqual(self.check(), [])

    def test_the_network(self):
        self.page("three", '<h1 id="top">three</h1><script src="https://example.org/a.js"></script>')
        self.wrong("example.org/a.js: from the network")
        self.page("three", '<h1 id="top">three</h1><a href="https://example.org">only a link</a>')
        self.assertEqual(self.check(), [])
        (self.folder / "a.css").write_text("@import 'https://example.org/b.css';")
        self.wrong("b.css: from the network")

    def test_a_key_that_is_not_found(self):
        self.search({"file": 1})
        self.wrong("search does not find survey")
        self.search({"survey": 0, "file": 1}, ["survey"])
        self.wrong("search does not lead to the key survey.file")

    def test_keys_in_another_form(self):
        (self.folder / "docs/keys.md").write_text("* `survey.file`: a file\n")
        self.wrong("no key is found")


if __name__ == "__main__":
    unittest.main()
