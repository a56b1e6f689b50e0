# SPDX-License-Identifier: MIT
"""KinectMultiTrack (Wu, github.com/chijuiwu/KinectMultiTrack): two Kinect v2 on one person, no truth.

A row is one sensor's body at one moment: study, configuration, scenario, the server's time in ms, ..., the sensor's own time in
ticks of 100 ns, and 25 joints in alphabetical order, turned about y and shifted into the camera space of one sensor by the angle
and place at which each saw the person first. The turn is undone here; the shift is not told, so the other sensor is set where it
would have the person on its axis at the stated distance.
"""
import argparse
import csv
import json
import re
from pathlib import Path

import numpy as np

from trilat.convert.motion import Comparison, Motion
from trilat.convert.recording import TICK_NS, TICKS_PER_S, Body, Recording, TornRow, integer, need_one, numbers, refuse_rate
from trilat.errors import InputError
from trilat.skeleton import JOINT_COUNT, JOINT_NUMBER, JOINTS
from trilat.write_session import write_session

HELP = "csv of KinectMultiTrack, one of a participant and configuration: a folder with a session of both sensors for each scenario"
NOTE = ("KinectMultiTrack: the files have no tracking states (every joint is called tracked). The turn of one sensor's joints into the "
        "other's camera space is undone by the recorded angles, the shift by its distance, as if it had first seen the person on its axis. "
        "The sensors' clocks are set by the motion: the server paired rows that are {offset_s:.3f} s ({low_s:.3f} to {high_s:.3f}) apart.")
SCENARIOS = {1: "standing", 2: "steps", 3: "walking"}
MISSING = -9999.0
SEARCH_S = 0.5
FIRST_ROWS = 40  # in which the person stands as when first seen


def column_of(joint: str) -> str:
    return "".join(part.capitalize() for part in re.sub("(.*)_(left|right)$", r"\1_\2", joint).split("_"))


def turn_about_y(angle_rad: float) -> np.ndarray:
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


class SensorRows:
    """All rows of one sensor of a file, by scenario."""

    def __init__(self, path: Path, name: str) -> None:
        self.path, self.name = path, name
        self.rows: list[tuple[str, int, int, np.ndarray]] = []  # place, scenario, ticks, joints (25, 3)
        self.angle_rad = self.distance_m = 0.0
        self.problems: list[tuple[str, str]] = []

    def motion(self) -> Motion:
        ticks = np.array([row[2] for row in self.rows])
        first = np.concatenate([[True], ticks[1:] > np.maximum.accumulate(ticks)[:-1]])
        joint_m = np.array([row[3] for row in self.rows])[first]
        return Motion(ticks[first] / TICKS_PER_S, joint_m)


def read_rows(path: Path) -> list[SensorRows]:
    """Both sensors, in the order of their addresses."""
    try:
        with open(path, newline="", encoding="utf-8") as file:
            table = list(csv.reader(file, skipinitialspace=True))
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(path, f"cannot be read: {error}") from error
    at = {name: i for i, name in enumerate(table[0])} if table else {}
    wanted = ["Scenario", "Skeleton_Time", "Skeleton_Init_Angle", "Skeleton_Init_Dist", "Kinect#",
              *(f"{column_of(joint)}_{axis}" for joint in JOINTS for axis in "XYZ")]
    if missing := [name for name in wanted if name not in at]:
        raise InputError(path, f"has no column {missing[0]}; a csv of KinectMultiTrack has {len(wanted)} of these")
    sensors: dict[str, SensorRows] = {}
    for number, row in enumerate(table[1:], 2):
        place, key = f"{path}:{number}", row[at["Kinect#"]] if len(row) > at["Kinect#"] else ""
        sensor = sensors.setdefault(key, SensorRows(path, key)) if key else next(iter(sensors.values()), SensorRows(path, ""))
        try:
            if len(row) < len(at):
                raise TornRow(f"has {len(row)} cells; a row has {len(at)}")
            joint_m = numbers([row[at[name]] for name in wanted[5:]], "a joint").reshape(JOINT_COUNT, 3)
            joint_m[(joint_m == MISSING).any(axis=1)] = np.nan
            sensor.angle_rad, sensor.distance_m = numbers([row[at[name]] for name in wanted[2:4]], "angle and distance")
            sensor.rows.append((place, integer(row[at["Scenario"]], "the scenario"), integer(row[at["Skeleton_Time"]], "the time"),
                                joint_m))
        except TornRow as torn:
            sensor.problems.append((place, str(torn)))
    if len(sensors) != 2 or not all(sensor.rows for sensor in sensors.values()):
        raise InputError(path, f"has rows of {len(sensors)} sensors; two are expected")
    return [sensors[key] for key in sorted(sensors)]


def shoulder_angle_rad(joint_m: np.ndarray) -> float:
    """Of the line from the left to the right shoulder, against the sensor's x, about y."""
    x, _, z = np.nanmedian(joint_m[:, JOINT_NUMBER["shoulder_right"]] - joint_m[:, JOINT_NUMBER["shoulder_left"]], axis=0)
    return float(np.arctan2(z, x))


def into_camera_space(sensors: list[SensorRows]) -> None:
    """Undoes the turn of the sensor that is not the one whose camera space the file is in, and sets it off by its distance."""
    angle_rad = shoulder_angle_rad(np.array([row[3] for row in sensors[0].rows[:FIRST_ROWS]]))
    reference, other = sorted(sensors, key=lambda sensor: abs(sensor.angle_rad - angle_rad))
    place_m = np.nanmean(other.rows[0][3], axis=0)
    turn = turn_about_y(reference.angle_rad - other.angle_rad)
    at_m = np.array([0.0, place_m[1], other.distance_m])
    other.rows = [(place, scenario, ticks, (joint_m - place_m) @ turn.T + at_m) for place, scenario, ticks, joint_m in other.rows]


def convert(arguments: argparse.Namespace) -> int:
    refuse_rate(arguments)
    path = need_one(arguments.files, "is a second file; a file is a participant and a configuration, and becomes a folder")
    output: Path = arguments.output
    if output.exists() and not arguments.force:
        raise InputError(output, "is there already; take another name, or write into it with --force")
    sensors = read_rows(path)
    first, second = (sensor.motion() for sensor in sensors)
    between_s = float(np.median([a[2] - b[2] for a, b in zip(sensors[0].rows, sensors[1].rows)])) / TICKS_PER_S
    pairing = Comparison(first, Motion(second.time_s + between_s, second.joint_m), SEARCH_S).pairing()
    if pairing.problem:
        raise InputError(path, "has two sensors that " + pairing.problem)
    into_camera_space(sensors)
    behind_ticks = round(TICKS_PER_S * (pairing.offset_s - between_s))  # the second's clock less the first's
    note = NOTE.format(offset_s=pairing.offset_s, low_s=pairing.low_s, high_s=pairing.high_s)
    output.mkdir(parents=True, exist_ok=True)
    start = min(sensors[0].rows[0][2], sensors[1].rows[0][2] - behind_ticks)
    report = []
    for scenario in sorted({row[1] for row in sensors[0].rows}):
        recordings = []
        for number, sensor in enumerate(sensors, 1):
            recording = Recording(f"k{number}", path)
            for place, _, ticks, joint_m in (row for row in sensor.rows if row[1] == scenario):
                missing = np.isnan(joint_m).any(axis=1)
                with recording.row(place):
                    recording.add(place, ticks - start - (behind_ticks if number == 2 else 0),
                                  [Body(np.where(missing[:, None], 0.0, joint_m), np.where(missing, 0, 2).astype(np.uint8))])
            recordings.append(recording)
        name = SCENARIOS.get(scenario, f"scenario{scenario}")
        write_session(output / f"{name}.h5", {r.name: r.sensor("import kinectmultitrack") for r in recordings}, note=note,
                      force=arguments.force)
        report += [{"session": str(output / f"{name}.h5"), **r.report()} for r in recordings]
    torn = [f"{place} {problem}" for sensor in sensors for place, problem in sensor.problems]
    if arguments.json:
        print(json.dumps({"folder": str(output), "note": note, "sensors": report, "torn_rows": torn}, indent=2))
    else:
        for row in report:
            print(f"{row['session']} {row['name']}: {row['body_frames']} frames; left out: {row['repeated_times']} that repeat the one "
                  f"before, {row['backward_times']} that go back in time, {row['torn_rows']} torn")
        if torn:
            print(f"{len(torn)} rows are torn and left out; first: {torn[0]}")
        print(note)
    return int(bool(torn) or any(row["torn_rows"] for row in report))
