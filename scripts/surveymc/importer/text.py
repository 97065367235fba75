"""Text: separated by commas, semicolons, tabs, bars or spaces, and reports of fixed columns.

The header is searched: up to four lines above the first row of data whose headings, joined column by column, name all that
is needed. Lines before it are titles. Behind it, a line of which no taken cell is a number is a note (a page break, a header
again); a row of data that cannot be read is never left out without being asked to.
"""

import codecs
import csv
import re
from collections import Counter

from . import columns, doubts
from .problem import Problem, shown
from .table import Row, Table

MOST_LINES, LONGEST_LINE = 500_000, 20_000  # what no survey comes near, and what is still read in seconds
SEPARATORS = {"\t": "tab", ";": "semicolon", "|": "bar", ",": "comma"}
_MARKS = [(codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF32_LE, "utf-32"), (codecs.BOM_UTF32_BE, "utf-32"),
          (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16")]


def decode(data, file, encoding=None):
    """(text, name of the encoding): by its mark, UTF-8, UTF-16 by its zero bytes, else Latin-1 (Windows-1252)."""
    tried = encoding or next((name for mark, name in _MARKS if data.startswith(mark)), None)
    if tried is None:
        even, odd = data[0:4096:2].count(0), data[1:4096:2].count(0)
        most = len(data[:4096]) // 4
        tried = "utf-16-le" if odd > most and even == 0 else "utf-16-be" if even > most and odd == 0 else "utf-8"
    try:
        text = data.decode(tried)
    except LookupError:
        raise Problem(f"--encoding: {shown(encoding)}: unknown; must be one that Python knows, such as utf-8, utf-16 or latin-1", 64)
    except UnicodeDecodeError as fault:
        if encoding or tried != "utf-8":
            raise Problem(f"{file}: byte {fault.start + 1}: is no {tried}: the text must be of one encoding; name it: --encoding")
        tried = "windows-1252"
        text = data.decode("cp1252", errors="replace") if b"\x81" not in data else data.decode("latin-1")
    text = text.rstrip("\x1a\x00").lstrip("\ufeff")
    bad = re.search(r"[\x00-\x08\x0e-\x1f\x7f]", text)
    if bad:
        line = text.count("\n", 0, bad.start()) + 1
        raise Problem(f"{file}:line {line}: byte 0x{ord(bad[0]):02x}: must be text (or .xlsx); is it a binary file? "
                      "Save it as CSV, or name its encoding: --encoding")
    return text, {"utf-8-sig": "UTF-8", "utf-8": "UTF-8", "utf-16": "UTF-16"}.get(tried, tried)


def lines_of(text):
    return re.split(r"\r\n|\n|\r|\f", text)


def check_size(lines, file):
    if len(lines) > MOST_LINES:
        raise Problem(f"{file}: {len(lines)} lines: must be at most {MOST_LINES}: a survey is far shorter; cut it")
    for n, line in enumerate(lines, 1):
        if len(line) > LONGEST_LINE:
            raise Problem(f"{file}:line {n}: {len(line)} characters: must be at most {LONGEST_LINE}; is it a table of text?")


def split(line, separator):
    """Cells of one line; quotes as CSV has them."""
    try:
        return [c.strip() for c in next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])]
    except csv.Error:
        return [c.strip() for c in line.split(separator)]


def is_ruler(line):
    return bool(line.strip()) and not re.search(r"[\w%°º'\"]", line.replace("_", ""))


def is_comment(line):
    return re.match(r"\s*[#%]", line)


def same_words(line):
    return re.sub(r"[\W_]+", " ", line).casefold().strip()


def joined_headings(parts, count):
    """Headings of several lines, joined column by column, those of a line with fewer cells from the left."""
    return [" ".join(p[i] for p in parts if i < len(p) and p[i]).strip() for i in range(count)]


def only_units(parts):
    """True of the lines of a header that have units alone: their names may stand above an empty line."""
    return all(columns.is_unit(c.strip("()[]{}")) for cells in parts for c in cells if c)


def delimited(lines, separator, options):
    """A Table of one separator, or None if no header is found with it."""
    cells = [split(line, separator) if separator in line else [line.strip()] for line in lines]
    numeric = [sum(columns.looks_numeric(c) for c in row) for row in cells]
    numbered = [int(c) - 1 for c in options.columns.values() if re.fullmatch(r"\d{1,5}", c)]
    for first in range(len(cells)):
        if numeric[first] < 3 or first + 1 in options.skip_lines:
            continue
        if len(numbered) >= 3 and not all(k < len(cells[first]) and columns.looks_numeric(cells[first][k]) for k in numbered) and \
                any(all(0 <= k < len(row) and columns.looks_numeric(row[k]) for k in numbered) for row in cells[first + 1:first + 1000]):
            continue  # a record of another kind: the columns that are named hold no numbers here
        parts, used, i = [], [], first - 1
        while i >= 0 and len(parts) < 4 and first - i <= 8:
            filled = [c for c in cells[i] if c]
            if not filled and parts and not only_units(parts):
                break  # what stands above an empty line is a title
            if not filled or is_ruler(lines[i]) or i + 1 in options.skip_lines or (len(filled) < 2 and is_comment(lines[i])):
                i -= 1
                continue
            if len(filled) < 2 or numeric[i] >= 3:
                break
            parts.insert(0, cells[i])
            used.insert(0, i + 1)
            count = max(len(p) for p in parts)
            whole = [k for k, line in enumerate(used) if numeric[line - 1] == 0]
            if len(whole) < len(used) and columns.complete(joined_headings([parts[k] for k in whole], count), options.readings):
                first = next(line for line in used if numeric[line - 1]) - 1  # a row of data of which one cell is no number
                parts, used = [parts[k] for k in whole], [used[k] for k in whole]
            if columns.complete(joined_headings(parts, count), options.readings):
                # "Measured" over "Depth": a line above that goes on belongs to it, if all is still named.
                above = cells[i - 1] if i else []
                if sum(map(bool, above)) >= 2 and len(above) <= count and numeric[i - 1] == 0:
                    if columns.complete(joined_headings([above, *parts], count), options.readings):
                        parts.insert(0, above)
                        used.insert(0, i)
                break
            i -= 1
        if not parts and not options.columns:
            continue
        count = max([len(p) for p in parts], default=len(cells[first]))
        headings = joined_headings(parts, count)
        if not options.columns and not columns.complete(headings, options.readings):
            # Two lines above may still be a heading with a name over it; else this is a number in a title.
            if options.last_resort is None and parts and count >= 3:
                options.last_resort = (f"line {used[-1]}", headings)
            continue
        if options.columns and not parts:
            headings = [""] * len(cells[first])
        header = {same_words(lines[n - 1]) for n in used}
        longer = [n for n in range(first, len(cells)) if numeric[n] >= 3 and any(cells[n][count:]) and not any(map(columns.looks_numeric, cells[n][count:]))]
        if used and longer and not options.columns and len(longer) == sum(m >= 3 for m in numeric[first:]):
            raise Problem(f"{options.name}:line {longer[0] + 1}: {len(cells[longer[0]])} values, as in all rows, below {count} headings (line {used[-1]}): "
                          "which belongs to which cannot be seen: name the columns: --columns md=NUMBER,inc=NUMBER,azi=NUMBER")
        rows = [Row(f"line {n + 1}", cells[n], same_words(lines[n]) in header) for n in range(first, len(cells)) if n + 1 not in options.skip_lines]
        return Table(f"{SEPARATORS[separator]}-separated text", headings, rows, place_of(used, first))
    return None


def place_of(used, first):
    if not used:
        return f"line {first + 1}"
    return f"line {used[0]}" if used[0] == used[-1] else f"lines {used[0]}-{used[-1]}"


def tokens(line):
    return [(m.start(), m.end(), m[0]) for m in re.finditer(r"\S+", line)]


def joined_tokens(line):
    """As tokens(), but a bearing ("S 40.5 W") and words with single spaces between ("A-11 T") are one."""
    out = []
    for m in re.finditer(rf"(?<!\S){columns.BEARING}(?!\S)|\S+", line):
        word = (m.start(), m.end(), m[0])
        is_text = not columns.looks_numeric(m[0])
        if out and is_text and word[0] == out[-1][1] + 1 and not columns.looks_numeric(out[-1][2]):
            out[-1] = (out[-1][0], word[1], out[-1][2] + " " + m[0])
        else:
            out.append(word)
    return out


def phrases(line):
    """Words with single spaces between them, and where they stand."""
    return [(m.start(), m.end(), m[0]) for m in re.finditer(r"\S+(?: \S+)*", line)]


def overlap(a, b):
    return min(a[1], b[1]) - max(a[0], b[0])


def nearest(word, spans):
    """The column that a word of the header stands over: most overlap, else the nearest middle."""
    best = max(range(len(spans)), key=lambda k: overlap(word, spans[k]))
    if overlap(word, spans[best]) > 0:
        return best
    return min(range(len(spans)), key=lambda k: abs(spans[k][0] + spans[k][1] - word[0] - word[1]))


def has_cell_a_column(line, count):
    return count in (len(phrases(line)), len(tokens(line)))


def header_cells(line, spans):
    """Cells of a header line over columns of numbers: by count where counts agree, else by place."""
    words, groups, count = tokens(line), phrases(line), len(spans)
    cells = [""] * count
    for kind in (groups, words):
        if len(kind) == count:
            return [w[2] for w in kind]
    for group in groups:
        over = [k for k in range(count) if overlap(group, spans[k]) > 0]
        if len(over) <= 1:
            k = nearest(group, spans)
            cells[k] = (cells[k] + " " + group[2]).strip()
        else:
            for m in re.finditer(r"\S+", group[2]):
                k = nearest((group[0] + m.start(), group[0] + m.end()), spans)
                cells[k] = (cells[k] + " " + m[0]).strip()
    return cells


def by_place(line, spans):
    """What keeps the headings of a line from standing over one column each, or None."""
    taken = {}
    for group in phrases(line):
        over = [k for k in range(len(spans)) if overlap(group, spans[k]) > 0]
        parts = [group] if len(over) == 1 else [(group[0] + m.start(), group[0] + m.end(), m[0]) for m in re.finditer(r"\S+", group[2])]
        for part in parts:
            over = [k for k in range(len(spans)) if overlap(part, spans[k]) > 0]
            if len(over) != 1:
                return f"'{shown(part[2], 30)}' stands over {len(over) or 'no'} columns"
            if over[0] in taken and taken[over[0]] != group:
                return f"'{shown(taken[over[0]][2], 30)}' and '{shown(part[2], 30)}' stand over one column"
            taken[over[0]] = group
    return None


def spaced(lines, options):
    """A Table of columns with spaces between, fixed or not, or None. Where headings are as many as columns, they are theirs."""
    expanded = [line.expandtabs(8) for line in lines]
    plain = [tokens(line) for line in expanded]
    joined = [joined_tokens(line) if sum(columns.looks_numeric(w[2]) for w in p) >= 2 else p for line, p in zip(expanded, plain)]
    if joined == plain:
        return spaced_words(lines, expanded, plain, options)
    found = []
    for words in (plain, joined):
        try:
            found.append(spaced_words(lines, expanded, words, options))
        except Problem as problem:
            found.append(problem)
    tables = [t for t in found if isinstance(t, Table)]
    best = [t for t in tables if t.by_count] or tables[-1:] or [f for f in found if f][-1:]
    if not best:
        return None
    if isinstance(best[0], Problem):
        raise best[0]
    if any(columns.bearing(c) for r in best[-1].rows[:50] for c in r.cells):
        return best[-1]
    return min(best, key=lambda t: sum(len(r.cells) > len(t.headings) for r in t.rows))  # where names have one word or two, joined ones


def spaced_words(lines, expanded, words, options):
    """As spaced(), of the words of every line."""
    wanted = len(columns.roles_wanted(options.readings))
    numeric = [sum(columns.looks_numeric(t[2]) for t in w) for w in words]
    data = [n for n, w in enumerate(words)
            if numeric[n] >= 3 and 2 * numeric[n] >= len(w) and len(w) >= wanted and n + 1 not in options.skip_lines]
    if not data:
        return None
    count = Counter(len(words[n]) for n in data).most_common(1)[0][0]
    regular = [n for n in data if len(words[n]) == count]
    spans = [(min(words[n][k][0] for n in regular), max(words[n][k][1] for n in regular)) for k in range(count)]
    fixed = all(a[1] <= b[0] for a, b in zip(spans, spans[1:]))
    for first in data:
        parts, used, i = [], [], first - 1
        headings = [""] * count
        while i >= 0 and len(parts) < 4 and first - i <= 8:
            if not expanded[i].strip() and parts and not only_units(parts):
                break  # what stands above an empty line is a title
            if not expanded[i].strip() or is_ruler(expanded[i]) or i + 1 in options.skip_lines:
                i -= 1
                continue
            if len(phrases(expanded[i])) < 2 and len(words[i]) < wanted or numeric[i] >= 3:
                break
            line = re.sub(r"^(\s*)[#%]", r"\1 ", expanded[i])
            parts.insert(0, header_cells(line, spans))
            used.insert(0, i + 1)
            headings = joined_headings(parts, count)
            if columns.complete(headings, options.readings):
                above = expanded[i - 1] if i else ""  # "Measured / Depth": a line above that continues the columns
                more = header_cells(above, spans)
                if len(phrases(above)) >= 2 and numeric[i - 1] == 0 and not re.search(r"[:=]", above) and len(parts) < 4:
                    longer = joined_headings([more, *parts], count)
                    if columns.complete(longer, options.readings):
                        parts.insert(0, more)
                        used.insert(0, i)
                        headings = longer
                break
            i -= 1
        if not options.columns and not (used and columns.complete(headings, options.readings)):
            if options.last_resort is None and used:
                options.last_resort = (f"line {used[-1]}", headings)
            continue
        rows, header = [], {same_words(lines[n - 1]) for n in used}
        for n in range(first, len(lines)):
            if n + 1 in options.skip_lines:
                continue
            if numeric[n] == 0 and len(phrases(expanded[n])) > 1:
                rows.append(Row(f"line {n + 1}", header_cells(expanded[n], spans), same_words(lines[n]) in header))
            elif fixed:
                cells = [""] * count
                for w in words[n]:
                    k = nearest(w, spans)
                    if overlap(w, spans[k]) > 0 or k == count - 1:
                        cells[k] = (cells[k] + " " + w[2]).strip()
                    elif numeric[n] >= wanted and columns.looks_numeric(w[2]):
                        cells.append(w[2])  # below no column: one value too many
                rows.append(Row(f"line {n + 1}", cells))
            elif len(words[n]) >= count or numeric[n] < 2:
                rows.append(Row(f"line {n + 1}", [w[2] for w in words[n]]))
            else:
                raise Problem(f"{options.name}:line {n + 1}: {len(words[n])} values: must be {count}, as in line {regular[0] + 1}: which one is "
                              f"missing cannot be seen; correct it, or leave it out: --skip-lines {n + 1}")
        by_count = any(has_cell_a_column(expanded[n - 1], count) for n in used)
        for k in range(1, count if not options.columns else 0):
            pairs = [(words[n][k - 1][2], words[n][k][2]) for n in regular]
            if headings[k] and not headings[k - 1] and all(re.fullmatch(r"\d{1,3}", a) and re.fullmatch(r"\d{3}([.,]\d*)?", b) for a, b in pairs):
                raise Problem(f"{options.name}:line {regular[0] + 1}: '{' '.join(pairs[0])}' under '{shown(headings[k])}': may be one number with a "
                              "space for thousands, or two: must be known: write it without the space, or name the columns: --columns")
        fault = None if by_count or options.columns else next(filter(None, (by_place(expanded[n - 1], spans) for n in used)), None)
        headed = [k for k in range(count) if headings[k]]
        bare = next((k for k in range(count) if not headings[k] and headed and k > headed[0]
                     and all(columns.looks_numeric(words[n][k][2]) for n in regular)), None)
        if not by_count and not options.columns and bare is not None:
            fault = fault or f"column {bare + 1} has no heading"
        if not by_count and not options.columns and not fixed:
            fault = fault or "columns do not stand below each other"
        if fault:
            raise Problem(f"{options.name}:{place_of(used, first)}: {max(len(phrases(expanded[n - 1])) for n in used)} headings over {count} columns "
                          f"({shown('|'.join(w[2] for w in words[regular[0]]), 80)}): {fault}: which belongs to which cannot be seen: name the columns: "
                          "--columns md=NUMBER,inc=NUMBER,azi=NUMBER")
        table = Table("fixed-width text" if fixed else "space-separated text", headings, rows, place_of(used, first))
        table.by_count = by_count
        return table
    return None


def north_in_titles(lines):
    """The north that a title line names: 'North Reference: Grid', 'Azimuths are to True North'."""
    found = None
    for n, line in enumerate(lines[:2000]):
        line = line[:400]
        hit = (re.search(r"(?:north|azimuth|azi)\s*(?:ref\w*\.?)\s*(?:to|is)?[:=,;|\"\s]+(true|grid|magnetic)\b", line, re.I)
               or re.search(r"azimuths?\s+(?:are\s+)?(?:referenced|referred|relative|given|corrected)?\s*to\s+(true|grid|magnetic)", line, re.I)
               or re.search(r"\b(?:north|azimuths?)\s*(?:type|system)?\s*[:=]+\s*(true|grid|magnetic)\b", line, re.I)
               or re.search(r"all\s+azimuths?\s+(?:are\s+)?(true|grid|magnetic)\b", line, re.I))
        if not hit:
            continue
        rest = re.split(r"\s{2,}|[,;|\t]", line[hit.end():])[0]
        if {w.lower() for w in re.findall(r"\b(?:true|grid|magnetic)\b", rest, re.I)} - {hit[1].lower()}:
            return "several", f"line {n + 1} '{shown(line.strip(), 50)}'"
        if found and found[0] != hit[1].lower():
            return "several", f"line {n + 1} '{shown(line.strip(), 40)}' and {found[1]}"
        if not found:
            found = hit[1].lower(), f"line {n + 1} '{shown(line.strip(), 50)}'"
    return found


def length_unit(words):
    """The unit of length that begins a text: 'Feet (RKB)' -> 'ft'; None for anything else."""
    words = re.split(r"\s{2,}|[,;|\t\"(]", words.strip())[0]
    if re.search(r"\b(?:us|u\.s\.)?\s*survey\s+(?:ft|foot|feet)\b", words, re.I):
        return "usft"
    return columns.length_of(words)


def claims_in_titles(lines, options):
    """[(role, unit, place)] of title lines such as 'Depth Units: Feet'. Inclinations from the horizontal are refused."""
    found = []
    for n, line in enumerate(lines[:2000]):
        if n + 1 in options.skip_lines:
            continue
        line = line[:400]
        place = f"line {n + 1} '{shown(line.strip(), 50)}'"
        if re.search(r"\b(?:incl?\w*|angles?|dips?|drift|deviations?)\b", line, re.I) and doubts.is_from_horizontal(line):
            raise Problem(f"{options.name}:line {n + 1}: '{shown(line.strip(), 60)}': inclinations must be from the vertical: 90 deg minus "
                          f"those from the horizontal; convert them, and take the line out, or, if it is not so: --skip-lines {n + 1}")
        hit = (re.search(r"\b(?:measured\s+depths?|depths?|md|lengths?)[\s_]+units?\s*(?:is|are)?[\s:=,;|\"]+(.*)", line, re.I)
               or re.search(r"\b(?:measured\s+)?depths?\s+(?:is|are)\s+(?:given\s+)?in\s+(.*)", line, re.I)
               or re.match(r"[\s#%\"]*units?\s*[:=,;|\t\"]+\s*(.*)", line, re.I))
        unit = hit and length_unit(hit[1].rstrip(" .,;|\""))
        if unit:
            found.append(("md", unit, place))
    return found


def closed_quotes(lines):
    """Headings in quotes that go over lines, as spreadsheets write them, in the last of their lines; the others are empty."""
    out, most = list(lines), 20
    for first, line in enumerate(lines):
        if out[first].count('"') % 2 == 0 or not re.search(r'(?:^|[,;\t|])\s*"[^"]*$', line):
            continue
        quotes = 0
        for last in range(first, min(first + most, len(lines))):
            if sum(map(columns.looks_numeric, re.split(r"[,;\t|]", lines[last]))) >= 2:  # a row of data is in no heading
                break
            quotes += lines[last].count('"')
            if quotes % 2 == 0:
                out[first:last + 1] = [*[""] * (last - first), " ".join(lines[first:last + 1])]
                break
    return out


def read(text, file, options):
    lines = lines_of(text)
    if not text.strip():
        raise Problem(f"{file}: is empty: must hold a header and rows of stations")
    check_size(lines, file)
    options.last_resort = None
    cells = closed_quotes(lines)
    tables = [t for t in (delimited(cells, s, options) for s in SEPARATORS) if t]
    table = max(tables, key=lambda t: len(t.headings), default=None) or spaced(lines, options)
    if table is None:
        wanted = "md, gx, gy, gz, bx, by, bz" if options.readings else "measured depth, inclination and azimuth"
        if options.last_resort:
            place, headings = options.last_resort
            raise Problem(f"{file}:{place}: headings {columns.listed(headings)}: must name {wanted}; {columns.missing(headings, options.readings)}; name the columns: "
                          f"--columns {','.join(r + '=NUMBER' for r in columns.roles_wanted(options.readings))}")
        minutes = re.search(r"\d\s*[°ºd]\s*\d[\d.]*\s*['′’m]", text[:100_000])
        if minutes:
            raise Problem(f"{file}:line {text.count(chr(10), 0, minutes.start()) + 1}: '{shown(minutes[0])}': degrees and minutes are not read: must be "
                          "degrees with decimals")
        raise Problem(f"{file}: {sum(map(bool, map(str.strip, lines)))} lines, no header over rows of numbers: must name {wanted}; name the "
                      f"columns if there is none: --columns {','.join(r + '=NUMBER' for r in columns.roles_wanted(options.readings))}")
    table.titles = lines[:int(re.search(r"\d+", table.header_place)[0]) - 1]
    table.reference = north_in_titles(lines)
    table.claims = claims_in_titles(lines, options)
    return table
