# SPDX-License-Identifier: MIT
"""What the program is asked to do while system calls fail: commands, and the folders that they begin with."""
import collections
import hashlib
import json
import os
import shutil
import subprocess
import sys

LIMIT_S = 60  # a run takes less than one
# Files that tell of a run and not of its results: times, places, machines.
VOLATILE = {"run.json", "hashes.json", "accepted.json", "history.csv", "timings.json"}
TIMED = {"tables.json", "figures.json", "item.json", "sweep.csv"}  # of a sweep these hold times too


SIMULATION = {"format": "trilat.simulation", "version": 1, "name": "small", "participants": 2, "body_tracker": {},
              "activities": [{"name": "walking", "duration_s": 1}]}
STUDY = {"format": "trilat.study", "version": 1, "kind": "accuracy", "name": "small", "alignments": ["mean"],
         "methods": [{"method": "linear"}, {"method": "mean"}]}
SWEEP = {"format": "trilat.study", "version": 1, "kind": "threshold_sweep", "name": "sweep", "seed": 1,
         "rigs": [{"name": "mine", "heights_m": [0.6, 2.2, 0.9, 1.9], "radius_m": 2.0}], "vary": {"threshold": [1, 1e-4], "error_cm": [[0, 5]]},
         "trials": 200}

Scenario = collections.namedtuple("Scenario", "name command inputs finished", defaults=("",))
RUN = "run study.json --campaign campaign -o out --threads 1"
# `inputs`: what the folder holds before, out of the stock; NAME=AS renames. `finished`: the file that comes last and says
# that a folder is whole; nothing: the output appears at once.
SCENARIOS = [
    Scenario("record", "record --source synthetic:1 --duration-s 0.7 -o out --json", ""),
    Scenario("recover", "recover out", "killed=out.trilog"),
    Scenario("simulate", "simulate simulation.json -o out", "simulation.json", "campaign.json"),
    Scenario("run", RUN, "study.json campaign", "summary.json"),
    Scenario("run over older", RUN, "study.json campaign older=out", "summary.json"),
    Scenario("run --shard", RUN + " --shard 1/2", "study.json campaign", "summary.json"),
    Scenario("run, resumed", RUN, "study.json campaign shard=out", "summary.json"),
    Scenario("sweep", "run sweep.json -o out --threads 1", "sweep.json", "summary.json"),
    Scenario("sweep, resumed", "run sweep.json -o out --threads 1", "sweep.json sweep_shard=out", "summary.json"),
    Scenario("report", "report results -o out --time then", "results", "no file"),
    Scenario("report: gnuplot", "report results -o out --time then", "results", "no file"),
    Scenario("gate --accept", "gate results --baseline out --accept better", "results older=out"),
]


def environment(folder):
    """The program's figures are drawn in the folder too."""
    (folder / "tmp").mkdir(exist_ok=True)
    return {**os.environ, "TMPDIR": str(folder / "tmp"), "LC_ALL": "C"}


def run(program, command, folder, before=(), extra=None):
    """Its exit code (negative: a signal; None: it hung), stdout and stderr."""
    # pylint: disable=consider-using-with
    process = subprocess.Popen([*before, program, *command.split()], cwd=folder, text=True, errors="replace",
                               stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                               env={**environment(folder), **(extra or {})}, start_new_session=True)
    try:
        out, err = process.communicate(timeout=LIMIT_S)
        return process.returncode, out, err
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, 9)
        process.communicate()
        return None, "", ""


def must(program, command, folder, before=()):
    code, _, err = run(program, command, folder, before)
    if code != 0:
        sys.exit(f"inject_faults: `{command}` ends with {code} without any fault: {err}")


def stock(program, folder):
    """Everything that a scenario may begin with."""
    folder.mkdir()
    for name, document in (("simulation", SIMULATION), ("study", STUDY), ("sweep", SWEEP),
                           ("other", {**STUDY})):
        (folder / f"{name}.json").write_text(json.dumps(document))
    must(program, "simulate simulation.json -o campaign", folder)
    must(program, "run study.json --campaign campaign -o shard --shard 1/2", folder)
    must(program, "run sweep.json -o sweep_shard --shard 1/1", folder)
    must(program, "run study.json --campaign campaign -o results", folder)
    must(program, "run other.json --campaign campaign -o older", folder)
    run(program, "record --source synthetic:2 --duration-s 9 -o killed", folder,
        ["timeout", "-s", "KILL", "3"])
    (folder / "killed.trilog").rename(folder / "killed")


def prepare(scenario, stock_folder, folder):
    folder.mkdir()
    for entry in scenario.inputs.split():
        name, _, other = entry.partition("=")
        source = stock_folder / name
        (shutil.copytree if source.is_dir() else shutil.copy2)(source, folder / (other or name))


def files_of(scenario, path):
    """What lies there, by name: its hash."""
    volatile = VOLATILE | TIMED if scenario.name.startswith("sweep") else VOLATILE
    found = {}
    for file in sorted([path, *path.rglob("*")]) if path.exists() else []:
        if file.is_file():
            data = b"" if file.name in volatile else file.read_bytes()
            found[str(file.relative_to(path))] = hashlib.sha256(data).hexdigest()
    return found
