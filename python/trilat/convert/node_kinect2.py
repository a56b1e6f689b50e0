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
NOTE = ("The files hold no tracking states: every joint of a tracked body is called tracked, inferred ones too. Times are the "
        "recording computer's, in milliseconds, of when the program got the frame.")
COLUMNS = ("cameraX", "cameraY", "cameraZ", "orientationX", "orientationY", "orientationZ", "orientationW", "depthX", "depthY")


def read_objects(path: Path) -> list[dict | str]:
    """The objects of the array; at a torn end its problem as text."""
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
            return [*objects, f"at byte {at} is where the file ends, or cannot be parsed"]
        objects.append(value if isinstance(value, dict) else "is no object")
    return objects if at < len(text) else [*objects, "is where the file ends, before the array is closed"]


def number(body: dict, key: str) -> float:
    value = body.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e15:
        raise TornRow(f'has no number in "{key}"')
    return float(value)


def read_body(body: dict) -> list[Body]:
    if not isinstance(body.get("tracked"), bool):
        raise TornRow('has no true or false in "tracked"')
    if not body["tracked"]:
        return []
    joints, hands = body.get("joints"), [number(body, key) for key in ("leftHandState", "rightHandState")]
    if not isinstance(joints, list) or len(joints) != JOINT_COUNT or not all(isinstance(joint, dict) for joint in joints):
        raise TornRow(f"has another number of joints than {JOINT_COUNT}")
    if any(hand not in range(5) for hand in hands) or not str(body.get("trackingId")).isdigit():
        raise TornRow("has a hand state beyond 0 to 4, or a trackingId that is no whole number")
    rows = np.array([[number(joint, key) for key in COLUMNS] for joint in joints])
    return [Body(rows[:, :3], tracking_id=int(body["trackingId"]), orientation_xyzw=rows[:, 3:7],
                 hand_state=(int(hands[0]), int(hands[1])), depth_px=rows[:, 7:] * np.array(DEPTH_SHAPE[::-1]))]


def read_file(name: str, path: Path, objects: list[dict | str], origin_ms: float | None) -> Recording:
    recording, frames = Recording(name, path), []  # (place, ticks, bodies); bodies of one time belong together
    for row, value in enumerate(objects):
        with recording.row(f"{path}[{row}]"):
            if isinstance(value, str):
                raise TornRow(value)
            since_ms = 0.0 if origin_ms is None else number(value, "record_startime") - origin_ms
            ticks, bodies = round(1e4 * (number(value, "record_timestamp") + since_ms)), read_body(value)
            ids = [body.tracking_id for body in (frames[-1][2] if frames else [])]
            if frames and frames[-1][1] == ticks and len(ids) < 6 and not any(body.tracking_id in ids for body in bodies):
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
    starts = [next((value["record_startime"] for value in objects if isinstance(value, dict)
                    and isinstance(value.get("record_startime"), int | float)), None) for _, objects in files]
    if len(files) > 1 and None in starts:
        raise InputError(files[starts.index(None)][0], "does not say when it began (record_startime), so it shares no clock "
                                                       "with the others; convert it alone")
    origin_ms = None if None in starts else min(starts)
    recordings = [read_file(f"k{n}", path, objects, origin_ms) for n, (path, objects) in enumerate(files, 1)]
    if origin_ms is None:
        return finish(arguments, recordings, NOTE + " The file does not say when it began (record_startime): times count from "
                                                    "an unknown beginning.")
    started = datetime.fromtimestamp(origin_ms / 1000, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
    return finish(arguments, recordings, NOTE, started)
