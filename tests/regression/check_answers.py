#!/usr/bin/env python3
"""Every number of an answer is in a table of its result, where the answer says: check_answers.py RESULT...
With --every PROGRAM CONFIGS: of every config in this folder, with few trials."""

import functools
import pathlib
import re
import subprocess
import sys
import tempfile

import h5py

LONGEST_S = 120  # for a config, with few trials
NUMBER = re.compile(r"(?<![\w.+/-])-?(?:\d+(?:\.\d+)?(?:e-?\d+)?|infinite)(?![\w/-]|\.\d)")
CELL = re.compile(r"(?P<table>\w+)\.(?P<column>.+)\[(?P<row>\d+)\]")
COUNT = re.compile(r"count (?P<table>\w+)(?: where (?P<conditions>.*))?")


@functools.lru_cache(64)
def values_of(file, table, column):
    data = file["tables"][table][column]
    return data.asstr()[()] if h5py.check_string_dtype(data.dtype) else data[()]


def meets(file, table, row, condition):
    """Whether a row of a table meets a condition of a source (lib/compare/answer.h)."""
    if condition.endswith(" finite"):
        column = condition.removesuffix(" finite")
        return column in file["tables"][table] and abs(values_of(file, table, column)[row]) < float("inf")
    if between := re.fullmatch(r"(.+) in (.+)\.\.(.+)", condition):
        return float(between[2]) <= values_of(file, table, between[1])[row] <= float(between[3])
    column, sign, word = re.fullmatch(r"(.+?) (!?=) (.*)", condition + ("" if "= " in condition else " ")).groups()
    has = column in file["tables"][table] and values_of(file, table, column)[row] == word
    return has if sign == "=" else not has


def number_at(file, source):
    """The number that a source names."""
    if factor := re.fullmatch(r"(.*) \* (\S+)", source):
        return number_at(file, factor[1]) * float(factor[2])
    if cell := CELL.fullmatch(source):
        return float(values_of(file, cell["table"], cell["column"])[int(cell["row"])])
    counted = COUNT.fullmatch(source)
    assert counted, source
    rows = len(file["tables"][counted["table"]]["row"])
    conditions = counted["conditions"].split(" and ") if counted["conditions"] else []
    return sum(all(meets(file, counted["table"], row, c) for c in conditions) for row in range(rows))


def three_digits(value):
    """As lib/compare/answer.h writes a number."""
    if value in (float("inf"), float("-inf")):
        return "infinite" if value > 0 else "-infinite"
    if 100 <= abs(value) < 1e9:
        return f"{value:.0f}"
    text = f"{value:.3g}"
    mantissa, e, power = text.partition("e")
    return f"{mantissa}e{int(power)}" if e and not 1e-4 <= abs(value) < 1e9 else text


def agrees(text, value):
    """Whether a text is the value with three digits, or an angle with two decimals."""
    return text in (three_digits(value), f"{value:.2f}")


def faults_of(path):
    """What is wrong with the answer of a result."""
    with h5py.File(path) as file:
        if "answer" not in file["tables"]:
            return [f"{path}: has no answer"]
        table = file["tables"]["answer"]
        found = []
        for sentence, sources in zip(table["sentence"].asstr()[()], table["sources"].asstr()[()]):
            named = [s for s in sources.split("; ") if s]
            words = re.sub(r'"[^"]*"', "", sentence)
            for name in sorted({w for name, t in file["tables"].items() if name not in ("answer", "warnings") for c in t.values()
                                if h5py.check_string_dtype(c.dtype) for w in c.asstr()[()][:20000]}, key=len, reverse=True):
                if re.search(r"\d", name) and re.search(r"[A-Za-z]", name) and name != sentence and name in words:
                    words = words.replace(name, "")  # a name with a number in it
            for key in {f"{column} = {w}" for name, t in file["tables"].items() if name not in ("answer", "warnings") for column, c in t.items()
                        if h5py.check_string_dtype(c.dtype) for w in c.asstr()[()][:20000] if w.isdigit()}:
                words = words.replace(key, "")  # the point of a sweep whose values are words of digits
            numbers = NUMBER.findall(words)
            if len(numbers) != len(named):
                found.append(f"{path}: {len(numbers)} numbers {numbers}, {len(named)} sources: {sentence}")
                continue
            for text, source in zip(numbers, named):
                value = number_at(file, source)
                if not agrees(text, value):
                    found.append(f"{path}: {text} is not {value}, which is {source}: {sentence}")
        return found


def results_of_every_config(program, configs, folder):
    for config in sorted(pathlib.Path(configs).rglob("*.toml")):
        if not re.search(r"(?m)^experiment *=", config.read_text()):
            continue
        result = pathlib.Path(folder) / f"{config.parent.name}_{config.stem}.h5"
        few = ["--trials", "600"] if re.search(r"(?m)^trials *=", config.read_text()) else []
        try:
            done = subprocess.run([program, "run", config, "-o", result, "-q", *few], capture_output=True, text=True, timeout=LONGEST_S)
        except subprocess.TimeoutExpired:
            print(f"{config}: left out: takes more than {LONGEST_S} s with few trials")
            continue
        if done.returncode:
            print(f"{config}: {done.stderr.strip()}")  # says why: some configs want more trials
        else:
            yield result


def main(arguments):
    with tempfile.TemporaryDirectory(prefix="surveymc-answers-") as folder:
        results = results_of_every_config(*arguments[1:], folder) if arguments[:1] == ["--every"] else arguments
        count, faults = 0, []
        for path in results:
            count += 1
            faults += faults_of(path)
    print("\n".join(faults))
    print(f"{count} answers, {len(faults)} faults")
    return bool(faults) or not count


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
