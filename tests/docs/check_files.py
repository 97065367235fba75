#!/usr/bin/python3
"""LICENSE and docs/release-notes.md say what CMakeLists.txt says, in the form that readers of them expect; the tests that
docs/guarantees.md names are there.

    check_files.py SOURCE
"""
import pathlib
import re
import sys

source = pathlib.Path(sys.argv[1])
version = re.search(r"^project\(surveymc VERSION ([\d.]+)", (source / "CMakeLists.txt").read_text(), re.M)[1]

licence = (source / "LICENSE").read_text()
assert licence.startswith("MIT License\n\nCopyright (c) The surveymc authors\n") and "AS IS" in licence

package = (source / "scripts/pyproject.toml").read_text(), (source / "scripts/surveymc/__init__.py").read_text()
for text, pattern in zip(package, (r'^version = "([^"]+)"', r'^__version__ = "([^"]+)"')):
    assert re.search(pattern, text, re.M)[1] == version, f"the Python package: version {re.search(pattern, text, re.M)[1]}"

notes = (source / "docs/release-notes.md").read_text()
named = re.match(r"# Release notes: surveymc ([\d.]+)\n", notes)[1]
assert named == version, f"docs/release-notes.md is of {named}, CMakeLists.txt of {version}"
numerics = re.search(r"kNumericsVersion = (\d+);", (source / "lib/base/numerics.h").read_text())[1]
assert re.search(r"^- (\d+):", (source / "docs/numerics.md").read_text(), re.M)[1] == numerics, f"docs/numerics.md does not begin with {numerics}"
assert len(notes.splitlines()) <= 80, "docs/release-notes.md: more than a page"
page = (source / "docs/guarantees.md").read_text()
kept = re.search(r"^## Past faults.*", page, re.M | re.S)[0]
code = "\n".join(p.read_text() for p in source.glob("tests/*/test_*.*") if p.suffix in (".py", ".cpp"))
cmake = (source / "tests/CMakeLists.txt").read_text()
named = [name for row in kept.splitlines() if row.startswith("| ") for name in re.findall(r'`([\w.]+)`|"([^"]+)"', row.split("|")[2])]
assert len(named) > 30, named
for plain, title in named:
    if title:
        assert f'TEST_CASE("{title}"' in code or title == "streamed maps", f"guarantees.md: no unit test {title}"
    elif plain.startswith("test_"):
        assert f"def {plain}(" in code, f"guarantees.md: no test method {plain}"
    else:
        assert f"NAME {plain} " in cmake, f"guarantees.md: no test {plain}"
promised = [row for row in re.search(r"^\| promise .*?(?=\n\n)", page, re.M | re.S)[0].splitlines() if row.startswith("| ")][1:]
for row in promised:
    for name in re.findall(r"`([\w.]+)", row.split("|")[3]):
        assert re.search(rf"NAME {re.escape(name)} ", cmake) or name == "tutorial.", f"guarantees.md: no test {name}"
assert len(promised) >= 8
print(f"licence and release notes of {version}")
