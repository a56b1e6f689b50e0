# SPDX-License-Identifier: MIT
"""The 25 joints of the Kinect SDK, in its order."""

JOINTS: tuple[str, ...] = (
    "spine_base", "spine_mid", "neck", "head",
    "shoulder_left", "elbow_left", "wrist_left", "hand_left",
    "shoulder_right", "elbow_right", "wrist_right", "hand_right",
    "hip_left", "knee_left", "ankle_left", "foot_left",
    "hip_right", "knee_right", "ankle_right", "foot_right",
    "spine_shoulder", "hand_tip_left", "thumb_left", "hand_tip_right", "thumb_right")
JOINT_COUNT = len(JOINTS)
JOINT_NUMBER = {name: number for number, name in enumerate(JOINTS)}
NOT_TRACKED, INFERRED, TRACKED = 0, 1, 2
