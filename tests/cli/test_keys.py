#!/usr/bin/python3
"""`surveymc keys` against the configs that come with the program, the documentation, and the reader itself:
test_keys.py SURVEYMC_EXECUTABLE SOURCE_FOLDER [unittest arguments]"""
import csv
import io
import os
import pty
import re
import subprocess
import sys
import tempfile
import tomllib
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "docs"))
import key_tables  # noqa: E402

EXECUTABLE = SOURCE = None


def call(*arguments, code=0, **more):
    done = subprocess.run([EXECUTABLE, *map(str, arguments)], capture_output=True, text=True, timeout=60, **more)
    if done.returncode != code:
        raise AssertionError(f"{arguments}: {done.returncode}\n{done.stderr}")
    return done.stdout if code == 0 else done.stderr


def experiments():
    return [line.split()[0] for line in call("list").splitlines() if not line.startswith(" ")]


def keys_of(experiment):
    return {row["key"]: row for row in csv.DictReader(io.StringIO(call("keys", experiment, "--csv")))}


def leaves(settings, path=""):
    """(key, value) of a config; elements of arrays of tables are alike, a sweep's keys are those that it varies."""
    for name, value in settings.items():
        key = f"{path}.{name}" if path else name
        if isinstance(value, dict):
            yield key, value
            yield from leaves(value, key)
        elif isinstance(value, list) and value and all(isinstance(v, dict) for v in value):
            yield key, value
            for element in value:
                yield from leaves(element, f"{key}[]")
        else:
            yield key, value


class Keys(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.listed = {e: keys_of(e) for e in experiments()}
        cls.configs = {}
        for path in sorted((SOURCE / "configs").glob("*/*.toml")):
            if path.parent.name != "error_models":
                cls.configs[path] = tomllib.loads(path.read_text())

    def is_listed(self, key, listed):
        """A key, its name as a string (estimator = "msa"), a table above listed keys, or a key inside a listed table."""
        if key in listed or f"{key}.name" in listed or any(k.startswith((f"{key}.", f"{key}[]")) for k in listed):
            return True
        parts = key.split(".")
        inside = [".".join(parts[:n]) for n in range(1, len(parts))]
        return any(k in listed and ("table of" in listed[k]["type"] or "{ from" in listed[k]["type"]) for k in inside)

    def test_every_experiment_has_its_list(self):
        self.assertEqual(call("keys"), call("list"))
        for experiment, listed in self.listed.items():
            self.assertGreater(len(listed), 20, experiment)
            self.assertEqual(listed["experiment"]["default"], "must be given")
        self.assertIn("did you mean msa_position?", call("keys", "msa_postion", code=64))
        self.assertIn("there are msa_position, ", call("keys", "nothing", code=64))

    def test_every_key_of_every_shipped_config_is_listed(self):
        seen = 0
        for path, config in self.configs.items():
            listed = self.listed[config["experiment"]]
            sweep = config.pop("sweep", {})
            sweep.pop("design", None)
            wanted = [key for key, _ in leaves(config)]
            for case in sweep.pop("case", []):
                wanted += [key for key, _ in leaves({k: v for k, v in case.items() if k != "name"})]
            for key, value in leaves(sweep):
                if isinstance(value, dict) and "match" in value:
                    wanted += [f"sweep.{key}.{pattern}" for pattern in value]
                elif key.split(".")[-1] not in ("match", "without"):
                    wanted.append(re.sub(r"\.(from|to|step|count|scale)$", "", key))
            for key in wanted:
                seen += 1
                self.assertTrue(self.is_listed(key, listed), f"{path.relative_to(SOURCE)}: {key} is not in: surveymc keys "
                                                             f"{config['experiment']}")
        self.assertGreater(seen, 2000)

    def test_keys_of_branches_that_no_config_takes(self):
        for experiment, key in [("msa_benefit", "field.model"), ("msa_benefit", "field.grid.zone"), ("msa_position", "stop.quantities"),
                                ("position_covariance", "sweep.error_model.name.match"), ("tool_code_map", "codes.match"), ("reliability_map", "direction"),
                                ("position_covariance", "error_model.file"), ("position_covariance", "leg[].from_md_ft"),
                                ("position_covariance", "leg[].error_model.name")]:
            self.assertIn(key, self.listed[experiment], experiment)

    def test_keys_that_only_some_wells_have(self):
        for experiment in ("clearance", "collision"):
            listed = self.listed[experiment]
            for key in ("leg[].from_md_ft", "offset[].leg[].from_md_ft", "offset[].kickoff_md_m", "offset[].depth_unit"):
                self.assertIn(key, listed, experiment)
            self.assertEqual(listed["offset[].azimuth_reference"]["default"], '"true", or needed by other keys')
        for experiment, listed in self.listed.items():
            self.assertEqual(listed.get("error_model.name", {"rule": ""})["rule"], "", experiment)  # no names of an example

    def test_what_must_be_given(self):
        listed = self.listed["msa_position"]
        self.assertEqual(listed["noise.magnetometer_nT"]["default"], "must be given")
        self.assertEqual(listed["stop.max_trials"]["default"], "needed in [stop]")
        self.assertEqual(listed["published[].values"]["default"], "needed in [[published]]")
        self.assertEqual(listed["noise.scale"]["default"], "1.0")
        self.assertEqual(listed["estimator.magnetometer_nT"]["default"], "by other keys")
        self.assertEqual(listed["trials"]["default"], "-")
        self.assertEqual(listed["field.longitude_deg"]["default"], "-")
        self.assertEqual(self.listed["mwd_drift"]["drift.at_td_mg"]["default"], "needed by other keys")
        self.assertEqual(self.listed["mwd_drift"]["drift.sensor"]["default"], "must be given")

    def test_defaults_and_limits_of_some_configs_are_not_told_of_all(self):
        default = lambda experiment, key: self.listed[experiment][key]["default"]
        for experiment in ("clearance", "collision"):
            self.assertEqual(default(experiment, "separation.formulations"), '["independent", "geomagnetic"]')
        for experiment in ("msa_position", "sensor_monte_carlo", "chained_multistation", "reliability_well"):
            self.assertEqual(default(experiment, "survey.toolface_zero"), '"y", or needed by other keys')
        self.assertEqual(default("axial_correction", "trials"), "0, or needed by other keys")
        self.assertEqual(default("drift_monitoring", "trials"), "1, or needed by other keys")
        self.assertEqual(self.listed["gross_error_detection"]["inject[].station"]["rule"], "in [0, N], N by other keys")

    def test_no_key_is_without_a_type(self):
        for experiment, listed in self.listed.items():
            for key, row in listed.items():
                self.assertTrue(row["type"], f"{experiment}: {key}")
                if key.rsplit(".", 1)[-1].endswith(("_deg", "_nT", "_mps2")):
                    self.assertEqual(row["unit"], key.rsplit("_", 1)[1])

    def test_every_key_has_a_meaning(self):
        for experiment, listed in self.listed.items():
            for key, row in listed.items():
                self.assertTrue(row["meaning"], f"{experiment}: {key}")
                self.assertNotRegex(row["meaning"], r"[A-Z][a-z]+ error:|\.$", f"{experiment}: {key}")

    def test_keys_are_printed_with_their_meaning_in_a_hundred_columns(self):
        for experiment in ("msa_benefit", "clearance", "reliability_map", "drift_monitoring", "estimate"):  # one writer for all
            listed, text = self.listed[experiment], call("keys", experiment)
            for line in text.splitlines():
                self.assertLessEqual(len(line), 100, f"{experiment}: {line}")
            blocks = {block.split("\n", 1)[0]: " ".join(block.split()) for block in re.split(r"\n(?=\S)", text)}
            self.assertEqual(list(blocks), list(listed))
            for key, row in listed.items():
                self.assertTrue(blocks[key].startswith(f"{key} {' '.join(row['meaning'].split())} {row['type']}"), blocks[key])
                self.assertIn(row["rule"], blocks[key])

    def test_what_a_study_goes_on_from_is_said_once(self):
        listed = call("list")
        self.assertIn("\n                           beyond E. Nyrnes", listed)
        self.assertNotIn("after beyond", listed)

    def test_the_page_of_keys_is_what_the_program_says(self):
        said = key_tables.page_of({experiment: key_tables.shown(listed.values()) for experiment, listed in self.listed.items()})
        self.assertEqual((SOURCE / "docs/keys.md").read_text(), said, "run tests/docs/key_tables.py build/surveymc")

    def test_every_key_that_a_page_names_is_listed(self):
        """`survey.depth_unit` in the text of a page is a key of some experiment, or a table of keys; `offset.file` is `offset[].file`."""
        plain = {key.replace("[]", "") for listed in self.listed.values() for key in listed}
        known = plain | {key.rsplit(".", n)[0] for key in plain for n in range(1, key.count(".") + 1)}
        tables = {key.split(".")[0] for key in plain if "." in key}
        tests = set(re.findall(r"NAME (\S+) ", (SOURCE / "tests/CMakeLists.txt").read_text()))
        checked = 0
        for page in [SOURCE / "README.md", *sorted((SOURCE / "docs").glob("**/*.md"))]:
            text = re.sub(r"(?ms)^```.*?^```", "", page.read_text())
            for name in re.findall(r"`([a-z_]+(?:\.\w+)+)(?: = [^`]*)?`", text):
                is_file = name.endswith((".cpp", ".csv", ".h", ".py", ".sh", ".toml", ".txt"))
                if page.name != "keys.md" and name.split(".")[0] in tables and not is_file and name not in tests:
                    checked += 1
                    self.assertIn(name, known, page.relative_to(SOURCE))
        self.assertGreater(checked, 60)

    def test_what_new_comments_out_are_keys(self):
        """Every "# key = value" of `surveymc new` is a key of the experiment."""
        tried = 0
        for experiment, listed in self.listed.items():
            names = {part for key in listed for part in re.split(r"[.\[\]]+", key)}
            for key in re.findall(r"(?m)^# (\w+) = ", call("new", experiment)):
                self.assertIn(key, names, experiment)
                tried += 1
        self.assertGreater(tried, 15)

    def test_rules_and_defaults_are_those_of_the_reader(self):
        """Each number with an interval, in a config that has it: beyond its end it is refused with the rule that is listed."""
        tried = 0
        for name in ("examples/own_well", "smoke/reliability_map", "smoke/position_covariance", "smoke/axial_correction"):
            path = SOURCE / f"configs/{name}.toml"
            config = tomllib.loads(path.read_text())
            resolved = tomllib.loads(call("check", path))
            swept = {key for key, _ in leaves(config.get("sweep", {}))}
            for key, row in self.listed[config["experiment"]].items():
                hit = re.fullmatch(r"in [(\[](\S+), (\S+)[)\]]", row["rule"])
                value = resolved
                for part in key.split("."):
                    value = value.get(part) if isinstance(value, dict) else None
                if not hit or value is None or row["type"] not in ("number", "integer") or key in swept or key == "seed":
                    continue
                beyond = float(hit[2]) * 2 + 1
                text = f"{int(beyond)}" if row["type"] == "integer" else f"{beyond!r}"
                if row["type"] == "integer" and beyond > 2**62:
                    continue
                self.assertIn(f"must be {row['rule']}", call("check", path, "--set", f"{key}={text}", code=65), key)
                tried += 1
                given = config
                for part in key.split("."):
                    given = given.get(part) if isinstance(given, dict) else None
                if given is None and row["default"] not in ("by other keys", "-", "must be given") and not row["default"].startswith("needed"):
                    self.assertEqual(float(row["default"]), float(value), f"{name}: {key}")
        self.assertGreater(tried, 40)

    def test_it_fits_a_narrow_screen(self):
        leader, follower = pty.openpty()
        import fcntl
        import struct
        import termios
        fcntl.ioctl(follower, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 60, 0, 0))
        child = subprocess.Popen([EXECUTABLE, "keys", "msa_benefit"], stdout=follower)
        os.close(follower)
        out = b""
        while True:
            try:
                piece = os.read(leader, 65536)
            except OSError:
                break
            if not piece:
                break
            out += piece
        self.assertEqual(child.wait(), 0)
        lines = out.decode().replace("\r", "").splitlines()
        self.assertIn("field.dip_deg", lines)
        self.assertLessEqual(max(len(line) for line in lines if " " in line.strip()), 60)

    def test_no_file_is_needed(self):
        with tempfile.TemporaryDirectory() as folder:
            copy = Path(folder) / "surveymc"
            copy.write_bytes(Path(EXECUTABLE).read_bytes())
            copy.chmod(0o755)
            done = subprocess.run([copy, "keys", "tool_code_map", "--csv"], cwd=folder, capture_output=True, text=True)
            self.assertEqual(done.stdout, call("keys", "tool_code_map", "--csv"))


if __name__ == "__main__":
    EXECUTABLE, SOURCE = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
