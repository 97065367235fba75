"""The one thing that all forms are read into: rows of text cells, with the place that each came from."""

from dataclasses import dataclass, field


@dataclass
class Row:
    place: str  # "line 12", "sheet Survey, row 12": stands behind the file name in messages
    cells: list  # one text a column, "" where the file has none
    repeats: bool = False  # a line of the header again


@dataclass
class Table:
    form: str  # "comma-separated text", "WITSML 1.4.1.1 trajectory" ...
    headings: list  # one text a column, its unit where the file has one
    rows: list
    header_place: str
    units: list = None  # one text a column where the form keeps units apart from names, else None
    reference: tuple = None  # (true|magnetic|grid, where the file says so), else None
    notes: list = field(default_factory=list)  # (word, text): more lines of the account
    null: str = None  # the number that stands for "no value" in this form
    plain_numbers: bool = False  # the form itself fixes the decimal point (LAS, XML, Excel)
    claims: list = field(default_factory=list)  # (role, unit, place): units that the file names besides the headings
    column_claims: dict = field(default_factory=dict)  # column from 0 to [(unit as written, place)]: of its number formats
    described: dict = field(default_factory=dict)  # column from 0 to what the file says of it besides its heading
    warnings: list = field(default_factory=list)  # what is doubtful, as found while reading
    by_count: bool = True  # headings are as many as columns; else they were paired by place
    titles: list = field(default_factory=list)  # lines above the header
