"""Tables of result files for the page: comparisons with their verdicts first, long ones folded."""

import dataclasses
import math

from ..result import MAY_BE_CHANCE, VERDICTS, is_unexpected, verdict_kind
from .text import grouped, interval, number, prose, unit

OPEN_ROWS = 14  # a table with more is folded
MOST_ROWS = 150  # a table with more is shortened; the whole is a command away
PAPER_COLUMNS = 9  # a table with more is not printed but named, with its counts: no paper is wide enough for it
# said in another column, in words or in the caption
MERGED = ("expected", "trials", "failed", "p_differs", "p_agrees", "trials_to_decide", "family", "wishart_family")


def _is_number(column):
    return column.dtype != object


def _nothing(column):
    """Whether a column has no entry."""
    return bool(column.isna().all()) if _is_number(column) else bool((column == "").all())


def _shortened(frame):
    """At most MOST_ROWS rows, in their order: those not as expected, then those with published values, then the first."""
    if len(frame) <= MOST_ROWS:
        return frame, ""
    rank = [2] * len(frame)
    if "published" in frame and _is_number(frame["published"]):
        rank = [1 if math.isfinite(p) else 2 for p in frame["published"]]
    if "verdict" in frame and "expected" in frame:
        rank = [0 if is_unexpected(v, e, f) else r
                for r, v, e, f in zip(rank, frame["verdict"], frame["expected"], _family(frame))]
    chosen = sorted(sorted(range(len(frame)), key=lambda i: (rank[i], i))[:MOST_ROWS])
    first = "those not as expected, then those with published values, then the first" if min(rank) < 2 else "the first"
    shown = frame.iloc[chosen]
    shown.attrs = frame.attrs
    return shown, f"{grouped(MOST_ROWS)} of {grouped(len(frame))} rows are shown: {first}."


def _family(frame):
    return frame["family"] if "family" in frame else [""] * len(frame)


def _kind(verdict, expected, family):
    """The kind of a row's verdict; one that differs may be chance in its family."""
    kind = verdict_kind(verdict, expected)
    return MAY_BE_CHANCE if kind == "differs" and family == MAY_BE_CHANCE else kind


def _unexpected(frame, got, wanted, family):
    """Whether a row is not as expected. Rows that are not decided say nothing against a config if the run had other trials than
    the config has (attrs["own_trials"], set by page.result_part)."""
    waits = got in ("", "undecided") and not frame.attrs.get("own_trials", True)
    return is_unexpected(got, wanted, family) and not waits


def no_counts():
    return dict.fromkeys((*VERDICTS, MAY_BE_CHANCE, "unexpected", "unexpected_undecided", "waiting"), 0)


def counts_of(frame):
    """Verdict counts of one table, as Result.verdicts has them of all, but with rows that may be chance apart,
    "unexpected_undecided": how many of the unexpected ones are undecided, and "waiting": how many would be unexpected, but
    are not decided by other trials than the config's."""
    counts = no_counts()
    expected = frame["expected"] if "expected" in frame else [""] * len(frame)
    for got, wanted, family in zip(frame["verdict"], expected, _family(frame)):
        kind = _kind(got, wanted, family)
        if kind in counts:
            counts[kind] += 1
        odd = _unexpected(frame, got, wanted, family)
        counts["unexpected"] += odd
        counts["unexpected_undecided"] += got == "undecided" and odd
        counts["waiting"] += is_unexpected(got, wanted, family) and not odd
    return counts


def _ratio_bar(value, low, high, margin):
    """A ratio and its interval on a logarithmic scale from 1/2 to 2, the band that counts as agreement behind it."""
    def place(x):
        return 50 + 50 * max(-1.0, min(1.0, math.log2(x))) if x > 0 else 0.0

    if not math.isfinite(value) or value <= 0:
        return ""
    low, high = (low, high) if math.isfinite(low) and math.isfinite(high) else (value, value)
    style = (f"--l:{place(low):.1f}%;--w:{place(high) - place(low):.1f}%;--v:{place(value):.1f}%;"
             f"--a:{place(1 - margin):.1f}%;--b:{place(1 + margin):.1f}%")
    return style


@dataclasses.dataclass
class Cell:
    """kind: "verdict" (text: one of VERDICT_MARKS, or what the file says), "number", "head" (of the row), "text"; bounds: of the
    interval; ratio: style of the small scale beside it; alarm: the verdict is not as expected."""

    kind: str
    text: str
    unit: str = ""
    bounds: str = ""
    ratio: str = ""
    alarm: bool = False


@dataclasses.dataclass
class Head:
    name: str
    unit: str
    title: str
    style: str


@dataclasses.dataclass
class Row:
    cells: list
    unexpected: bool


@dataclasses.dataclass
class Table:
    """What the template table.html shows."""

    name: str
    caption: str
    heads: list
    rows: list
    counts: dict | None
    size: str  # "12 rows"
    folded: bool
    wide: bool  # too wide for paper
    shortened: str
    command: str  # that prints all of it


class _Columns:
    """Which columns of a table are shown, and how each of its cells is written."""

    def __init__(self, frame, margin):
        self.frame, self.margin = frame, margin
        self.units, self.intervals = frame.attrs["units"], frame.attrs["intervals"]
        bounds = {c for pair in self.intervals.values() for c in pair}
        self.constant = [k for k in frame.attrs["sweep_keys"] if len(frame) > 1 and frame[k].nunique() == 1]
        left_out = {*bounds, *MERGED, *self.constant, "unit" if "quantity" in frame else ""}
        self.shown = [c for c in frame if c not in left_out and not (_nothing(frame[c]) and c != "verdict")]
        if "verdict" in self.shown:  # last, where the style keeps it in sight while the others scroll
            self.shown.remove("verdict")
            self.shown.append("verdict")
        self.numbers = {c for c in self.shown if _is_number(frame[c])}

    def head(self, column):
        found = unit(self.units.get(column, ""))
        stem = column
        for ending in ("_deg", "_m2", "_m", "_nT", "_mps2", "_h", "_z"):  # the unit stands beside the name
            if found and column.endswith(ending):
                stem = column[: -len(ending)]
        names = {"monte_carlo": "Monte Carlo", "published_ratio": "published / Monte Carlo",
                 "ratio": "analytic / Monte Carlo"} if "monte_carlo" in self.frame else {}
        return Head(names.get(column, stem.replace("_", " ")), found, self.frame.attrs["descriptions"].get(column, ""),
                    "n" if column in self.numbers else "v" if column == "verdict" else "")

    def cell(self, row, column, unexpected):
        value = row[column]
        if column == "verdict":
            return Cell("verdict", _kind(value, row.get("expected", ""), row.get("family", "")), alarm=unexpected)
        if column not in self.numbers:
            of = row.get("unit", "1") if column == "quantity" else ""
            return Cell("head" if column == "quantity" else "text", str(value), unit(of))
        value = value.item()
        if column not in self.intervals:
            return Cell("number", number(value))
        low, high = (row[c].item() for c in self.intervals[column])
        text, bounds = interval(value, low, high)
        return Cell("number", text, bounds=bounds, ratio=_ratio_bar(value, low, high, self.margin) if column == "ratio" else "")


def _caption(frame, columns):
    text = frame.attrs["long_name"] or frame.attrs["name"]
    parts = [text[:1].upper() + text[1:] + "."]
    if columns.constant:
        parts.append("Everywhere here: " + ", ".join(f"{k} = {frame[k].iloc[0]}" for k in columns.constant) + ".")
    if "trials" in frame and len(frame):
        trials, failed = frame["trials"].unique(), frame["failed"].sum() if "failed" in frame else 0
        if len(trials) == 1:
            parts.append(f"{grouped(int(trials[0]))} trials a row"
                         + (", none failed." if not failed else ", some failed: see `failed` in the file."))
    return prose(" ".join(parts))


def table(frame, margin=0.0, command="", fold=False):
    """One table for the page, folded if it is long or `fold` is set.

    margin: what a ratio may differ from 1 and agree (0: not drawn); command: how to see all of it.
    """
    shown, shortened = _shortened(frame)
    columns = _Columns(shown, margin)
    data = [shown[c].to_numpy() for c in shown]
    rows = []
    for i in range(len(shown)):
        row = {c: values[i] for c, values in zip(shown, data)}
        unexpected = "verdict" in row and _unexpected(shown, row["verdict"], row.get("expected", ""), row.get("family", ""))
        rows.append(Row([columns.cell(row, c, unexpected) for c in columns.shown], unexpected))
    folded = fold or len(frame) > OPEN_ROWS
    return Table(frame.attrs["name"], _caption(frame, columns), [columns.head(c) for c in columns.shown], rows,
                 counts_of(frame) if "verdict" in frame else None, f"{grouped(len(frame))} row{'s' if len(frame) != 1 else ''}",
                 folded, not folded and len(columns.shown) > PAPER_COLUMNS, shortened, command)
