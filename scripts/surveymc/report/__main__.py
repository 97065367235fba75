"""One page with all results: summary sentences, figures, comparison tables, drawings to play with.

    surveymc report [RESULT.h5 | FOLDER ...] [-o REPORT.html] [--base FOLDER] [--figures FOLDER] [--jobs N] [--no-figures]
                    [--note TEXT]

Reads the result files that are named, or all of a folder and its folders (results/, without its quick/), draws their
figures with the drawers that studies.toml names (kept in FOLDER/figures, drawn again only when data or code have
changed), and writes one self-contained HTML file: no network, no other files. Results of any experiment can be shown.
"""

import os
import re
import sys

import surveymc

from .. import storage, streams, studies, whole_file
from ..arguments import Parser
from ..plots import saving
from ..plots.reading import PlotError
from ..plots.runner import Drawn
from ..result import holm_limit
from . import figures, headlines, page, text

MAKER = "surveymc report"  # of the page, which only a page of it replaces


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


def _family(result):
    try:
        return result.family
    except (surveymc.ResultError, *storage.DAMAGE):  # opened, but not whole; make() tells
        return []


def _order(known, result):
    study = studies.study_of(known, result.experiment)
    return study.order, study.experiment, result.path


def make(results, base, folder, jobs, note, progress):
    """The page of these results. base: folder that paths of figures are relative to; folder: for the figures, or None."""
    known = studies.load()
    results = sorted(results, key=lambda r: _order(known, r))
    drawn = {}
    if folder:
        tasks = [(i, r, studies.study_of(known, r.experiment).drawers_for(r.path),
                  os.path.join(folder, os.path.relpath(os.path.dirname(r.path) or ".", base).replace("..", "up")))
                 for i, r in enumerate(results)]
        drawn = figures.draw_all(tasks, jobs, progress)
    limit = holm_limit([p for result in results for p in _family(result)])
    groups, taken, number, versions, findings, left_out = [], set(), 1, [], [], 0
    for i, result in enumerate(results):
        study = studies.study_of(known, result.experiment)
        stem = text.slug(os.path.splitext(os.path.relpath(result.path, base))[0])
        identity = next(n for k in range(len(results) + 1) if (n := f"result-{stem}" + (f"-{k + 1}" if k else "")) not in taken)
        taken.add(identity)
        try:
            html, counts, chances, family, count = page.result_part(result, study, drawn.get(i, Drawn()), identity,
                                                                  os.path.relpath(result.path), number, limit)
            sentence = headlines.sentence(result, counts)
        except (surveymc.ResultError, *storage.DAMAGE) as error:  # opened, but not whole
            reason = " ".join(str(error).split()).removeprefix(f"{result.path}: ")
            print(f"surveymc report: left out: {result.path}: {reason}", file=sys.stderr)
            left_out += 1
            continue
        if not groups or groups[-1][0].experiment != study.experiment:
            groups.append((study, []))
        number += count
        findings.append((study.experiment, headlines.Headline(study.headline_rank(result.path), sentence, identity,
                                                              next(iter(drawn.get(i, Drawn()).files), ""))))
        title = result.title or os.path.splitext(os.path.basename(result.path))[0]
        groups[-1][1].append({"id": identity, "title": title, "counts": counts, "chances": chances, "family": family,
                              "html": html})
        version = f"{result.version} ({result.revision})"
        versions += [version] if version not in versions else []
    if not groups:
        raise PlotError("no result file could be read")
    return page.page(groups, versions, note, headlines.chosen(findings)), drawn.values(), len(taken) - left_out


def main():
    parser = Parser(description="Write one self-contained HTML report of result files.")
    parser.add_argument("results", nargs="*", metavar="RESULT", help="result files or folders (results/)")
    parser.add_argument("-o", "--output", metavar="FILE", help="the page (report.html in the first folder, or beside the file)")
    parser.add_argument("--base", metavar="FOLDER", help="folder that results are named by (the one that all are in)")
    parser.add_argument("--figures", metavar="FOLDER", help="where figures are kept (figures/ beside the page)")
    parser.add_argument("--jobs", type=int, default=min(2, os.cpu_count() or 1), metavar="N", help="figures drawn at a time (2)")
    parser.add_argument("--no-figures", action="store_true", help="only tables and interactive drawings")
    parser.add_argument("--note", default="", help="a sentence for the head of the page")
    arguments = parser.parse_args()
    paths = arguments.results or [os.path.join(studies.ROOT, "results")]
    files = result_files(paths)
    base = arguments.base or os.path.commonpath([os.path.abspath(p) if os.path.isdir(p) else os.path.dirname(os.path.abspath(p))
                                                 for p in paths])
    output = arguments.output or os.path.join(os.path.relpath(base), "report.html")
    folder = None if arguments.no_figures else arguments.figures or os.path.join(os.path.dirname(output) or ".", "figures")
    results = read_all(files)

    def progress(done, of):
        if sys.stderr.isatty():
            sys.stderr.raw(f"\rfigures of {done} of {of} results{chr(10) if done == of else ''}".encode())

    try:
        whole_file.check_target(output)
        os.makedirs(os.path.dirname(output) or ".", exist_ok=True)
        html, drawn, shown = make(results, base, folder, arguments.jobs, arguments.note, progress)
    except OSError as error:  # of a figure, the place of that
        place = error.filename or output
        raise PlotError(f"{place}: cannot write: {error.strerror or error}", streams.CANNOT_WRITE) from None
    data = html.encode("utf-8", "backslashreplace")
    saving.write(output, whole_file.marked(data, MAKER), whole_file.is_marked_by(MAKER))
    print(f"{output}: {shown} result{'s' if shown != 1 else ''}, {len(data) / 1e6:.1f} MB")
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
