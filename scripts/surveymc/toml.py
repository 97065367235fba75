"""Writes dicts as TOML: Python reads it (tomllib), and has nothing that writes it."""

import datetime
import math
import re


def dumps(settings):
    """Nested dicts as TOML text. Values may be str, bool, int, float, dates, lists, dicts, and what numpy makes of them.

    A key with a dot stays one key ("noise.scale" = ..., as [sweep] has them). TypeError for any other value.
    """
    lines = []
    _table(lines, (), settings)
    return "\n".join(lines) + "\n"


def value(of):
    """One value as TOML; dicts inline."""
    if hasattr(of, "tolist"):  # numpy's numbers and arrays
        of = of.tolist()
    if isinstance(of, bool):
        return "true" if of else "false"
    if isinstance(of, int):
        return str(of)
    if isinstance(of, float):
        return repr(of) if math.isfinite(of) else "nan" if math.isnan(of) else "inf" if of > 0 else "-inf"
    if isinstance(of, (datetime.datetime, datetime.date, datetime.time)):
        return of.isoformat()
    if isinstance(of, dict):
        return "{" + ", ".join(f"{_key(k)} = {value(v)}" for k, v in of.items()) + "}"
    if isinstance(of, (list, tuple)):
        return "[" + ", ".join(value(v) for v in of) + "]"
    if hasattr(of, "__fspath__"):
        of = of.__fspath__()
    if isinstance(of, str):
        return _text(of)
    raise TypeError(f"no TOML value: {of!r}")


def _text(of):
    names = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t", "\r": "\\r"}
    return '"' + "".join(names.get(c) or (c if c.isprintable() else f"\\U{ord(c):08x}") for c in of) + '"'


def _key(of):
    if not isinstance(of, str):
        raise TypeError(f"a key must be a text: {of!r}")
    return of if re.fullmatch(r"[A-Za-z0-9_-]+", of) else _text(of)


def _is_tables(of):
    return isinstance(of, (list, tuple)) and len(of) > 0 and all(isinstance(v, dict) for v in of)


def _table(lines, path, settings):
    """The values of one table, then its tables: TOML reads what follows a heading as part of it."""
    for k, v in settings.items():
        if not isinstance(v, dict) and not _is_tables(v):
            lines.append(f"{_key(k)} = {value(v)}")
    for k, v in settings.items():
        name = ".".join(_key(p) for p in (*path, k))
        for table in [v] if isinstance(v, dict) else v if _is_tables(v) else []:
            lines += ["", f"[{name}]" if isinstance(v, dict) else f"[[{name}]]"]
            _table(lines, (*path, k), table)
