#!/usr/bin/python3
"""Figures of scripts/plot_gross_error.py from the smoke run: SURVEYMC_RESULT names its file."""
import os
import unittest

import drawing


class GrossError(drawing.Drawing):
    script = "plot_gross_error.py"

    def test_outcomes_by_strategy(self):
        self.assertEqual(sorted(self.figures(os.environ["SURVEYMC_RESULT"])),
                         ["gross_error_detection.png", "gross_error_detection.svg"])


if __name__ == "__main__":
    unittest.main()
