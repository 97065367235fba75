#!/usr/bin/python3
"""`surveymc schema` against the configs that come with the program, made-up mistakes, and `surveymc check`:
test_schema.py SURVEYMC_EXECUTABLE SOURCE_FOLDER [unittest arguments]"""
import copy
import csv
import datetime
import io
import json
import subprocess
import sys
import tempfile
import tomllib
import unittest
from pathlib import Path

import jsonschema

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
sys.path.insert(0, str(SCRIPTS))
from surveymc import toml  # noqa: E402

EXECUTABLE = SOURCE = None


def call(*arguments, **more):
    return subprocess.run([EXECUTABLE, *map(str, arguments)], capture_output=True, text=True, timeout=120, **more)


def as_json(value):
    """What an editor hands to a schema: dates are texts."""
    if isinstance(value, dict):
        return {key: as_json(v) for key, v in value.items()}
    if isinstance(value, list):
        return [as_json(v) for v in value]
    return value.isoformat() if isinstance(value, datetime.date) else value


def leaves(table, path=()):
    """Paths of all keys, those of tables in lists, too."""
    for key, value in table.items():
        yield (*path, key)
        if isinstance(value, dict):
            yield from leaves(value, (*path, key))
        elif isinstance(value, list):
            for i, element in enumerate(value):
                if isinstance(element, dict):
                    yield from leaves(element, (*path, key, i))


def without(config, path):
    left = copy.deepcopy(config)
    at = left
    for part in path[:-1]:
        at = at[part]
    del at[path[-1]]
    return left


class Schemas(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        names = [line.split()[0] for line in call("list").stdout.splitlines() if not line.startswith(" ")]
        cls.schemas = {name: json.loads(call("schema", name).stdout) for name in names}
        cls.checks = {name: jsonschema.Draft202012Validator(schema) for name, schema in cls.schemas.items()}
        cls.configs = {path: as_json(tomllib.loads(path.read_text())) for path in sorted((SOURCE / "configs").glob("*/*.toml"))
                       if path.parent.name != "error_models"}

    def faults(self, config):
        return [f"{'.'.join(map(str, e.absolute_path))}: {e.message[:200]}" for e in self.checks[config["experiment"]].iter_errors(as_json(config))]

    def is_accepted_by_program(self, config, folder):
        with tempfile.NamedTemporaryFile("w", suffix=".toml", dir=folder, prefix=".schema-") as file:
            file.write(toml.dumps(config))
            file.flush()
            return call("check", file.name).returncode == 0

    def test_they_are_schemas(self):
        for name, schema in self.schemas.items():
            jsonschema.Draft202012Validator.check_schema(schema)
            self.assertEqual(schema["properties"]["experiment"]["const"], name)
            for reference in set(self.references(schema)):
                self.assertIn(reference.removeprefix("#/$defs/"), schema["$defs"])

    def references(self, schema):
        if isinstance(schema, dict):
            for key, value in schema.items():
                if key == "$ref":
                    yield value
                else:
                    yield from self.references(value)
        elif isinstance(schema, list):
            for value in schema:
                yield from self.references(value)

    def test_every_key_is_there_with_its_meaning_and_default(self):
        for name in ("msa_position", "clearance", "tool_code_map", "mwd_drift"):  # one reader of keys serves all
            schema = self.schemas[name]
            for row in csv.DictReader(io.StringIO(call("keys", name, "--csv").stdout)):
                if row["key"] == "experiment" or row["key"].startswith("sweep."):
                    continue
                said = schema["$defs"][row["key"].replace("[]", "")]
                self.assertTrue(said["description"].startswith(row["meaning"]), row)
                if row["rule"] and "by other keys" not in row["rule"] and not row["rule"].startswith(("one of", '"')):
                    self.assertIn(row["rule"], said["description"])
                if row["unit"]:
                    self.assertIn(f"in {row['unit']}", said["description"])
                if "default" in said and row["type"] in ("number", "integer") and row["default"] != "by other keys":
                    self.assertEqual(float(row["default"].split(",")[0]), said["default"], row)

    def test_every_shipped_config_passes(self):
        self.assertGreater(len(self.configs), 100)
        for path, config in self.configs.items():
            with self.subTest(config=str(path.relative_to(SOURCE))):
                self.assertEqual(self.faults(config), [])

    def test_what_the_program_takes_passes(self):
        """Configs of `new` less each of their keys: what the program accepts without it, so does the schema."""
        accepted = refused = 0
        for path, config in self.configs.items():
            if path.parent.name != "new" or path.stem not in ("position_covariance", "msa_position", "clearance", "estimate", "mwd_drift",
                                                              "reliability_well", "vertical_well"):
                continue
            for key in leaves(config):
                fewer = without(config, key)
                if key == ("experiment",):
                    continue
                if self.is_accepted_by_program(fewer, path.parent):
                    accepted += 1
                    self.assertEqual(self.faults(fewer), [], f"{path.name} without {key}")
                else:
                    refused += bool(self.faults(fewer))
        self.assertGreater(accepted, 25)
        self.assertGreater(refused, 15)  # most keys that must be there are known to the schema

    def test_mistakes_are_refused_as_the_program_refuses_them(self):
        well = SOURCE / "configs/new/position_covariance.toml"
        msa = SOURCE / "configs/new/msa_position.toml"
        for path, change, where in [
                (well, {"fild": {"total_nT": 1.0}}, "fild"), (well, {"field": {"total_nt": 48000.0}}, "total_nt"),
                (well, {"field": {"dip_deg": 95.0}}, "field.dip_deg"), (well, {"field": {"dip_deg": "steep"}}, "field.dip_deg"),
                (well, {"field": {"total_nT": -1}}, "field.total_nT"), (well, {"survey": {"azimuth_reference": "north"}}, "survey.azimuth_reference"),
                (well, {"survey": {"file": 3}}, "survey.file"), (well, {"title": 1}, "title"), (well, {"seed": -1}, "seed"),
                (well, {"leg": {"from_md_m": 1.0}}, "leg"), (well, {"leg": [{"from_m": 450.0}]}, "from_m"),
                (well, {"sweep": {"field.dip": [60.0, 70.0]}}, "field.dip"), (well, {"sweep": {"field": {"dip_deg": []}}}, "sweep.field.dip_deg"),
                (well, {"sweep": {"field.dip_deg": {"from": 60.0, "step": 5.0}}}, "sweep.field.dip_deg"), (well, {"sweep": {"design": "zap"}}, "sweep.design"),
                (well, {"sweep": {"case": [{"field": {"dip_deg": 60.0}}]}}, "sweep.case"), (well, {"sweep": {"field.dip_deg": [60.0, 95.0]}}, "sweep.field.dip_deg"),
                (msa, {"trials": 2.5}, "trials"), (msa, {"trials": 0}, "trials"), (msa, {"estimator": "mas"}, "estimator"),
                (msa, {"sensor": {"bias_nT": [1.0, 2.0]}}, "sensor.bias_nT"), (msa, {"antithetic": "yes"}, "antithetic"),
                (msa, {"event": [{"name": "a", "quantity": "gain"}]}, "event.0.quantity"), (msa, {"event": [{"quantity": "gain_x"}]}, "event.0"),
                (msa, {"sweep": {"trials": [100, 200]}}, "trials"), (msa, {"noise": {"scale": 0.0}}, "noise.scale")]:
            config = copy.deepcopy(self.configs[path])
            for key, value in change.items():
                inner = isinstance(value, dict) and isinstance(config.get(key), dict)
                config[key] = {**config[key], **value} if inner else value
            with self.subTest(change=change):
                faults = self.faults(config)
                self.assertTrue(any(where in fault for fault in faults), faults)
                self.assertFalse(self.is_accepted_by_program(config, path.parent))

    def test_numbers_at_the_ends_of_their_ranges(self):
        """Each number of a config of `new` that has a range: the schema and the program agree on values around its ends."""
        tried = 0
        for name in ("position_covariance", "reliability_map", "msa_position"):
            path = SOURCE / f"configs/new/{name}.toml"
            definitions = self.schemas[name]["$defs"]
            for key in leaves(self.configs[path]):
                rule = definitions.get(".".join(map(str, key)), {})
                if rule.get("type") not in ("number", "integer") or isinstance(key[-1], int) or any(isinstance(part, int) for part in key):
                    continue
                ends = [(rule[word], by) for word, by in (("minimum", -1), ("maximum", 1), ("exclusiveMinimum", 0), ("exclusiveMaximum", 0)) if word in rule]
                for end, by in ends:
                    config = copy.deepcopy(self.configs[path])
                    at = config
                    for part in key[:-1]:
                        at = at[part]
                    at[key[-1]] = end + by if rule["type"] == "number" else int(end) + by
                    if key == ("seed",):
                        continue
                    self.assertTrue(self.faults(config), f"{name}: {key} = {at[key[-1]]}")
                    self.assertFalse(self.is_accepted_by_program(config, path.parent), f"{name}: {key} = {at[key[-1]]}")
                    tried += 1
        self.assertGreater(tried, 15)

    def test_new_names_it_in_its_first_line_and_writes_it(self):
        with tempfile.TemporaryDirectory() as folder:
            done = call("new", "clearance", "-o", "mine.toml", cwd=folder)
            self.assertEqual(done.returncode, 0, done.stderr)
            first = (Path(folder) / "mine.toml").read_text().splitlines()[0]
            self.assertEqual(first, "#:schema ./clearance.schema.json")
            self.assertEqual(json.loads((Path(folder) / "clearance.schema.json").read_text()), self.schemas["clearance"])

    def test_an_unknown_experiment_is_refused(self):
        done = call("schema", "clearence")
        self.assertEqual(done.returncode, 64)
        self.assertIn("did you mean clearance?", done.stderr)


if __name__ == "__main__":
    EXECUTABLE, SOURCE = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
