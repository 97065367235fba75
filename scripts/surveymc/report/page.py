"""The report as one HTML file: what stands where. Colours and type are in report.css, behaviour in the .js files."""

import collections
import json
import math
import os
import re
import shlex

from .. import studies
from ..plots import saving
from ..result import MAY_BE_CHANCE, agreement_share, family_rows, holm, test_rows
from . import explore, figures, tables
from .text import VERDICT_MARKS, counts_bar, counts_marks, counts_sentence, escape, grouped, number, prose, shell_word, slug

HERE = os.path.dirname(os.path.abspath(__file__))
POLICY = ("default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'; "
          "base-uri 'none'; form-action 'none'")


def _read(name):
    with open(os.path.join(HERE, name), encoding="utf-8") as file:
        return file.read()


def total(counts):
    """How many rows have a verdict."""
    return sum(counts[k] for k in VERDICT_MARKS)


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


def expectation(counts):
    """What a reader should know of the rows whose verdict is not the one that a config expects."""
    rows, undecided, waiting = counts["unexpected"], counts["unexpected_undecided"], counts["waiting"]
    if not rows:
        return "No verdict is other than the configs expect." + (
            f" {grouped(waiting)} that they expect {'is' if waiting == 1 else 'are'} not decided by these trials, which are not the "
            "configs'." if waiting else "")
    are = "is" if rows == 1 else "are"
    why = "" if not undecided else ": undecided with so many trials" if undecided == rows else \
        f"; {grouped(undecided)} of them {'is' if undecided == 1 else 'are'} undecided with so many trials"
    return f"<strong>{grouped(rows)} {are} not as the config expects</strong> (marked in the tables){why}."


# --- one result -----------------------------------------------------------------------------------------------------


def _summary(result, counts):
    """One sentence: what was compared with what, and how it came out."""
    judged = total(counts)
    drawn = f"{grouped(result.trials)} Monte-Carlo trials at each point" if result.trials else "no Monte Carlo"
    if not judged:
        return f"<p class=\"summary\">Nothing in this result is held against a prediction or a published value ({drawn}).</p>"
    return (f'<p class="summary">Of {grouped(judged)} predictions and published values held against the results ({drawn}), '
            f"{counts_sentence(counts)}. {expectation(counts)}</p>{counts_bar(counts)}")


def _figure(path, study, stem, number, identity):
    address, width, height = figures.embedded(path)
    suffix = os.path.splitext(os.path.basename(path))[0][len(stem):].lstrip("_")
    caption = study.caption(suffix)
    return (f'<figure id="{identity}" class="plot"><button type="button" class="figure" '
            f'aria-label="Enlarge figure {number}"><img src="{address}" width="{width}" height="{height}" '
            f'loading="lazy" decoding="async" alt="{escape(caption)}"></button>'
            f"<figcaption><b>Figure {number}.</b> {prose(caption)}</figcaption></figure>")


def _explorer(kind, data, identity, heading, caption):
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=False, allow_nan=False).replace("<", "\\u003c")
    return (f'<section class="explore" aria-labelledby="{identity}-t"><h4 id="{identity}-t">{heading}</h4>'
            f'<div class="drawing" id="{identity}" data-kind="{kind}" data-source="{identity}-data">'
            f'<noscript><p class="small">This drawing needs JavaScript.</p></noscript></div>'
            f'<p class="small">{caption}</p><script type="application/json" id="{identity}-data">{text}</script></section>')


def _explorers(result, frames, identity):
    parts = []
    samples = next((result.samples[s] for s in result.samples), None)
    for name, frame in frames.items():
        if explore.has_ellipses(frame):
            data = explore.ellipses(frame, samples)
            dots = " Dots are the first realisations, about their mean." if data["clouds"] else ""
            parts.append(_explorer("ellipse", data, f"{identity}-{slug(name)}-drawing",
                                   "Error ellipses: choose point and propagation",
                                   f"Horizontal ellipses of table <code>{escape(name)}</code>.{dots}"))
    data = explore.maps(result) if len(result.maps) else None
    if data:
        parts.append(_explorer("map", data, f"{identity}-map-drawing", "Maps: choose quantity, axes and point",
                               "Hatched: infinite. White: no value."))
    return parts


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
    """What to know before the numbers are used, as a box: severity, place, what is unusual, and what to do."""
    rows = result.warnings
    if not rows:
        return ""
    items = []
    for row in rows[:MOST_WARNINGS]:
        value, way_out = row.get("value", ""), row.get("way_out", "")
        place = escape(row.get("place", "")) + (f" = {escape(value)}" if value and " = " not in value else f": {escape(value)}" if value else "")
        points = f" At {row['points']} points, the first: {escape(row['at'])}." if row.get("points", 1) > 1 else (
            f" At {escape(row['at'])}." if row.get("at") else "")
        items.append(f'<li><strong>{escape(row["severity"])}</strong> {f"<code>{place}</code>: " if place else ""}'
                     f'{prose(row["message"])}.{f" <em>{prose(way_out[0].upper() + way_out[1:])}</em>" if way_out else ""}{points}</li>')
    more = f"<p>{len(rows) - MOST_WARNINGS} more in table <code>warnings</code>.</p>" if len(rows) > MOST_WARNINGS else ""
    return (f'<aside class="warnings" aria-label="Warnings"><h4>Before you use these numbers</h4><ul>{"".join(items)}</ul>{more}</aside>')


def _provenance(result, config, name):
    run = result.run
    took = f", {run['elapsed_s']:.1f} s on {run.get('threads', 1)} threads" if "elapsed_s" in run else ""
    repeat = f"build/surveymc run {shell_word(config or 'CONFIG')}{own_numbers(result.command)}"
    rows = [("config", f"<code>{escape(config)}</code>" if config else ""), ("result", f"<code>{escape(name)}</code>"),
            ("experiment", f"<code>{escape(result.experiment)}</code>"), ("seed", str(result.seed)),
            ("trials", grouped(result.trials)),
            ("version", f"surveymc {escape(result.version)} ({escape(result.revision)})"),
            ("compiler", escape(result.compiler)), ("run", escape(run.get("created", "")) + took),
            ("content hash", f"<code>{escape(result.content_hash)}</code>")]
    listed = "".join(f"<dt>{k}</dt><dd>{v}</dd>" for k, v in rows if v)
    return ('<details class="about"><summary>Config, seed, version, and how to run it again</summary>'
            f"<dl>{listed}</dl><p>Run it again, from the config or from what is stored in the result:</p>"
            f"<pre>{escape(repeat)}\nbuild/surveymc rerun {escape(shell_word(name))}</pre>"
            f"<p>Config as it was resolved:</p><pre>{escape(result.config)}</pre></details>")


def result_part(result, study, drawn, identity, name, first_figure, limit=math.inf):
    """One result as HTML, its verdict counts, rows by the level of their intervals, its family (family_of), and how many
    figures it has.

    name: its path as the reader has it; identity: the id of its part of the page; limit: see judged_together.
    """
    frames = {t: judged_together(result.table(t), limit) for t in result.tables}
    own_trials = "--trials" not in result.command
    for frame in frames.values():
        frame.attrs["own_trials"] = own_trials
    judged = [t for t in frames if "verdict" in frames[t] and len(frames[t])]
    counts = added(tables.counts_of(frames[t]) for t in judged)
    config = studies.config_of(result.command, result.title)
    margin = float(result.settings.get("verdict", {}).get("margin", 0))
    stem = saving.stem_of(result.path)
    parts = [f'<article class="result" id="{identity}"><h3><a href="#{identity}">{escape(result.title or stem)}</a></h3>']
    if config:
        for text in studies.description(config):
            parts.append(f"<pre>{escape(text)}</pre>" if text.startswith("  ") else f"<p>{prose(text)}</p>")
    if result.answer:
        parts.append('<div class="answer">' + "".join(f"<p>{escape(sentence)}</p>" for sentence in result.answer) + "</div>")
    parts.append(_summary(result, counts))
    if own_numbers(result.command):
        parts.append(f'<p class="small">Run with other numbers than the config has: <code>{escape(own_numbers(result.command).strip())}'
                     '</code></p>')
    parts.append(_warnings(result))
    if drawn.files:
        parts.append('<div class="figures">')
        parts += [_figure(path, study, stem, first_figure + i, f"{identity}-figure-{i + 1}") for i, path in enumerate(drawn.files)]
        parts.append("</div>")
    if drawn.broken:
        parts.append('<p class="broken">No figure: ' + "; ".join(escape(b) for b in drawn.broken) + "</p>")
    elif not drawn.files and drawn.messages and not len(result.maps):
        parts.append(f'<p class="small">No figure: {escape(drawn.messages[0])}</p>')
    parts += _explorers(result, frames, identity)
    others = [t for t in frames if t not in judged and t not in ("answer", "warnings") and len(frames[t])]
    for group, heading, kind in ((judged, "Comparison", "judged"), (others, "Other tables", "others")):
        if group:
            parts.append(f'<div class="{kind}"><h4>{heading}</h4>')
            parts += [tables.table(frames[t], margin, f"build/surveymc show {shell_word(name)} {shell_word(t)} --csv", t in study.fold) for t in group]
            parts.append("</div>")
    parts.append(_provenance(result, config, name))
    parts.append("</article>")
    chances = chances_of(frames[t] for t in judged) if result.trials else {}
    return "\n".join(parts), counts, chances, family_of(frames.values()), len(drawn.files)


# --- the whole page -------------------------------------------------------------------------------------------------


def _overview(groups):
    """The table at the head of the page: a row for each result."""
    rows = []
    for study, entries in groups:
        rows.append(f'<tr class="group"><th colspan="2" scope="rowgroup">{escape(study.name)}</th></tr>')
        for entry in entries:
            marks = counts_marks(entry["counts"]) or '<span class="small">not judged</span>'
            alarm = f' <strong>{entry["counts"]["unexpected"]} not as expected</strong>' if entry["counts"]["unexpected"] else ""
            rows.append(f'<tr><th scope="row"><a href="#{entry["id"]}">{escape(entry["title"])}</a></th>'
                        f'<td>{counts_bar(entry["counts"])}<span class="marks">{marks}{alarm}</span></td></tr>')
    return ('<div class="scroll" tabindex="0" role="region" aria-label="All results"><table class="overview"><thead><tr>'
            f'<th scope="col">result</th><th scope="col">verdicts</th></tr></thead><tbody>{"".join(rows)}</tbody></table></div>')


def _contents(groups):
    items = []
    for study, entries in groups:
        inner = "".join(f'<li><a href="#{e["id"]}">{escape(e["title"])}</a></li>' for e in entries)
        items.append(f'<li><a href="#study-{slug(study.experiment)}">{escape(study.name)}</a><ul>{inner}</ul></li>')
    return ('<nav aria-label="Contents"><details id="contents" open><summary>Contents</summary>'
            f'<ul><li><a href="#overview">Overview</a></li>{"".join(items)}</ul></details></nav>')


def _style():
    css, dark = _read("report.css").split("/* dark */")
    return (css + "@media (prefers-color-scheme: dark) { :root:not([data-theme=light]) {" + dark + "} }\n"
            + ":root[data-theme=dark] {" + dark + "}\n" + _read("print.css"))


def _headlines(findings):
    """The first screen: what was found, in sentences, and the figure of the first finding."""
    if not findings:
        return ""
    items = "".join(f'<li><a href="#{f.result}">{escape(f.sentence)}</a></li>' for f in findings)
    figure = ""
    if findings[0].figure:
        address, width, height = figures.embedded(findings[0].figure)
        figure = (f'<figure class="plot"><button type="button" class="figure" aria-label="Enlarge the figure of the first finding">'
                  f'<img src="{address}" width="{width}" height="{height}" decoding="async" '
                  f'alt="Figure of the first finding"></button></figure>')
    return f'<div class="headlines"><ol>{items}</ol>{figure}</div>'


def _chance(chances):
    """How the counts are to be read: how many rows may differ by chance. chances: {confidence: rows judged at it}."""
    rows = sum(chances.values())
    if not rows:
        return ""
    most = sum(n * (1 - c) / 2 for c, n in chances.items())
    levels = " and ".join(f"{100 * c:.7g}&nbsp;%" for c in sorted(chances))
    text = (f"{grouped(rows)} rows are judged by Monte-Carlo intervals at {levels}, each on its own. A prediction that is right, just within "
            f"its margin, is said to differ with a chance of at most (1&nbsp;−&nbsp;level)&nbsp;/&nbsp;2: ")
    if most < 0.5:
        return text + f"over all rows that is a chance below {number(max(most, 1e-12), 2)} that even one differs by chance."
    return text + (f"of {grouped(rows)} rows at most {grouped(round(most))} may differ by chance, mostly far fewer, as most right predictions are "
                   "well within their margins. Those that do not differ among all rows together are marked △ and counted apart.")


def _share(share):
    return f"{100 * share:.2g}&nbsp;%" if share >= 1e-4 or share == 0 else "below 0.01&nbsp;%"


def _families(groups):
    """The table of the report's own error rates: a row for each study, and one for all results together."""
    named = [(study.name, [row for e in entries for row in e["family"]]) for study, entries in groups]
    everything = [row for _, family in named for row in family]
    if not everything:
        return ""
    rows = []
    for name, family in (*named, ("all together", everything)):
        if not family:
            continue
        r = error_rates(family)
        rows.append(f'<tr><th scope="row">{escape(name)}</th>' + "".join(f'<td class="n">{grouped(r[k])}</td>' for k in (
            "verdicts", "agrees", "differs", "surviving")) + f'<td class="n">{_share(r["share"])}</td>'
                    + "".join(f'<td class="n">{grouped(r[k])}</td>' for k in ("tests", "tests_surviving")) + "</tr>")
    return ('<details class="about" id="family"><summary>How many of these verdicts may be wrong</summary>'
            "<p>Rows that are not expected to differ, judged together. Of those that differ, the ones that still do so among all "
            "rows of their line (Holm): the chance that even one of them is false is at most 5&nbsp;%. Of those that agree, the "
            "share that may be wrong (Benjamini and Hochberg). The marks of this page are those of the last line: a row that differs "
            "by itself but not among all results may be chance. Tests of whole covariances (Wishart) have no margin and no verdict; "
            "they join with their own p-value.</p>"
            '<div class="scroll" tabindex="0" role="region" aria-label="Error rates"><table><thead><tr><th scope="col">study</th>'
            '<th scope="col" class="n">rows</th><th scope="col" class="n">agree</th><th scope="col" class="n">differ</th>'
            '<th scope="col" class="n">differ among all</th><th scope="col" class="n">wrong agreements</th>'
            '<th scope="col" class="n">covariance tests</th><th scope="col" class="n">of them differ among all</th></tr></thead>'
            f'<tbody>{"".join(rows)}</tbody></table></div></details>')


def page(groups, versions, note="", findings=()):
    """The report. groups: [(study, [{id, title, counts, chances, html}])] in their order; versions: of the programs that
    ran; findings: headlines.Headline of the first screen."""
    counts = added(e["counts"] for _, entries in groups for e in entries)
    chances = collections.Counter()
    for _, entries in groups:
        for entry in entries:
            chances.update(entry["chances"])
    results = sum(len(entries) for _, entries in groups)
    judged = total(counts)
    lead = (f"{results} result{'s' if results != 1 else ''} of {len(groups)} "
            f"stud{'ies' if len(groups) != 1 else 'y'}. ")
    if judged:
        lead += (f"Of {grouped(judged)} predictions and published values, {counts_sentence(counts)}. {expectation(counts)} "
                 "Where a prediction differs, that is a finding about the prediction.")
    body = []
    for study, entries in groups:
        source = f'<p class="source">After {escape(study.source)}</p>' if study.source else ""
        about = "".join(f"<p>{prose(t)}</p>" for t in (study.question, study.read) if t)
        body.append(f'<section class="study" id="study-{slug(study.experiment)}"><h2>{escape(study.name)}</h2>{source}{about}'
                    + "\n".join(e["html"] for e in entries) + "</section>")
    scripts = "\n".join(_read(f) for f in ("drawing.js", "ellipses.js", "maps.js", "tables.js", "page.js"))
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="{POLICY}">
<meta name="color-scheme" content="light dark">
<title>surveymc: results</title>
<link rel="icon" href="data:,">
<style>{_style()}</style>
</head>
<body>
<a class="skip" href="#main">Skip to the results</a>
<header><div><h1>Results of surveymc</h1><p>Monte Carlo, analytic prediction and published values for wellbore directional
surveying</p></div><button type="button" id="theme" hidden></button></header>
<div class="page">
{_contents(groups)}
<main id="main" tabindex="-1">
<section id="overview"><h2>Overview</h2>
{f'<p class="banner">{escape(note)}</p>' if note else ""}
{_headlines(findings)}
<p class="lead">{lead}</p>{counts_bar(counts)}
{f'<p class="small" id="chance">{_chance(chances)}</p>' if chances else ""}
{_overview(groups)}
{_families(groups)}
<details class="about" id="reading"><summary>How to read the tables</summary>
<p>A ratio is analytic (or published) over Monte Carlo: below 1 a prediction promises too much. Brackets are 95&nbsp;%
intervals. The small scale beside a ratio goes from ½ to 2; its band is what counts as agreement.</p>
<dl class="verdicts">
<dt><span class="verdict agrees"><i aria-hidden="true">●</i> agrees</span></dt><dd>the whole interval is within the margin</dd>
<dt><span class="verdict differs"><i aria-hidden="true">◆</i> differs</span></dt><dd>the whole interval is outside of it: this prediction is wrong here</dd>
<dt><span class="verdict finding"><i aria-hidden="true">◇</i> finding</span></dt><dd>the same, of an approximation, a statement of others, or what the config says is wrong: this shows where it fails</dd>
<dt><span class="verdict undecided"><i aria-hidden="true">▲</i> undecided</span></dt><dd>more trials would tell</dd>
<dt><span class="verdict undecided"><i aria-hidden="true">△</i> differs, may be chance</span></dt><dd>it differs by itself, but among so many rows one may by chance</dd>
</dl><p>“Not as expected” marks rows whose verdict is another than the one that the config asks for.</p></details>
</section>
{"".join(body)}
<footer><p>Made by <code>surveymc.report</code> from result files of surveymc {escape(", ".join(versions))}.</p></footer>
</main></div>
<dialog id="large" aria-label="Enlarged figure"><button type="button" aria-label="Close the enlarged figure"></button></dialog>
<script>
{scripts}
</script>
</body>
</html>
"""
