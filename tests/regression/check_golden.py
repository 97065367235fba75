#!/usr/bin/python3
"""Holds the tables of a smoke run against those kept here, so that no number changes unnoticed.

    check_golden.py SURVEYMC [--update] RESULT.h5 ...

Compares every table of a result that tests/regression/<stem>.<table>.csv exists for: words exactly, numbers to 1e-9 of
their size (the last digits may follow the compiler). --update writes the files of the tables named in TABLES with at
most 60 rows; of the longer ones in CHOSEN_COLUMNS only these columns, which say it all. Say in the commit why the
numbers changed.
"""
import csv
import io
import math
import pathlib
import subprocess
import sys

import h5py

HERE = pathlib.Path(__file__).resolve().parent
TABLES = ("parameters", "position", "ellipse", "control_variate", "observability", "fit", "stations", "covariance",
          "ellipsoid", "summary", "verification", "toolface_sequences", "axes", "statements", "tolerance",
          "worst_stations", "systematic", "detection", "injected", "alarms", "blame", "claims", "delay", "failures",
          "profile", "metrics", "comparison", "operating", "baselines", "data_quality",
          "reference_field", "magnetic_elements", "interference", "modes", "outliers", "rms", "unstart", "worse",
          "gyro", "tool_codes", "validity", "by_source", "least", "relative_covariance", "relative_position",
          "probability", "sampling", "design_points", "importance",
          "calibration", "family", "sensitivity", "prediction", "requirement", "shares", "tails", "laws", "benefit", "breakdown")
# What follows from interval, margin and verdict, which are kept; tests/compare/test_family.cpp judges it.
DERIVED = {"p_differs", "p_agrees", "family", "wishart_family", "trials_to_decide"}
# Long tables: the mean over realisations, and nothing that follows from it.
CHOSEN_COLUMNS = {"metrics": {"formulation", "quantity", "monte_carlo"}}


def tables_of(result):
    with h5py.File(result) as file:
        return set(file["tables"])


def table(surveymc, result, name):
    """Its text and rows; None if the result has no such table."""
    shown = subprocess.run([surveymc, "show", result, name, "--csv"], capture_output=True, text=True)
    if shown.returncode != 0:
        return None
    rows = list(csv.reader(io.StringIO(shown.stdout)))
    if name in CHOSEN_COLUMNS:
        sweep = set(rows[0][:rows[0].index("formulation")])
        chosen = [i for i, column in enumerate(rows[0]) if column in CHOSEN_COLUMNS[name] | sweep]
    elif "p_differs" in rows[0]:
        chosen = [i for i, column in enumerate(rows[0]) if column not in DERIVED]
    else:
        return shown.stdout, rows
    rows = [[row[i] for i in chosen] for row in rows]
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue(), rows


def same(a, b):
    try:
        x, y = float(a), float(b)
    except ValueError:
        return a == b
    return math.isclose(x, y, rel_tol=1e-9, abs_tol=1e-12) or (math.isnan(x) and math.isnan(y))


def check(surveymc, result, update):
    """Whether a table is not as it was kept; with update its file is written."""
    stem = pathlib.Path(result).stem
    bad = []
    in_result = tables_of(result)
    for name in TABLES:
        golden = HERE / f"{stem}.{name}.csv"
        if name not in in_result:
            if golden.exists():
                bad.append(f"{golden.name}: the run has no table {name} any more")
            continue
        text, rows = table(surveymc, result, name)
        if update:
            if len(rows) <= 61 or name in CHOSEN_COLUMNS:
                golden.write_text(text)
            continue
        if not golden.exists():
            continue
        kept = list(csv.reader(io.StringIO(golden.read_text())))
        if [len(r) for r in kept] != [len(r) for r in rows]:
            bad.append(f"{golden.name}: has another shape")
            continue
        notes = {i for i, column in enumerate(kept[0]) if column == "note"}  # their rounded numbers may tip over
        for line, (old, new) in enumerate(zip(kept, rows), 1):
            for i, (a, b) in enumerate(zip(old, new)):
                if i not in notes and not same(a, b):
                    bad.append(f"{golden.name}:{line}: {kept[0][i]} = {b}, was {a}")
    print("\n".join(bad) or f"{stem}: as kept")
    return bool(bad)


def main():
    results = [a for a in sys.argv[2:] if a != "--update"]
    return any([check(sys.argv[1], result, "--update" in sys.argv) for result in results]) or not results


if __name__ == "__main__":
    sys.exit(main())
