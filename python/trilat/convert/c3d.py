# SPDX-License-Identifier: MIT
"""C3D (c3d.org, "The C3D file format user guide") to an OptiTrack CSV with y up: the markers, and nothing else."""
import argparse
import json
from collections import Counter
from pathlib import Path

import numpy as np

from trilat.convert.motive import file_of, head_of
from trilat.errors import InputError
from trilat.outputs import written_aside

HELP = "motion capture as C3D, to an OptiTrack CSV with y up"
BLOCK, WORD_END = 512, 65535  # bytes; the largest number that a word of the header holds
INTEL, DEC, MIPS = 84, 85, 86
UNIT_M = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254, "ft": 0.3048}
UNIT_NAMES = {"mm": ("millimeters", "millimetres"), "cm": ("centimeters", "centimetres"), "m": ("meters", "metres"),
              "in": ("inches",), "ft": ("feet",)}
NO_MARKERS = ("ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS")  # Vicon's points that POINT names as such
UPRIGHT_M, UPRIGHT_RATIO = 0.6, 1.3  # spread of the named markers along the axis that is up, and over the others'
LARGEST_M = 100.0
USUAL_SPREAD_M = (0.3, 5.0)     # of the markers' mean positions; a hand's spread less, several persons' more
POSSIBLE_SPREAD_M = (0.02, 50.0)  # of any that a study is about
PERSON_SPREAD_M = (0.8, 2.5)


def add_options(verb: argparse.ArgumentParser) -> None:
    verb.add_argument("--unit", choices=UNIT_M, help="of the positions, instead of POINT:UNITS")
    verb.add_argument("--up-axis", choices="yz", help="of the file, instead of what POINT:Y_SCREEN or the markers show")


def real_numbers(data: bytes, processor: int) -> np.ndarray:
    if processor == DEC:  # a VAX counts the exponent from 129, with a mantissa that begins with a half
        words = np.frombuffer(data, "<u2").astype(np.uint32).reshape(-1, 2)
        return (words[:, 0] << 16 | words[:, 1]).view(np.float32) / np.float32(4)
    return np.frombuffer(data, ">f4" if processor == MIPS else "<f4")


def signed(byte: int) -> int:
    return byte - 256 if byte > 127 else byte


def integers(data: bytes, processor: int, kind: str = "u2") -> np.ndarray:
    return np.frombuffer(data, (">" if processor == MIPS else "<") + kind)


class C3d:
    """The header, the parameters and the layout of the frames of one file; InputError names what contradicts itself."""

    def __init__(self, path: Path) -> None:
        self.path, self.notes = path, []
        self.data = np.memmap(path, np.uint8, "r") if path.stat().st_size else np.zeros(0, np.uint8)
        if len(self.data) < BLOCK or self.data[1] != 0x50:
            raise InputError(path, "does not begin as a C3D file does, or ends within its header")
        self.parameters = self.read_parameters(max(int(self.data[0]), 1))
        self.points = int(self.number("POINT:USED", self.word(2)))
        if self.points != self.word(2) and self.word(2) > 0:  # with another width of the rows all numbers would be others
            raise InputError(path, f"contradicts itself: {self.word(2)} points by the header (block 1, word 2), {self.points} by POINT:USED "
                                   f"(block {self.data[0]})")
        if self.points < 1:
            raise InputError(path, "holds no points" + (", and analog channels only" if self.word(3) else ""))
        self.rate_hz = float(self.number("POINT:RATE", self.real(20)))
        if not 1.0 <= self.rate_hz <= 9000.0:
            raise InputError(path, f"POINT:RATE is {self.rate_hz:g}; it must be 1 to 9000 Hz")
        if self.real(20) > 0 and not np.isclose(self.real(20), self.rate_hz, rtol=1e-3):
            self.notes.append(f"the header states {self.real(20):g} Hz, POINT:RATE {self.rate_hz:g} Hz, which is taken")
        self.scale = self.read_scale()
        self.first, self.promised = self.read_range()
        self.start, self.analog, self.frames = self.read_layout()

    def read_parameters(self, block: int) -> dict:
        section = bytes(self.data[BLOCK * (block - 1):])
        if len(section) < 4 or not INTEL <= section[3] <= MIPS:
            raise InputError(f"{self.path} (block {block})", "does not begin the parameters with a processor of 84 (Intel), 85 (DEC) or 86 (MIPS)")
        self.processor = section[3]
        at, end = 4, min(len(section), BLOCK * (section[2] or 255))  # some programs leave the number of blocks at zero
        groups, entries = {}, []
        while at + 4 <= end:
            length, group = abs(signed(section[at])), signed(section[at + 1])  # a negative length: a name that is locked
            name, at = section[at + 2:at + 2 + length].decode("latin-1").upper(), at + 2 + length
            if length == 0 or at + 2 > end:
                break
            step = int(integers(section[at:at + 2], self.processor)[0])
            content = section[at + 2:at + step if step >= 2 else end]
            if group < 0:
                groups[-group] = name
            elif len(content) > 1 + content[1]:
                entries.append((group, name, content))
            if step < 2:
                break
            at += step
        return {f"{groups.get(group, '')}:{name}": (signed(c[0]), c[2:2 + c[1]], c[2 + c[1]:]) for group, name, c in entries}

    def word(self, number: int) -> int:
        """Of the header, from 1 as in the guide."""
        return int(integers(self.data[2 * number - 2:2 * number].tobytes(), self.processor)[0])

    def real(self, offset: int) -> float:
        return float(real_numbers(self.data[offset:offset + 4].tobytes(), self.processor)[0])

    def number(self, name: str, otherwise=None, i: int = 0):
        """Element `i` of a parameter; integers are without sign."""
        size, _, data = self.parameters.get(name, (0, b"", b""))
        if size not in (1, 2, 4) or len(data) < size * (i + 1):
            return otherwise
        element = data[size * i:size * (i + 1)]
        return element[0] if size == 1 else (integers if size == 2 else real_numbers)(element, self.processor)[0].item()

    def texts(self, name: str) -> list[str]:
        """Of a parameter and those with 2, 3, … behind its name, which go on with it."""
        found, part = [], 1
        while (entry := self.parameters.get(name + (str(part) if part > 1 else ""))) and entry[0] == -1:
            length = entry[1][0] if entry[1] else 1
            count = int(np.prod(list(entry[1][1:]), dtype=int)) if length else 0
            found += [entry[2][length * i:length * (i + 1)].decode("latin-1").rstrip(" \0") for i in range(count)]
            part += 1
        return found

    def read_scale(self) -> float:
        """Of integers; negative: the numbers are real."""
        of_header, scale = self.real(12), float(self.number("POINT:SCALE", self.real(12)))
        if not np.isfinite(scale) or scale == 0.0:
            raise InputError(self.path, f"POINT:SCALE is {scale:g}; it must be a number other than zero")
        if (scale > 0 or of_header > 0) and not np.isclose(scale, of_header, rtol=1e-3):
            raise InputError(self.path, f"contradicts itself: the scale is {of_header:g} in the header (block 1, words 7 and 8) and "
                                        f"{scale:g} in POINT:SCALE (block {self.data[0]}); write it anew with the right one in both")
        return scale

    def read_range(self) -> tuple[int, int]:
        """The first frame's number, and how many are promised. The header's words end at 65535; TRIAL has two words each."""
        first, last = self.word(4), self.word(5)
        long = [[self.number(f"TRIAL:ACTUAL_{end}_FIELD", i=i) for i in (0, 1)] for end in ("START", "END")]
        if long[0][0] is not None and long[1][0] is not None:
            first, last = (int(low) + 65536 * int(high or 0) for low, high in long)
        elif last == WORD_END:
            last = max([last] + [first - 1 + int(self.number(f"POINT:{name}", 0)) for name in ("FRAMES", "LONG_FRAMES")])
        if last < first:
            raise InputError(self.path, f"the frames go from {first} to {last}")
        return first, last - first + 1

    def read_layout(self) -> tuple[int, int, int]:
        """Where the first frame begins, analog numbers a frame, and frames: what the size of the file bears out."""
        of_header, block = self.word(9), int(self.number("POINT:DATA_START", 0))
        starts = [b for b in dict.fromkeys((block, of_header)) if b > self.data[0]] or [of_header]
        if block and len(starts) == 2:
            raise InputError(self.path, f"contradicts itself: the points begin in block {of_header} by the header (word 9) and in block "
                                        f"{block} by POINT:DATA_START (block {self.data[0]})")
        start, size = BLOCK * (starts[0] - 1), 4 if self.scale < 0 else 2
        room = {n: (len(self.data) - start) // (size * (4 * self.points + n)) for n in self.analog_counts()}
        fits = [n for n, frames in room.items() if frames >= self.promised]
        exact = [n for n in fits if len(self.data) - start - size * self.promised * (4 * self.points + n) < BLOCK]
        stated = self.word(3)
        if len(room) > 1 and len(exact) != 1:
            raise InputError(self.path, f"contradicts itself: {stated} analog numbers a frame by the header (block 1, word 3), "
                                        f"{max(set(room) - {stated})} by ANALOG:USED and ANALOG:RATE, and the size of the file decides for none")
        analog = exact[0] if len(room) > 1 else stated
        if analog != stated:
            self.notes.append(f"the header states {stated} analog numbers a frame (word 3), ANALOG states {analog}, as the file has room for")
        if room[analog] < self.promised:
            raise InputError(self.path, f"promises {self.promised} frames of {self.points} points, but has room for {room[analog]}")
        frames = self.promised
        if self.first + frames - 1 == WORD_END and room[analog] > frames:  # the word could not say more
            rows = self.data[start:start + size * room[analog] * (4 * self.points + analog)].reshape(room[analog], -1)
            frames = max(frames, room[analog] - int(np.argmax(rows[::-1].any(axis=1))))  # without the zeros that fill a block
        if frames > self.promised:
            self.notes.append(f"the header ends at frame {WORD_END}, the file goes on: {frames} frames are read")
        return start, analog, frames

    def analog_counts(self) -> list[int]:
        rate = float(self.number("ANALOG:RATE", 0.0))
        used = int(self.number("ANALOG:USED", 0))
        by_rate = used * max(round(rate / self.rate_hz), 1) if used and rate > 0 else self.word(3)
        return list(dict.fromkeys((self.word(3), by_rate)))

    def points_of(self, first: int, end: int, chosen: list[int]) -> np.ndarray:
        """(frames, points, 3) in the file's unit; NaN where a point is missing."""
        width, size = 4 * self.points + self.analog, 4 if self.scale < 0 else 2
        data = self.data[self.start + size * width * first:self.start + size * width * end].tobytes()
        numbers = real_numbers(data, self.processor) if size == 4 else integers(data, self.processor, "i2")
        rows = numbers.reshape(end - first, width)[:, :4 * self.points].reshape(end - first, self.points, 4)[:, chosen].astype(float)
        missing = (rows[..., 3] < 0) | ~np.isfinite(rows).all(axis=2) | (rows[..., :3] == 0).all(axis=2)
        return np.where(missing[..., None], np.nan, rows[..., :3] * (1.0 if self.scale < 0 else self.scale))


def markers_of(file: C3d) -> dict[int, str]:
    """Names by the points' places. Unlabelled points, and what is no position, are left out."""
    labels = (file.texts("POINT:LABELS") + [""] * file.points)[:file.points]
    others = {name for group in NO_MARKERS for name in file.texts(f"POINT:{group}")}
    chosen = {i: label for i, label in enumerate(labels) if label and not label.startswith("*") and label not in others}
    if not chosen:
        raise InputError(file.path, "names no markers in POINT:LABELS")
    if len(chosen) < file.points:
        file.notes.append(f"{file.points - len(chosen)} of {file.points} points are no markers: unlabelled, or angles, forces, moments or powers")
    for label, count in Counter(chosen.values()).items():
        if count > 1:
            same = [i for i in chosen if chosen[i] == label]
            chosen |= {i: f"{label}#{i + 1}" for i in same}
            file.notes.append(f"{label} stands {'twice' if count == 2 else f'{count} times'}: {', '.join(chosen[i] for i in same)}")
    return chosen


def unit_of(file: C3d, stated: str | None) -> str:
    text = (file.texts("POINT:UNITS") or [""])[0]
    found = [unit for unit, names in UNIT_NAMES.items()
             if text.lower() == unit or (len(text) >= 4 and any(name.startswith(text.lower()) for name in names))]
    if not stated and len(found) != 1:
        raise InputError(file.path, f'POINT:UNITS is "{text}"; it must be a unit of length such as mm; state it with --unit')
    return stated or found[0]


def refuse_far(file: C3d, position_m: np.ndarray, first: int, names: list[str]) -> None:
    if (far := np.argwhere(np.abs(position_m) > LARGEST_M)).size:
        raise InputError(file.path, f"frame {first + far[0][0]}, {names[far[0][1]]} is more than 100 m away; have the numbers another unit "
                                    "than POINT:UNITS says? State it with --unit")


def spread_of(file: C3d, markers: dict[int, str], unit: str, is_stated: bool) -> np.ndarray:
    """(3,) m: of the markers' mean positions along x, y and z. InputError for a size that nothing has in this unit."""
    position_m = UNIT_M[unit] * file.points_of(0, min(file.frames, 4096), list(markers))
    refuse_far(file, position_m, file.first, list(markers.values()))
    mean_m = np.ma.masked_invalid(position_m).mean(axis=0)
    spread_m = np.ma.filled(mean_m.max(axis=0) - mean_m.min(axis=0), 0.0)
    size_m, (least, most) = spread_m.max(), USUAL_SPREAD_M
    if is_stated or len(markers) < 2 or size_m == 0.0 or least <= size_m <= most:
        return spread_m
    others = [(other, size_m * UNIT_M[other] / UNIT_M[unit]) for other in UNIT_M]
    text = f"the markers spread over {size_m:.2g} m, taken in {UNIT_NAMES[unit][-1]} as POINT:UNITS says" + "".join(
        f"; in {UNIT_NAMES[other][-1]} over {other_m:.2f} m, as those of a person do: state --unit {other}"
        for other, other_m in others if PERSON_SPREAD_M[0] <= other_m <= PERSON_SPREAD_M[1])
    if not POSSIBLE_SPREAD_M[0] <= size_m <= POSSIBLE_SPREAD_M[1]:
        raise InputError(file.path, text)
    file.notes.append(text)
    return spread_m


def up_axis_of(file: C3d, spread_m: np.ndarray, stated: str | None) -> str:
    screen = (file.texts("POINT:Y_SCREEN") or [""])[0].upper()
    longest = int(np.argmax(spread_m))
    shown = "xyz"[longest] if spread_m[longest] > max(UPRIGHT_M, UPRIGHT_RATIO * np.delete(spread_m, longest).max()) else ""
    by_screen = screen[-1:].lower() if screen in ("+Y", "+Z", "Y", "Z") else ""
    axis = stated or by_screen or shown
    if axis not in ("y", "z") or (not stated and by_screen and shown and shown != by_screen):
        raise InputError(file.path, f'does not show which axis is up: POINT:Y_SCREEN is "{screen}", the markers spread {spread_m[0]:.2f}, '
                                    f"{spread_m[1]:.2f} and {spread_m[2]:.2f} m along x, y and z; state --up-axis y or z")
    return axis


def write_csv(path: Path, file: C3d, markers: dict[int, str], unit_m: float, up: str) -> None:
    """Motive's layout, version 1.25, in metres."""
    names, chosen, is_any_seen = list(markers.values()), list(markers), False
    with written_aside(path) as aside, open(aside, "w", encoding="utf-8", newline="") as text:
        rate_hz = f"{file.rate_hz:.6f}"
        text.write(head_of(file.path.stem, f"of {file.path.name}",
                           ["Capture Frame Rate", rate_hz, "Export Frame Rate", rate_hz, "Capture Start Time", "", "Capture Start Frame", file.first,
                            "Total Frames in Take", file.frames, "Total Exported Frames", file.frames],
                           [("Marker", name, i + 1) for name, i in zip(names, chosen)]))
        for begin in range(0, file.frames, 4096):
            position_m = unit_m * file.points_of(begin, min(begin + 4096, file.frames), chosen)
            if up == "z":
                position_m = position_m[..., [0, 2, 1]] * [1.0, 1.0, -1.0]
            refuse_far(file, position_m, file.first + begin, names)
            is_any_seen |= bool(np.isfinite(position_m).any())
            for k, values in enumerate(position_m.reshape(len(position_m), -1), file.first + begin):
                text.write(f"{k},{k / file.rate_hz:.6f}" + "".join("," if v != v else f",{v:.6f}" for v in values) + "\n")
        if not is_any_seen:
            raise InputError(file.path, f"has no position of any of {len(names)} markers in its {file.frames} frames")


def convert(arguments: argparse.Namespace) -> int:
    file = C3d(file_of(arguments))
    markers = markers_of(file)
    unit = unit_of(file, arguments.unit)
    up = up_axis_of(file, spread_of(file, markers, unit, bool(arguments.unit)), arguments.up_axis)
    write_csv(arguments.output, file, markers, UNIT_M[unit], up)
    if arguments.json:
        print(json.dumps({"mocap": str(arguments.output), "frames": file.frames, "rate_hz": file.rate_hz, "unit": unit, "up_axis": up,
                          "markers": list(markers.values()), "notes": file.notes}, indent=2))
    else:
        print(f"{arguments.output}: {file.frames} frames from {file.first} at {file.rate_hz:g} Hz, {len(markers)} markers in {unit}, {up} up"
              f"{', turned so that y is' if up == 'z' else ''}")
        for note in file.notes:
            print(f"note: {note}")
    return 0
