"""The file that is written, whole or not at all, and the account of what was read."""

import os

from .. import whole_file
from . import doubts
from .problem import IO, USAGE, Problem, as_keys, shown

MOST_BYTES = 64 << 20
MOST_NAMES = 50  # columns that a message names


def read_file(path):
    """All bytes of a regular file of at most 64 MiB; a pipe or device is refused before it can block or never end."""
    try:
        data = whole_file.read_regular(path, MOST_BYTES)
    except whole_file.NotRegular:
        raise Problem(f"{shown(path)}: must be a regular file, no folder, pipe or device; save it to a file first", IO)
    except (OSError, ValueError) as fault:
        raise Problem(f"{shown(path)}: cannot be read: {getattr(fault, 'strerror', fault)}", IO)
    if len(data) > MOST_BYTES:
        size = max(len(data), os.path.getsize(path))
        raise Problem(f"{shown(path)}: {size} bytes: must be at most {MOST_BYTES >> 20} MiB: a survey is far smaller; cut it")
    return data


def check_target(path, source, overwrite):
    """Says early what write() would refuse."""
    if os.path.exists(path):
        if not os.path.isfile(path):
            raise Problem(f"{shown(path)}: must be a regular file, or none yet", IO)
        if os.path.samefile(path, source):
            raise Problem(f"-o: {shown(path)}: must not be the file that is read", USAGE)
        if not overwrite:
            raise Problem(f"{shown(path)}: exists: must not; choose another name, or --overwrite", IO)


def write(path, text, overwrite):
    """Whole or not at all."""
    try:
        if overwrite:
            whole_file.write(path, text.encode("ascii"), lambda name: True)
        else:
            whole_file.write_new(path, text.encode("ascii"))
    except FileExistsError:
        raise Problem(f"{shown(path)}: exists: must not; choose another name, or --overwrite", IO)
    except OSError as fault:
        raise Problem(f"{shown(path)}: cannot be written: {fault.strerror}; choose another place: -o", IO)


def csv_of(stations):
    return "".join(",".join(row) + "\n" for row in [stations.heads, *stations.texts])


def toml_text(text):
    return '"' + "".join({'"': '\\"', "\\": "\\\\"}.get(c, c) if c.isprintable() else f"\\u{ord(c):04x}" for c in text) + '"'


def few(places, most=6):
    kind = places[0].rsplit(" ", 1)[0]
    numbers = [p.rsplit(" ", 1)[-1] for p in places]
    return f"{kind}{'s' if len(places) > 1 else ''} {', '.join(numbers[:most])}{' ...' if len(numbers) > most else ''}"


def account(file, table, chosen, stations, reference, facts, encoding, options):
    """What was read and how, line by line."""
    unit = {"mps2": "m/s2"}
    header = f"header: {table.header_place}" if any(table.headings) else f"no header, rows from {table.header_place}"
    out = [f"{file}: {table.form}{', ' + encoding if encoding else ''}, decimal {stations.mark}; {header}"]
    for role, head in zip(stations.roles, stations.heads):
        c = chosen[role]
        name = unit.get(c.unit, c.unit)
        by = "" if c.unit_from == "heading" else f" ({c.unit_from})"
        exact = " x 1200/3937 m" if c.unit == "usft" else ""
        out.append(f"  {head:<16} from column {c.index + 1} '{shown(c.heading, 40)}', {name}{exact}{by}")
    taken = {c.index for c in chosen.values()}
    ignored = [shown(h, 30) or f"column {i + 1} (no heading)" for i, h in enumerate(table.headings)
               if i not in taken and (h or any(i < len(r.cells) and r.cells[i] for r in stations.rows))]
    ignored += list(getattr(table, "ignored", []))
    more = f" and {len(ignored) - MOST_NAMES} more" if len(ignored) > MOST_NAMES else ""
    out.append(f"  ignored          {', '.join(ignored[:MOST_NAMES]) + more if ignored else 'no column'}")
    if stations.notes:
        out.append(f"  no data          {few(stations.notes)}")
    for word, said in table.notes:
        out.append(f"  {word:<16} {said}")
    if options.skip_lines:
        out.append(f"  left out         lines {doubts.ranges(options.skip_lines)} (--skip-lines)")
    if stations.empty:
        out.append(f"  no value         {stations.empty} rows that hold only the null value {table.null}")
    md = stations.texts
    out.append(f"{len(md)} {'readings' if options.readings else 'stations'}, {stations.heads[0]} {md[0][0]} to {md[-1][0]}" + facts)
    if reference:
        out.append(f"azimuths from {reference[0]} north ({reference[1]})")
    return out


def for_program(file, table, chosen, stations, reference, warnings, encoding, options):
    """What surveymc reads: an account in one line, the line of every station, warnings, and the CSV, whose azimuth names its north."""
    lines = account(file, table, chosen, stations, None, "", encoding, options)[:-1]
    told = lines[0].replace(": ", " read as ", 1) + "; " + "; ".join(" ".join(line.split()) for line in lines[1:])
    numbers = [place.rsplit(" ", 1)[-1] for place in stations.places]
    heads = [f"azimuth_{reference[0]}_deg" if head == "azimuth_deg" and reference else head for head in stations.heads]
    text = "".join(",".join(row) + "\n" for row in [heads, *stations.texts])
    doubtful = "".join(f"warning: {as_keys(w, options.key_prefix)}\n" for w in warnings)
    lines = " ".join(numbers) if all(n.isdecimal() for n in numbers) else ""
    return f"told: {as_keys(told, options.key_prefix)}\nlines: {lines}\n{doubtful}csv:\n{text}"


def config_lines(path, reference, options, has_toolface):
    name = toml_text(os.path.basename(path))
    if options.readings:
        return ["In the config beside it:", f"  readings = {name}"]
    lines = ["In the config beside it:", "  [survey]", f"  file = {name}", f'  azimuth_reference = "{reference[0]}"']
    if has_toolface:
        lines.append(f'  toolface_zero = "{options.toolface_zero}"')
    return lines
