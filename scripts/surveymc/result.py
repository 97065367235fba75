"""A result file of surveymc as Python objects. docs/results-format.md describes the file."""

import collections.abc
import contextlib
import os
import re
import tomllib
import warnings

import h5py
import numpy as np

from . import storage
from .arguments import nearest
from .ellipse import Ellipse
from .storage import ResultError
from .storage import plain as _python

MAY_BE_CHANCE = "may be chance"  # of column `family`
_MOST_TOLD = 10  # warnings of one result
_told = set()    # content hashes of results whose warnings were given to Python
VERDICTS = ("agrees", "finding", "undecided", "differs")
EITHER = "either"  # of column `expected`: an approximation, or what others say
_ATTRIBUTES = {  # of the root group: name here, name there
    "title": "title", "experiment": "experiment", "seed": "seed", "trials": "trials", "version": "surveymc_version",
    "revision": "git_revision", "compiler": "compiler", "command": "command", "config": "config",
    "config_hash": "config_hash", "content_hash": "content_hash"}


class ResultWarning(UserWarning):
    """What the program doubts in the input of a result, or in its numbers: the table `warnings`."""


class NotFound(ResultError, KeyError):
    """There is no such table, map, column or row; the message lists what there is."""

    __str__ = Exception.__str__  # KeyError would print the repr


def not_found(what, name, names, where):
    names = [str(n) for n in names]
    near = nearest(name, names)
    hint = f" (did you mean '{near}'?)" if near else ""
    return NotFound(f"{where}: no {what} '{name}'{hint}; there are: {', '.join(names) or 'none'}")


def _values(data):
    return data.asstr()[()] if h5py.check_string_dtype(data.dtype) is not None else data[()]


class _Collection(collections.abc.Mapping):
    """The tables (or maps, ...) of a result by name; each is read when asked for."""

    def __init__(self, names, read):
        self._names, self._read = names, read

    def __getitem__(self, name):
        return self._read(name)

    def __contains__(self, name):
        return name in self._names

    def __iter__(self):
        return iter(self._names)

    def __len__(self):
        return len(self._names)

    def __repr__(self):
        return f"<{', '.join(self._names) or 'none'}>"


class Result:
    """What a run of surveymc wrote.

    title, experiment, config (resolved TOML, whole), version, revision, compiler, command, config_hash, content_hash: str
    seed, trials (of each sweep point; 0 where nothing is drawn): int
    settings: the config as nested dicts; run: when, where and how long it ran
    tables, maps, samples, inputs: mappings from name to data, read when asked for
    """

    def __init__(self, path):
        self.path = os.fspath(path)
        with self._file() as file:
            for name, stored in _ATTRIBUTES.items():
                if stored not in file.attrs:
                    raise ResultError(f"{self.path}: attribute '{stored}' is missing")
                setattr(self, name, _python(file.attrs[stored]))
            self.run = {k: _python(v) for k, v in file["run"].attrs.items()} if "run" in file else {}
            groups = {g: list(file[g]) if g in file else [] for g in ("tables", "samples", "inputs")}
            maps = [k for k, d in file.get("maps", {}).items() if not h5py.h5ds.is_scale(d.id)]
        self.tables = _Collection(groups["tables"], self.table)
        self.samples = _Collection(groups["samples"], lambda name: self._frame("samples", name))
        self.inputs = _Collection(groups["inputs"], lambda name: self._frame("inputs", name))
        self.maps = _Collection(maps, self.map)

    def __repr__(self):
        return (f"<surveymc result '{self.title or self.path}': {self.experiment}, seed {self.seed}, {self.trials} trials; "
                f"tables {', '.join(self.tables) or 'none'}; maps {', '.join(self.maps) or 'none'}>")

    @contextlib.contextmanager
    def _file(self):
        """The open file; ResultError where what is read from it shows that it is damaged."""
        with storage.open_file(self.path) as file:
            try:
                yield file
            except ResultError:
                raise
            except storage.DAMAGE as error:
                raise ResultError(f"{self.path}: is damaged: {' '.join(str(error).split())}") from None

    @property
    def settings(self):
        """The resolved config as nested dicts."""
        try:
            return tomllib.loads(self.config)
        except (ValueError, RecursionError) as error:
            raise ResultError(f"{self.path}: is damaged: its config is not TOML: {error}") from None

    @property
    def answer(self):
        """What the run has found, as a list of sentences; empty in a result of an older program."""
        if "answer" not in self.tables:
            return []
        with self._file() as file:
            return list(_values(file["tables"]["answer"]["sentence"]))

    @property
    def warnings(self):
        """What to know before the numbers are used, as a list of dicts: severity ("severe", "warning", "info"), place, value,
        message, way_out, points, at. Empty if nothing is doubtful."""
        if "warnings" not in self.tables:
            return []
        with self._file() as file:
            columns = {k: [_python(v) for v in _values(d)] for k, d in file["tables/warnings"].items() if k != "row"}
        return [dict(zip(columns, row)) for row in zip(*columns.values())]

    def warn(self, stacklevel=2):
        """Gives its warnings to Python's `warnings`, those that only inform left out: one ResultWarning, once for a result of
        these contents."""
        said = [warning_in_words(w) for w in self.warnings if w["severity"] != "info"]
        if not said or self.content_hash in _told:
            return
        _told.add(self.content_hash)
        more = [f"and {len(said) - _MOST_TOLD} more: Result.warnings"] if len(said) > _MOST_TOLD else []
        warnings.warn("\n  ".join([f"{self.title or self.path}: {len(said)} warning{'s' * (len(said) > 1)}:",
                                   *said[:_MOST_TOLD], *more]), ResultWarning, stacklevel + 1)

    @property
    def verdicts(self):
        """How many rows of all tables have which verdict: {"agrees", "finding", "undecided", "differs",
        "unexpected"}. A "finding" is a row that differs and may: of an approximation, or known to be wrong; "unexpected" is what `surveymc run --check`
        fails on: rows whose verdict is not the one that the config expects."""
        counts = dict.fromkeys((*VERDICTS, "unexpected"), 0)
        with self._file() as file:
            for table in file.get("tables", {}).values():
                if "verdict" in table:
                    expected, family = (_values(table[c]) if c in table else [""] * len(table["verdict"])
                                        for c in ("expected", "family"))
                    for got, wanted, together in zip(_values(table["verdict"]), expected, family):
                        kind = verdict_kind(got, wanted)
                        if kind:
                            counts[kind] += 1
                        counts["unexpected"] += is_unexpected(got, wanted, together)
        return counts

    @property
    def family(self):
        """The p-values of all rows and tests that are judged as a family (family_rows, test_rows), as a list; empty where the
        config asks for none."""
        found = []
        if self.settings.get("verdict", {}).get("family") == "none":
            return found
        with self._file() as file:
            for table in file.get("tables", {}).values():
                for judged, column in (({"verdict", "p_differs", "p_agrees", "family"}, "p_differs"),
                                       ({"wishart_p", "wishart_family"}, "wishart_p")):
                    if judged <= set(table):
                        columns = [_values(table[c]) if c in table else None for c in (column, "verdict", "expected")]
                        found += [float(p) for i, p in enumerate(columns[0]) if p == p
                                  and (column == "wishart_p" or columns[1][i]) and (columns[2] is None or columns[2][i] != "differs")]
        return found

    def table(self, name):
        """Table `name` as pandas.DataFrame, columns in the order of the file. Its attrs:

        name, long_name; sweep_keys: the columns that say which sweep point; units {column: unit} of the columns that
        have one; descriptions {column: text}; intervals {column: (low column, high column)}; confidence of the
        intervals (0.95), NaN if the file does not say.
        """
        return self._frame("tables", name)

    def _frame(self, group, name):
        import pandas  # here: attributes can be had without waiting for it

        with self._file() as file:
            if name not in file.get(group, {}):
                raise not_found(group.rstrip("s"), name, file.get(group, {}), self.path)
            stored = file[group][name]
            columns = {k: d for k, d in stored.items() if k != "row"}
            frame = pandas.DataFrame({k: _values(d) for k, d in columns.items()})
            long_name = _python(stored.attrs.get("long_name", ""))
            found = re.search(r"intervals at (?:all looks at )?([\d.]+) %$", long_name)
            frame.attrs = {
                "name": name, "long_name": long_name,
                "sweep_keys": [k for k, d in columns.items() if _python(d.attrs.get("long_name", "")) == "sweep key"],
                "units": {k: _python(d.attrs["units"]) for k, d in columns.items() if "units" in d.attrs},
                "descriptions": {k: _python(d.attrs.get("long_name", "")) for k, d in columns.items()},
                "intervals": {k: (f"{k}_ci_low", f"{k}_ci_high") for k in columns if f"{k}_ci_low" in columns},
                "confidence": float(found[1]) / 100 if found else float("nan")}
        return frame

    def map(self, name):
        """Map `name` as xarray.DataArray with its coordinates; `attrs` has units and long_name. Infinity is inf."""
        import xarray

        with self._file() as file:
            if name not in self.maps:
                raise not_found("map", name, self.maps, self.path)
            data = file["maps"][name]
            dimensions, coordinates = [], {}
            for axis, dimension in enumerate(data.dims):
                if len(dimension) == 0:
                    raise ResultError(f"{self.path}: axis {axis} of map '{name}' has no values")
                scale = dimension[0]
                dimension_name = os.path.basename(scale.name)
                dimensions.append(dimension_name)
                coordinates[dimension_name] = (dimension_name, _values(scale), _described(scale))
            return xarray.DataArray(data[()], dims=dimensions, coords=coordinates, name=name, attrs=_described(data))

    def ellipse(self, propagation="monte_carlo", table="ellipse", at=None, **point):
        """The horizontal one-sigma ellipse of one row of `table`.

        propagation: "monte_carlo", or the analytic prediction ("joint", "systematic", ...: column `formulation`).
        The sweep point by keyword, columns with a dot by their last or first part or with an underscore (estimator="msa"
        is `estimator.name`), or whole: at={"noise.scale": 0.1}. Columns with one value need not be given.
        `table` may be any with the columns semi_major_m, semi_minor_m and major_azimuth_deg: that named "covariance" of
        position_covariance, with md_m= the station. NotFound, with what there is, unless exactly one row remains.
        """
        frame = self.table(table)
        missing = {"semi_major_m", "semi_minor_m", "major_azimuth_deg"} - set(frame.columns)
        if missing:
            raise ResultError(f"{self.path}: table '{table}' has no ellipses: no column {', '.join(sorted(missing))}")
        wanted = {self._column(frame, k): v for k, v in point.items()} | dict(at or {})
        if "formulation" in frame:
            wanted.setdefault("formulation", propagation)
        for column, value in wanted.items():
            if column not in frame:
                raise not_found(f"column of table '{table}'", column, frame.columns, self.path)
            number = isinstance(value, (int, float)) and frame[column].dtype != object
            keep = np.isclose(frame[column].astype(float), value, rtol=1e-9, atol=0) if number else frame[column] == value
            if not keep.any():
                raise not_found(f"row of table '{table}' with {column} =", value, frame[column].unique(), self.path)
            frame = frame[keep]
        if len(frame) > 1:
            keys = [*frame.attrs["sweep_keys"], "md_m", "formulation"]
            open_keys = [k for k in keys if k in frame and frame[k].nunique() > 1]
            choice = "; ".join(f"{k}: {', '.join(str(v) for v in frame[k].unique()[:12])}" for k in open_keys)
            raise NotFound(f"{self.path}: {len(frame)} rows of table '{table}' fit; choose by {choice}")
        row = frame.iloc[0].to_dict()
        return Ellipse(row.get("center_north_m", 0.0), row.get("center_east_m", 0.0), row["semi_major_m"],
                       row["semi_minor_m"], row["major_azimuth_deg"], row)

    def _column(self, frame, word):
        """The column a keyword means: whole, dots as underscores, or one part of a dotted name that only one has."""
        if word in frame:
            return word
        for part in (lambda c: c.replace(".", "_"), lambda c: c.split(".")[0], lambda c: c.split(".")[-1]):
            found = [c for c in frame.columns if "." in c and part(c) == word]
            if len(found) == 1:
                return found[0]
        raise not_found("column", word, frame.columns, self.path)


def warning_in_words(row):
    """A row of Result.warnings in one line: "warning: survey.csv:5: azimuth_deg = 400: must be in [0, 360]"."""
    place, value = row.get("place", ""), row.get("value", "")
    if value:
        place = f"{place}{' = ' if place and ' = ' not in value else ': ' if place else ''}{value}"
    way_out, points, at = row.get("way_out", ""), int(row.get("points", 1)), row.get("at", "")
    where = f" ({points} points, the first: {at})" if points > 1 else f" (at {at})" if at else ""
    return ": ".join(filter(None, [row["severity"], place, row["message"]])) + (f"; {way_out}" if way_out else "") + where


def _described(data):
    return {k: _python(data.attrs[k]) for k in ("units", "long_name") if k in data.attrs}


def is_unexpected(verdict, expected, family=""):
    """Whether a row is "not as expected", by the rule of the program and the report: its verdict is not the one that the
    config expects, or undecided, or missing. A row that differs but "may be chance" in its family does not count."""
    return expected not in ("", EITHER) and verdict != expected and not (verdict == "differs" and family == MAY_BE_CHANCE)


def holm(p, level=0.05):
    """Which hypotheses with these p-values Holm's procedure rejects, as a list of bool: the k-th smallest of n is compared
    with level / (n - k + 1), until one is larger. The probability of any false rejection is at most `level`."""
    order = sorted(range(len(p)), key=lambda i: p[i])
    rejected = [False] * len(p)
    for k, i in enumerate(order):
        if not p[i] <= level / (len(p) - k):
            break
        rejected[i] = True
    return rejected


def agreement_share(p, accepted):
    """The share of wrong ones to be expected among those of p that are at most `accepted` (Benjamini and Hochberg 1995): q
    of the last of them; 0 where there is none."""
    rising = sorted(p)
    last = sum(x <= accepted for x in rising)
    return min([1.0, *(len(p) * rising[i] / (i + 1) for i in range(last - 1, len(rising)))]) if last else 0.0


def family_rows(frame):
    """The rows of a table (Result.table) that are judged as a family, as in the program: those with a verdict and a
    p-value that are not expected to differ. Empty for a table without p-values."""
    if not {"verdict", "p_differs", "p_agrees", "family"} <= set(frame.columns):
        return frame.iloc[:0]
    asked = frame["expected"] == "differs" if "expected" in frame else False
    return frame[(frame["verdict"] != "") & frame["p_differs"].notna() & ~asked]


def test_rows(frame):
    """The rows of a table whose Wishart test joins the family: those with a wishart_p that are not expected to differ."""
    if not {"wishart_p", "wishart_family"} <= set(frame.columns):
        return frame.iloc[:0]
    asked = frame["expected"] == "differs" if "expected" in frame else False
    return frame[frame["wishart_p"].notna() & ~asked]


def holm_limit(p, level=0.05):
    """The largest p-value that Holm's procedure rejects; -1 where it rejects none."""
    return max([x for x, rejected in zip(p, holm(p, level)) if rejected], default=-1.0)


def verdict_kind(verdict, expected=""):
    """One of VERDICTS, or "" for a row without a verdict."""
    if verdict == "differs":
        return "finding" if expected in ("differs", EITHER) else "differs"
    return verdict
