"""Tables of result files as HTML: comparisons with their verdicts first, long ones folded."""

import math

from ..result import MAY_BE_CHANCE, VERDICTS, is_unexpected, verdict_kind
from .text import counts_marks, escape, grouped, interval, number, unit, verdict

OPEN_ROWS = 14  # a table with more is folded
MOST_ROWS = 150  # a table with more is shortened; the whole is a command away
PAPER_COLUMNS = 13  # a table with more is not printed but named, with its counts: no paper is wide enough for it
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
    return f'<span class="ratio" aria-hidden="true" style="{style}"></span>'


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

    def head(self, column):
        found = unit(self.units.get(column, ""))
        stem = column
        for ending in ("_deg", "_m2", "_m", "_nT", "_mps2", "_h", "_z"):  # the unit stands beside the name
            if found and column.endswith(ending):
                stem = column[: -len(ending)]
        title = escape(self.frame.attrs["descriptions"].get(column, ""))
        names = {"monte_carlo": "Monte Carlo", "published_ratio": "published / Monte Carlo",
                 "ratio": "analytic / Monte Carlo"} if "monte_carlo" in self.frame else {}
        name = names.get(column, stem.replace("_", " "))
        number_class = ' class="n"' if _is_number(self.frame[column]) else ' class="v"' if column == "verdict" else ""
        return (f'<th scope="col"{number_class} title="{title}">{escape(name)}'
                + (f' <span class="unit">({escape(found)})</span>' if found else "") + "</th>")

    def cell(self, row, column):
        value = row[column]
        if column == "verdict":
            wanted = row.get("expected", "")
            together = row.get("family", "")
            return f'<td class="v">{verdict(_kind(value, wanted, together), _unexpected(self.frame, value, wanted, together))}</td>'
        if not _is_number(self.frame[column]):
            if column == "quantity" and row.get("unit", "1") not in ("1", ""):
                return f'<th scope="row">{escape(value)} <span class="unit">({escape(unit(row["unit"]))})</span></th>'
            tag = 'th scope="row"' if column == "quantity" else "td"
            return f'<{tag}{" class=note" if len(str(value)) > 40 else ""}>{escape(value)}</{tag[:2]}>'
        value = value.item()
        if column not in self.intervals:
            return f'<td class="n">{number(value)}</td>'
        low, high = (row[c].item() for c in self.intervals[column])
        text, bounds = interval(value, low, high)
        bounds = f' <span class="ci">{bounds}</span>' if bounds else ""
        bar = _ratio_bar(value, low, high, self.margin) if column == "ratio" else ""
        return f'<td class="n">{text}{bounds}{bar}</td>'


def _caption(frame, columns):
    text = frame.attrs["long_name"] or frame.attrs["name"]
    parts = [escape(text[:1].upper() + text[1:]) + "."]
    if columns.constant:
        parts.append("Everywhere here: " + ", ".join(
            f"{escape(k)} = {escape(frame[k].iloc[0])}" for k in columns.constant) + ".")
    if "trials" in frame and len(frame):
        trials, failed = frame["trials"].unique(), frame["failed"].sum() if "failed" in frame else 0
        if len(trials) == 1:
            parts.append(f"{grouped(int(trials[0]))} trials a row"
                         + (", none failed." if not failed else ", some failed: see <code>failed</code> in the file."))
    return " ".join(parts)


def table(frame, margin=0.0, command="", fold=False):
    """One table as HTML, folded if it is long or `fold` is set.

    margin: what a ratio may differ from 1 and agree (0: not drawn); command: how to see all of it.
    """
    name = frame.attrs["name"]
    counts = counts_of(frame) if "verdict" in frame else None
    shown, shortened = _shortened(frame)
    columns = _Columns(shown, margin)
    head = "".join(columns.head(c) for c in columns.shown)
    rows = []
    for i in range(len(shown)):
        row = {c: shown[c].iat[i] for c in shown}
        unexpected = _unexpected(shown, row.get("verdict", ""), row.get("expected", ""), row.get("family", ""))
        rows.append(f"<tr{' class=unexpected' if unexpected else ''}>" + "".join(columns.cell(row, c) for c in columns.shown)
                    + "</tr>")
    note = f'<p class="small">{shortened} All: <code>{escape(command)}</code></p>' if shortened else ""
    body = (f'<div class="scroll" tabindex="0" role="region" aria-label="Table {escape(name)}"><table><caption>'
            f'{_caption(frame, columns)}</caption><thead><tr>{head}</tr></thead><tbody>{"".join(rows)}</tbody></table></div>{note}')
    title = f'<code>{escape(name)}</code>'
    marks = counts_marks(counts) if counts else ""
    rows_text = f"{grouped(len(frame))} row{'s' if len(frame) != 1 else ''}"
    if not fold and len(frame) <= OPEN_ROWS:
        wide = len(columns.shown) > PAPER_COLUMNS
        on_paper = f' <span class="paper rows">{rows_text}, too wide for paper</span> <span class="paper">{marks}</span>' if wide else ""
        return f'<div class="table{" wide" if wide else ""}"><p class="tablename">{title}{on_paper}</p>{body}</div>'
    return f'<details class="table"><summary>{title} <span class="rows">{rows_text}</span> {marks}</summary>{body}</details>'
