# SPDX-License-Identifier: MIT
"""A folder of depth images, 16-bit grey PNG of 512 x 424; the unit, and where times come from, must be said."""
import argparse
import re
import sys
from pathlib import Path

import numpy as np

from trilat.convert.recording import TICKS_PER_S, Recording, TornRow, finish, need_one
from trilat.errors import InputError
from trilat.write_session import DEPTH_SHAPE

HELP = ("folder of depth images: 16-bit grey PNG, 512 x 424; needs --depth-unit-mm and one of --rate-hz, --timestamps, "
        "--time-from-name")
NEAREST_MM, FARTHEST_MM = 500, 8000  # that a Kinect v2 can measure


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--depth-unit-mm", type=float, help="what a value of 1 means; 1 for Kinect v2 and NTU, 0.2 for TUM")
    parser.add_argument("--timestamps", type=Path, help="file with one time in seconds a line, in the order of the names")
    parser.add_argument("--time-from-name", action="store_true", help="the last number in a name is its time in seconds")


def read_image(path: Path, unit_mm: float) -> np.ndarray:
    from PIL import Image
    try:
        with Image.open(path) as image:
            if image.size != DEPTH_SHAPE[::-1] or image.mode not in ("I;16", "I;16B", "I"):
                raise InputError(path, f"is {image.size[0]} x {image.size[1]} of mode {image.mode}; depth images of a Kinect "
                                       "v2 are 512 x 424 with 16 bits, grey")
            depth_mm = np.round(np.asarray(image).astype(float) * unit_mm)
    except (OSError, SyntaxError) as error:
        raise TornRow(f"cannot be read: {error}") from error
    if depth_mm.max() > np.iinfo(np.uint16).max:
        raise InputError(path, f"has a depth of {depth_mm.max():.0f} mm; is --depth-unit-mm {unit_mm:g} right?")
    return depth_mm.astype(np.uint16)


def times_s(images: list[Path], arguments: argparse.Namespace) -> tuple[list[float], str]:
    """A time an image, and where it comes from."""
    if arguments.rate_hz:
        return [i / arguments.rate_hz for i in range(len(images))], "the image's number / rate"
    if arguments.time_from_name:
        found = [re.findall(r"\d+(?:\.\d+)?", image.stem) for image in images]
        if [] in found:
            raise InputError(images[found.index([])], "has no number in its name, and --time-from-name is given")
        return [float(numbers[-1]) for numbers in found], "the last number of each name, in seconds"
    try:
        times = [float(line) for line in arguments.timestamps.read_text().split()]
    except (OSError, ValueError) as error:
        raise InputError(arguments.timestamps, f"cannot be read as one time in seconds a line: {error}") from error
    if len(times) != len(images):
        raise InputError(arguments.timestamps, f"holds {len(times)} times for {len(images)} images")
    return times, f"those of {arguments.timestamps.name}"


def convert(arguments: argparse.Namespace) -> int:
    folder = need_one(arguments.files, "is a second folder; a folder is a sensor and a session")
    unit_mm, images = arguments.depth_unit_mm, sorted(folder.glob("*.png"))
    if not unit_mm or unit_mm <= 0:
        raise InputError("--depth-unit-mm", "is missing or not above 0: what a value of 1 means is not in the images")
    if (arguments.rate_hz is not None) + arguments.time_from_name + (arguments.timestamps is not None) != 1:
        raise InputError("--rate-hz, --timestamps, --time-from-name", "say when the images were made; give one of them")
    if not images:
        raise InputError(folder, "is no folder of depth images, or holds no .png")
    times, origin = times_s(images, arguments)
    recording, seen = Recording("k1", folder, arguments.rate_hz or 30.0), np.zeros(3, int)  # values, outside, farthest

    def read(image: Path) -> np.ndarray:
        depth_mm = read_image(image, unit_mm)
        outside = (depth_mm > 0) & ((depth_mm < NEAREST_MM) | (depth_mm > FARTHEST_MM))
        seen[:] = seen[0] + (depth_mm > 0).sum(), seen[1] + outside.sum(), max(seen[2], depth_mm.max())
        return depth_mm

    order = np.argsort(times, kind="stable") if arguments.time_from_name else range(len(images))
    depth = recording.depth((str(images[i]), round(TICKS_PER_S * times[i]), None, lambda i=i: read(images[i])) for i in order)
    code = finish(arguments, [recording], f"Values count {unit_mm:g} mm each; times are {origin}. Intrinsics: those of a typical "
                                          "Kinect v2.", depth={"k1": depth})
    # Infrared pictures look like depth images, too.
    if seen[1]:
        print(f"note: of {seen[0]} values that are not 0, {seen[1]} ({100 * seen[1] / seen[0]:.1f} %) lie outside the 0.5 to 8 m that "
              f"the sensor can measure, up to {1e-3 * seen[2]:.1f} m: are these depth images, and is --depth-unit-mm right?", file=sys.stderr)
    return code
