"""A survey, or six-axis readings, in another form to the CSV that surveymc reads.

    surveymc import FILE -o well.csv [options]               measured depth, inclination, azimuth (and toolface)
    surveymc import FILE --readings -o readings.csv         measured depth, Gx, Gy, Gz, Bx, By, Bz

Reads text (separated by commas, semicolons, tabs, bars or spaces; reports of fixed columns; UTF-8, UTF-16, Latin-1), LAS 1.2
and 2.0, WITSML trajectories 1.3.1, 1.4.1 and 2.x, Excel (.xlsx), and JSON of readings. It says what it took. What can be read in two ways it
does not guess: an option says. Digits are carried over as they stand. Exit codes: 0 done, 64 usage, 65 bad data, 74 cannot
read or write. Without -o nothing is written.
"""

import argparse
import ctypes
import re
import signal
import sys

from .. import streams
from ..arguments import nearest
from . import axes, checks, columns, doubts, excel, json_readings, las, listed, output, stations, text, witsml
from .problem import DATA, USAGE, Problem, as_keys, shown

MOST_SECONDS = 20  # of the processor
LONGEST_MESSAGE = 2000  # characters


class Parser(argparse.ArgumentParser):
    def error(self, message):
        unknown = re.search(r"unrecognized arguments: (--[\w-]+)", message)
        near = unknown and nearest(unknown[1], self._option_string_actions, 0.7)
        raise Problem(f"surveymc import: {message}{f'; did you mean {near}?' if near else ''}; --help shows all", USAGE)


def pairs(value):
    """--columns md=1,inc=Incl: role to number or heading."""
    found = {}
    for part in value.split(","):
        role, mark, name = part.partition("=")
        if not mark or not name.strip():
            raise argparse.ArgumentTypeError(f"'{shown(part)}': must be ROLE=NUMBER or ROLE=HEADING, such as md=1,inc=2,azi=3")
        found[role.strip().lower()] = name.strip()
    return found


def step(value):
    try:
        metres = float(value)
    except ValueError:
        metres = 0.0
    if not 0.001 <= metres <= 1000:
        raise argparse.ArgumentTypeError(f"'{shown(value)}': must be a number of metres in [0.001, 1000]")
    return metres


def line_set(value):
    found = set()
    for part in value.split(","):
        hit = re.fullmatch(r"\s*(\d{1,8})(?:-(\d{1,8}))?\s*", part)
        if not hit or int(hit[2] or hit[1]) - int(hit[1]) > 10_000_000:
            raise argparse.ArgumentTypeError(f"'{shown(part)}': must be line numbers such as 12,15-20")
        found |= set(range(int(hit[1]), int(hit[2] or hit[1]) + 1))
    return found


def arguments(given):
    p = Parser(prog="surveymc import", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False)
    p.add_argument("file", metavar="FILE")
    p.add_argument("-o", "--output", metavar="OUT.csv")
    p.add_argument("--overwrite", action="store_true", help="replace OUT.csv if it exists")
    p.add_argument("--readings", action="store_true", help="six-axis readings instead of a survey")
    p.add_argument("--depth-unit", choices=["m", "ft", "usft"], help="usft: US survey foot, 1200/3937 m; written as metres")
    p.add_argument("--angle-unit", choices=["deg", "rad", "gon"])
    p.add_argument("--gravity-unit", choices=["g", "mg", "mps2"], help="of accelerometers")
    p.add_argument("--field-unit", choices=["nT", "uT", "gauss", "mgauss"], help="of magnetometers")
    p.add_argument("--axes", type=axes.turns, default={}, metavar="g=+x+y-z,b=..",
                   help="tool axes x, y, z of accelerometers (g) and magnetometers (b) as axes of the file; default +x+y+z")
    p.add_argument("--depth-step", type=step, metavar="METRES", help="made-up depths of readings that have none (JSON)")
    p.add_argument("--azimuth-reference", choices=["true", "magnetic", "grid"])
    p.add_argument("--toolface-zero", choices=["x", "y"], help="tool axis that toolface is measured from")
    p.add_argument("--no-toolface", action="store_true", help="leave a toolface column out")
    p.add_argument("--decimal", choices=["point", "comma"])
    p.add_argument("--columns", type=pairs, default={}, metavar="md=..,inc=..", help="numbers from 1, or headings; of JSON g=.., b=..: names of lists")
    p.add_argument("--skip-lines", type=line_set, default=set(), metavar="12,15-20", help="lines (rows of a sheet) to leave out")
    p.add_argument("--sheet", help="of a workbook")
    p.add_argument("--trajectory", help="of a WITSML file with several: name, uid or number; of a table with a column of wells: the well")
    p.add_argument("--encoding", help="of text: utf-8, utf-16, latin-1 ...")
    p.add_argument("--accept-doglegs", action="store_true", help="take turns of 180 deg and more")
    p.add_argument("--accept-depths", action="store_true", help="take depths below 20 km")
    p.add_argument("--unusual", choices=["refuse", "allow"], default="refuse", help=argparse.SUPPRESS)  # of surveymc
    p.add_argument("--for-program", metavar="NAME", help=argparse.SUPPRESS)  # surveymc calls it so, and calls the file NAME
    p.add_argument("--key-prefix", default="survey.", help=argparse.SUPPRESS)  # with it: what its keys begin with
    options = p.parse_args(given)
    options.name = shown(options.for_program or options.file)
    if options.readings and (options.azimuth_reference or options.angle_unit or options.toolface_zero):
        p.error("--readings have no angles: must be without --azimuth-reference, --angle-unit and --toolface-zero")
    if not options.readings and (options.gravity_unit or options.field_unit or options.axes or options.depth_step):
        p.error("--gravity-unit, --field-unit, --axes and --depth-step are for --readings")
    return options


def read_table(data, options):
    """(table, encoding): the form is told by how the file begins."""
    file, encoding = options.name, ""
    if not data.strip(b"\0 \t\r\n"):
        raise Problem(f"{file}: is empty: must hold a survey")
    if data.startswith(b"PK\x03\x04"):
        kind, table = "Excel", excel.read(data, file, options)
    elif data.startswith(b"\xd0\xcf\x11\xe0"):
        raise Problem(f"{file}: is a workbook of Excel 97-2003 or another old Office file: must be .xlsx; save it as .xlsx or CSV")
    else:
        string, encoding = text.decode(data, file, options.encoding)
        if re.match(r"\s*<(!doctype\s+html|html|head|body|table|meta|div|style)\b", string, re.I) or re.search(r"<html\b", string[:2000], re.I):
            raise Problem(f"{file}: is HTML, a page of the web, whatever its name ends in: must be a table of text, LAS, WITSML or Excel; open it in a "
                          "spreadsheet program and save it as .xlsx or CSV")
        if "urn:schemas-microsoft-com:office:spreadsheet" in string[:2000]:
            raise Problem(f"{file}: is an XML spreadsheet of Excel 2003: must be .xlsx; save it as .xlsx or CSV")
        if string.lstrip().startswith("<"):
            kind, encoding, table = "WITSML", "", witsml.read(data, file, options)
        elif json_readings.is_json(string):
            kind, table = "JSON", json_readings.read(string, file, options)
        elif las.is_las(string):
            kind, table = "LAS", las.read(string, file, options)
        else:
            kind, table = "text", text.read(string, file, options)
    if options.depth_step and kind != "JSON":
        raise Problem(f"--depth-step: is for JSON, which has no depths: {file} is {table.form}", USAGE)
    if options.sheet and kind != "Excel":
        raise Problem(f"--sheet: is for Excel: {file} is {table.form}", USAGE)
    return table, encoding


def give_up(file):
    """Ends a reading that takes longer than any survey: some files are made so, and no one waits for minutes."""
    def late(*_):
        raise Problem(f"{shown(file)}: takes more than {MOST_SECONDS} s of processor time to read: must be a survey, read in less; cut it, or save it as CSV")
    signal.signal(signal.SIGPROF, late)
    signal.setitimer(signal.ITIMER_PROF, MOST_SECONDS)


def end_with_the_program():
    """A signal to surveymc alone leaves no reader behind."""
    end_with_parent = 1  # PR_SET_PDEATHSIG
    ctypes.CDLL(None).prctl(end_with_parent, signal.SIGKILL)


def doubtful_things(table, chosen, found, options):
    """Texts of what is doubtful. surveymc refuses the worse ones, until its config allows them; a reader of this account sees them."""
    if options.readings:
        return []
    contradictions, notes = listed.compare(table, chosen, found, options.name)
    told = [*doubts.all_of(found, table, chosen, options, options.name), *contradictions]
    if options.for_program and options.unusual != "allow":
        for is_refused, said in told:
            if is_refused:
                raise Problem(f"{said}; if the file is meant so: --unusual allow")
    return [said for _, said in told] + notes


def run(options):
    if options.for_program:
        end_with_the_program()
    data = output.read_file(options.file)
    if options.output:
        output.check_target(options.output, options.file, options.overwrite)
    table, encoding = read_table(data, options)
    chosen, reference = columns.choose(table, options.name, options)
    found = stations.collect(table, chosen, options, options.name, reference)
    axes.turn(found, options.axes)
    table.notes += axes.said(options.axes)
    doubtful = table.warnings + doubtful_things(table, chosen, found, options)
    if options.for_program:  # which checks the survey itself
        print(output.for_program(options.name, table, chosen, found, reference, doubtful, encoding, options), end="")
        return
    has_toolface = "tf" in chosen
    if has_toolface and not options.toolface_zero:
        raise Problem(f"{options.name}:{table.header_place}: column '{shown(chosen['tf'].heading)}': the file does not say which tool axis toolface "
                      "is measured from: must be known: --toolface-zero x|y, or --no-toolface")
    if options.readings:
        warnings, repeated = checks.readings(found, options.name, options)
        facts = f"; {repeated} rows repeat the depth before (estimate needs depths that increase: one shot a depth)" if repeated else ""
    else:
        warnings, steepest, (dogleg, at) = checks.survey(found, options.name, options)
        facts = f"; largest inclination {steepest:g} deg, largest dogleg {dogleg:.3g} deg/30 m" + (f" ({found.places[at]})" if dogleg else "")
    if options.output:
        output.write(options.output, output.csv_of(found), options.overwrite)
    for line in output.account(options.name, table, chosen, found, reference, facts, encoding, options):
        print(line)
    for warning in [*doubtful, *warnings]:
        print(f"warning: {warning}")
    if options.output:
        print(f"written: {shown(options.output)}")
        print("\n".join(output.config_lines(options.output, reference, options, has_toolface)))
    else:
        print("nothing was written: -o FILE.csv")


def main():
    try:
        options = arguments(sys.argv[1:])
        give_up(options.name)
        run(options)
    except Problem as problem:
        prefix = next((a.partition("=")[2] for a in sys.argv if a.startswith("--key-prefix=")), "survey.")
        has_keys = any(word.startswith("--for-program=") for word in sys.argv) and "--readings" not in sys.argv
        text = str(problem) if len(str(problem)) <= LONGEST_MESSAGE else str(problem)[:LONGEST_MESSAGE] + " ..."
        print(as_keys(text, prefix) if has_keys else text, file=sys.stderr)
        return problem.code
    except (MemoryError, RecursionError):
        print(f"{shown(sys.argv[1])}: too large or too deep to read: must be a survey; save it as CSV", file=sys.stderr)
        return DATA
    return 0


def command():
    streams.run(main, "surveymc import")


if __name__ == "__main__":
    command()
