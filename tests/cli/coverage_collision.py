#!/usr/bin/python3
"""Do 95 % intervals of collision hold the exact probability in 95 % of the runs? coverage_collision.py SURVEYMC [RUNS]

Wells that are displaced as they are (the places of their slots alone are uncertain), 1e-3 to 1e-10, whole procedure with
another preparation each run: vertical wells (disc) and horizontal ones that cross (slab, and between slab and disc). The
share of RUNS (400) that holds must be within 3.3 standard errors of .93 .. .975; no trusted estimate may be off by more
than its interval's width beyond the interval. Nightly: some minutes."""
import csv
import io
import math
import subprocess
import sys
import tempfile
from pathlib import Path

BASE = """\
experiment = "collision"
seed = 1
trials = 2000
[survey]
file = "{reference}.csv"
azimuth_reference = "true"
hole_diameter_in = 36.0
slot_sd_m = {sd}
[field]
total_nT = 50000.0
dip_deg = 70.0
[error_model]
name = "MWD+SRGM"
[errors]
multiplier = 1e-9
{offsets}
[separation]
formulations = ["independent"]
[sampling]
method = "importance"
subset = {{ replicates = 0 }}
"""
OFFSET = """\
[[offset]]
name = "{name}"
file = "{file}.csv"
azimuth_reference = "true"
hole_diameter_in = 24.0
slot_m = [{north:.9f}, {east:.9f}, {down:.1f}]
slot_sd_m = {sd}
"""
# Exact: quadrature.
VERTICAL = {10: 1.360392e-3, 25: 1.858687e-5, 35: 1.375242e-7, 46: 9.420310e-11}
CROSSING = {(90, 18): 1.952206e-4, (5, 18): 1.952061e-4, (2, 18): 1.746723e-4, (1, 18): 1.169034e-4, (.3, 18): 4.503524e-5,
            (60, 12): 6.951673e-3, (60, 22): 8.151768e-6, (60, 30): 2.111985e-9}


def write_configs(folder):
    def well(name, inclination, azimuth, legs):
        lines = "".join(f"{30 * k},{inclination},{azimuth}\n" for k in range(legs + 1))
        (folder / f"{name}.csv").write_text("md_m,inclination_deg,azimuth_deg\n" + lines)
    well("vertical", 0, 0, 19)
    (folder / "vertical.toml").write_text(BASE.format(reference="vertical", sd="[5.0, 8.0, 0.0]", offsets="".join(
        OFFSET.format(name=d, file="vertical", north=d, east=0, down=0, sd="[6.0, 9.0, 0.0]") for d in VERTICAL)))
    well("to_0", 90, 0, 30)
    offsets = ""
    for angle, gap in CROSSING:
        well(f"to_{angle}", 90, angle, 30)
        turn = math.radians(angle)
        offsets += OFFSET.format(name=f"{angle} {gap}", file=f"to_{angle}", north=450 - 450 * math.cos(turn),
                                 east=-450 * math.sin(turn), down=gap, sd="[5.0, 8.0, 4.0]")
    (folder / "crossing.toml").write_text(BASE.format(reference="to_0", sd="[5.0, 6.0, 3.0]", offsets=offsets))
    return {"vertical.toml": {str(d): p for d, p in VERTICAL.items()},
            "crossing.toml": {f"{a} {g}": p for (a, g), p in CROSSING.items()}}


def main():
    program, runs = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 400
    held, wrong, seen = {}, [], {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for config, exact in write_configs(folder).items():
            for seed in range(1, runs + 1):
                out = folder / "r.h5"
                subprocess.run([program, "run", folder / config, "-o", out, "--overwrite", "--quiet", "--seed", str(seed)],
                               check=True, stdout=subprocess.DEVNULL)

                def rows(table):
                    done = subprocess.run([program, "show", out, table, "--csv"], check=True, capture_output=True, text=True)
                    return list(csv.DictReader(io.StringIO(done.stdout)))
                trusted = {r["offset"]: r["trusted"] == "1" for r in rows("sampling")}
                for r in rows("probability"):
                    if r["formulation"] != "form":
                        continue
                    low, high, p = float(r["monte_carlo_ci_low"]), float(r["monte_carlo_ci_high"]), exact[r["offset"]]
                    key = (config, r["offset"])
                    held[key] = held.get(key, 0) + (low <= p <= high)
                    least, most = seen.get(key, (9, 0))
                    seen[key] = min(least, float(r["monte_carlo"]) / p), max(most, float(r["monte_carlo"]) / p)
                    if trusted[r["offset"]] and not 2 * low - high <= p <= 2 * high - low:
                        wrong.append((*key, seed))
    slack = 3.3 * math.sqrt(.95 * .05 / runs)
    failed = bool(wrong)
    for key, count in held.items():
        share = count / runs
        good = .93 - slack <= share <= .975 + slack
        failed = failed or not good
        print(f"{key[0][:-5]} {key[1]}: {share:.3f} of {runs} runs hold, estimate / exact {seen[key][0]:.3f} to {seen[key][1]:.3f}"
              f"{'' if good else ': NOT in .93 .. .975'}")
    print(f"trusted and wrong: {wrong or 'none'}")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
