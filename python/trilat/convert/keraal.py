# SPDX-License-Identifier: MIT
"""Keraal (Nguyen et al., github.com/nguyensmai/KeraalDataset): one Kinect v2 and Vicon on rehabilitation exercises.

A row is a frame. Kinect: 25 joints, position in metres and quaternion x, y, z, w. Vicon: 17 rigid targets, millimetres and
quaternion. Neither has time stamps, and the ratio of their rates is found from the motion. A target is no joint centre.
"""
import argparse
import re
from pathlib import Path

import numpy as np

from trilat.convert.campaign import Take, write_campaign
from trilat.convert.recording import refuse_rate
from trilat.errors import InputError
from trilat.skeleton import JOINT_COUNT, JOINTS

HELP = "folder of Keraal's G3-Kinect-*.txt and G3-Vicon-*.txt: a campaign with truth"
NOTE = ("Keraal: the files have no time stamps (30 Hz is taken for the sensor; Vicon's rate is found from the motion) and no tracking "
        "states (every joint is called tracked). Targets on the arms and legs lie between joints and are not used. Clocks and poses "
        "are from the motion.")
# As found by which joint each moves with: the order that the data set states has the left forearm and the left arm exchanged.
TARGETS = ("forearm_right", "arm_left", "arm_right", "forearm_left", "chest", "thigh_right", "thigh_left", "shoulder_right",
           "shoulder_left", "hand_right", "hand_left", "foot_right", "foot_left", "hips", "head", "tibia_right", "tibia_left")
MAPPING = {"head": ("head",), "spine_shoulder": ("chest",), "spine_base": ("hips",),
           **{joint: (joint,) for joint in ("shoulder_left", "shoulder_right", "hand_left", "hand_right", "foot_left", "foot_right")}}
SEARCH_S, VICON_HZ = 0.7, 60.0
RATIOS = tuple(np.round(np.arange(0.95, 1.0501, 0.0025), 4))


def table(path: Path, columns: int) -> np.ndarray:
    """(N, columns, 7) numbers."""
    try:
        rows = np.loadtxt(path, ndmin=2)
    except (OSError, ValueError) as error:
        raise InputError(path, f"cannot be read as rows of {7 * columns} numbers: {error}") from error
    if rows.shape[1] != 7 * columns or not np.isfinite(rows).all():
        raise InputError(path, f"has rows of {rows.shape[1]} numbers, or some that are not finite; {7 * columns} are expected")
    return rows.reshape(-1, columns, 7)


def convert(arguments: argparse.Namespace) -> int:
    refuse_rate(arguments)
    takes, left_out = [], []
    for folder in arguments.files:
        found = sorted(folder.glob("*Kinect-*.txt"))
        if not found:
            raise InputError(folder, "has no G3-Kinect-CTK-P1T1-C-0.txt or the like")
        for path in found:
            vicon = path.with_name(path.name.replace("Kinect", "Vicon"))
            name = re.search(r"(G\d+)-Kinect-([A-Z]+)-(P\d+)", path.name)
            if not name or not vicon.exists():
                left_out.append(f"{path.name}, which has no {vicon.name} beside it, or another name than G3-Kinect-CTK-P1T1-C-0.txt")
                continue
            try:
                joints, targets = table(path, JOINT_COUNT), table(vicon, len(TARGETS))
            except InputError as error:
                left_out.append(str(error))
                continue
            takes.append(Take(path.stem.replace("-Kinect", ""), f"{name[1]}-{name[3]}", name[2], 30.0,
                              joints[:, :, :3], JOINTS, VICON_HZ, 0.001 * targets[:, :, :3], TARGETS, MAPPING, joints[:, :, 3:]))
    return write_campaign(arguments, "Keraal", takes, left_out, NOTE, SEARCH_S, RATIOS)
