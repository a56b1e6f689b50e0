# SPDX-License-Identifier: MIT
"""recorded_skeleton.json of Kinectron: an array with an object for each body and frame, as node-kinect2 hands them over."""
import argparse
import json
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from trilat.convert.recording import Body, Recording, TornRow, finish, refuse_rate
from trilat.errors import InputError
from trilat.skeleton import JOINT_COUNT
from trilat.write_session import DEPTH_SHAPE

HELP = "recorded_skeleton.json of Kinectron or node-kinect2; several files: sensors of one computer's clock"
NOTE = ("The files hold no tracking states: every joint of a tracked body is called tracked, inferred ones too. Times are "
        "the recording computer's, in milliseconds, of when the program got the frame.")
NO_START = "does not say when it began (record_startime)"
COLUMNS = [f"camera{axis}" for axis in "XYZ"] + [f"orientation{axis}" for axis in "XYZW"] + ["depthX", "depthY"]


def read_objects(path: Path) -> list[object]:
    """The objects of the array; what stands at a torn end is no object."""
    try:
        text = path.read_text(encoding="utf-8").strip()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(path, f"cannot be opened: {error}") from error
    if not text.startswith("["):
        raise InputError(path, "does not begin with '['; a JSON array of bodies is expected")
    objects, at, decoder = [], 1, json.JSONDecoder()
    while (at := len(text) - len(text[at:].lstrip(" \t\r\n,"))) < len(text) and text[at] != "]":
        try:
            value, at = decoder.raw_decode(text, at)
        except ValueError:
            value, at = "is where the file ends, or cannot be parsed", len(text)
        objects.append(value)
    return objects


def number(body: object, key: str) -> float:
    value = body.get(key) if isinstance(body, dict) else None
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e15:
        raise TornRow(f'has no number in "{key}"')
    return float(value)


def read_bodies(body: dict) -> list[Body]:
    """The body, or none when it is not tracked."""
    joints, ended = body.get("joints", []), body.get("tracked") is not True
    if ended and body.get("tracked") is not False or not ended and (not isinstance(joints, list) or len(joints) != JOINT_COUNT):
        raise TornRow(f'has no true or false in "tracked", or another number of joints than {JOINT_COUNT}')
    if ended:
        return []
    hands = tuple(int(number(body, key)) for key in ("leftHandState", "rightHandState"))
    if not {*hands} <= {*range(5)} or not str(body.get("trackingId")).isdigit():
        raise TornRow("has a hand state beyond 0 to 4, or a trackingId that is no whole number")
    rows = np.array([[number(joint, key) for key in COLUMNS] for joint in joints])
    return [Body(rows[:, :3], tracking_id=int(body["trackingId"]), orientation_xyzw=rows[:, 3:7], hand_state=hands,
                 depth_px=rows[:, 7:] * DEPTH_SHAPE[::-1])]


def read_file(name: str, path: Path, objects: list[object], origin_ms: float | None) -> Recording:
    recording, frames = Recording(name, path), []  # (place, ticks, bodies); bodies of one time belong together
    for row, value in enumerate(objects):
        with recording.row(f"{path}[{row}]"):
            time_ms = number(value, "record_timestamp")
            time_ms += 0.0 if origin_ms is None else number(value, "record_startime") - origin_ms
            ticks, bodies = round(1e4 * time_ms), read_bodies(value)
            ids = [body.tracking_id for body in (frames[-1][2] if frames else [])]
            if frames and frames[-1][1] == ticks and len(ids) < 6 and not any(b.tracking_id in ids for b in bodies):
                frames[-1][2].extend(bodies)
            else:
                frames.append((f"{path}[{row}]", ticks, bodies))
    for frame in frames:
        with recording.row(frame[0]):
            recording.add(*frame)
    return recording


def convert(arguments: argparse.Namespace) -> int:
    refuse_rate(arguments)
    files = [(path, read_objects(path)) for path in arguments.files]
    starts = [next((v["record_startime"] for v in objects if isinstance(v, dict) and "record_startime" in v), None)
              for _, objects in files]
    if len(files) > 1 and None in starts:
        raise InputError(files[starts.index(None)][0], NO_START + ", so it shares no clock with the others; convert it alone")
    origin_ms = None if None in starts else min(starts)
    recordings = [read_file(f"k{n}", path, objects, origin_ms) for n, (path, objects) in enumerate(files, 1)]
    if origin_ms is None:
        return finish(arguments, recordings, f"{NOTE} The file {NO_START}: times count from an unknown beginning.")
    started = datetime.fromtimestamp(origin_ms / 1000, UTC).isoformat(timespec="milliseconds")
    return finish(arguments, recordings, NOTE, started.replace("+00:00", "Z"))
