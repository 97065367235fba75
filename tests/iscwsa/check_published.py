#!/usr/bin/python3
"""Holds position_covariance against all figures of the ISCWSA example workbooks: check_published.py SURVEYMC FOLDER

FOLDER has wellN_header.json, wellN_survey.csv, revR_well1_expected.csv (by source at four depths) and
revR_well1_totals.csv (every station). They are no part of the project: without them the exit code is 77 (skipped), and
the figures in configs/iscwsa/*.toml, which ctest always checks, have to do.
"""
import csv
import io
import json
import pathlib
import subprocess
import sys
import tempfile

SKIPPED = 77
ELEMENTS = ("nn", "ee", "vv", "ne", "nv", "ev")
TOLERANCE = 1e-10  # of the trace; the figures have 12 digits


def read(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def run(surveymc, data, folder, well, revision):
    """The tables covariance and covariance_by_source, a dict by depth (m) and source."""
    header = json.loads((data / f"{well}_header.json").read_text())
    unit = header["md_tvd_unit"]
    with open(folder / "survey.csv", "w") as file:
        file.write(f"md_{unit},inclination_deg,azimuth_deg,tvd_{unit}\n")
        for row in read(data / f"{well}_survey.csv"):
            file.write(",".join(row[c] for c in (f"md_{unit}", "inc_deg", "azi_true_deg", f"tvd_listed_{unit}")) + "\n")
    (folder / "well.toml").write_text(f"""
experiment = "position_covariance"
seed = 1
error_model = "iscwsa_mwd_{revision}"
[survey]
file = "survey.csv"
azimuth_reference = "{header['azimuth_reference'].lower()}"
[field]
total_nT = {float(header['b_total_nT'])}
dip_deg = {float(header['dip_deg'])}
declination_deg = {float(header['declination_deg'])}
convergence_deg = {float(header['convergence_deg'])}
gravity_mps2 = {header['g_mps2']}
""")
    subprocess.run([surveymc, "run", folder / "well.toml", "-o", folder / "well.h5"], check=True, capture_output=True)
    out = {}
    for table in ("covariance", "covariance_by_source"):
        text = subprocess.run([surveymc, "show", folder / "well.h5", table, "--csv"], check=True, capture_output=True,
                              text=True).stdout
        for row in csv.DictReader(io.StringIO(text)):
            out[float(row["md_m"]), row.get("source", "TOTAL")] = [float(row[f"{e}_m2"]) for e in ELEMENTS]
    return out


def difference(ours, theirs):
    """Largest difference of an element, relative to the trace."""
    worst = max(abs(a - b) for a, b in zip(ours, theirs))
    return worst / sum(theirs[:3]) if sum(theirs[:3]) > 0 else worst


def main():
    surveymc, data = sys.argv[1], pathlib.Path(sys.argv[2])
    if not (data / "well1_survey.csv").exists():
        print(f"skipped: the ISCWSA example figures are not in {data}: set SURVEYMC_SHARED_DATA in CMake")
        return SKIPPED
    bad, worst, compared = [], {}, 0
    with tempfile.TemporaryDirectory() as name:
        for revision in ("rev4", "rev5.10"):
            ours = run(surveymc, data, pathlib.Path(name), "well1", revision)
            rows = [(r["md_m"], r["source"], [r[f"calc_{e}"] for e in ELEMENTS])
                    for r in read(data / f"{revision}_well1_expected.csv")]
            rows += [(r["md_m"], "TOTAL", [r[e] or 0 for e in ELEMENTS])
                     for r in read(data / f"{revision}_well1_totals.csv")]
            known = {source for _, source in ours}
            given = {source for _, source, _ in rows}
            if known != given:
                bad.append(f"{revision}: sources differ: {sorted(known ^ given)}")
                continue
            for md, source, values in rows:
                d = difference(ours[float(md), source], [float(v) for v in values])
                compared += 1
                key = revision, "total" if source == "TOTAL" else "source"
                worst[key] = max(worst.get(key, 0), d)
                if not d <= TOLERANCE:
                    bad.append(f"{revision} well 1, {md} m, {source}: differs by {d:.2g} of the trace")
    for (revision, what), d in worst.items():
        print(f"well 1, {revision}, every {what}: largest difference {d:.2g} of the trace")
    print("\n".join(bad) or f"{compared} covariances agree")
    return bool(bad)


if __name__ == "__main__":
    sys.exit(main())
