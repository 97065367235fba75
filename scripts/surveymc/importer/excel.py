"""Excel workbooks (.xlsx, .xlsm), one sheet; values as stored, formulas by the value that Excel kept."""

import io
import re
import zipfile

from . import columns, output, text
from .problem import DATA, IO, USAGE, Problem, shown

MOST_UNPACKED = 256 << 20
MOST_CELLS = 500_000  # of all sheets; openpyxl takes some 20 us for each, and two cells span all rows between them
# A formula behind which no value stands, as programs write it that compute nothing.
_WITHOUT_VALUE = re.compile(rb"(?:</(?:\w+:)?f>|<(?:\w+:)?f\b[^<>]*/>)\s*(?:<(?:\w+:)?v\s*/>|<(?:\w+:)?v>\s*</(?:\w+:)?v>)?\s*</(?:\w+:)?c>")


def read(data, file, options):
    try:
        import openpyxl
    except ImportError:
        raise Problem("python3-openpyxl is not installed, which Excel is read with: scripts/bootstrap.sh import", IO)
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as packed:
            parts = packed.infolist()
            if sum(p.file_size for p in parts) > MOST_UNPACKED:
                raise Problem(f"{file}: unpacks to more than {MOST_UNPACKED >> 20} MiB: must be less; save the sheet as CSV")
            if any(p.flag_bits & 1 for p in parts):
                raise Problem(f"{file}: is encrypted: must be open; save it without a password")
            cells, unsaved = 0, False
            for part in (packed.read(p) for p in parts if p.filename.endswith((".xml", ".rels"))):
                if b"<!DOCTYPE" in part:
                    raise Problem(f"{file}: has an XML document type: workbooks have none, and entities are not read")
                cells += sum(1 for _ in re.finditer(rb"<(?:\w+:)?(?:c|si)[ />]", part))
                if cells > MOST_CELLS:
                    raise Problem(too_many(file))
                unsaved = unsaved or bool(_WITHOUT_VALUE.search(part))
        book = openpyxl.load_workbook(io.BytesIO(data), data_only=True, read_only=False, keep_links=False)
        formulas = openpyxl.load_workbook(io.BytesIO(data), keep_links=False) if unsaved else None
    except Problem:
        raise
    except Exception as fault:  # openpyxl raises many kinds for damaged files
        raise Problem(f"{file}: {shown(fault, 100)}: must be an Excel workbook (.xlsx); open it and save it again, or as CSV")
    names = [s.title for s in book.worksheets]
    if options.sheet and options.sheet not in names:
        raise Problem(f"--sheet: '{shown(options.sheet)}': must be one of {', '.join(map(repr, names))}", USAGE)
    filled = [s for s in book.worksheets if s.max_row > 1 or s.cell(1, 1).value is not None]
    if not options.sheet and len(filled) != 1:
        raise Problem(f"{file}: {len(filled)} sheets with content: {', '.join(repr(s.title) for s in filled) or 'none'}: "
                      "one must be meant: --sheet NAME", DATA)
    sheet = book[options.sheet] if options.sheet else filled[0]
    if sheet.max_row * sheet.max_column > MOST_CELLS:
        raise Problem(too_many(file))
    cells = [[written(c) for c in row] for row in sheet.iter_rows()]
    for row in formulas[sheet.title].iter_rows() if formulas else []:
        for c in row:  # one whose value is an empty text is of type "str"
            if c.data_type == "f" and sheet[c.coordinate].value is None and sheet[c.coordinate].data_type != "str":
                cells[c.row - 1][c.column - 1] = "=" + str(getattr(c.value, "text", c.value)).lstrip("=")
    # The same search as in text, on cells: joined by a mark that no cell has.
    lines = ["\t".join(c.replace("\t", " ").replace('"', "''") for c in row) for row in cells]
    options.last_resort = None
    table = text.delimited(lines, "\t", options)
    if table is None:
        bare = next((f"row {n}: '{shown(c, 30)}'" for n, row in enumerate(cells, 1) for c in row if c.startswith("=")), None)
        if bare:
            raise Problem(f"{file}:sheet '{shown(sheet.title)}', {bare}: formulas must have values: open the workbook in a spreadsheet "
                          "program and save it")
        place, headings = options.last_resort or ("row 1", cells[0] if cells else [])
        raise Problem(f"{file}:sheet '{shown(sheet.title)}', {place.replace('line', 'row')}: headings {columns.listed(headings)}: must name "
                      f"{', '.join(columns.roles_wanted(options.readings))}; {columns.missing(headings, options.readings)}; name the columns: --columns")
    table.titles = lines[:int(re.search(r"\d+", table.header_place)[0]) - 1]
    table.form = f"Excel, sheet '{shown(sheet.title)}'"
    table.header_place = f"sheet '{shown(sheet.title)}', {table.header_place.replace('line', 'row')}"
    for row in table.rows:
        row.place = row.place.replace("line", "row")
    hidden = [row.place for row in table.rows if sheet.row_dimensions[int(row.place.rsplit(" ", 1)[-1])].hidden]
    if hidden:
        table.notes.append(("hidden", f"{output.few(hidden)}, read as any other; --skip-lines leaves them out"))
    table.reference = text.north_in_titles(lines)
    table.claims = [(role, unit, place.replace("line", "row")) for role, unit, place in text.claims_in_titles(lines, options)]
    table.column_claims = units_in_formats(sheet, table)
    if table.reference:
        table.reference = (table.reference[0], table.reference[1].replace("line", "row"))
    return table


def units_in_formats(sheet, table):
    """{column from 0: [(unit as written, place)]}: 0.0" ft" shows a unit behind every number, which no cell holds."""
    found = {}
    for row in table.rows:
        number = int(row.place.rsplit(" ", 1)[-1])
        for k in range(len(table.headings)):
            cell = sheet.cell(number, k + 1)
            if not isinstance(cell.value, (int, float)) or isinstance(cell.value, bool):
                continue
            for quoted in re.findall(r'"([^"]*)"', cell.number_format.split(";")[0].replace("\\ ", " ")):
                if columns.is_unit(quoted):
                    found.setdefault(k, {}).setdefault(columns.unit_key(quoted), row.place)
    return {k: list(units.items()) for k, units in found.items()}


def too_many(file):
    return f"{file}: has more than {MOST_CELLS:,} cells, empty ones between others too: must have less; save the sheet as CSV"


def written(cell):
    """A cell as text; a number with all digits that tell it from its neighbours."""
    value = cell.value
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value)
    if isinstance(value, float):
        return format(columns.Decimal(repr(value)), "f")
    return " ".join(str(value).split())
