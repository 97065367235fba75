"""Figures of a clearance result: how safely does a well pass the wells around it?

    surveymc plot clearance RESULT.h5 [-o FOLDER] [--point I] [--sigma K]

<stem>_ladder      centre distance, hole radii and K sigma (k of the separation rule) against depth, one strip an offset
<stem>_separation  separation factor against depth, one panel an offset, a line a formulation, line at 1
<stem>_cylinder    travelling cylinder: distance and direction of the offsets seen along the reference, coloured by depth,
                   with the distance at which the separation factor is 1
<stem>_views       plan and vertical section about the least separation factor along the reference: paths, K-sigma ellipses and pedal curves
<stem>_relative    the relative position at the least separation factor: ellipses of the relative covariance in plan and
                   section, one panel a formulation, and the holes
<stem>_cloud       drawn relative positions at the first depth of report_md_m, with 1, 2, 3 sigma ellipses of the first formulation,
                   in plan and section (with trials and save_samples)
each as PNG and SVG. Of a sweep one point is drawn: --point (counted from 0, in the order of the file; the first), and the
figures are named <stem>_point<I>_<figure>.
"""

import matplotlib
import matplotlib.pyplot as plt
import numpy as np

from . import drawing, geometry, reading, saving, wording
from .reading import PlotError
from .wording import number

SIGMA = "\N{GREEK SMALL LETTER SIGMA}"
DEGREE = "\N{DEGREE SIGN}"
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#222222", "#999999")
DASHES = ("-", (0, (6, 2)), (0, (2, 1.2)), (0, (6, 2, 1, 2)), (0, (1, 1)), (0, (8, 3)), (0, (4, 1)), "-")
MOST_OFFSETS = 8


class Clearance:
    """The tables of one point of the sweep."""

    def __init__(self, file, arguments):
        config = reading.configuration(file)
        parameters = reading.read_table(file, "parameters")
        keys = reading.sweep_keys(config, parameters)
        points = reading.sweep_points(parameters, keys)
        chosen = reading.chosen_point(arguments, points)
        point = points[chosen or 0]
        self.suffix = f"_point{chosen or 0}" if len(points) > 1 else ""
        self.title = wording.title_of(file)
        if keys:
            self.title += f": {wording.point_name(keys, point)}"
        tables = [reading.at_point(reading.read_table(file, name), keys, point)
                  for name in ("parameters", "clearance", "least", "relative_covariance", "paths")]
        self.samples = reading.at_point(reading.read_table(file, "relative_realisations", "samples"), keys, point)
        self.parameters, rows, self.least, self.covariance, self.paths = tables
        if rows is None:
            raise PlotError(f"{arguments.result}: has no table clearance: run it with output.clearance = \"all\"")
        self.rows = rows.where(lambda i: rows["minimum"][i] == 1 and rows["direction"][i] == "reference")
        self.offsets = list(dict.fromkeys(self.rows["offset"]))
        self.all_offsets = len(self.offsets)
        self.k = float(self.parameters["scale_factor"][0])
        self.margin = float(self.parameters["surface_margin_m"][0])
        self.project_ahead = float(self.parameters["project_ahead_m"][0])
        # The wells that come nearest to breaking the rule, if there are many.
        if len(self.offsets) > MOST_OFFSETS:
            self.offsets.sort(key=lambda o: min(finite_or_inf(self.least_row(o, direction=d)) for d in ("reference", "offset")))
            self.offsets = self.offsets[:MOST_OFFSETS]

    def formulations(self, offset):
        return list(dict.fromkeys(f for o, f in zip(self.rows["offset"], self.rows["formulation"]) if o == offset))

    def of(self, offset, formulation):
        r = self.rows
        return r.where(lambda i: r["offset"][i] == offset and r["formulation"][i] == formulation)

    def least_row(self, offset, formulation=None, direction="reference"):
        """The row of the least separation factor seen along a well; None if it is not scanned."""
        rows = [self.least.row(offset=offset, formulation=f, direction=direction, quantity="separation_factor")
                for f in ([formulation] if formulation else self.formulations(offset))]
        return min(filter(None, rows), key=finite_or_inf, default=None)

    def with_least(self, offset, md, distance):
        """Depths and distances of a curve, with those of the least values between the stations."""
        least = self.least.where(lambda i: self.least["offset"][i] == offset and self.least["direction"][i] == "reference"
                                 and np.isfinite(self.least["distance_m"][i]))
        md, place = np.unique(np.concatenate([md, least["ref_md_m"]]), return_index=True)
        return md, np.concatenate([distance, least["distance_m"]])[place]

    def less_along_the_offset(self, offset):
        """', along the offset 0.0648' where the factor seen from there is the smaller one; pictures are of the reference."""
        seen = [self.least_row(offset, direction=d) for d in ("reference", "offset")]
        return f", along the offset {number(seen[1]['continuous'])}" if finite_or_inf(seen[1]) < finite_or_inf(seen[0]) else ""

    def radii(self, offset):
        diameter = dict(zip(self.parameters["well"], self.parameters["hole_diameter_m"]))
        return (diameter["reference"] + diameter[offset]) / 2

    def path(self, well):
        p = self.paths
        return p.where(lambda i: p["well"][i] == well)

    def at_least(self, offset, formulation, of):
        """Difference of the positions and covariance at the least separation factor; None where there is none."""
        row = self.covariance.row(offset=offset, formulation=formulation, where="least separation factor", of=of)
        if row is None or not all(np.isfinite(row[e]) for e in geometry.COVARIANCE):
            return None
        return row, *relative_position(row)


def finite_or_inf(row):
    """The factor of a row of `least`; infinite where there is none."""
    return np.inf if row is None or np.isnan(row["continuous"]) else row["continuous"]


def largest(values, otherwise=0.0):
    """The largest of those that are finite."""
    return np.max(values[np.isfinite(values)], initial=-np.inf) if np.any(np.isfinite(values)) else otherwise


def relative_position(row):
    """Difference of the positions (3) and covariance (3x3) of a row of relative_covariance."""
    return np.array([row["distance_north_m"], row["distance_east_m"], row["distance_down_m"]]), geometry.covariances(row)


def lines_of_two(data, offsets, text):
    """A figure with plan and section of each offset."""
    figure, panels = plt.subplots(len(offsets), 2, figsize=(11.0, 1.3 + 4.9 * len(offsets)), squeeze=False, layout="constrained")
    drawing.heading(figure, data.title, text)
    return figure, panels


def strips(data, text, high):
    """A figure with a strip along the reference for each offset."""
    figure, panels = plt.subplots(len(data.offsets), 1, figsize=(11.5, 1.4 + high * len(data.offsets)), squeeze=False, sharex=True,
                                  layout="constrained")
    drawing.heading(figure, data.title, text + note_of(data))
    panels[-1, 0].set_xlabel("Measured depth on the reference (m)")
    panels[-1, 0].set_xlim(np.min(data.rows["ref_md_m"]), np.max(data.rows["ref_md_m"]))
    return figure, panels[:, 0]


def note_of(data):
    more = data.all_offsets - len(data.offsets)
    return f" {more} more offsets are not drawn." if more else ""


def ladder(data):
    figure, panels = strips(data, f"Distance of the centre lines, and what it is held against: hole radii + S_m = {data.margin:g} m "
                            f"+ {data.k:g} x sd of the distance (with {data.project_ahead:g} m ahead of the bit).", 2.9)
    for ax, offset in zip(panels, data.offsets):
        for i, f in enumerate(data.formulations(offset)):
            t = data.of(offset, f)
            md = t["ref_md_m"]
            need = data.radii(offset) + data.margin + data.k * np.hypot(t["sd_relative_m"], data.project_ahead)
            if i == 0:
                ax.plot(*data.with_least(offset, md, t["distance_m"]), color="#222222", linewidth=2.0, label="distance")
                ax.fill_between(md, 0, data.radii(offset), color="#777777", linewidth=0, label="hole radii")
                far = np.array([e != "interior" for e in t["end"]])
                ax.plot(md[far], t["distance_m"][far], ".", color="#222222", markersize=5, label="closest at an end of the offset")
            ax.plot(md, need, color=COLOURS[i % 8], linestyle=DASHES[i % 8], linewidth=1.5, label=f)
        least = data.least_row(offset)
        ax.axvline(least["ref_md_m"], color="#777777", linewidth=1.0, linestyle=(0, (4, 3)), zorder=0.5)
        # Where the wells are far apart nothing is to be seen: the scale is that of what is needed, and of the least distance.
        most = max(largest(data.of(offset, f)["sd_relative_m"]) for f in data.formulations(offset))
        apart = data.of(offset, data.formulations(offset)[0])["distance_m"]
        top = max(4 * (data.radii(offset) + data.margin + data.k * np.hypot(most, data.project_ahead)), 1.5 * np.nanmin(apart))
        ax.set_ylim(0, min(top, 1.05 * np.nanmax(apart)))
        ax.set_ylabel("Distance (m)")
        ax.set_title(f"{offset}: least separation factor along the reference {number(least['continuous'])} at "
                     f"{number(least['ref_md_m'], 5)} m ({least['formulation']}){data.less_along_the_offset(offset)}")
        ax.legend(loc="center left", bbox_to_anchor=(1.005, 0.5), fontsize=8.5)
    return figure


def separation(data):
    figure, panels = strips(data, "Separation factor along the reference: lines through its stations, dots at the least value between "
                            "them. Below 1 the rule is broken.", 2.7)
    for ax, offset in zip(panels, data.offsets):
        factors = {f: data.of(offset, f)["separation_factor"] for f in data.formulations(offset)}
        least = {f: data.least_row(offset, f) for f in factors}
        seen = np.concatenate([*factors.values(), [r["continuous"] for r in least.values()]])
        seen = seen[np.isfinite(seen)]
        # On a logarithmic axis there is no room for nothing: factors below the axis are drawn at its lower edge.
        low = max(0.05, 0.8 * np.min(seen, initial=1.0)) if np.min(seen, initial=1.0) > 0 else 0.5 * np.min(seen[seen > 0], initial=1.0)
        top = min(200, 1.3 * np.max(seen, initial=1.5))
        for i, (f, sf) in enumerate(factors.items()):
            ax.plot(data.of(offset, f)["ref_md_m"], np.maximum(sf, 0.5 * low), color=COLOURS[i % 8], linestyle=DASHES[i % 8], linewidth=1.7,
                    label=f"{f}, least {number(least[f]['continuous'])}")
            value, at = least[f]["continuous"], least[f]["ref_md_m"]
            if not np.isfinite(value):
                continue
            is_below = value < low
            ax.plot(at, max(value, low), "v" if is_below else "o", color=COLOURS[i % 8], markersize=8 if is_below else 4.5, clip_on=False,
                    zorder=5)
            if is_below:
                ax.annotate(number(value), (at, low), xytext=(7, 5 + 10 * i), textcoords="offset points", color=COLOURS[i % 8], fontsize=8.5)
        ax.axhspan(low, 1, color="#D55E00", alpha=0.12, linewidth=0)
        ax.axhline(1, color="#444444", linewidth=1.2)
        ax.set_yscale("log")
        ax.set_ylim(low, top)
        drawing.plain_log_axis(ax.yaxis, low, top)
        ax.set_title(f"{offset}: least {number(data.least_row(offset)['continuous'])}{data.less_along_the_offset(offset)}")
        ax.set_ylabel("Separation factor")
        ax.legend(loc="center left", bbox_to_anchor=(1.005, 0.5), fontsize=8.5)
    return figure


def cylinder(data):
    """Polar: distance against the direction from the high side; rings where the separation factor would be 1."""
    columns = min(3, len(data.offsets))
    lines = -(-len(data.offsets) // columns)
    figure, panels = plt.subplots(lines, columns, figsize=(max(7.5, 4.4 * columns + 0.9), 4.4 * lines + 1.2), squeeze=False,
                                  subplot_kw={"projection": "polar"}, layout="constrained")
    drawing.heading(figure, data.title, "Travelling cylinder: the offset seen along the reference, high side up, by measured depth. "
                    "Orange rings: where the separation factor would be 1, at the depths of the points." + note_of(data))
    image, shown = None, []
    for ax in panels.flat[len(data.offsets):]:
        ax.set_visible(False)
    for offset in data.offsets:
        t = data.of(offset, data.formulations(offset)[0])
        angle, distance, md = np.radians(t["toolface_to_offset_deg"]), t["distance_m"], t["ref_md_m"]
        ring = data.radii(offset) + data.margin + data.k * np.hypot(t["sd_relative_m"], data.project_ahead)
        limit = max(2.2 * largest(ring), 1.3 * np.nanmin(distance)) or 1.0
        keep = np.isfinite(angle) & (distance <= limit)
        shown.append((offset, t, angle, distance, md, ring, limit, keep))
    depths = np.concatenate([s[4][s[7]] for s in shown])  # colours: the depths that are drawn, of all panels
    for ax, (offset, t, angle, distance, md, ring, limit, keep) in zip(panels.flat, shown):
        for r, m in list(zip(ring[keep], md[keep]))[::max(1, int(np.sum(keep)) // 12)]:
            ax.plot(np.linspace(0, 2 * np.pi, 181), np.full(181, r), color="#D55E00", linewidth=0.6, alpha=0.45, zorder=1)
        ax.plot(angle[keep], distance[keep], color="#777777", linewidth=0.6, zorder=2)
        image = ax.scatter(angle[keep], distance[keep], c=md[keep], s=16, cmap="viridis", zorder=3,
                           vmin=np.min(depths), vmax=np.max(depths))
        broken = keep & (t["separation_factor"] < 1)
        ax.scatter(angle[broken], distance[broken], s=46, facecolors="none", edgecolors="#D55E00", linewidths=1.3, zorder=4)
        ax.set_theta_zero_location("N")
        ax.set_theta_direction(-1)
        ax.set_rlim(0, limit)
        ax.set_rlabel_position(112)
        ax.yaxis.set_major_locator(matplotlib.ticker.MaxNLocator(4))
        ax.tick_params(labelsize=8)
        ax.set_title(f"{offset} (m)", pad=14)
    if image is not None:
        bar = figure.colorbar(image, ax=list(panels.flat), shrink=0.7)
        bar.set_label("Measured depth on the reference (m)")
    return figure


def pedal_points(covariance, k, centre):
    """The pedal curve of an ellipse: k sqrt(u' C u) in every direction u."""
    a = np.linspace(0, 2 * np.pi, 361)
    u = np.array([np.cos(a), np.sin(a)])
    r = k * np.sqrt(np.maximum(0, np.einsum("ia,ij,ja->a", u, covariance, u)))
    return centre[0] + r * u[0], centre[1] + r * u[1]


def projections(d):
    """(name, 2x3 matrix, labels): plan, and the vertical section through both points (through north without a distance)."""
    level = np.hypot(d[0], d[1])
    a = np.arctan2(d[1], d[0]) if level > 1e-6 else 0.0
    return (("plan", np.array([[0, 1, 0], [1, 0, 0]]), ("East (m)", "North (m)")),
            ("section", np.array([[np.cos(a), np.sin(a), 0], [0, 0, 1]]), (f"Along azimuth {np.degrees(a) % 360:.0f}{DEGREE} (m)", "Depth (m)")))


def frame(ax, points, size, down):
    centre = np.mean(points, axis=0)
    ax.set_xlim(centre[0] - size, centre[0] + size)
    ax.set_ylim(*((centre[1] + size, centre[1] - size) if down else (centre[1] - size, centre[1] + size)))
    ax.set_aspect("equal", adjustable="box")


def views(data, sigma):
    offsets = data.offsets[:4]
    figure, panels = lines_of_two(data, offsets, f"Where the separation factor along the reference is least: paths, {sigma:g}{SIGMA} ellipses (filled) and pedal curves (lines) of each well, "
                     "and the line between the centres. The pedal curve's radius along that line is what the rule takes.")
    for line, offset in zip(panels, offsets):
        least = data.least_row(offset)
        found = data.at_least(offset, least["formulation"], "reference")
        if found is None:
            for ax, name in zip(line, ("plan", "section")):
                ax.set_title(f"{offset}, {name}: no covariance there")
            continue
        row, d, c_reference = found
        c_offset = data.at_least(offset, least["formulation"], "offset")[2]
        paths = {w: data.path(w) for w in ("reference", offset)}
        xyz = {w: np.array([p["north_m"], p["east_m"], p["tvd_m"]]) for w, p in paths.items()}
        reference = np.array([np.interp(row["ref_md_m"], paths["reference"]["md_m"], x) for x in xyz["reference"]])
        t = data.of(offset, least["formulation"])
        near = int(np.argmin(np.abs(t["ref_md_m"] - row["ref_md_m"])))
        if abs(t["ref_md_m"][near] - row["ref_md_m"]) < 1e-6:
            reference = np.array([t[f"ref_{a}_m"][near] for a in ("north", "east", "tvd")])
        there = reference + d
        for ax, (name, p, labels) in zip(line, projections(d)):
            points = np.array([p @ reference, p @ there])
            size = 0.6 * np.linalg.norm(d) + 1.25 * sigma * np.sqrt(max(np.max(np.linalg.eigvalsh(p @ c @ p.T)) for c in (c_reference, c_offset))) + 1
            for w, c, centre, colour in (("reference", c_reference, points[0], COLOURS[0]), (offset, c_offset, points[1], COLOURS[1])):
                ax.plot(*(p @ xyz[w]), color=colour, linewidth=1.5, label=w)
                flat = p @ c @ p.T
                x, y = geometry.ellipse_points(flat, sigma, centre)
                ax.fill(x, y, facecolor=colour, alpha=0.2, edgecolor="none")
                ax.plot(*pedal_points(flat, sigma, centre), color=colour, linewidth=0.9)
                ax.plot(*centre, "o", color=colour, markersize=4.5)
            ax.plot(*points.T, color="#222222", linewidth=1.0, linestyle=(0, (3, 2)))
            frame(ax, points, size, name == "section")
            ax.set_xlabel(labels[0])
            ax.set_ylabel(labels[1])
            ax.set_title(f"{offset}, {name}" + (f": factor {number(least['continuous'])} at {number(row['ref_md_m'], 5)} m, {least['formulation']}"
                                                if name == "plan" else f": distance {number(np.linalg.norm(d))} m"))
        line[0].legend(loc="best", fontsize=9)
    return figure


def relative(data, sigma):
    offsets = data.offsets[:4]
    figure, panels = lines_of_two(data, offsets, f"The offset relative to the reference where the separation factor along it is least: {sigma:g}{SIGMA} ellipses of the relative covariance by what the "
                     "wells share. The disc at the cross is the reference's place, with both hole radii.")
    for line, offset in zip(panels, offsets):
        worst = data.at_least(offset, data.least_row(offset)["formulation"], "relative")
        for i, f in enumerate(data.formulations(offset)):
            found = data.at_least(offset, f, "relative")
            if found is None:
                continue
            row, d, c = found
            for ax, (name, p, labels) in zip(line, projections((worst or found)[1])):
                flat = p @ c @ p.T
                x, y = geometry.ellipse_points(flat, sigma, p @ d)
                ax.plot(x, y, color=COLOURS[i % 8], linestyle=DASHES[i % 8], linewidth=1.6,
                        label=f"{f}: {number(row['ref_md_m'], 5)} m, factor {number(data.least_row(offset, f)['continuous'])}")
                ax.plot(*(p @ d), ".", color=COLOURS[i % 8])
                ax.set_xlabel(labels[0])
                ax.set_ylabel(labels[1])
                ax.set_title(f"{offset}, {name}")
        for ax, name in zip(line, ("plan", "section")):
            a = np.linspace(0, 2 * np.pi, 181)
            ax.fill(data.radii(offset) * np.cos(a), data.radii(offset) * np.sin(a), color="#777777", zorder=4)
            ax.plot(0, 0, "+", color="#222222", markersize=11, zorder=5)
            ax.set_aspect("equal", adjustable="datalim")
            if name == "section":
                ax.invert_yaxis()
        line[1].legend(*line[0].get_legend_handles_labels(), loc="center left", bbox_to_anchor=(1.03, 0.5), fontsize=8.5)
    return figure


def cloud(data):
    """None where no wells were drawn."""
    s = data.samples
    if s is None or s.rows == 0:
        return None
    everywhere = [w for w in data.parameters["well"] if w != "reference"]  # samples count them all
    offsets = [o for o in data.offsets if np.any(s["offset"] == everywhere.index(o) + 1)][:4]
    first = data.formulations(offsets[0])[0]
    figure, panels = lines_of_two(data, offsets, f"Errors of the relative position, drawn with all errors of both wells; 1, 2, 3{SIGMA} ellipses of the relative covariance "
                     f"({first}). The arrow points along the line between the wells.")
    for line, offset in zip(panels, offsets):
        c = data.covariance
        formulation = data.formulations(offset)[0]
        row = c.row(offset=offset, formulation=formulation, where="report_md_m", of="relative")
        keep = (s["offset"] == everywhere.index(offset) + 1) & (s["md_m"] == row["ref_md_m"])
        x = np.array([s[k][keep] for k in ("north_m", "east_m", "down_m")])
        d, covariance = relative_position(row)
        for ax, (name, p, labels) in zip(line, projections(d)):
            drawing.cloud(ax, *(p @ x))
            flat = p @ covariance @ p.T
            for k in (1, 2, 3):
                ax.plot(*geometry.ellipse_points(flat, k), color="#D55E00", linewidth=1.3)
            u = p @ d / np.linalg.norm(d) * 3 * np.sqrt(np.max(np.linalg.eigvalsh(flat)))
            ax.annotate("", u, (0, 0), arrowprops={"arrowstyle": "->", "color": "#222222"})
            ax.set_aspect("equal", adjustable="datalim")
            if name == "section":
                ax.invert_yaxis()
            ax.set_xlabel(labels[0])
            ax.set_ylabel(labels[1])
            ax.set_title(f"{offset}, {name}, at {number(row['ref_md_m'], 5)} m, {int(np.sum(keep))} drawn")
    return figure


def main():
    parser = saving.argument_parser("distance, separation factor and uncertainty of two and more wells")
    parser.add_argument("--point", type=int, help="point of a sweep, from 0 (the first)")
    parser.add_argument("--sigma", type=float, default=2.0, help="size of the ellipses and pedal curves (2)")
    arguments = parser.parse_args()
    drawing.use_style()
    with reading.open_result(arguments.result, "clearance") as file:
        data = Clearance(file, arguments)
    folder = saving.figures_folder(arguments.output, arguments.result)
    stem = saving.stem_of(arguments.result) + data.suffix
    saving.save(ladder(data), folder, f"{stem}_ladder")
    saving.save(separation(data), folder, f"{stem}_separation")
    saving.save(cylinder(data), folder, f"{stem}_cylinder")
    saving.save(views(data, arguments.sigma), folder, f"{stem}_views")
    saving.save(relative(data, arguments.sigma), folder, f"{stem}_relative")
    drawn = cloud(data)
    if drawn is not None:
        saving.save(drawn, folder, f"{stem}_cloud")
