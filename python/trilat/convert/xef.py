# SPDX-License-Identifier: MIT
"""Kinect Studio's .xef, plain or archived, as far as its layout is known: nobody has published it. Little-endian.

The file is a header and events; the first two events of a stream describe it. Damage is stepped over to the next frame
of depth or bodies that has the right length and is not earlier than the last.
"""
import argparse
import mmap
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from trilat.convert.recording import Body, Recording, TornRow, finish, need_one
from trilat.errors import InputError
from trilat.skeleton import JOINT_COUNT
from trilat.write_session import DEPTH_SHAPE

HELP = "Kinect Studio's .xef, plain or archived: depth and bodies (not yet run on a real file)"
NOTE = ("The file holds no absolute time and no intrinsics that could be read: those of a typical Kinect v2 are written. This "
        "converter has not yet been run on a real file.")
MAGIC, HEADER = b"EVENTS1\0", struct.Struct("<HHIqII")  # stream, flags, stored bytes, ticks, -, full bytes
TAG_BYTES, NAME_BYTES, GUID_BYTES, TAG_SIZE_AT = 24, 292, 98, 258
FILE_HEADER_BYTES, FOOTER_BYTES, INDEX_BLOCK, INDEX_BYTES = 24, 0x6B0, 0xFFFF, (0x6000, 0x7000, 0xC000)
LARGEST_BYTES = 64 << 20
KINDS = {bytes.fromhex(guid): kind for guid, kind in {
    "d614390a163be111aac3001e4fd58c0f": "depth", "5b41d985c941f4478dd588c3047bae6b": "depth",
    "7951c4a068517548a75cf8f1760f637c": "bodies", "4ab1321c75126f49b435f6f22d451885": "bodies",
    "e214390a163be111aac3001e4fd58c0f": "raw infrared"}.items()}
FRAME_BYTES = {"depth": 2 * DEPTH_SHAPE[0] * DEPTH_SHAPE[1], "bodies": 6288}
BODY = np.dtype({"names": ["position", "orientation", "state", "hand_left", "hand_right", "id", "tracked"],
                 "formats": [("<f4", (JOINT_COUNT, 4)), ("<f4", (JOINT_COUNT, 4)), ("<i4", JOINT_COUNT), ("<i4", 3), ("<i4", 3),
                             "<u8", "<i4"], "offsets": [0, 400, 800, 980, 992, 1008, 1016], "itemsize": 1040})
SDK_HAND_STATE = (2, 3, 4, 0)  # of raw open, closed, lasso, unknown


@dataclass
class Stream:
    kind: str
    tag_bytes: int
    last_ticks: int = 0


@dataclass
class Event:
    kind: str
    at: int
    data_at: int
    flags: int
    stored: int
    ticks: int
    full: int
    number: int | None


class Events:
    """The events of depth and bodies, in the order of the file; counts what is stepped over."""

    def __init__(self, data: mmap.mmap) -> None:
        self.data, self.streams = data, {}
        self.stream_count = struct.unpack_from("<i", data, 12)[0]
        self.skipped_events = self.skipped_bytes = 0

    def header(self, at: int) -> tuple[int, ...] | None:
        return HEADER.unpack_from(self.data, at) if at + HEADER.size <= len(self.data) else None

    def length(self, at: int, header: tuple[int, ...]) -> int | None:
        """Bytes of the event up to the next one; None when no event can be here."""
        number, flags, stored, _, _, full = header
        stream = self.streams.get(number)
        if stream is None or flags > 1 or max(stored, full) > LARGEST_BYTES or (flags == 0 and full != stored):
            return None
        length = HEADER.size + stream.tag_bytes + stored
        return length if at + length <= len(self.data) else None

    def is_footer(self, at: int, header: tuple[int, ...]) -> bool:
        return (0 < self.stream_count == header[0] and header[0] not in self.streams
                and len(self.data) - at <= FOOTER_BYTES)

    def can_begin(self, at: int) -> bool:
        """Whether the file ends here, or an event, a description or a footer may begin."""
        header = self.header(at)
        if header is None:
            return at == len(self.data)
        if header[0] == INDEX_BLOCK:
            return header[1] == 0
        return (self.length(at, header) is not None or self.is_footer(at, header)
                or (header[2] == NAME_BYTES and header[1] <= 1))

    def description(self, at: int, header: tuple[int, ...]) -> int | None:
        """Takes up the stream that is described here and gives where the description ends."""
        if header[2] != NAME_BYTES or header[1] > 1:
            return None
        tag = at + HEADER.size
        end = tag + TAG_BYTES + NAME_BYTES
        number = struct.unpack_from("<H", self.data, tag)[0] if end <= len(self.data) else INDEX_BLOCK
        if number in self.streams or number == INDEX_BLOCK:
            return None
        for extra in (0, 8):  # archived files have eight bytes more
            guid = self.header(end + extra)
            if guid and guid[2] == GUID_BYTES:
                size = struct.unpack_from("<H", self.data, tag + TAG_BYTES + TAG_SIZE_AT)[0]
                self.streams[number] = Stream(KINDS.get(self.data[tag + 4:tag + 20], "other"), size)
                return min(len(self.data), end + extra + HEADER.size + TAG_BYTES + GUID_BYTES)
        return None

    def behind_damage(self, at: int) -> int:
        """The next place that can only be a frame of depth or bodies, or the end."""
        places = [len(self.data)]
        for kind, full in FRAME_BYTES.items():
            found, pattern = at, struct.pack("<I", full)
            while (found := self.data.find(pattern, found + 1)) >= 0:
                begin = found - (HEADER.size - 4)
                header = self.header(begin) if begin > at else None
                stream = self.streams.get(header[0]) if header else None
                if stream and stream.kind == kind and header[3] >= stream.last_ticks:
                    length = self.length(begin, header)
                    if length and self.can_begin(begin + length):
                        places.append(begin)
                        break
        self.skipped_bytes += min(places) - at
        return min(places)

    def __iter__(self) -> Iterator[Event]:
        at = FILE_HEADER_BYTES
        while at < len(self.data):
            header = self.header(at)
            if header and self.is_footer(at, header):
                return
            if header and header[:2] == (INDEX_BLOCK, 0):
                ends = [at + HEADER.size + size for size in INDEX_BYTES if self.can_begin(at + HEADER.size + size)]
                at = ends[0] if ends else self.behind_damage(at)
                continue
            if header and (end := self.description(at, header)):
                at = end
                continue
            length = self.length(at, header) if header else None
            if length is None:
                at = self.behind_damage(at)
                continue
            stream, begin = self.streams[header[0]], at
            at += length
            if stream.kind not in FRAME_BYTES:
                self.skipped_events += header[0] != 0
                continue
            stream.last_ticks = max(stream.last_ticks, header[3])
            data_at = begin + HEADER.size + stream.tag_bytes
            number = struct.unpack_from("<I", self.data, data_at - 4)[0] if stream.tag_bytes == 4 else None
            yield Event(stream.kind, begin, data_at, header[1], header[2], header[3], header[5], number)

    def payload(self, event: Event) -> bytes:
        """The frame's bytes, inflated."""
        if event.full != FRAME_BYTES[event.kind]:
            raise TornRow(f"is a frame of {event.full} bytes; {FRAME_BYTES[event.kind]} are expected")
        stored = self.data[event.data_at:event.data_at + event.stored]
        try:
            data = zlib.decompress(stored, bufsize=event.full) if event.flags else stored
        except zlib.error as error:
            raise TornRow("is a frame that cannot be decompressed") from error
        if len(data) != event.full:
            raise TornRow("is a frame that cannot be decompressed, or where the file ends")
        return data


def bodies_of(data: bytes) -> list[Body]:
    bodies = []
    for raw in np.frombuffer(data, BODY, offset=32, count=6):
        if raw["tracked"] == 0:
            continue
        hands = np.array([raw["hand_left"], raw["hand_right"]])  # state, whether tracked, confidence
        if raw["state"].min() < 0 or raw["state"].max() > 2 or hands[:, 0].min() < 0 or hands[:, 0].max() > 3:
            raise TornRow("has a tracking state beyond 0 to 2, or a hand state beyond 0 to 3")
        if not np.isfinite(raw["position"][:, :3]).all():
            raise TornRow("has a joint whose position is no number")
        states = [SDK_HAND_STATE[state] if tracked else 1 for state, tracked, _ in hands]
        bodies.append(Body(raw["position"][:, :3], raw["state"].astype(np.uint8), int(raw["id"]), raw["orientation"],
                           (states[0], states[1]), (int(hands[0, 2] == 1), int(hands[1, 2] == 1))))
    return bodies


def convert(arguments: argparse.Namespace) -> int:
    path = need_one(arguments.files, "is a second file; recordings share no clock, so each becomes a session of its own")
    try:
        with open(path, "rb") as file:
            data = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
    except (OSError, ValueError) as error:
        raise InputError(path, f"cannot be opened, or does not begin with EVENTS1: {error}") from error
    if data[:2] == b"PK":
        raise InputError(path, "is a zip archive, as HoloLens writes under the same ending; Kinect Studio's .xef is expected")
    if len(data) < FILE_HEADER_BYTES or data[:8] != MAGIC:
        raise InputError(path, "does not begin with EVENTS1 as Kinect Studio's .xef does")
    events = Events(data)
    frames = list(events)
    if not frames and any(stream.kind == "raw infrared" for stream in events.streams.values()):
        raise InputError(path, "is a raw capture (.xrf), from which depth has yet to be computed; play it in Kinect Studio and "
                               "record depth and bodies")
    if not frames:
        raise InputError(path, "holds neither depth nor bodies")
    recording = Recording("k1", path)
    recording.skipped = {"skipped_events": events.skipped_events, "skipped_bytes": events.skipped_bytes}

    for event in frames:
        if event.kind == "bodies":
            with recording.row(place := f"{path} (byte {event.at})"):
                payload = events.payload(event)
                recording.add(place, event.ticks, bodies_of(payload), event.number, np.frombuffer(payload, "<f4", 4))
    images = [e for e in frames if e.kind == "depth"]
    depth = recording.depth((f"{path} (byte {e.at})", e.ticks, e.number,
                             lambda e=e: np.frombuffer(events.payload(e), "<u2").reshape(DEPTH_SHAPE)) for e in images)
    return finish(arguments, [recording], NOTE, depth={"k1": depth} if images else {})
