# SPDX-License-Identifier: MIT
"""What all converters share: checked frames of one sensor, what was left out of them, and the session."""
import argparse
import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from trilat.errors import InputError
from trilat.skeleton import FARTHEST_JOINT_M, JOINT_COUNT, JOINT_NUMBER, NEAREST_JOINT_M, NOT_TRACKED, TRACKED, states_within_reach
from trilat.write_session import DEPTH_SHAPE, FASTEST_HZ, MOST_BODIES, SLOWEST_HZ, SensorFrames, write_session

TICK_NS = 100
TICKS_PER_S = 1e9 / TICK_NS
MOST_OUT_OF_REACH = 0.5  # of the tracked joints of a recording
MOST_LEFT_OUT = 0.5      # of its frames
MOST_UPSIDE_DOWN, FEWEST_BODIES = 0.9, 30  # of its bodies
UNITS_NS = {"seconds": 1e9, "milliseconds": 1e6, "microseconds": 1e3, "nanoseconds": 1.0, "ticks of 100 ns": 100.0}
USUAL_HZ, USUAL_HZ_WITHIN = 30.0, 0.5  # a third of the frames may be lost
LATEST_TICKS = 2**59 // TICK_NS  # 18 years
FEWEST_FITTED, SMALLEST_SPREAD, LARGEST_RMS_PX = 200, 0.03, 1.0


class TornRow(Exception):
    """A row or frame that is of no use. It is counted, and reading goes on behind it."""


def need_one(files: list[Path], why: str) -> Path:
    """The only file; `why` says what is wrong with a second one."""
    if len(files) > 1:
        raise InputError(files[1], why)
    return files[0]


def refuse_rate(arguments: argparse.Namespace) -> None:
    """For formats whose files say when a frame was made."""
    if arguments.rate_hz:
        raise InputError("--rate-hz", "is not for this format, whose files have time stamps")


def numbered_lines(path: Path) -> Iterator[tuple[str, str]]:
    """(place, line) of every line that is not blank."""
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            for number, line in enumerate(file, 1):
                if line.strip(" \t\r\n,"):
                    yield f"{path}:{number}", line
    except OSError as error:
        raise InputError(path, f"cannot be opened: {error.strerror}") from error


def numbers(cells: Iterable[str], what: str) -> np.ndarray:
    """The cells as finite numbers."""
    cells = list(cells)
    try:
        if any("_" in cell for cell in cells):
            raise ValueError("1_0 is not a number in a data file")
        values = np.array(cells, float)
    except ValueError as error:
        raise TornRow(f"has a cell that is not a number where {what} should be: {error}") from error
    if not np.isfinite(values).all():
        raise TornRow(f'has "{cells[int(np.argmin(np.isfinite(values)))]}" where {what} should be')
    return values


def integer(cell: str, what: str) -> int:
    """The cell as a whole number."""
    try:
        if "_" in cell:
            raise ValueError("1_0 is not a number in a data file")
        return int(cell)
    except ValueError as error:
        raise TornRow(f'has "{cell[:24]}" where {what} should be') from error


def time_of(cell: str) -> float:
    """A time as it is written: whole, or with decimals where it stands in another unit than the format's."""
    try:
        return integer(cell, "the time")
    except TornRow:
        return float(numbers([cell], "the time")[0])


def states_of(values: np.ndarray, place: str) -> np.ndarray:
    """Tracking states. InputError for fractions: then somebody has averaged the file."""
    if (values != np.floor(values)).any():
        raise InputError(place, f"has the tracking state {values[values != np.floor(values)][0]:g}; states are 0, 1 or 2, "
                                "so the file has been averaged or interpolated. Convert it as it was recorded")
    if ((values < 0) | (values > 2)).any():
        raise TornRow(f"has the tracking state {values[(values < 0) | (values > 2)][0]:g}, which goes from 0 to 2")
    return values.astype(np.uint8)


@dataclass
class Body:
    """One body in one frame; shapes as in SensorFrames. `depth_px` (25, 2): where a file says it, else None."""
    position_m: np.ndarray
    tracking_state: np.ndarray = field(default_factory=lambda: np.full(JOINT_COUNT, TRACKED, np.uint8))
    tracking_id: int = 1
    orientation_xyzw: np.ndarray = field(default_factory=lambda: np.zeros((JOINT_COUNT, 4)))
    hand_state: tuple[int, int] = (0, 0)
    hand_confidence: tuple[int, int] = (0, 0)
    depth_px: np.ndarray | None = None


@dataclass
class Stamps:
    """Numbers the frames of one stream, and says why a frame is left out."""
    rate_hz: float
    ticks: int | None = None
    sequence: int = -1
    gap_frames: int = 0

    def next(self, ticks: int, sequence: int | None) -> int:
        """The sequence number: the file's where it rises, else it goes on by the time."""
        if abs(ticks) > LATEST_TICKS:
            raise TornRow(f"has the time {ticks}, which is beyond all clocks")
        if self.ticks is None:
            number = sequence or 0
        else:
            step = max(1, round((ticks - self.ticks) / TICKS_PER_S * self.rate_hz))
            number = sequence if sequence is not None and sequence > self.sequence else self.sequence + step
            self.gap_frames += number - self.sequence - 1
        self.ticks, self.sequence = ticks, number
        return number


class Recording:
    """The frames of one sensor while a file is read; counts what is torn, repeated or goes back in time."""

    def __init__(self, name: str, file: Path, rate_hz: float = 30.0, unit_ns: float = TICK_NS) -> None:
        """`unit_ns` is that of the file's times."""
        self.name, self.file, self.rate_hz, self.unit_ns = name, file, rate_hz, unit_ns
        self.left_out = {"torn_rows": 0, "repeated_times": 0, "backward_times": 0}
        self.first_left_out = ""
        self.stamps = Stamps(rate_hz)
        self.times: list[float] = []  # as written, in ticks, of all frames
        self.frames: list[tuple[int, int]] = []  # sequence, ticks
        self.floors: list[np.ndarray] = []
        self.bodies: list[tuple[int, Body]] = []  # row of its frame
        self.tracked = self.out_of_reach = 0  # joints
        self.first_out_of_reach = ""
        self.rms_px: float | None = None

    def leave_out(self, why: str, place: str, problem: str) -> None:
        """Counts a frame that is not in the session."""
        self.left_out[why] += 1
        self.first_left_out = self.first_left_out or f"{place} {problem}"

    def _number(self, place: str, ticks: int, sequence: int | None) -> int | None:
        if self.stamps.ticks is not None and ticks <= self.stamps.ticks:
            repeated = ticks == self.stamps.ticks
            self.leave_out("repeated_times" if repeated else "backward_times", place,
                           "has the time of the frame before" if repeated else "has a time before that of the frame before")
            return None
        return self.stamps.next(ticks, sequence)

    def add(self, place: str, ticks: float, bodies: list[Body], sequence: int | None = None,
            floor_plane: np.ndarray | None = None) -> None:
        """A frame at `ticks` of 100 ns. Joints where no Kinect measures any are not tracked, and counted."""
        for body in bodies:
            self.tracked += int((body.tracking_state != NOT_TRACKED).sum())
            body.tracking_state, beyond = states_within_reach(body.position_m, body.tracking_state)
            self.out_of_reach += beyond
            if beyond and not self.first_out_of_reach:
                self.first_out_of_reach = f"{place} has a joint {np.linalg.norm(body.position_m, axis=1).max():g} m from the sensor"
        if len(bodies) > MOST_BODIES:
            raise TornRow(f"has {len(bodies)} bodies; a Kinect tracks at most {MOST_BODIES}")
        self.times.append(ticks)
        ticks = round(ticks)
        number = self._number(place, ticks, sequence)
        if number is None:
            return
        self.bodies += [(len(self.frames), body) for body in bodies]
        self.frames.append((number, ticks))
        self.floors.append(np.zeros(4) if floor_plane is None else floor_plane)

    @contextmanager
    def row(self, place: str) -> Iterator[None]:
        """Around the reading of a row: a torn one is counted, with its place."""
        try:
            yield
        except TornRow as torn:
            self.leave_out("torn_rows", place, str(torn))

    def sensor(self, source: str) -> SensorFrames:
        """The frames as write_session() takes them. InputError when there is none."""
        if not self.frames:
            first = f" that can be read; is it in this format? First: {self.first_left_out}" if self.first_left_out else ""
            raise InputError(self.file, "holds no frame" + first)
        self._check_rate()
        self._check_times()
        stamps = np.array(self.frames, np.int64).reshape(-1, 2)
        bodies = [body for _, body in self.bodies]
        self._check_reach()
        self._check_upright(bodies)

        def column(name: str, row_shape: tuple[int, ...], dtype: type) -> np.ndarray:
            return np.array([getattr(body, name) for body in bodies], dtype).reshape(-1, *row_shape)

        return SensorFrames(
            device_ticks=stamps[:, 1], sequence=stamps[:, 0], frame=np.array([row for row, _ in self.bodies], np.uint64),
            position_m=column("position_m", (JOINT_COUNT, 3), np.float32),
            tracking_state=column("tracking_state", (JOINT_COUNT,), np.uint8),
            tracking_id=column("tracking_id", (), np.uint64),
            orientation_xyzw=column("orientation_xyzw", (JOINT_COUNT, 4), np.float32),
            hand_state=column("hand_state", (2,), np.uint8), hand_confidence=column("hand_confidence", (2,), np.uint8),
            floor_plane=np.array(self.floors, np.float32).reshape(-1, 4), intrinsics=self._intrinsics(),
            source=source, tick_ns=TICK_NS, rate_hz=self.rate_hz)

    def _check_rate(self) -> None:
        """InputError for times that are no Kinect's: then they are in another unit."""
        steps = np.diff(self.times)
        if len(steps) < 2 or not (steps > 0).any():
            return
        rate_hz = TICKS_PER_S / np.median(steps[steps > 0])
        if not SLOWEST_HZ <= rate_hz <= FASTEST_HZ:
            factors = {unit: length_ns / self.unit_ns for unit, length_ns in UNITS_NS.items()}
            found = next((unit for unit, by in factors.items() if abs(rate_hz / by / USUAL_HZ - 1) < USUAL_HZ_WITHIN), None)
            remedy = "are they in another unit than this format's?"
            if found:
                by = factors[found]
                remedy = f"as {found} they make {rate_hz / by:.3g}: {f'multiply them by {by:,.0f}' if by > 1 else f'divide them by {1 / by:,.0f}'}"
            raise InputError(self.file, f"has {rate_hz:.6g} frames a second by its times, where a Kinect makes 30; {remedy}")

    def _check_times(self) -> None:
        """InputError where the times of most frames do not rise: then they are not what they are taken for."""
        for why, text in (("repeated_times", "repeat a time; are the times those of the frames?"),
                          ("backward_times", "go back in time; write them in the order of their times.")):
            if self.left_out[why] > MOST_LEFT_OUT * (self.left_out[why] + len(self.frames)):
                raise InputError(self.file, f"has {self.left_out[why] + len(self.frames)} frames, of which {self.left_out[why]} {text} "
                                            f"First: {self.first_left_out}")

    def _check_upright(self, bodies: list[Body]) -> None:
        """InputError for persons on their heads: then y points the other way than this format's."""
        head, ankle = JOINT_NUMBER["head"], JOINT_NUMBER["ankle_left"]
        below = [body.position_m[head, 1] < body.position_m[ankle, 1] for body in bodies if body.tracking_state[[head, ankle]].all()]
        if len(below) >= FEWEST_BODIES and np.mean(below) > MOST_UPSIDE_DOWN:
            raise InputError(self.file, f"has heads below the feet in {np.mean(below):.0%} of its bodies: the sign of y is not that of this "
                                        "format. Turn it in the file")

    def _check_reach(self) -> None:
        """InputError when most joints lie where no Kinect measures any: then they are not in metres."""
        if self.tracked and self.out_of_reach > MOST_OUT_OF_REACH * self.tracked:
            raise InputError(self.file, f"has {self.out_of_reach} of {self.tracked} joints nearer than {NEAREST_JOINT_M} m or farther "
                                        f"than {FARTHEST_JOINT_M:g} m of the sensor; positions must be in metres, not in millimetres or "
                                        f"pixels. First: {self.first_out_of_reach}")

    def _intrinsics(self) -> Mapping[str, float] | None:
        """The depth camera from joints that a file has in space and in pixels: column = cx + fx X / Z, by least squares."""
        seen = [(body.position_m, body.depth_px, body.tracking_state) for _, body in self.bodies if body.depth_px is not None]
        if not seen:
            return None
        position_m, pixel, state = (np.concatenate(part) for part in zip(*seen, strict=True))
        with np.errstate(invalid="ignore"):
            used = (state > 0) & (position_m[:, 2] >= 0.3) & (pixel >= 0).all(1) & (pixel < DEPTH_SHAPE[::-1]).all(1)
        ratio = position_m[used, :2] / position_m[used, 2:]
        if len(ratio) < FEWEST_FITTED or ratio.std(axis=0).min() < SMALLEST_SPREAD:
            return None
        (fx, cx), (fy, cy) = (np.polyfit(ratio[:, axis], pixel[used, axis], 1) for axis in (0, 1))
        self.rms_px = float(np.sqrt(np.mean((pixel[used] - ratio * [fx, fy] - [cx, cy]) ** 2)))
        if self.rms_px > LARGEST_RMS_PX or not (100 < fx < 1000 and 100 < -fy < 1000):
            self.rms_px = None
            return None
        return {"fx_px": fx, "fy_px": -fy, "cx_px": cx, "cy_px": cy}

    def report(self) -> dict[str, object]:
        """What is in the session and what was left out."""
        return {"name": self.name, "file": str(self.file), "body_frames": len(self.frames), "bodies": len(self.bodies),
                "gap_frames": self.stamps.gap_frames,
                "out_of_reach": self.out_of_reach, **self.left_out, "first_left_out": self.first_left_out,
                "intrinsics_rms_px": self.rms_px}


def finish(arguments: argparse.Namespace, recordings: list[Recording], note: str, started_utc: str = "") -> int:
    """Writes the session, says what is in it, and gives the exit code: 1 when something was left out."""
    source = f"import {arguments.format}"
    sensors = {r.name: r.sensor(source) for r in recordings}
    note += (" Intrinsics: fitted to the joints' depth pixels, without distortion."
             if all(r.rms_px is not None for r in recordings) else " Intrinsics: those of a typical Kinect v2.")
    write_session(arguments.output, sensors, note=note, started_utc=started_utc, force=arguments.force)
    return say(arguments, [r.report() for r in recordings], note)


def say(arguments: argparse.Namespace, sensors: list[dict], note: str) -> int:
    """Prints the report, as JSON when that is asked for; 1 when something was left out."""
    if arguments.json:
        print(json.dumps({"session": str(arguments.output), "format": arguments.format, "note": note, "sensors": sensors},
                         indent=2))
    else:
        print(arguments.output)
        for s in sensors:
            camera = "typical intrinsics" if s["intrinsics_rms_px"] is None else f"intrinsics fitted, {s['intrinsics_rms_px']:.2f} px"
            print(f"{s['name']}: {s['body_frames']} body frames with {s['bodies']} bodies; "
                  f"{s['gap_frames']} frames are missing in between; {camera}")
            left_out = s["torn_rows"] + s["repeated_times"] + s["backward_times"]
            if left_out:
                print(f"{s['name']}: {left_out} rows are left out ({s['torn_rows']} torn, {s['repeated_times']} repeat a time, "
                      f"{s['backward_times']} go back); first: {s['first_left_out']}")
            if s["out_of_reach"]:
                print(f"{s['name']}: {s['out_of_reach']} joints lie where no Kinect measures any, and are not tracked in the session")
        print(note)
    return int(any(s["torn_rows"] + s["repeated_times"] + s["backward_times"] > 0 for s in sensors))
