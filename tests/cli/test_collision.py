#!/usr/bin/python3
"""End-to-end tests of collision and rare_event: test_collision.py SURVEYMC_EXECUTABLE SOURCE_FOLDER"""
import sys
import unittest
from pathlib import Path

import numpy as np

import test_cli
from test_cli import BAD_INPUT, Case, column, content_hash

VERTICAL = "md_m,inclination_deg,azimuth_deg\n" + "".join(f"{30 * k},0,0\n" for k in range(20))

# Nothing but the places of the slots is uncertain: parallel wells, displaced as they are. The disc is exact.
RIGID = """\
experiment = "collision"
seed = 6
trials = 4096
[survey]
file = "vertical.csv"
hole_diameter_in = 36.0
slot_sd_m = [5.0, 8.0, 0.0]
[field]
total_nT = 50000.0
dip_deg = 70.0
[error_model]
name = "MWD+SRGM"
[errors]
multiplier = 1e-9
[[offset]]
name = "other"
file = "vertical.csv"
hole_diameter_in = 24.0
slot_m = [25.0, 0.0, 0.0]
slot_sd_m = [6.0, 9.0, 0.0]
[separation]
formulations = ["independent"]
[sampling]
method = "importance"
subset = { replicates = 0 }
"""

FUNCTION = """\
experiment = "rare_event"
seed = 1
trials = 2048
[problem]
name = "union"
beta = [4.0, 4.5]
[sampling]
method = "union"
subset = { replicates = 0 }
"""


class Wells(Case):
    def setUp(self):
        super().setUp()
        self.write("vertical.csv", VERTICAL)
        self.write("base.toml", RIGID)

    def changed(self, *changes, text=RIGID, append=""):
        for old, new in changes:
            self.assertIn(old, text)
            text = text.replace(old, new, 1)
        self.write("changed.toml", text + append)
        return "changed.toml"

    def test_wells_displaced_as_they_are_have_the_probability_of_the_disc(self):
        path = self.run_config()
        formulation = list(column(path, "tables/probability", "formulation"))
        low, high, analytic = (column(path, "tables/probability", k)[formulation.index("disc")] for k in
                               ("monte_carlo_ci_low", "monte_carlo_ci_high", "analytic"))
        self.assertAlmostEqual(analytic, 1.858687e-5, delta=2e-11)
        half = (high - low) / 2
        self.assertLess(abs((high + low) / 2 - analytic), 2 * half)  # four standard errors
        self.assertLess(half, .05 * analytic)
        self.assertEqual(list(column(path, "tables/sampling", "trusted")), [1])
        factors = np.array(column(path, "tables/importance", "factor"))
        self.assertAlmostEqual(float(np.sum(factors)), 1, places=9)

    def test_parts_and_threads_do_not_change_a_bit(self):
        whole = self.run_config("--threads", "1")
        for i in range(3):
            self.call("run", "base.toml", "--shard", f"{i}/3", "-o", f"{i}.part")
        self.call("merge", "0.part", "1.part", "2.part", "-o", "merged.h5")
        self.assertEqual(content_hash(whole), content_hash(self.folder / "merged.h5"))

    def test_bad_input_is_refused_with_place_and_rule(self):
        for changes, says in (
                ([("[25.0, 0.0, 0.0]", "[0.5, 0.0, 0.0]")], r"slot_m.*touch as surveyed.*probability is 1"),
                ([('"importance"', '"exact"')], "sampling.method"),
                ([("replicates = 0", "replicates = 1")], "at least 2"),
                ([("[5.0, 8.0, 0.0]", "[5.0, -8.0, 0.0]")], "slot_sd_m"),
                ([("[sampling]\n", "[sampling]\nshares = { adapted = 0.5 }\n")], "must add up to 1"),
                ([("seed = 6\n", "seed = 6\nantithetic = true\n")], "antithetic"),
                ([('["independent"]', '["zeroed"]')], "zeroed"),
        ):
            self.refused(BAD_INPUT, "check", self.changed(*changes), says=says)

    def test_wells_that_no_source_moves_together_cannot_touch(self):
        path = self.run_config(config=self.changed(("[25.0, 0.0, 0.0]", "[25.0, 0.0, 900.0]")))
        self.assertEqual(set(column(path, "tables/probability", "monte_carlo")), {0.0})
        self.assertIn("impossible", list(column(path, "tables/sampling", "note"))[0])

    def test_a_union_is_drawn_at_any_level(self):
        path = self.run_config(config=self.changed(text=FUNCTION))
        self.assertEqual(list(column(path, "tables/probability", "verdict")), ["agrees"])
        for changes, says in (([("[4.0, 4.5]", "[]")], "problem.beta"),
                              ([("beta = [", "dimension = 1\nbeta = [")], "at most problem.dimension"),
                              ([('name = "union"\nbeta = [4.0, 4.5]', 'name = "rp25"')], "no union of half spaces"),
                              ([('name = "union"\nbeta = [4.0, 4.5]', 'name = "rp26"')], "problem.name"),
                              ([('name = "union"\nbeta = [4.0, 4.5]', 'name = "disc"\nmean = [0.0, 0.1]\nsd = [1.0, 1.0]\nradius = 1.0')],
                               "holds at z = 0")):
            self.refused(BAD_INPUT, "check", self.changed(*changes, text=FUNCTION), says=says)


if __name__ == "__main__":
    test_cli.EXECUTABLE, test_cli.SOURCE = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
