"""Draws the figures of results in several processes, and makes their SVG fit to stand in a page."""

import base64
import concurrent.futures
import concurrent.futures.process
import contextlib
import functools
import hashlib
import io
import json
import multiprocessing
import os
import re
import signal

from .. import studies, whole_file
from ..plots import runner, saving
from ..plots.runner import Drawn

LARGEST_SVG = 300_000  # bytes; a figure with finer contours than that is embedded as the PNG that was drawn with it
LARGEST_RECORD = 1 << 20  # bytes


@functools.cache
def _code():
    """What draws: a hash of surveymc.plots."""
    folder = os.path.join(studies.PACKAGE, "plots")
    files = [os.path.join(folder, f) for f in sorted(os.listdir(folder)) if f.endswith((".py", ".mplstyle"))]
    return hashlib.sha256("".join(map(_hash, files)).encode()).hexdigest()


def _stamp(result, names):
    """What the figures depend on: the result's data, its drawers, and their code."""
    return hashlib.sha256("\n".join([result.content_hash, *names, _code()]).encode()).hexdigest()


def _draw(result_path, stem, names, folder, stamp):
    """Runs the drawers for one result; what they drew is kept in `folder` with a stamp, and not drawn again."""
    record_path = os.path.join(folder, f".{stem}.figures.json")
    record = _record(record_path)
    if record and record["stamp"] == stamp and all(_hash(os.path.join(folder, f)) == h for f, h in record["files"].items()):
        return Drawn([os.path.join(folder, f) for f in record["files"]], record["messages"])
    drawn = runner.draw(result_path, names, folder)
    if not drawn.broken:  # what failed is tried again
        kept = {os.path.basename(f): _hash(f) for f in drawn.files}
        text = json.dumps({"stamp": stamp, "files": kept, "messages": drawn.messages})
        with contextlib.suppress(OSError):  # without it, they are drawn again
            whole_file.write(record_path, text.encode(), lambda name: bool(_record(name)))
    return drawn


def _record(path):
    """The record of figures in this file; None if it is none."""
    try:
        record = json.loads(whole_file.read_regular(path, LARGEST_RECORD))
        return record if {"stamp", "files", "messages"} == set(record) and isinstance(record["files"], dict) else None
    except (OSError, ValueError, TypeError, RecursionError):
        return None


def _hash(path):
    """Of a figure that is there; "" if it is not."""
    try:
        return hashlib.sha256(whole_file.read_regular(path)).hexdigest()
    except OSError:
        return ""


def _start_worker():
    """Once a process. Ctrl-C is the parent's: it ends the pool without tracebacks."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _task(task):
    key, *arguments = task
    return key, _draw(*arguments)


def draw_all(tasks, jobs, progress):
    """Figures of many results: {key: Drawn}.

    tasks: (key, result, drawers, folder for the figures) each; jobs: processes; progress(done, all) is called after
    each result. Drawers that are declared but are not there are left out. Where a process ends amid its work, the others go on. Ctrl-C ends all at once.
    """
    figures, waiting = {}, []
    for key, result, names, folder in tasks:
        there = [n for n in names if runner.is_drawer(n)]
        waiting.append((key, result.path, saving.stem_of(result.path), there, folder, _stamp(result, there)))

    def finish(workers, tasks):
        """Draws these, and returns those that are left where a process ended amid its work (damaged data, no memory)."""
        pool = concurrent.futures.ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), _start_worker)
        try:
            for done in concurrent.futures.as_completed([pool.submit(_task, task) for task in tasks]):
                key, figures[key] = done.result()
                progress(len(figures), len(waiting))
        except concurrent.futures.process.BrokenProcessPool:
            pass
        except BaseException:  # Ctrl-C, a disk that is full: nobody waits for a figure that is being drawn
            for worker in multiprocessing.active_children():
                worker.terminate()
            raise
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
        return [task for task in tasks if task[0] not in figures]

    left = finish(max(1, jobs), waiting)
    while left:  # one by one: which of them ends the process?
        first, *later = left
        if finish(1, [first]):
            figures[first[0]] = Drawn(broken=[f"{first[1]}: the process that drew its figures was ended"], code=1)
            progress(len(figures), len(waiting))
        left = finish(max(1, jobs), later) if later else []
    return figures


def sized(path):
    """A figure's SVG, and its width and height in CSS pixels. path: its SVG."""
    svg = whole_file.read_regular(path).decode("utf-8")
    return svg, *size_of(svg)


def embedded(path, largest=LARGEST_SVG):
    """A figure for the page, as data URI: the SVG, or the PNG beside it where that is smaller and the SVG has more than `largest`
    bytes."""
    address = _svg_address(path)
    picture = os.path.splitext(path)[0] + ".png"
    if len(address) > largest and os.path.exists(picture):
        address = min(address, _small_png(picture), key=len)
    return address


def picture(path):
    """A figure for the front page: {address, width, height}."""
    _, width, height = sized(path)
    return {"address": embedded(path), "width": width, "height": height, "id": "", "caption": "Figure of the first finding"}


@functools.lru_cache(512)
def _svg_address(path):
    return as_address(sized(path)[0])


def thumbnail(path, width=520):
    """A small picture of a figure: {address, width, height}, of its PNG; None where that is not there."""
    from PIL import Image  # comes with matplotlib

    name, data = os.path.splitext(path)[0] + ".png", io.BytesIO()
    if not os.path.exists(name):
        return None
    with Image.open(name) as picture:
        small = picture.convert("RGB")
        small.thumbnail((width, width), Image.Resampling.LANCZOS)
        small.quantize(64, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE).save(data, "PNG", optimize=True)
    return {"address": "data:image/png;base64," + base64.b64encode(data.getvalue()).decode("ascii"), "width": small.width,
            "height": small.height}


@functools.lru_cache(512)
def _small_png(path):
    """A PNG as data URI, in its 256 commonest colours: a third of the size, and the eye sees no difference in a figure."""
    from PIL import Image  # comes with matplotlib

    data = io.BytesIO()
    with Image.open(path) as picture:
        picture.convert("RGB").quantize(256, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE).save(data, "PNG", compress_level=7)
    return "data:image/png;base64," + base64.b64encode(data.getvalue()).decode("ascii")


def as_address(svg):
    """An SVG of matplotlib as a data URI: an image of its own, so that its ids and styles meet no others on the page.

    Without XML and document type declarations, metadata (which names addresses) and needless digits. Rasterised parts stay.
    """
    svg = svg[svg.index("<svg"):]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.S)
    svg = re.sub(r"<!--.*?-->", "", svg, flags=re.S)

    def shorter(match):  # positions are in points: 1/100 of one is below what any screen or printer shows
        return match[1] + re.sub(r"-?\d+\.\d{3,}", lambda n: f"{float(n[0]):.2f}".rstrip("0").rstrip("."), match[2]) + '"'

    parts = re.split(r"(<defs>.*?</defs>)", svg, flags=re.S)  # glyphs and markers are scaled: they keep their digits
    for i in range(0, len(parts), 2):
        parts[i] = re.sub(r'(\bd=")([^"]*)"', shorter, parts[i])
    svg = re.sub(r"\s*\n\s*", " ", "".join(parts)).replace('"', "'")
    for character in "%#<>&":  # "%" first
        svg = svg.replace(character, f"%{ord(character):02X}")
    return "data:image/svg+xml," + svg


def size_of(svg):
    """Width and height of an SVG in CSS pixels, for the page to leave room before it is decoded."""
    found = re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', svg)
    return (round(float(found[1]) * 96 / 72), round(float(found[2]) * 96 / 72)) if found else (800, 500)
