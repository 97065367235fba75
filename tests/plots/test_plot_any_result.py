#!/usr/bin/python3
"""Any result draws itself: new -> run -> plot of every study, as users do: without a sweep, with two points, along one key, on a
grid of two or three, and drawn at random.

No drawer fails, no text lies upon another or leaves its figure, no key stands in place of words, and each sweep has an
overview of its own. Every second study with one kind of sweep, of 25 points, another kind for the next; with
SURVEYMC_EVERY=1 all studies and kinds, of 400 points. The program is that of SURVEYMC; SURVEYMC_FIGURES=FOLDER keeps the figures, to be looked at.
"""
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import plot_case
from surveymc.plots import __main__ as plots

PROGRAM = os.environ.get("SURVEYMC", "surveymc")
QUANTITY = {"position_covariance": "covariance.sd_north_m", "reliability_map": "minimal_detectable_error"}  # chosen, too
EVERY = os.environ.get("SURVEYMC_EVERY") == "1"
KEPT = os.environ.get("SURVEYMC_FIGURES", "")
CUT = 20 if EVERY else 5  # points along an axis of a grid

# Three numeric keys of each study with ends, and what keeps a run short.
FIELD = {"field.dip_deg": (50.0, 75.0), "field.total_nT": (30000.0, 60000.0)}
STUDIES = {
    "axial_correction": ({**FIELD, "sigma.magnetometer_xy_nT": (20.0, 150.0)}, ["inclination_deg=[0.0,30.0,60.0,90.0]", "magnetic_azimuth_deg=[0.0,45.0,90.0,135.0]"]),
    "chained_multistation": ({**FIELD, "model.magnetometer_xy.random_nT": (20.0, 90.0)}, ["trials=8", 'estimators=["base","single","filter"]']),
    "clearance": ({"field.dip_deg": (50.0, 75.0), "separation.scale_factor": (2.0, 3.5), "separation.surface_margin_m": (0.1, 1.0)}, []),
    "collision": ({"field.dip_deg": (50.0, 75.0), "field.total_nT": (30000.0, 60000.0), "errors.multiplier": (0.5, 2.0)}, ["trials=256", "sampling.subset.replicates=0", "sampling.pilot=200"]),
    "robustness_map": ({**FIELD, "well.inclination_deg": (30.0, 85.0), "gross.size_nT": (500.0, 3000.0)}, ["trials=64", "gross.share=0.2"]),
    "corrected_codes": ({**FIELD, "well.inclination_deg": (30.0, 85.0)}, ["trials=64", "correction.kind=msa"]),
    "drift_monitoring": ({"drift.amplitude_z": (1.0, 8.0), "drift.start_h": (1.0, 3.0), "model.bandwidth": (0.2, 0.8)}, []),
    "error_model_monte_carlo": ({**FIELD, "errors.multiplier": (0.1, 3.0)}, ["trials=64"]),
    "estimate": ({**FIELD, "noise.magnetometer_nT": (20.0, 90.0)}, []),
    "gross_error_detection": ({**FIELD, "inclination_deg": (10.0, 80.0)}, ["trials=64"]),
    "msa_benefit": ({**FIELD, "noise.magnetometer_nT": (20.0, 90.0)}, ["trials=64", "inclination_deg=[10.0,40.0,70.0,90.0]", "azimuth_deg=[0.0,45.0,90.0,135.0]"]),
    "msa_position": ({**FIELD, "noise.magnetometer_nT": (20.0, 90.0)}, ["trials=64"]),
    "mwd_drift": ({**FIELD, "noise.magnetometer_nT": (10.0, 40.0)}, ["trials=16", "well.stations=30"]),
    "position_covariance": ({**FIELD, "field.declination_deg": (-10.0, 10.0)}, []),
    "rare_event": ({"problem.beta": (2.0, 4.0), "verdict.margin": (0.05, 0.3), "verdict.confidence": (0.8, 0.99)}, ['problem.name="linear"', "problem.beta=2.5", "trials=256", "sampling.subset.replicates=0", "sampling.pilot=200"]),
    "reliability_map": ({**FIELD, "sigma.total_field_nT": (20.0, 150.0)}, ["inclination_deg=[10.0,40.0,70.0,90.0]", "magnetic_azimuth_deg=[0.0,45.0,90.0,135.0]", "toolface_deg=[0.0,45.0]"]),
    "reliability_well": ({**FIELD, "alpha": (1e-4, 1e-2)}, ['observation=["bx","bz","total_field"]', 'toolface="worst"']),
    "sensor_monte_carlo": ({**FIELD, "sensor_errors.magnetometer_bias_nT": (20.0, 150.0)}, ["trials=64"]),
    "tool_code_map": ({**FIELD, "field.declination_deg": (-10.0, 10.0)}, ["map.inclination_deg=[0.0,30.0,60.0,90.0]", "map.azimuth_deg=[0.0,90.0,180.0,270.0]", 'codes=["MWD+SRGM","MWD+IFR1"]']),
    "vertical_well": ({**FIELD, "sensor_errors.accelerometer_bias_mps2": (0.001, 0.01)}, ["trials=64"]),
}


def _grid(ends, count):
    return {k: "{ from = %r, to = %r, count = %d }" % (*e, count) for k, e in ends.items()}


def sweep_of(kind, ends):
    """The [sweep] of a kind, as text."""
    first = dict(list(ends.items())[:2])
    if kind == "two":
        lines = _grid(dict(list(ends.items())[:1]), 2)
    elif kind == "curve":
        lines = _grid(dict(list(ends.items())[:1]), CUT)
    elif kind == "grid":
        lines = _grid(first, CUT)
    elif kind == "cube":
        lines = {**_grid(first, max(CUT // 2, 3)), **_grid(dict(list(ends.items())[2:]), 4)}
    elif kind == "random":
        lines = {"design": f'{{ kind = "latin_hypercube", points = {CUT**2}, seed = 3 }}',
                 **{k: "{ from = %r, to = %r }" % e for k, e in ends.items()}}
    else:
        return ""
    return "[sweep]\n" + "".join(f'{k if k == "design" else chr(34) + k + chr(34)} = {v}\n' for k, v in lines.items())


KINDS = ("one", "two", "curve", "grid", "cube", "random")


class AnyResult(unittest.TestCase):
    def test_all_studies_are_here(self):
        folder = Path(__file__).resolve().parents[2] / "configs" / "new"
        self.assertEqual(sorted(STUDIES), sorted(p.stem for p in folder.glob("*.toml")))

    def drawn(self, study, kind):
        ends, settings = STUDIES[study]
        with tempfile.TemporaryDirectory() as folder:
            config, result = Path(folder, f"{study}_{kind}.toml"), Path(folder, f"{study}_{kind}.h5")
            new = subprocess.run([PROGRAM, "new", study, "-o", config], capture_output=True, text=True)
            self.assertEqual(new.returncode, 0, new.stderr)
            text = re.sub(r"(?m)^\[sweep\].*\n(?:\S.*\n)*", "", config.read_text())
            sweep = sweep_of(kind, ends)
            config.write_text(text + "\n" + sweep)
            kept = (s for s in settings if f'"{s.split("=")[0]}"' not in sweep)  # --set takes the place of a sweep
            run = subprocess.run([PROGRAM, "run", config, "-o", result, "-q", "--threads", "2", *(w for s in kept for w in ("--set", s))],
                                 capture_output=True, text=True)
            self.assertEqual(run.returncode, 0, run.stderr)
            to = os.path.join(KEPT or folder, "figures")

            def command():
                sys.argv = ["surveymc plot", str(result), "-o", to]
                plots.command()

            done = plot_case.draw(command)
            if "one number, no figure" in done.stderr:  # a probability; the sentence has it
                self.assertIn(kind, ("one", "two"))
                return
            self.assertEqual(done.returncode, 0, done.stderr)
            names = [os.path.basename(n) for n in done.stdout.split("\n") if n.endswith(".png")]
            self.assertTrue(names)
            if study in QUANTITY:
                def choice():
                    sys.argv = ["surveymc plot", str(result), "-o", to, "--quantity", QUANTITY[study]]
                    plots.command()

                done = plot_case.draw(choice)
                self.assertEqual(done.returncode, 0, done.stderr)
            if kind not in ("one", "two"):
                self.assertTrue(any(n.startswith(f"{study}_{kind}_sweep_") for n in names), names)


def _add(study, kind):
    setattr(AnyResult, f"test_{study}_{kind}", lambda self: self.drawn(study, kind))


for _number, _study in enumerate(STUDIES if EVERY else list(STUDIES)[::2]):
    for _kind in KINDS if EVERY else (KINDS[_number % len(KINDS)],):
        _add(_study, _kind)

if __name__ == "__main__":
    unittest.main()
