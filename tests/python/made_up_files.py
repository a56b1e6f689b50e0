# SPDX-License-Identifier: MIT
"""Recordings in other people's layouts, of our own making: joint j of frame i stands where joint_m() says."""
import struct

import numpy as np

JOINTS = 25
PERIOD_TICKS = 333_333
ID = 72057594037931648
CAMERA = (366.3, 366.5, 256.34, 208.49)  # fx, fy, cx, cy


def joint_m(frame, joint):
    """A person 2.5 m in front of the sensor who goes aside by 1 cm a frame."""
    return [0.01 * frame + 0.05 * (joint % 5) - 0.1, 0.15 - 0.06 * (joint // 5), 2.5 + 0.01 * joint]


def pixel(frame, joint):
    x, y, z = joint_m(frame, joint)
    fx, fy, cx, cy = CAMERA
    return [cx + fx * x / z, cy - fy * y / z]


def labanotation_row(frame, ticks, state="2"):
    joints = "".join(f",{x!r},{y!r},{z!r},{state}" for x, y, z in (joint_m(frame, j) for j in range(JOINTS)))
    return f"{ticks}{joints},\n"


def kimore_files(folder, frames, turns=True):
    rows = [[v for j in range(JOINTS) for v in [*joint_m(i, j), 2]] for i in range(frames)]
    text = "\n".join(",".join(map(str, row)) + "," for row in rows)
    (folder / "JointPosition1.csv").write_text("\n" + text + "\n")
    (folder / "TimeStamp1.csv").write_text("\n".join(str(1000 + PERIOD_TICKS * i) for i in range(frames)) + "\n")
    if turns:
        (folder / "JointOrientation1.csv").write_text("0.1,0.2,0.3,0.9," * JOINTS + "\n" + ("0.1,0.2,0.3,0.9," * JOINTS + "\n") * (frames - 1))
    return folder


def ntu_body(frame, body_id=ID, state="2", joints_m=None, states=None):
    lines = [f"{body_id} 0 1 3 0 2 0 0.25 -0.125 2", str(JOINTS)]
    for j in range(JOINTS):
        u, v = pixel(frame, j)
        place_m = joint_m(frame, j) if joints_m is None else joints_m[j]
        lines.append(" ".join(map(str, [*place_m, u, v, 900, 500, 0.9, 0.1, 0.2, 0.3, state if states is None else states[j]])))
    return "\n".join(lines) + "\n"


def ntu_frame(*bodies):
    return f"{len(bodies)}\n" + "".join(bodies)


def kinectron_body(frame, time_ms, tracked=True, body_id=str(ID), start=1_500_000_000_000):
    joints = []
    for j in range(JOINTS):
        x, y, z = joint_m(frame, j)
        u, v = pixel(frame, j)
        joints.append({"cameraX": x, "cameraY": y, "cameraZ": z, "depthX": u / 512, "depthY": v / 424, "orientationX": 0.1,
                       "orientationY": 0.2, "orientationZ": 0.3, "orientationW": 0.9})
    body = {"tracked": tracked, "record_timestamp": time_ms}
    if start is not None:
        body["record_startime"] = start
    if tracked:
        body.update(trackingId=body_id, leftHandState=3, rightHandState=2, joints=joints)
    return body


def depth_mm(frame):
    """Every pixel says its frame and its column."""
    return np.broadcast_to(500 + 100 * frame + np.arange(512, dtype=np.uint16), (424, 512)).astype("<u2")


class C3d:
    """A C3D file laid out by hand, by the guide of c3d.org: the header, parameters from block 2 on, the points behind them."""

    def __init__(self, processor=84, scale=-1.0, units="mm", labels=("a", "b"), analog=0, first=1, last=None, frames=None, **parameters):
        self.processor, self.scale, self.labels, self.analog, self.first = processor, scale, labels, analog, first
        self.frames = frames if frames is not None else [[1500, 250, -100, 0, 1004, 5, 6, 0], [1501, 250, -100, 0, 9, 9, 9, -1]]
        self.last = first + len(self.frames) - 1 if last is None else last
        self.of_header = {}  # word: value, where the header shall say something else
        self.parameters = {"POINT:UNITS": [units], "POINT:LABELS": list(labels[:255]), "POINT:Y_SCREEN": ["+Y"], **parameters}
        if len(labels) > 255:
            self.parameters["POINT:LABELS2"] = list(labels[255:])

    def integer(self, value):
        return struct.pack(">H" if self.processor == 86 else "<H", int(value) & 0xFFFF)

    def real(self, value):
        if self.processor == 86:
            return struct.pack(">f", value)
        low = struct.pack("<f", 4 * value if self.processor == 85 else value)
        return low[2:] + low[:2] if self.processor == 85 else low

    def content(self, value):
        if isinstance(value, float):
            return b"\x04\0" + self.real(value)
        if isinstance(value, int):
            return b"\x02\0" + self.integer(value)
        if value and isinstance(value[0], int):
            return bytes([2, 1, len(value)]) + b"".join(map(self.integer, value))
        length = max(map(len, value), default=1)
        return bytes([255, 2, length, len(value)]) + "".join(text.ljust(length) for text in value).encode("latin-1")

    def data(self):
        groups = sorted({name.split(":")[0] for name in self.parameters})
        section = bytes([1, 0x50, 0, self.processor])
        for name, value in self.parameters.items():  # a parameter may stand before its group, and its name in any case
            group, name = name.split(":")
            body = self.content(value) + b"\0"
            section += bytes([len(name), groups.index(group) + 1]) + name.title().encode() + self.integer(2 + len(body)) + body
        for number, group in enumerate(groups, 1):
            section += bytes([len(group), 256 - number]) + group.encode() + self.integer(3) + b"\0"
        blocks = (len(section) + 2 + 511) // 512
        section = (section[:2] + bytes([blocks]) + section[3:]).ljust(512 * blocks, b"\0")
        words = {2: len(self.labels), 3: self.analog, 4: self.first, 5: self.last, 6: 0, 9: 2 + blocks, 10: 1} | self.of_header
        header = bytes([2, 0x50]) + b"".join(self.integer(words[n]) for n in range(2, 7)) + self.real(self.scale)
        header += self.integer(words[9]) + self.integer(words[10]) + self.real(100.0)
        number = self.real if self.scale < 0 else self.integer
        rows = b"".join(b"".join(map(number, frame)) + self.analog * number(7777) for frame in self.frames)
        return header.ljust(512, b"\0") + section + rows

