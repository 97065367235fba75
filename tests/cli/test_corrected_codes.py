#!/usr/bin/python3
"""corrected_codes: the class by first order is that by trials, and what cannot be drawn is refused: test_corrected_codes.py SURVEYMC SOURCE [TEST ...]"""
import pathlib
import subprocess
import sys
import tempfile
import unittest

import h5py

EXECUTABLE, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
CONFIGS = SOURCE / "configs/corrected_codes"


def run(config, *options):
    """Exit code, what it says, and the result (None without one)."""
    with tempfile.TemporaryDirectory() as folder:
        result = pathlib.Path(folder) / "result.h5"
        done = subprocess.run([EXECUTABLE, "run", config, "-o", result, *options], capture_output=True, text=True)
        tables = {}
        if result.exists():
            with h5py.File(result) as file:
                for name, table in file["tables"].items():
                    tables[name] = {c: [x.decode() if isinstance(x, bytes) else x for x in table[c][()]]
                                    for c in table if c != "row"}
        return done.returncode, done.stdout + done.stderr, tables


def classes(claims, quantity):
    """(by first order, by trials) of the last station of every cell, scope magnetic, where both are decided."""
    last = {}
    for i, found in enumerate(claims["quantity"]):
        if found == quantity:
            last[tuple(claims[key][i] for key in claims if "." in key)] = i
    pairs = [(claims["predicted_class"][i], claims["class"][i]) for i in last.values()]
    return [p for p in pairs if "undetermined" not in p and "undecided" not in p], len(pairs)


class CorrectedCodes(unittest.TestCase):
    def check_classes(self, *options, at_least):
        code, said, tables = run(CONFIGS / "random_cells.toml", *options)
        self.assertEqual(code, 0, said)
        for quantity in ("lateral", "azimuth"):
            decided, cells = classes(tables["claims"], quantity)
            right = sum(a == b for a, b in decided)
            self.assertGreater(len(decided), at_least, quantity)
            self.assertGreaterEqual(right, 0.95 * len(decided), f"{quantity}: {right} of {len(decided)}, {cells} cells")

    def test_classes_of_random_cells(self):
        self.check_classes("--set", 'sweep.design = { kind = "latin_hypercube", points = 60, seed = 11 }', "--set",
                           'compare.quantities = ["lateral", "azimuth"]', at_least=25)

    def test_parameter_sets_refused(self):
        for setting, message in (('prediction.orders = ["second"]', "six gains and biases"),
                                 ("estimator.accelerometer_mps2 = 0.0", "must be > 0"),
                                 ('correction.kind = "msa"', "needs correction.kind"),
                                 ('estimator.estimated = ["bias_z"]', "is not of estimators by estimator.parameters")):
            with self.subTest(setting=setting):
                code, said, _ = run(SOURCE / "configs/smoke/corrected_codes_parameters.toml", "--set", setting)
                self.assertEqual(code, 65, said)
                self.assertIn(message, said)

    def test_refused(self):
        for key, value, message in (("code.base", "MWD+IFR1+AX", "ABIXY-TI1S"), ("code.base", "GYRO-NS", "GYRO-NS"),
                                    ("code.claimed", "GYRO-NS", "no term of a magnetic tool code"),
                                    ("code.base", "MWD+IFR3", "no such tool code"),
                                    ("correction.kind", "msa4", "msa3")):
            with self.subTest(value=value):
                code, said, _ = run(SOURCE / "configs/new/corrected_codes.toml", "--set", f'{key} = "{value}"')
                self.assertEqual(code, 65, said)
                self.assertIn(message, said)

    def test_orders_are_made_of_normals(self):
        config = SOURCE / "configs/smoke/corrected_codes_orders.toml"
        code, said, _ = run(config, "--set", "draw.turn = true")
        self.assertEqual(code, 65, said)
        self.assertIn("draw.turn draws a uniform angle", said)

    def test_at_a_tenth_of_all_errors_the_orders_agree(self):
        """Second order to 1e-3 with first, the profile to 1e-4 with second; first order is that of the claims but for its
        derivatives of minimum curvature."""
        config = SOURCE / "configs/smoke/corrected_codes_orders.toml"
        code, said, tables = run(config, "--set", "draw.scale = 0.1", "--set", "trials = 0", "--set",
                                 'sweep.correction.kind = ["none", "msa", "msa3", "axial"]')
        self.assertEqual(code, 0, said)
        rows, claims = tables["orders"], tables["claims"]
        self.assertEqual(len(rows["quantity"]), 4 * 4)
        predicted = {(claims["correction"][i], q): claims["predicted"][i] for i, q in enumerate(claims["quantity"])}
        for i, quantity in enumerate(rows["quantity"]):
            with self.subTest(correction=rows["correction"][i], quantity=quantity):
                self.assertEqual(rows["order"][i], "first")
                self.assertLess(abs(rows["sd_second"][i] / rows["sd_first"][i] - 1), 1e-3)
                self.assertLess(abs(rows["sd_profile"][i] / rows["sd_second"][i] - 1), 1e-4)
                if (key := (rows["correction"][i], quantity)) in predicted:
                    self.assertLess(abs(rows["sd_first"][i] / predicted[key] - 1), 0.01)

    def test_a_tenth_of_all_errors(self):
        """Where errors are small Monte Carlo is first order; nightly to 1 %."""
        code, said, tables = run(CONFIGS / "tenth_of_errors.toml", "--trials", "4096")
        self.assertEqual(code, 0, said)
        rows = tables["prediction"]
        judged = [(rows["case"][i], rows["correction.kind"][i], q, rows["ratio"][i]) for i, q in enumerate(rows["quantity"])
                  if q in ("ratio_lateral", "ratio_azimuth")]
        self.assertEqual(len(judged), 2 * 5 * 14)
        for row in judged:
            self.assertAlmostEqual(row[3], 1, delta=0.05, msg=row)

    def test_first_order_needs_no_trials(self):
        config = SOURCE / "configs/new/corrected_codes.toml"
        (_, _, drawn), (_, _, alone) = run(config, "--trials", "64"), run(config, "--set", "trials = 0")
        for name in ("predicted_ratio", "predicted_ratio_before", "predicted_verdict", "predicted_class"):
            self.assertEqual(drawn["claims"][name], alone["claims"][name])
        self.assertEqual(set(alone["claims"]["claim"]), {""})


class Nightly(unittest.TestCase):
    check_classes = CorrectedCodes.check_classes

    def test_classes_of_250_cells(self):
        self.check_classes(at_least=150)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *(sys.argv[3:] or ["CorrectedCodes"])], verbosity=2)
