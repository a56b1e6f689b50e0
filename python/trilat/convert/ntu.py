# SPDX-License-Identifier: MIT
"""NTU RGB+D .skeleton: the number of frames; a frame: the number of bodies; a body: a line, 25, and a line a joint."""
import argparse
import re
from pathlib import Path

import numpy as np

from trilat.convert.recording import TICKS_PER_S, Body, Recording, TornRow, finish, integer, numbered_lines, numbers, states_of
from trilat.errors import InputError
from trilat.skeleton import JOINT_COUNT

HELP = ".skeleton of NTU RGB+D; several files: the cameras of one recording"
NOTE = ("The files hold no time stamps: frame number / rate is the time, and the same frame number of several cameras the same "
        "moment.")
NAME = re.compile(r"(S\d{3})(C\d{3})(P\d{3}R\d{3}A\d{3})")


def cells_of(line: str, count: int, what: str) -> list[str]:
    cells = line.split()
    if len(cells) != count:
        raise TornRow(f"has {len(cells)} cells; {what} has {count}")
    return cells


def read_body(lines: list[tuple[str, str]]) -> Body:
    about = cells_of(lines[0][1], 10, "the line about a body")
    hands = [integer(cell, "a hand") for cell in about[2:6]]  # confidence and state, left and right
    if min(hands) < 0 or max(hands[0::2]) > 1 or max(hands[1::2]) > 4:
        raise TornRow("has a hand's confidence above 1 or state above 4")
    rows = [cells_of(line, 12, "the line of a joint") for _, line in lines[2:]]
    joints = numbers([cell for row in rows for cell in row[:3] + row[7:]], "a joint").reshape(JOINT_COUNT, 8)
    pixels = np.array([row[3:5] for row in rows]).astype(float)  # of what cannot be projected infinite or NaN
    return Body(joints[:, :3], states_of(joints[:, 7], lines[0][0]), integer(about[0], "a body's id"), joints[:, [4, 5, 6, 3]],
                (hands[1], hands[3]), (hands[0], hands[2]), pixels)


def read_file(path: Path, camera: str, rate_hz: float) -> Recording:
    recording, lines = Recording(camera, path, rate_hz), [*numbered_lines(path), (f"{path}:end", "")]
    try:
        frames, at = integer(lines[0][1].strip(), "the number of frames"), 1
    except TornRow as torn:
        raise InputError(lines[0][0], f"{torn}; this is not a .skeleton file") from torn
    for frame in range(frames):
        begin, torn, bodies = at, None, []
        count = int(lines[at][1]) if lines[at][1].strip().isdigit() else -1
        at += 1
        for _ in range(count):
            if at + JOINT_COUNT + 2 >= len(lines) or lines[at + 1][1].split() != [str(JOINT_COUNT)]:
                count = -1
                break
            try:
                bodies.append(read_body(lines[at:at + JOINT_COUNT + 2]))
            except (TornRow, ValueError) as error:
                torn = torn or error
            at += JOINT_COUNT + 2
        with recording.row(lines[begin][0]):
            if count < 0:
                raise TornRow(f"is a frame that is cut short; nothing behind it can be read, {frames - frame} of {frames} frames "
                              "are lost")
            if torn:
                raise TornRow(str(torn))
            recording.add(lines[begin][0], round(TICKS_PER_S * frame / rate_hz), bodies, frame)
        if count < 0:
            break
    return recording


def convert(arguments: argparse.Namespace) -> int:
    names = [NAME.fullmatch(file.stem) for file in arguments.files]
    cameras = [name[2] if name else "C001" for name in names]
    for n, (file, name) in enumerate(zip(arguments.files, names, strict=True)):
        if len(names) > 1 and not name:
            raise InputError(file, "has no name such as S001C002P003R002A013.skeleton, which says the camera")
        if n > 0 and name.group(1, 3) != names[0].group(1, 3):
            raise InputError(file, f"is of another recording than {arguments.files[0].name}; only the camera C... may differ")
        if cameras[n] in cameras[:n]:
            raise InputError(file, f"is a second file of camera {cameras[n]}")
    rate_hz = arguments.rate_hz or 30.0
    return finish(arguments, [read_file(*pair, rate_hz) for pair in zip(arguments.files, cameras, strict=True)], NOTE)
