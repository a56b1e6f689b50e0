# SPDX-License-Identifier: MIT
"""Body csv of Microsoft's LabanotationSuite: a row a frame, ticks of 100 ns, then x, y, z, state of 25 joints."""
import argparse

from trilat.convert.recording import (Body, Recording, TornRow, finish, need_one, numbered_lines, numbers, refuse_rate, states_of,
                                      time_of)
from trilat.skeleton import JOINT_COUNT

HELP = "body csv of Microsoft's LabanotationSuite"
NOTE = "The file holds no body id (1 is written), no orientations and no hand states (zeros)."


def convert(arguments: argparse.Namespace) -> int:
    path = need_one(arguments.files, "is a second file; these files share no clock, so each becomes a session of its own")
    refuse_rate(arguments)
    recording = Recording("k1", path)
    for place, line in numbered_lines(path):
        with recording.row(place):
            cells = line.strip().rstrip(",").split(",")
            if len(cells) != 1 + 4 * JOINT_COUNT:
                raise TornRow(f"has {len(cells)} cells; a row has {1 + 4 * JOINT_COUNT}: the time, then x, y, z and state "
                              f"of {JOINT_COUNT} joints")
            joints = numbers(cells[1:], "a joint's position").reshape(JOINT_COUNT, 4)
            recording.add(place, time_of(cells[0]), [Body(joints[:, :3], tracking_state=states_of(joints[:, 3], place))])
    return finish(arguments, [recording], NOTE)
