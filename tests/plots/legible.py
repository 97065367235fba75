"""What makes a figure hard to read, measured by matplotlib's renderer: texts upon each other, or cut off by the edge."""
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
import matplotlib  # noqa: E402

SLACK = 2  # pixels of 100 dpi by which boxes may share: a box is wider than its letters
RAW_KEY = re.compile(r"\b[a-z]+(?:_[a-z]+)*\.[a-z]\w*_\w+|\b[a-z]+_(?:nT|mps2|mg|deg|m)\b")


def _words(text):
    return " ".join(text.get_text().split())


def drawn_texts(figure, renderer):
    """All visible texts of a figure with their boxes; labels of ticks beyond the limits of an axis are not drawn."""
    found = [t for t in figure.findobj(matplotlib.text.Text) if t.get_visible() and _words(t)]
    hidden = set()
    for ax in figure.findobj(matplotlib.axes.Axes):
        if not ax.get_visible() or ax.name == "3d":  # ticks in space are placed as they are drawn
            hidden.update(map(id, ax.findobj(matplotlib.text.Text)))
            continue
        for axis in (ax.xaxis, ax.yaxis):
            shown = {id(t) for tick in axis._update_ticks() for t in (tick.label1, tick.label2)} if ax.axison else set()
            every = {id(t) for tick in axis.get_major_ticks() + axis.get_minor_ticks() for t in (tick.label1, tick.label2)}
            hidden |= every - shown
        if not ax.axison:
            hidden.update(id(t) for axis in (ax.xaxis, ax.yaxis) for t in axis.findobj(matplotlib.text.Text))
    boxes = []
    for text in found:
        if id(text) in hidden:
            continue
        box = text.get_window_extent(renderer)
        if box.width > 1 and box.height > 1:
            boxes.append((text, box))
    return boxes


def faults(figure):
    """What is wrong with the texts of a figure, a sentence each."""
    figure.draw_without_rendering()
    renderer = figure.canvas.get_renderer()
    boxes = drawn_texts(figure, renderer)
    slack = SLACK * figure.dpi / 100
    said = []
    for text, box in boxes:
        if box.x0 < -slack or box.y0 < -slack or box.x1 > figure.bbox.width + slack or box.y1 > figure.bbox.height + slack:
            said.append(f"'{_words(text)}' leaves the figure")
        if RAW_KEY.search(_words(text)):
            said.append(f"'{_words(text)}' shows a key")
    for i, (text, box) in enumerate(boxes):
        for other, its in boxes[i + 1:]:
            if text.get_rotation() % 90 or other.get_rotation() % 90:
                continue
            wide = min(box.x1, its.x1) - max(box.x0, its.x0)
            high = min(box.y1, its.y1) - max(box.y0, its.y0)
            if wide > slack and high > slack:
                said.append(f"'{_words(text)}' and '{_words(other)}' share {wide:.0f} x {high:.0f} pixels")
    return said
