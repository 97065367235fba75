#!/usr/bin/python3
"""Figures of surveymc.plots.gross_error from the smoke run: SURVEYMC_RESULT names its file."""
import os
import unittest

import numpy as np

import plot_case
from surveymc.plots import gross_error as plot
from surveymc.plots import reading


class DesignedPower(unittest.TestCase):
    """The power is that of each point, and only where the errors are of the size that it is for."""

    def test_of_a_point(self):
        minimal, fixed = {"observation": "bx", "size": "minimal_detectable"}, {"observation": "bx", "size_nT": 90.0}
        for config, keys, point, power in (({"inject": [minimal]}, [], [], 0.8),
                                           ({"inject": [minimal], "power": 0.9}, [], [], 0.9),
                                           ({"inject": [minimal], "factor": -1}, [], [], 0.8),
                                           ({"inject": [minimal], "factor": 2.0}, [], [], None),
                                           ({"inject": [fixed]}, [], [], None),
                                           ({"inject": [minimal]}, ["power"], [0.95], 0.95),
                                           ({"inject": [minimal]}, ["factor"], [0.5], None),
                                           ({"inject": [minimal]}, ["factor"], [1.0], 0.8)):
            self.assertEqual(plot.designed_power(config, keys, point), power, (config, point))

    def bars(self, key, values, inject):
        """The lines of power beside bars of a sweep: [(power, from, to)]."""
        quantities = ["detection_bx", *plot.OUTCOMES]
        count = len(quantities)
        rows = {key: np.repeat(values, count), "quantity": quantities * len(values),
                "formulation": ["linear" if q == "detection_bx" else "single" for q in quantities] * len(values)}
        rows |= {c: np.full(count * len(values), 0.2) for c in ("monte_carlo", "monte_carlo_ci_low", "monte_carlo_ci_high", "analytic")}
        rows |= {"trials": np.full(count * len(values), 100.0), "failed": np.zeros(count * len(values))}
        table = reading.Table("detection", rows)
        figure = plot.bars_figure("t", table, [key], lambda i: plot.designed_power({"inject": inject}, [key], [table[key][i]]), "")
        self.assertIn("100 trials", figure.texts[-1].get_text())
        dashed = [x for x in figure.axes[0].lines if x.get_linestyle() == "--"]
        return [(x.get_xdata()[0], *x.get_ydata()) for x in dashed]

    def test_beside_bars(self):
        inject = [{"observation": "bx", "size": "minimal_detectable"}]
        self.assertEqual(self.bars("power", [0.5, 0.95], inject), [(0.5, -0.5, 0.5), (0.95, 0.5, 1.5)])
        self.assertEqual(self.bars("factor", [0.5, 1.0, 2.0], inject), [(0.8, 0.5, 1.5)])
        self.assertEqual(self.bars("factor", [1.0, -1.0], inject), [(0.8, 0, 1)])  # one line through all


    def test_one_case_has_a_line_for_each_rate(self):
        quantities = ["detection_bx", *plot.OUTCOMES]
        rates = np.arange(1, len(quantities) + 1) / 10
        table = reading.Table("detection", {"quantity": quantities, "formulation": ["linear"] + ["single"] * len(plot.OUTCOMES),
                                            "monte_carlo": rates, "monte_carlo_ci_low": rates - 0.01, "monte_carlo_ci_high": rates + 0.01,
                                            "analytic": rates + 0.02, "trials": np.full(len(rates), 100.0), "failed": np.zeros(len(rates))})
        figure = plot.bars_figure("t", table, [], lambda i: 0.8, plot.place_of({"inclination_deg": 85.0, "toolface_deg": [1.0, 2.0]}, [], []))
        self.assertIn("Inclination 85\N{DEGREE SIGN}.", figure.texts[-1].get_text())
        drawn = [line.get_xdata()[0] for bars in figure.axes[0].containers for line in [bars[0]]]
        np.testing.assert_allclose(drawn, rates)
        self.assertEqual([t.get_text() for t in figure.axes[0].get_yticklabels()][:2], ["the test of $b_x$ rejects", "rejected: the right ones, and only these"])


class GrossError(plot_case.Drawing):
    script = "gross_error"

    def test_outcomes_by_strategy(self):
        self.assertEqual(sorted(self.figures(os.environ["SURVEYMC_RESULT"])),
                         ["gross_error_detection.png", "gross_error_detection.svg"])


if __name__ == "__main__":
    unittest.main()
