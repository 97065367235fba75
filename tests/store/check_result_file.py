#!/usr/bin/python3
"""Can other programs open surveymc result files? check_result_file.py [--every] FILE.h5 ...

Opens every group with h5py and ncdump, and with xarray (engines h5netcdf and netcdf4), and checks the rules of
docs/results-format.md. xarray opens those groups that have a column unlike all before, in type, storage or attributes; with
--every each group. Prints each violation and exits with 1 if there is any.
"""
import pathlib
import re
import subprocess
import sys

import h5py
import numpy as np
import xarray as xr

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
from surveymc import integrity  # noqa: E402

ROOT_TEXTS = ["title", "format", "experiment", "surveymc_version", "git_revision", "config", "config_hash", "command",
              "compiler", "content_hash"]
ROOT_INTEGERS = ["format_version", "seed", "trials"]
RUN = ["created", "host", "elapsed_s", "threads", "ranks"]

violations = []
read_alike = set()  # kinds of columns that xarray has read


def demand(ok, message):
    if not ok:
        violations.append(message)


def is_text(dataset):
    return h5py.check_string_dtype(dataset.dtype) is not None


def is_scale(dataset):
    return h5py.h5ds.is_scale(dataset.id)


def values_of(dataset):
    return dataset.asstr()[()] if is_text(dataset) else dataset[()]


def same(a, b):
    a, b = np.asarray(a), np.asarray(b)
    if a.shape != b.shape:
        return False
    if a.dtype.kind in "OUS" or b.dtype.kind in "OUS":
        return a.astype(str).tolist() == b.astype(str).tolist()
    return np.array_equal(a, b, equal_nan=True) if a.dtype.kind == "f" else np.array_equal(a, b)


def check_root(f):
    for name in ROOT_TEXTS:
        demand(isinstance(f.attrs.get(name), str), f"/: attribute {name} is missing or not variable-length text")
    for name in ROOT_INTEGERS:
        value = f.attrs.get(name)
        demand(isinstance(value, np.int64), f"/: attribute {name} is missing or not a 64-bit integer")
    demand(f.attrs.get("format") == "surveymc", "/: format is not surveymc")
    demand(len(f.attrs.get("content_hash", "")) == 32, "/: content_hash is not 128 bits in hex")
    for name in ["tables", "samples", "maps", "inputs", "run"]:
        demand(isinstance(f.get(name), h5py.Group), f"/{name}: no such group")
    for name in RUN:
        demand("run" in f and name in f["run"].attrs, f"/run: attribute {name} is missing")


def check_dataset(d):
    string = h5py.check_string_dtype(d.dtype)
    demand(d.dtype.kind != "S" and (string is None or string.length is None), f"{d.name}: fixed-length strings")
    demand(string is None or string.encoding == "utf-8", f"{d.name}: strings are not UTF-8")
    demand(d.dtype.names is None, f"{d.name}: compound type")
    for name in ["long_name"] + ([] if is_text(d) else ["units"]):
        demand(isinstance(d.attrs.get(name), str), f"{d.name}: attribute {name} is missing or not variable-length text")
    for axis in range(d.ndim if not is_scale(d) else 0):
        scales = d.dims[axis].values()
        demand(len(scales) == 1, f"{d.name}: dimension {axis} has {len(scales)} dimension scales")
        for scale in scales:
            demand(scale.shape == (d.shape[axis],), f"{d.name}: {scale.name} has another length")


def check_columns(group):
    demand("long_name" in group.attrs, f"{group.name}: no long_name")
    if "row" not in group:
        violations.append(f"{group.name}: no dimension scale `row`")
        return
    row = group["row"]
    demand(is_scale(row), f"{row.name}: is not a dimension scale")
    demand(row.dtype == np.int64 and same(row[()], np.arange(len(row))), f"{row.name}: is not 0, 1, 2, ... as int64")
    for name, d in group.items():
        demand(d.shape == row.shape, f"{d.name}: length {d.shape} differs from that of row {row.shape}")
        check_dataset(d)
        if d.name != row.name and d.ndim == 1 and len(d.dims[0]) == 1:
            demand(d.dims[0][0] == row, f"{d.name}: the scale `row` is not attached")
        for companion in d.attrs.get("ancillary_variables", "").split():
            demand(companion in group, f"{d.name}: ancillary variable {companion} is missing")


def kinds_of(group):
    """What decides how a reader takes the columns of a group: types, dimensions, storage and attributes; not their names and numbers."""
    def attributes(item):
        return tuple((k, np.asarray(v).dtype.str[:2]) for k, v in sorted(item.attrs.items()) if k not in ("DIMENSION_LIST", "REFERENCE_LIST"))

    place = group.name.split("/")[1]
    return {(place, attributes(group))} | {
        (place, name.isidentifier(), str(d.dtype), d.ndim, d.size == 0, is_scale(d), d.chunks is None, d.compression, attributes(d))
        for name, d in group.items() if isinstance(d, h5py.Dataset)}


def check_xarray(path, group, engine):
    """Every dataset of the group arrives under its name with the same values."""
    try:
        with xr.open_dataset(path, group=group.name, engine=engine) as ds:
            demand(set(ds.variables) == set(group), f"{group.name}: {engine} sees {sorted(ds.variables)}")
            for name in ds.variables:
                demand(same(ds[name].values, values_of(group[name])), f"{group.name}/{name}: {engine} reads other values")
                demand(ds[name].attrs.get("units") == group[name].attrs.get("units"),
                       f"{group.name}/{name}: {engine} reads other units")
            if group.name != "/maps":
                demand(not ds.variables or set(ds.sizes) == {"row"}, f"{group.name}: {engine} sees dimensions {dict(ds.sizes)}")
            str(ds)
            if ds.sizes:
                ds.to_dataframe() if set(ds.sizes) == {"row"} else ds.load()
    except Exception as e:  # whatever a reader throws is a violation to report, with the rest of them
        violations.append(f"{group.name}: {engine}: {type(e).__name__}: {e}")


PROBABILITY = re.compile(r"(p|share|coverage)_.*|p_value|.*_(share|p)")
PROBABLE_ROW = re.compile(r"(p_|false_alarm|detection_|identified|missed|rejected|over_tolerance|detected|deleted|own_test|station_right|"
                          r"reading_right|nis_within).*")


def check_probabilities(table):
    """Probabilities and shares, found and predicted, with the ends of their intervals, are in [0, 1]; infinity is none."""
    within = lambda values: bool(((values >= 0) & (values <= 1) | np.isnan(values)).all())  # noqa: E731
    ends = ("share", "share_ci_low", "share_ci_high")
    if table.name == "/tables/sensitivity" and all(name in table for name in ends):  # chance may take an estimate beyond
        share, low, high = (table[name][()] for name in ends)
        demand(bool((((low >= 0) | (share < 0)) & ((high <= 1) | (share > 1)) | np.isnan(low)).all()),
               f"{table.name}: ends of intervals must be within [0, 1] where the estimate is")
        return
    for name, column in table.items():
        if not is_text(column) and column.attrs.get("units") == "1" and PROBABILITY.fullmatch(name):
            demand(within(column[()]), f"{column.name}: must be within [0, 1]")
    if not {"quantity", "analytic", "monte_carlo"} <= set(table):
        return
    rows = [i for i, q in enumerate(table["quantity"].asstr()[()]) if PROBABLE_ROW.fullmatch(q)]
    for name in ("analytic", "monte_carlo", "monte_carlo_ci_low", "monte_carlo_ci_high"):
        demand(within(table[name][()][rows]), f"{table.name}/{name}: rows of probabilities must be within [0, 1]")


def check(path, every):
    before = len(violations)
    with h5py.File(path, "r") as f:
        check_root(f)
        tables = [g for parent in ["tables", "samples", "inputs"] for g in f.get(parent, {}).values()]
        for group in tables:
            check_columns(group)
        for group in f.get("tables", {}).values():
            check_probabilities(group)
        for group in f.get("inputs", {}).values():
            for name in ["path", "hash"]:
                demand(isinstance(group.attrs.get(name), str), f"{group.name}: attribute {name} is missing")
        for d in f.get("maps", {}).values():
            check_dataset(d)
            demand(is_scale(d) or d.dtype == np.float64, f"{d.name}: a map holds doubles")
        demand(integrity.content_hash(f) == f.attrs["content_hash"], "/: content_hash is of other contents")
        chosen = []
        for group in [f, f["run"], f["maps"]] + tables:
            if every or not kinds_of(group) <= read_alike:
                read_alike.update(kinds_of(group))
                chosen.append(group)
        for engine in ["h5netcdf", "netcdf4"]:
            for group in chosen:
                if group.name in ("/", "/run"):
                    with xr.open_dataset(path, group=group.name, engine=engine) as ds:
                        for name, value in group.attrs.items():
                            demand(name in ds.attrs and same(ds.attrs[name], value),
                                   f"{group.name}: {engine} reads another {name}")
                else:
                    check_xarray(path, group, engine)
    for command in [["ncdump", "-h", path], ["ncdump", path], ["h5dump", "-H", path]]:
        try:
            done = subprocess.run(command, capture_output=True)
        except FileNotFoundError:
            print(f"skipped: {command[0]} is not installed")
            continue
        demand(done.returncode == 0, f"{' '.join(command)}: exit code {done.returncode}: {done.stderr.decode()[:300]}")

    for v in violations[before:]:
        print(v)
    print(f"{path}: {len(violations) - before} violations, {len(tables)} tables, {len(chosen)} groups in xarray")


def main(arguments):
    for path in (a for a in arguments if a != "--every"):
        check(path, "--every" in arguments)
    return 1 if violations else 0


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1:]))
