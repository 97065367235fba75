#!/usr/bin/python3
"""Figures of scripts/plot_reliability_well.py from the smoke run: SURVEYMC_RESULT names its file."""
import os
import unittest

import drawing


class ReliabilityWell(drawing.Drawing):
    script = "plot_reliability_well.py"

    def test_effects_over_depth(self):
        self.assertEqual(sorted(self.figures(os.environ["SURVEYMC_RESULT"])),
                         ["reliability_well.png", "reliability_well.svg"])


if __name__ == "__main__":
    unittest.main()
