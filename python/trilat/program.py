# SPDX-License-Identifier: MIT
"""Calls the program `trilat`."""
import os
import shutil
import subprocess
from pathlib import Path

from trilat.errors import InputError, ProgramError
from trilat.read_results import Results


def program_path() -> str:
    """The program: `TRILAT` of the environment, that of this clone, or the one on the PATH."""
    in_clone = Path(__file__).resolve().parents[2] / "build/release/trilat"
    found = os.environ.get("TRILAT") or (str(in_clone) if in_clone.exists() else shutil.which("trilat"))
    if not found:
        raise InputError("trilat", "is not on the PATH; build it with scripts/build, or say where it is in TRILAT")
    return found


def call(*arguments: str | os.PathLike) -> str:
    """Runs `trilat ARGUMENTS` and gives what it prints; ProgramError with its message when it fails."""
    ended = subprocess.run([program_path(), *map(os.fspath, arguments)], capture_output=True, text=True, check=False)
    if ended.returncode != 0:
        raise ProgramError(ended.returncode, ended.stderr.strip())
    return ended.stdout


def run(study: str | os.PathLike, campaign: str | os.PathLike | None = None, output: str | os.PathLike = "results",
        force: bool = False) -> Results:
    """`trilat run`: evaluates a study of a campaign and gives its results. ProgramError with the program's message.

    Results that are there already and are up to date are taken as they are.
    """
    chosen = ["--campaign", os.fspath(campaign)] if campaign is not None else []
    call("run", study, *chosen, "-o", output, *(["--force"] if force else []))
    return Results(output)
