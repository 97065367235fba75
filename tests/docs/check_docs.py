#!/usr/bin/python3
"""Runs the commands of the documentation and holds every number that is quoted from them against what they give.

    check_docs.py SURVEYMC [PAGE ...] [--full] [--sample N] [--print] [--only TEXT] [--keep FOLDER] [--syntax | --list]

A page is README.md, one of docs/studies/, or any other Markdown file (default: these, and all pages of docs/ that have claims).
Its numbers are tied to commands by a file that no reader of the page sees: docs/claims/NAME.toml for docs/NAME.md,
docs/FOLDER/NAME.md or README.md.

    [[numbers]]
    section = "Table 5"                         # heading of the section that quotes them, as the page has it
    of = "surveymc run configs/thesis/table5.toml --trials 1000000"
    small = "--trials 4000"
    held = '''
    bias_z of test 1 is −137 = parameters(case="test 1", quantity="mean_bias_z").published
    | 1.06, 1.05, 1.17 | = parameters(case="test 1", quantity=GAINS).published_ratio
    to 4·10⁻¹² >= max(abs(published().difference_over_trace))
    kurtosis 5.6 = ... [small ± 2]
    50 times = ... [full]
    '''

* `of` is the whole command as it stands in the text, or the config alone, if the text names that (checked in
  docs/studies/). `small` has the options of a run of seconds instead of the command's own; `small = "the same"`
  runs the command as it is. Without it the command is run with --full only.
* Each line of `held` has a quote, a relation and an expression. The quote stands in the text of the section, word by word,
  its line breaks aside. All numbers in it are compared, in their order, with the values of the
  expression. `=`: the value rounds to the number; `>=`, `<=`: the number bounds the value. Numbers are written as in the
  text: −.5, 1,000, 4·10⁻¹², 12 % (= .12), ∞. Trailing zeros of a whole number count up to its second digit: 6800 stands
  for 6750 to 6850. The numbers 0 and 1 are exact.
* An expression is Python. The name of a table selects rows by the values of columns and gives columns:
  table(column="value", other=["a", "b"]).column. Rows come in the order of a list's values, the first list slowest. Where
  a column's name has a dot, write "_". The name of a map selects by its axes: azimuth_ratio(inclination=90, azimuth=90).
  samples("realisations") is there, too. max, min, median, mean, sd, abs, sqrt, count, share, rows work on columns; several
  values are separated by commas. table().cells("a", "b") gives two columns row by row.
* `[nightly]`, or `[nightly, small ± X]`: the small run compares the number, too, but would not see that it is wrong by 5 %. A
  number of which that is so and not said is an error. `--list` prints these numbers and those marked `[full]`.
* A line `let NAME = EXPRESSION` before the numbers gives a name to what several of them use.

A value of Monte Carlo has an interval, 95 % in the file. Here it is widened to what all numbers of the pages of a folder keep
together with probability 99 %, and once more by the square root of 2, because the number in the text is a draw as well. Products
and ratios of such values are taken as independent. What has no interval (medians, counts) has to come out in every digit,
or states its own tolerance for the small run: `[small ± X]`. `[full]` is a number that a small run cannot say.

Every command `surveymc run` of a page of docs/studies/ has to be tied to a number, unless it stands in `[not_run]` with the
reason (`"configs/chained/deleted_wrong.toml" = "minutes"`), and every such page has such numbers. Exit: 0, or 1 with a line
for every number that is wrong.
"""
import argparse
import functools
import hashlib
import math
import os
import pathlib
import re
import shlex
import statistics
import subprocess
import sys
import tempfile
import time
import tomllib
import zlib
from typing import NamedTuple

import h5py
import numpy as np

SOURCE = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCE / "scripts"))
from surveymc import storage, streams  # noqa: E402
PAGES = [*sorted((SOURCE / "docs/studies").glob("*.md")), SOURCE / "README.md",
         *sorted(page for page in (SOURCE / "docs").glob("*.md") if (SOURCE / f"docs/claims/{page.stem}.toml").exists())]
ALL_TIED = "studies"  # the folder of pages whose commands all need numbers
TOGETHER = 0.99  # probability that all numbers of the pages of a folder are within their intervals


class Wrong(Exception):
    """What is wrong with one line of a page."""


# Numbers as they are written in the text.

SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
NUMBER = re.compile(r"""
    (?<![\w.,])(?<!\w[-−])                # not within a word: "s0", "trajectory-3"
    (?P<sign>[−-]?)
    (?: (?P<infinite>∞)
      | (?P<digits>\d{1,3}(?:,\d{3})+(?:\.\d+)? | \d+(?:\.\d+)? | \.\d+)
        (?: \ ?·\ ?10(?P<power>[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+) | e(?P<e>[-+]?\d+) | (?P<ten>[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+) )? )
    (?P<percent>\ ?%)?
    (?![\w]|\.\d)""", re.X)


class Number(NamedTuple):
    text: str
    value: float
    rounding: float  # half a unit of the last digit


def numbers_in(text):
    """The numbers of a piece of text, in order. A number followed by % is a hundredth."""
    found = []
    for hit in NUMBER.finditer(re.sub(r"(?<=\d)(?=(?:mm|cm|m|ft|nT|mg|h|sd|deg)\b)", " ", text)):
        sign = -1 if hit["sign"] else 1
        if hit["infinite"]:
            found.append(Number(hit[0], sign * math.inf, 0))
            continue
        digits = hit["digits"].replace(",", "")
        if hit["ten"]:  # 10⁶ is a power; no other number has a superscript
            if digits != "10":
                raise Wrong(f"'{hit[0]}' is no number")
            found.append(Number(hit[0].strip(), sign * 10.0 ** int(hit["ten"].translate(SUPERSCRIPTS)), 0))
            continue
        power = int((hit["power"] or hit["e"] or "0").translate(SUPERSCRIPTS))
        if "." in digits:
            unit = 10.0 ** -len(digits.split(".")[1])
        elif digits in ("0", "1"):  # none and all: exact
            unit = 0.0
        else:
            unit = 10.0 ** max(0, len(digits) - max(2, len(digits.rstrip("0"))))
        scale = 10.0**power / (100 if hit["percent"] else 1)
        found.append(Number(hit[0].strip(), sign * float(digits) * scale, unit / 2 * scale))
    return found


# Values of results, with half the width of their intervals.

class Measured:
    """Numbers and half of their 95 % intervals; 0 where there is none. Arithmetic takes operands as independent."""

    __array_priority__ = 1

    def __init__(self, values, half=0.0):
        self.values = np.atleast_1d(np.asarray(values, float))
        self.half = np.broadcast_to(np.asarray(half, float), self.values.shape)

    @staticmethod
    def of(x):
        return x if isinstance(x, Measured) else Measured(x)

    def _with(self, other, value, by_self, by_other):
        return Measured(value, np.hypot(by_self * self.half, by_other * other.half))

    def __add__(self, other):
        other = self.of(other)
        return self._with(other, self.values + other.values, 1, 1)

    def __sub__(self, other):
        other = self.of(other)
        return self._with(other, self.values - other.values, 1, 1)

    def __mul__(self, other):
        other = self.of(other)
        return self._with(other, self.values * other.values, other.values, self.values)

    def __truediv__(self, other):
        other = self.of(other)
        return self._with(other, self.values / other.values, 1 / other.values, self.values / other.values**2)

    def __rtruediv__(self, other):
        return self.of(other) / self

    def __rsub__(self, other):
        return self.of(other) - self

    __radd__, __rmul__ = __add__, __mul__

    def __neg__(self):
        return Measured(-self.values, self.half)

    def __pow__(self, power):
        return Measured(self.values**power, np.abs(power * self.values ** (power - 1)) * self.half)

    def __abs__(self):
        return Measured(np.abs(self.values), self.half)

    def __getitem__(self, index):
        return Measured(self.values[index], self.half[index])

    def __len__(self):
        return len(self.values)

    def __gt__(self, other):
        return self.values > Measured.of(other).values

    def __lt__(self, other):
        return self.values < Measured.of(other).values


def at(chooses):
    """The entry that `chooses` (argmax, argmin) picks, with its interval."""
    def pick(*values):
        flat = joined(values)
        return flat[[int(chooses(flat.values))]]
    return pick


def joined(values):
    parts = [Measured.of(v) for v in (values if isinstance(values, (tuple, list)) else (values,))]
    return Measured(np.concatenate([p.values for p in parts]), np.concatenate([p.half for p in parts]))


class Texts(list):
    """A column of words; == gives which rows have the word."""

    def __eq__(self, word):
        return np.array([x == word for x in self])


def equal(column, wanted):
    if isinstance(wanted, str):
        return column == wanted
    return np.isclose(column.astype(float), wanted, rtol=1e-9, atol=1e-12) if column.dtype != object else column == wanted


class Rows:
    """Chosen rows of a table; its columns are attributes."""

    def __init__(self, name, columns, index):
        self._name, self._columns, self._index = name, columns, index

    def __call__(self, **wanted):
        index = self._index
        for key, value in reversed(wanted.items()):  # the first key varies slowest
            column = self._columns[self._column(key)]
            choices = value if isinstance(value, (list, tuple)) else [value]
            index = np.concatenate([index[np.asarray(equal(column[index], c), bool)] for c in choices])
        if len(index) == 0:
            raise Wrong(f"table {self._name} has no row with {wanted}")
        return Rows(self._name, self._columns, index)

    def _column(self, key):
        for name in self._columns:
            if name == key or name.replace(".", "_") == key:
                return name
        raise Wrong(f"table {self._name} has no column '{key}'; there are: {', '.join(self._columns)}")

    def __getattr__(self, key):
        if key.startswith("__"):
            raise AttributeError(key)
        name = self._column(key)
        column = self._columns[name][self._index]
        if column.dtype == object:
            return Texts(column)
        half = 0.0
        if name + "_ci_low" in self._columns:
            low, high = (self._columns[f"{name}_ci_{end}"][self._index] for end in ("low", "high"))
            half = np.nan_to_num(np.maximum(high - column, column - low), nan=0.0, posinf=0.0)
        if name == "published_ratio" and "monte_carlo_ci_low" in self._columns:  # published / monte_carlo
            monte_carlo = self.monte_carlo
            half = np.abs(column * monte_carlo.half / monte_carlo.values)
        return Measured(column, half)

    def cells(self, *names):
        """Several columns, row by row, as a table of the text has them."""
        columns = [Measured.of(getattr(self, name)) for name in names]
        return Measured(np.stack([c.values for c in columns], 1).ravel(), np.stack([c.half for c in columns], 1).ravel())

    def __len__(self):
        return len(self._index)


def names_of(path):
    """Names of an expression: tables and maps of a result file, and a few functions."""
    names = dict(
        __builtins__={}, max=at(np.nanargmax), min=at(np.nanargmin), abs=abs, inf=math.inf, rows=len, row=lambda *x: joined(x), any=np.any,
        median=lambda *x: Measured(np.median(joined(x).values)), mean=lambda *x: Measured(np.mean(joined(x).values)),
        sd=lambda *x: Measured(np.std(joined(x).values, ddof=1)), sqrt=lambda x: Measured.of(x) ** 0.5,
        count=lambda x: int(np.sum(np.asarray(x, bool))), share=lambda x: float(np.mean(np.asarray(x, bool))),
        isinf=lambda x: np.isinf(Measured.of(x).values), samples=lambda name: opened(path, "samples", name),
        N_E=["sigma3_north", "sigma3_east"], NEV=["sigma3_north", "sigma3_east", "sigma3_vertical"],
        GAINS=["sigma3_gain_x", "sigma3_gain_y", "sigma3_gain_z"], BIASES=["sigma3_bias_x", "sigma3_bias_y", "sigma3_bias_z"],
        each=lambda text, *words: [text.format(w) for w in words], TESTS=["test 1", "test 2", "test 3", "test 4"])
    with storage.open_file(path) as file:
        for group in ("tables", "maps"):
            for name in file.get(group, {}):
                if isinstance(file[group][name], h5py.Group) or name not in names:
                    names[name] = functools.partial(select, path, group, name)
    return names


@functools.cache
def opened(path, group, name):
    """A table or samples as Rows; a map as (its name, axes, values)."""
    with storage.open_file(path) as file:
        data = file[group][name]
        if isinstance(data, h5py.Group):
            columns = {key: values_of(data[key]) for key in data if key != "row"}
            return Rows(name, columns, np.arange(len(next(iter(columns.values())))))
        return [(data.dims[i][0].name.rsplit("/", 1)[-1], values_of(data.dims[i][0])) for i in range(data.ndim)], data[()]


def values_of(data):
    return np.array(data.asstr()[()], object) if h5py.check_string_dtype(data.dtype) is not None else data[()]


def select(path, group, name, **wanted):
    """Rows of a table by values of columns, or values of a map by values of axes."""
    found = opened(path, group, name)
    if isinstance(found, Rows):
        return found(**wanted)
    axes, values = found
    chosen = [np.arange(len(axis)) for _, axis in axes]
    for key, value in wanted.items():
        i = next((i for i, (axis, _) in enumerate(axes) if key in (axis, axis.replace(".", "_"))), None)
        if i is None:
            raise Wrong(f"map {name} has no axis '{key}'; there are: {', '.join(a for a, _ in axes)}")
        choices = value if isinstance(value, (list, tuple)) else [value]
        chosen[i] = np.concatenate([np.flatnonzero(equal(axes[i][1], v)) for v in choices])
        if len(chosen[i]) == 0:
            raise Wrong(f"map {name} has no {key} = {value}")
    return Measured(values[np.ix_(*chosen)].ravel())


# Pages.

class Claim(NamedTuple):
    line: int
    quote: str
    relation: str
    expression: str
    small: float | None  # tolerance of the small run; None: from intervals
    full_only: bool
    nightly: bool  # the small run does not see an error of 5 %


class Tied(NamedTuple):
    """One entry of a claims file: a command and the numbers that are quoted from it."""
    line: int
    section: str
    command: list  # arguments of surveymc
    small: list | None
    lets: list  # names for parts of expressions: (line, name, expression)
    claims: list


CLAIM = re.compile(r"(?P<quote>.+?) (?P<relation>=|>=|<=) (?P<expression>\S.*?)(?: \[(?P<note>full|nightly|(?:nightly, )?small ± \S+)\])?")


def command_of(text, line):
    words = shlex.split(text)
    if words and re.fullmatch(r"configs/\S+\.toml", words[0]):
        words = ["surveymc", "run", *words]
    if len(words) < 3 or pathlib.Path(words[0]).name != "surveymc" or words[1] != "run":
        raise Wrong(f"{line}: '{text}': must be a config or 'surveymc run CONFIG …'")
    return words[1:]


def plain(text):
    """Text as a quote is looked for in it: no comments, no line breaks."""
    return re.sub(r"\s+", " ", re.sub(r"<!--.*?-->", " ", text, flags=re.S))


def sections(text):
    """Start and end of every section: from a heading to the next one of any level."""
    starts = [0]
    fenced = False
    for hit in re.finditer(r"^(```|#+ ).*$", text, re.M):
        fenced ^= hit[1] == "```"
        if not fenced and hit[1] != "```":
            starts.append(hit.start())
    return list(zip(starts, [*starts[1:], len(text)]))


def claims_file(page):
    """docs/claims/NAME.toml of docs/NAME.md and docs/FOLDER/NAME.md, and of README.md."""
    near = page.parent / "docs" if page.name == "README.md" else page.parent
    return (near if (near / "claims").is_dir() else near.parent) / "claims" / f"{page.stem}.toml"


def heading_of(section):
    return section.split("\n", 1)[0].lstrip("# ")


def read_claims(text, claims, says_command):
    """All that `claims`, the text of a claims file, ties to commands. Wrong, with the line, where it is not as it has to be.

    says_command: the page has to say the command, or name its config, up to the end of the section.
    """
    if "<!-- numbers of:" in text:
        raise Wrong("1: numbers are tied in docs/claims, no more in the page")
    try:
        entries = tomllib.loads(claims).get("numbers", [])
    except tomllib.TOMLDecodeError as error:
        raise Wrong(str(error)) from error
    starts = [m.start() for m in re.finditer(r"^\[\[numbers\]\]", claims, re.M)]
    found = []
    for entry, start in zip(entries, starts):
        line = claims.count("\n", 0, start) + 1
        if unknown := set(entry) - {"section", "of", "small", "held"}:
            raise Wrong(f"{line}: unknown key {', '.join(sorted(unknown))}")
        here = [(b, e) for b, e in sections(text) if heading_of(text[b:e]) == entry["section"]]
        if len(here) != 1:
            raise Wrong(f"{line}: the page has {len(here)} sections '{entry['section']}'")
        begin, end = here[0]
        seen = plain(text[begin:end])
        command, small, lets, found_claims = command_of(entry["of"], line), None, [], []
        if "small" in entry:
            small = command if entry["small"] == "the same" else command[:2] + shlex.split(entry["small"])
        first = claims.count("\n", 0, claims.index("held =", start)) + 2
        for number, raw in enumerate(entry["held"].split("\n"), first):
            raw = raw.strip()
            if not raw:
                continue
            if let := re.fullmatch(r"let (\w+) = (.+)", raw):
                lets.append((number, let[1], let[2]))
                continue
            claim = CLAIM.fullmatch(raw)
            if not claim:
                raise Wrong(f"{number}: '{raw}': must be QUOTE = EXPRESSION")
            quote = claim["quote"]
            if re.sub(r"\s+", " ", quote) not in seen:
                raise Wrong(f"{number}: '{quote}' does not stand in the text of the section")
            if not numbers_in(quote):
                raise Wrong(f"{number}: '{quote}' has no number")
            note = claim["note"] or ""
            found_claims.append(Claim(number, quote, claim["relation"], claim["expression"],
                                      float(note.split("± ")[1]) if "±" in note else None, note == "full", note.startswith("nightly")))
        if not found_claims:
            raise Wrong(f"{line}: no number")
        above, config = text[:end], pathlib.Path(command[1])
        named = len(command) == 2 and re.search(rf"(?<![\w.]){re.escape(config.stem)}(?!\w)", plain(above))
        if says_command and not named and command not in [words for _, words, _ in commands_shown(above)]:
            raise Wrong(f"{line}: the text does not say 'surveymc {shlex.join(command)}'")
        found.append(Tied(line, entry["section"], command, small, lets, found_claims))
    return found


def commands_shown(text):
    """(line, arguments or None if not whole) of every command `surveymc run` that a reader sees and that should run."""
    shown = []
    for hit in re.finditer(r"<!--.*?-->|```.*?```|`([^`]+)`", text, re.S):
        for part in re.finditer(r"(?:^|[\s/])(surveymc run[^\n`]*)|^(run \S+\.toml[^`]*)", hit[1] or "" if hit[1] else
                                (hit[0] if hit[0].startswith("```") else ""), re.M):
            line = text.count("\n", 0, hit.start()) + 1
            if part[2]:
                shown.append((line, None, part[2]))
                continue
            whole = re.sub(r"\s+", " ", hit[1][hit[1].index("surveymc run"):]) if hit[1] else part[1]
            words = shlex.split(whole)
            if len(words) == 3 and words[2] == "CONFIG":
                continue
            shown.append((line, words[1:] if len(words) > 2 and words[2].startswith("configs/") else None, whole))
    return shown


def not_tied(text, tied, not_run):
    """What a page whose numbers all are tied lacks: lines to print. `not_run`: the commands that need no number."""
    bad, known = [], [t.command for t in tied] + [command_of(command, 1) for command in not_run]
    for line, words, whole in commands_shown(text):
        if words is None:
            bad.append(f"{line}: `{whole}` is not whole: surveymc run configs/…")
        elif words not in known and len(words) > 2:
            bad.append(f"{line}: no number is tied to `{whole}` (or [not_run] with the reason)")
    return bad if tied else [*bad, "1: no number is tied"]


# Runs.

def config_hash(program, arguments):
    done = subprocess.run([program, "check", *arguments[1:]], cwd=SOURCE, capture_output=True, text=True)
    hit = re.search(r"config hash (\w+)", done.stdout)
    if done.returncode or not hit:
        raise Wrong(f"surveymc {shlex.join(['check', *arguments[1:]])}: {done.stderr.strip()}")
    return hit[1]


def result_of(program, arguments, folder):
    """The result file of a command: the kept one of the same program and config, or a new one; and its seconds."""
    stamp = os.stat(program)
    key = f"{config_hash(program, arguments)} {stamp.st_mtime_ns} {stamp.st_size}"
    path = pathlib.Path(folder) / (pathlib.Path(arguments[1]).stem + "-" + hashlib.sha256(key.encode()).hexdigest()[:12] + ".h5")
    if path.exists():
        return path, 0.0
    began = time.monotonic()
    done = subprocess.run([program, *arguments, "-o", str(path)], cwd=SOURCE, capture_output=True, text=True)
    if done.returncode:
        raise Wrong(f"surveymc {shlex.join(arguments)}: exit {done.returncode}\n{done.stderr.strip()[-1000:]}")
    return path, time.monotonic() - began


def widening(count):
    """Factor on a 95 % interval that `count` differences of two draws keep together with probability TOGETHER."""
    normal = statistics.NormalDist()
    return math.sqrt(2) * normal.inv_cdf(1 - (1 - TOGETHER) / 2 / max(count, 1)) / normal.inv_cdf(0.975)


WRONG_BY = 0.05  # an error that the small run has to see


def is_close(number, value, width):
    return abs(value - number.value) <= number.rounding * (1 + 1e-9) + width + 1e-9 * abs(number.value)


def is_blind(number, value, width):
    """True if the number would pass though it is wrong by 5 %, and not because of its rounding."""
    if math.isinf(number.value) or number.value == 0:
        return False
    others = [number._replace(value=number.value * (1 + sign * WRONG_BY)) for sign in (-1, 1)]
    hides = lambda other: any(is_close(other, around, 0) for around in (value, number.value))  # the rounding, without an interval
    return any(is_close(other, value, width) and not hides(other) for other in others)


def compare(claim, measured, factor, small):
    """(words on the numbers, what is wrong with them or "")."""
    quoted = numbers_in(claim.quote)
    if len(measured) != len(quoted):
        raise Wrong(f"'{claim.quote}' has {len(quoted)} numbers, the expression {len(measured)} values: "
                    + ", ".join(f"{v:.6g}" for v in measured.values[:12]))
    words, wrong = [], []
    for number, value, half in zip(quoted, measured.values, measured.half):
        own = small and claim.small is not None
        width = claim.small if own else factor * half
        slack = number.rounding * (1 + 1e-9) + width + 1e-9 * abs(number.value)
        word = f"{number.text}: {value:.5g}" + (f" ± {width:.2g}" if width else "")
        words.append(word)
        if claim.relation == "=":
            good = value == number.value if math.isinf(number.value) else is_close(number, value, width)
            if good and small and not claim.nightly and is_blind(number, value, width):
                wrong.append(f"{word}: would pass if it were wrong by 5 %: more trials in the small run, or [nightly]")
        elif claim.relation == ">=":
            good = value <= number.value + (slack - number.rounding)
        else:
            good = value >= number.value - (slack - number.rounding)
        if not good:  # NaN is never good
            wrong.append(word)
    return "; ".join(words), "; ".join(wrong)


def held_nightly(tied):
    """Lines that say which numbers the small runs do not hold: one a section."""
    found = {}
    for t in tied:
        for c in t.claims:
            if c.nightly or c.full_only or t.small is None:
                found.setdefault(t.section, []).extend(n.text.strip() for n in numbers_in(c.quote))
    return [f"{section}: {', '.join(numbers)}" for section, numbers in found.items()]


def value_of(expression, names, line):
    try:
        return eval(expression, names)
    except Wrong:
        raise
    except Exception as error:  # whatever an expression can do wrong
        raise Wrong(f"{line}: {expression}: {type(error).__name__}: {error}") from error


def tied_of(page, says_command):
    """(what is tied to commands, the commands of [not_run]) of a page, both empty without a claims file."""
    path = claims_file(page)
    claims = path.read_text() if path.exists() else ""
    tied = read_claims(page.read_text(), claims, says_command)
    return tied, tomllib.loads(claims).get("not_run", {})


def quoted_beside(page):
    """How many numbers the pages of a page's folder quote: they are judged together."""
    return sum(len(numbers_in(claim.quote)) for other in sorted(page.parent.glob("*.md")) for tied in tied_of(other, False)[0]
               for claim in tied.claims)


def check_page(program, page, options, folder):
    text, all_tied = page.read_text(), page.resolve().parent.name == ALL_TIED
    tied, not_run = tied_of(page, all_tied)
    bad = not_tied(text, tied, not_run) if all_tied else []
    if options.list:
        print("\n".join(f"{page.name}: {line}" for line in held_nightly(tied)))
        return False
    if options.syntax:
        for t in tied:
            config_hash(program, t.command)
            if t.small:
                config_hash(program, t.small)
    factor = widening(quoted_beside(page))
    count, commands, seconds = 0, set(), []
    for t in [] if options.syntax else tied:
        arguments = t.command if options.full else t.small
        claims = [c for c in t.claims if options.full or not c.full_only]
        if arguments is None or not claims or (options.only and options.only not in shlex.join(t.command)):
            continue
        if zlib.crc32(shlex.join(t.command).encode()) % options.sample:
            continue
        path, took = result_of(program, arguments, folder)
        names = names_of(path)
        commands.add(shlex.join(arguments))
        if took:
            seconds.append((took, shlex.join(arguments)))
        try:
            for line, name, expression in t.lets:
                names[name] = value_of(expression, names, line)
        except Wrong as error:
            bad.append(str(error))
            continue
        for claim in claims:
            try:
                value = joined(value_of(claim.expression, names, claim.line))
                words, wrong = compare(claim, value, factor, not options.full)
            except Wrong as error:
                words, wrong = "", str(error)
            count += len(numbers_in(claim.quote))
            if wrong:
                bad.append(f"{claim.line}: {wrong}    (surveymc {shlex.join(arguments)})")
            elif options.print:
                print(f"{page.name}:{claim.line}: {words}")
    if options.print:
        for took, command in sorted(seconds, reverse=True):
            print(f"{took:7.1f} s  surveymc {command}")
    print("\n".join(f"{page.name}:{b}" for b in bad) or
          f"{page.name}: {len(tied)} entries are well formed" if options.syntax or bad else
          f"{page.name}: {count} numbers of {len(commands)} commands, all within their intervals")
    return bool(bad)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0], epilog="The head of this file says how numbers are tied to commands.")
    parser.add_argument("surveymc")
    parser.add_argument("pages", nargs="*", type=pathlib.Path)
    parser.add_argument("--sample", type=int, default=1, metavar="N", help="run about one of N commands, always the same ones")
    parser.add_argument("--full", action="store_true", help="run the commands as they are quoted, instead of the small ones")
    parser.add_argument("--print", action="store_true", help="print every number with its measured value, and the times")
    parser.add_argument("--only", metavar="TEXT", help="only commands that have this in them")
    parser.add_argument("--keep", metavar="FOLDER", help="keep results there, and take those that are there")
    parser.add_argument("--syntax", action="store_true", help="read the claims and check the configs; run nothing")
    parser.add_argument("--list", action="store_true", help="print the numbers that are held only nightly, and run nothing")
    options = parser.parse_args()
    program = os.path.abspath(options.surveymc)
    bad = False
    with tempfile.TemporaryDirectory(prefix="surveymc-docs-") as temporary:
        folder = pathlib.Path(options.keep or temporary)
        folder.mkdir(parents=True, exist_ok=True)
        for stray in set((SOURCE / "docs/claims").glob("*.toml")) - {claims_file(page) for page in PAGES}:
            print(f"{stray.name}: there is no such page")
            bad = True
        for page in options.pages or PAGES:
            try:
                bad |= check_page(program, page, options, folder.resolve())
            except Wrong as error:
                print(f"{page.name}:{error}")
                bad = True
    return bad


if __name__ == "__main__":
    streams.run(main)
