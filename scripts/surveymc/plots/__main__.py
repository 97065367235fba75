"""Draws the figures of a result, whatever its experiment.

    surveymc plot RESULT.h5 [-o FOLDER] [--point N]     all that studies.toml names for the experiment
    surveymc plot RESULT.h5 --quantity TABLE.NAME       a quantity of your choice against the keys of the sweep (sweep --help)
    surveymc plot RESULT.h5 --3d                        its wells in space, as a page to turn and to zoom: NAME_3d.html
    surveymc plot DRAWER RESULT.h5 [options]            those of one drawer, with its own options (DRAWER --help)

Prints the paths of the figures. Figures that show one sweep point are drawn of the first one, or of that given with --point. A sweep has an overview, whose figures
say what is drawn of how many values; --quantity and --at choose.
"""

import argparse
import importlib.util
import os
import sys

from .. import storage, streams, studies
from ..arguments import USAGE, Parser, nearest
from . import reading, runner, saving, sweep
from .reading import PlotError


def drawers():
    folder = os.path.dirname(os.path.abspath(__file__))
    return sorted(n for f in os.listdir(folder) if f.endswith(".py") and runner.is_drawer(n := f.removesuffix(".py")))


def draw_in_space(arguments):
    """Writes NAME_3d.html of a result's wells, and prints its path."""
    missing = [n for n in ("pandas", "jinja2") if importlib.util.find_spec(n) is None]
    if missing:
        raise PlotError(f"--3d needs {', '.join(missing)}: sudo apt install {' '.join(f'python3-{n}' for n in missing)}", 1)
    from .. import view3d

    path = os.path.join(saving.figures_folder(arguments.output, arguments.result), f"{saving.stem_of(arguments.result)}_3d.html")
    try:
        kept = view3d.write(arguments.result, path)
    except storage.ResultError as error:
        raise PlotError(str(error)) from None
    except OSError as error:
        raise PlotError(f"{path}: cannot write: {error.strerror or error}", streams.CANNOT_WRITE) from None
    if kept:
        print(f"{path}: was there, and was not made from this: kept as {os.path.relpath(kept)}", file=sys.stderr)
    print(path)


def main():
    parser = Parser(description=__doc__, epilog=f"Drawers: {', '.join(drawers())}.", formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("result", help="result file (HDF5) of surveymc")
    parser.add_argument("-o", "--output", metavar="FOLDER", help="where to write (default: the folder of the result)")
    parser.add_argument("--point", type=int, metavar="N", help="sweep point of figures that show one, from 0")
    parser.add_argument("--3d", dest="in_space", action="store_true", help="only its wells in space: NAME_3d.html")
    sweep.add_choices(parser)
    arguments = parser.parse_args()
    if arguments.in_space:
        draw_in_space(arguments)
        return
    if arguments.quantity or arguments.at:
        sweep.main()
        return
    try:
        with storage.open_file(arguments.result) as file:
            experiment = reading.text_attribute(file, "experiment")
    except storage.ResultError as error:
        raise PlotError(str(error)) from None
    folder = saving.figures_folder(arguments.output, arguments.result)
    names = studies.study_of(studies.load(), experiment).drawers_for(arguments.result) or ["sweep"]
    drawn = runner.draw(arguments.result, names, folder, arguments.point)
    for note in drawn.kept + drawn.notes * (not drawn.broken):
        print(note, file=sys.stderr)
    for path in drawn.files:
        print(path.removesuffix(".svg") + ".png")
        print(path)
    if drawn.broken:
        raise PlotError(f"{arguments.result}: a drawer failed: {'; '.join(drawn.broken)}", drawn.code)
    if not drawn.files:
        said = "; ".join(drawn.messages) or f"no figures are known for experiment '{experiment}'"
        raise PlotError(f"{arguments.result}: {said}", drawn.code or reading.BAD_DATA)


def command():
    if len(sys.argv) > 1 and runner.is_drawer(sys.argv[1]):
        runner.start(sys.argv[1], sys.argv[2:])
    elif len(sys.argv) > 2 and sys.argv[1].isidentifier() and not os.path.exists(sys.argv[1]):
        near = nearest(sys.argv[1], drawers())
        print(f"surveymc plot: {sys.argv[1]}: no drawer has this name: "
              + (f"did you mean {near}?" if near else f"there are {', '.join(drawers())}"), file=sys.stderr)
        sys.exit(USAGE)
    else:
        streams.run(main, runner.COMMAND)


if __name__ == "__main__":
    command()
