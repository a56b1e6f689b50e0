# SPDX-License-Identifier: MIT
"""The one campaign that tests of the program read, and how they use the program.

`python3 made.py FOLDER` makes it: simulation.json, study.json, campaign/ (4 participants, 2 activities, 8 s), results/ and report/.
`python3 made.py FOLDER reproduced` makes `trilat reproduce --scale quick`."""
import csv
import glob
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
PROGRAM = os.environ["TRILAT"]
BENCH = {"format": "trilat.simulation", "version": 1, "name": "bench", "participants": 1, "activities": [{"name": "walking", "duration_s": 0.5}],
         "rig": {"heights_m": [0.6, 2.2, 0.9]}, "wand": {"positions": 7, "hold_s": 0.7, "move_s": 0.2},
         "bench": {"places": 6, "hold_s": 0.07, "walls_m": [2], "wall_s": 0.2}}
SIMULATION = {"format": "trilat.simulation", "version": 1, "name": "made", "seed": 5, "participants": 4, "body_tracker": {},
              "activities": [{"name": "walking", "duration_s": 8}, {"name": "arm_swing", "duration_s": 8}]}
STUDY = {"format": "trilat.study", "version": 1, "kind": "accuracy", "name": "table3", "paper": "table3", "alignments": ["mean", "none"],
         "methods": [{"method": "nonlinear"}, {"method": "linear"}, {"method": "mean"}, {"method": "single", "sensors": ["k2"]}]}
CELL = ("condition", "group", "method", "alignment")
UNSETTLED = {"run.json", "hashes.json", "timings.json"}  # of the machine and of the time


def fixture(variable, make_it):
    """The folder of the fixture; where there is none, tests are run by hand and make one of their own."""
    folder = Path(os.environ.get(variable, Path(tempfile.gettempdir()) / f"{variable.lower()}_{os.getuid()}"))
    if not (folder / "report").exists():
        make_it(folder)
    return folder


def made():
    return fixture("TRILAT_MADE", make)


def reproduced():
    return fixture("TRILAT_REPRODUCED", reproduce)


def reproduce(folder):
    subprocess.run(["rm", "-rf", folder], check=True)
    trilat("reproduce", "--scale", "quick", "-o", folder)


def make(folder):
    subprocess.run(["rm", "-rf", folder], check=True)
    folder.mkdir(parents=True)
    (folder / "simulation.json").write_text(json.dumps(SIMULATION))
    (folder / "study.json").write_text(json.dumps(STUDY))
    (folder / "bench.json").write_text(json.dumps(BENCH))
    trilat("simulate", folder / "simulation.json", "-o", folder / "campaign")
    trilat("simulate", folder / "bench.json", "-o", folder / "bench")
    trilat("run", folder / "study.json", "--campaign", folder / "campaign", "-o", folder / "results")
    trilat("report", folder / "results", "-o", folder / "report", "--time", "2026-01-01")


def numbers(results, **keys):
    """Rows of numbers.csv with these keys, of all takes together unless one is named."""
    with open(Path(results) / "numbers.csv", newline="") as file:
        rows = [row for row in csv.DictReader(file) if all(row[key] == value for key, value in {"take": "", **keys}.items())]
    return [{**row, **{key: float(row[key] or "nan") for key in ("value", "low", "high", "n", "clusters")}} for row in rows]


def cells(results):
    """A dict a condition, group, method and alignment, with what is asked and answered and the mean error."""
    means = {tuple(row[key] for key in CELL): row for row in numbers(results, measure="distance", statistic="mean")}
    found = []
    for asked in numbers(results, measure="answered", statistic="share"):
        mean = means.get(tuple(asked[key] for key in CELL), {"value": None, "n": 0.0})
        found.append({**{key: asked[key] for key in CELL}, "asked": asked["n"], "answered": mean["n"], "mae_m": mean["value"]})
    return found


def ended(*words, cwd=None, env=None, largest_file=None):
    """What became of a use of the program; no file may grow beyond `largest_file` bytes, as on a full disk."""
    def limit():
        import resource
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (largest_file, largest_file))

    return subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, cwd=cwd, env=env, timeout=600, check=False,
                          stdin=subprocess.DEVNULL, preexec_fn=limit if largest_file else None)


def trilat(*words, code=0, cwd=None, env=None):
    """Runs the program; gives what it printed on both streams."""
    done = ended(*words, cwd=cwd, env=env)
    said = done.stdout + done.stderr
    assert done.returncode == code, f"{words}: exit {done.returncode}: {said}"
    return said


def stopped_with(items, output, *words, by):
    """Runs the program and stops it once so many items lie in its output; its exit code and what it said."""
    process = subprocess.Popen([PROGRAM, *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    while process.poll() is None and len(glob.glob(f"{output}/**/item.json", recursive=True)) < items:
        time.sleep(0.002)
    process.send_signal(by)
    said, _ = process.communicate(timeout=600)
    return process.returncode, said


def everything_in(folder):
    """Every file below with its bytes, every link with where it leads."""
    found = {}
    for path in sorted(Path(folder).rglob("*")):
        name = str(path.relative_to(folder))
        found[name] = os.readlink(path) if path.is_symlink() else path.read_bytes() if path.is_file() else None
    return found


def settled(folder):
    """What equal inputs give equal bytes of."""
    found = everything_in(folder)
    timed = {str(Path(name).parent / shown) for name in found if Path(name).name == "timings.json" for shown in ("tables.json", "figures.json", "item.json")}
    return {name: content for name, content in found.items() if Path(name).name not in UNSETTLED and name not in timed}


class ScratchTest(unittest.TestCase):
    maxDiff = 2000

    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = Path(holder.name)

    def written(self, name, document):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(document if isinstance(document, str) else json.dumps(document))
        return path

    def assert_same(self, one, other):
        """Both folders hold the same files with the same bytes."""
        first, second = settled(one), settled(other)
        self.assertEqual(first.keys(), second.keys())
        self.assertEqual([name for name in first if first[name] != second[name]], [])


if __name__ == "__main__":
    (reproduce if "reproduced" in sys.argv else make)(Path(sys.argv[1]))
