"""The findings at the head of the report: the first sentence of each result's answer."""

import dataclasses

from .text import counts_sentence, grouped

MOST = 3  # sentences at the head of the page


@dataclasses.dataclass
class Headline:
    """One finding. rank: its place (smaller is first); sentence: plain text; result: id of its part of the page; page: its file."""

    rank: int
    sentence: str
    result: str
    figure: str = ""
    page: str = ""


def sentence(result, counts):
    """The finding of a result. counts: its verdict counts, which speak where it has no answer (of an older program)."""
    if result.answer:
        return f"{result.title}: {result.answer[0]}" if result.title else result.answer[0]
    judged = sum(counts[k] for k in ("agrees", "finding", "undecided", "differs"))
    return f"{result.title}: of {grouped(judged)} predictions and published values, {counts_sentence(counts)}." if judged else ""


def chosen(candidates):
    """At most MOST headlines, the best of each study. candidates: [(experiment, Headline)]."""
    best = {}
    for experiment, headline in candidates:
        if headline.sentence and (experiment not in best or headline.rank < best[experiment].rank):
            best[experiment] = headline
    return sorted(best.values(), key=lambda h: h.rank)[:MOST]
