"""What figures share: style, labels that find their places, legends, axes."""

import math
import os
import textwrap

import matplotlib
import matplotlib.patheffects
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from .wording import cut, plain_size


# One colour, line and marker per thing, in every figure. No two share a line style, so the figures also read in grey.
LOOK = {
    "monte_carlo": {"label": "Monte Carlo", "color": "#0072B2", "linestyle": "-"},
    "joint": {"label": "joint", "color": "#D55E00", "linestyle": (0, (7, 2))},
    "systematic": {"label": "systematic", "color": "#222222", "linestyle": (0, (3.5, 2))},
    "random": {"label": "random", "color": "#A8508A", "linestyle": (0, (1, 1.3))},
}
PROPAGATIONS = ("joint", "systematic", "random")
PUBLISHED = "#777777"
VERDICT_MARKER = {"agrees": "o", "undecided": "^", "differs": "D"}


def use_style():
    """The look of all figures."""
    plt.style.use(os.path.join(os.path.dirname(os.path.abspath(__file__)), "style.mplstyle"))


def fit_texts(figure):
    """Makes titles and texts that run out of the figure, or into the panel beside theirs, smaller; cuts what is still too long.

    Names of runs, cases and wells are the user's, and may be of any length.
    """
    if figure.get_layout_engine() is not None:
        figure.get_layout_engine().execute(figure)  # only now the panels have their places
    renderer = figure.canvas.get_renderer()
    wide = figure.bbox.width
    panels = [ax for ax in figure.axes if ax.get_visible()]
    boxes = [ax.get_window_extent(renderer) for ax in panels]
    texts = [(text, wide) for text in figure.texts]
    for ax, own in zip(panels, boxes):
        beside = [b.x0 for b in boxes if b.x0 > own.x1 - 1 and b.y0 < own.y1 and b.y1 > own.y0]
        texts += [(title, min(beside, default=wide)) for title in (ax.title, ax._left_title)]
    for text, limit in texts:
        for size in (None, 10, 9, 8, 7, 6):
            if size is not None and size < text.get_fontsize():
                text.set_fontsize(size)
            box = text.get_window_extent(renderer)
            low = max(box.x0, 0.005 * wide) if text.get_ha() == "center" else box.x0
            if not text.get_text() or box.width < 1 or low + box.width <= limit - 0.003 * wide:
                break
        else:
            whole = text.get_text().split("\n")
            length = int(max(map(len, whole)) * (limit - low) / box.width)
            while length > 8 and low + text.get_window_extent(renderer).width > limit - 0.003 * wide:
                length -= 1
                text.set_text("\n".join(cut(line, length) for line in whole))


def label_points(ax, text, point, end=None, is_up=True, **style):
    """Writes a text at a point (data), beyond `end` on its ordinate: above, or below.

    It stays there unless it would lie on another such text or leave the panel; `save` then tries places about it.
    """
    label = ax.annotate(text, (point[0], point[1] if end is None else end), xytext=(0, 9), textcoords="offset points",
                        **{"fontsize": 8, "annotation_clip": False, **style})
    label.set_in_layout(False)
    high = 1.25 * label.get_fontsize() * (1 + text.count("\n"))
    steps = [9 + k * high for k in (0, 1, 2)]
    first, other = (1, -1) if is_up else (-1, 1)
    label.ways = [(0, first * s) for s in steps] + [(0, other * s) for s in steps]
    label.ways += [(side * 9, up * s) for s in (0, *steps) for up in (first, other) for side in (1, -1)]
    label.taken = point
    _put(label, label.ways[0])
    return label


def _put(label, way):
    """Moves a text to an offset from its point (points), so that it grows away from the point."""
    across, up = way
    label.set_position(way)
    label.set_ha("left" if across > 0 else "right" if across < 0 else "center")
    label.set_va("bottom" if up > 0 else "top" if up < 0 else "center")


def _shared(box, others):
    """The area (pixels) that a box shares with others."""
    return sum(max(min(box.x1, o.x1) - max(box.x0, o.x0), 0) * max(min(box.y1, o.y1) - max(box.y0, o.y0), 0) for o in others)


def _boxes_along(line, dpi):
    """Small boxes (pixels) along a line that a text must not cross; none for what is drawn of very many points."""
    vertices = line.get_transform().transform(line.get_path().vertices) if line.get_linestyle() != "None" else []
    if not 2 <= len(vertices) <= 60 or not np.all(np.isfinite(vertices)):
        return []
    step, boxes = 6 * dpi / 72, []
    for (x0, y0), (x1, y1) in zip(vertices, vertices[1:]):
        for part in np.linspace(0, 1, max(2, min(int(np.hypot(x1 - x0, y1 - y0) / step), 400))):
            x, y = x0 + part * (x1 - x0), y0 + part * (y1 - y0)
            boxes.append(matplotlib.transforms.Bbox.from_extents(x - 1, y - 1, x + 1, y + 1))
    return boxes


def settle_labels(figure):
    """Moves the texts of `label_points` apart, and hides those contour labels that lie on another one."""
    labels = [t for t in figure.findobj(matplotlib.text.Annotation) if hasattr(t, "ways")]
    optional = [t for t in figure.findobj(matplotlib.text.Text) if getattr(t, "is_optional", False)]
    if not labels and not optional:
        return
    renderer = figure.canvas.get_renderer()
    for ax in {t.axes: None for t in labels}:
        own = [t for t in labels if t.axes is ax]
        panel = ax.get_window_extent(renderer)
        reach = 4 * figure.dpi / 72  # of a marker
        taken = [matplotlib.transforms.Bbox.from_extents(x - reach, y - reach, x + reach, y + reach)
                 for x, y in ax.transData.transform([t.taken for t in own])]
        taken += [t.get_window_extent(renderer) for t in ax.texts if t not in own and t.get_visible() and t.get_text()]
        taken += [b for line in ax.lines for b in _boxes_along(line, figure.dpi)]
        taken += [ax.get_legend().get_window_extent(renderer)] if ax.get_legend() is not None else []
        for label in own:
            best = None
            for way in label.ways:
                _put(label, way)
                box = label.get_window_extent(renderer).padded(1.0)
                cost = _shared(box, taken) + box.width * box.height - _shared(box, [panel])
                if best is None or cost < best[0] - 1:
                    best = cost, way
                if cost < 1:
                    break
            _put(label, best[1])
            taken.append(label.get_window_extent(renderer))
    for ax in {t.axes: None for t in optional}:
        seen, panel = [], ax.get_window_extent(renderer)
        for text in (t for t in optional if t.axes is ax):
            box = text.get_window_extent(renderer)
            text.set_visible(_shared(box, seen) < 1 and _shared(box, [panel]) > 0.99 * box.width * box.height)
            seen += [box] if text.get_visible() else []


def label_contours(ax, lines, text_of, colour="white", halo="#333333", size=7):
    """Writes their values on contours; where lines run close, only so many as there is room for."""
    for label in ax.clabel(lines, fmt=text_of, fontsize=size, inline=False, colors=colour):
        label.set_path_effects([matplotlib.patheffects.withStroke(linewidth=1.5, foreground=halo)])
        label.is_optional = True


def dot_size(count, largest=6.0, smallest=1.8):
    """Size of the dots of a cloud of so many: few are large enough to be seen, many leave the ellipses legible."""
    return float(np.clip(largest * (30 / max(count, 1)) ** 0.25, smallest, largest))


def cloud(ax, x, y, smallest=1.8, **look):
    """Realisations as dots, below all lines."""
    ax.plot(x, y, ".", markersize=dot_size(len(x), smallest=smallest), rasterized=True, zorder=1,
            **{"color": "#56B4E9", "alpha": 0.5, "markeredgewidth": 0, **look})


def band(ax, margin):
    """1 and the margin within which a prediction agrees."""
    if margin:
        ax.axhspan(1 - margin, 1 + margin, color="#009E73", alpha=0.18, linewidth=0, zorder=0)
    ax.axhline(1, color="#444444", linewidth=1.0, zorder=1)


def legend_columns(figure, handles, most=7):
    """How many columns of a legend with these handles the figure has room for (9 points, 5.6 a letter)."""
    widest = max(len(h.get_label()) for h in handles) * 5.6 + 45
    return int(np.clip(0.96 * 72 * figure.get_figwidth() // widest, 1, min(most, len(handles))))


def interval_handle(confidence):
    return Line2D([], [], color="#444444", marker="|", linestyle="none", markersize=11, markeredgewidth=1.6,
                  label=f"{100 * confidence:g} % interval")


def margin_handle(margin, largest=None):
    """largest: of rows whose margins differ, of which `margin` is the smallest."""
    words = f"{margin:g}" if largest in (None, margin) else f"{margin:g} to {largest:g}"
    return [Patch(color="#009E73", alpha=0.18, label=f"agrees: 1 \N{PLUS-MINUS SIGN} {words}")] if margin else []


def heading(figure, title, text):
    """Title, and below it a text that says what is drawn and from how many trials.

    In a figure of constrained layout, lines that are too long are broken, and the panels leave room for all.
    """
    engine, high = figure.get_layout_engine(), figure.get_figheight()
    if engine is not None:
        wide = 0.96 * 72 * figure.get_figwidth()  # points; a letter of the title has 7.6, one of the text 5.6
        title = "\n".join(textwrap.wrap(title, int(wide / 7.6), max_lines=2, placeholder="\N{HORIZONTAL ELLIPSIS}"))
        text = "\n".join(line for given in text.split("\n") for line in textwrap.wrap(given, int(wide / 5.6)))
        engine.set(rect=(0, 0.08 / high, 1, 1 - (0.08 + 0.2 * (title.count("\n") + 1) + (0.19 * (text.count("\n") + 1) if text else 0) + 0.14) / high))
    figure.suptitle(title, x=0.02, y=1 - 0.08 / high if engine else 0.985, ha="left", va="top")
    if engine is not None:  # it would take its room a second time
        figure._suptitle.set_in_layout(False)
    top = 0.985 if engine is None else 1 - (0.08 + 0.2 * title.count("\n")) / high
    figure.text(0.02, top - (0.38 if engine is None else 0.27) / high, text, ha="left", va="top", linespacing=1.35)


def panels(count, size=(3.6, 2.9), columns=None, least_wide=6.4, **options):
    """A figure of so many panels beside and below each other: (figure, list of axes). size: of a panel (in).

    The last row may be shorter. Matplotlib's constrained layout gives the panels their places.
    """
    columns = columns or (count if count <= 3 else 2 if count == 4 else 3 if count <= 9 else 4)
    rows = -(-count // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(max(size[0] * columns, least_wide), size[1] * rows + 0.8), squeeze=False,
                                layout="constrained", **options)
    for spare in axes.flat[count:]:
        spare.remove()
    return figure, list(axes.flat[:count])


def legend_below(figure, handles, **options):
    """A legend below all panels of a figure of constrained layout; heading() comes first. None without handles."""
    if not handles:
        return None
    legend = figure.legend(handles=handles, loc="lower center", ncols=legend_columns(figure, handles), **options)
    legend.set_in_layout(False)
    engine = figure.get_layout_engine()
    share = legend.get_window_extent(figure.canvas.get_renderer()).height / figure.bbox.height
    left, bottom, wide, high = engine.get()["rect"]
    engine.set(rect=(left, share + bottom, wide, high - share))
    return legend


def apart(ticks, low, high, room):
    """As many ticks of a logarithmic axis as keep their distance, powers of ten first. room(tick): share of the axis that a label takes."""
    kept = []
    for tick in sorted(ticks, key=lambda t: (abs(math.log10(t) - round(math.log10(t))) > 1e-9, t)):
        if all(abs(math.log(tick / other)) > room(tick) * math.log(high / low) for other in kept):
            kept.append(tick)
    return sorted(kept)


def plain_log_axis(axis, low, high):
    """Ticks of a logarithmic axis that people read without thinking: 0.2, 0.5, 1, 2, 5 and no minor labels."""
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    decades = [10.0**e for e in range(first, last + 1) if low <= 10.0**e <= high]
    ticks = decades[::-(-len(decades) // 9)][::-1] if len(decades) > 5 else []
    for steps in ((1, 2, 5), (1, 1.5, 2, 3, 5, 7), (1, 1.2, 1.5, 1.8, 2, 2.5, 3, 4, 5, 6, 7, 8, 9)):
        if len(ticks) >= (4 if low > 1e-4 else 2):  # powers of ten need more room
            break
        ticks = [s * 10.0**e for e in range(first, last + 1) for s in steps if low <= s * 10.0**e <= high]
    if len(ticks) < 4 and high < 2 * low:  # as on a plain axis
        ticks = [t for t in matplotlib.ticker.MaxNLocator(5, steps=(1, 2, 5, 10)).tick_values(low, high) if low <= t <= high]
    axis.set_major_locator(matplotlib.ticker.FixedLocator(apart(ticks, low, high, lambda t: 0.04)))
    axis.set_major_formatter(matplotlib.ticker.FuncFormatter(lambda v, _: plain_size(v)))
    axis.set_minor_locator(matplotlib.ticker.NullLocator())
