"""The command line of a drawer, and the files that it writes."""

import io
import os
import re
import sys

import matplotlib.pyplot as plt

from .. import streams, whole_file
from ..arguments import Parser
from ..streams import CANNOT_WRITE
from .drawing import fit_texts, settle_labels
from .reading import PlotError, Saved


def argument_parser(description):
    """Arguments every drawer has: the result file and the folder to write to."""
    parser = Parser(description=description)
    parser.add_argument("result", help="result file (HDF5) of surveymc")
    parser.add_argument("-o", "--output", metavar="FOLDER", help="where to write (default: the folder of the result)")
    return parser


def stem_of(result):
    """What the names of a result's figures begin with: the name of its file, as it is printed, on one line."""
    return re.sub("[\n\t]", "_", streams.visible(os.path.splitext(os.path.basename(result))[0]))


def figures_folder(output, result):
    """The folder to write to, made if need be; by default the one of the result."""
    folder = output or os.path.dirname(result) or "."
    try:
        os.makedirs(folder, exist_ok=True)
    except OSError as error:
        raise PlotError(f"{folder}: cannot make the folder: {error.strerror}", CANNOT_WRITE) from None
    return folder


def save(figure, folder, name):
    """Writes <name>.png (150 dpi) and <name>.svg, closes the figure, prints the two paths.

    The files depend on the data only: no dates, and clips are counted, where matplotlib names them by addresses in memory.
    Rasterised parts of the SVG have 300 dpi. A figure that the same script has made of the same result (of its experiment and
    title) is replaced, if nobody has changed it since; any other file is kept under the next free number.
    """
    fit_texts(figure)
    if figure.get_layout_engine() is not None:
        figure.get_layout_engine().execute(figure)
        figure.set_layout_engine("none")  # the panels have their places, in both files; to find them takes as long as to draw
        figure.get_layout_engine = lambda: None  # or savefig would draw once more, to let one place them
    settle_labels(figure)
    picture, drawing = io.BytesIO(), io.StringIO()
    figure.savefig(picture, format="png", metadata={"Software": None})
    figure.savefig(drawing, format="svg", metadata={"Date": None}, dpi=300)
    plt.close(figure)
    svg = streams.visible(drawing.getvalue())  # a control character is no XML
    clips = {clip: f"clip{i}" for i, clip in enumerate(re.findall(r'<clipPath id="(\w+)"', svg), 1)}
    svg = re.sub(r'(<clipPath id="|url\(#)(\w+)', lambda use: use[1] + clips.get(use[2], use[2]), svg)
    maker = "\n".join([os.path.basename(sys.argv[0]), *dict.fromkeys(Saved.results)])
    for extension, data in ((".png", picture.getvalue()), (".svg", svg.encode())):
        path = os.path.join(folder, name + extension)
        write(path, whole_file.marked(data, maker), whole_file.is_marked_by(maker))
        print(path)
        Saved.paths.append(path)


def write(path, data, is_ours):
    """Writes a file whole, says what it has kept, and what it could not write."""
    try:
        kept = whole_file.write(path, data, is_ours)
    except OSError as error:
        raise PlotError(f"{path}: cannot write: {error.strerror or error}", CANNOT_WRITE) from None
    if kept:
        Saved.kept.append(f"{path}: was there, and was not made from this: kept as {os.path.relpath(kept)}")
        print(Saved.kept[-1], file=sys.stderr)


def save_all(figures, arguments):
    """Saves {name: figure}, None where there is nothing to draw, as <stem>_<name> into the folder that the arguments name."""
    folder = figures_folder(arguments.output, arguments.result)
    for name, figure in figures.items():
        if figure is not None:
            save(figure, folder, f"{stem_of(arguments.result)}_{name}")
