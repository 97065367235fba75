#!/usr/bin/python3
"""Every printed separation of two ISCWSA workbooks against the program: check_separations.py SURVEYMC FOLDER

FOLDER holds the figures as its README.md describes them; they are no part of the project. Without it: exit 77 (skipped).
Wells and terms are written to a temporary folder in the project's own form.
"""
import csv
import pathlib
import subprocess
import sys
import tempfile

import h5py
import numpy as np

PROGRAM, DATA = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
SLOTS = {1: (0, 100), 2: (100, 0), 3: (0, 10), 4: (0, 20), 5: (-50, -500), 6: (-2300, 100)}
HEAD = """experiment = "clearance"
[survey]
file = "set_reference.csv"
hole_diameter_in = 36.0
[field]
total_nT = 50000.0
dip_deg = 70.0
[error_model]
{model}
"""
OFFSET = """[[offset]]
name = "{i}"
file = "set_offset_{i}.csv"
slot_m = [{north}.0, {east}.0, 0.0]
hole_diameter_in = 24.0
"""
wrong = []


def columns(name):
    rows = list(csv.DictReader(open(DATA / name)))
    return {k: np.array([float(r[k]) if r[k] else np.nan for r in rows]) for k in rows[0]}


def offset(i, more=""):
    return OFFSET.format(i=i, north=SLOTS[i][0], east=SLOTS[i][1]) + more


def run(folder, text):
    (folder / "run.toml").write_text(text)
    subprocess.run([PROGRAM, "run", "run.toml", "-o", "run.h5"], cwd=folder, check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)
    with h5py.File(folder / "run.h5") as file:
        return {k: np.array(v.asstr()[()] if h5py.check_string_dtype(v.dtype) else v[()])
                for k, v in file["tables/clearance"].items()}


def held(what, own, published, tolerance, keep=None):
    difference = np.abs(own - published) / tolerance
    if keep is not None:
        difference = difference[keep]
    bad = int(np.sum(~(difference <= 1)))
    print(f"{what}: {len(difference)} figures, largest difference {np.max(difference):.3f} of the tolerance")
    if bad:
        wrong.append(f"{what}: {bad} figures beyond the tolerance")


def turn(a, b):
    return (a - b + 180) % 360 - 180


def write_inputs(folder):
    for path in [DATA / "set_reference.csv", *DATA.glob("set_offset_?.csv")]:
        rows = csv.DictReader(open(path))
        lines = [f"{r['md_m']},{r['inclination_deg']},{r['azimuth_deg']}" for r in rows]
        (folder / path.name).write_text("\n".join(["md_m,inclination_deg,azimuth_deg", *lines]) + "\n")
    for name in ("srgm", "ifr1"):
        terms = [f'{{ code = "{r["code"]}", function = "{r["function"]}", magnitude = {float(r["magnitude"])!r}, '
                 f'unit = "{r["unit"]}", mode = "{r["mode"]}" }},' for r in csv.DictReader(open(DATA / f"terms_{name}.csv"))]
        (folder / f"{name}.toml").write_text("\n".join([f'title = "{name}"', 'source = "ISCWSA"', 'first_leg = "doubled"',
                                                        "terms = [", *terms, "]"]) + "\n")
    (folder / "rev4.toml").write_text('[[model]]\nname = "rev4"\ntitle = "Rev 4"\nsource = "ISCWSA"\n'
                                      'extends = "iscwsa_mwd_rev4"\nfirst_leg = "doubled"\nterms = []\n')


def check_set(folder):
    c = run(folder, HEAD.format(model='file = "rev4.toml"') + "".join(offset(i) for i in SLOTS))
    for i in SLOTS:
        p = columns(f"set_offset_{i}_clearance.csv")
        o = {k: v[(c["offset"] == str(i)) & (c["formulation"] == "independent")] for k, v in c.items()}
        held(f"set, offset {i}, distance", o["distance_m"], p["distance_m"], .0055)
        held(f"set, offset {i}, offset md", o["offset_md_m"], p["offset_md_m"], .0055)
        # Bearings are printed to 0.001 deg, of positions that are rounded to 0.01 m.
        level = np.hypot(p["offset_north_m"] - p["ref_north_m"], p["offset_east_m"] - p["ref_east_m"])
        held(f"set, offset {i}, bearing", turn(o["horizontal_bearing_deg"], p["horizontal_bearing_deg"]), 0,
             .0005 + np.degrees(.015 / np.maximum(level, .1)), level > .1)
        sf = p["separation_factor"]
        held(f"set, offset {i}, factor", o["separation_factor"], sf, np.where(sf < 10, .002, np.maximum(.01, .005 * sf)))


def check_correlation(folder):
    for model, i, key in (("srgm", 1, "srgm"), ("srgm", 6, "srgm"), ("ifr1", 1, "ifr1"), ("ifr1", 6, "ifr1"), ("ifr1", 1, "ifr1_srgm")):
        more = 'error_model = { file = "srgm.toml" }\n' if key == "ifr1_srgm" else ""
        c = run(folder, HEAD.format(model=f'file = "{model}.toml"') + offset(i, more))
        p = columns(f"correlation_offset_{i}_clearance.csv")
        for f in ("independent", "geomagnetic"):
            o = {k: v[c["formulation"] == f] for k, v in c.items()}
            beyond_tie_on = p["ref_md_m"] > 0  # where the workbook has the tie-on's depth error and a floor of the sd
            for name, own in ((f"sd_relative_m_{key}_{f}", "sd_relative_m"), (f"separation_factor_{key}_{f}", "separation_factor"),
                              (f"ellipse_separation_m_{key}_{f}", "ellipse_separation_m"), ("distance_m", "distance_m"),
                              ("offset_md_m", "offset_md_m")):
                held(f"correlation, {key}, offset {i}, {f}, {own}", o[own], p[name], .0055, beyond_tie_on)


def main():
    if not (DATA / "set_reference.csv").exists():
        print(f"skipped: no figures in {DATA}")
        sys.exit(77)
    with tempfile.TemporaryDirectory(prefix="surveymc-clearance-") as name:
        folder = pathlib.Path(name)
        write_inputs(folder)
        check_set(folder)
        check_correlation(folder)
    for line in wrong:
        print("WRONG", line)
    sys.exit(1 if wrong else 0)


main()
