# SPDX-License-Identifier: MIT
"""UI-PRMD (Vakanski et al. 2018, doi 10.3390/data3010002): one Kinect v2 and Vicon on ten rehabilitation movements.

Kinect: 22 joints, centimetres, each in the frame of its parent, to be chained with angles in degrees: a frame's rotation
is Rz Rx Ry (found by trying all six orders against Vicon). Vicon: 39 Plug-in Gait markers, millimetres, 100 Hz.
"""
import argparse
import gzip
import re
from pathlib import Path

import numpy as np

from trilat.convert.campaign import Take, write_campaign
from trilat.convert.recording import refuse_rate
from trilat.errors import InputError

HELP = "folder of UI-PRMD's segmented movements (Kinect/Positions, Kinect/Angles, Vicon/Positions): a campaign with truth"
NOTE = ("UI-PRMD: the files have no time stamps (30 Hz and 100 Hz are taken), no tracking states (every joint is called tracked), "
        "no orientations that are used, and not the sensor's height: positions count from the floor. Clocks and poses are from "
        "the motion.")
MOVEMENTS = ("deep squat", "hurdle step", "inline lunge", "side lunge", "sit to stand", "straight leg raise", "shoulder abduction",
             "shoulder extension", "shoulder rotation", "shoulder scaption")
# The joints of a file in their order: name in the SDK (empty: no such joint), and the number of the parent.
CHAIN = (("spine_base", -1), ("spine_mid", 0), ("spine_shoulder", 1), ("neck", 2), ("head", 3), ("", 4),
         ("", 2), ("shoulder_left", 6), ("elbow_left", 7), ("wrist_left", 8),
         ("", 2), ("shoulder_right", 10), ("elbow_right", 11), ("wrist_right", 12),
         ("hip_left", 0), ("knee_left", 14), ("ankle_left", 15), ("foot_left", 16),
         ("hip_right", 0), ("knee_right", 18), ("ankle_right", 19), ("foot_right", 20))
MARKERS = tuple(("LFHD RFHD LBHD RBHD C7 T10 CLAV STRN RBAK LSHO LUPA LELB LFRM LWRA LWRB LFIN RSHO RUPA RELB RFRM RWRA RWRB RFIN "
                 "LASI RASI LPSI RPSI LTHI LKNE LTIB LANK LHEE LTOE RTHI RKNE RTIB RANK RHEE RTOE").split())
SIDE = {"shoulder": "SHO", "elbow": "ELB", "wrist": "WRA WRB", "hip": "ASI PSI", "knee": "KNE", "ankle": "ANK", "foot": "TOE"}
MAPPING = {"head": ("LFHD", "RFHD", "LBHD", "RBHD"), "spine_shoulder": ("CLAV", "C7"),
           "spine_base": ("LASI", "RASI", "LPSI", "RPSI"),
           **{f"{joint}_{side}": tuple(side[0].upper() + marker for marker in markers.split())
              for joint, markers in SIDE.items() for side in ("left", "right")}}
SEARCH_S = 1.5


def table(path: Path, columns: int) -> np.ndarray:
    """Rows of `columns` numbers."""
    try:
        with (gzip.open if path.suffix == ".gz" else open)(path, "rt") as file:
            rows = np.loadtxt(file, delimiter=",", ndmin=2)
    except (OSError, EOFError, ValueError) as error:
        raise InputError(path, f"cannot be read as rows of {columns} numbers: {error}") from error
    if rows.shape[1:] != (columns,) or not np.isfinite(rows).all():
        raise InputError(path, f"has rows of {rows.shape[-1]} numbers, or some that are not finite; {columns} are expected")
    return rows


def rotations(angle_deg: np.ndarray) -> np.ndarray:
    """(N, 3) angles about x, y and z to (N, 3, 3): Rz Rx Ry."""
    (sx, sy, sz), (cx, cy, cz), one, zero = (f(np.radians(angle_deg.T)) for f in (np.sin, np.cos, lambda a: a[0] * 0 + 1,
                                                                                   lambda a: a[0] * 0))
    about_x = np.array([[one, zero, zero], [zero, cx, -sx], [zero, sx, cx]])
    about_y = np.array([[cy, zero, sy], [zero, one, zero], [-sy, zero, cy]])
    about_z = np.array([[cz, -sz, zero], [sz, cz, zero], [zero, zero, one]])
    return np.einsum("ijn,jkn,kln->nil", about_z, about_x, about_y)


def chained_m(position_cm: np.ndarray, angle_deg: np.ndarray) -> np.ndarray:
    """(N, 22, 3) joints in their parents' frames to camera space over the floor: x and z change their sign."""
    turn, place = [], []
    for j, (_, parent) in enumerate(CHAIN):
        own = rotations(angle_deg[:, j])
        turn.append(own if parent < 0 else turn[parent] @ own)
        place.append(position_cm[:, j] if parent < 0
                     else place[parent] + np.einsum("nij,nj->ni", turn[parent], position_cm[:, j]))
    return 0.01 * np.stack(place, axis=1) * [-1.0, 1.0, -1.0]


def read_take(name: str, positions: Path, angles: Path, vicon: Path) -> Take:
    """One repetition of one movement; `name` is m01_s01_e01."""
    movement, participant, _ = name.split("_")
    position_cm, angle_deg = (table(path, 66).reshape(-1, 22, 3) for path in (positions, angles))
    if len(position_cm) != len(angle_deg):
        raise InputError(angles, f"has {len(angle_deg)} rows for {len(position_cm)} of {positions.name}")
    joints = [j for j, (joint, _) in enumerate(CHAIN) if joint]
    truth_m = 0.001 * table(vicon, 117).reshape(-1, 39, 3)
    return Take(name.replace("_", "-"), participant, MOVEMENTS[int(movement[1:]) - 1], 30.0,
                chained_m(position_cm, angle_deg)[:, joints], tuple(CHAIN[j][0] for j in joints), 100.0,
                np.where((truth_m == 0).all(axis=2, keepdims=True), np.nan, truth_m), MARKERS, MAPPING)


def convert(arguments: argparse.Namespace) -> int:
    refuse_rate(arguments)
    takes, left_out = [], []
    for folder in arguments.files:
        found = sorted((folder / "Kinect" / "Positions").glob("m*_positions.txt*"))
        if not found:
            raise InputError(folder, "has no Kinect/Positions/m01_s01_e01_positions.txt or the like; give the folder of the "
                                     "segmented movements")
        for positions in found:
            name = re.fullmatch(r"(m(?:0[1-9]|10)_s\d\d_e\d\d)_positions.txt(?:.gz)?", positions.name)
            if not name:
                left_out.append(f"{positions.name}, which is not named as m01_s01_e01_positions.txt")
                continue
            angles = folder / "Kinect/Angles" / positions.name.replace("positions", "angles")
            vicon = folder / "Vicon/Positions" / positions.name
            if missing := next((path for path in (angles, vicon) if not path.exists()), None):
                left_out.append(f"{positions.name}, which has no {missing.relative_to(folder)}")
                continue
            try:
                takes.append(read_take(name[1], positions, angles, vicon))
            except InputError as error:
                left_out.append(str(error))
    return write_campaign(arguments, "UI-PRMD", takes, left_out, NOTE, SEARCH_S)
