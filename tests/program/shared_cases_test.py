# SPDX-License-Identifier: MIT
"""Inputs after public bug reports, in ../shared/data/cases where that is there: each gives what its `expect` says."""
import gzip
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

SOURCE = Path(__file__).resolve().parents[2]
CASES = SOURCE.parent / "shared/data/cases"
EXPECTED = json.loads((Path(__file__).parent / "shared_cases.json").read_text())


def rotation_of(q):
    x, y, z, w = q
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def poses_beside_first(calibration):
    """(rotation, position in metres) of each sensor in the frame of k1."""
    poses = {s["name"]: (rotation_of(s["rotation_xyzw"]), np.array(s["position_m"])) for s in calibration["sensors"]}
    r1, p1 = poses["k1"]
    return {name: (r1.T @ r, r1.T @ (p - p1)) for name, (r, p) in poses.items()}


def copied(name, scratch):
    """The case in a folder of its own, its study without the key that studies have no more."""
    folder = Path(scratch) / "case"
    shutil.copytree(CASES / name, folder)
    if (study := folder / "study.json").exists():
        document = json.loads(study.read_text())
        document.pop("resamples", None)
        study.write_text(json.dumps(document))
    return folder


class SharedCases(unittest.TestCase):
    def check(self, name):
        case, expected = CASES / name, EXPECTED[name]
        with tempfile.TemporaryDirectory() as scratch:
            env = {**os.environ, "TRILAT_PYTHON": str(SOURCE / "python"), "TMPDIR": scratch, "LC_ALL": "C.UTF-8"}
            script = (case / "cmd").read_text().replace('"$T" mocap ', '"$T" info ')  # today's name of the verb
            for old, new in expected.get("instead", {}).items():  # what speaks the protocol of 0.4.0, or asks for faults
                self.assertIn(old, script)
                script = script.replace(old, new.replace("OTHER", str(SOURCE / "tests/recorders/other_version.py")))
            ended = subprocess.run(["sh", "-c", script], cwd=copied(name, scratch), env=env, text=True, stdout=subprocess.PIPE,
                                   stderr=subprocess.STDOUT, timeout=300, check=False)
        said = ended.stdout
        exits = [int(code) for code in re.findall(r"^exit (\d+)$", said, re.M)]
        self.assertEqual(exits, expected["exits"], said)
        for text in expected["said"]:
            self.assertIn(text, said)
        for text in expected.get("not_said", []):
            self.assertNotIn(text, said)
        for method, most_cm in expected.get("most_cm", {}).items():
            self.assertLess(self.largest_cm(said, method), most_cm, said)
        if expected.get("check") == "poses":
            self.check_poses(said, json.loads((case / "truth.json").read_text()))

    def largest_cm(self, said, method):
        """The largest error of a method in the table that `run` prints."""
        lines = said.splitlines()
        start = next(n for n, line in enumerate(lines) if line.startswith("method "))
        row = next(line for line in lines[start:] if line.split() and line.split()[0] == method)
        cells = dict(zip(re.split(r"\s{2,}", lines[start]), re.split(r"\s{2,}", row), strict=True))
        return max(float(cell.split()[0]) for head, cell in cells.items() if head.endswith("(cm)"))

    def check_poses(self, said, truth):
        found = poses_beside_first(json.loads(said[said.index("{\n"):said.rindex("}") + 1]))
        for name, (rotation, position_m) in poses_beside_first(truth).items():
            turn = np.degrees(np.arccos(np.clip((np.trace(found[name][0].T @ rotation) - 1) / 2, -1, 1)))
            self.assertLess(turn, 0.3, name)
            self.assertLess(np.linalg.norm(found[name][1] - position_m), 0.015, name)


    def converted(self, name, folder, *options, code=0):
        """What the converter says of a case's C3D, which becomes folder/m.csv."""
        source = folder / "m.c3d"
        case = CASES / name / "m.c3d"
        source.write_bytes(case.read_bytes() if case.exists() else gzip.decompress(case.with_suffix(".c3d.gz").read_bytes()))
        ended = subprocess.run([sys.executable, "-B", "-m", "trilat.convert", "c3d", source, "-o", folder / "m.csv", "--force", *options],
                               env={**os.environ, "PYTHONPATH": str(SOURCE / "python")}, capture_output=True, text=True, check=False)
        self.assertEqual(ended.returncode, code, ended.stderr)
        return ended.stdout + ended.stderr

    def test_c3d(self):
        cases = {"c3d-70000-frames-clamped": (["--up-axis", "y"], 0, "70000 frames from 1"),
                 "c3d-data-start-zero": ([], 0, "200 frames from 1 at 50 Hz, 6 markers in mm, y up"),
                 "c3d-doubled-names-proposal": ([], 0, "LKNE stands twice: LKNE#5, LKNE#11"),
                 "c3d-moments-beyond-100m": ([], 0, "200 frames from 1 at 50 Hz, 6 markers in mm, y up"),
                 "c3d-scale-of-header": ([], 2, "the scale is 0.0551 in the header (block 1, words 7 and 8) and 0.0215 in POINT:SCALE"),
                 "c3d-unit-cut-to-mete": ([], 0, "6 markers in m, y up"),
                 "c3d-up-by-unlabelled": ([], 0, "6 markers in mm, z up")}
        for name, (options, code, said) in cases.items():
            with self.subTest(name), tempfile.TemporaryDirectory() as scratch:
                self.assertIn(said, self.converted(name, Path(scratch), *options, code=code))

    def test_c3d_analog_words_of_header(self):
        name = "c3d-analog-words-of-header"
        with tempfile.TemporaryDirectory() as scratch:
            folder = copied(name, scratch)
            words = [os.environ["TRILAT"], "run", folder / "study.json", "--campaign", folder, "-o", folder / "results"]
            ended = subprocess.run(words, capture_output=True, text=True, check=False)
            self.assertIn(f"m.c3d: is C3D; python3 -m trilat.convert c3d {folder}/m.c3d -o {folder}/m.csv", ended.stdout + ended.stderr)
            self.assertIn("ANALOG states 112", self.converted(name, folder))
            campaign = json.loads((folder / "campaign.json").read_text())
            campaign["takes"][0]["mocap"] = "m.csv"
            (folder / "campaign.json").write_text(json.dumps(campaign))
            ended = subprocess.run(words, capture_output=True, text=True, check=False)
            self.assertEqual(ended.returncode, 0, ended.stderr)
            self.assertLess(self.largest_cm(ended.stdout, "mean"), 2.0)


def add_cases():
    for name in EXPECTED:
        def test(self, name=name):
            self.check(name)
        setattr(SharedCases, "test_" + name.replace("-", "_"), test)


add_cases()

if __name__ == "__main__":
    if not CASES.is_dir():
        print(f"skipped: {CASES} is not there")
        sys.exit(77)
    unittest.main(verbosity=2)
