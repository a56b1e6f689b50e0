# SPDX-License-Identifier: MIT
"""What the program is asked to do while system calls fail: commands, and the folders that they begin with."""
import collections
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys

LIMIT_S = 60  # a run takes less than one
# Files that tell of a run and not of its results: times, places, machines.
VOLATILE = {"run.json", "hashes.json", "accepted.json", "history.jsonl"}


SIMULATION = {"format": "trilat.simulation", "version": 1, "name": "small", "participants": 2, "body_tracker": {},
              "activities": [{"name": "walking", "duration_s": 1}]}
STUDY = {"format": "trilat.study", "version": 1, "kind": "accuracy", "name": "small", "alignments": ["mean"],
         "resamples": 200, "methods": [{"method": "linear"}, {"method": "mean"}]}
SWEEP = {"format": "trilat.study", "version": 1, "kind": "threshold_sweep", "name": "sweep", "seed": 1,
         "rigs": [{"name": "mine", "heights_m": [0.6, 2.2, 0.9, 1.9], "radius_m": 2.0}], "joints": ["volume"],
         "error_models": ["range_signed"], "threshold_units": ["cm2"], "gradients": ["corrected"],
         "stops": ["objective"], "dampings": ["none"], "starts": ["linear"], "thresholds": [1, 1e-4],
         "error_ranges_cm": [[0, 5]], "trials": 200}

Scenario = collections.namedtuple("Scenario", "name command inputs whole", defaults=(True,))
RUN = "run study.json --campaign campaign -o out --threads 1"
# `inputs`: what the folder holds before, out of the stock; NAME=AS renames. `whole`: the output appears at once.
SCENARIOS = [
    Scenario("record", "record --source synthetic:1 --duration-s 0.7 -o out --json", ""),
    Scenario("recover", "recover out", "killed=out.partial"),
    Scenario("simulate", "simulate simulation.json -o out", "simulation.json"),
    Scenario("simulate --shard", "simulate simulation.json --shard 1/2 -o out", "simulation.json"),
    Scenario("run", RUN, "study.json campaign"),
    Scenario("run over older", RUN, "study.json campaign older=out"),
    Scenario("run --reuse", RUN + " --reuse results", "study.json campaign results"),
    Scenario("run --shard", RUN + " --shard 1/2", "study.json campaign"),
    Scenario("run, resumed", RUN, "study.json campaign stopped=out.partial"),
    Scenario("merge", "merge part1 part2 -o out --threads 1", "part1 part2"),
    Scenario("merge campaign", "merge made1 made2 -o out", "made1 made2"),
    Scenario("sweep", "run sweep.json -o out --threads 1", "sweep.json"),
    Scenario("sweep, resumed", "run sweep.json -o out --threads 1", "sweep.json stopped_sweep=out.partial"),
    Scenario("report", "report results -o out --time then", "results", False),
    Scenario("report: gnuplot", "report results -o out --time then", "results", False),
    Scenario("gate", "gate older --baseline accepted --junit out --threads 1", "older accepted"),
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
                           ("other", {**STUDY, "resamples": 250})):
        (folder / f"{name}.json").write_text(json.dumps(document))
    no_summary = ["strace", "-f", "-qq", "-o", "/dev/null", "-P", "stopped.partial/summary.json.partial", "-P",
                  "stopped_sweep.partial/summary.json.partial", "-e", "inject=openat:error=ENOSPC"]
    must(program, "simulate simulation.json -o campaign", folder)
    for part in (1, 2):
        must(program, f"simulate simulation.json --shard {part}/2 -o made{part}", folder)
        must(program, f"run study.json --campaign campaign --shard {part}/2 -o part{part}", folder)
    must(program, "run study.json --campaign campaign -o results", folder)
    must(program, "run other.json --campaign campaign -o older", folder)
    must(program, "gate older --baseline accepted --accept first", folder)
    for study in ("study.json --campaign campaign -o stopped", "sweep.json -o stopped_sweep"):
        run(program, "run " + study, folder, no_summary)
        name = study.split()[-1]
        (folder / f"{name}.partial").rename(folder / name)
    run(program, "record --source synthetic:2 --duration-s 9 -o killed", folder,
        ["timeout", "-s", "KILL", "3"])
    (folder / "killed.partial").rename(folder / "killed")


def prepare(scenario, stock_folder, folder):
    folder.mkdir()
    for entry in scenario.inputs.split():
        name, _, other = entry.partition("=")
        source = stock_folder / name
        (shutil.copytree if source.is_dir() else shutil.copy2)(source, folder / (other or name))


def files_of(path):
    """What lies there, by name: its hash."""
    found = {}
    for file in sorted([path, *path.rglob("*")]) if path.exists() else []:
        if file.is_file():
            data = b"" if file.name in VOLATILE else file.read_bytes()
            data = re.sub(rb' timestamp="[^"]*"', b"", data)  # of a gate's verdict
            found[str(file.relative_to(path))] = hashlib.sha256(data).hexdigest()
    return found
