# SPDX-License-Identifier: MIT
"""Reads a session with h5py as datasets/FORMATS.md documents it, and compares it with `trilat info --json`."""
import json
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import h5py
import hdf5plugin  # noqa: F401  (registers the Blosc filter)
import numpy as np

trilat = sys.argv[1]


def check(condition, what):
    if not condition:
        sys.exit("failed: " + what)


def column(group, name, dtype, row_shape):
    table = group[name]
    check(table.dtype == np.dtype(dtype), f"{table.name} is {table.dtype}")
    check(table.shape[1:] == row_shape, f"{table.name} has rows of {table.shape[1:]}")
    return table


def compare(sensor, told):
    frames, bodies = told["body_frames"], told["bodies"]
    for name in ("sequence", "device_ticks", "arrival_ns"):
        check(len(column(sensor["body_frames"], name, "<i8", ())) == frames, name)
    check(column(sensor["body_frames"], "body_count", "u1", ())[:].sum() == bodies, "body_count adds up")
    check(column(sensor["bodies"], "tracking_id", "<u8", ()).shape[0] == bodies, "one id a body")
    positions = column(sensor["bodies"], "position_m", "<f4", (25, 3))[:]
    states = column(sensor["bodies"], "tracking_state", "u1", (25,))[:]
    check(np.isfinite(positions).all() and (states <= 2).all(), "positions are numbers, states are 0, 1, 2")
    check((positions[states == 2][:, 2] > 0.4).all(), "tracked joints lie in front of the sensor")
    depth = column(sensor["depth"], "frame_mm", "<u2", (424, 512))
    check(len(depth) == told["depth_frames"], "depth frames")
    image = depth[len(depth) // 2]
    check(0.5 < (image > 0).mean() <= 1.0 and image.max() < 8000, "depth is in millimetres")


with tempfile.TemporaryDirectory() as folder:
    session = str(Path(folder) / "session.h5")
    subprocess.run([trilat, "record", "--source", "synthetic:2,duration=0.4,speed=max", "-o", session], check=True, capture_output=True)
    told = json.loads(subprocess.run([trilat, "info", "--json", session], check=True, capture_output=True).stdout)
    with h5py.File(session) as file:
        check(file.attrs["format"] in (b"trilat.session", "trilat.session"), "format")
        check(file.attrs["version"] == 1 and file.attrs["complete"] == 1, "version and complete")
        for sensor in told["sensors"]:
            compare(file["sensors"][sensor["name"]], sensor)
    # a log of a recording that was killed, by the lines in the description of the format
    log = Path(folder) / "walk.h5.trilog"
    with subprocess.Popen([trilat, "record", "--source", "synthetic:2,depth=no", "-o", str(log.with_suffix(""))],
                          stderr=subprocess.DEVNULL) as recording:
        while not log.exists() or log.stat().st_size < 60_000:
            time.sleep(0.05)
        recording.kill()
    told = json.loads(subprocess.run([trilat, "info", "--json", str(log)], check=True, capture_output=True).stdout)
    formats = (Path(__file__).resolve().parents[2] / "datasets/FORMATS.md").read_text(encoding="utf-8")
    (recipe,) = re.findall(r"```python\n(.*?)```", formats, re.DOTALL)
    names = {}
    exec(recipe.replace('"walk.h5.trilog"', repr(str(log))), names)  # pylint: disable=exec-used
    kinds = [(kind, sensor) for kind, sensor, _ in names["records_of"](log)]
    check(kinds[0] == (1, 0) and len(kinds) > 20, "the head comes first")
    for index, sensor in enumerate(told["sensors"]):
        check(kinds.count((2, index)) == sensor["body_frames"], "body frames of a log")
    check(all(np.isfinite(head).all() and 0.4 < head[2] < 8 for head in names["heads_m"]), "a head is before its sensor")
print("h5py reads what was written, and Python a log")
