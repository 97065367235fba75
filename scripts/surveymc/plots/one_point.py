"""A result of one sweep point, cut out of that of a whole sweep: what draws single points sees no sweep."""

import atexit
import os
import shutil
import tempfile

import h5py
import numpy as np

from .. import storage, toml
from . import reading, saving, wording

LEFT_OUT = {"answer", "sweep_points", "failed_points", "sensitivity"}  # tables of the whole sweep
OF_HDF5 = {"DIMENSION_LIST", "REFERENCE_LIST", "CLASS", "NAME"}  # attributes that HDF5 makes itself


def keys_of(group):
    """The columns of a table that say which sweep point a row is of."""
    return [k for k, d in group.items() if reading.text_attribute(d, "long_name") == "sweep key"]


def points_of(file):
    """(keys, their values at each point in the order of the file); ([], [()]) without a sweep."""
    listed = reading.read_table(file, "sweep_points")
    if listed is not None:
        keys = [k for k in listed if k not in ("point", "row")]
        return keys, list(zip(*(listed[k] for k in keys)))
    best = [], [()]
    for name in file["tables"]:
        keys = keys_of(file["tables"][name])
        if keys:
            points = reading.sweep_points(reading.read_table(file, name), keys)
            best = (keys, points) if len(points) > len(best[1]) else best
    return best


def varying(keys, points):
    """The keys that have more than one value."""
    return [k for k, values in zip(keys, zip(*points)) if len(set(values)) > 1]


def settings_at(config, keys, point):
    """The config of a point: without [sweep], with the values of its keys and of its case in place."""
    case = dict(zip(keys, point)).get("case")
    named = next((c for c in config.get("sweep", {}).get("case", []) if c.get("name") == case), {})
    settings = {k: v for k, v in config.items() if k not in ("sweep", "refine", "sensitivity")}
    for key, value in [*named.items(), *zip(keys, point)]:
        if key in ("case", "name"):
            continue
        *path, last = key.split(".")
        inner = settings
        for part in path:
            inner[part] = dict(inner[part]) if isinstance(inner.get(part), dict) else {}
            inner = inner[part]
        inner[last] = storage.plain(value)
    return settings


def _copy_attributes(of, to):
    for name, value in of.attrs.items():
        if name not in OF_HDF5:
            to.attrs[name] = value


def _copy_rows(group, to, keys, point):
    """The rows of a table that are of a point."""
    own = {k: group[k].asstr()[()] if h5py.check_string_dtype(group[k].dtype) else group[k][()] for k in keys if k in group}
    rows = next(iter(own.values()), group["row"][()] if "row" in group else np.zeros(0))
    keep = np.ones(len(rows), bool)
    for key, value in zip(keys, point):
        if key in own:
            keep &= own[key] == value
    _copy_attributes(group, to)
    for name, column in group.items():
        data = column[()][keep] if own else column[()]
        if name == "row":
            data = data[:keep.sum()]
        _copy_attributes(column, to.create_dataset(name, data=data, dtype=column.dtype))


def _copy_map(data, to, keys, point, number):
    """A map at a point: without the axes that are keys of the sweep."""
    at, left = [], []
    for dimension in data.dims:
        scale = dimension[0]
        name = os.path.basename(scale.name)
        if name == "point":
            at.append(number)
        elif name in keys:
            values = scale.asstr()[()] if h5py.check_string_dtype(scale.dtype) else scale[()]
            at.append(int(np.flatnonzero(values == point[keys.index(name)])[0]))
        else:
            at.append(slice(None))
            left.append(scale)
    made = to.create_dataset(os.path.basename(data.name), data=data[tuple(at)])
    _copy_attributes(data, made)
    for axis, scale in enumerate(left):
        name = os.path.basename(scale.name)
        if name not in to:
            _copy_attributes(scale, to.create_dataset(name, data=scale[()], dtype=scale.dtype))
            to[name].make_scale(name)
        made.dims[axis].attach_scale(to[name])


def extract(path, number, folder):
    """Writes point `number` (from 0, in the order of the file) of a result as <stem>_point<number>.h5 into a folder: (its path,
    the point in words). PlotError if there is no such point."""
    with reading.open_any(path) as file:
        keys, points = points_of(file)
        point = points[reading.checked_point(number, points, path)]
        made = os.path.join(folder, f"{saving.stem_of(path)}_point{number}.h5")
        with storage.sealed_file(made) as to:
            _copy_attributes(file, to)
            title = reading.text_attribute(file, "title") or reading.text_attribute(file, "experiment").replace("_", " ").capitalize()
            words = wording.point_name(keys, point)
            to.attrs["title"] = f"{title}: {words} (point {number} of 0 to {len(points) - 1})".replace("\\$", "$")
            to.attrs["config"] = toml.dumps(settings_at(reading.configuration(file), keys, point))
            for kind in ("tables", "samples"):
                group = to.create_group(kind, track_order=True)
                for name in file.get(kind, {}):
                    if name not in LEFT_OUT:
                        own = file[kind][name]
                        _copy_rows(own, group.create_group(name, track_order=True), keys_of(own), [dict(zip(keys, point))[k] for k in keys_of(own)])
            maps = to.create_group("maps", track_order=True)
            for data in file.get("maps", {}).values():
                if not h5py.h5ds.is_scale(data.id):
                    _copy_map(data, maps, keys, point, number)
            for name in ("inputs", "run"):
                to.create_group(name, track_order=True)
                if name in file:
                    for item in file[name].values():
                        file.copy(item, to[name])
    return made, words


def parse(parser):
    """The arguments of a drawer of single points: with --point, its result is that of the point, cut out until the program ends."""
    parser.add_argument("--point", type=int, metavar="I", help="sweep point of figures that show one, from 0")
    arguments = parser.parse_args()
    if arguments.point is not None:
        arguments.output = saving.figures_folder(arguments.output, arguments.result)
        folder = tempfile.mkdtemp(prefix="surveymc-point-")
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        arguments.result, _ = extract(arguments.result, arguments.point, folder)
    return arguments


def of_sweep(path):
    """(how many points a result has, which keys of its sweep vary, whether [refine] or [sensitivity] asks for figures of the sweep)."""
    try:
        with storage.open_file(path) as file:
            keys, points = points_of(file)
            config = reading.configuration(file)
    except (storage.ResultError, reading.PlotError, *storage.DAMAGE):
        return 1, [], False  # the drawers say what is wrong
    return len(points), varying(keys, points), "refine" in config or "sensitivity" in config
