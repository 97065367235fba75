#!/usr/bin/python3
"""Figures of surveymc.plots.reliability_well from the smoke run: SURVEYMC_RESULT names its file."""
import os
import unittest

import plot_case


class ReliabilityWell(plot_case.Drawing):
    script = "reliability_well"

    def test_effects_over_depth(self):
        self.assertEqual(sorted(self.figures(os.environ["SURVEYMC_RESULT"])),
                         ["reliability_well.png", "reliability_well.svg"])


if __name__ == "__main__":
    unittest.main()
