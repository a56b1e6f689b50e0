# SPDX-License-Identifier: MIT
"""Body csv of Microsoft's LabanotationSuite: ticks of 100 ns, then x, y, z, state of 25 joints."""
import argparse

from trilat.convert.joint_rows import convert_rows

HELP = "body csv of Microsoft's LabanotationSuite"
NOTE = "The file holds no body id (1 is written), no orientations and no hand states (zeros)."


def convert(arguments: argparse.Namespace) -> int:
    return convert_rows(arguments, separator=",", ticks_per_unit=1, has_states=True, note=NOTE)
