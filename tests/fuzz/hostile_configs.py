#!/usr/bin/python3
"""Every key of an experiment with values that nobody means: hostile_configs.py SURVEYMC SOURCE_FOLDER [--sample N] [--only TEXT]

Each key that `surveymc keys` lists gets each of VALUES, in the smoke configs of EXPERIMENTS. `check` must take the config or
refuse it with 65 and a message that names the key; what it takes must run to a documented exit code. Never a crash, an internal
error or a check without end, with memory limited. --sample N: about N of the values, evenly spread.
"""
import argparse
import csv
import io
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import tempfile

EXPERIMENTS = {"collision": ("collision", []), "msa_position": ("calibration", ["stop.max_trials=4096"])}
VALUES = ("0", "-1", "1", "0.5", "1e308", "-1e308", "5e-324", "1e-300", "1e9", "nan", "inf", "-inf", "2147483648",
          "9223372036854775807", "-9223372036854775807", "''", "'x'", "'" + "a" * 5000 + "'", "true", "1979-05-27", "[]", "[[]]", "{}",
          "[0.0]", "[1e308, 1e308, 1e308]")
DONE, UNEXPECTED, BAD_INPUT, INTERRUPTED = 0, 1, 65, 75
MEMORY = 3 << 30
PATIENCE = 120  # s


def call(*command):
    try:
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True, errors="replace", timeout=PATIENCE,
                              preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY)))
    except subprocess.TimeoutExpired:
        return "no end", ""
    return done.returncode, done.stderr


def config_with(text, key, value):
    """The config and the --set options that give the key this value; the key of an array of tables goes into its first one."""
    if "[]." not in key:
        return text, [f"{key}={value}"]
    table, name = key.split("[].", 1)
    mark = f"[[{table}]]\n"
    if mark not in text:
        text += f"\n{mark}"
    begin = text.index(mark) + len(mark)
    end = text.find("\n[", begin)
    end = end if end >= 0 else len(text)
    block = re.sub(rf"(?m)^{re.escape(name)} = .*\n", "", text[begin:end])
    return f"{text[:begin]}{name} = {value}\n{block}{text[end:]}", []


def wrong(program, folder, name, key, value, settings):
    """What is wrong with how this value is taken; nothing if nothing is."""
    config = folder / "smoke/hostile.toml"
    text, options = config_with((folder / "smoke" / f"{name}.toml").read_text(), key, value)
    config.write_text(text)
    words = [w for option in (*settings, *options) for w in ("--set", option)]
    code, said = call(program, "check", config, *words)
    if code not in (DONE, BAD_INPUT) or "internal" in said:
        return f"check: {code}: {said[-300:]}"
    if code == BAD_INPUT:
        is_named = "hostile.toml" in said or re.split(r"[.\[\]]+", key)[-1] in said
        return None if is_named else f"check: names neither file nor key: {said[-300:]}"
    if key in ("trials", "stop.max_trials"):
        return None  # as many as were asked for
    trials = [] if settings else ["--trials", 64]
    code, said = call(program, "run", config, *words, *trials, "-o", folder / "out.h5", "--overwrite", "--quiet", "--threads", 1)
    is_fine = code in (DONE, UNEXPECTED, BAD_INPUT, INTERRUPTED) and "internal" not in said
    return None if is_fine else f"run: {code}: {said[-300:]}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("surveymc")
    parser.add_argument("source")
    parser.add_argument("--sample", type=int)
    parser.add_argument("--only", default="")
    a = parser.parse_args()
    program, source = pathlib.Path(a.surveymc).resolve(), pathlib.Path(a.source)
    planned = []
    for experiment, (name, settings) in EXPERIMENTS.items():
        listed = subprocess.run([program, "keys", experiment, "--csv"], capture_output=True, text=True, check=True).stdout
        for row in csv.DictReader(io.StringIO(listed)):
            key = row["key"]
            if key != "experiment" and "KEY" not in key and key.count("[]") < 2 and a.only in key:
                planned += [(name, key, value, settings) for value in VALUES]
    wanted = min(len(planned), a.sample or len(planned))
    chosen = [planned[i * len(planned) // wanted] for i in range(wanted)]
    findings = 0
    with tempfile.TemporaryDirectory(prefix="surveymc-hostile-") as folder:
        for part in ("smoke", "calibration"):
            shutil.copytree(source / "configs" / part, pathlib.Path(folder) / part)
        for name, key, value, settings in chosen:
            if finding := wrong(program, pathlib.Path(folder), name, key, value, settings):
                findings += 1
                print(f"{name}: {key} = {value[:60]}: {finding}", flush=True)
    print(f"{len(chosen)} of {len(planned)} values, {findings} with a finding")
    sys.exit(1 if findings or not chosen else 0)


main()
