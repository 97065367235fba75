"""The report as a folder of pages: a front page with a card for each study, a page for each study and each result of the
user's own, and all of it for paper. Every page is a file of its own, which needs no other and no network."""

import collections
import dataclasses
import os
import re
import secrets
import sys

import surveymc

from .. import storage, studies, view3d
from ..plots.reading import PlotError
from ..plots.runner import Drawn
from ..result import holm_limit
from . import figures, headlines, page, templating, text

FRONT, PAPER = "index", "paper"
LARGEST_PAGE = 3_000_000  # bytes
FIGURE_STEPS = (300_000, 120_000, 60_000, 30_000, 0)  # the largest SVG that is embedded; of a larger one, the PNG
LARGEST_FRONT = 2_000_000  # bytes of all pictures of the front page; cards beyond have none


@dataclasses.dataclass
class Article:
    """One result on its page. html, paper: its part of its page and of that for paper, with marks in place of the figures."""

    id: str
    title: str
    study: studies.Study
    is_own: bool
    html: str
    paper: str
    part: page.Part  # without its tables and drawings
    in_space: bool
    sentence: str
    rank: int
    page: str = ""


@dataclasses.dataclass
class Page:
    """One file of the report but the front page and that for paper. addresses: of its figures, by their marks."""

    name: str
    study: studies.Study
    is_own: bool
    articles: list
    of: tuple = (1, 1)  # this part of so many
    addresses: dict = dataclasses.field(default_factory=dict)


@dataclasses.dataclass
class Card:
    """What the front page shows of a study, or of a result of the user's own."""

    page: str
    title: str
    about: str
    sentence: str
    counts: dict
    results: int
    picture: dict | None


def _family(result):
    try:
        return result.family
    except (surveymc.ResultError, *storage.DAMAGE):  # opened, but not whole; articles() tells
        return []


def _order(known, result):
    study = studies.study_of(known, result.experiment)
    return study.order, study.experiment, result.path


def is_own(result):
    """Whether a result is the user's: of no config that is shipped."""
    return not studies.config_of(result.command, result.title)


class Report:
    """All pages of these results. base: the folder that names are relative to; folder: for the figures, or None; progress(done,
    all) after each drawn result."""

    def __init__(self, results, base, folder, jobs, note, progress, templates=None):
        self.environment = templating.environment(templates)
        self.base, self.note = base, note
        known = studies.load()
        results = sorted(results, key=lambda r: _order(known, r))
        self.drawn = {}
        if folder:
            tasks = [(i, r, studies.study_of(known, r.experiment).drawers_for(r.path),
                      os.path.join(folder, os.path.relpath(os.path.dirname(r.path) or ".", base).replace("..", "up")))
                     for i, r in enumerate(results)]
            self.drawn = figures.draw_all(tasks, jobs, progress)
        self.versions, self._marks = [], {}
        self.articles = self._articles(known, results)
        if not self.articles:
            raise PlotError("no result file could be read")
        self.pages = self._pages()

    # --- results ----------------------------------------------------------------------------------------------------

    def _articles(self, known, results):
        limit = holm_limit([p for result in results for p in _family(result)])
        found, taken, numbers = [], set(), collections.Counter()
        for i, result in enumerate(results):
            study = studies.study_of(known, result.experiment)
            stem = text.slug(os.path.splitext(os.path.relpath(result.path, self.base))[0])
            identity = next(n for k in range(len(results) + 1) if (n := f"result-{stem}" + (f"-{k + 1}" if k else "")) not in taken)
            taken.add(identity)
            try:
                own = is_own(result)
                group = identity if own else study.experiment  # figures are counted in it
                part = page.result_part(result, study, self.drawn.get(i, Drawn()), identity, os.path.relpath(result.path),
                                        numbers[group] + 1, limit)
                sentence = headlines.sentence(result, part.counts)
            except (surveymc.ResultError, *storage.DAMAGE) as error:  # opened, but not whole
                reason = " ".join(str(error).split()).removeprefix(f"{result.path}: ")
                print(f"surveymc report: left out: {result.path}: {reason}", file=sys.stderr)
                continue
            numbers[group] += len(part.figures)
            for figure in part.figures:
                figure.address = f"figure-{secrets.token_hex(12)}"
                _, figure.width, figure.height = figures.sized(figure.path)
                self._marks[figure.address] = figure.path
            heading = "h1" if own else "h2"
            html = self._render("result.html", r=part, heading=heading, paper=False)
            paper = self._render("result.html", r=part, heading="h2", paper=True)
            in_space = any(d.kind == "wells" for d in part.drawings)
            part.drawings, part.tables = [], []  # are set; they may be large
            found.append(Article(identity, part.title, study, own, html, paper, part, in_space, sentence,
                                 study.headline_rank(result.path)))
            version = f"{result.version} ({result.revision})"
            self.versions += [version] if version not in self.versions else []
        return found

    # --- which page has what ----------------------------------------------------------------------------------------

    def _pages(self):
        groups = collections.OrderedDict()
        for article in self.articles:
            key = article.id if article.is_own else article.study.experiment
            groups.setdefault((article.is_own, key), []).append(article)
        found, taken = [], {FRONT, PAPER}
        for (own, key), articles in sorted(groups.items(), key=lambda g: not g[0][0]):  # the user's own come first
            name = text.slug(os.path.splitext(articles[0].part.file)[0]) if own else re.sub(r"\W", "_", key, flags=re.A)
            name = next(n for k in range(len(groups) + 2) if (n := name + (f"-{k + 1}" if k else "")) not in taken)
            parts = self._split(articles)
            for k, (own_articles, addresses) in enumerate(parts):
                this = name + (f"-{k + 1}" if k else "")
                taken.add(this)
                found.append(Page(this, articles[0].study, own, own_articles, (k + 1, len(parts)), addresses))
        if len(found) == 1:  # needs no front page
            found[0].name = FRONT
        for p in found:
            for article in p.articles:
                article.page = f"{p.name}.html"
        return found

    def _split(self, articles):
        """[(articles, addresses)] for pages of at most LARGEST_PAGE: figures as SVG where they fit, as PNG where they do not, and
        more pages where that is too much still."""
        room = LARGEST_PAGE - self._frame(any(a.in_space for a in articles))
        for largest in FIGURE_STEPS:
            addresses = self._embedded(articles, largest)
            if self._size(articles, addresses) <= room:
                return [(articles, addresses)]
        parts, rest = [], []
        for article in articles:
            if rest and self._size([*rest, article], addresses) > room:
                parts.append(rest)
                rest = []
            rest.append(article)
        return [(part, {m: addresses[m] for a in part for m in self._marks_of(a)}) for part in (*parts, rest)]

    def _frame(self, in_space):
        """Bytes of a page besides its results, about."""
        if not hasattr(self, "_frames"):
            empty = self._render("page.html", file="", library="")
            self._frames = (len(empty.encode()) + 60_000, len(view3d.library()) if view3d.is_installed() else 0)
        return self._frames[0] + (self._frames[1] if in_space else 0)

    @staticmethod
    def _marks_of(article):
        return [f.address for f in article.part.figures]

    def _embedded(self, articles, largest):
        return {m: figures.embedded(self._marks[m], largest) for a in articles for m in self._marks_of(a)}

    def _size(self, articles, addresses):
        return sum(len(a.html.encode("utf-8", "backslashreplace")) + 20_000 / 82 + sum(len(addresses[m]) for m in self._marks_of(a))
                   for a in articles)

    # --- pages ------------------------------------------------------------------------------------------------------

    def _render(self, name, **values):
        return templating.render(self.environment, name, **values)

    @staticmethod
    def _with_figures(html, addresses):
        return text.Markup(re.sub(r"figure-[0-9a-f]{24}", lambda m: addresses.get(m[0], m[0]), html))

    def _summary(self):
        """What the front page says of all results together."""
        counts = page.added(a.part.counts for a in self.articles)
        chances = collections.Counter()
        for article in self.articles:
            chances.update(article.part.chances)
        groups = collections.OrderedDict()
        for article in self.articles:
            groups.setdefault(article.study.experiment, (article.study, []))[1].append(article)
        named = [(study.name, [row for a in articles for row in a.part.family]) for study, articles in groups.values()]
        findings = headlines.chosen([(a.study.experiment, headlines.Headline(
            a.rank, a.sentence, a.id, next((f.path for f in a.part.figures), ""), a.page)) for a in self.articles])
        return {"counts": counts, "judged": text.total(counts), "results": len(self.articles), "studies": len(groups),
                "chance": page.chance(chances) if chances else "", "groups": list(groups.values()), "families": page.families(named),
                "findings": findings, "versions": self.versions, "note": self.note}

    def _cards(self):
        """Cards of the user's own results, and of the studies."""
        room, own, shipped = LARGEST_FRONT, [], []
        for p in self.pages:
            if p.of[0] > 1:
                continue
            articles = [a for q in self.pages if (q.is_own, q.study.experiment) == (p.is_own, p.study.experiment) for a in q.articles
                        ] if not p.is_own else p.articles
            best = min(articles, key=lambda a: (not a.sentence, a.rank))
            picture = next((f for a in (best, *articles) for f in a.part.figures), None)
            shown = figures.thumbnail(picture.path) if picture else None
            if shown:
                room -= len(shown["address"])
            sentence = best.part.answer[0] if best.part.answer else best.sentence
            card = Card(f"{p.name}.html", best.title if p.is_own else p.study.name, f"{p.study.name}, {best.part.file}" if p.is_own else p.study.question, sentence,
                        page.added(a.part.counts for a in articles), len(articles), shown if room > 0 else None)
            (own if p.is_own else shipped).append(card)
        return own, shipped

    def files(self):
        """{name of the file: its text}, the front page first; each is made when it is asked for."""
        summary = self._summary()
        library = text.Markup(view3d.library()) if any(a.in_space for a in self.articles) else ""
        whole = len(self.pages) == 1
        if not whole:
            first = next((f.figure for f in summary["findings"] if f.figure), "")
            own, shipped = self._cards()
            yield f"{FRONT}.html", self._render("front.html", file="surveymc", own=own, shipped=shipped, summary=summary,
                                                first_figure=figures.picture(first) if first else None, paper=f"{PAPER}.html")
        for p in self.pages:
            siblings = [q for q in self.pages if (q.is_own, q.study.experiment) == (p.is_own, p.study.experiment)] if not p.is_own else [p]
            html = self._with_figures("\n".join(a.html for a in p.articles), p.addresses)
            contents = [(a.page + "#" + a.id if q is not p else "#" + a.id, a.title) for q in siblings for a in q.articles]
            yield f"{p.name}.html", self._render(
                "own.html" if p.is_own else "study.html", file=p.name if p.name != FRONT else self.articles[0].id.removeprefix("result-"),
                page=p, study=p.study, articles=p.articles, html=html, contents=contents, front="" if whole else f"{FRONT}.html",
                summary=summary, whole=whole, library=library if any(a.in_space for a in p.articles) else "")
        if not whole:
            addresses = {m: a for p in self.pages for m, a in p.addresses.items()}
            body = [(p, self._with_figures("\n".join(a.paper for a in p.articles), addresses)) for p in self.pages]
            yield f"{PAPER}.html", self._render("paper.html", file="surveymc", pages=body, summary=summary)
