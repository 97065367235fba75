"""Along a well: what the smallest error that is found, in one reading, does to the final position, without linearisation.

    surveymc plot reliability_well RESULT.h5 [-o FOLDER]

A panel for each point of the sweep, over measured depth, PNG and SVG next to the result. Rings: the station where an
error in that observation matters most. Pale crosses: what linear theory says where it is off by more than 20 %. A gap: an
error of any size passes there (infinite). References that all stations share are horizontal lines.
"""

import matplotlib
import numpy as np

from ..arguments import USAGE
from . import drawing, reading, saving, wording

LOOK = {"gx": ("#0072B2", "-"), "gy": ("#56B4E9", (0, (7, 2))), "gz": ("#222222", (0, (3.5, 2))),
        "bx": ("#D55E00", "-"), "by": ("#E69F00", (0, (7, 2))), "bz": ("#A8508A", (0, (3.5, 2))),
        "gravity": ("#777777", (0, (1, 1.3))), "total_field": ("#009E73", (0, (1, 1.3))),
        "dip": ("#000000", (0, (7, 2, 1, 2)))}
NAMES = {"gx": "$g_x$", "gy": "$g_y$", "gz": "$g_z$", "bx": "$b_x$", "by": "$b_y$", "bz": "$b_z$", "gravity": "G",
         "total_field": "B", "dip": "Θ"}


def main():
    arguments = saving.argument_parser(__doc__.splitlines()[0]).parse_args()
    drawing.use_style()
    with reading.open_result(arguments.result, "reliability_well") as file:
        config = reading.configuration(file)
        title = wording.title_of(file)
        table = reading.read_table(file, "stations")
    keys = reading.sweep_keys(config, table)
    points = reading.sweep_points(table, keys)
    if len(points) > 6:
        raise reading.PlotError(f"{arguments.result}: {len(points)} panels: sweep fewer values", USAGE)
    figure, panels = drawing.panels(len(points), (4.6, 4.4), columns=len(points), sharey=True)
    sizes, handles = {}, {}
    for axes, point in zip(panels, points):
        rows = reading.at_point(table, keys, point)
        for name, (colour, line) in LOOK.items():
            own = rows.where(lambda i: rows["observation"][i] == name)
            if own.rows == 0:
                continue
            size = np.where(np.isfinite(own["position_m"]), own["position_m"], np.nan)
            if not np.any(np.isfinite(size)):
                continue
            sizes[name] = max(sizes.get(name, 0), np.nanmax(size))
            if own["station"][0] < 0:
                handles[NAMES[name]] = axes.axhline(size[0], color=colour, linestyle=line, linewidth=1.3)
            else:
                handles[NAMES[name]], = axes.plot(own["md_m"], size, color=colour, linestyle=line, linewidth=1.3)
                off = np.array([note == "linear differs" for note in own["note"]])
                linear = np.asarray(own["linear_position_m"], float)
                off &= np.isfinite(linear)
                if off.any():
                    axes.plot(np.asarray(own["md_m"])[off], linear[off], "x", color=colour, alpha=0.35, markersize=4)
                worst = int(np.nanargmax(size))
                axes.plot(own["md_m"][worst], size[worst], "o", color=colour, markersize=7, markerfacecolor="none")
        axes.set_xlabel("Measured depth (m)")
        axes.set_title(wording.point_name(keys, point), fontsize=9)
    panels[0].set_ylabel("Effect on the final position (m)")
    top = 1.5 * max(sizes.values(), default=1.0)
    below = [name for name, size in sizes.items() if size < top / 3000]  # of no account, and of no line
    for name in below:
        handles.pop(NAMES[name])
    panels[0].set_yscale("log")
    panels[0].set_ylim(top / 3000, top)
    panels[0].yaxis.set_major_formatter(matplotlib.ticker.FuncFormatter(lambda v, _: f"{v:g}"))
    panels[0].yaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    words = "its worst toolface (x and y coincide)" if config.get("toolface") == "worst" else "the survey's toolface"
    test = "the reading's own test" if config.get("detected_by") == "own" else "the general test"
    meaning = (f"the smallest error that {test} finds in one reading of one station, at {words}, without linearisation; "
               "rings: worst station; pale crosses: linear theory, where it is off by more than 20\N{NO-BREAK SPACE}%")
    meaning += f"; {', '.join(NAMES[n] for n in below)}: less than {wording.number(top / 3000, 1)} m" if below else ""
    drawing.heading(figure, title, meaning[0].upper() + meaning[1:] + ".")
    for label, line in handles.items():
        line.set_label(label)
    drawing.legend_below(figure, list(handles.values()))
    folder = saving.figures_folder(arguments.output, arguments.result)
    saving.save(figure, folder, saving.stem_of(arguments.result))
