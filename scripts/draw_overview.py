#!/usr/bin/python3
"""Draws the picture of README.md, a well with its ellipsoids beside prediction against Monte Carlo:

    surveymc run configs/iscwsa/well1_rev5.10.toml -o well.h5
    surveymc run configs/thesis/noise_scale.toml --trials 200000 -o noise_scale.h5
    scripts/draw_overview.py well.h5 noise_scale.h5 docs/figures/overview.png
"""
import pathlib
import sys

import matplotlib
import matplotlib.ticker
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from PIL import Image  # noqa: E402

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import surveymc  # noqa: E402
from surveymc import view3d  # noqa: E402

ENLARGED = 10
SIGMA = 2
COLOURS = {"test 1": "#0072b2", "test 2": "#d55e00", "test 3": "#009e73", "test 4": "#cc79a7"}
LINES = {"joint": "-", "profile": "--"}  # first order; the path along the direction that dominates


def draw_well(axes, result):
    """Path and ellipsoids, by three great ellipses each."""
    scene = view3d.wells(result)["scenes"][0]
    path = np.array([scene["wells"][0][name] for name in ("north", "east", "down")])
    axes.plot(path[1], path[0], -path[2], color="#222222", linewidth=1.8)
    turn = np.linspace(0, 2 * np.pi, 61)
    circle = np.array([np.cos(turn), np.sin(turn)])
    for ellipsoid in scene["ellipsoids"][::max(len(scene["ellipsoids"]) // 10, 1)]:
        half = np.array(ellipsoid["axes"]).T * SIGMA * ENLARGED  # one sd each
        for pair in ([0, 1], [0, 2], [1, 2]):
            north, east, down = half[:, pair] @ circle + np.array(ellipsoid["centre"])[:, None]
            axes.plot(east, north, -down, color="#0072b2", linewidth=0.8, alpha=0.8)
    axes.set_aspect("equal")
    axes.set_box_aspect(np.ptp([axes.get_xlim(), axes.get_ylim(), axes.get_zlim()], axis=1), zoom=1.1)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_major_locator(matplotlib.ticker.MultipleLocator(2000))
    axes.zaxis.set_major_formatter(lambda height, _: f"{abs(height):.0f}")
    axes.set_xlabel("east (m)", labelpad=8)
    axes.set_ylabel("north (m)", labelpad=8)
    axes.set_zlabel("down (m)", labelpad=8)
    axes.view_init(elev=18, azim=-55)
    axes.set_title(f"A well and what is known of its position\n({SIGMA} sd, enlarged {ENLARGED} times)", fontsize=12)


def draw_agreement(axes, result):
    """Predicted over Monte-Carlo sd of north at the end, by two orders, against the size of the noise."""
    rows = result.table("position")
    rows = rows[rows["quantity"] == "sigma3_north"]
    axes.axhspan(0.97, 1.03, color="#009e73", alpha=0.15, label="within 3 %")
    axes.axhline(1, color="black", linewidth=0.8)
    for (case, formulation), of in rows.groupby(["case", "formulation"]):
        if formulation not in LINES:
            continue
        scale, ratio = of["noise.scale"].to_numpy(), of["ratio"].to_numpy()
        ends = np.abs(np.array([of["ratio_ci_low"], of["ratio_ci_high"]]) - ratio)
        first = formulation == "joint"
        axes.errorbar(scale, ratio, ends, marker="o", markersize=4, capsize=3, color=COLOURS[case],
                      linestyle=LINES[formulation], markerfacecolor=None if first else "white",
                      label=case if first else None)
    axes.plot([], [], color="#444444", linestyle=LINES["joint"], label="first order")
    axes.plot([], [], color="#444444", linestyle=LINES["profile"], label="profile")
    axes.set_xscale("log")
    axes.set_xticks([0.1, 0.2, 0.5, 1], ["0.1", "0.2", "0.5", "1"])
    axes.minorticks_off()
    axes.set(xlabel="size of the noise (1: as in the source)", ylabel="predicted / Monte Carlo, sd of north")
    axes.set_title("Does the prediction hold?\nTwo orders against 200,000 trials a point, 95 % intervals", fontsize=12)
    axes.legend(loc="lower left", frameon=False)


def main():
    well, scales, to = surveymc.open(sys.argv[1]), surveymc.open(sys.argv[2]), sys.argv[3]
    assert scales.trials == 200_000, "the title says so"
    figure = plt.figure(figsize=(11.5, 4.8), dpi=110)
    draw_well(figure.add_subplot(1, 2, 1, projection="3d"), well)
    draw_agreement(figure.add_subplot(1, 2, 2), scales)
    figure.tight_layout(w_pad=7)
    figure.savefig(to)
    with Image.open(to) as image:
        small = image.convert("RGB").quantize(64)
    small.save(to, optimize=True)


if __name__ == "__main__":
    main()
