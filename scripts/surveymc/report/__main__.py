"""A folder of pages with all results: summary sentences, figures, comparison tables, drawings to play with.

    surveymc report [RESULT.h5 | FOLDER ...] [-o FOLDER] [--base FOLDER] [--figures FOLDER] [--jobs N] [--no-figures]
                    [--note TEXT] [--templates FOLDER]

Reads the result files that are named, or all of a folder and its folders (results/, without its quick/), draws their
figures with the drawers that studies.toml names (kept in FOLDER/figures, drawn again only when data or code have
changed), and writes FOLDER/index.html, a page for each study and each result of your own, and paper.html. Each page is one file
that needs no network and no other file. Results of any experiment can be shown.
"""

import os
import re
import sys

import surveymc

from .. import streams, studies, whole_file
from ..arguments import USAGE, Parser
from ..plots import saving
from ..plots.reading import PlotError
from .pages import FRONT, Report

MAKER = "surveymc report"  # of the pages, which only pages of it replace


def is_kept_old(name, beside):
    """True for x.1.h5 beside x.h5: an earlier result that a new run has kept."""
    old = re.fullmatch(r"(.+)\.\d+\.h5", name)
    return bool(old) and f"{old[1]}.h5" in beside


def result_files(paths):
    """All result files that are meant, in their order and once each, and the folder that names are relative to."""
    found = []
    for path in paths:
        if os.path.isdir(path):
            for folder, inner, names in os.walk(path):
                inner[:] = sorted(d for d in inner if d != "figures" and not (d == "quick" and folder == path))
                found += [os.path.join(folder, n) for n in sorted(names)
                          if n.endswith(".h5") and not n.startswith(".") and not is_kept_old(n, names)]
        elif os.path.exists(path):
            found.append(path)
        else:
            raise PlotError(f"{path}: no such file or folder")
    if not found:
        raise PlotError(f"{', '.join(paths)}: no result files (*.h5); scripts/run_all.sh makes them")
    return list(dict.fromkeys(os.path.normpath(f) for f in found))


def read_all(paths):
    """The results that can be read; the others are named on stderr, and left out."""
    results = []
    for path in paths:
        try:
            results.append(surveymc.Result(path))  # its warnings are on the page
        except surveymc.ResultError as error:
            print(f"surveymc report: left out: {error}", file=sys.stderr)
    if not results:
        raise PlotError("no result file could be read")
    return results


def remove_old(folder, written):
    """Pages of ours in this folder that the report has no longer."""
    for name in os.listdir(folder):
        path = os.path.join(folder, name)
        if name.endswith(".html") and name not in written and os.path.isfile(path) and whole_file.is_marked_by(MAKER)(path):
            os.unlink(path)


def main():
    parser = Parser(description="Write a folder of HTML pages about result files: index.html, and a page for each study.")
    parser.add_argument("results", nargs="*", metavar="RESULT", help="result files or folders (results/)")
    parser.add_argument("-o", "--output", metavar="FOLDER", help="where the pages go (report/ in the first folder, or beside the file)")
    parser.add_argument("--base", metavar="FOLDER", help="folder that results are named by (the one that all are in)")
    parser.add_argument("--figures", metavar="FOLDER", help="where figures are kept (figures/ in the folder of the pages)")
    parser.add_argument("--jobs", type=int, default=min(2, os.cpu_count() or 1), metavar="N", help="figures drawn at a time (2)")
    parser.add_argument("--no-figures", action="store_true", help="only tables and interactive drawings")
    parser.add_argument("--note", default="", help="a sentence for the head of the pages")
    parser.add_argument("--templates", metavar="FOLDER", help="your own templates, in place of those of the same name")
    arguments = parser.parse_args()
    here = "results" if os.path.isdir("results") or not studies.is_source() else os.path.join(studies.ROOT, "results")
    paths = arguments.results or [here]
    files = result_files(paths)
    base = arguments.base or os.path.commonpath([os.path.abspath(p) if os.path.isdir(p) else os.path.dirname(os.path.abspath(p))
                                                 for p in paths])
    output = arguments.output or os.path.join(os.path.relpath(base), "report")
    if output.endswith(".html"):
        raise PlotError(f"-o {output}: the report is a folder of pages: name a folder (-o {output.removesuffix('.html')})", USAGE)
    if arguments.templates and not os.path.isdir(arguments.templates):
        raise PlotError(f"--templates {arguments.templates}: no such folder", USAGE)
    folder = None if arguments.no_figures else arguments.figures or os.path.join(output, "figures")
    results = read_all(files)

    def progress(done, of):
        if sys.stderr.isatty():
            sys.stderr.raw(f"\rfigures of {done} of {of} results{chr(10) if done == of else ''}".encode())

    size, written = 0, []
    try:
        front = os.path.join(output, f"{FRONT}.html")
        os.makedirs(output, exist_ok=True)
        whole_file.check_target(front)
        report = Report(results, base, folder, arguments.jobs, arguments.note, progress, arguments.templates)
    except OSError as error:  # of a figure, the place of that
        place = error.filename or output
        raise PlotError(f"{place}: cannot write: {error.strerror or error}", streams.CANNOT_WRITE) from None
    for name, html in report.files():
        data = html.encode("utf-8", "backslashreplace")
        saving.write(os.path.join(output, name), whole_file.marked(data, MAKER), whole_file.is_marked_by(MAKER))
        size += len(data)
        written.append(name)
    remove_old(output, written)
    shown, drawn = len(report.articles), report.drawn.values()
    print(f"{front}: {shown} result{'s' if shown != 1 else ''}, {len(written)} page{'s' if len(written) != 1 else ''}, {size / 1e6:.1f} MB")
    for figure in drawn:
        for message in figure.kept:
            print(message, file=sys.stderr)
        for message in figure.broken:
            print(f"surveymc report: a drawer failed: {message}", file=sys.stderr)
    codes = {figure.code for figure in drawn if figure.broken}
    return streams.CANNOT_WRITE if streams.CANNOT_WRITE in codes else 1 if codes else 0


def command():
    streams.run(main, "surveymc report")


if __name__ == "__main__":
    command()
