#!/usr/bin/python3
"""What pages, configs and scripts tell a reader to type is what the program takes.

    check_commands.py SURVEYMC SOURCE

Every `surveymc COMMAND ... --option` of README.md, docs/ and configs/ is held against --help: the command is there, and so
are its options. A config that it names is in the tree or made on its page. The exit codes of docs/exit-codes.md, the
manual and the program are the same. Pages that speak of what a command no longer has are found so.
"""
import pathlib
import re
import subprocess
import sys

executable, source = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()


def call(*words):
    return subprocess.run([executable, *words], check=True, capture_output=True, text=True).stdout


def options_in(text):
    return set(re.findall(r"(?<![\w-])--[a-z][a-z-]*|(?<![\w-])-[a-zA-Z](?![\w-])", text))


def known_commands():
    """{command: its options}; "" is the program."""
    top = call("--help")
    names = re.findall(r"^  ([a-z]+) ", top[top.index("Subcommands:"):], re.M)
    known = {"": options_in(top), **{name: options_in(call(name, "--help")) for name in names}}
    for drawer in (source / "scripts/surveymc/plots").glob("*.py"):  # surveymc plot DRAWER has those of the drawer
        known["plot"] |= set(re.findall(r'add_argument\((?:"-\w", )?"(--[a-z-]+)"', drawer.read_text()))
    return known


def lines_of(text):
    """(number, line), with what a backslash at the end of a line goes on with; also of a comment."""
    number, kept = 0, ""
    for n, line in enumerate(text.splitlines(), 1):
        if not kept:
            number = n
        kept += line
        if line.rstrip().endswith("\\"):
            kept = kept.rstrip()[:-1]
            continue
        yield number, kept
        kept = ""


def faults_of(page, known):
    text = page.read_text()
    made = set(re.findall(r"<!-- file: (\S+) -->", text))
    where = page.relative_to(source)
    found, commands = [], 0
    for number, line in lines_of(text):
        for hit in re.finditer(r"(?<![\w.-])(?:[\w./]*/)?surveymc(?:-mpi)? (?:--(?!\w+=)[a-z-]+ )*([a-z]+)\b([^`|;#>)]*)", line):
            command, rest = hit[1], hit[2]
            if command not in known:  # "surveymc runs" of a sentence; what is typed stands in backquotes or begins with build/
                if hit[0].startswith("build/") or line[:hit.start()].endswith("`"):
                    found.append(f"{where}:{number}: surveymc {command}: there is no such command")
                continue
            commands += 1
            rest = re.split(r"  +(?=[a-z])|\. |: | && ", rest)[0]  # what stands behind it in words
            for option in sorted(options_in(re.sub(r"'[^']*'", "", rest)) - known[command] - {"-h", "--help"}):
                found.append(f"{where}:{number}: surveymc {command} {option}: it has no such option")
            for config in re.findall(r"(?<!\S)configs/[\w/.+-]+\.toml", rest):
                if config not in made and not (source / config).exists():
                    found.append(f"{where}:{number}: {config}: no such file")
    return found, commands


def exit_codes():
    page = (source / "docs/exit-codes.md").read_text()
    of_page = set(re.findall(r"^\| (\d+) \|", page, re.M))
    of_manual = set(re.findall(r"^\.B (\d+)$", call("man").split(".SH EXIT STATUS")[1].split(".SH")[0], re.M))
    of_code = set(re.findall(r"k\w+ = (\d+)", re.search(r"enum Exit \{.*?\};", (source / "lib/cli/exit_codes.h").read_text(), re.S)[0]))
    return [f"exit codes: {name} has {sorted(codes)}, the program {sorted(of_code)}"
            for name, codes in [("docs/exit-codes.md", of_page), ("surveymc man", of_manual)] if codes != of_code]


def main():
    known = known_commands()
    pages = [source / "README.md", *sorted(source.glob("docs/**/*.md")), *sorted(source.glob("configs/**/*.toml"))]
    faults, commands = exit_codes(), 0
    for page in pages:
        found, n = faults_of(page, known)
        faults += found
        commands += n
    used = {name for name in known if name}
    text = "\n".join(p.read_text() for p in pages[:1] + [source / f"docs/{page}.md" for page in ("using", "show", "diff", "cluster")])
    faults += [f"surveymc {name}: no page names it" for name in sorted(used) if not re.search(rf"surveymc {name}\b|`{name}\b", text)]
    print("\n".join(faults) or f"{len(pages)} pages and configs, {commands} commands")
    sys.exit(bool(faults))


main()
