# SPDX-License-Identifier: MIT
"""Motive's CSV, version 1.25, in metres, with a position for each asset."""
import argparse
import csv
import io
from collections.abc import Sequence
from pathlib import Path

from trilat.convert.recording import need_one, refuse_rate
from trilat.errors import InputError


def file_of(arguments: argparse.Namespace) -> Path:
    """The one file that is read, where its CSV may be written."""
    path = need_one(arguments.files, "is a second file; each becomes a CSV of its own")
    refuse_rate(arguments)
    if arguments.output.exists() and not arguments.force:
        raise InputError(arguments.output, "is there already; take another name, or replace it with --force")
    return path


def row_of(*cells: object) -> str:
    line = io.StringIO()
    csv.writer(line, lineterminator="\n").writerow(cells)
    return line.getvalue()


def head_of(take: str, note: str, keys: Sequence[object], assets: Sequence[tuple[str, str, object]]) -> str:
    """keys: "Export Frame Rate", "100", …; without a rate the printed times count. assets: type, name and ID."""
    text = row_of("Format Version", "1.25", "Take Name", take, "Take Notes", note, *keys, "Rotation Type", "Quaternion",
                  "Length Units", "Meters", "Coordinate Space", "Global") + "\n"
    types, names, numbers = zip(*assets) if assets else ((), (), ())
    for head, cells in (("Type", types), ("Name", names), ("ID", numbers), ("Parent", [""] * len(assets))):
        text += row_of("", head, *(cell for cell in cells for _ in range(3)))
    return text + row_of("", "", *["Position"] * (3 * len(assets))) + row_of("Frame", "Time (Seconds)", *["X", "Y", "Z"] * len(assets))
