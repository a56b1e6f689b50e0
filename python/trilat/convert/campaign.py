# SPDX-License-Identifier: MIT
"""Takes of one sensor and motion capture that share neither clock nor axes: a campaign that `trilat run` evaluates."""
import argparse
import json
import shlex
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from trilat.convert.motion import Comparison, Motion, Pairing, rotation_of
from trilat.convert.recording import TICKS_PER_S
from trilat.errors import InputError
from trilat.outputs import folder_aside, refuse_inputs_within
from trilat.skeleton import JOINT_COUNT, JOINT_NUMBER, TRACKED, states_within_reach
from trilat.write_joints import write_joints
from trilat.write_session import SensorFrames, write_session

START_S = 10.0  # what a take's host clock shows at the sensor's first frame
ROUNDS = 3


@dataclass
class Take:
    """One movement, seen by a sensor (its frame, metres) and by motion capture (its own axes with z up, metres).

    joints: columns of sensor_m by name. markers: columns of truth_m by name. mapping: a joint's markers.
    """
    id: str
    participant: str
    activity: str
    rate_hz: float
    sensor_m: np.ndarray
    joints: tuple[str, ...]
    truth_hz: float
    truth_m: np.ndarray
    markers: tuple[str, ...]
    mapping: Mapping[str, tuple[str, ...]]
    orientation_xyzw: np.ndarray | None = None

    def motions(self) -> tuple[Motion, Motion]:
        """Of the mapped joints: the sensor's, and the means of the markers with y up."""
        columns = [self.joints.index(joint) for joint in self.mapping]
        means = [np.mean([self.truth_m[:, self.markers.index(m)] for m in names], axis=0) for names in self.mapping.values()]
        return (Motion(np.arange(len(self.sensor_m)) / self.rate_hz, self.sensor_m[:, columns]),
                Motion(np.arange(len(self.truth_m)) / self.truth_hz, y_up(np.stack(means, axis=1))))


@dataclass
class Pose:
    """world = rotation sensor + position, with standard deviations from leaving each take out."""
    rotation: np.ndarray
    position_m: np.ndarray
    rotation_sigma_rad: float = 0.0
    position_sigma_m: float = 0.0


def y_up(point_m: np.ndarray) -> np.ndarray:
    """Axes with z up turned so that y is."""
    return point_m[..., [0, 2, 1]] * [1.0, 1.0, -1.0]


def pose_of(pairs: list[tuple[np.ndarray, np.ndarray, np.ndarray]]) -> Pose:
    """From (covariance, mean of the sensor's joints, mean of the truth's) of each take: Kabsch, and equal means."""
    rotation = rotation_of(sum(covariance for covariance, _, _ in pairs))
    return Pose(rotation, np.mean([truth_m - rotation @ sensor_m for _, sensor_m, truth_m in pairs], axis=0))


def means_m(first: Motion, second: Motion, pairing: Pairing) -> tuple[np.ndarray, np.ndarray]:
    """(3,) means over the joints that both have, each of its mean over time."""
    other = second.at(pairing.ratio * first.time_s + pairing.offset_s)
    both = np.isfinite(first.joint_m + other).all(axis=2)
    seen = both.any(axis=0)
    return tuple(np.mean([joint_m[both[:, j], j].mean(axis=0) for j in np.flatnonzero(seen)], axis=0)
                 for joint_m in (first.joint_m, other))


def pair_takes(takes: list[Take], search_s: float,
               ratios: tuple[float, ...]) -> tuple[dict[str, Pairing], Pose | None, dict[str, str]]:
    """The clocks of one participant's takes and the sensor's one pose, in turn until both agree; and why others fail."""
    motions, compared, problems = {take.id: take.motions() for take in takes}, {}, {}
    for key, pair in motions.items():
        try:
            compared[key] = Comparison(*pair, search_s, ratios)
        except InputError as error:
            problems[key] = error.problem
    pairings = {key: comparison.pairing() for key, comparison in compared.items()}
    for _ in range(ROUNDS):
        used = [key for key, pairing in pairings.items() if not pairing.problem] or list(pairings)
        if not used:
            return {}, None, problems
        rotation = rotation_of(sum(compared[key].covariance(pairings[key]) for key in used))
        pairings = {key: comparison.pairing(rotation) for key, comparison in compared.items()}
    problems |= {key: pairing.problem for key, pairing in pairings.items() if pairing.problem}
    pairings = {key: pairing for key, pairing in pairings.items() if not pairing.problem}
    if not pairings:
        return {}, None, problems
    pairs = [(compared[key].covariance(pairing), *means_m(*motions[key], pairing)) for key, pairing in pairings.items()]
    pose = pose_of(pairs)
    if len(pairs) > 1:
        without = [pose_of(pairs[:i] + pairs[i + 1:]) for i in range(len(pairs))]
        spread = np.sqrt((len(pairs) - 1) / 3.0)  # a jackknife, root mean square over the axes
        turns = [np.arccos(np.clip((np.trace(p.rotation.T @ pose.rotation) - 1) / 2, -1, 1)) for p in without]
        shifts = [np.linalg.norm(p.position_m - np.mean([q.position_m for q in without], axis=0)) for p in without]
        pose.rotation_sigma_rad = float(spread * np.sqrt(np.mean(np.square(turns))))
        pose.position_sigma_m = float(spread * np.sqrt(np.mean(np.square(shifts))))
    return pairings, pose, problems


def quaternion_xyzw(rotation: np.ndarray) -> list[float]:
    """Of a rotation matrix: the eigenvector of the largest eigenvalue of Bar-Itzhack's matrix."""
    m = rotation
    k = np.array([[m[0, 0] - m[1, 1] - m[2, 2], 0, 0, 0], [m[1, 0] + m[0, 1], m[1, 1] - m[0, 0] - m[2, 2], 0, 0],
                  [m[2, 0] + m[0, 2], m[2, 1] + m[1, 2], m[2, 2] - m[0, 0] - m[1, 1], 0],
                  [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], np.trace(m)]]) / 3.0
    return [float(q) for q in np.linalg.eigh(k)[1][:, -1]]


def write_json(path: Path, kind: str, content: dict) -> None:
    """A document of trilat's."""
    path.write_text(json.dumps({"format": f"trilat.{kind}", "version": 1, **content}, indent=1) + "\n")


def write_take(folder: Path, take: Take, pairing: Pairing, note: str, source: str) -> dict:
    """The take's folder, and its entry in campaign.json."""
    (folder / take.id).mkdir()
    frames = len(take.sensor_m)
    position_m = np.zeros((frames, JOINT_COUNT, 3))
    state = np.zeros((frames, JOINT_COUNT), np.uint8)
    columns = [JOINT_NUMBER[joint] for joint in take.joints]
    position_m[:, columns], state[:, columns] = take.sensor_m, TRACKED
    state, _ = states_within_reach(position_m, state)
    ticks = np.round(TICKS_PER_S * (START_S + np.arange(frames) / take.rate_hz)).astype(np.int64)
    write_session(folder / take.id / "session.h5", {"k1": SensorFrames(
        ticks, np.arange(frames), position_m, state, orientation_xyzw=take.orientation_xyzw, source=source,
        rate_hz=take.rate_hz)}, note=note)
    truth_m = y_up(take.truth_m)
    write_joints(folder / take.id / "mocap.trc", np.arange(len(truth_m)) / (take.truth_hz * pairing.ratio),
                 {name: truth_m[:, k] for k, name in enumerate(take.markers)})
    return {"id": take.id, "participant": take.participant, "activity": take.activity,
            "session": f"{take.id}/session.h5", "calibration": f"{take.participant}.json", "mocap": f"{take.id}/mocap.trc",
            "mapping": "mapping.json", "up_axis": "y",
            "mocap_start_host_ns": round(1e9 * (START_S - pairing.offset_s / pairing.ratio))}


def refuse_other_files(folder: Path) -> None:
    """InputError unless the folder is a campaign and holds its files alone: it is replaced as a whole."""
    try:
        campaign = json.loads((folder / "campaign.json").read_text())
        takes = [take for take in campaign["takes"] if campaign["format"] == "trilat.campaign"]
        known = {folder / str(take[key]) for take in takes for key in ("session", "calibration", "mocap", "mapping") if key in take}
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(folder, "is there already and is not a campaign; take another name") from error
    known.add(folder / "campaign.json")
    for path in sorted(folder.rglob("*")):
        if not path.is_dir() and path not in known:
            raise InputError(path, f"is not a file of the campaign {folder}, which is replaced as a whole; move it, or take another name")


def write_campaign(arguments: argparse.Namespace, name: str, takes: list[Take], left_out: list[str], note: str,
                   search_s: float, ratios: tuple[float, ...] = (1.0,)) -> int:
    """Pairs, writes and says all; the exit code is 1 when takes were left out. The folder is whole or not there."""
    output: Path = arguments.output
    refuse_inputs_within(output, arguments.files)
    if output.exists():
        if not arguments.force:
            raise InputError(output, "is there already; take another name, or replace a campaign with --force")
        refuse_other_files(output)
    if not takes:
        raise InputError(arguments.files[0], "holds no take" + (f"; first: {left_out[0]}" if left_out else ""))
    entries, report = [], []
    with folder_aside(output) as aside:
        for participant in sorted({take.participant for take in takes}):
            mine = [take for take in takes if take.participant == participant]
            if sys.stderr.isatty():
                print(f"{participant}: setting {len(mine)} takes beside motion capture", file=sys.stderr)
            pairings, pose, problems = pair_takes(mine, search_s, ratios)
            left_out += [f"{key}: sensor and motion capture {problem}" for key, problem in problems.items()]
            if pose is None:
                continue
            used = [take for take in mine if take.id in pairings]
            entries += [write_take(aside, take, pairings[take.id], note, f"import {arguments.format}") for take in used]
            write_json(aside / f"{participant}.json", "calibration", {
                "method": f"fitted to the motion of {len(used)} takes; a constant difference between all markers and all joints "
                          "is in the position", "world": "optitrack", "simulated": False,
                "sensors": [{"name": "k1", "position_m": [float(v) for v in pose.position_m],
                             "rotation_xyzw": quaternion_xyzw(pose.rotation), "position_sigma_m": pose.position_sigma_m,
                             "rotation_sigma_rad": pose.rotation_sigma_rad}]})
            report += [{"take": take.id, "offset_s": pairings[take.id].offset_s, "low_s": pairings[take.id].low_s,
                        "high_s": pairings[take.id].high_s, "ratio": pairings[take.id].ratio,
                        "correlation": pairings[take.id].correlation} for take in used]
        if not entries:
            raise InputError(arguments.files[0], "holds no take whose sensor and motion capture fit together; first: "
                             + left_out[0])
        write_json(aside / "mapping.json", "mapping", {"joints": {joint: list(names) for joint, names in takes[0].mapping.items()}})
        write_json(aside / "campaign.json", "campaign", {"name": name, "simulated": False, "takes": entries})
    widths = [row["high_s"] - row["low_s"] for row in report]
    if arguments.json:
        print(json.dumps({"campaign": str(output), "format": arguments.format, "note": note, "takes": report,
                          "left_out": left_out}, indent=2))
    else:
        print(f"{output}: {len(entries)} takes of {len({take['participant'] for take in entries})} participants\n"
              f"clocks from the motion: offsets of {min(r['offset_s'] for r in report):.2f} to "
              f"{max(r['offset_s'] for r in report):.2f} s, 95 % intervals {np.median(widths):.2f} s wide (median), correlation "
              f"{min(r['correlation'] for r in report):.2f} at least\n{note}")
        for line in left_out:
            print(f"left out: {line}")
        print(f"next: trilat run one_sensor --campaign {shlex.quote(str(output))} -o results")
    return int(bool(left_out))
