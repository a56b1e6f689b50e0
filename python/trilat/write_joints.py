# SPDX-License-Identifier: MIT
"""Writes joints that an own method gave, as `trilat run` and `trilat compare` read them."""
import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from trilat.errors import InputError


def write_joints(path: str | os.PathLike, time_s: np.ndarray, joints_m: Mapping[str, np.ndarray]) -> None:
    """Writes joints by name, each (N, 3) in metres in the world, NaN where there is none; `time_s` (N,) since the recording's
    start, rising. The name's end says the format: .csv (time_s, joint, x_m, y_m, z_m, to the last digit) or .trc (OpenSim's
    markers in millimetres, at a fixed rate). InputError for other shapes and names."""
    path, time_s = Path(path), np.asarray(time_s, float)
    joints_m = {name: np.asarray(position_m, float) for name, position_m in joints_m.items()}
    if time_s.ndim != 1 or len(time_s) == 0 or not np.all(np.diff(time_s) > 0):
        raise InputError(path, "time_s must be a list of rising times")
    for name, position_m in joints_m.items():
        if position_m.shape != (len(time_s), 3):
            raise InputError(path, f"{name} has the shape {position_m.shape}; ({len(time_s)}, 3) is wanted")
    for name in joints_m:
        if not name or any(sign in name for sign in ',"\t\r\n'):
            raise InputError(path, f"the joint {name!r} must have a name without commas, quotes, tabs and line ends")
    if not joints_m:
        raise InputError(path, "there are no joints")
    if path.suffix == ".csv":
        text = _csv(time_s, joints_m)
    elif path.suffix == ".trc":
        text = _trc(path, time_s, joints_m)
    else:
        raise InputError(path, "must end in .csv or .trc, which say the format")
    aside = path.with_name(path.name + ".partial")
    aside.write_text(text, encoding="utf-8")
    aside.replace(path)


def _csv(time_s: np.ndarray, joints_m: Mapping[str, np.ndarray]) -> str:
    lines = ["time_s,joint,x_m,y_m,z_m"]
    for i, time in enumerate(time_s.tolist()):
        for name, position_m in joints_m.items():
            known = np.all(np.isfinite(position_m[i]))
            lines.append(f"{time!r},{name}," + (",".join(map(repr, position_m[i].tolist())) if known else ",,"))
    return "\n".join(lines) + "\n"


def _trc(path: Path, time_s: np.ndarray, joints_m: Mapping[str, np.ndarray]) -> str:
    steps = np.diff(time_s)
    rate_hz = 1.0 / np.median(steps) if len(steps) else 30.0
    if len(steps) and np.max(np.abs(time_s - time_s[0] - np.arange(len(time_s)) / rate_hz)) > 0.5 / rate_hz:
        raise InputError(path, "a TRC needs times at a fixed rate; write a .csv instead")
    count, names = len(time_s), list(joints_m)
    lines = [f"PathFileType\t4\t(X/Y/Z)\t{path.name}",
             "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames",
             f"{rate_hz:.6f}\t{rate_hz:.6f}\t{count}\t{len(names)}\tmm\t{rate_hz:.6f}\t1\t{count}",
             "Frame#\tTime\t" + "\t\t\t".join(names) + "\t\t",
             "\t\t" + "\t".join(f"{axis}{k}" for k in range(1, len(names) + 1) for axis in "XYZ"), ""]
    for i, time in enumerate(time_s):
        cells = [f"{1e3 * x:.6f}" if np.isfinite(x) else "" for name in names for x in joints_m[name][i]]
        lines.append(f"{i + 1}\t{time:.6f}\t" + "\t".join(cells))
    return "\n".join(lines) + "\n"
