#!/usr/bin/python3
"""Draws docs/figures/real_instruments.png, a panel for each hand-held instrument of docs/studies/real_readings.md:

    scripts/draw_real_readings.py build/surveymc FOLDER docs/figures/real_instruments.png

FOLDER has the readings, as JSON (furbrain/CircuitPython_mag_cal, tests/fixtures: SAP6_*.json, and cal_*.json of cal_data), which are
no part of the project. Prints what is drawn.
"""
import pathlib
import subprocess
import sys
import tempfile

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.patches import Patch  # noqa: E402

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import docs_site  # noqa: E402
import surveymc  # noqa: E402
from surveymc.plots import drawing, sets_figure  # noqa: E402

#: How the JSON of a kind of instrument is read.
KINDS = {"SAP6": ["--axes", "g=-y-x+z,b=+x+y-z", "--gravity-unit", "mps2"],
         "cal": ["--axes", "g=+x+y+z,b=+x+y+z", "--gravity-unit", "g", "--columns", "g=shots.grav,b=shots.mag"]}
DRAWN = ("least_squares", "cauchy", "tukey")
SETS = ("6", "9", "12", "15", "18", "21")
LEAST, MOST = 0.3, 10  # degrees of the axis that are drawn
CONFIG = """
experiment = "estimate"
readings = "readings.csv"
field = {{ total_nT = {total}, dip_deg = 60.0, gravity_mps2 = {gravity} }}
estimator = {{ name = "multistation", parameters = "justified", use_priors = false, reference = "unknown" }}
residual_sd = {{ gravity_mps2 = {gravity_sd}, field_nT = {field_sd}, sine_of_dip = 0.004 }}
group = [{{ first = 9, last = 16 }}, {{ first = 17, last = 24 }}]
"""


def sets_of(program, path):
    """Table `sets` of an instrument, whose lengths shall be the medians of what it reads."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        quiet = {"check": True, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        subprocess.run([program, "import", path, "--readings", *KINDS[path.stem.split("_")[0]], "--field-unit", "uT", "--depth-step", "1",
                        "-o", folder / "readings.csv"], **quiet)
        heads = (folder / "readings.csv").read_text().splitlines()[0]
        readings = np.loadtxt(folder / "readings.csv", delimiter=",", skiprows=1)
        gravity = np.clip(np.median(np.linalg.norm(readings[:, 1:4], axis=1)) * (0.00980665 if "gx_mg" in heads else 1), 9.7, 9.9)
        total = 1000 * np.median(np.linalg.norm(readings[:, 4:7], axis=1))
        (folder / "run.toml").write_text(CONFIG.format(total=total, gravity=gravity, gravity_sd=0.002 * gravity, field_sd=0.004 * total))
        subprocess.run([program, "run", folder / "run.toml", "-o", folder / "out.h5"], **quiet)
        return surveymc.open(folder / "out.h5").table("sets")


def main():
    program, folder, picture = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    paths = [path for kind in KINDS for path in sorted(folder.glob(f"{kind}_*.json"))]
    drawing.use_style()
    figure, axes = drawing.panels(len(paths), (2.7, 2.2), columns=4)
    for ax, path in zip(axes, paths):
        table = sets_of(program, path)
        squares = table[table["loss"] == "least_squares"].set_index("set")
        print(path.stem, f"as read {squares['raw_axis_rms_deg'].max():.0f}", *(f"{s}: {squares['axis_rms_deg'][s]:.2f}" for s in SETS),
              *(s for s in SETS if squares["judgement"][s] == "justified"))
        for place, name in enumerate(SETS):
            if squares["judgement"][name] in ("justified", "as good"):
                ax.axvspan(place - 0.45, place + 0.45, color="#009E73", alpha=0.25 if squares["judgement"][name] == "justified" else 0.1, linewidth=0)
        for k, loss in enumerate(DRAWN):
            _, colour, marker = sets_figure.LOSSES[loss]
            axis = table[table["loss"] == loss].set_index("set")["axis_rms_deg"]
            ax.plot([place + 0.22 * (k - 1) for place in range(len(SETS))], [min(axis[s], MOST) for s in SETS], linestyle="none", color=colour, marker=marker, markersize=4.5)
        ax.set_yscale("log")
        ax.set_ylim(LEAST, 1.15 * MOST)
        ax.set_yticks([0.5, 1, 2, 5, 10], ["0.5", "1", "2", "5", f"\N{GREATER-THAN OR EQUAL TO}{MOST}"])
        ax.minorticks_off()
        ax.set_xticks(range(len(SETS)), SETS)
        ax.grid(False, axis="x")
        ax.set_title(f"{path.stem.replace('_', ' ')}, as read {squares['raw_axis_rms_deg'].max():.0f}\N{DEGREE SIGN}", fontsize=10)
    drawing.heading(figure, "Eleven hand-held instruments: scatter of the axis turned about (\N{DEGREE SIGN})",
                    "By sets of 6 to 21 errors of the tool; each group of eight rolls is judged by a fit of the others. No mark: no fit.")
    handles = [plt.Line2D([], [], linestyle="none", color=colour, marker=marker, label=label)
               for label, colour, marker in (sets_figure.LOSSES[loss] for loss in DRAWN)]
    drawing.legend_below(figure, [*handles, Patch(color="#009E73", alpha=0.25, label="justified"), Patch(color="#009E73", alpha=0.1, label="as good")])
    with tempfile.TemporaryDirectory() as name:
        whole = pathlib.Path(name) / "whole.png"
        figure.savefig(whole, dpi=150)
        docs_site.smaller(whole, picture, 1000)


if __name__ == "__main__":
    main()
