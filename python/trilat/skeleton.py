# SPDX-License-Identifier: MIT
"""The 25 joints of the Kinect SDK, in its order."""
import numpy as np

JOINTS: tuple[str, ...] = (
    "spine_base", "spine_mid", "neck", "head",
    "shoulder_left", "elbow_left", "wrist_left", "hand_left",
    "shoulder_right", "elbow_right", "wrist_right", "hand_right",
    "hip_left", "knee_left", "ankle_left", "foot_left",
    "hip_right", "knee_right", "ankle_right", "foot_right",
    "spine_shoulder", "hand_tip_left", "thumb_left", "hand_tip_right", "thumb_right")
JOINT_COUNT = len(JOINTS)
JOINT_NUMBER = {name: number for number, name in enumerate(JOINTS)}
_OTHER_SIDE = {"left": "right", "right": "left"}
# The number of each joint's counterpart on the other side; its own in the middle.
MIRRORED = np.array([JOINT_NUMBER["_".join(_OTHER_SIDE.get(part, part) for part in name.split("_"))] for name in JOINTS])
NOT_TRACKED, INFERRED, TRACKED = 0, 1, 2
NEAREST_JOINT_M, FARTHEST_JOINT_M = 0.4, 10.0  # from the sensor; beyond them no Kinect measures a joint


def states_within_reach(position_m: np.ndarray, state: np.ndarray) -> tuple[np.ndarray, int]:
    """Tracking states (..., 25) of joints (..., 25, 3) in the sensor's frame, not tracked where a joint is nearer or farther
    than a Kinect measures, as where (0, 0, 0) is written for what it did not see; and how many of those there are."""
    range_m = np.linalg.norm(position_m, axis=-1)
    beyond = (state != NOT_TRACKED) & ~((range_m >= NEAREST_JOINT_M) & (range_m <= FARTHEST_JOINT_M))
    return np.where(beyond, NOT_TRACKED, state).astype(np.uint8), int(beyond.sum())
