#!/usr/bin/python3
"""CITATION.cff is of the Citation File Format 1.2.0, and its references are those that `surveymc cite` prints:
check_citation.py SURVEYMC SOURCE SMOKE_FOLDER

SMOKE_FOLDER has a result of every experiment.
"""
import pathlib
import re
import subprocess
import sys

import yaml

surveymc, source, smoke = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
cff = yaml.safe_load((source / "CITATION.cff").read_text())
version = re.search(r"^project\(surveymc VERSION ([\d.]+)", (source / "CMakeLists.txt").read_text(), re.M)[1]
assert set(cff) == {"cff-version", "message", "type", "title", "authors", "version", "license", "keywords", "references"}, set(cff)
assert cff["cff-version"] == "1.2.0" and cff["type"] == "software" and cff["license"] == "MIT"
assert cff["version"] == version and cff["authors"] == [{"name": "The surveymc authors"}]

# Of the schema of the format: types and keys of references that are used here.
TYPES = {"article", "report", "thesis", "conference-paper", "standard", "slides", "data"}
KEYS = {"type": str, "title": str, "authors": list, "journal": str, "institution": dict, "publisher": dict, "number": str, "volume": int,
        "issue": str, "start": int, "end": int, "year": int, "doi": str}
listed = {}
for reference in cff["references"]:
    assert reference["type"] in TYPES and {"title", "authors"} <= set(reference), reference
    for key, value in reference.items():
        assert isinstance(value, KEYS[key]) and value, f"{reference['title']}: {key}"
    for author in reference["authors"]:
        assert set(author) in ({"name"}, {"given-names", "family-names"}), author
    if "doi" in reference:
        assert re.fullmatch(r"10\.\d{4,9}/[-._;()/:a-zA-Z0-9]+", reference["doi"]), reference["doi"]
    names = [a.get("name") or f"{a['given-names']} {a['family-names']}" for a in reference["authors"]]
    listed[reference["title"]] = (names, reference.get("year"), reference.get("doi"))
assert len(listed) == len(cff["references"]) > 10


def call(*arguments):
    return subprocess.run([surveymc, *map(str, arguments)], capture_output=True, text=True, check=True).stdout


def fields(entry):
    """{name: text without the outer braces and escapes} of an entry of BibTeX."""
    return {name: re.sub(r"\\([&%$#_{}])", r"\1", text.strip("{}")) for name, text in re.findall(r"(?m)^  (\w+) = \{(.*)\},?$", entry)}


cited, experiments = {}, set()
for path in sorted(smoke.glob("*.h5")):
    text, entries = call("cite", path), call("cite", path, "--bibtex").split("\n\n")
    program, result = fields(entries[0]), fields(entries[1])
    assert f"version {version}, revision " in program["note"] and f"version {version}, revision " in text, path
    assert result["title"] in text and re.search(r"content [0-9a-f]{32}", result["note"])
    experiments.add(re.search(r"study (\S+) of", result["howpublished"])[1])
    ids = re.findall(r"(?m)^@\w+\{(\w+)", "\n\n".join(entries))
    assert len(set(ids)) == len(ids)
    for entry in entries[2:]:
        f = fields(entry)
        authors = [a.strip("{}") for a in f["author"].split(" and ")] if not f["author"].startswith("{") else \
            [a.strip("{}") for a in f["author"].split("} and {")]
        assert f["title"] in text and all(a in text for a in authors), f
        cited[f["title"]] = (authors, int(f["year"]) if "year" in f else None, f.get("doi"))
known = {line.split()[0] for line in call("list").splitlines() if not line.startswith(" ")}
assert experiments == known, known - experiments
conditional = {title for title in listed if "gyroscopic" in title or "World Magnetic" in title}  # where the config names them
assert set(cited) | conditional == set(listed), set(cited) ^ set(listed)
for title, what in cited.items():
    assert what == listed[title], f"{title}: cite says {what}, CITATION.cff {listed[title]}"
print(f"{len(listed)} references, as surveymc cite prints them for {len(experiments)} experiments")
