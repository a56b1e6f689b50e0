# SPDX-License-Identifier: MIT
"""Writes session.h5, format 1, as datasets/FORMATS.md describes it."""
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from trilat.errors import InputError
from trilat.outputs import written_aside
from trilat.skeleton import JOINT_COUNT

DEPTH_SHAPE = (424, 512)  # rows, columns
MOST_BODIES = 6           # of a frame
MOST_SENSORS = 64
SLOWEST_HZ, FASTEST_HZ = 1.0, 100.0  # of a Kinect's frames, which come 30 times a second
LONGEST_NS = 2**59  # of a clock that began at 0, some 18 years
TICKS_NS = (100, 1, 1000, 1_000_000)  # of clocks that count in 100 ns, ns, us and ms
# A typical Kinect v2, for recordings that do not say their own.
TYPICAL_INTRINSICS = {"fx_px": 365.456, "fy_px": 365.456, "cx_px": 254.878, "cy_px": 205.395,
                      "k1": 0.0905, "k2": -0.2682, "k3": 0.0951, "p1": 0.0, "p2": 0.0}
UNDISTORTED = {"k1": 0.0, "k2": 0.0, "k3": 0.0, "p1": 0.0, "p2": 0.0}
DepthFrame = tuple[int, int, int, np.ndarray]  # sequence, device_ticks, arrival_ns, millimetres (424, 512)


@dataclass
class SensorFrames:
    """What one sensor recorded: N frames, and B bodies in the order of their frames.

    device_ticks      (N,) the sensor's own time stamps, which rise; a tick is `tick_ns` long
    frame             (B,) the row of `device_ticks` that a body belongs to
    position_m        (B, 25, 3) joints in the sensor's frame, in the order of `trilat.JOINTS`
    tracking_state    (B, 25) 0 not tracked, 1 inferred, 2 tracked
    The others may be left out:
    sequence          (N,) frame numbers, where a gap is a lost frame; 0, 1, 2, ...
    arrival_ns        (N,) when frames came, by the clock of the computer; the device's time
    tracking_id       (B,) 1
    orientation_xyzw  (B, 25, 4), hand_state, hand_confidence (B, 2), floor_plane (N, 4): zeros
    depth             (sequence, device_ticks, arrival_ns, image) each frame; image (424, 512), uint16, millimetres
    intrinsics        fx_px, fy_px, cx_px, cy_px and, when there are some, k1, k2, k3, p1, p2
    """
    device_ticks: np.ndarray
    frame: np.ndarray
    position_m: np.ndarray
    tracking_state: np.ndarray
    sequence: np.ndarray | None = None
    arrival_ns: np.ndarray | None = None
    tracking_id: np.ndarray | None = None
    orientation_xyzw: np.ndarray | None = None
    hand_state: np.ndarray | None = None
    hand_confidence: np.ndarray | None = None
    floor_plane: np.ndarray | None = None
    depth: Iterable[DepthFrame] | None = None
    intrinsics: Mapping[str, float] | None = None
    source: str = "python"
    serial: str = ""
    model: str = "Kinect v2"
    tick_ns: int = 100
    rate_hz: float = 30.0
    latency_ns: int = 0


def _check_ticks(name: str, ticks: np.ndarray, tick_ns: int) -> None:
    """InputError for ticks that are no Kinect's: then a tick has another length."""
    if len(ticks) < 3:
        return
    rate_hz = {of: 1e9 / (of * np.median(np.diff(ticks))) for of in (tick_ns, *TICKS_NS)}
    if SLOWEST_HZ <= rate_hz[tick_ns] <= FASTEST_HZ:
        return
    right = next((of for of in TICKS_NS if SLOWEST_HZ <= rate_hz[of] <= FASTEST_HZ), None)
    remedy = f"with tick_ns={right} it has {rate_hz[right]:.4g}" if right else "write device_ticks in a unit that tick_ns states"
    raise InputError(f"sensor {name}", f"has {rate_hz[tick_ns]:.6g} frames a second by device_ticks of {tick_ns} ns, where a Kinect "
                                       f"makes 30; {remedy}")


def _ticks(name: str, given: np.ndarray, tick_ns: int) -> np.ndarray:
    """Whole ticks; InputError for seconds, and for times since 1970."""
    if given.dtype.kind == "f" and len(given) > 2 and SLOWEST_HZ <= 1 / max(np.median(np.diff(given)), 1e-9) <= FASTEST_HZ:
        raise InputError(f"sensor {name}", f"device_ticks rise by {np.median(np.diff(given)):.4g}, as seconds do; write np.rint(seconds * 1e9 / tick_ns)")
    if len(given) and not abs(float(given[0]) * tick_ns) < LONGEST_NS:
        raise InputError(f"sensor {name}", f"device_ticks begin at {given[0]}, {given[0] * tick_ns / 3.156e16:.0f} years from 0, as since 1970; "
                                           "take the first of all sensors from them")
    return _whole(given).astype(np.int64)


def _whole(values: np.ndarray) -> np.ndarray:
    """Fractions rounded; integers as they are, since a float holds no more than 2**53 of them."""
    return np.rint(values) if np.asarray(values).dtype.kind == "f" else np.asarray(values)


def _columns(name: str, s: SensorFrames) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """The tables of frames and of bodies, checked."""
    def column(values: object, default: np.ndarray, what: str) -> np.ndarray:
        array = default if values is None else np.asarray(values)
        if array.shape != default.shape:
            raise InputError(f"sensor {name}", f"{what} has the shape {array.shape}; {default.shape} is expected")
        stored = array.astype(default.dtype)
        if default.dtype.kind in "iu" and (wrong := array[stored != array]).size:
            limits = np.iinfo(default.dtype)
            raise InputError(f"sensor {name}", f"{what} has {wrong.flat[0]}; whole numbers from {limits.min} to {limits.max} are stored")
        return stored

    ticks = _ticks(name, np.asarray(s.device_ticks).reshape(-1), s.tick_ns)
    bodies = len(np.asarray(s.frame).reshape(-1))
    frame = column(s.frame, np.zeros(bodies, np.uint64), "frame").astype(np.int64)
    if (np.diff(ticks) <= 0).any():
        raise InputError(f"sensor {name}", f"device_ticks do not rise after frame {int(np.argmax(np.diff(ticks) <= 0))}")
    _check_ticks(name, ticks, s.tick_ns)
    if bodies and ((np.diff(frame) < 0).any() or frame[0] < 0 or frame[-1] >= len(ticks)):
        raise InputError(f"sensor {name}", f"frame must rise from 0 to at most {len(ticks) - 1}")
    counts = np.bincount(frame, minlength=len(ticks))
    if (counts > MOST_BODIES).any():
        raise InputError(f"sensor {name}", f"frame {int(np.argmax(counts))} has {counts.max()} bodies; "
                                           f"a Kinect tracks at most {MOST_BODIES}")
    zeros = np.zeros
    table = {"frame": frame.astype(np.uint64),
             "tracking_id": column(s.tracking_id, np.ones(bodies, np.uint64), "tracking_id"),
             "position_m": column(s.position_m, zeros((bodies, JOINT_COUNT, 3), np.float32), "position_m"),
             "orientation_xyzw": column(s.orientation_xyzw, zeros((bodies, JOINT_COUNT, 4), np.float32),
                                        "orientation_xyzw"),
             "tracking_state": column(s.tracking_state, zeros((bodies, JOINT_COUNT), np.uint8), "tracking_state"),
             "hand_state": column(s.hand_state, zeros((bodies, 2), np.uint8), "hand_state"),
             "hand_confidence": column(s.hand_confidence, zeros((bodies, 2), np.uint8), "hand_confidence")}
    if (table["tracking_state"] > 2).any() or np.asarray(s.tracking_state).dtype == bool:
        raise InputError(f"sensor {name}", "tracking_state goes from 0 to 2: not tracked, inferred, tracked")
    if not np.isfinite(table["position_m"][table["tracking_state"] > 0]).all():
        raise InputError(f"sensor {name}", "position_m has a joint that is not a number; call it not tracked (state 0)")
    frames = {"sequence": column(s.sequence, np.arange(len(ticks), dtype=np.int64), "sequence"), "device_ticks": ticks,
              "arrival_ns": column(None if s.arrival_ns is None else _whole(s.arrival_ns), ticks * s.tick_ns, "arrival_ns"),
              "floor_plane": column(s.floor_plane, zeros((len(ticks), 4), np.float32), "floor_plane"),
              "body_count": counts.astype(np.uint8)}
    return frames, table


def _text(node: h5py.Group, name: str, text: str) -> None:
    data = text.encode()
    node.attrs.create(name, data, dtype=h5py.string_dtype("utf-8", max(1, len(data))))


def _table(group: h5py.Group, name: str, rows: np.ndarray) -> None:
    group.create_dataset(name, data=rows, maxshape=(None, *rows.shape[1:]), chunks=(32, *rows.shape[1:]), fletcher32=True)


def _write_depth(sensor: h5py.Group, name: str, frames: Iterable[DepthFrame]) -> int:
    depth = sensor.create_group("depth")
    images = depth.create_dataset("frame_mm", (0, *DEPTH_SHAPE), np.uint16, maxshape=(None, *DEPTH_SHAPE),
                                  chunks=(1, *DEPTH_SHAPE), shuffle=True, compression="gzip", compression_opts=1,
                                  fletcher32=True)
    stamps: list[tuple[int, int, int]] = []
    for sequence, ticks, arrival_ns, image in frames:
        if np.shape(image) != DEPTH_SHAPE:
            raise InputError(f"sensor {name}", f"depth frame {len(stamps)} has the shape {np.shape(image)}; "
                                               f"{DEPTH_SHAPE} is expected")
        images.resize(len(stamps) + 1, axis=0)
        images[len(stamps)] = image
        stamps.append((sequence, ticks, arrival_ns))
    columns = np.array(stamps, np.int64).reshape(-1, 3)
    for column, rows in zip(("sequence", "device_ticks", "arrival_ns"), columns.T, strict=True):
        _table(depth, column, rows)
    return len(stamps)


def _write_sensor(group: h5py.Group, name: str, s: SensorFrames) -> None:
    camera = TYPICAL_INTRINSICS if s.intrinsics is None else {**UNDISTORTED, **s.intrinsics}
    frames, bodies = _columns(name, s)
    for key in ("serial", "model", "source"):
        _text(group, key, getattr(s, key))
    integers = {"tick_ns": s.tick_ns, "latency_ns": s.latency_ns, "width_px": DEPTH_SHAPE[1], "height_px": DEPTH_SHAPE[0]}
    for key, integer in integers.items():
        group.attrs.create(key, integer, dtype=np.int64)
    for key, number in {"nominal_rate_hz": s.rate_hz, **camera}.items():
        group.attrs.create(key, number, dtype=np.float64)
    for table, columns in (("body_frames", frames), ("bodies", bodies)):
        node = group.create_group(table)
        for column, rows in columns.items():
            _table(node, column, rows)
    if s.depth is not None:
        _write_depth(group, name, s.depth)
    _table(group, "clock_exchanges_ns", np.zeros((0, 4), np.int64))
    _table(group, "drop_counts", np.zeros((0, 3), np.int64))
    notices = group.create_group("notices")
    _table(notices, "host_ns", np.zeros(0, np.int64))
    _table(notices, "text", np.zeros((0, 240), np.uint8))


def write_session(path: str | os.PathLike, sensors: Mapping[str, SensorFrames], *, note: str = "",
                  started_utc: str = "", simulated: bool = False, force: bool = False) -> Path:
    """Writes a session of these sensors, whole or not at all; `trilat verify` reads it. Returns its path.

    `note` is for people: what was assumed. A file that is there is replaced with `force` alone.
    """
    path = Path(path)
    if path.exists() and not force:
        raise InputError(path, "is there already; take another name, or replace it with force")
    if not 1 <= len(sensors) <= MOST_SENSORS:
        raise InputError(path, f"a session has 1 to {MOST_SENSORS} sensors")
    with written_aside(path) as aside, h5py.File(aside, "w", libver="latest") as file:
        for key, text in {"format": "trilat.session", "created_by": "trilat python", "started_utc": started_utc,
                          "note": note}.items():
            _text(file, key, text)
        for key, integer in {"version": 1, "simulated": int(simulated), "complete": 1}.items():
            file.attrs.create(key, integer, dtype=np.int64)
        group = file.create_group("sensors")
        for name, sensor in sensors.items():
            if not 1 <= len(name) <= 64 or "/" in name:
                raise InputError(path, f'a sensor\'s name has 1 to 64 characters and no "/", is "{name}"')
            _write_sensor(group.create_group(name), name, sensor)
    return path
