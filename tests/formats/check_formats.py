#!/usr/bin/python3
"""Result files that earlier revisions wrote are read: check_formats.py SURVEYMC

tests/formats/VERSION/NAME.h5.txt is a result of that format_version, compressed by gzip, in base64; NAME.csv is a table of it
as `surveymc show NAME.h5 TABLE --csv` printed it then, behind a line "TABLE content_hash". They are never made anew: what
cannot read them any more breaks the promise of docs/results-format.md. (Four had a seal of an older form, which nothing released
has written: they are sealed as revision 961b4c7 seals.) To keep a result of today beside them:
check_formats.py SURVEYMC --keep RESULT.h5 TABLE
"""
import base64
import gzip
import pathlib
import subprocess
import sys
import tempfile

import h5py

FOLDER = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parents[1] / "scripts"))
from surveymc import integrity, storage  # noqa: E402

WIDTH = 120


def call(program, *arguments, codes=(0,)):
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode not in codes:
        sys.exit(f"{arguments}: exit {done.returncode}: {done.stderr}")
    return done.stdout


def keep(program, result, table):
    with h5py.File(result, "r") as file:
        version, content_hash = file.attrs["format_version"], file.attrs["content_hash"]
    folder = FOLDER / str(version)
    folder.mkdir(exist_ok=True)
    name = pathlib.Path(result).stem
    text = base64.b64encode(gzip.compress(pathlib.Path(result).read_bytes(), 9, mtime=0)).decode()
    for path, content in ((folder / f"{name}.h5.txt", "\n".join(text[i:i + WIDTH] for i in range(0, len(text), WIDTH)) + "\n"),
                          (folder / f"{name}.csv", f"{table} {content_hash}\n{call(program, 'show', result, table, '--csv')}")):
        if path.exists():
            sys.exit(f"{path} exists: kept files are never made anew")
        path.write_text(content)


def main():
    program = str(pathlib.Path(sys.argv[1]).resolve())
    if sys.argv[2:3] == ["--keep"]:
        return keep(program, *sys.argv[3:])
    kept = sorted(FOLDER.glob("*/*.h5.txt"))
    if len(kept) < 3:
        sys.exit("the kept files are missing")
    with tempfile.TemporaryDirectory(prefix="surveymc-formats-") as folder:
        for path in kept:
            name = path.name.removesuffix(".h5.txt")
            file = pathlib.Path(folder) / f"{name}.h5"
            file.write_bytes(gzip.decompress(base64.b64decode(path.read_text())))
            head, csv = path.with_name(f"{name}.csv").read_text().split("\n", 1)
            table, content_hash = head.split()
            if call(program, "show", file, table, "--csv") != csv:
                sys.exit(f"{path}: table {table} reads otherwise")
            call(program, "show", file)
            said = call(program, "show", file, "--json", "--list")  # all is read, and held against the content hash
            if f'"content_hash": "{content_hash}"' not in said:
                sys.exit(f"{path}: another content hash")
            with storage.open_file(str(file)) as opened:
                if integrity.content_hash(opened) != content_hash:
                    sys.exit(f"{path}: Python reads other contents")
            again = call(program, "rerun", file, codes=(0, 1)).split("\n")[0]  # 1: other numerics, or texts of tables
            print(f"{path.relative_to(FOLDER)}: read; rerun: {again}")


main()
