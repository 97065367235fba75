"""Map of the order of prediction that is needed (docs/orders.md), for every direction of the hole: of msa_benefit and corrected_codes."""

import textwrap

import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch

from . import drawing
from .tool_codes import cell_edges

DEGREE = "\N{DEGREE SIGN}"
# Told apart by lightness, too.
ORDERS = (("first", "#DCEFF8", "first order: the ellipse holds"), ("second", "#56B4E9", "second order"),
          ("profile", "#E69F00", "profile"), ("sample", "#7F2704", "only trials"))
UNDETERMINED = "#777777"


def figure(title, what, rows, inclination, azimuth):
    """rows: of panels, each (name, map of 0 to 3 over inclination and azimuth); what: the quantity that is predicted."""
    columns, shown = len(rows[0]), sum(rows, [])
    drawn, axes = drawing.panels(len(shown), (3.1, 2.4), columns=columns, sharex=True, sharey=True)
    colours = ListedColormap([colour for _, colour, _ in ORDERS])
    norm = BoundaryNorm(np.arange(-0.5, len(ORDERS)), len(ORDERS))
    for ax, (name, order) in zip(axes, shown):
        ax.set_title("\n".join(line for part in name.split("\n") for line in textwrap.wrap(part, 40)), fontsize=8.5)
        ax.set_facecolor(UNDETERMINED)
        ax.grid(False)
        ax.pcolormesh(cell_edges(azimuth), cell_edges(inclination), np.ma.masked_invalid(order), cmap=colours, norm=norm)
        share = [np.mean(order[np.isfinite(order)] == k) if np.any(np.isfinite(order)) else 0.0 for k in range(len(ORDERS))]
        ax.set_xlabel(", ".join(f"{n} {100 * s:.0f} %" for (n, _, _), s in zip(ORDERS, share) if s > 0) or "not determined", fontsize=7.5)
    for ax in axes[-columns:]:
        ax.set_xlabel(f"{ax.get_xlabel()}\nazimuth ({DEGREE})", fontsize=7.5)
        ax.xaxis.set_tick_params(labelbottom=True)
    for ax in axes[::columns]:
        ax.set_ylabel(f"inclination ({DEGREE})")
    drawing.heading(drawn, title, f"Order of prediction that {what} needs, by directions of the hole; shares of the map below each panel.")
    drawing.legend_below(drawn, [Patch(facecolor=colour, edgecolor="black", linewidth=0.5, label=label) for _, colour, label in ORDERS]
                         + [Patch(color=UNDETERMINED, label="not determined")])
    return drawn
