"""What a table says beside its numbers, and must not be passed over: other wells, stations that do not count, minutes of angle.

A doubt is (is refused, text). Refused ones are questions: surveymc takes the file with `unusual = "allow"`, and then warns.
"""

import re

from . import columns
from .problem import USAGE, Problem, shown

WELLS = set("well wellname wellid wellbore wellborename wellboreid borehole boreholename boreholeid bore borename hole holeid holename holeno bhid "
            "uwi api apino apinumber sidetrack st lateral branch track trajectory name wellno wellnumber uniquewellid leg legname".split())
QUALITY = re.compile(r"\b(qc|qa|qual|qaqc|quality|status|flag|valid|validity|validated|accepted|acceptance|accept|use|used|usable|ok|good|check|result|pass|"
                     r"passed|grade|include|included|active)\b", re.I)
BAD = re.compile(r"\b(fail(ed|ure|s)?|bad|reject(ed)?|invalid|not[ _-]?(ok|valid|used?|accepted|good)|nok|no[ _-]?good|poor|suspect(ed)?|unreliable|"
                 r"do[ _-]?not[ _-]?use|dnu|out[ _-]?of[ _-]?(spec|tolerance|range)|unusable|discard(ed)?|excluded?|disqualified|erroneous|misread|misrun|"
                 r"deleted?|wrong|void)\b", re.I)
NO = {"n", "no", "false", "f", "0", "x"}  # under a heading of quality
PROJECTED = re.compile(r"\b(proj(ect(ed|ion))?\.?|extrap(olat(ed|ion))?\.?|interp(olat(ed|ion))?\.?|estimated?|planned|bit[ _]proj\w*)(?![a-z])", re.I)
NO_COMMENT = re.compile(r"\b(project|client|company|field)\b", re.I)  # headings whose cells are names
MINUTES = {"min", "mins", "minute", "minutes", "mm", "sec", "secs", "second", "seconds", "arcmin", "arcsec", "m", "s", "'", '"', "′", "″"}


def words_of(heading):
    return [w for w in re.split(r"[^\w'\"′″]+|_", re.sub(r"([a-z])([A-Z][a-z])", r"\1 \2", heading).casefold()) if w]


def others(table, chosen):
    taken = {c.index for c in chosen.values()}
    width = max([len(table.headings), *(len(r.cells) for r in table.rows[:1000])], default=0)
    return [(i, table.headings[i] if i < len(table.headings) else "") for i in range(width) if i not in taken]


def cells_of(rows, index):
    return [columns.tidy(r.cells[index]) if index < len(r.cells) else "" for r in rows]


def called(index, heading):
    return f"column {index + 1} '{shown(heading, 30)}'" if heading else f"column {index + 1}, without a heading,"


def line_of(row):
    return row.place.rsplit(" ", 1)[-1]


def last_line(table):
    return next((line_of(r) for r in reversed(table.rows) if any(r.cells)), "")


def ranges(numbers):
    """[5, 6, 7, 9] -> "5-7,9", at most as many as a line holds."""
    out = []
    for n in sorted(numbers):
        if out and n == out[-1][1] + 1:
            out[-1][1] = n
        else:
            out.append([n, n])
    return ",".join(f"{a}-{b}" if b > a else f"{a}" for a, b in out[:20]) + (",..." if len(out) > 20 else "")


def lines_to_skip(rows):
    numbers = [line_of(r) for r in rows]
    return ranges(map(int, numbers)) if all(n.isdecimal() for n in numbers) else ",".join(numbers[:20])


def of_one_well(rows, table, chosen, options, file):
    """The rows of the one well that is meant: where a column of wells names several, an option says which."""
    for index, heading in others(table, chosen):
        if "".join(words_of(heading)) not in WELLS:
            continue
        cells = [shown(c, 40) for c in cells_of(rows, index)]
        names = list(dict.fromkeys(c for c in cells if c))
        if "hole" in words_of(heading) and all(columns.looks_numeric(c) for c in names):
            continue  # sizes of the hole
        if options.trajectory and names:
            if options.trajectory not in names:
                raise Problem(f"--trajectory: '{shown(options.trajectory)}': must be one of {quoted(names)}, {called(index, heading)} of {file}", USAGE)
            return [r for r, c in zip(rows, cells) if c == options.trajectory]
        if len(names) < 2 or (len(names) > len(rows) // 2 and len(rows) > 3 and cells.count("") == 0 and "name" in words_of(heading)):
            continue
        raise Problem(f"{file}:{table.header_place}: {called(index, heading)} names {len(names)} wells: {quoted(names)}: one must be meant: "
                      "--trajectory NAME, as it is written there")
    if options.trajectory and not table.form.startswith("WITSML"):
        raise Problem(f"--trajectory: is for WITSML, and for tables with a column of wells: {file} is {table.form}", USAGE)
    return rows


def quoted(names, most=12):
    return ", ".join(f"'{shown(n, 40)}'" for n in names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")


def minutes_and_letters(rows, table, chosen, options, file):
    """Columns beside an angle that are a part of it."""
    by_index = dict(others(table, chosen))
    for role in ("inc", "azi"):
        c = chosen[role]
        for i in (c.index - 1, c.index + 1):
            if i not in by_index:
                continue
            cells, heading = [t for t in cells_of(rows, i) if t], by_index[i]
            if role == "azi" and cells and all(re.fullmatch(r"(N|S|E|W|NE|SE|SW|NW)\.?", t, re.I) for t in cells):
                yield True, (f"{file}:{rows[0].place}: {called(i, heading)} beside the {columns.NAMES[role]} holds letters of the compass ({shown(cells[0])}): "
                             "azimuths must be clockwise from north, 0 to 360 deg; write the angle in one column, as S 40.5 W or 220.5")
            if i < c.index or not cells or not all(columns.looks_numeric(t) for t in cells):
                continue
            numbers = [float(t.replace(",", ".")) if re.fullmatch(r"[\d.,]+", t) and t.count(".") + t.count(",") < 2 else -1.0 for t in cells]
            words = [w for w in words_of(heading) if w not in columns.STRONG[role] and w != "of"]
            is_minutes = words and set(words) <= MINUTES | {"angle", "arc"} if heading else not options.columns
            if is_minutes and all(0 <= v < 60 for v in numbers) and any(numbers):
                yield True, (f"{file}:{rows[0].place}: {called(i, heading)} right of the {columns.NAMES[role]} '{shown(c.heading, 30)}' holds numbers below 60 "
                             f"({shown(cells[-1])}): are they minutes of angle? Angles must be degrees with decimals, in one column")


def quality(rows, table, chosen, file):
    """Stations that another column of the table says do not count, or are no measurement."""
    for i, heading in others(table, chosen):
        cells = cells_of(rows, i)
        judged = QUALITY.search(re.sub(r"[_\W]+", " ", heading))
        if "".join(words_of(heading)) in WELLS or NO_COMMENT.search(heading):
            continue
        bad = [(r, t) for r, t in zip(rows, cells) if BAD.search(t.replace("_", " ")) or (judged and t.casefold() in NO)]
        if judged and 2 * len(bad) >= len(rows) and not any(BAD.search(t.replace("_", " ")) for _, t in bad):
            bad = []  # a code whose usual value it is
        if bad:
            more = f" (and {len(bad) - 1} more)" if len(bad) > 1 else ""
            text = (f"{file}:{bad[0][0].place}: {called(i, heading)} = '{shown(bad[0][1], 40)}'{more}: does this station count? It is "
                    f"{'asked for' if judged else 'used as any other'}: leave it out: --skip-lines {lines_to_skip([r for r, _ in bad])}")
            yield bool(judged), text
            continue
        projected = [(r, t) for r, t in zip(rows, cells) if PROJECTED.search(t.replace("_", " "))]
        if projected:
            more = f" (and {len(projected) - 1} more)" if len(projected) > 1 else ""
            yield False, (f"{file}:{projected[0][0].place}: {called(i, heading)} = '{shown(projected[0][1], 40)}'{more}: is no measurement, and used as one; "
                          f"leave it out: --skip-lines {lines_to_skip([r for r, _ in projected])}")
            continue
        kinds = list(dict.fromkeys(cells))
        if judged and 2 <= len(kinds) <= 6 and len(kinds) < len(rows):
            counts = ", ".join(f"'{shown(k, 20)}' {cells.count(k)}" for k in kinds)
            yield False, f"{file}:{table.header_place}: {called(i, heading)} holds {counts} times: all these stations are used"


def wells_without_a_name(rows, table, chosen, file):
    """A text column without a heading that changes once along the table may name two wells."""
    for i, heading in others(table, chosen):
        cells = cells_of(rows, i)
        blocks = [c for k, c in enumerate(cells) if k == 0 or c != cells[k - 1]]
        if heading or not all(cells) or any(columns.looks_numeric(c) for c in cells) or not 2 <= len(blocks) <= 3:
            continue
        if len(set(blocks)) == len(blocks) and all(cells.count(b) > 1 for b in blocks):
            yield False, f"{file}:{rows[0].place}: {called(i, heading)} holds {quoted(blocks)}, one after the other: are these several wells?"


def wells_in_notes(rows, table, file):
    """A line between stations that names another well than the title, as "Well: A-2"."""
    kept = {id(r) for r in rows}
    where = [k for k, r in enumerate(table.rows) if id(r) in kept]
    seen = {" ".join(re.findall(r"\w+", line)).casefold() for line in table.titles}
    for row in table.rows[where[0]:where[-1]]:
        if id(row) in kept or row.repeats or sum(map(columns.looks_numeric, row.cells)) >= 2:
            continue
        text = " ".join(c for c in row.cells if c)
        plain = " ".join(re.findall(r"\w+", text)).casefold()
        if not plain or any(plain in s or s in plain for s in seen if s):
            continue
        seen.add(plain)
        said = f"{file}:{row.place}: '{shown(text, 50)}' stands between stations"
        if re.match(r"\W*(well|well ?bore|bore ?hole|bore|hole|lateral|trajectory|side ?track)\s*(name|id|no|number)?\s*[:=#]\s*\S", text, re.I):
            yield True, f"{said}: does another well begin? Must be one well; leave the others out: --skip-lines {line_of(row)}-{last_line(table)}"
        elif re.search(r"\b(side ?-?track|lateral|wellbore|borehole)\b", text, re.I):
            yield False, f"{said}: does another well begin? All stations are taken as one well"


def horizontal_at_the_top(rows, found, file):
    first = found.values[0]
    if first[0] <= 1 and 60 <= first[1] <= 120:
        yield False, (f"{file}:{rows[0].place}: inclination {found.texts[0][1]} deg at depth {found.texts[0][0]}: the hole begins far from the vertical: "
                      "do inclinations count from the horizontal?")


def from_horizontal(table, chosen, file):
    """A dip or an inclination from the horizontal is no inclination."""
    c = chosen["inc"]
    words = words_of(columns.split_heading(c.heading)[0])
    said = c.heading if set(words) & {"dip", "plunge", "elevation", "dips"} else None
    text = table.described.get(c.index, "")
    said = said or next((t for t in (c.heading, text) if is_from_horizontal(t)), None)
    if said or re.match(r"\W*(dip|plunge|elevation)\b", text, re.I):
        yield True, (f"{file}:{table.header_place}: column '{shown(c.heading, 30)}', '{shown(said or text, 60)}': counts from the horizontal: inclinations must "
                     "count from the vertical: 90 deg minus these (plus, if down is negative); convert them")


def is_from_horizontal(text):
    return bool(re.search(r"\b(from|to|with|wrt|w\.r\.t\.?|above|below|off|against|of)\s+(the\s+)?horiz(on(tal)?)?\b|"
                          r"\bhoriz(ontal)?\s*(is|=|:|at)\s*(0|zero)\b|\b(0|zero)\s*(deg\w*|°)?\s*(is|=|:|at|->)?\s*(the\s+)?horiz(ontal)?\b|"
                          r"\bvert(ical)?\s*(is|=|:|at)\s*[+-]?90\b|\b[+-]?90\s*(deg\w*|°)?\s*(is|=|:|at)?\s*(the\s+)?vertical\b", text, re.I))


def all_of(found, table, chosen, options, file):
    rows = found.rows
    if options.readings or not rows:
        return []
    return [*from_horizontal(table, chosen, file), *minutes_and_letters(rows, table, chosen, options, file), *quality(rows, table, chosen, file),
            *wells_without_a_name(rows, table, chosen, file), *wells_in_notes(rows, table, file), *horizontal_at_the_top(rows, found, file)]
