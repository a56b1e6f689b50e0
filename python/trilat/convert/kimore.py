# SPDX-License-Identifier: MIT
"""KIMORE: JointPosition*.csv (x, y, z, state), TimeStamp*.csv (ticks of 100 ns), JointOrientation*.csv, row by row."""
import argparse
from itertools import zip_longest
from pathlib import Path

from trilat.convert.recording import (TICKS_PER_S, Body, Recording, TornRow, finish, need_one, numbered_lines, numbers, states_of,
                                      time_of)
from trilat.errors import InputError
from trilat.skeleton import JOINT_COUNT

HELP = ("folder with an exercise's JointPosition, TimeStamp and JointOrientation csv of the KIMORE data set, or the JointPosition "
        "csv alone with --rate-hz (not yet run on a real file)")


def files_of(path: Path) -> dict[str, Path]:
    """The files of a folder by what they hold, or the positions alone."""
    if not path.is_dir():
        return {"JointPosition": path}
    found = {}
    for kind in ("JointPosition", "TimeStamp", "JointOrientation"):
        files = sorted(path.glob(kind + "*.csv"))
        if len(files) > 1 or (kind == "JointPosition" and not files):
            raise InputError(path, f"holds {len(files)} files {kind}*.csv; the files of one exercise are expected")
        found.update({kind: file for file in files})
    return found


def four_a_joint(line: str, what: str):
    cells = line.strip().rstrip(",").split(",")
    if len(cells) != 4 * JOINT_COUNT:
        raise TornRow(f"has {len(cells)} cells; a row has {4 * JOINT_COUNT}: four for each of {JOINT_COUNT} joints")
    return numbers(cells, what).reshape(JOINT_COUNT, 4)


def convert(arguments: argparse.Namespace) -> int:
    path = need_one(arguments.files, "is a second recording; they share no clock, so each becomes a session of its own")
    files, rate_hz = files_of(path), arguments.rate_hz
    if "TimeStamp" in files and rate_hz:
        raise InputError("--rate-hz", "is not for recordings with a TimeStamp csv")
    if "TimeStamp" not in files and not rate_hz:
        raise InputError("--rate-hz", f"is missing: there is no TimeStamp*.csv beside {files['JointPosition']}")
    recording = Recording("k1", path)

    for number, cells in enumerate(zip_longest(*(numbered_lines(file) for file in files.values()))):
        place = next(cell for cell in cells if cell)[0]
        row = {kind: cell[1] for kind, cell in zip(files, cells, strict=True) if cell}
        with recording.row(place):
            if len(row) < len(files):
                raise TornRow("is where one of the files has ended and another has not")
            ticks = (time_of(row["TimeStamp"].strip().rstrip(",")) if "TimeStamp" in row
                     else round(TICKS_PER_S * number / rate_hz))
            joints = four_a_joint(row["JointPosition"], "a joint's position")
            turns = ({"orientation_xyzw": four_a_joint(row["JointOrientation"], "an orientation")}
                     if "JointOrientation" in row else {})
            recording.add(place, ticks, [Body(joints[:, :3], states_of(joints[:, 3], place), **turns)])
    note = "The files hold no body id (1 is written) and no hand states (zeros)."
    note += " Orientations are taken as x, y, z, w." if "JointOrientation" in files else " There are no orientations (zeros)."
    note += "" if "TimeStamp" in files else f" There are no time stamps: row / {rate_hz:g} Hz is the time."
    return finish(arguments, [recording], note + " This converter has not yet been run on a real file.")
