#!/usr/bin/python3
"""Draws all figures that belong to a result, whatever its experiment: draw_result.py RESULT.h5 [-o FOLDER] [--point N]

Runs the plot scripts that studies.toml names for the experiment and prints the paths of the figures. Figures that show one
sweep point are drawn of the first one, or of that given with --point.
"""

import sys

import plotting
import studies
import surveymc
from plotting import PlotError
from report_page import figures


def main():
    parser = plotting.argument_parser("Draw all figures of a result of any experiment.")
    parser.add_argument("--point", type=int, metavar="N", help="sweep point of figures that show one, from 0")
    arguments = parser.parse_args()
    try:
        result = surveymc.open(arguments.result)
    except surveymc.ResultError as error:
        raise PlotError(str(error)) from None
    folder = plotting.figures_folder(arguments.output, arguments.result)
    scripts = studies.study_of(studies.load(), result.experiment).scripts_for(result.path)
    drawn = figures.draw(result.path, scripts, folder, arguments.point)
    for note in drawn.kept:
        print(note, file=sys.stderr)
    for path in drawn.files:
        print(path.removesuffix(".svg") + ".png")
        print(path)
    if drawn.broken:
        raise PlotError(f"{arguments.result}: a plot script failed: {'; '.join(drawn.broken)}", drawn.code)
    if not drawn.files:
        said = "; ".join(drawn.messages) or f"no figures are known for experiment '{result.experiment}'"
        raise PlotError(f"{arguments.result}: {said}", drawn.code or plotting.BAD_DATA)


if __name__ == "__main__":
    plotting.run(main)
