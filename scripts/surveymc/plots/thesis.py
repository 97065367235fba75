"""Figures of the study of S. Vis (TU Delft 2019) that span its tests: configs/thesis/*.toml.

    surveymc plot thesis RESULT.h5 [-o FOLDER]

What the result has decides what is drawn, each as PNG and SVG:
<stem>_hypotheses        noise_hypotheses.toml: which reading of the noise reproduces table 5
<stem>_ladder            wls_ladder.toml: 3 sigma of each parameter, from WLS to MSA
<stem>_estimators        joint_estimation.toml: position after msa, msa_weighted, msa_joint
<stem>_published         table8.toml, table9_10_11.toml: position uncertainty, published and ours
<stem>_ellipsoids        table8.toml: figure 7 of the thesis, final positions with the 3-sigma ellipsoids

Figures of single points, and of the noise scale, are
surveymc plot msa_position's.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D

from . import drawing, estimator_figures, geometry, msa_position, ratios, reading, saving, wording
from .drawing import LOOK, PROPAGATIONS
from .reading import PlotError
from .wording import SIGMA

SPANS = ("noise.scale", "noise.law", "estimator.name")  # keys of a sweep that has figures of its own here

DIRECTIONS = ("north", "east")
REFERENCE_LOOK = {"exact": "#222222", "107 nT/.16 deg per run": "#D55E00", "130 nT/.20 deg per run": "#E69F00",
                  "107 nT/.16 deg per station": "#0072B2", "130 nT/.20 deg per station": "#56B4E9"}


# --- which reading of the noise -------------------------------------------------------------------------------------


def readings_of_the_noise(parameters):
    """All published / Monte-Carlo ratios of each reading over its tests: {(law, reference): array}, best rms first."""
    ratios = {}
    for i in range(parameters.rows):
        if parameters["quantity"][i].startswith("sigma3_") and parameters["published_ratio"][i] > 0:
            test, reference = parameters["case"][i].split(": ", 1)
            key = (parameters["noise.law"][i], reference.removeprefix("reference "))
            ratios.setdefault(key, {})[(test, parameters["quantity"][i])] = parameters["published_ratio"][i]
    arrays = {key: np.array(list(r.values())) for key, r in ratios.items()}
    return dict(sorted(arrays.items(), key=lambda kv: rms(kv[1])))


def rms(ratios):
    """Root mean square of ln(ratio): 0.1 is 10 % off."""
    return float(np.sqrt(np.mean(np.log(ratios) ** 2)))


def hypotheses_figure(title, parameters):
    ranked = readings_of_the_noise(parameters)
    tests = sorted({c.split(": ")[0] for c in parameters["case"]})
    count = len(ranked)
    figure, (ax, bars) = plt.subplots(1, 2, figsize=(12.0, 0.34 * count + 2.3), sharey=True, width_ratios=(2.6, 1), layout="constrained")
    size = len(next(iter(ranked.values())))
    drawing.heading(figure, title, f"{size} published standard deviations over Monte Carlo ({', '.join(tests)}; "
            f"{wording.counts_text(parameters['trials'])} trials a point). Noise law and reference on the left; "
            "the noise's size is the same in all.")
    for y, ((law, reference), r) in enumerate(ranked.items()):
        colour = REFERENCE_LOOK.get(reference, "#222222")
        ax.plot((r.min(), r.max()), (y, y), color=colour, linewidth=1.2, alpha=0.5)
        ax.plot(r, np.full(size, y), "o", color=colour, markersize=4.5, alpha=0.75, markeredgewidth=0)
        bars.barh(y, rms(r), height=0.6, color=colour)
        bars.text(rms(r), y, f" {rms(r):.3f}", va="center", fontsize=9, weight="bold" if y == 0 else "normal")
    ax.axvline(1, color="#444444", linewidth=1.0, zorder=1)
    ax.set_xscale("log")
    low, high = (f(f(r) for r in ranked.values()) for f in (min, max))
    ax.set_xlim(low / 1.25, high * 1.25)
    drawing.plain_log_axis(ax.xaxis, low / 1.25, high * 1.25)
    ax.set_yticks(range(count))
    ax.set_yticklabels([f"{law.replace('_', ' ')}, {reference.replace(' deg', chr(176))}"
                        for law, reference in ranked])
    ax.set_ylim(count - 0.4, -0.6)
    ax.set_xlabel("Published / Monte-Carlo standard deviation (one point a parameter and test)")
    bars.set_xlabel("Root mean square of ln(ratio)")
    bars.set_xlim(0, 1.18 * max(rms(r) for r in ranked.values()))
    handles = [Line2D([], [], color=c, marker="o", label=f"reference {n.replace(' deg', chr(176))}")
               for n, c in REFERENCE_LOOK.items() if any(reference == n for _, reference in ranked)]
    drawing.legend_below(figure, handles)
    return figure


# --- published positions --------------------------------------------------------------------------------------------


def published_figure(title, position):
    """Predicted and published over Monte-Carlo sd of north and east: a panel a test and direction, a line a propagation."""
    panels = []
    for test in dict.fromkeys(position["case"]):
        for d in DIRECTIONS:
            rows = {f: position.row(case=test, quantity=f"sigma3_{d}", formulation=f) for f in PROPAGATIONS}
            rows = {f: row for f, row in rows.items() if row is not None}
            if rows:
                sd = next(iter(rows.values()))["monte_carlo"] / 3
                panels.append((f"{test}, {d}: 1{SIGMA} = {msa_position.length(sd)}", {f: [(row, "", False)] for f, row in rows.items()}))
    return ratios.lines_figure(title, f"Predicted, and published, over Monte-Carlo standard deviation of the final position. "
                               f"{wording.counts_text(position['trials'])} trials a test.", panels,
                               {f: (LOOK[f]["label"], LOOK[f]["color"]) for f in PROPAGATIONS}, position.confidence, 2)


# --- ellipsoids -----------------------------------------------------------------------------------------------------


def ellipsoids_figure(title, samples, covariances, position):
    """Two views of every test, along and across the direction in which the joint ellipsoid is longest on the map: from above and
    from the side. In a plane well azimuth errors move no vertical to first order: such ellipses are lines."""
    cases = list(dict.fromkeys(covariances["case"]))
    figure, panels = drawing.panels(2 * len(cases), (5.6, 2.6), columns=2)
    formulations = ("monte_carlo", *PROPAGATIONS)
    for case, *views in zip(cases, panels[::2], panels[1::2]):
        cloud = reading.at_point(samples, ["case"], [case])
        points = np.array([cloud[f"{d}_m"] for d in ("north", "east", "vertical")])
        points = points - points.mean(axis=1, keepdims=True)
        found = {}
        for name in formulations:
            r = covariances.row(case=case, formulation=name)
            if r is not None:
                found[name] = geometry.covariances(r)
        azimuth = geometry.ellipse_axes(found["joint"][:2, :2])[2]
        a = np.radians(azimuth)
        along, left, down = np.array([np.cos(a), np.sin(a), 0]), np.array([np.sin(a), -np.cos(a), 0]), np.array([0, 0, 1.0])
        for ax, other, word in zip(views, (left, down), ("to the left", "down")):
            turn = np.array([along, other])
            xy = turn @ points
            is_small = np.abs(xy[1]).max() < 0.5
            scale = np.array([[1.0], [1000.0 if is_small else 1.0]])
            drawing.cloud(ax, *(xy * scale), smallest=3.0)
            lines = {}
            for name in sorted(found, key=lambda f: (f != "monte_carlo", -found[f][0, 0])):
                flat = turn @ found[name] @ turn.T
                if flat[1, 1] <= 1e-12 * flat[0, 0]:
                    lines[name] = np.sqrt(flat[0, 0])
                    continue
                root = np.linalg.cholesky(flat / np.outer(np.sqrt(np.diag(flat)), np.sqrt(np.diag(flat))) + 1e-15 * np.eye(2))
                t = np.linspace(0, 2 * np.pi, 361)
                outline = 3 * np.sqrt(np.diag(flat))[:, None] * (root @ np.array([np.cos(t), np.sin(t)]))
                ax.plot(*(outline * scale), color=LOOK[name]["color"], linestyle=LOOK[name]["linestyle"], linewidth=1.7, zorder=3)
            ax.plot(0, 0, "+", color="black", markersize=10, markeredgewidth=1.5, zorder=9)
            if word == "down":
                ax.invert_yaxis()
            msa_position.draw_rulers(ax, lines, (3,), 0.08)
            ax.set_ylabel(f"{word.capitalize()} ({'mm' if is_small else 'm'})")
            ax.set_title(f"{case}, {'from above' if word != 'down' else 'from the side'}")
            ax.set_xlabel(f"Along azimuth {azimuth:.0f}\N{DEGREE SIGN} (m)" if case == cases[-1] else f"Along {azimuth:.0f}\N{DEGREE SIGN} (m)")
    drawing.heading(figure, title, f"Final positions after MSA about their mean with 3{SIGMA} ellipses; lines with ends: predicted ellipses without width. Scales of the axes differ. "
                    f"Cloud: the first {wording.grouped(cloud.rows)} of {wording.counts_text(position['trials'])} trials.")
    drawing.legend_below(figure, [Line2D([], [], color=LOOK[f]["color"], linestyle=LOOK[f]["linestyle"], label=LOOK[f]["label"])
                                  for f in formulations])
    return figure


# --------------------------------------------------------------------------------------------------------------------


def main():
    arguments = saving.argument_parser("Draw the figures of the thesis study that span its tests.").parse_args()
    drawing.use_style()
    with reading.open_result(arguments.result, "msa_position") as file:
        config = reading.configuration(file)
        title = wording.title_of(file)
        tables = {n: reading.read_table(file, n)
                  for n in ("parameters", "position", "position_covariance")}
        samples = reading.read_table(file, "realisations", "samples")
    parameters, position = tables["parameters"], tables["position"]
    if parameters is None or parameters.rows == 0:
        raise PlotError(f"{arguments.result}: table 'parameters' is missing or empty")
    keys = reading.sweep_keys(config, parameters)
    if "case" in parameters and "case" not in keys:  # [[sweep.case]] comes under the sweep's own name
        keys.append("case")
    margin = float(config.get("verdict", {}).get("margin", 0))
    figures = {}
    if "noise.law" in keys and "case" in keys and np.any(parameters["published_ratio"] > 0):
        figures["hypotheses"] = hypotheses_figure(title, parameters)
    elif "case" in keys and estimator_figures.is_ladder(parameters):
        figures["ladder"] = estimator_figures.ladder(title, parameters, parameters.confidence)
    elif position and "case" in keys and "estimator.name" in keys:
        figures["estimators"] = estimator_figures.positions(title, position, margin, position.confidence)
    elif position and keys == ["case"]:
        if np.any(np.isfinite(position["published"])):
            figures["published"] = published_figure(title, position)
        if samples and samples.rows and tables["position_covariance"]:
            figures["ellipsoids"] = ellipsoids_figure(title, samples, tables["position_covariance"], position)
    if not figures:
        raise PlotError(f"{arguments.result}: nothing that spans the thesis' tests: see surveymc plot msa_position")
    saving.save_all(figures, arguments)
