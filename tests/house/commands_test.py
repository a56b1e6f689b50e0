# SPDX-License-Identifier: MIT
"""The commands in README and docs/: the program has each verb and option, files of ours that they name exist, and what needs
neither a sensor nor somebody's files runs."""
import json
import os
import re
import shutil
import subprocess
import tempfile
import textwrap
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ["TRILAT"]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
# Blocks that run as they stand in a folder with `my-study`, by a command in them.
RUNNABLE = ("trilat init my-study", "trilat init my-recordings")


def blocks():
    """Page and text of every block of shell commands, lines that go on joined."""
    for page in PAGES:
        for block in re.findall(r"^ *```sh\n(.*?)^ *```", page.read_text(), re.DOTALL | re.MULTILINE):
            yield page.name, re.sub(r"\\\n\s*", " ", textwrap.dedent(block))


def commands():
    """Page, line, and the words behind `trilat` of each of its commands."""
    for page, block in blocks():
        text = re.sub(r"<<'(\w+)'.*?^\1$", "", block, flags=re.DOTALL | re.MULTILINE)
        for line in text.split("\n"):
            for part in re.split(r"&&|;|\|", line.split(" #")[0]):
                words = part.split()
                if words and Path(words[0]).name == "trilat":
                    yield page, line.strip(), words[1:]


class CommandsTest(unittest.TestCase):
    def test_verbs_and_options_are_ones_that_the_program_has(self):
        helps, seen = {}, 0
        for page, line, words in commands():
            verb = words[0]
            if verb.startswith("-"):
                continue
            if verb not in helps:
                asked = subprocess.run([PROGRAM, verb, "--help"], capture_output=True, text=True)
                self.assertEqual(asked.returncode, 0, f"{page}: {line}")
                helps[verb] = set(re.findall(r"(?<![\w-])--?[a-z][\w-]*", asked.stdout))
            for word in words[1:]:
                if re.fullmatch(r"--?[a-z][\w-]*(=.*)?", word):
                    self.assertIn(word.split("=")[0], helps[verb], f"{page}: {line}")
            seen += 1
        self.assertGreater(seen, 60)

    def test_there_are_blocks_of_commands(self):
        self.assertGreater(len(list(blocks())), 20)
        self.assertGreater(len(list(commands())), 40)

    def test_files_of_ours_that_are_named_exist(self):
        for page, block in blocks():
            for path in re.findall(r"(?<![\w/.])(?:scripts|pipeline|python|tests)/[\w./-]*\w", block):
                self.assertTrue((ROOT / path).exists(), f"{page}: {path}")

    def run_block(self, folder, page, block):
        environment = os.environ | {"PATH": f"{Path(PROGRAM).parent}:{os.environ['PATH']}"}
        done = subprocess.run(["bash", "-euo", "pipefail", "-c", block], cwd=folder, env=environment, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, f"{page}:\n{block}\n{done.stderr}")

    def test_the_first_tutorial_runs(self):
        with tempfile.TemporaryDirectory() as name:
            for page, block in blocks():
                if page == "first_table.md":
                    self.run_block(name, page, block)
            self.assertGreater((Path(name) / "report/report.html").stat().st_size, 10_000)

    def test_blocks_about_own_recordings_run(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            (folder / "simulation.json").write_text(json.dumps({
                "format": "trilat.simulation", "version": 1, "participants": 2, "activities": [{"name": "walking", "duration_s": 6}]}))
            subprocess.run([PROGRAM, "simulate", "simulation.json", "-o", "made"], cwd=folder, check=True, capture_output=True)
            for study, with_mocap in (("my-study", True), ("my-recordings", False)):
                (folder / study).mkdir()
                shutil.copy(folder / "made/calibration.json", folder / study)
                for participant in ("p01", "p02"):
                    (folder / study / participant).mkdir()
                    for file, called in (("session.h5", "walking.h5"), ("mocap.csv", "walking.csv"))[:2 if with_mocap else 1]:
                        shutil.copy(folder / f"made/{participant}-walking/{file}", folder / study / participant / called)
            ran = 0
            for page, block in blocks():
                if not any(command in block for command in RUNNABLE):
                    continue
                for output in ("results", "report", *(f"{study}/{file}" for study in ("my-study", "my-recordings")
                                                      for file in ("campaign.json", "study.json", "mapping.json"))):
                    target = folder / output
                    shutil.rmtree(target) if target.is_dir() else target.unlink(missing_ok=True)
                self.run_block(folder, page, block)
                self.assertTrue((folder / "report/report.html").stat().st_size > 10_000, page)
                ran += 1
            self.assertEqual(ran, 3)


if __name__ == "__main__":
    unittest.main()
