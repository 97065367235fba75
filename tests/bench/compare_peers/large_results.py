#!/usr/bin/python3
"""Large results: speed of writing against the disk's own, memory, and `show` of one row.

    large_results.py SURVEYMC [-o FOLDER] [--values 1e9] [--rows 1e6]

In turn in FOLDER (default: a new one under the present folder, removed afterwards): a streamed reliability map of about
--values numbers (configs/bench/reliability_4d.toml with a finer grid); three times a table of about --rows rows (by-source
covariances of a long survey), and the same program without these rows, so that what is left is what the rows add; `show` of
the first and last row of that table. Beside each, dd writes as many zeros and forces them to the disk, once through the page cache
(conv=fsync), as surveymc does, and once past it (oflag=direct conv=fsync). Prints elapsed and processor seconds, MB/s, and peak
resident memory of every command. Refuses where less than 20 GB would stay free.
"""
import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time

from revisions import ROOT, long_well_config

SOURCES = 35  # error sources of the model, a row each at every station


def measured(command):
    """(elapsed, processor seconds, peak MB) of a command."""
    start = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    if os.waitstatus_to_exitcode(status) not in (0, 1):
        sys.exit(f"large_results.py: {' '.join(command[:3])} failed")
    return time.monotonic() - start, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def line(name, found, size):
    elapsed, cpu, peak = found
    print(f"{name:44} {elapsed:8.1f} {cpu:8.1f} {size / 1e6 / elapsed:8.0f} {peak:8.0f}", flush=True)
    return size / elapsed


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("surveymc")
    parser.add_argument("-o", default=".", metavar="FOLDER")
    parser.add_argument("--values", type=float, default=1e9)
    parser.add_argument("--rows", type=float, default=1e6)
    a = parser.parse_args()
    program = os.path.abspath(a.surveymc)
    size = 8 * a.values
    if shutil.disk_usage(a.o).free < size + 20e9:
        sys.exit(f"large_results.py: {a.o}: would leave less than 20 GB free")
    with tempfile.TemporaryDirectory(dir=a.o) as folder:
        print(f"{'':44} {'s':>8} {'cpu s':>8} {'MB/s':>8} {'peak MB':>8}")
        zeros = os.path.join(folder, "zeros")

        def disk(bytes_):
            speeds = []
            for how, flags in (("fsync", ["conv=fsync"]), ("direct, fsync", ["oflag=direct", "conv=fsync"])):
                found = measured(["dd", "if=/dev/zero", f"of={zeros}", "bs=1M", f"count={round(bytes_ / 1048576)}", *flags,
                                  "status=none"])
                os.remove(zeros)
                speeds.append(line(f"disk (dd, {how})", found, bytes_))
            return speeds

        def share(written, speeds):
            print("share of the disk's speed: {:.2f} of dd, {:.2f} of dd past the page cache".format(*(written / s for s in speeds)))

        before = disk(size)
        output = os.path.join(folder, "map.h5")
        step = 90 / max(1, round(100 * a.values / 5e8))  # the config: 100 x 100 x 100 x 100 points of five quantities
        grid = f"inclination_deg={{ from = {step!r}, to = 90.0, step = {step!r} }}"
        found = measured([program, "run", os.path.join(ROOT, "configs/bench/reliability_4d.toml"), "--quiet", "--set",
                          grid, "-o", output])
        written = line(f"map of {a.values:.3g} values", found, os.path.getsize(output))
        share(written, before)
        os.remove(output)
        config = long_well_config(folder, int(a.rows / SOURCES))
        output, rest = os.path.join(folder, "table.h5"), os.path.join(folder, "rest.h5")
        for turn in range(3):
            found = measured([program, "run", config, "--quiet", "-o", output])
            size = os.path.getsize(output)
            without = measured([program, "run", config, "--quiet", "--set", "output.by_source=\"none\"", "-o", rest])
            added = [whole - part for whole, part in zip(found, without)]
            size_added = size - os.path.getsize(rest)
            before = disk(size)
            written = line(f"table of {a.rows:.3g} rows", found, size)
            share(written, before)
            share(line("what its rows add", added, size_added), before)
            os.remove(rest)
            if turn < 2:
                os.remove(output)
        for how in ([], ["--unchecked"]):
            line(" ".join(["show of its first and last row", *how]), measured(
                [program, "show", output, "covariance_by_source", "--rows", "2", *how]), os.path.getsize(output))


if __name__ == "__main__":
    sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../scripts"))
    from surveymc import streams
    streams.run(main)
