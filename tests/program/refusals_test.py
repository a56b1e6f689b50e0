# SPDX-License-Identifier: MIT
"""What the program refuses in its documents: ranges, types and unknown keys as `trilat schema` says them, all of them; and what no schema
says, as refusals.json has it. And that all documents that are shipped are what the schemas say."""
import copy
import json
import re
import shutil
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import jsonschema

from engine_test import STUDIES, WALK
from made import SOURCE, ScratchTest, ended, made, trilat

DOCUMENTS = ["study", "simulation", "campaign", "mapping", "calibration"]
SIMULATION = {**WALK, "seed": 1, "stature_m": {"mean": 1.7, "half_range": 0.1}, "rig": {"radius_m": 2.0, "heights_m": [1.0, 2.0, 1.0]},
              "sensor": {"rate_hz": 30, "nearest_m": 0.5, "farthest_m": 4.5}, "mocap": {"rate_hz": 100}, "body_tracker": {"lag_s": 0.01},
              "depth": {"takes": False}, "wand": {"positions": 5}}


def patched(document, change):
    """JSON merge patch (RFC 7386)."""
    if not isinstance(change, dict) or not isinstance(document, dict):
        return change
    result = dict(document)
    for key, value in change.items():
        if value is None:
            result.pop(key, None)
        else:
            result[key] = patched(result.get(key, {}), value)
    return result


def branch_of(schema, value):
    """That of several schemas whose fixed texts the value has."""
    if "oneOf" not in schema:
        return schema
    def fits(one):
        for key, part in one.get("properties", {}).items():
            known = [part["const"]] if "const" in part else part.get("enum", [])
            if len(known) == 1 and value.get(key) not in (known[0], None):
                return False
        return one.get("type") == "object"

    return next((one for one in schema["oneOf"] if isinstance(value, dict) and fits(one)), {})


def with_at(document, path, value):
    result = copy.deepcopy(document)
    inner = result
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = value
    return result


def wrong_values(schema):
    kind = schema.get("type")
    if "minimum" in schema:
        yield schema["minimum"] - (1 if kind == "integer" else 1e-3 * abs(schema["minimum"]) + 1e-3)
    if "exclusiveMinimum" in schema:
        yield schema["exclusiveMinimum"]
    if "maximum" in schema:
        yield schema["maximum"] + (1 if kind == "integer" else 1e-3 * abs(schema["maximum"]) + 1e-3)
    if kind in ("number", "integer", "boolean", "object", "array"):
        yield "a text"
    if kind == "string":
        yield 7
        if "enum" in schema:
            yield "no such name"
    if kind == "integer":
        yield 1.5


def changes(schema, value, document, path=()):
    """(pointer, document with one thing wrong) for every key that the schema knows of, where the document has its object."""
    schema = branch_of(schema, value)
    if isinstance(value, dict) and "properties" in schema:
        yield "/".join(("", *map(str, path), "no_such_key")), with_at(document, (*path, "no_such_key"), 1)
        for key, part in schema["properties"].items():
            if key == "$schema":
                continue
            for wrong in wrong_values(part):
                yield "/".join(("", *map(str, (*path, key)))), with_at(document, (*path, key), wrong)
            if key in value:
                yield from changes(part, value[key], document, (*path, key))
    elif isinstance(value, list) and isinstance(schema.get("items"), dict):
        for k, item in enumerate(value[:1]):
            yield from changes(schema["items"], item, document, (*path, k))


def limits_of(schema, place):
    """ "study/rate_hz: exclusiveMinimum 0, maximum 1000, default 30.0" of each key that has any."""
    said = [f"{key} {json.dumps(schema[key])}" for key in ("minimum", "exclusiveMinimum", "maximum", "minItems", "maxItems", "maxLength", "default")
            if key in schema]
    if said:
        yield f"{place}: {', '.join(said)}"
    if "minimum" not in schema:  # else its keys are as itself
        for key, part in schema.get("properties", {}).items():
            yield from limits_of(part, f"{place}/{key}")
    for part in [schema["items"]] if isinstance(schema.get("items"), dict) else schema.get("oneOf", []):
        yield from limits_of(part, place)


def shipped_documents():
    for path in sorted((SOURCE / "pipeline/studies").glob("*.json")):
        document = json.loads(path.read_text())
        document.pop("scales", None)  # of `trilat reproduce`
        yield path.name, document
    for page in [SOURCE / "README.md", SOURCE / "datasets/FORMATS.md", *sorted((SOURCE / "docs").rglob("*.md"))]:
        for number, block in enumerate(re.findall(r"```json\n(.*?)```", page.read_text(), re.S)):
            if "…" in block:
                continue  # something is left out
            document = json.loads(block)
            if isinstance(document, dict) and document.get("format", "").removeprefix("trilat.") in DOCUMENTS:
                yield f"{page.name} block {number}", document


class Refusals(ScratchTest):
    @classmethod
    def setUpClass(cls):
        cls.schemas = {name: json.loads(trilat("schema", name)) for name in DOCUMENTS}
        first = made() / "campaign/p01-walking"
        cls.documents = {
            **{kind: {"format": "trilat.study", "version": 1, "kind": kind, "name": "tiny", **study} for kind, study in STUDIES.items()},
            "simulation": SIMULATION,
            "campaign": json.loads((made() / "campaign/campaign.json").read_text()),
            "calibration": json.loads((made() / "campaign/calibration.json").read_text()),
            "mapping": json.loads((first / "mapping.json").read_text())}

    def setUp(self):
        super().setUp()
        shutil.copytree(made() / "campaign", self.folder / "campaign")
        self.written("walk.json", WALK)
        self.study = self.written("mean.json", {"format": "trilat.study", "version": 1, "kind": "accuracy", "name": "mean",
                                                "methods": [{"method": "mean"}]})

    def use(self, number, name, document):
        """What the program says of a document where a user would give it."""
        if name == "mapping":
            campaign = copy.deepcopy(self.documents["campaign"])
            campaign["takes"] = [take for take in campaign["takes"] if take["activity"] == "walking"]
            for take in campaign["takes"]:
                take["mapping"] = f"{number}.json"
            self.written(f"campaign/{number}.json", document)
            return ended("run", self.study, "--campaign", self.written(f"campaign/of{number}.json", campaign), "--dry-run")
        folder = "campaign" if name == "campaign" else "."
        path = self.written(f"{folder}/{number}.json", document)
        if name == "simulation":
            return ended("simulate", path, "-o", self.folder / f"out{number}")
        if name == "campaign":
            return ended("run", self.study, "--campaign", path, "--dry-run")
        if name == "calibration":
            return ended("run", self.study, "--campaign", self.folder / "campaign", "--calibration", path, "--dry-run")
        return ended("run", path, "--dry-run")

    def refuse_all(self, cases):
        """Checks that the program ends with 2 and names the place. A case is (name of the document, document, message)."""
        with ThreadPoolExecutor(3) as pool:
            for (name, document, says), done in zip(cases, pool.map(lambda k: self.use(k, *cases[k][:2]), range(len(cases)))):
                with self.subTest(document=name, says=says):
                    self.assertEqual(done.returncode, 2, done.stdout[-300:] + done.stderr)
                    self.assertIn(says, done.stderr)

    def test_ranges_types_and_unknown_keys_are_refused_at_their_place(self):
        cases = []
        for name, document in self.documents.items():
            schema = self.schemas[name if name in DOCUMENTS else "study"]
            cases += [(name, wrong, pointer) for pointer, wrong in changes(schema, document, document)]
        self.assertGreater(len(cases), 380)
        self.refuse_all(cases)

    def test_limits_and_defaults_are_those_of_the_list(self):
        """A limit or default that moves changes what users may write, or their results: limits.txt is changed with it, by hand."""
        listed = (Path(__file__).parent / "limits.txt").read_text().splitlines()
        found = {line for name, schema in self.schemas.items() for line in limits_of(schema, name)}
        self.assertEqual(sorted(found - set(listed)), [], "not in the list")
        self.assertEqual(sorted(set(listed) - found), [], "in the list alone")

    def test_what_no_schema_says_is_refused_at_its_place(self):
        cases = json.loads((Path(__file__).parent / "refusals.json").read_text())["cases"]
        self.refuse_all([(name, patched(self.documents[name], change), says) for name, change, says in cases])

    def test_the_documents_that_are_changed_are_themselves_good(self):
        for number, (name, document) in enumerate(self.documents.items()):
            with self.subTest(name):
                jsonschema.validate(document, self.schemas[name if name in DOCUMENTS else "study"])
                self.assertEqual(self.use(f"good{number}", name, document).returncode, 0)

    def test_a_key_that_stands_twice_is_refused(self):
        path = self.written("twice.json", '{"format": "trilat.study", "version": 1, "kind": "accuracy", "name": "x", "rate_hz": 30, "rate_hz": 60}')
        self.assertIn('has the key "rate_hz" twice', ended("run", path, "--dry-run").stderr)

    def test_every_shipped_document_is_valid(self):
        seen = set()
        for name, document in shipped_documents():
            kind = document["format"].removeprefix("trilat.")
            seen.add(kind)
            with self.subTest(name):
                jsonschema.Draft202012Validator(self.schemas[kind]).validate(document)
                with self.assertRaises(jsonschema.ValidationError):
                    jsonschema.validate({**document, "no_such_key": 1}, self.schemas[kind])
        self.assertGreaterEqual(seen, set(DOCUMENTS) - {"calibration"})

    def test_every_key_says_what_it_means_and_has_a_valid_default(self):
        def objects_in(schema):
            for part in schema if isinstance(schema, list) else schema.values() if isinstance(schema, dict) else ():
                yield from objects_in(part)
            if isinstance(schema, dict) and isinstance(schema.get("properties"), dict):
                yield schema

        self.assertGreater(sum(len(one["properties"]) for schema in self.schemas.values() for one in objects_in(schema)), 100)
        for name, schema in self.schemas.items():
            jsonschema.Draft202012Validator.check_schema(schema)
            for one in objects_in(schema):
                for key, value in one["properties"].items():
                    with self.subTest(document=name, key=key):
                        if "default" in value and key != "campaign":
                            jsonschema.validate(value["default"], value)
                        self.assertTrue({"type", "const", "oneOf", "enum"} & value.keys())
                        named = key in ("format", "version", "kind") or {"trunk", "head"} & set(one["properties"])
                        self.assertTrue(named or value.get("description"))


if __name__ == "__main__":
    unittest.main(verbosity=2)
