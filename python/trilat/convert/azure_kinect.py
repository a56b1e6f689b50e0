# SPDX-License-Identifier: MIT
"""JSON of Microsoft's offline_processor (Azure Kinect Body Tracking): 32 joints a body, millimetres, y down, microseconds."""
import argparse
import json
import math
from pathlib import Path

import numpy as np

from trilat.convert.recording import Body, Recording, TornRow, finish, need_one, refuse_rate
from trilat.errors import InputError
from trilat.skeleton import INFERRED, JOINTS, NOT_TRACKED, TRACKED

HELP = "JSON of Microsoft's offline_processor: bodies of one Azure Kinect"
OTHER_NAMES = {"spine_base": "PELVIS", "spine_mid": "SPINE_NAVEL", "spine_shoulder": "SPINE_CHEST",
               "hand_tip_left": "HANDTIP_LEFT", "hand_tip_right": "HANDTIP_RIGHT"}
NAMES = [OTHER_NAMES.get(joint, joint.upper()) for joint in JOINTS]
STATES = np.array([NOT_TRACKED, INFERRED, TRACKED, TRACKED], np.uint8)  # of the confidences none, low, medium, high
CONFIDENCE_KEYS = ("joint_confidence_levels", "confidence_levels", "joint_confidences")
CONFIDENCES = {name: level for level, word in enumerate(("NONE", "LOW", "MEDIUM", "HIGH"))
               for name in (word, f"K4ABT_JOINT_CONFIDENCE_{word}")}
NEAREST_MM = 400.0  # a body is half a metre away at least
UNITS = (("metres", 1000, 20.0), ("centimetres", 10, NEAREST_MM))  # mm in one, and the largest distance that is one in it
LONGEST_USEC = 2**59 // 1000  # 18 years; no device runs so long
NOTE = ("Joints without a counterpart among the 25 are left out: clavicles, nose, eyes and ears. spine_mid is the navel and spine_shoulder "
        "the chest, some centimetres below those of a Kinect v2. Orientations keep the axes that the Azure Kinect gives each joint.")


def read_document(path: Path) -> tuple[list[dict], list[int]]:
    """The frames, and where each of the 25 joints stands among the file's."""
    try:
        document = json.loads(path.read_bytes())  # UTF-8, UTF-16 or UTF-32, with a byte order mark or without
    except (OSError, ValueError) as error:
        raise InputError(path, f"cannot be read as JSON: {error}") from error
    if not isinstance(document, dict) or not isinstance(document.get("frames"), list) or not isinstance(document.get("joint_names"), list):
        raise InputError(path, 'has no "joint_names" and "frames", which offline_processor writes')
    names = [str(name).upper().removeprefix("K4ABT_JOINT_") for name in document["joint_names"]]
    if missing := [name for name in NAMES if name not in names]:
        raise InputError(path, f'has no {missing[0]} among its "joint_names"')
    return document["frames"], [names.index(name) for name in NAMES]


def array_of(body: dict, key: str, width: int, joints: list[int]) -> np.ndarray:
    try:
        return np.array(body[key], dtype=float).reshape(-1, width)[joints]
    except (KeyError, IndexError, TypeError, ValueError):
        raise TornRow(f'has no {width} numbers a joint in "{key}"') from None


def number_of(record: dict, key: str) -> float:
    value = record.get(key)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise TornRow(f'has {json.dumps(value)[:24]} for "{key}", where a number should be' if key in record else f'has no "{key}"')
    return value


def whole(record: dict, key: str) -> int:
    """A whole number, also where a program wrote it as 1.0."""
    if (value := number_of(record, key)) != int(value):
        raise TornRow(f'has {value:g} for "{key}", where a whole number should be')
    return int(value)


def body_of(body: dict, joints: list[int]) -> Body:
    """Turned by half a turn about z, so that y points up and x to the sensor's left."""
    made = Body(1e-3 * array_of(body, "joint_positions", 3, joints) * [-1.0, -1.0, 1.0], tracking_id=whole(body, "body_id"))
    if "joint_orientations" in body:
        w, x, y, z = array_of(body, "joint_orientations", 4, joints).T
        made.orientation_xyzw = np.stack([-y, x, w, -z], axis=1)
    if key := next((key for key in CONFIDENCE_KEYS if key in body), None):
        levels = [CONFIDENCES.get(level, level) if isinstance(level, str) else level for level in body[key]]
        confidence = array_of({key: levels}, key, 1, joints)[:, 0]
        if not np.isin(confidence, range(len(STATES))).all():
            raise TornRow(f'has another confidence in "{key}" than 0 to 3')
        made.tracking_state = STATES[confidence.astype(int)]
    return made


def check_unit(path: Path, frames: list[dict]) -> None:
    """InputError for joints in metres or centimetres: none is so few millimetres from the sensor."""
    bodies = [body for frame in frames if isinstance(frame, dict) for body in frame.get("bodies") or [] if isinstance(body, dict)]
    try:
        positions = [np.array(body["joint_positions"], dtype=float).reshape(-1, 3) for body in bodies[:100]]
    except (KeyError, TypeError, ValueError):
        return  # torn ones are counted where they are read
    whole = [np.linalg.norm(joints, axis=1) for joints in positions if len(joints) >= len(NAMES)]
    away = np.median(np.concatenate(whole)) if whole else np.inf
    for unit, factor, largest in UNITS:
        if 0 < away < largest:
            raise InputError(path, f"has joints {away:.3g} mm from the sensor, as {unit} are; this format has millimetres: multiply "
                                   f"joint_positions by {factor}")


def first_time_usec(frames: list[dict]) -> int:
    """The first time of a clock that counts since 1970, which a device's does not; else 0."""
    times = (frame.get("timestamp_usec") for frame in frames if isinstance(frame, dict))
    first = next((time for time in times if isinstance(time, (int, float))), 0)
    return int(first) if first > LONGEST_USEC else 0


def convert(arguments: argparse.Namespace) -> int:
    path = need_one(arguments.files, "is a second file; these files share no clock, so each becomes a session of its own")
    refuse_rate(arguments)
    frames, joints = read_document(path)
    check_unit(path, frames)
    recording, confident, begin_usec = Recording("k1", path, unit_ns=1000.0), False, first_time_usec(frames)
    for number, frame in enumerate(frames):
        place = f"{path} /frames/{number}"
        with recording.row(place):
            if not isinstance(frame, dict) or not isinstance(frame.get("bodies"), list):
                raise TornRow('has no list of "bodies"')
            bodies = [body_of(body, joints) for body in frame["bodies"]]
            confident |= any(key in body for body in frame["bodies"] for key in CONFIDENCE_KEYS)
            number = whole(frame, "frame_id") if "frame_id" in frame else None
            recording.add(place, 10 * (number_of(frame, "timestamp_usec") - begin_usec), bodies, number)
    states = "" if confident else " The file holds no confidences: every joint is called tracked, inferred ones too."
    since = " Its times count since 1970, and were taken to begin with the first frame." if begin_usec else ""
    return finish(arguments, [recording], NOTE + states + since)
