"""Six-axis readings in JSON: a list of accelerometer readings and one of magnetometer readings.

The lists stand under names such as "grav" and "mag", at the top or further in. An entry is a list of three numbers, or the
lists are flat, three numbers a shot. Instruments that are not in a hole have no measured depth: --depth-step makes one up.
"""

import json
import math
import re

from . import columns
from .problem import USAGE, Problem, shown
from .table import Row, Table

DEEPEST = 20  # of lists and objects in each other
KINDS = {"g": "accelerometers", "b": "magnetometers"}


def is_json(text):
    return bool(re.match(r"\s*[\[{]\s*[\"\[{\d\]}-]", text))


def read(text, file, options):
    """A Table with the columns md, gx, gy, gz, bx, by, bz; --columns g=NAME,b=NAME names the lists where names do not."""
    if not options.readings:
        raise Problem(f"{file}: is JSON: a survey must be a table of text, LAS, WITSML or Excel; write it as CSV; for six-axis readings: --readings")
    try:
        tree = json.loads(text, parse_float=str, parse_int=str, parse_constant=lambda word: "nan" if word == "NaN" else word)
    except RecursionError:
        raise Problem(f"{file}: lists in lists too deep to read: must be lists of readings; correct the file")
    except json.JSONDecodeError as fault:
        raise Problem(f"{file}:line {fault.lineno}: {shown(fault.msg)}: must be JSON from here on; correct it")
    lists = dict(named_lists(tree))
    names = {kind: name_of(kind, lists, file, options) for kind in KINDS}
    shots = {kind: triples(lists[name], f"{file}: {name}") for kind, name in names.items()}
    if len(shots["g"]) != len(shots["b"]):
        raise Problem(f"{file}: {names['g']} has {len(shots['g'])} shots, {names['b']} {len(shots['b'])}: must be as many; correct the file")
    if options.depth_step is None:
        raise Problem(f"{file}: JSON of readings has no measured depth: must be made up: --depth-step METRES from shot to shot (gains, biases and attitudes do not "
                      "depend on it, positions mean nothing)")
    rows = []
    for k, (g, b) in enumerate(zip(shots["g"], shots["b"])):
        empty = [value == "nan" for value in [*g, *b]]
        if all(empty):
            continue  # the list is longer than the shots in it
        if any(empty):
            raise Problem(f"{file}:shot {k + 1}: {columns.AXES[empty.index(True)]} has no value: must be a number, or none of the six; correct it, or leave the "
                          f"shot out: --skip-lines {k + 1}")
        if k + 1 not in options.skip_lines:
            rows.append(Row(f"shot {k + 1}", [columns.plain(columns.Decimal(repr(options.depth_step)) * (k + 1)), *g, *b]))
    if not rows:
        raise Problem(f"{file}: {names['g']}, {names['b']}: hold no shot: must hold readings")
    options.columns = {role: name for role, name in options.columns.items() if role not in KINDS}
    table = Table("JSON", ["md (m)", *columns.AXES], rows, f"{names['g']}, {names['b']}", plain_numbers=True)
    table.warnings.append(f"{file}: has no measured depth: made up, {options.depth_step:g} m from shot to shot (--depth-step): positions mean nothing")
    return table


def named_lists(tree, name="", depth=0):
    """(name with dots, list) of every list in an object that holds numbers, alone or by three."""
    if depth > DEEPEST:
        return
    if isinstance(tree, dict):
        for key, value in tree.items():
            yield from named_lists(value, f"{name}.{key}" if name else key, depth + 1)
    elif isinstance(tree, list) and tree and name and all(isinstance(v, str) or is_triple(v) for v in tree):
        yield name, tree


def is_triple(value):
    return isinstance(value, list) and len(value) == 3 and all(isinstance(v, str) for v in value)


def name_of(kind, lists, file, options):
    """The name of the list of accelerometers or magnetometers: by --columns, else the only one that says so."""
    given = options.columns.get(kind)
    if given:
        if given not in lists:
            raise Problem(f"--columns: {kind}={shown(given)}: must be one of {', '.join(map(shown, lists)) or 'the lists of numbers, and there is none'}", USAGE)
        return given
    hits = [name for name in lists if name.rsplit(".", 1)[-1].casefold() in WORDS[kind]]
    if len(hits) != 1:
        found = f"{len(hits)} lists are {KINDS[kind]} ({', '.join(map(shown, hits))})" if hits else f"no list is named as {KINDS[kind]}"
        raise Problem(f"{file}: {found}: must be one; name it: --columns {kind}=NAME, such as {kind}={shown(hits[0] if hits else next(iter(lists), 'shots.mag'))}")
    return hits[0]


WORDS = {"g": {"g", "a", "acc", "accel", "accelerometer", "accelerometers", "grav", "gravity"},
         "b": {"b", "h", "m", "mag", "magn", "magnetometer", "magnetometers", "magnetic", "magnetics"}}


def triples(values, place):
    if all(map(is_triple, values)):
        shots = values
    else:
        if not all(isinstance(v, str) for v in values):
            raise Problem(f"{place}: numbers beside lists: must be lists of three numbers, or numbers alone; correct the file")
        over = len(values) % 3
        if any(v != "nan" for v in values[len(values) - over:]):
            raise Problem(f"{place}: {len(values)} numbers: must be three a shot; correct the file")
        shots = [values[k:k + 3] for k in range(0, len(values) - over, 3)]
    for k, shot in enumerate(shots, 1):
        for value in shot:
            if value != "nan" and not is_number(value):
                raise Problem(f"{place}: shot {k} = '{shown(value)}': must be a number; correct it")
    return shots


def is_number(text):
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False
