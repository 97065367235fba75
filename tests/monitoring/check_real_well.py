#!/usr/bin/python3
"""The paper's protocol on a real well: check_real_well.py SURVEYMC TABLE2.toml FOLDER. Exit 77 where FOLDER is absent.

Bounds are on what must hold of this file: how it is read, that AKS follows faulty inputs less than AS, that the depletion of
the well is taken for a drift of its healthy bottom-hole gauge, by both, and what it shows of the source's claims, as
docs/studies/drift_monitoring.md says.
"""
import csv
import io
import os
import subprocess
import sys
import tempfile

SURVEYMC, CONFIG, FOLDER = sys.argv[1:4]
WELL = os.path.join(FOLDER, "WELL-00010_flow-instability_1min.csv")
SETTINGS = (f"source.file={WELL}", 'source.sensors=["P-PDG", "P-TPT", "P-MON-CKP"]', 'source.units=["Pa", "Pa", "Pa"]',
            "model.memory_vectors=1500", "drift.start_h=42", "filter.process_variance_z2=1e-4")


def main():
    if not os.path.exists(WELL):
        print(f"skipped: no {WELL}")
        return 77
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "well.h5")
        overrides = [a for s in SETTINGS for a in ("--set", s)]
        refused = subprocess.run([SURVEYMC, "run", CONFIG, *overrides, "--set", "source.bad_rows=reject", "-o", out],
                                 capture_output=True, text=True)
        assert refused.returncode == 65 and "empty sensor cell: 1 (line 4080)" in refused.stderr, refused.stderr
        assert not os.path.exists(out)
        subprocess.run([SURVEYMC, "run", CONFIG, *overrides, "-o", out], check=True, capture_output=True)

        def rows(table):
            shown = subprocess.run([SURVEYMC, "show", out, table, "--csv"], check=True, capture_output=True, text=True)
            return list(csv.DictReader(io.StringIO(shown.stdout)))

        found = {r["finding"]: int(r["rows"]) for r in rows("data_quality")}
        assert (found["empty"], found["gap"], found["good_rows"]) == (1, 37, 9908), found
        metrics = {(r["formulation"], r["quantity"]): float(r["monte_carlo"]) for r in rows("metrics") if r["monte_carlo"]}
        ratio = metrics["aakr_kf_sprt", "auto_sensitivity"] / metrics["aakr_sprt", "auto_sensitivity"]
        assert 0.3 < ratio < 0.8, ratio
        blamed = {r["architecture"]: r["p_alarm_without_drift"] for r in rows("alarms") if r["sensor"] == "P-PDG"}
        assert blamed["aakr_sprt"] == blamed["aakr_kf_sprt"] == "1", blamed
        claims = {r["quantity"]: (r["verdict"], float(r["monte_carlo"])) for r in rows("claims")}
        assert len(claims) == 6 and not any(verdict for verdict, _ in claims.values()), claims  # one realisation
        for claim, quoted, digits in [("blames_a_healthy_sensor", 1, 0), ("blames_no_healthy_sensor", 1, 0), ("auto_sensitivity_is_lower", 0.546, 3), ("cross_sensitivity_is_lower", 1.54, 2),
                                      ("unfaulted_mse_is_higher", 1.047, 3), ("drifting_mse_is_lower", 1.007, 3)]:
            assert round(claims[claim][1], digits) == quoted, claims[claim]  # one realisation, nothing is drawn
        assert subprocess.run([SURVEYMC, "rerun", out], capture_output=True, text=True).stdout.startswith("identical")
    print("as it must be")
    return 0


if __name__ == "__main__":
    sys.exit(main())
