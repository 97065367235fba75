"""Words and numbers as HTML."""

import math
import re
import shlex

import markupsafe
from markupsafe import Markup

from ..streams import visible

MINUS, NARROW, DASH = "\N{MINUS SIGN}", "\N{NARROW NO-BREAK SPACE}", "\N{EN DASH}"
UNITS = {"deg": "°", "deg2": "deg²", "mps2": "m/s²", "m/s2": "m/s²", "nT": "nT", "m2": "m²", "1": "", "z2": "z²",
         "nT2": "nT²", "1/m": "m⁻¹"}


def escape(text):
    """A text for the page; what would move words on it, or is not UTF-8, as the terminal has it."""
    return markupsafe.escape(visible(str(text)))


def shell_word(text):
    """A text as one word of a shell's command line, whatever it holds; a file's name that begins with a dash is no option."""
    text = f"./{text}" if text.startswith("-") else text
    if visible(text) == text and "\n" not in text and "\t" not in text:
        return shlex.quote(text)
    parts = (chr(b) if 32 <= b < 127 and b not in b"\\'" else f"\\{b:03o}" for b in text.encode("utf-8", "surrogateescape"))
    return f"$'{''.join(parts)}'"


def prose(text):
    """Text of a comment as HTML: `names` in back quotes as code."""
    return Markup(re.sub(r"`([^`]+)`", r"<code>\1</code>", str(escape(text))))


def slug(text):
    """A word fit to be an id."""
    return re.sub(r"[^a-z0-9]+", "-", str(text).lower()).strip("-") or "x"


def unit(name):
    """A unit of a result file as it is printed; nothing for a plain number."""
    return UNITS.get(name, name or "")


def grouped(count):
    """20000 as '20 000'."""
    return f"{count:,}".replace(",", NARROW)


def _decimal(value, decimals):
    return f"{value:.{max(0, min(decimals, 12))}f}".replace("-", MINUS)


def number(value, digits=4):
    """A number with `digits` significant digits; a dash for NaN, ∞ for infinity."""
    if isinstance(value, (bool,)):
        return "yes" if value else "no"
    if isinstance(value, int) or (isinstance(value, float) and value.is_integer() and abs(value) < 1e15):
        return grouped(int(value)).replace("-", MINUS) if abs(value) >= 1e4 else str(int(value)).replace("-", MINUS)
    if math.isnan(value):
        return DASH
    if math.isinf(value):
        return "∞" if value > 0 else f"{MINUS}∞"
    size = math.floor(math.log10(abs(value)))
    if -4 <= size < 6:
        return _decimal(value, digits - 1 - size)
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    return Markup(f"{mantissa.replace('-', MINUS)}·10<sup>{str(int(exponent)).replace('-', MINUS)}</sup>")


def interval(value, low, high):
    """(value, interval) with the digits that the interval's width allows; the interval "" if it is not there."""
    if not (math.isfinite(value) and math.isfinite(low) and math.isfinite(high)) or high <= low:
        bounds = Markup(f"[{number(low, 3)}, {number(high, 3)}]") if not math.isnan(low) and not math.isnan(high) and high > low else ""
        return number(value), bounds
    width = math.floor(math.log10((high - low) / 2))
    size = max(abs(value), abs(low), abs(high))
    if size >= 1e6 or (size < 1e-4 and size > 0):
        return number(value, 3), Markup(f"[{number(low, 3)}, {number(high, 3)}]")
    decimals = max(0, 1 - width)
    return _decimal(value, decimals), f"[{_decimal(low, decimals)}, {_decimal(high, decimals)}]"


VERDICT_MARKS = {  # kind: class, mark, words for one and for several
    "agrees": ("agrees", "●", "agrees", "agree"),
    "finding": ("finding", "◇", "finding", "findings"),
    "undecided": ("undecided", "▲", "undecided", "undecided"),
    "may be chance": ("undecided", "△", "differs, may be chance", "differ, may be chance"),
    "differs": ("differs", "◆", "differs", "differ")}


def total(counts):
    """How many rows have a verdict."""
    return sum(counts[k] for k in VERDICT_MARKS)


def counts_sentence(counts):
    """'12 agree, 3 are findings'; the kinds that there are."""
    words = {"agrees": ("agrees", "agree"), "finding": ("is a finding", "are findings"),
             "undecided": ("is undecided", "are undecided"),
             "may be chance": ("differs, which may be chance", "differ, which may be chance"), "differs": ("differs", "differ")}
    parts = [f"{grouped(counts[k])} {w[counts[k] != 1]}" for k, w in words.items() if counts.get(k)]
    return ", ".join(parts)
