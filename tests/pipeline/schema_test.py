# SPDX-License-Identifier: MIT
"""`trilat schema` against the documents that are shipped, against what the program refuses, and against the
reference that was made from it. Usage: schema_test.py TRILAT"""

import copy
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import jsonschema

ROOT = pathlib.Path(__file__).resolve().parents[2]
TRILAT = sys.argv.pop()
DOCUMENTS = ["study", "simulation", "campaign", "mapping", "calibration"]
OF_FORMAT = {f"trilat.{name}": name for name in DOCUMENTS}


def trilat(*arguments):
    return subprocess.run([TRILAT, *arguments], capture_output=True, text=True)


def schema_of(name):
    return json.loads(trilat("schema", name).stdout)


def objects_in(schema):
    """The schema of every object, by its pointer."""
    if isinstance(schema, list):
        for part in schema:
            yield from objects_in(part)
    elif isinstance(schema, dict):
        if isinstance(schema.get("properties"), dict):
            yield schema
        for part in schema.values():
            yield from objects_in(part)


def shipped_documents():
    for path in sorted((ROOT / "pipeline" / "studies").glob("*.json")):
        yield path.name, json.loads(path.read_text())
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]:
        for number, block in enumerate(re.findall(r"```json\n(.*?)```", page.read_text(), re.S)):
            document = json.loads(block)
            if "format" in document:
                yield f"{page.name} block {number}", document


class Schemas(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.schemas = {name: schema_of(name) for name in DOCUMENTS}

    def test_every_shipped_document_is_valid(self):
        seen = set()
        for name, document in shipped_documents():
            kind = OF_FORMAT[document["format"]]
            seen.add(kind)
            with self.subTest(name):
                jsonschema.Draft202012Validator(self.schemas[kind]).validate(document)
                document["no_such_key"] = 1
                with self.assertRaises(jsonschema.ValidationError):
                    jsonschema.validate(document, self.schemas[kind])
        self.assertGreaterEqual(seen, {"study", "simulation"})

    def test_every_key_says_what_it_means_and_has_a_valid_default(self):
        for name, schema in self.schemas.items():
            jsonschema.Draft202012Validator.check_schema(schema)
            for one in objects_in(schema):
                for key, value in one["properties"].items():
                    with self.subTest(document=name, key=key):
                        if "default" in value and key != "campaign":
                            jsonschema.validate(value["default"], value)
                        self.assertTrue({"type", "const", "oneOf", "enum"} & value.keys())
                        explains_itself = key in ("format", "version", "kind") or {"trunk", "head"} & set(
                            one["properties"]
                        )
                        self.assertTrue(explains_itself or value.get("description"))

    def test_the_program_refuses_what_lies_beyond_a_range(self):
        refused = 0
        examples = {d["kind"]: d for _, d in shipped_documents() if d["format"] == "trilat.study"}
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "study.json"
            for schema in self.schemas["study"]["oneOf"]:
                example = copy.deepcopy(examples[schema["properties"]["kind"]["enum"][0]])
                for key, value in schema["properties"].items():
                    if "maximum" not in value:
                        continue
                    path.write_text(json.dumps({**example, key: value["maximum"] * 2 + 1}))
                    said = trilat("run", str(path), "--dry-run")
                    self.assertEqual(said.returncode, 2, key)
                    self.assertIn(f"/{key}: must", said.stderr)
                    refused += 1
        self.assertGreater(refused, 30)

    def test_the_reference_is_current(self):
        self.assertEqual(
            (ROOT / "docs/reference/keys.md").read_text(),
            trilat("schema", "--markdown").stdout,
            "renew it: build/release/trilat schema --markdown > docs/reference/keys.md",
        )

    def test_an_unknown_document_is_refused_with_those_known(self):
        said = trilat("schema", "nope")
        self.assertEqual(said.returncode, 2)
        self.assertIn("known are: " + ", ".join(DOCUMENTS), said.stderr)


if __name__ == "__main__":
    unittest.main()
