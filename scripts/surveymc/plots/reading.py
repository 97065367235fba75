"""What drawers read: result files, their tables, the points of a sweep."""

import math
import os
import re
import sys
import tomllib

import h5py
import numpy as np

from .. import storage, streams
from ..arguments import USAGE


BAD_DATA = 65  # exit code, as for the program itself
ZERO_TO_FIRST_ORDER = 1e-3  # a ratio below this: the theory predicts nothing, whatever rounding left in it


class PlotError(streams.Failure):
    """The data cannot be plotted; the message is one line and says place and rule."""

    def __init__(self, message, code=BAD_DATA):
        super().__init__(message, code)


class Saved:
    """What this process has saved, for those that run a script within it, and of which results the figures are."""

    paths = []
    kept = []  # what was there before, as messages
    results = []  # experiment and title of each that was opened


class Table(dict):
    """Columns by name: numbers are numpy arrays, words are lists of str. All have the same length, `rows`.

    `confidence` is that of the table's intervals, from the end of its long name ("..., intervals at 95 %").
    """

    def __init__(self, name, columns, long_name=""):
        super().__init__(columns)
        self.name, self.long_name = name, long_name
        found = re.search(r"intervals at (?:all looks at )?([\d.]+) %$", long_name)
        self.confidence = float(found[1]) / 100 if found else math.nan
        self.rows = len(next(iter(columns.values()))) if columns else 0

    def __missing__(self, key):
        raise PlotError(f"table '{self.name}' has no column '{key}'")

    def where(self, keep):
        """The rows for which keep(i) is true."""
        rows = [i for i in range(self.rows) if keep(i)]
        return Table(self.name, {k: [v[i] for i in rows] if isinstance(v, list) else v[rows] for k, v in self.items()},
                     self.long_name)

    def row(self, **wanted):
        """The first row with these values, as a dict of scalars; None if there is none."""
        for i in range(self.rows):
            if all(self[k][i] == v for k, v in wanted.items()):
                return {k: v[i] for k, v in self.items()}
        return None


def open_result(path, experiment):
    """Opens a result file for reading; it must be of this experiment, or of one of these. Use it in a `with` statement."""
    allowed = (experiment,) if isinstance(experiment, str) else experiment
    file = open_any(path)
    found = text_attribute(file, "experiment")
    if found not in allowed:
        file.close()
        raise PlotError(f"{path}: is a result of experiment '{found}', not of {' or '.join(map(repr, allowed))}")
    return file


def open_any(path):
    """Opens a result file of any experiment."""
    try:
        file = storage.open_file(path)
    except storage.ResultError as error:
        raise PlotError(str(error)) from None
    Saved.results.append(f"{text_attribute(file, 'experiment')}: {text_attribute(file, 'title')}")
    return file


def text_attribute(item, name, default=""):
    """An attribute as str, whichever way HDF5 stored it."""
    try:
        return str(storage.plain(item.attrs.get(name, default)))
    except storage.DAMAGE as error:
        raise PlotError(f"{item.file.filename}: cannot read attribute '{name}': {error}") from None


def configuration(file):
    """The resolved config of the run, as nested dicts."""
    try:
        return tomllib.loads(text_attribute(file, "config"))
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise PlotError(f"{file.filename}: the stored config is not TOML: {error}") from None


def read_table(file, name, group="tables"):
    """Table /<group>/<name>; None if the file does not have it."""
    path = f"{group}/{name}"
    if path not in file:
        return None
    columns = {}
    try:
        for key, data in file[path].items():
            if h5py.check_string_dtype(data.dtype) is not None:
                columns[key] = list(data.asstr()[()])
            else:
                columns[key] = data[()]
    except storage.DAMAGE as error:
        raise PlotError(f"{file.filename}: cannot read {path}: {error}") from None
    if len({len(c) for c in columns.values()}) > 1:
        raise PlotError(f"{file.filename}: the columns of {path} differ in length")
    return Table(name, columns, text_attribute(file[path], "long_name"))


def sweep_keys(config, table):
    """The columns of `table` that the sweep of the config adds, in the order of the config."""
    return [k for k in config.get("sweep", {}) if k in table]


def sweep_points(table, keys):
    """The different values of the sweep columns, a tuple each, in the order of the file. [()] without a sweep."""
    points = {}
    for i in range(table.rows):
        points[tuple(table[k][i] for k in keys)] = None
    return list(points)


def checked_point(number, points, path):
    """The number of a sweep point; PlotError if there is no such point."""
    if not 0 <= number < len(points):
        raise PlotError(f"--point {number}: {path} has points 0 to {len(points) - 1}", USAGE)
    return number


def chosen_point(arguments, points):
    """The index given with --point, or None; PlotError if the sweep has no such point."""
    return None if arguments.point is None else checked_point(arguments.point, points, arguments.result)


def at_point(table, keys, point):
    """The rows of one sweep point; a missing table stays None."""
    if table is None:
        return None
    return table.where(lambda i: all(table[k][i] == v for k, v in zip(keys, point)))


def map_point(file, data, inner, number):
    """Where sweep point `number` of a map is: (index of its leading axes, keys of the sweep, their values, how many points).

    inner: how many axes of the map are its own; PlotError if there is no such point.
    """
    outer = data.shape[:data.ndim - inner]
    count = int(np.prod(outer, dtype=int))
    if not 0 <= number < count:
        raise PlotError(f"--point {number}: {file.filename} has points 0 to {count - 1}", USAGE)
    index = tuple(int(i) for i in np.unravel_index(number, outer)) if outer else ()
    names = [os.path.basename(dim[0].name) for dim in list(data.dims)[:len(outer)]]
    listed = read_table(file, "sweep_points") if names == ["point"] else None
    if listed is not None:  # points that are no product: a table has the keys of each
        keys = [k for k in listed if k != "point"]
        return index, keys, [listed[k][number] for k in keys], count
    return index, names, [storage.plain(dim[0][i]) for dim, i in zip(data.dims, index)], count


def setting_at(config, keys, point, key, default=None):
    """The value of a key of the config ("field.dip_deg") at a sweep point: the sweep's, else its case's, else the config's."""
    at = dict(zip(keys, point))
    if key in at:
        return at[key]
    named = [case for case in config.get("sweep", {}).get("case", []) if case.get("name") == at.get("case")]
    for found in (*named, config):
        if key in found:  # cases have keys with dots
            return found[key]
        for part in key.split("."):
            found = found.get(part) if isinstance(found, dict) else None
        if found is not None:
            return found
    return default


def norths_at(file, config, keys, point):
    """(declination, convergence) in degrees at a sweep point: true less magnetic and true less grid azimuth.

    Those of a field by model are in table `reference_field`, not in the config. NaN for the convergence of a grid without a
    model, which no table has.
    """
    placed = at_point(read_table(file, "reference_field"), keys, point)
    if placed is not None and placed.rows:
        return float(placed["declination_deg"][0]), float(placed["convergence_deg"][0])
    has_grid = setting_at(config, keys, point, "field.grid") is not None
    convergence = np.nan if has_grid else setting_at(config, keys, point, "field.convergence_deg", 0.0)
    return float(setting_at(config, keys, point, "field.declination_deg", 0.0)), float(convergence)


def spread(values, most):
    """At most so many of some values, evenly from the first to the last; of one, the middle."""
    if len(values) <= most:
        return list(values)
    at = [len(values) // 2] if most == 1 else np.linspace(0, len(values) - 1, most).round().astype(int)
    return [values[i] for i in at]


def shared_out(sizes, most):
    """How many values of each facet are shown, so that their product is at most `most`: those with the most give first."""
    shown = list(sizes)
    while np.prod(shown) > most:
        shown[int(np.argmax(shown))] -= 1
    return shown


MOST_POINTS = 6  # of a sweep, in figures of which every point has its own


def points_to_draw(arguments, points, most=MOST_POINTS):
    """(number, point) of the sweep points to draw: the one of --point, otherwise the first ones; says what it leaves out."""
    chosen = chosen_point(arguments, points)
    if chosen is not None:
        return [(chosen, points[chosen])]
    if len(points) > most:
        print(f"{arguments.result}: points 0 to {most - 1} of {len(points)} of the sweep are drawn; any other with --point I",
              file=sys.stderr)
    return list(enumerate(points))[:most]


def is_zero_to_first_order(row):
    """Whether the theory predicts no error for a row of a comparison table."""
    return row["analytic"] == 0 or row["ratio"] < ZERO_TO_FIRST_ORDER
