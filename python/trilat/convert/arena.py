# SPDX-License-Identifier: MIT
"""Rows of Arena and Tracking Tools (row formats 1.0 and 1.1) to Motive's CSV, without a rate: their own times count."""
import argparse
import csv
import json
import math
from pathlib import Path

from trilat.convert.motive import file_of, head_of, row_of
from trilat.errors import InputError
from trilat.outputs import written_aside

HELP = "rows of Arena and Tracking Tools (\"comment,\", \"info,\", \"frame,\") to Motive's CSV"
ROW_TYPES = ("comment", "info", "righthanded", "lefthanded", "trackable", "rigidbody", "frame")
BODY, SOLVED, MARKER = "Rigid Body", "Rigid Body Marker", "Marker"


class Row:
    """The cells of one row, each with its meaning from its position. The last cell of an unfinished row is not trusted."""

    def __init__(self, place: str, text: str) -> None:
        self.place, self.finished, self.at = place, text.endswith("\n"), 0
        text = text.rstrip("\r\n")
        self.cells = next(csv.reader([text if self.finished else text.rpartition(",")[0]]), [])
        self.type = self.cells[0].strip(" \t") if self.cells else ""

    def skip(self, count: int) -> str:
        self.at += count
        return self.cells[self.at - 1]  # IndexError where the row ends early

    def number(self, what: str, kind: type = float):
        cell = self.skip(1)
        try:
            return kind(cell or "nan")
        except ValueError:
            raise InputError(self.place, f'column {self.at}: "{cell[:40]}" is not a {what}') from None

    def position(self, mirrored: bool) -> tuple[float, ...]:
        return self.number("position"), self.number("position"), (-1 if mirrored else 1) * self.number("position")


class Take:
    """bodies: name and number of markers by ID. frames: number, time and positions by asset, in the order of time."""

    def __init__(self, path: Path) -> None:
        self.bodies, self.frames, self.poses, self.mirrored, self.is_newer = {}, [], None, False, False
        with path.open(encoding="utf-8-sig", errors="replace", newline="") as file:
            for line, text in enumerate(file, 1):
                row = Row(f"{path}:{line}", text)
                try:
                    self.add(row)
                except IndexError:
                    if row.finished:
                        raise InputError(row.place, f"the {row.type} row ends too early") from None
                except KeyError as unknown:
                    raise InputError(row.place, f"the body ID {unknown} is not defined before the first frame") from None
        if self.poses is None and not self.bodies:
            raise InputError(path, 'the file ends before any "trackable", "rigidbody" or "frame" row')

    def add(self, row: Row) -> None:
        if row.type and row.type not in ROW_TYPES and row.finished:
            raise InputError(row.place, f'the row type "{row.type[:40]}" is unknown; allowed: {", ".join(ROW_TYPES)}')
        self.mirrored |= row.type == "lefthanded"
        self.is_newer |= row.cells[:2] == ["info", "version"] and "".join(row.cells[2:3]).startswith("1.1")
        if row.type == "frame":
            self.add_frame(row)
        elif row.type in ("trackable", "rigidbody"):
            (self.define if self.poses is None else self.add_markers)(row)

    def define(self, row: Row) -> None:
        name, number, count = row.skip(2), row.number("body ID", int), row.number("marker count", int)
        if number in self.bodies:
            raise InputError(row.place, f"the body ID {number} is defined twice")
        self.bodies[number] = (name, count)

    def add_frame(self, row: Row) -> None:
        row.skip(1)
        index, time_s, poses = row.number("frame number", int), row.number("time"), {}
        for _ in range(row.number("body count", int)):
            number, position = row.number("body ID", int), row.position(self.mirrored)
            row.skip(7)  # rotations
            poses[BODY, self.bodies[number][0], number] = position
        row.number("marker count", int)
        if not abs(time_s) <= 1e9:
            raise InputError(row.place, "the frame row has no sensible time")
        self.poses = poses  # of a frame whose time does not advance they are left out
        before, before_s = self.frames[-1][:2] if self.frames else (-1, -math.inf)
        if time_s > before_s:
            self.frames.append((max(before + 1, index), time_s, poses))

    def add_markers(self, row: Row) -> None:
        """Of a body: the solved ones where it is tracked, and the measured ones."""
        row.skip(4)
        number, lost, count = (row.number(what, int) for what in ("body ID", "number of frames since last tracked", "marker count"))
        row.cells[row.at + count * (9 if self.is_newer else 8)]  # the last cell
        name, defined = self.bodies[number]
        if count != defined:
            raise InputError(row.place, f"the body has {count} markers here and {defined} in its definition")
        for kind in (SOLVED, MARKER):
            for k in range(1, count + 1):
                position = row.position(self.mirrored)
                row.skip(1 if kind == SOLVED and self.is_newer else 0)
                if kind == MARKER or lost == 0:
                    self.poses[kind, f"{name}:Marker{k}", number] = position

    def assets(self) -> list[tuple[str, str, int]]:
        """Type, name and ID; markers where the first frame has some."""
        kinds = (BODY, SOLVED, MARKER) if self.frames and any(kind != BODY for kind, _, _ in self.frames[0][2]) else (BODY,)
        return [(kind, name if kind == BODY else f"{name}:Marker{k}", number) for kind in kinds
                for number, (name, count) in self.bodies.items() for k in range(1, 2 if kind == BODY else count + 1)]


def convert(arguments: argparse.Namespace) -> int:
    path = file_of(arguments)
    take = Take(path)
    assets = take.assets()
    with written_aside(arguments.output) as aside, open(aside, "w", encoding="utf-8", newline="") as text:
        text.write(head_of(path.stem, f"of {path.name}", [], assets))
        for index, time_s, poses in take.frames:
            text.write(row_of(index, time_s, *("" if v != v else v for asset in assets for v in poses.get(asset, [math.nan] * 3))))
    if arguments.json:
        print(json.dumps({"mocap": str(arguments.output), "frames": len(take.frames), "mirrored": take.mirrored, "assets": assets}))
    else:
        print(f"{arguments.output}: {len(take.frames)} frames, {len(assets)} assets{', mirrored' if take.mirrored else ''}")
    return 0
