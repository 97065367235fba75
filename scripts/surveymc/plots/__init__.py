"""Figures of results. Each drawer is a module with a function main(); `python3 -m surveymc.plots` runs them.

reading: files, tables, points of a sweep; wording: words and numbers; geometry: error ellipses; drawing: style, labels,
axes; ratios: predictions beside what was found; one_point: a point cut out of a sweep; saving: command line and files;
runner: starts drawers.
"""

import matplotlib

matplotlib.use("Agg")  # files, no windows
