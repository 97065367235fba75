"""What headings mean, which units they name, and numbers of which no digit is lost.

A heading is text such as "Measured Depth (ft)", "AZI_GRID [deg]" or "Incl.": words are compared without case, accents and
marks. Whatever can be read in two ways is asked for by an option.
"""

import math
import re
from dataclasses import dataclass, field
from decimal import ROUND_HALF_EVEN, Context, Decimal

from .problem import DATA, USAGE, Problem, shown

AXES = ["gx", "gy", "gz", "bx", "by", "bz"]
ANGLES = ["inc", "azi", "tf"]
NAMES = {"md": "measured depth", "inc": "inclination", "azi": "azimuth", "tf": "toolface"}

# Spellings, joined words in small letters. "Strong" ones say it, "weak" ones count where no column has a strong one.
STRONG = {
    "md": "md mdepth measureddepth measdepth measdep measddepth mdrkb mdkb mddepth depthmd depmd mdbrt mdrt mdkelly "
          "surveymd surveydepth measdepthmd measureddepthmd mdbkb ahdepth alonghole alongholedepth ahd",
    "inc": "inc incl inclination incli incln inclin deviation devi dev drift driftangle hdev hinc holeinclination sinc "
           "inclinationangle deviationangle angle incangle inclangle wellinclination",
    "azi": "azi azim azimuth azm azmth azimu az hazi hazim azin azit azig azimuthangle holeazimuth wellazimuth sazi "
           "azimuthgn azimuthtn azimuthmn hdaz haz holedirection direction driftdirection driftazimuth",
    "tf": "toolface tf gtf hstf highsidetoolface gravitytoolface gravtoolface tfo toolfaceangle tfhs",
}
WEAK = {"md": "depth dept dep"}
STRONG = {role: set(words.split()) for role, words in STRONG.items()}
WEAK = {role: set(words.split()) for role, words in WEAK.items()}
for _axis in "xyz":
    STRONG["g" + _axis] = {w + _axis for w in ("g", "a", "acc", "accel", "accelerometer", "grav", "gravity")}
    STRONG["b" + _axis] = {w + _axis for w in ("b", "h", "m", "mag", "magn", "magnetometer", "magnetic")}
REFERENCES = {
    "true": {"true", "tn", "truenorth", "tru"},
    "magnetic": {"magnetic", "mag", "mn", "magneticnorth", "magn"},
    "grid": {"grid", "gn", "gridnorth", "grd"},
}
SUFFIXED = {"azig": "grid", "azit": "true", "azimuthgn": "grid", "azimuthtn": "true", "azimuthmn": "magnetic"}
NEUTRAL = {"north", "corr", "corrected", "angle", "raw", "survey", "survd", "hole", "well", "borehole", "ref", "rkb",
           "kb", "rt", "brt", "reference", "no", "station", "avg", "degrees"}

# Units: as written, small letters unless the case matters; the value is (what it is, its name here).
LENGTHS = {"m": "m", "meter": "m", "meters": "m", "metre": "m", "metres": "m", "mtr": "m", "mts": "m", "mrkb": "m", "mmd": "m",
           "ft": "ft", "f": "ft", "feet": "ft", "foot": "ft", "'": "ft", "ftrkb": "ft", "ftmd": "ft",
           "usft": "usft", "ftus": "usft", "us ft": "usft", "ft us": "usft", "us survey ft": "usft", "us survey feet": "usft",
           "us survey foot": "usft", "survey ft": "usft", "survey feet": "usft", "us feet": "usft", "us foot": "usft"}
ANGLE_UNITS = {"deg": "deg", "degs": "deg", "degree": "deg", "degrees": "deg", "°": "deg", "º": "deg", "dega": "deg", "ø": "deg",
               "rad": "rad", "rads": "rad", "radian": "rad", "radians": "rad",
               "gon": "gon", "gons": "gon", "grads": "gon", "gradian": "gon", "gradians": "gon"}
EITHER = {"grad", "gr"}  # the degree in German and Norwegian, the gon in English
ACCELERATIONS = {"g": "g", "mg": "mg", "milli-g": "mg", "millig": "mg", "m/s2": "mps2", "m/s^2": "mps2", "m/s²": "mps2",
                 "mps2": "mps2", "m/sec2": "mps2", "m/s/s": "mps2", "ms-2": "mps2", "m.s-2": "mps2", "m s-2": "mps2"}
INDUCTIONS = {"nt": "nT", "ntesla": "nT", "nanotesla": "nT", "gamma": "nT", "gammas": "nT", "ut": "uT", "µt": "uT", "μt": "uT",
              "microtesla": "uT", "gauss": "gauss", "g": "gauss", "gs": "gauss", "mgauss": "mgauss", "milligauss": "mgauss", "mg": "mgauss"}
ALL_UNITS = set(LENGTHS) | set(ANGLE_UNITS) | EITHER | set(ACCELERATIONS) | set(INDUCTIONS)


_DATUM = r"(?:rkb|kb|rt|brt|bkb|brkb|rte|df|bdf|gl|msl|md|mdrt|mdrkb|mdkb|mdbrt|tvd|tvdrt|tvdrkb|tvdss|tvdmsl|ss|ahd|ah|ahbrt|ahrt|ahkb|ahrkb|ahbdf)"


def length_of(text):
    """'m', 'ft' or 'usft' of a unit as written, with or without the datum behind it: "m RKB", "ftKB", "mMDRT"; or None."""
    key = unit_key(text)
    if key in LENGTHS:
        return LENGTHS[key]
    hit = re.fullmatch(rf"(m|metres?|meters?|ft|feet|usft|us ft)[ ./,]*{_DATUM}(?:[ ./,]*{_DATUM})?", key)
    return LENGTHS[hit[1]] if hit else None


def is_unit(text):
    return unit_key(text) in ALL_UNITS or length_of(text) is not None


def unit_of(role, text):
    return length_of(text) if role == "md" else vocabulary(role).get(unit_key(text))


def vocabulary(role):
    return LENGTHS if role == "md" else ANGLE_UNITS if role in ANGLES else ACCELERATIONS if role[0] == "g" else INDUCTIONS


def split_heading(heading):
    """(name, unit texts in brackets): 'Depth (RKB) [ft]' -> ('Depth', ['RKB', 'ft'])."""
    brackets = [a or b or c for a, b, c in re.findall(r"\(([^()]*)\)|\[([^\[\]]*)\]|\{([^{}]*)\}", heading)]
    inner = [re.sub(r"[\[\]()]", " ", b).strip() for b in brackets if b.strip()]  # "ft[US]" is put right below
    return re.sub(r"\([^()]*\)|\[[^\[\]]*\]|\{[^{}]*\}", " ", heading).strip(), inner


def unit_key(text):
    return " ".join(re.sub(r"[.,]+$", "", text.strip()).replace("_", " ").casefold().split())


@dataclass
class Heading:
    """What one heading can mean."""
    text: str
    strong: set = field(default_factory=set)
    weak: set = field(default_factory=set)
    reference: str = None
    unit: str = None  # as written


def read_heading(text, unit=None):
    """Roles, unit and azimuth reference that a heading names."""
    found = Heading(text)
    text = re.sub(r"\bft\s*[\[(]\s*us\s*[\])]", "usft", text, flags=re.I)
    name, inner = split_heading(text)
    units = ([unit] if unit else []) + [i for i in inner if is_unit(i)]
    words = [w for w in re.split(r"[^\w°º/²^'µμ]+|_", re.sub(r"([a-z])([A-Z][a-z])", r"\1 \2", name)) if w]
    for i in inner:
        if not is_unit(i):
            words += [w for w in re.split(r"[^\w°º/²^'µμ]+|_", i) if w]
    # A unit without brackets stands last: "MD ft", "md_us_ft", "Incl deg".
    for take in (3, 2, 1):
        tail = " ".join(words[-take:])
        if not units and len(words) > take and is_unit(tail) and unit_key(tail) not in ("gr", "f"):
            units, words = [tail], words[:-take]
    found.unit = units[0] if units else None
    small = [w.casefold() for w in words]
    for reference, spellings in REFERENCES.items():
        if any(w in spellings for w in small):
            found.reference = reference if found.reference in (None, reference) else "several"
    if found.reference == "magnetic" and any(w in ("corr", "corrected", "correction") for w in small):
        found.reference = "several"  # a magnetic azimuth, or one corrected to another north
    if "tvd" in small or "vertical" in small or "vert" in small or re.match(r"\s*[-\u2212\u2013]\s*\w", name):  # "-Gx" is no Gx
        return found
    bare = [w for w in small if w not in NEUTRAL and not any(w in s for s in REFERENCES.values())]
    joined = {"".join(small), "".join(bare)}
    for role, spellings in STRONG.items():
        if joined & spellings:
            found.strong.add(role)
    for role, spellings in WEAK.items():
        if joined & spellings:
            found.weak.add(role)
    if not found.strong and len(bare) > 1:  # two headings in one: "Inclination Azimuth"
        for role in ("md", *ANGLES):
            if any(w in STRONG[role] for w in bare):
                found.weak.add(role)
        found.weak = found.weak if len(found.weak) > 1 else set()
    for word, reference in SUFFIXED.items():
        if word in joined:
            found.reference = reference
    return found


def roles_wanted(readings):
    return ["md", *AXES] if readings else ["md", "inc", "azi"]


def complete(headings, readings):
    """Whether these headings name all that is needed; what text readers look for when they search the header."""
    read = [read_heading(h) for h in headings]
    return all(any(role in h.strong or h.weak == {role} for h in read) for role in roles_wanted(readings))


@dataclass
class Choice:
    """A column that is taken."""
    role: str
    index: int
    heading: str
    unit: str = None  # the name here: m, ft, usft, deg, rad, gon, g, mg, mps2, nT, uT, gauss, mgauss
    unit_from: str = ""
    by_option: bool = False


def position_of(wanted, table, role, option):
    """The column that --columns names, by its number from 1 or its heading."""
    if re.fullmatch(r"\d+", wanted):
        if not 1 <= int(wanted) <= len(table.headings):
            raise Problem(f"{option}: {role}={wanted}: must be in [1, {len(table.headings)}], the columns of the file", USAGE)
        return int(wanted) - 1
    same = [i for i, h in enumerate(table.headings) if " ".join(h.split()).casefold() == " ".join(wanted.split()).casefold()]
    if len(same) != 1:
        raise Problem(f"{option}: {role}={shown(wanted)}: {'no column has' if not same else f'{len(same)} columns have'} this heading; "
                      f"the columns are {listed(table.headings)}; a number, from 1, will do too", USAGE)
    return same[0]


def listed(headings, most=30):
    more = f" and {len(headings) - most} more" if len(headings) > most else ""
    return ", ".join(f"{i + 1} '{shown(h, 30)}'" for i, h in enumerate(headings[:most])) + more


def missing(headings, readings):
    """Of headings that do not name all that is needed: what is not found, and why."""
    read = [read_heading(h) for h in headings]
    lost = [NAMES.get(r, r) for r in roles_wanted(readings) if not any(r in h.strong or h.weak == {r} for h in read)]
    positions = not readings and any(re.search(r"\btvd|\b(north|east)|^\W*[xy]\b|n/\W?s", h, re.I) for h in headings)
    level = next((h for h in headings if re.search(r"(?<![a-z])(dip|plunge|horiz\w*)(?![a-z])", h, re.I)), None) if "inclination" in lost else None
    if level is not None:
        return f"found no {', no '.join(lost)}; '{shown(level, 30)}' counts from the horizontal: an inclination is 90 deg minus it"
    return f"found no {', no '.join(lost)}" + ("; positions alone are not read: angles must be there" if positions and "inclination" in lost else "")


def choose(table, file, options):
    """The columns to take, with their units where headings or options name them, and the azimuth reference."""
    place = f"{file}:{table.header_place}"
    read = [read_heading(h, table.units[i] if table.units else None) for i, h in enumerate(table.headings)]
    wanted, picked = roles_wanted(options.readings), {}
    roles = wanted if options.readings else [*wanted, "tf"]
    for role, name in options.columns.items():
        if role not in roles:
            raise Problem(f"--columns: {role}: unknown; must be one of {', '.join(roles)}", USAGE)
        picked[role] = position_of(name, table, role, "--columns")
    for role in roles:
        if role in picked or (role == "tf" and options.no_toolface):
            continue
        hits = [i for i, h in enumerate(read) if role in h.strong] or [i for i, h in enumerate(read) if role in h.weak]
        hits = [i for i in hits if i not in picked.values() or role not in read[i].strong]
        if role == "azi" and len(hits) > 1 and options.azimuth_reference:
            named = [i for i in hits if read[i].reference == options.azimuth_reference]
            hits = named or hits
        if not hits and role == "tf":
            continue
        if not hits:
            raise Problem(f"{place}: no column is the {NAMES.get(role, role)}; the columns are {listed(table.headings)}; "
                          f"name it: --columns {role}=NUMBER or {role}=HEADING")
        if len(hits) > 1:
            way = "--azimuth-reference or " if role == "azi" and len({read[i].reference for i in hits}) == len(hits) else ""
            way = way + f"--columns {role}={hits[0] + 1}" + (" or --no-toolface" if role == "tf" else "")
            raise Problem(f"{place}: columns {', '.join(repr(shown(read[i].text)) for i in hits)}: {len(hits)} columns are the "
                          f"{NAMES.get(role, role)}: one must be meant: {way}")
        meant = (read[hits[0]].strong | read[hits[0]].weak) & set(roles)  # "Az" is no accelerometer in a survey
        if len(meant) > 1:
            raise Problem(f"{place}: column {hits[0] + 1} '{shown(read[hits[0]].text)}': the heading names {' and '.join(sorted(meant))}: "
                          f"must be one: --columns {','.join(r + '=NUMBER' for r in sorted(meant))}")
        picked[role] = hits[0]
    if len(set(picked.values())) < len(picked):
        raise Problem(f"{place}: one column is taken twice: {picked}: name each: --columns", USAGE if options.columns else DATA)
    chosen = {}
    for role in roles:
        if role in picked:
            i = picked[role]
            chosen[role] = Choice(role, i, table.headings[i] or f"(column {i + 1})", by_option=role in options.columns)
            set_unit(chosen[role], read[i].unit, place, options)
            check_claims(chosen[role], table, file, options)
    reference = None if options.readings else azimuth_reference(table, read[picked["azi"]], place, options)
    return chosen, reference


def check_claims(choice, table, file, options):
    """A unit that the file names elsewhere must be that of the heading, or an option says which is right."""
    said = [(unit, place) for role, unit, place in table.claims if role == choice.role]
    said += [(unit_of(choice.role, written) or written, f"{place}: number format '{written}'")
             for written, place in table.column_claims.get(choice.index, [])]
    option = {"md": "--depth-unit", "g": "--gravity-unit", "b": "--field-unit"}.get(choice.role if choice.role == "md" else choice.role[0])
    option = option or "--angle-unit"
    other = next(((unit, place) for unit, place in said if unit != (choice.unit or "deg")), None)
    if other and choice.unit_from != option:
        both = f"{other[1]} says {other[0]}, the heading '{shown(choice.heading)}' {choice.unit or 'deg'}"
        raise Problem(f"{file}:{both}: must agree; correct the wrong one, or say which is right: {option} {choice.unit or 'deg'}"
                      + (f" or {option} usft" if (choice.unit, other[0]) == ("ft", "usft") else ""))


def set_unit(choice, written, place, options):
    """The unit of a column from its heading or an option; angles may be left open, for what the values say."""
    if written is not None and choice.role in ANGLES and unit_key(written) in EITHER:
        if not options.angle_unit:
            raise Problem(f"{place}: column '{shown(choice.heading)}': unit '{shown(written)}': is the degree in some languages, "
                          "1/400 of a turn in others: must be known: --angle-unit deg|gon")
        written = None
    if written is not None:
        choice.unit = unit_of(choice.role, written)
        choice.unit_from = "heading"
        if choice.unit is None:
            known = ", ".join(sorted(set(vocabulary(choice.role).values())))
            raise Problem(f"{place}: column '{shown(choice.heading)}': unit '{shown(written)}': must be one of {known} for "
                          f"{NAMES.get(choice.role, choice.role)}; is it another column? --columns {choice.role}=...")
        if choice.role[0] == "b" and unit_key(written) == "mg" and written.strip() == "mg":
            raise Problem(f"{place}: column '{shown(choice.heading)}': unit 'mg': must be nT, uT, gauss or mG (milligauss) for a "
                          f"magnetometer; if milligauss is meant: --field-unit mgauss") if not options.field_unit else None
    given = (options.depth_unit if choice.role == "md" else options.angle_unit if choice.role in ANGLES
             else options.gravity_unit if choice.role[0] == "g" else options.field_unit)
    name = ("--depth-unit" if choice.role == "md" else "--angle-unit" if choice.role in ANGLES
            else "--gravity-unit" if choice.role[0] == "g" else "--field-unit")
    if given and choice.unit and given != choice.unit and (choice.unit, given) != ("ft", "usft"):
        raise Problem(f"{place}: column '{shown(choice.heading)}': the heading says {choice.unit}, {name} says {given}: "
                      f"must agree; correct the heading, or leave {name} out")
    if given:
        choice.unit, choice.unit_from = given, name
    if choice.unit is None and choice.role not in ANGLES:
        units = {"md": "m|ft|usft", "g": "g|mg|mps2", "b": "nT|uT|gauss|mgauss"}["md" if choice.role == "md" else choice.role[0]]
        raise Problem(f"{place}: column '{shown(choice.heading)}': no unit: must be known: {name} {units}")


def azimuth_reference(table, heading, place, options):
    """(true|magnetic|grid, who says so); the heading of the column goes before the rest of the file."""
    said = [(heading.reference, f"heading '{shown(heading.text)}'")] if heading.reference else [table.reference] if table.reference else []
    if heading.reference and table.reference and not options.azimuth_reference and {heading.reference, table.reference[0]} <= set(REFERENCES) and \
            heading.reference != table.reference[0]:
        raise Problem(f"{place}: {said[0][1]} says {heading.reference} north, {table.reference[1]} says {table.reference[0]}: must agree: which is right? "
                      "--azimuth-reference true|magnetic|grid")
    if said and said[0][0] == "several":
        if options.azimuth_reference:
            return options.azimuth_reference, "--azimuth-reference"
        raise Problem(f"{place}: {said[0][1]}: names more than one north, or one that was corrected: must be one: "
                      "--azimuth-reference true|magnetic|grid")
    if said and options.azimuth_reference and table.reference and table.reference[0] == options.azimuth_reference != said[0][0]:
        return options.azimuth_reference, f"--azimuth-reference, and {table.reference[1]}"
    if said and options.azimuth_reference and said[0][0] != options.azimuth_reference:
        raise Problem(f"{place}: {said[0][1]} says {said[0][0]} north, --azimuth-reference says {options.azimuth_reference}: must "
                      "agree; choose the column (--columns azi=...) or correct the file")
    if said:
        return said[0]
    if options.azimuth_reference:
        return options.azimuth_reference, "--azimuth-reference"
    if options.for_program:
        return "unreferenced", ""
    raise Problem(f"{place}: column '{shown(heading.text)}': the file does not say which north azimuths are counted from: must be known: "
                  "--azimuth-reference true|magnetic|grid")


# Numbers. What is written is kept digit by digit; only marks between the digits are changed.
_SPACES = "\u00a0\u2009\u202f '’"
_POINT, _COMMA = r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?", r"[+-]?(\d+,?\d*|,\d+)([eE][+-]?\d{1,3})?"


def tidy(cell):
    return cell.strip().strip('"').strip().replace("\u2212", "-").rstrip("°º").rstrip()


BEARING = r"[NSns]\s{0,2}\d{1,2}(?:[.,]\d+)?\s{0,2}[°º]?\s{0,2}[EWew]"


def bearing(cell):
    """(letter, digits, letter) of "S 40.5 W": an angle from north or south towards east or west; or None."""
    hit = re.fullmatch(r"([NS])\s*(\d{1,2}(?:[.,]\d+)?)\s*[°º]?\s*([EW])", cell.strip(), re.I)
    return (hit[1].upper(), hit[2], hit[3].upper()) if hit else None


def azimuth_of(cell, mark, place):
    """(Decimal, text) of an azimuth cell: a number, or a bearing by quadrant, turned exactly."""
    said = bearing(cell)
    if said is None:
        return number(cell, mark, place)
    value, _ = number(said[1], mark, place)
    if value > 90:
        raise Problem(f"{place} = '{shown(cell)}': must be at most 90 deg from north or south; correct it")
    value = {"NE": value, "SE": 180 - value, "SW": 180 + value, "NW": (360 - value) if value else value}[said[0] + said[2]]
    return value, plain(value)


def is_null(cell, null):
    t = tidy(cell)
    if t.casefold() in ("", "-", "--", "nan", "null", "none", "n/a", "na", "#n/a"):
        return True
    try:
        return null is not None and Decimal(t) == Decimal(null)
    except ArithmeticError:
        return False


def looks_numeric(cell):
    """A number in any of the ways of writing, to tell rows of data from text."""
    t = tidy(cell)
    return bool(t) and len(t) < 60 and bool(re.fullmatch(r"[+-]?[\d.,\u00a0\u2009\u202f '’]*\d[\d.,]*([eE][+-]?\d{1,3})?", t, re.A) or bearing(t))


def mark_meaning(text):
    """What the marks of one number say of the decimal mark: 'point', 'comma', 'open' (may be either), or None (no marks)."""
    t = "".join(c for c in tidy(text) if c not in _SPACES).lstrip("+-")
    body = re.split("[eE]", t)[0]
    points, commas = body.count("."), body.count(",")
    if points and commas:
        return "point" if body.rfind(".") > body.rfind(",") else "comma"
    if not points and not commas:
        return None
    mark, other = (".", "comma") if points else (",", "point")
    own = "point" if mark == "." else "comma"
    if points + commas > 1:
        return other  # 1.234.567: groups of thousands
    before, after = body.split(mark)
    grouped = len(after) == 3 and 1 <= len(before) <= 3 and not before.startswith("0")
    return "open" if grouped else own


def decimal_mark(cells, options):
    """The decimal mark of a file from [(place, text, role)], 'point' or 'comma'; what can be read in two ways is asked for."""
    if options.decimal:
        return options.decimal
    said = {}
    for place, text, role in cells:
        meaning = mark_meaning(text)
        if meaning and meaning not in said:
            said[meaning] = (place, text)
        if meaning == "open":
            said.setdefault("open comma" if "," in text else "open point" if role == "md" else "three decimals", (place, text))
    if "point" in said and "comma" in said:
        (p, a), (q, b) = said["point"], said["comma"]
        raise Problem(f"{q}: '{shown(b)}' has a decimal comma, '{shown(a)}' ({p.split(':', 1)[1]}) a decimal point: a file must have one; "
                      "--decimal point|comma says which, and what does not fit is then told")
    if "point" in said or "comma" in said:
        return "point" if "point" in said else "comma"
    if "open comma" in said:
        place, text = said["open comma"]
        raise Problem(f"{place}: '{shown(text)}': the comma may be a decimal comma or a mark of thousands: must be known: "
                      "--decimal comma or --decimal point")
    if "open point" in said and "three decimals" not in said:  # no angle is a thousand: one of 2.500 has three decimals
        place, text = said["open point"]
        raise Problem(f"{place}: '{shown(text)}': the point may be a decimal point or a mark of thousands: must be known: "
                      "--decimal point or --decimal comma")
    return "point"


def number(text, mark, place):
    """(Decimal, text with a decimal point): all digits of the file. Marks of thousands must stand between groups of three."""
    t = tidy(text)
    thousands, decimal = (",", ".") if mark == "point" else (".", ",")
    body = t
    if re.search(f"[{_SPACES}{re.escape(thousands)}]", body):
        if not re.fullmatch(rf"[+-]?[1-9]\d{{0,2}}([{_SPACES}{re.escape(thousands)}]\d{{3}})+({re.escape(decimal)}\d*)?", body):
            raise Problem(f"{place} = '{shown(text)}': must be a number with a decimal {mark}, marks of thousands only between groups "
                          "of three digits; correct it, or name the other mark: --decimal")
        body = re.sub(f"[{_SPACES}{re.escape(thousands)}]", "", body)
    if not re.fullmatch(_POINT if mark == "point" else _COMMA, body, re.A):
        raise Problem(f"{place} = '{shown(text)}': must be a number; correct it, or leave the line out: --skip-lines")
    body = body.replace(",", ".").lstrip("+")
    value = Decimal(body)
    if not math.isfinite(float(value)) or abs(value) > Decimal("1e9"):
        raise Problem(f"{place} = '{shown(text)}': must be within 1e9 of zero; correct it")
    return value, body


_WIDE = Context(prec=40)
_PI = Decimal("3.14159265358979323846264338327950288419716939937510")


def plain(value, digits=None):
    """A Decimal as text without exponent; `digits`: rounded to as many significant digits."""
    if digits:
        value = Context(prec=digits, rounding=ROUND_HALF_EVEN).plus(value)
        text = format(value, "f")
        return text.rstrip("0").rstrip(".") if "." in text else text
    return format(value, "f")


def converted(value, text, unit):
    """(output unit, text): exact where the factor is a finite decimal, else to 17 digits (more than a double holds)."""
    if unit == "usft":
        return "m", plain(_WIDE.divide(_WIDE.multiply(value, Decimal(1200)), Decimal(3937)), 17)
    if unit == "rad":
        return "deg", plain(_WIDE.divide(_WIDE.multiply(value, Decimal(180)), _PI), 17)
    if unit == "gon":
        return "deg", plain(_WIDE.multiply(value, Decimal("0.9")))
    if unit == "g":
        return "mg", plain(value.scaleb(3))
    if unit == "gauss":
        return "uT", plain(value.scaleb(2))
    if unit == "mgauss":
        return "nT", plain(value.scaleb(2))
    return unit, text
