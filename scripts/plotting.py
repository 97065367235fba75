"""What the plot scripts of surveymc share: reading result files, error ellipses, style, saving.

Frames and units are those of docs/conventions.md: north, east, vertical (down) in metres; azimuths in degrees clockwise
from north. On maps east is the abscissa and north the ordinate.
"""

import fractions
import io
import math
import os
import re
import sys
import tomllib

import matplotlib

matplotlib.use("Agg")

import h5py  # noqa: E402
import matplotlib.patheffects  # noqa: E402
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402
from matplotlib.patches import Patch  # noqa: E402

import streams  # noqa: E402
import whole_file  # noqa: E402
from arguments import Parser, USAGE  # noqa: E402
from streams import CANNOT_WRITE, run  # noqa: E402, F401
from surveymc import storage  # noqa: E402

BAD_DATA = 65  # exit code, as for the program itself

# One colour, line and marker per thing, in every figure. No two share a line style, so the figures also read in grey.
LOOK = {
    "monte_carlo": {"label": "Monte Carlo", "color": "#0072B2", "linestyle": "-"},
    "joint": {"label": "joint", "color": "#D55E00", "linestyle": (0, (7, 2))},
    "systematic": {"label": "systematic", "color": "#222222", "linestyle": (0, (3.5, 2))},
    "random": {"label": "random", "color": "#A8508A", "linestyle": (0, (1, 1.3))},
}
PROPAGATIONS = ("joint", "systematic", "random")
PUBLISHED = "#777777"
ZERO_TO_FIRST_ORDER = 1e-3  # a ratio below this: the theory predicts nothing, whatever rounding left in it
SIGMA = "\N{GREEK SMALL LETTER SIGMA}"
VERDICT_MARKER = {"agrees": "o", "undecided": "^", "differs": "D"}


class PlotError(streams.Failure):
    """The data cannot be plotted; the message is one line and says place and rule."""

    def __init__(self, message, code=BAD_DATA):
        super().__init__(message, code)


class Saved:
    """What this process has saved, for those that run a script within it, and of which results the figures are."""

    paths = []
    kept = []  # what was there before, as messages
    results = []  # experiment and title of each that was opened


def argument_parser(description):
    """Arguments every plot script has: the result file and the folder to write to."""
    parser = Parser(description=description)
    parser.add_argument("result", help="result file (HDF5) of surveymc")
    parser.add_argument("-o", "--output", metavar="FOLDER", help="where to write (default: the folder of the result)")
    return parser


def stem_of(result):
    """What the names of a result's figures begin with: the name of its file, as it is printed, on one line."""
    return re.sub("[\n\t]", "_", streams.visible(os.path.splitext(os.path.basename(result))[0]))


def name_of(values):
    """Values of a point as part of a file's name: other points have other names."""
    return re.sub(r"[^A-Za-z0-9.+-]+", "_", " ".join(str(v) for v in values)).strip("_")


def plain_text(text):
    """A text of the user for a figure: a dollar sign in it begins no formula, and what is not seen is an escape."""
    return streams.visible(text).replace("$", r"\$")


def title_of(file):
    """The title of a result, or of what experiment it is."""
    return plain_text(text_attribute(file, "title")) or text_attribute(file, "experiment").replace("_", " ").capitalize()


# --- result files ---------------------------------------------------------------------------------------------------


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


def chosen_point(arguments, points):
    """The index given with --point, or None; PlotError if the sweep has no such point."""
    if arguments.point is not None and not 0 <= arguments.point < len(points):
        raise PlotError(f"--point {arguments.point}: {arguments.result} has points 0 to {len(points) - 1}", USAGE)
    return arguments.point


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


# What readers of a figure call a key of the sweep and its values; others are named by the last part of the key.
POINT_WORDS = {
    "estimator.name": "{}", "estimator.method": "{}", "error_model.name": "{}", "drilling.mode": "{}", "mode": "{}",
    "noise.scale": "noise \N{MULTIPLICATION SIGN} {}", "noise.law": "{} noise",
    "noise.reference.per": "reference drawn per {}", "sensor_errors.multiplier": "errors \N{MULTIPLICATION SIGN} {}",
    "errors.multiplier": "errors \N{MULTIPLICATION SIGN} {}", "errors.vertical": "lateral errors as {}", "sensor.spread.axial_bias_nT": "axial bias sd {} nT", "well.stations": "{} stations", "well.kind": "{} well",
    "spacing_m": "stations {} m apart", "drilling.sequence": "toolface sequence {}",
    "model.truth_references": "references {} in truth", "factor": "error \N{MULTIPLICATION SIGN} {}",
    "problem.name": "{}", "sampling.method": "method {}"}
VALUE_WORDS = {
    "msa": "MSA", "msa_weighted": "weighted MSA", "msa_joint": "joint MSA", "wls": "WLS", "wls_consider": "WLS with considered reference",
    "sse": "single station", "sse_axial": "single station, axial correction", "mse_fixed": "many stations, references fixed",
    "mse_shared": "many stations, references shared", "gaussian": "normal",
    "form": "FORM", "sorm": "SORM", "nees": "NEES", "nis": "NIS", "bonferroni": "Bonferroni"}
POINT_UNITS = {"nT": "nT", "deg": "\N{DEGREE SIGN}", "mps2": "m/s\N{SUPERSCRIPT TWO}", "mg": "mg", "m": "m", "z": "z", "h": "h"}


def value_name(value):
    """A value of a key as readers know it."""
    if isinstance(value, (float, np.floating)):
        return f"{value:g}"
    return VALUE_WORDS.get(str(value), plain_text(str(value).replace("_", " ")))


def point_name(keys, point):
    """'test 1, noise \N{MULTIPLICATION SIGN} 0.1': a sweep point in words, its case first. keys: of the sweep; point: their values."""
    parts = []
    for key, value in sorted(zip(keys, point), key=lambda kv: kv[0] != "case"):
        if key == "case":
            parts.append(re.sub(r"\b(msa|msa_weighted|msa_joint|wls)\b", lambda word: VALUE_WORDS[word[0]],
                                plain_text(str(value))))
            continue
        if key in POINT_WORDS:
            parts.append(POINT_WORDS[key].format(value_name(value)))
            continue
        name, _, ending = key.rsplit(".", 1)[-1].rpartition("_")
        unit = POINT_UNITS.get(ending, "") if name else ""
        words = (name if unit else key.rsplit(".", 1)[-1]).replace("_", " ")
        words = f"sd of {words}" if key.startswith("sigma.") else words
        gap = "" if unit == POINT_UNITS["deg"] else " "
        parts.append(f"{words} {value_name(value)}{gap + unit if unit else ''}")
    return ", ".join(parts)


def quantity_name(name):
    """What readers call a quantity, a formulation or a code of a table: "3σ of gain z" for "sigma3_gain_z"."""
    if name in VALUE_WORDS:
        return VALUE_WORDS[name]
    found = re.fullmatch(r"(sigma3|mean|sd)_(\w+)", name)
    if found:
        return f"{ {'sigma3': '3' + SIGMA, 'mean': 'mean', 'sd': 'sd'}[found[1]]} of {quantity_name(found[2])}"
    return plain_text(name.replace("_", " "))


def axis_name(name):
    """A key or a column as the label of an axis, its unit in brackets: "inclination (\N{DEGREE SIGN})" for "inclination_deg"."""
    parts = name.split(".")
    name = parts[-2] if parts[-1] == "name" and len(parts) > 1 else parts[-1]
    stem, _, ending = name.rpartition("_")
    unit = POINT_UNITS.get(ending, "") if stem else ""
    words = {"md": "measured depth", "semi_major": "semi-major axis", "semi_minor": "semi-minor axis"}
    text = words.get(stem if unit else name) or quantity_name(stem if unit else name)
    text = f"sd of {text}" if parts[0] == "sigma" and len(parts) > 1 else text
    return f"{text} ({unit})" if unit else text


# --- error ellipses -------------------------------------------------------------------------------------------------


def ellipse_axes(covariance):
    """Semi axes of the 1-sigma ellipse of a covariance [[nn, ne], [ne, ee]] (m2) and the azimuth of the major one.

    Returns (semi_major, semi_minor, azimuth_deg): the axes are the square roots of the eigenvalues (m), the azimuth
    is that of the eigenvector of the larger one, clockwise from north, in [0, 180). Eigenvalues that rounding made
    negative count as 0: the ellipse is a line. PlotError if the matrix is not a covariance.

    The closed form with an exact determinant, not a general eigenvalue routine: the minor axis of a position error is
    easily a thousandth of the major one, and a general routine loses the square of that in relative accuracy.
    """
    c = np.asarray(covariance, float)
    if c.shape != (2, 2) or not np.all(np.isfinite(c)):
        raise PlotError("a covariance must be 2x2 and finite")
    nn, ne, ee = c[0, 0], (c[0, 1] + c[1, 0]) / 2, c[1, 1]
    major2 = (nn + ee + np.hypot(nn - ee, 2 * ne)) / 2
    if major2 == 0 and nn == 0 and ee == 0:
        return 0.0, 0.0, 0.0
    exact = fractions.Fraction
    minor2 = float(exact(nn) * exact(ee) - exact(ne) ** 2) / major2 if major2 > 0 else -1.0
    if min(nn, ee) < 0 or minor2 < -1e-9 * major2:  # stored elements carry about 1e-15 of the largest
        raise PlotError(f"not a covariance: [[{nn:g}, {ne:g}], [{ne:g}, {ee:g}]] has a negative eigenvalue")
    azimuth = np.degrees(np.arctan2(2 * ne, nn - ee)) / 2
    return float(np.sqrt(major2)), float(np.sqrt(max(minor2, 0.0))), float(azimuth % 180)


def ellipse_points(covariance, k=1.0, centre=(0.0, 0.0), count=361):
    """Points x of the k-sigma ellipse (x - centre)' C^-1 (x - centre) = k^2; returns (north, east), closed.

    covariance: [[nn, ne], [ne, ee]] in m2; centre: (north, east) in m. A singular covariance gives a line.
    """
    major, minor, azimuth = ellipse_axes(covariance)
    return ellipse_points_from_axes(major, minor, azimuth, k, centre, count)


def ellipse_points_from_axes(major, minor, azimuth_deg, k=1.0, centre=(0.0, 0.0), count=361):
    """As ellipse_points, from semi axes (m) and the azimuth of the major one."""
    t = np.linspace(0, 2 * np.pi, count)
    along, across = k * major * np.cos(t), k * minor * np.sin(t)
    ca, sa = np.cos(np.radians(azimuth_deg)), np.sin(np.radians(azimuth_deg))
    return centre[0] + along * ca - across * sa, centre[1] + along * sa + across * ca


def is_line(major, minor):
    """Whether an ellipse is degenerate: a minor axis below 1e-6 of the major one is rounding of the covariance, whose
    elements carry 1e-15 of the *square* of the major axis."""
    return minor < 1e-6 * major


def rotate_to_axes(north, east, azimuth_deg):
    """(along, across) the direction azimuth_deg; across is positive to its right (azimuth + 90 deg)."""
    ca, sa = np.cos(np.radians(azimuth_deg)), np.sin(np.radians(azimuth_deg))
    return ca * north + sa * east, -sa * north + ca * east


def map_turned(north, east, azimuth_deg):
    """(along, left): the map turned until the direction azimuth_deg points to the right; what lies to its left is up.

    A map that is turned, not mirrored: an ellipse has the shape that it has on the map.
    """
    along, right = rotate_to_axes(north, east, azimuth_deg)
    return along, -right


def ellipse_coverage(k):
    """Probability that a normally distributed point lies inside its k-sigma ellipse."""
    return -np.expm1(-k * k / 2)


# --- figures --------------------------------------------------------------------------------------------------------


def use_style():
    """The look of all figures."""
    plt.style.use(os.path.join(os.path.dirname(os.path.abspath(__file__)), "style.mplstyle"))


def figures_folder(output, result):
    """The folder to write to, made if need be; by default the one of the result."""
    folder = output or os.path.dirname(result) or "."
    try:
        os.makedirs(folder, exist_ok=True)
    except OSError as error:
        raise PlotError(f"{folder}: cannot make the folder: {error.strerror}", CANNOT_WRITE) from None
    return folder


def fit_texts(figure):
    """Makes titles and texts that run out of the figure, or into the panel beside theirs, smaller; cuts what is still too long.

    Names of runs, cases and wells are the user's, and may be of any length.
    """
    if figure.get_layout_engine() is not None:
        figure.get_layout_engine().execute(figure)  # only now the panels have their places
    renderer = figure.canvas.get_renderer()
    wide = figure.bbox.width
    panels = [ax for ax in figure.axes if ax.get_visible()]
    boxes = [ax.get_window_extent(renderer) for ax in panels]
    texts = [(text, wide) for text in figure.texts]
    for ax, own in zip(panels, boxes):
        beside = [b.x0 for b in boxes if b.x0 > own.x1 - 1 and b.y0 < own.y1 and b.y1 > own.y0]
        texts += [(title, min(beside, default=wide)) for title in (ax.title, ax._left_title)]
    for text, limit in texts:
        for size in (None, 10, 9, 8, 7, 6):
            if size is not None and size < text.get_fontsize():
                text.set_fontsize(size)
            box = text.get_window_extent(renderer)
            low = max(box.x0, 0.005 * wide) if text.get_ha() == "center" else box.x0
            if not text.get_text() or box.width < 1 or low + box.width <= limit - 0.003 * wide:
                break
        else:
            whole = text.get_text().split("\n")
            length = int(max(map(len, whole)) * (limit - low) / box.width)
            while length > 8 and low + text.get_window_extent(renderer).width > limit - 0.003 * wide:
                length -= 1
                text.set_text("\n".join(cut(line, length) for line in whole))


def label_points(ax, text, point, end=None, is_up=True, **style):
    """Writes a text at a point (data), beyond `end` on its ordinate: above, or below.

    It stays there unless it would lie on another such text or leave the panel; `save` then tries places about it.
    """
    label = ax.annotate(text, (point[0], point[1] if end is None else end), xytext=(0, 9), textcoords="offset points",
                        **{"fontsize": 8, "annotation_clip": False, **style})
    label.set_in_layout(False)
    high = 1.25 * label.get_fontsize() * (1 + text.count("\n"))
    steps = [9 + k * high for k in (0, 1, 2)]
    first, other = (1, -1) if is_up else (-1, 1)
    label.ways = [(0, first * s) for s in steps] + [(0, other * s) for s in steps]
    label.ways += [(side * 9, up * s) for s in (0, *steps) for up in (first, other) for side in (1, -1)]
    label.taken = point
    _put(label, label.ways[0])
    return label


def _put(label, way):
    """Moves a text to an offset from its point (points), so that it grows away from the point."""
    across, up = way
    label.set_position(way)
    label.set_ha("left" if across > 0 else "right" if across < 0 else "center")
    label.set_va("bottom" if up > 0 else "top" if up < 0 else "center")


def _shared(box, others):
    """The area (pixels) that a box shares with others."""
    return sum(max(min(box.x1, o.x1) - max(box.x0, o.x0), 0) * max(min(box.y1, o.y1) - max(box.y0, o.y0), 0) for o in others)


def _boxes_along(line, dpi):
    """Small boxes (pixels) along a line that a text must not cross; none for what is drawn of very many points."""
    vertices = line.get_transform().transform(line.get_path().vertices) if line.get_linestyle() != "None" else []
    if not 2 <= len(vertices) <= 60 or not np.all(np.isfinite(vertices)):
        return []
    step, boxes = 6 * dpi / 72, []
    for (x0, y0), (x1, y1) in zip(vertices, vertices[1:]):
        for part in np.linspace(0, 1, max(2, min(int(np.hypot(x1 - x0, y1 - y0) / step), 400))):
            x, y = x0 + part * (x1 - x0), y0 + part * (y1 - y0)
            boxes.append(matplotlib.transforms.Bbox.from_extents(x - 1, y - 1, x + 1, y + 1))
    return boxes


def settle_labels(figure):
    """Moves the texts of `label_points` apart, and hides those contour labels that lie on another one."""
    labels = [t for t in figure.findobj(matplotlib.text.Annotation) if hasattr(t, "ways")]
    optional = [t for t in figure.findobj(matplotlib.text.Text) if getattr(t, "is_optional", False)]
    if not labels and not optional:
        return
    renderer = figure.canvas.get_renderer()
    for ax in {t.axes: None for t in labels}:
        own = [t for t in labels if t.axes is ax]
        panel = ax.get_window_extent(renderer)
        reach = 4 * figure.dpi / 72  # of a marker
        taken = [matplotlib.transforms.Bbox.from_extents(x - reach, y - reach, x + reach, y + reach)
                 for x, y in ax.transData.transform([t.taken for t in own])]
        taken += [t.get_window_extent(renderer) for t in ax.texts if t not in own and t.get_visible() and t.get_text()]
        taken += [b for line in ax.lines for b in _boxes_along(line, figure.dpi)]
        taken += [ax.get_legend().get_window_extent(renderer)] if ax.get_legend() is not None else []
        for label in own:
            best = None
            for way in label.ways:
                _put(label, way)
                box = label.get_window_extent(renderer).padded(1.0)
                cost = _shared(box, taken) + box.width * box.height - _shared(box, [panel])
                if best is None or cost < best[0] - 1:
                    best = cost, way
                if cost < 1:
                    break
            _put(label, best[1])
            taken.append(label.get_window_extent(renderer))
    for ax in {t.axes: None for t in optional}:
        seen, panel = [], ax.get_window_extent(renderer)
        for text in (t for t in optional if t.axes is ax):
            box = text.get_window_extent(renderer)
            text.set_visible(_shared(box, seen) < 1 and _shared(box, [panel]) > 0.99 * box.width * box.height)
            seen += [box] if text.get_visible() else []


def label_contours(ax, lines, text_of, colour="white", halo="#333333", size=7):
    """Writes their values on contours; where lines run close, only so many as there is room for."""
    for label in ax.clabel(lines, fmt=text_of, fontsize=size, inline=False, colors=colour):
        label.set_path_effects([matplotlib.patheffects.withStroke(linewidth=1.5, foreground=halo)])
        label.is_optional = True


def dot_size(count, largest=6.0, smallest=1.8):
    """Size of the dots of a cloud of so many: few are large enough to be seen, many leave the ellipses legible."""
    return float(np.clip(largest * (30 / max(count, 1)) ** 0.25, smallest, largest))


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


def point_title(title, keys, points, number):
    """Title of a figure of one sweep point; its number where not all points are drawn."""
    if not keys:
        return title
    of_all = f" (point {number} of 0 to {len(points) - 1})" if len(points) > MOST_POINTS else ""
    return f"{title}: {point_name(keys, points[number])}{of_all}"


def cut(line, length):
    """A line of at most this length; no backslash is left without what it stands before."""
    return line if len(line) <= length else line[:length - 1].rstrip("\\") + "\N{HORIZONTAL ELLIPSIS}"


def save(figure, folder, name):
    """Writes <name>.png (150 dpi) and <name>.svg, closes the figure, prints the two paths.

    The files depend on the data only: no dates, and clips are counted, where matplotlib names them by addresses in memory.
    Rasterised parts of the SVG have 300 dpi. A figure that the same script has made of the same result (of its experiment and
    title) is replaced, if nobody has changed it since; any other file is kept under the next free number.
    """
    fit_texts(figure)
    if figure.get_layout_engine() is not None:
        figure.get_layout_engine().execute(figure)
        figure.set_layout_engine("none")  # the panels have their places, in both files; to find them takes as long as to draw
        figure.get_layout_engine = lambda: None  # or savefig would draw once more, to let one place them
    settle_labels(figure)
    picture, drawing = io.BytesIO(), io.StringIO()
    figure.savefig(picture, format="png", metadata={"Software": None})
    figure.savefig(drawing, format="svg", metadata={"Date": None}, dpi=300)
    plt.close(figure)
    svg = streams.visible(drawing.getvalue())  # a control character is no XML
    clips = {clip: f"clip{i}" for i, clip in enumerate(re.findall(r'<clipPath id="(\w+)"', svg), 1)}
    svg = re.sub(r'(<clipPath id="|url\(#)(\w+)', lambda use: use[1] + clips.get(use[2], use[2]), svg)
    maker = "\n".join([os.path.basename(sys.argv[0]), *dict.fromkeys(Saved.results)])
    for extension, data in ((".png", picture.getvalue()), (".svg", svg.encode())):
        path = os.path.join(folder, name + extension)
        write(path, whole_file.marked(data, maker), whole_file.is_marked_by(maker))
        print(path)
        Saved.paths.append(path)


def write(path, data, is_ours):
    """Writes a file whole, says what it has kept, and what it could not write."""
    try:
        kept = whole_file.write(path, data, is_ours)
    except OSError as error:
        raise PlotError(f"{path}: cannot write: {error.strerror or error}", CANNOT_WRITE) from None
    if kept:
        Saved.kept.append(f"{path}: was there, and was not made from this: kept as {os.path.relpath(kept)}")
        print(Saved.kept[-1], file=sys.stderr)


def save_all(figures, arguments):
    """Saves {name: figure}, None where there is nothing to draw, as <stem>_<name> into the folder that the arguments name."""
    folder = figures_folder(arguments.output, arguments.result)
    for name, figure in figures.items():
        if figure is not None:
            save(figure, folder, f"{stem_of(arguments.result)}_{name}")


def counts_text(counts):
    """'7 168', or '7 168 to 21 504' where points, or tests, differ."""
    least, most = int(min(counts)), int(max(counts))
    return grouped(least) if least == most else f"{grouped(least)} to {grouped(most)}"


def trials_text(table):
    """'19 935 of 20 000 trials' of a table that counts them; of rows that differ, ranges."""
    run, failed = np.asarray(table["trials"]).astype(int), np.asarray(table["failed"]).astype(int)
    if not failed.any():
        return f"{counts_text(run)} trials"
    return f"{counts_text(run - failed)} of {counts_text(run)} trials ({counts_text(failed)} did not converge)"


def grouped(count):
    """12345 as '12 345'."""
    return f"{count:,}".replace(",", "\N{NARROW NO-BREAK SPACE}")


def is_zero_to_first_order(row):
    """Whether the theory predicts no error for a row of a comparison table."""
    return row["analytic"] == 0 or row["ratio"] < ZERO_TO_FIRST_ORDER


def band(ax, margin):
    """1 and the margin within which a prediction agrees."""
    if margin:
        ax.axhspan(1 - margin, 1 + margin, color="#009E73", alpha=0.18, linewidth=0, zorder=0)
    ax.axhline(1, color="#444444", linewidth=1.0, zorder=1)


def legend_columns(figure, handles, most=7):
    """How many columns of a legend with these handles the figure has room for (9 points, 5.6 a letter)."""
    widest = max(len(h.get_label()) for h in handles) * 5.6 + 45
    return int(np.clip(0.96 * 72 * figure.get_figwidth() // widest, 1, min(most, len(handles))))


def interval_handle(confidence):
    return Line2D([], [], color="#444444", marker="|", linestyle="none", markersize=11, markeredgewidth=1.6,
                  label=f"{100 * confidence:g} % interval")


def margin_handle(margin, largest=None):
    """largest: of rows whose margins differ, of which `margin` is the smallest."""
    words = f"{margin:g}" if largest in (None, margin) else f"{margin:g} to {largest:g}"
    return [Patch(color="#009E73", alpha=0.18, label=f"agrees: 1 \N{PLUS-MINUS SIGN} {words}")] if margin else []


def heading(figure, title, text):
    """Title, and below it a text that says what is drawn and from how many trials."""
    figure.suptitle(title, x=0.02, y=0.985, ha="left")
    figure.text(0.02, 0.985 - 0.38 / figure.get_figheight(), text, ha="left", va="top", linespacing=1.35)


def number(value, digits=3):
    """A number for people: `digits` significant digits, no exponent between 1e-4 and 1e5, '-' for none."""
    if not np.isfinite(value):
        return "\N{EN DASH}"
    if value == 0:
        return "0"
    size = int(np.floor(np.log10(abs(value))))
    value = round(value, digits - 1 - size)
    size = int(np.floor(np.log10(abs(value))))  # 9.996 became 10
    text = f"{value:.{max(digits - 1 - size, 0)}f}" if -4 <= size < 5 else f"{value:.{digits - 1}e}"
    return text.replace("-", "\N{MINUS SIGN}")


def plain_size(value):
    """A tick of a logarithmic axis for people: 0.02, 500; of very small and large ones with a power of ten."""
    if 1e-4 <= abs(value) < 1e6 or value == 0:
        return f"{value:g}"
    exponent = math.floor(math.log10(abs(value)) + 1e-9)
    first = f"{value / 10.0**exponent:.3g}"
    return f"$10^{{{exponent}}}$" if first == "1" else f"${first}\\times10^{{{exponent}}}$"


def plain_log_axis(axis, low, high):
    """Ticks of a logarithmic axis that people read without thinking: 0.2, 0.5, 1, 2, 5 and no minor labels."""
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    decades = [10.0**e for e in range(first, last + 1) if low <= 10.0**e <= high]
    ticks = decades[::-(-len(decades) // 9)][::-1] if len(decades) > 5 else []
    for steps in ((1, 2, 5), (1, 1.5, 2, 3, 5, 7), (1, 1.2, 1.5, 1.8, 2, 2.5, 3, 4, 5, 6, 7, 8, 9)):
        if len(ticks) >= (4 if low > 1e-4 else 2):  # powers of ten need more room
            break
        ticks = [s * 10.0**e for e in range(first, last + 1) for s in steps if low <= s * 10.0**e <= high]
    if len(ticks) < 4 and high < 2 * low:  # as on a plain axis
        ticks = [t for t in matplotlib.ticker.MaxNLocator(5, steps=(1, 2, 5, 10)).tick_values(low, high) if low <= t <= high]
    axis.set_major_locator(matplotlib.ticker.FixedLocator(ticks))
    axis.set_major_formatter(matplotlib.ticker.FuncFormatter(lambda v, _: plain_size(v)))
    axis.set_minor_locator(matplotlib.ticker.NullLocator())
