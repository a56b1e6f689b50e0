# SPDX-License-Identifier: MIT
"""Reads session.h5, format 1: bodies and depth of every sensor."""
import json
import os
import tempfile
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

import h5py
import numpy as np

from trilat.errors import InputError, ProgramError
from trilat.skeleton import MIRRORED

try:
    import hdf5plugin  # noqa: F401  (the filter of depth that trilat records)
except ImportError:
    hdf5plugin = None


def open_hdf5(path: Path, file_format: str, newest: int) -> h5py.File:
    """The file, when it is of this format and of no newer version than `newest`."""
    if not path.exists():
        raise InputError(path, "is not there")
    try:
        file = h5py.File(path, "r")
    except OSError as error:
        raise InputError(path, "cannot be read as HDF5; is it cut short? `trilat recover` saves what a crash left of a "
                               "session") from error
    found = file.attrs.get("format", b"")
    found = found.decode() if isinstance(found, bytes) else str(found)
    version = int(file.attrs.get("version", 0))
    if found != file_format:
        raise InputError(path, f'is of the format "{found}"; "{file_format}" is expected')
    if version > newest:
        raise InputError(path, f"has version {version}; this module reads up to {newest}: take the one of the trilat "
                               "that wrote it")
    return file


@dataclass(frozen=True)
class Bodies:
    """All bodies that a sensor saw, B rows in the order of its frames.

    frame (B,) number of the body's frame; time_s (B,) since the sensor's first frame, by its own clock;
    tracking_id (B,); position_m (B, 25, 3) in the sensor's frame; orientation_xyzw (B, 25, 4);
    tracking_state (B, 25) 0 not tracked, 1 inferred, 2 tracked.
    """
    frame: np.ndarray
    time_s: np.ndarray
    tracking_id: np.ndarray
    position_m: np.ndarray
    orientation_xyzw: np.ndarray
    tracking_state: np.ndarray

    def __len__(self) -> int:
        return len(self.frame)


@dataclass(frozen=True)
class JointsInWorld:
    """What every sensor gives of one person, at common instants in the world: the input of an own method.

    time_s (I,) since the recording's start; sensors (S,) their names; position_m (I, S, 25, 3), NaN where a sensor does not
    have a joint; tracking_state (I, S, 25) 0 not tracked, 1 inferred, 2 tracked.
    """
    time_s: np.ndarray
    sensors: tuple[str, ...]
    position_m: np.ndarray
    tracking_state: np.ndarray


class Sensor:
    """One sensor of a session. `attributes` has what the file says of it, its intrinsics included."""

    def __init__(self, group: h5py.Group) -> None:
        self._group = group
        self.name = group.name.rsplit("/", 1)[-1]
        self.attributes = {key: value.decode() if isinstance(value, bytes) else value
                           for key, value in group.attrs.items()}

    def arrival_times_s(self) -> np.ndarray:
        """(N,) when the body frames came, in seconds on the recording's host clock, to some milliseconds.

        The clock of the sensor's machine is set by the exchange of least delay; `trilat run` does better.
        """
        arrival_s = 1e-9 * self._group["body_frames/arrival_ns"][:]
        t1, t2, t3, t4 = self._group["clock_exchanges_ns"][:].astype(float).T
        if len(t1) == 0:
            return arrival_s
        best = np.argmin((t4 - t1) - (t3 - t2))
        return arrival_s - 0.5e-9 * ((t2 - t1) + (t3 - t4))[best]

    def frame_times_s(self) -> np.ndarray:
        """(N,) seconds of the body frames since the first of them, by the sensor's own clock."""
        ticks = self._group["body_frames/device_ticks"][:]
        return (ticks - ticks[:1]) * (1e-9 * int(self.attributes["tick_ns"]))

    def host_times_s(self) -> np.ndarray:
        """(N,) when the body frames were made, in seconds on the recording's host clock: by the sensor's own clock, laid under
        the arrivals, less the stated latency."""
        frames_s = self.frame_times_s()
        return frames_s + np.min(self.arrival_times_s() - frames_s, initial=np.inf) - 1e-9 * int(self.attributes["latency_ns"])

    def bodies(self) -> Bodies:
        """All bodies of all frames."""
        columns = {name: table[:] for name, table in self._group["bodies"].items()}
        frame = columns["frame"].astype(np.int64)
        return Bodies(frame, self.frame_times_s()[frame], columns["tracking_id"], columns["position_m"],
                      columns["orientation_xyzw"], columns["tracking_state"])

    @property
    def depth_frames(self) -> int:
        """How many depth images there are."""
        return len(self._group["depth/sequence"]) if "depth" in self._group else 0

    def depth(self, number: int) -> np.ndarray:
        """Depth image (424, 512) in metres, float32; NaN where nothing was measured."""
        if not 0 <= number < self.depth_frames:
            raise IndexError(f"{self.name} has {self.depth_frames} depth images, not number {number}")
        try:
            image = self._group["depth/frame_mm"][number]
        except OSError as error:
            if hdf5plugin is None:
                raise InputError(self._group.file.filename, "has depth that Blosc compressed; install hdf5plugin "
                                                            "(Debian: python3-hdf5plugin)") from error
            raise
        return np.where(image == 0, np.float32(np.nan), np.float32(1e-3) * image)


class Session:
    """An open session; `session["k1"]` is a sensor. Use it in `with`, or close it."""

    def __init__(self, path: str | os.PathLike) -> None:
        self._file = open_hdf5(Path(path), "trilat.session", 1)
        self.sensors: tuple[str, ...] = tuple(self._file["sensors"])
        self.simulated = bool(self._file.attrs["simulated"])
        note = self._file.attrs["note"]
        self.note: str = note.decode() if isinstance(note, bytes) else note

    def __getitem__(self, name: str) -> Sensor:
        if name not in self.sensors:
            raise InputError(self._file.filename, f'has no sensor "{name}"; it has {", ".join(self.sensors)}')
        return Sensor(self._file["sensors"][name])

    def joints_in_world(self, calibration: str | os.PathLike, rate_hz: float = 30.0, longest_gap_s: float = 0.11,
                        repair_exchanges: bool = True) -> JointsInWorld:
        """Joints of all sensors in the world of calibration.json, interpolated linearly at common instants, never across a
        longer gap. Of several bodies in a frame the one with the most tracked joints is taken: for one person alone. Where a
        tracker took a back for a front, left and right are put right, as a study's own methods see them (`trilat fuse` finds
        where); with `repair_exchanges=False` they are as the sensors gave them."""
        document = json.loads(Path(calibration).read_text(encoding="utf-8"))
        poses = {sensor["name"]: sensor for sensor in document["sensors"]}
        missing = [name for name in self.sensors if name not in poses]
        if missing:
            raise InputError(calibration, f'has no sensor "{missing[0]}"; it has {", ".join(poses)}')
        times_s = {name: self[name].host_times_s() for name in self.sensors}
        start_s, end_s = min(t[0] for t in times_s.values()), max(t[-1] for t in times_s.values())
        time_s = np.arange(int((end_s - start_s) * rate_hz) + 1) / rate_hz
        seen = [_at_instants(self[name].bodies(), times_s[name] - start_s, time_s, longest_gap_s) for name in self.sensors]
        position_m = np.stack([joints_m @ _turn(poses[name]["rotation_xyzw"]).T + poses[name]["position_m"]
                               for name, (joints_m, _) in zip(self.sensors, seen)], axis=1)
        state = np.stack([state for _, state in seen], axis=1)
        if repair_exchanges:
            exchanged = self._exchanged(calibration, time_s, rate_hz)
            position_m[exchanged], state[exchanged] = position_m[exchanged][:, MIRRORED], state[exchanged][:, MIRRORED]
        return JointsInWorld(time_s, self.sensors, position_m, state)

    def _exchanged(self, calibration: str | os.PathLike, time_s: np.ndarray, rate_hz: float) -> np.ndarray:
        """Whether left and right of each sensor (instants, sensors) are exchanged."""
        from trilat.program import call  # which reads results, and they sessions

        path = Path(self._file.filename)
        with tempfile.TemporaryDirectory() as folder:
            try:
                fused = json.loads(call("fuse", path, "--calibration", calibration, "--method", "mean", "--rate-hz", str(rate_hz),
                                        "-o", Path(folder) / "mean.csv", "--json"))
            except (InputError, ProgramError) as error:
                raise InputError(path, f"has left and right put right by `trilat fuse`, which failed: {error}. "
                                            "joints_in_world(..., repair_exchanges=False) gives them as the sensors did") from error
        exchanged = np.zeros((len(time_s), len(self.sensors)), bool)
        for stretch in fused["exchanged"]:
            within = (time_s > stretch["first_s"] - 0.5 / rate_hz) & (time_s < stretch["last_s"] + 0.5 / rate_hz)
            exchanged[within, self.sensors.index(stretch["sensor"])] = True
        return exchanged

    def close(self) -> None:
        self._file.close()

    def __enter__(self) -> "Session":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()


def _turn(xyzw: list[float]) -> np.ndarray:
    """The rotation matrix of a unit quaternion."""
    x, y, z, w = xyzw
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def _at_instants(bodies: Bodies, frame_s: np.ndarray, time_s: np.ndarray, longest_gap_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Positions (I, 25, 3) and states (I, 25) of one person: the worse state of the frames before and after."""
    joints_m = np.full((len(frame_s), 25, 3), np.nan)
    state = np.zeros((len(frame_s), 25), np.uint8)
    for row in np.argsort((bodies.tracking_state == 2).sum(axis=1), kind="stable"):  # the best tracked comes last
        joints_m[bodies.frame[row]], state[bodies.frame[row]] = bodies.position_m[row], bodies.tracking_state[row]
    joints_m[state == 0] = np.nan
    after = np.clip(np.searchsorted(frame_s, time_s), 1, len(frame_s) - 1)
    before = after - 1
    gap_s = frame_s[after] - frame_s[before]
    share = ((time_s - frame_s[before]) / gap_s)[:, None, None]
    there = (time_s >= frame_s[0]) & (time_s <= frame_s[-1]) & (gap_s <= longest_gap_s)
    at_m = joints_m[before] + share * (joints_m[after] - joints_m[before])
    at_m[~there] = np.nan
    return at_m, np.where(np.isfinite(at_m[:, :, 0]), np.minimum(state[before], state[after]), 0)


def session(path: str | os.PathLike) -> Session:
    """Opens session.h5. InputError when it is none, is cut short, or is of a newer version."""
    return Session(path)
