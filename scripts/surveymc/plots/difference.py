"""Draw which values of two results differ: z of every value that chance can move, with the limit for all of them together.

    surveymc plot difference A.h5 B.h5 [-o FOLDER]

Asks `surveymc diff`. z = difference over its standard error; beyond the lines a value differs among all of them (Bonferroni,
the first step of Holm's procedure). Only for results of other seeds: the same draws have no chance in them.
"""
import json
import statistics
import subprocess
import textwrap

import matplotlib.pyplot as plt
import numpy as np

from .. import program
from ..arguments import Parser
from . import drawing, reading, saving, wording
from .reading import PlotError

LEVEL = 0.05
COLOURS = {"chance": "#0072B2", "differs": "#D55E00"}
MOST_NAMES = 12


def differences(a, b):
    """Columns of `surveymc diff A B`: {name: list}."""
    done = subprocess.run([program.find_program(), "diff", a, b, "--json"], capture_output=True, text=True)
    if done.returncode not in (0, 1):
        raise PlotError(done.stderr.strip().removeprefix("error: ") or "surveymc diff failed", done.returncode)
    return {c["name"]: c["values"] for c in json.loads(done.stdout)["columns"]}


def normal(p):
    """How many standard errors have this two-sided p."""
    return -statistics.NormalDist().inv_cdf(p / 2)


def difference_figure(title, found):
    number = {k: np.array([np.nan if x is None else float(x) for x in found[k]]) for k in ("difference", "standard_error", "p_value")}
    finding = np.array(found["finding"])
    at = np.flatnonzero(np.isin(finding, list(COLOURS)) & np.isfinite(number["p_value"]))
    if not len(at):
        return None
    z = np.sign(number["difference"][at]) * np.array([normal(p) for p in np.maximum(number["p_value"][at], 1e-300)])
    named = sorted(np.flatnonzero(finding[at] == "differs"), key=lambda i: -abs(z[i]))[:MOST_NAMES]
    wide = 7.2 + (4.6 if named else 0)  # names of rows are long: they stand beside the panel, by number
    figure, ax = plt.subplots(figsize=(wide, 4.4))
    for kind, colour in COLOURS.items():
        here = finding[at] == kind
        if here.any():
            words = "differs among all" if kind == "differs" else "no difference beyond chance"
            ax.plot(np.flatnonzero(here) + 1, z[here], linestyle="none", marker="o", markersize=4, color=colour, label=words)
    limit = normal(LEVEL / len(at))
    for sign in (-1, 1):
        ax.axhline(sign * limit, color="black", linewidth=0.9, label="limit for all together, 5 %" if sign > 0 else None)
        ax.axhline(sign * normal(LEVEL), color="black", linewidth=0.7, linestyle=(0, (4, 2)),
                   label="limit for one alone" if sign > 0 else None)
    names = []
    for k, i in enumerate(named, 1):
        drawing.label_points(ax, str(k), (i + 1, z[i]), is_up=z[i] > 0, fontsize=7)
        names.append(textwrap.fill(f"{k}: " + wording.plain_text(found["row"][at[i]].replace("_", " ")), 62, subsequent_indent="     "))
    if names:
        figure.text(7.1 / wide, 0.93, "\n".join(names), va="top", fontsize=7, linespacing=1.3)
    high = max(limit, np.abs(z).max()) * 1.15
    ax.set_ylim(-high, high)
    ax.set_xlabel(f"Values that chance can move, in the order of the files ({len(at)})")
    ax.set_ylabel("Difference over its standard error")
    ax.set_title(title, fontsize=10)
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncol=2, fontsize=8)
    figure.tight_layout(rect=(0, 0, 7.1 / wide, 1))
    return figure


def main():
    parser = Parser(description=__doc__.splitlines()[0])
    parser.add_argument("a", metavar="A.h5", help="result file (HDF5) of surveymc")
    parser.add_argument("b", metavar="B.h5", help="another of the same experiment")
    parser.add_argument("-o", "--output", metavar="FOLDER", help="where to write (default: the folder of B)")
    arguments = parser.parse_args()
    drawing.use_style()
    stems = [saving.stem_of(p) for p in (arguments.a, arguments.b)]
    reading.Saved.results += stems  # of other files it is another figure
    figure = difference_figure(f"{stems[1]} against {stems[0]}", differences(arguments.a, arguments.b))
    if figure is None:
        raise PlotError(f"{arguments.b}: has no value that chance can move against {arguments.a}")
    saving.save(figure, saving.figures_folder(arguments.output, arguments.b), f"{stems[1]}_difference")
