# SPDX-License-Identifier: MIT
"""Text files with a row a frame: the time, then x, y, z and perhaps the state of 25 joints."""
import argparse

from trilat.convert.recording import (Body, Recording, TornRow, finish, integer, need_one, numbered_lines, numbers, refuse_rate,
                                      states_of)
from trilat.skeleton import JOINT_COUNT


def convert_rows(arguments: argparse.Namespace, separator: str | None, ticks_per_unit: int, has_states: bool, note: str) -> int:
    """One file of one body. `separator` None is blanks."""
    path = need_one(arguments.files, "is a second file; these files share no clock, so each becomes a session of its own")
    refuse_rate(arguments)
    recording = Recording("k1", path)
    width = 4 if has_states else 3

    for place, line in numbered_lines(path):
        with recording.row(place):
            cells = line.strip().rstrip(separator).split(separator)
            if len(cells) != 1 + width * JOINT_COUNT:
                raise TornRow(f"has {len(cells)} cells; a row has {1 + width * JOINT_COUNT}: the time, then x, y, z"
                              f"{' and state' if has_states else ''} of {JOINT_COUNT} joints")
            ticks = integer(cells[0], "the time") * ticks_per_unit
            joints = numbers(cells[1:], "a joint's position").reshape(JOINT_COUNT, width)
            states = {"tracking_state": states_of(joints[:, 3], place)} if has_states else {}
            recording.add(place, ticks, [Body(joints[:, :3], **states)])
    return finish(arguments, [recording], note)
