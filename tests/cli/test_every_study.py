#!/usr/bin/python3
"""Smoke configs in parts and interrupted give the results of plain runs: test_every_study.py SURVEYMC_EXECUTABLE SOURCE_FOLDER
SMOKE_RESULTS [unittest arguments]. A study that keeps something of its trials outside of what journals and parts hand on fails
here. The plain runs are those of the tests smoke.*.run. One config of each study is taken, one with [[event]], with [stop] and
with [sensitivity]; all of them with SURVEYMC_EVERY_CONFIG=1 (ctest -L nightly).
"""
import os
import re
import sys
import tomllib
import unittest
from pathlib import Path

from durability import USAGE, Case, content_hash, program_from_arguments

CONFIGS, SMOKE = [], None


class EveryStudy(Case):
    def test_parts_and_interruptions(self):
        for config in CONFIGS:
            with self.subTest(config.stem):
                self.check(config)

    def check(self, config):
        name = config.stem
        whole = content_hash(SMOKE / f"{name}.h5")
        points = int(self.call("plan", config, "--count"))
        # One by one, the last ones first; of long sweeps what is in the middle together.
        single = range(points) if points < 5 else (0, 1, points - 1)
        chosen = [*single, *([f"2:{points - 1}"] if points > len(single) else [])]
        for point in reversed(chosen):
            self.call("run", config, "--point", point, "-o", f"{name}.points/")
        self.call("merge", "-o", f"{name}.merged.h5", f"{name}.points")
        self.assertEqual(self.hash_of(f"{name}.merged.h5"), whole, "points")

        trials = int(re.search(r"(\d+) trials in all", self.call("check", config))[1])
        if trials == 0 or "[stop]" in config.read_text():
            self.call("run", config, "--shard", "0/2", "-o", f"{name}.shards/", code=USAGE, says="divide it by --point")
        else:
            for shard in (2, 0, 1):
                self.call("run", config, "--shard", f"{shard}/3", "-o", f"{name}.shards/")
            self.call("merge", "-o", f"{name}.shards.h5", f"{name}.shards")
            self.assertEqual(self.hash_of(f"{name}.shards.h5"), whole, "shards")

        self.run_until_done("run", config, "-o", f"{name}.again.h5", "--checkpoint-seconds", "0.001", "--threads", 2)
        self.assertEqual(self.hash_of(f"{name}.again.h5"), whole, "resume")
        self.assertEqual(self.journals(), [])


def chosen(configs):
    """One config of each kind, or all."""
    kinds = {}
    for path in configs:
        config = tomllib.loads(path.read_text())
        special = next((t for t in ("event", "stop", "sensitivity") if t in config), None)
        if special or config["experiment"] not in kinds:
            kinds[special or config["experiment"]] = path
    return configs if os.environ.get("SURVEYMC_EVERY_CONFIG") else list(kinds.values())


if __name__ == "__main__":
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    SMOKE = Path(sys.argv.pop(3)).resolve()
    CONFIGS = chosen(sorted((Path(sys.argv.pop(2)).resolve() / "configs/smoke").glob("*.toml")))
    program_from_arguments(__doc__)
    unittest.main()
