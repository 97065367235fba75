"""What the pages of the report say of results: plain values, which the templates in templates/ set."""

import collections
import dataclasses
import math
import os
import re
import shlex

from .. import studies, view3d
from ..plots import saving
from ..result import MAY_BE_CHANCE, agreement_share, family_rows, holm, test_rows
from . import explore, figures, tables
from .text import grouped, number, shell_word, slug, total


def added(all_counts):
    """Verdict counts (tables.counts_of) of several tables or results together."""
    found = tables.no_counts()
    for counts in all_counts:
        for k, v in counts.items():
            found[k] += v
    return found


def chances_of(frames):
    """How many rows of comparison tables are judged by intervals of which level: {confidence: rows}."""
    found = collections.Counter()
    for frame in frames:
        if math.isfinite(frame.attrs["confidence"]) and "ratio" in frame:
            found[round(frame.attrs["confidence"], 9)] += int((frame["verdict"] != "").sum())
    return found


MOST_WARNINGS = 20
TEST = "test"  # in place of a verdict: a Wishart test, which has a p-value alone


def family_of(frames):
    """The rows of tables that are judged as a family: [(verdict or TEST, p_differs, p_agrees)]."""
    frames = list(frames)
    rows, tests = [family_rows(frame) for frame in frames], [test_rows(frame) for frame in frames]
    return [*((v, float(d), float(a)) for r in rows if len(r) for v, d, a in zip(r["verdict"], r["p_differs"], r["p_agrees"])),
            *((TEST, float(p), math.nan) for r in tests if len(r) for p in r["wishart_p"])]


def judged_together(frame, limit):
    """The table with column `family` as the whole report has it. limit: the largest p-value that Holm's procedure rejects among
    all results (surveymc.result.holm_limit)."""
    if "family" not in frame or not {"verdict", "p_differs"} <= set(frame.columns):
        return frame
    together = frame.copy()
    together.attrs = frame.attrs
    together["family"] = [("differs" if p <= limit else MAY_BE_CHANCE) if said and v == "differs" else said
                          for said, v, p in zip(frame["family"], frame["verdict"], frame["p_differs"])]
    return together


def error_rates(family):
    """How many rows of a family agree and differ, how many of the latter do so among all (Holm at 5 %), and what share of
    the former may be wrong (Benjamini and Hochberg)."""
    agreeing = [a for v, _, a in family if v == "agrees" and math.isfinite(a)]
    rejected = holm([d for _, d, _ in family])
    judged = [a for v, _, a in family if v != TEST]
    return {"verdicts": len(judged), "tests": len(family) - len(judged), "agrees": sum(v == "agrees" for v, _, _ in family),
            "differs": sum(v == "differs" for v, _, _ in family),
            "surviving": sum(r and v == "differs" for r, (v, _, _) in zip(rejected, family)),
            "tests_surviving": sum(r and v == TEST for r, (v, _, _) in zip(rejected, family)),
            # A row without p_agrees (a test without a margin) says nothing for "agrees".
            "share": agreement_share([a for a in judged if math.isfinite(a)], max(agreeing, default=0.0))}


# --- one result -----------------------------------------------------------------------------------------------------


@dataclasses.dataclass
class Figure:
    """A figure for the template; address: its data URI."""

    id: str
    number: int
    path: str
    caption: str
    address: str = ""
    width: int = 0
    height: int = 0


@dataclasses.dataclass
class Drawing:
    """A drawing that the reader can change. kind: "ellipse", "map", "wells" or "cylinder" (page.js)."""

    kind: str
    id: str
    heading: str
    note: str
    data: dict


@dataclasses.dataclass
class Part:
    """One result, as the template result.html shows it."""

    id: str
    title: str
    file: str
    study: str
    description: list
    answer: list
    counts: dict
    judged: int
    drawn: str
    own_numbers: str
    warnings: list
    more_warnings: int
    figures: list
    broken: list
    no_figure: str
    drawings: list
    no_space: str
    tables: list
    provenance: list
    run_again: str
    rerun: str
    config: str
    chances: dict
    family: list


def _drawings(result, frames, identity):
    """The drawings of a result, and why it has none in space where it could."""
    found, samples, no_space = [], next((result.samples[s] for s in result.samples), None), ""
    in_space = view3d.wells(result)
    if in_space and view3d.is_installed():
        found.append(Drawing("wells", f"{identity}-wells", "Wells and their error ellipsoids, in space", "", in_space))
    elif in_space:
        no_space = "The wells are not drawn in space: libjs-three is not installed (scripts/bootstrap.sh)."
    around = view3d.cylinder(result)
    if around:
        found.append(Drawing("cylinder", f"{identity}-cylinder", "Travelling cylinder", "", around))
    for name, frame in frames.items():
        if explore.has_ellipses(frame):
            data = explore.ellipses(frame, samples)
            dots = " Dots are the first realisations, about their mean." if data["clouds"] else ""
            found.append(Drawing("ellipse", f"{identity}-{slug(name)}-drawing", "Error ellipses: choose point and propagation",
                                 f"Horizontal ellipses of table {name}.{dots}", data))
    data = explore.maps(result) if len(result.maps) else None
    if data:
        found.append(Drawing("map", f"{identity}-map-drawing", "Maps: choose quantity, axes and point",
                             "Hatched: infinite. White: no value. Lines: equal values.", data))
    return found, no_space


def own_numbers(command):
    """Options of a stored command that replace keys of the config, as a shell takes them: " --seed 5 --set 'a=[1, 2]'".

    Older programs stored the command without quotes: a value goes on to the next option, or to a config that comes last.
    """
    found = [*re.finditer(r" --(seed|trials)[ =](\S+)", command), *re.finditer(r" --(set)[ =](.+?)(?= --?[a-z]|$)", command)]
    has_config = re.search(r"\brun \S+\.toml", command)
    options = []
    for match in sorted(found, key=lambda m: m.start()):
        value = match[2] if has_config or match[1] != "set" else re.sub(r" \S+\.toml$", "", match[2])
        if value[0] == "'":
            value = shlex.split(value)[0]
        options.append(f" --{match[1]} {shell_word(value)}")
    return "".join(options)


def _warnings(result):
    """What to know before the numbers are used: severity, place, what is unusual, what to do; the first MOST_WARNINGS."""
    found = []
    for row in result.warnings[:MOST_WARNINGS]:
        place, value, way_out = row.get("place", ""), row.get("value", ""), row.get("way_out", "")
        place += f" = {value}" if value and " = " not in value else f": {value}" if value else ""
        where = f" At {row['points']} points, the first: {row['at']}." if row.get("points", 1) > 1 else (
            f" At {row['at']}." if row.get("at") else "")
        found.append({"severity": row["severity"], "place": place, "message": row["message"],
                      "way_out": way_out[:1].upper() + way_out[1:], "where": where})
    return found


def _provenance(result, config, name):
    """(name, value, whether it is code)."""
    run = result.run
    took = f", {run['elapsed_s']:.1f} s on {run.get('threads', 1)} threads" if "elapsed_s" in run else ""
    return [("config", config, True), ("result", name, True), ("experiment", result.experiment, True), ("seed", str(result.seed), False),
            ("trials", grouped(result.trials), False), ("version", f"surveymc {result.version} ({result.revision})", False),
            ("compiler", result.compiler, False), ("run", run.get("created", "") + took, False),
            ("content hash", result.content_hash, True)]


def result_part(result, study, drawn, identity, name, first_figure, limit=math.inf):
    """One result as Part.

    name: its path as the reader has it; identity: the id of its part of the page; limit: see judged_together.
    """
    frames = {t: judged_together(result.table(t), limit) for t in result.tables}
    own_trials = "--trials" not in result.command
    for frame in frames.values():
        frame.attrs["own_trials"] = own_trials
    judged = [t for t in frames if "verdict" in frames[t] and len(frames[t])]
    others = [t for t in frames if t not in judged and t not in ("answer", "warnings") and len(frames[t])]
    config = studies.config_of(result.command, result.title)
    margin = float(result.settings.get("verdict", {}).get("margin", 0))
    stem = saving.stem_of(result.path)
    counts = added(tables.counts_of(frames[t]) for t in judged)
    pictures = []
    for i, path in enumerate(drawn.files):
        suffix = os.path.splitext(os.path.basename(path))[0][len(stem):].lstrip("_")
        pictures.append(Figure(f"{identity}-figure-{i + 1}", first_figure + i, path, study.caption(suffix)))
    drawings, no_space = _drawings(result, frames, identity)
    shown = lambda t: tables.table(frames[t], margin, f"build/surveymc show {shell_word(name)} {shell_word(t)} --csv", t in study.fold)  # noqa: E731
    warnings, options = _warnings(result), own_numbers(result.command)
    return Part(
        id=identity, title=result.title or stem, file=os.path.basename(name), study=study.name, description=studies.description(config) if config else [],
        answer=result.answer, counts=counts, judged=total(counts),
        drawn=f"{grouped(result.trials)} Monte-Carlo trials at each point" if result.trials else "no Monte Carlo",
        own_numbers=options.strip(), warnings=warnings, more_warnings=len(result.warnings) - len(warnings), figures=pictures,
        broken=drawn.broken,
        no_figure=drawn.messages[0] if drawn.messages and not (drawn.files or drawn.broken or len(result.maps)) else "",
        drawings=drawings, no_space=no_space,
        tables=[("judged", "Comparison", [shown(t) for t in judged]), ("others", "Other tables", [shown(t) for t in others])],
        provenance=_provenance(result, config, name), run_again=f"build/surveymc run {shell_word(config or 'CONFIG')}{options}",
        rerun=f"build/surveymc rerun {shell_word(name)}", config=result.config,
        chances=chances_of(frames[t] for t in judged) if result.trials else {}, family=family_of(frames.values()))


# --- all of them ----------------------------------------------------------------------------------------------------


def chance(chances):
    """How the counts are to be read: how many rows may differ by chance. chances: {confidence: rows judged at it}."""
    rows = sum(chances.values())
    if not rows:
        return ""
    most = sum(n * (1 - c) / 2 for c, n in chances.items())
    levels = " and ".join(f"{100 * c:.7g} %" for c in sorted(chances))
    text = (f"{grouped(rows)} rows are judged by Monte-Carlo intervals at {levels}, each on its own. A prediction that is right, just within "
            f"its margin, is said to differ with a chance of at most (1 − level) / 2: ")
    if most < 0.5:
        return text + f"over all rows that is a chance below {number(max(most, 1e-12), 2)} that even one differs by chance."
    return text + (f"of {grouped(rows)} rows at most {grouped(round(most))} may differ by chance, mostly far fewer, as most right predictions are "
                   "well within their margins. Those that do not differ among all rows together are marked △ and counted apart.")


def _share(share):
    return f"{100 * share:.2g} %" if share >= 1e-4 or share == 0 else "below 0.01 %"


def families(named):
    """The report's own error rates: a row for each study, and one for all results together. named: [(name, family)]."""
    everything = [row for _, family in named for row in family]
    rates = [(name, error_rates(family)) for name, family in (*named, ("all together", everything)) if family]
    return [{"name": name, **r, "share": _share(r["share"])} for name, r in rates] if everything else []
