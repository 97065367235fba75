#!/usr/bin/env python3
"""Writes docs/keys.md out of the program, which knows every config key: key_tables.py SURVEYMC [PAGE]

The page has a table of the keys that all studies share, one of those that several share (equal in type, default, rule
and meaning), and one a study with the rest. The test cli.keys sees to it that the page is what the program says."""
import csv
import io
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

HEAD = """# Every config key

<!-- Written by tests/docs/key_tables.py out of the program: change the words where the program asks for a key. -->
`surveymc keys STUDY` prints the same for one study, with an example of each key. A key ends in its unit. `[]` stands in an
array of tables. Default "-": the key may be absent; "by other keys": another key decides.
"""


def ask(program, *arguments):
    return subprocess.run([program, *arguments], capture_output=True, text=True, check=True).stdout


def shown(rows):
    """Of the rows of `surveymc keys STUDY --csv` what the page has."""
    return [tuple(row[c] for c in ("key", "type", "default", "rule", "meaning")) for row in rows]


def rows_by_study(program):
    studies = [line.split()[0] for line in ask(program, "list").splitlines() if not line.startswith(" ")]
    return {s: shown(csv.DictReader(io.StringIO(ask(program, "keys", s, "--csv")))) for s in studies}


def cell(text):
    return text.replace("|", "\\|") or " "


def table(rows, more=None):
    """`more`: name of a further column, and what stands there by row."""
    lines = ["| key | default | rule | meaning |" + (f" {more[0]} |" if more else ""), "|---" * (5 if more else 4) + "|"]
    for row in rows:
        key, kind, default, rule, meaning = map(cell, row)
        what = f"{kind}: {rule}" if rule.strip() else kind
        lines.append(f"| `{key}` | {default} | {what} | {meaning} |" + (f" {more[1][row]} |" if more else ""))
    return lines


def page_of(studies):
    holders = defaultdict(list)
    for study, rows in studies.items():
        for row in rows:
            holders[row].append(study)
    in_all = [row for row, of in holders.items() if len(of) == len(studies)]
    in_several = sorted(row for row, of in holders.items() if 1 < len(of) < len(studies))
    most_named = 4
    names = {row: ", ".join(holders[row]) if len(holders[row]) <= most_named else f"{len(holders[row])} studies"
             for row in in_several}
    lines = [HEAD, "## Keys of every config", *table(in_all), "", "## Keys of several studies",
             *table(in_several, ("studies", names))]
    for study, rows in studies.items():
        own = [row for row in rows if len(holders[row]) == 1]
        shared = [f"`{row[0]}`" for row in rows if row in names]
        lines += ["", f"## Keys of `{study}`", *(table(own) if own else []), "",
                  f"Of several studies: {', '.join(shared)}."]
    return "\n".join(lines) + "\n"


def main():
    page = Path(sys.argv[2]) if len(sys.argv) > 2 else Path(__file__).resolve().parents[2] / "docs/keys.md"
    page.write_text(page_of(rows_by_study(sys.argv[1])))


if __name__ == "__main__":
    main()
