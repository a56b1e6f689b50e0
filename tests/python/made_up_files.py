# SPDX-License-Identifier: MIT
"""Recordings in other people's layouts, of our own making: joint j of frame i stands where joint_m() says."""
import json
import struct
import zlib

import numpy as np

JOINTS = 25
PERIOD_TICKS = 333_333
ID = 72057594037931648
CAMERA = (366.3, 366.5, 256.34, 208.49)  # fx, fy, cx, cy


def joint_m(frame, joint):
    """A person 2.5 m in front of the sensor who goes aside by 1 cm a frame."""
    return [0.01 * frame + 0.05 * (joint % 5) - 0.1, 0.06 * (joint // 5) - 0.15, 2.5 + 0.01 * joint]


def pixel(frame, joint):
    x, y, z = joint_m(frame, joint)
    fx, fy, cx, cy = CAMERA
    return [cx + fx * x / z, cy - fy * y / z]


def labanotation_row(frame, ticks, state="2"):
    joints = "".join(f",{x!r},{y!r},{z!r},{state}" for x, y, z in (joint_m(frame, j) for j in range(JOINTS)))
    return f"{ticks}{joints},\n"


def umons_row(frame, time_ms):
    return " ".join([str(time_ms), *(repr(v) for j in range(JOINTS) for v in joint_m(frame, j))]) + " \n"


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


def kinectron_text(bodies):
    return json.dumps(bodies)


def depth_mm(frame):
    """Every pixel says its frame and its column."""
    return np.broadcast_to(500 + 100 * frame + np.arange(512, dtype=np.uint16), (424, 512)).astype("<u2")


class Xef:
    """Writes .xef files, plain or archived, as far as the layout is known."""
    DEPTH, BODIES = "d614390a163be111aac3001e4fd58c0f", "7951c4a068517548a75cf8f1760f637c"
    INFRARED, RAW = "d714390a163be111aac3001e4fd58c0f", "e214390a163be111aac3001e4fd58c0f"

    def __init__(self, streams, archived=False):
        self.archived, self.streams = archived, streams
        self.data = b"EVENTS1\0" + struct.pack("<Iiq", 5, 0 if archived else streams + 1, 0)
        self.describe(0, "00" * 16, 24)

    def header(self, stream, flags, stored, ticks, full):
        self.data += struct.pack("<HHIqII", stream, flags, stored, ticks, 0, full)

    def describe(self, stream, guid, tag_bytes=4):
        self.header(stream, 0, 292, 0, 292)
        self.data += struct.pack("<HH16s4x", stream, 0, bytes.fromhex(guid)) + bytes(258) + struct.pack("<H", tag_bytes) + bytes(32)
        self.data += bytes(8) if self.archived else b""
        self.header(0, 0, 98, 0, 98)
        self.data += bytes(24 + 98)

    def event(self, stream, ticks, number, payload):
        stored = zlib.compress(payload) if self.archived else payload
        self.header(stream, int(self.archived), len(stored), ticks, len(payload))
        self.data += struct.pack("<I", number) + stored

    def index_block(self, size):
        self.header(0xFFFF, 0, 0, 0, 0)
        self.data += b"\xEE" * size

    def footer(self):
        self.header(self.streams + 1, 0, 0, 0, 0)
        self.data += bytes(0x6B0 - 24)


def xef_bodies(frame, body_id=ID, hand_state=1):
    """A body in slot 3, with the left hand closed and the right one open."""
    data = bytearray(6288)
    struct.pack_into("<f", data, 4, 1.0)
    at = 32 + 1040 * 3
    for j in range(JOINTS):
        struct.pack_into("<fff", data, at + 16 * j, 0.01 * frame, 0.0, 2.0 + 0.01 * j)
        struct.pack_into("<f", data, at + 400 + 16 * j + 12, 1.0)
        struct.pack_into("<i", data, at + 800 + 4 * j, 1)
    struct.pack_into("<iii", data, at + 980, hand_state, 2, 1)
    struct.pack_into("<iii", data, at + 992, 0, 2, 0)
    struct.pack_into("<QI", data, at + 1008, body_id, 1)
    return bytes(data)
