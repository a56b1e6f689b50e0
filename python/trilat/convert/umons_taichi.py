# SPDX-License-Identifier: MIT
"""UMONS-TAICHI (Tits et al. 2018, doi 10.1016/j.dib.2018.05.088): whole milliseconds, then x, y, z of 25 joints."""
import argparse

from trilat.convert.joint_rows import convert_rows

HELP = "Kinect text file of the UMONS-TAICHI data set (not yet run on a real file)"
NOTE = ("The file holds no tracking states (every joint is called tracked, inferred ones too), no body id (1 is written), no "
        "orientations and no hand states (zeros). This converter has not yet been run on a real file.")


def convert(arguments: argparse.Namespace) -> int:
    return convert_rows(arguments, separator=None, ticks_per_unit=10_000, has_states=False, note=NOTE)
