#!/usr/bin/python3
"""docs/equations.md names what exists, and misses no equation that the code cites: check_equations.py SOURCE

The page has a section for every source, with a table: equation | what it says | function | test.
  function  `file.h`: `name`, `name`; `other.h`: `name`     the name stands in the code of that file, comments apart
  test      `test_file.cpp`: "name of a test case", "..."   that file has the test case
Files are named without folder where no other file of lib, experiments or tests has that name.

Of a source whose heading says how many equations it has ("... (49 equations)"):
  every one of them is either in the table or in the line "Not built: ...", which says why;
  every citation in a comment of lib/**/*.h ("eq 14", "eqs 8-10, 19") is in the table, and the header is named there. What
  follows the word "Errata" in a comment may also be in the line;
Every work that these comments cite by name and year stands on the page.

docs/architecture.md: `file.h`: `name` exists in the same sense, and every module of lib is named.
"""
import functools
import pathlib
import re
import sys

NUMBERS = r"\d+(?:(?:-|–|, | and )\d+)*"
CITATION = re.compile(rf"\b(?:[Ee]qs?|relations?)\.? ({NUMBERS})")
WORK = re.compile(r"[A-Z][A-Za-z]+(?: et al\.|,? [A-Z][A-Za-z]+| and [A-Z][A-Za-z]+)* \(?(?:19|20)\d\d")
FUNCTIONS = re.compile(r"`([\w./]+\.(?:h|cpp))`: ((?:`[\w:]+`(?:, )?)+)")
NO_WORK = {"January 2016"}
#: Which source the comments of a header mean: the first part of the path that fits; all else must say "thesis".
SOURCES = [("/reliability/", "Nyrnes"), ("/monitoring/", "Boechat"), ("/vertical_well", "Hanak"), ("", "Vis")]


def expand(text):
    """Numbers of a list as people write it: "8-10, 19 and 21"."""
    found = []
    for first, last in re.findall(r"(\d+)(?:[-–](\d+))?", text):
        found += range(int(first), int(last or first) + 1)
    return found


@functools.lru_cache(maxsize=None)
def without_comments(code):
    return re.sub(r"//.*", "", code)


@functools.lru_cache(maxsize=None)
def comment_blocks(text):
    """Comments of consecutive lines, each as one line of text."""
    blocks, block = [], []
    for line in [*text.splitlines(), ""]:
        comment = re.search(r"//[/<! ]*(.*)$", line)
        if comment:
            block.append(comment[1].strip())
        elif block:
            blocks.append(" ".join(block))
            block = []
    return blocks


def cells(line):
    return [c.strip() for c in re.split(r"(?<!\\)\|", line)[1:-1]]


class Page:
    def __init__(self, source):
        self.source, self.bad, self.names = source, [], 0
        self.files = {}  # path, as text -> path
        for folder in ("lib", "experiments", "tests"):
            for path in (source / folder).rglob("*"):
                if path.suffix in (".h", ".cpp", ".py"):
                    self.files[path.relative_to(source).as_posix()] = path
        self.text = (source / "docs/equations.md").read_text()
        self.sections = dict(re.findall(r"^## (.*)\n((?:(?!^## ).*\n)*)", self.text, re.M))

    def file(self, name, where):
        fits = [p for path, p in self.files.items() if f"/{path}".endswith(f"/{name}")]
        if len(fits) != 1:
            self.bad.append(f"{where}: `{name}`: " + ("no such file" if not fits else "several files: give the folder"))
            return None
        return fits[0]

    def functions(self, cell, where):
        found = FUNCTIONS.findall(cell)
        if not found or FUNCTIONS.sub("", cell).strip("; "):
            self.bad.append(f"{where}: functions must be `file.h`: `name`, `name`; ...: {cell}")
        self.look_up(found, where)

    def look_up(self, found, where):
        """`found`: (file, names in backquotes)."""
        for name, words in found:
            path = self.file(name, where)
            code = without_comments(path.read_text()) if path else ""
            for word in re.findall(r"`([\w:]+)`", words):
                self.names += 1
                for part in word.split("::"):
                    if path and not re.search(rf"\b{part}\b", code):
                        self.bad.append(f"{where}: `{name}` has no {part}")

    def tests(self, cell, where):
        found = re.findall(r'`([\w./]+\.(?:cpp|py))`(?:: ("[^"]+"(?:, "[^"]+")*))?', cell)
        if not found:
            self.bad.append(f'{where}: tests must be `test_file.cpp`: "test case", ...: {cell}')
        for name, cases in found:
            path = self.file(name, where)
            if path and not path.is_relative_to(self.source / "tests"):
                self.bad.append(f"{where}: `{name}` is no test")
            if path and path.suffix == ".cpp" and not cases:
                self.bad.append(f"{where}: `{name}`: say which test case")
            # Names that the source breaks into two literals are one.
            text = re.sub(r'"\s*\n\s*"', "", path.read_text()) if path else ""
            for case in re.findall(r'"([^"]+)"', cases):
                self.names += 1
                if path and not re.search(r'TEST_CASE\(\s*"' + re.escape(case) + '"', text):
                    self.bad.append(f'{where}: `{name}` has no test case "{case}"')

    def rows(self, heading):
        """(equation, functions) of every row; checks what they name."""
        for line in self.sections[heading].splitlines():
            if not line.startswith("|") or re.fullmatch(r"[|\- ]+", line) or line.startswith("| equation"):
                continue
            row = cells(line)
            where = f"docs/equations.md: {heading}: {row[0]}"
            if len(row) != 4:
                self.bad.append(f"{where}: {len(row)} columns, not 4")
                continue
            self.functions(row[2], where)
            self.tests(row[3], where)
            yield row[0], row[2]

    def numbered(self, heading, rows):
        """(numbers in the table, numbers not built); every equation of the source is one of them."""
        count = re.search(r"\((\d+) equations\)$", heading)
        if not count:
            return None
        lines = re.findall(r"^Not built: ((?:.+\n)+)", self.sections[heading], re.M)
        built = {n for equation, _ in rows for n in expand(equation)}
        left = set()
        for line in lines:
            for numbers in re.findall(rf"(?:^|; )({NUMBERS}) \(", line.replace("\n", " ")):
                left |= set(expand(numbers))
        for n in range(1, int(count[1]) + 1):
            if (n in built) == (n in left):
                self.bad.append(f"docs/equations.md: {heading}: equation {n} is " +
                                ("in the table and not built" if n in built else "missing"))
        for n in sorted((built | left) - set(range(1, int(count[1]) + 1))):
            self.bad.append(f"docs/equations.md: {heading}: there is no equation {n}")
        return built, left

    def architecture(self):
        where = "docs/architecture.md"
        text = (self.source / where).read_text()
        self.look_up(FUNCTIONS.findall(text), where)
        for folder in sorted(p.name for p in (self.source / "lib").iterdir() if p.is_dir()):
            if f"`{folder}`" not in text:
                self.bad.append(f"{where}: module {folder} of lib is not named")

    def citations(self, sources):
        """Every citation of a header has its row; returns how many there are."""
        found = 0
        for name, path in sorted(self.files.items()):
            if not name.startswith("lib/") or path.suffix != ".h":
                continue
            for block in comment_blocks(path.read_text()):
                for work in WORK.findall(block):
                    found += 1
                    year, author = re.search(r"\d{4}", work)[0], re.match(r"\w+", work)[0]
                    if work not in NO_WORK and not re.search(rf"{author}[^|\n]*{year}", self.text):
                        self.bad.append(f"{name}: {work}: not on docs/equations.md")
                before, _, errata = block.partition("Errata")
                for part, is_errata in ((before, False), (errata, True)):
                    for hit in CITATION.finditer(part):
                        whose = next(s for fits, s in SOURCES if fits in f"/{name}")
                        if whose == "Vis" and "thesis" not in block.lower():
                            self.bad.append(f"{name}: {hit[0]}: of which source?")
                            continue
                        heading, (built, left), functions = sources[whose]
                        found += 1
                        for n in expand(hit[1]):
                            if n not in built and not (is_errata and n in left):
                                self.bad.append(f"{name}: cites equation {n}: no row in docs/equations.md: {heading}")
                        if f"`{path.name}`" not in functions and not is_errata:
                            self.bad.append(f"{name}: cites {hit[0]}: not named in docs/equations.md: {heading}")
        return found


def main():
    page = Page(pathlib.Path(sys.argv[1]).resolve())
    page.architecture()
    sources, rows_in_all = {}, 0
    for heading in page.sections:
        rows = list(page.rows(heading))
        rows_in_all += len(rows)
        numbered = page.numbered(heading, rows)
        for _, whose in SOURCES:
            if numbered and whose in heading:
                sources[whose] = heading, numbered, "; ".join(functions for _, functions in rows)
    missing = {whose for _, whose in SOURCES} - set(sources)
    if missing:
        page.bad.append(f"docs/equations.md: no section of {', '.join(sorted(missing))} with its number of equations")
    else:
        citations = page.citations(sources)
    print("\n".join(page.bad) or f"equations: {rows_in_all} rows, {page.names} names exist, {citations} citations have rows")
    return bool(page.bad)


if __name__ == "__main__":
    sys.exit(main())
