"""Excel workbooks (.xlsx, .xlsm), one sheet; values as stored, formulas by the value that Excel kept."""

import io
import re
import zipfile

from . import columns, text
from .problem import DATA, IO, USAGE, Problem, shown
from .table import Row, Table

MOST_UNPACKED = 256 << 20
MOST_CELLS = 500_000  # of all sheets; openpyxl takes some 20 us for each, and two cells span all rows between them


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
            cells = 0
            for part in (packed.read(p) for p in parts if p.filename.endswith((".xml", ".rels"))):
                if b"<!DOCTYPE" in part:
                    raise Problem(f"{file}: has an XML document type: workbooks have none, and entities are not read")
                cells += sum(1 for _ in re.finditer(rb"<(?:\w+:)?(?:c|si)[ />]", part))
                if cells > MOST_CELLS:
                    raise Problem(too_many(file))
        book = openpyxl.load_workbook(io.BytesIO(data), data_only=True, read_only=False, keep_links=False)
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
    cells, marks = [], {}
    for n, row in enumerate(sheet.iter_rows(), 1):
        cells.append([written(c, file, sheet.title) for c in row])
    # The same search as in text, on cells: joined by a mark that no cell has.
    lines = ["\t".join(c.replace("\t", " ").replace('"', "''") for c in row) for row in cells]
    options.last_resort = None
    table = text.delimited(lines, "\t", options)
    if table is None:
        place, headings = options.last_resort or ("row 1", cells[0] if cells else [])
        raise Problem(f"{file}:sheet '{shown(sheet.title)}', {place.replace('line', 'row')}: headings {columns.listed(headings)}: must name "
                      f"{', '.join(columns.roles_wanted(options.readings))}; name the columns: --columns")
    table.form = f"Excel, sheet '{shown(sheet.title)}'"
    table.header_place = f"sheet '{shown(sheet.title)}', {table.header_place.replace('line', 'row')}"
    for row in table.rows:
        row.place = row.place.replace("line", "row")
    table.reference = text.north_in_titles(lines)
    if table.reference:
        table.reference = (table.reference[0], table.reference[1].replace("line", "row"))
    return table


def too_many(file):
    return f"{file}: has more than {MOST_CELLS:,} cells, empty ones between others too: must have less; save the sheet as CSV"


def written(cell, file, sheet):
    """A cell as text; a number with all digits that tell it from its neighbours."""
    value = cell.value
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value)
    if isinstance(value, float):
        return format(columns.Decimal(repr(value)), "f")
    return " ".join(str(value).split())
