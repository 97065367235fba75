#!/usr/bin/python3
"""Every section of README and docs with measured numbers says what makes them: check_numbers.py SOURCE

A section is the text from a heading to the next one. If it has a number with a decimal point or a percentage, then it,
or the section that it is in, names a config of configs/, a program of tests/ or scripts/, or a command. No page of a study has
more than 150 lines, and README 100 to 130: what is longer is split, with the summary on the first page.
"""
import pathlib
import re
import sys

source = pathlib.Path(sys.argv[1])
configs = {p.stem for p in source.glob("configs/*/*.toml")}
MEASURED = re.compile(r"(?<![\w.])\d*[.,]\d+(?![\w.])|\d ?%|10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]")
COMMAND = re.compile(r"configs/|\.toml|\bsurveymc (?:run|show|check)|surveymc_bench|\btests/|\bscripts/|\w+\.cpp|python3")


def says_how(text):
    names = set(re.findall(r"`([\w.]+)`", text))
    return bool(COMMAND.search(text)) or bool(names & configs)


def sections(text):
    """(level, heading, text) in order; code fences are part of the text."""
    found, fenced = [(0, "head", "")], False
    for line in text.splitlines():
        fenced ^= line.startswith("```")
        heading = None if fenced else re.match(r"(#+) (.*)", line)
        if heading:
            found.append((len(heading[1]), heading[2], ""))
        else:
            level, name, body = found[-1]
            found[-1] = (level, name, body + line + "\n")
    return found


def main():
    bad, checked = [], 0
    for page in [source / "README.md", *sorted(source.glob("docs/studies/*.md")), source / "docs/performance.md"]:
        lines = len(page.read_text().splitlines())
        if page.parent.name == "studies" and lines > 150 or page.name == "README.md" and not 100 <= lines <= 130:
            bad.append(f"{page.relative_to(source)}: {lines} lines")
        above = []  # the sections that a section is in
        for level, name, text in sections(page.read_text()):
            above = [s for s in above if s[0] < level] + [(level, name, text)]
            if not MEASURED.search(text):
                continue
            checked += 1
            if not any(says_how(f"{n}\n{t}") for _, n, t in above[-2:]):
                bad.append(f"{page.relative_to(source)}: {name}: numbers without a config or command")
    print("\n".join(bad) or f"numbers: {checked} sections say what makes theirs")
    return bool(bad)


if __name__ == "__main__":
    sys.exit(main())
