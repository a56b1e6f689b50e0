# SPDX-License-Identifier: MIT
"""What `trilat info` says of motion capture and sessions, line by line."""
import json
import sys
import unittest

import numpy as np

from made import SOURCE, ScratchTest, trilat

sys.path.insert(0, str(SOURCE / "python"))
import trilat as library  # noqa: E402

PERSON = {"head": (0.0, 1.7, 0.0), "hip_left": (0.1, 1.0, 0.0), "knee_left": (0.1, 0.5, 0.05), "ankle_left": (0.1, 0.1, 0.0)}


def standing(frames, axes=(0, 1, 2)):
    """Points of a person who walks 1 m along x, by name."""
    on = np.linspace(0, 1, frames)[:, None] * [1.0, 0.0, 0.0]
    return {name: (np.array(at) + on)[:, axes] for name, at in PERSON.items()}


class Info(ScratchTest):
    def said(self, name, time_s, points):
        library.write_joints(self.folder / name, time_s, points)
        text, told = trilat("info", self.folder / name), json.loads(trilat("info", self.folder / name, "--json"))
        return text.splitlines(), told

    def test_motion_capture_has_its_frames_rate_height_and_what_is_missing(self):
        points = standing(101)
        points["knee_left"][20:30] = np.nan
        points["ankle_left"][50:55] = 0.0
        lines, told = self.said("walk.trc", np.arange(101) / 50, points)
        self.assertIn("walk.trc: TRC, take \"walk", lines[0])
        self.assertEqual(lines[1], "101 frames from 1 at 50 Hz (2.000 s), unit millimetre")
        self.assertRegex(lines[2], r"^up: probably y; the assets spread \d\.\d\d, \d\.\d\d, 0\.0\d m along x, y, z$")
        self.assertEqual(lines[3], "odd: ankle_left: 5 positions are exactly (0, 0, 0), taken as missing")
        self.assertEqual([line.split() for line in lines[4:]], [
            ["type", "name", "samples", "missing", "frozen"], ["marker", "head", "101", "0", "0"], ["marker", "hip_left", "101", "0", "0"],
            ["marker", "knee_left", "91", "10", "0"], ["marker", "ankle_left", "101", "0", "0"]])
        self.assertEqual([told[key] for key in ("format", "frames", "duration_s", "rate_hz", "probably_up", "index_gaps")], ["TRC", 101, 2.0, 50.0, "y", 0])
        self.assertEqual([asset["at_origin"] for asset in told["assets"]], [0, 0, 0, 5])

    def test_a_height_along_z_comes_with_the_key_that_states_it(self):
        lines, told = self.said("walk.trc", np.arange(50) / 50, standing(50, (0, 2, 1)))
        self.assertIn('up: probably z (state "up_axis": "z" in the take; init does)', lines[2])
        self.assertEqual(told["probably_up"], "z")

    def test_frames_that_are_missing_are_counted(self):
        points = {name: np.delete(at, slice(30, 40), axis=0) for name, at in standing(101).items()}
        library.write_joints(self.folder / "walk.trc", np.arange(91) / 50, points)
        head, rows = (lines := (self.folder / "walk.trc").read_text().splitlines())[:5], lines[5:]
        rows = [row for row in rows if row.strip()]
        for k in range(30, 91):
            cells = rows[k].split("\t")
            rows[k] = "\t".join([str(k + 11), f"{(k + 10) / 50:.6f}", *cells[2:]])
        (self.folder / "walk.trc").write_text("\n".join([*head, "", *rows, ""]))
        self.assertIn("1 gaps in the frame numbers, 10 frames missing", trilat("info", self.folder / "walk.trc"))
        told = json.loads(trilat("info", self.folder / "walk.trc", "--json"))
        self.assertEqual((told["frames"], told["index_gaps"], told["skipped_frames"], told["duration_s"]), (91, 1, 10, 2.0))

    def test_a_session_has_a_line_a_sensor(self):
        frames = 91
        body = np.zeros((frames, 25, 3)) + np.arange(25)[:, None] * [0.01, 0.05, 0.0] + [0.0, 0.0, 2.5]
        kinect = library.SensorFrames(device_ticks=np.arange(frames) * 333_333, frame=np.arange(frames), position_m=body, tracking_state=np.full((frames, 25), 2))
        slow = library.SensorFrames(device_ticks=np.arange(frames)[::2] * 333_333, frame=np.arange(0, 46), position_m=body[::2], tracking_state=np.full((46, 25), 2))
        library.write_session(self.folder / "own.h5", {"left": kinect, "right": slow}, note="made up")
        lines = trilat("info", self.folder / "own.h5").splitlines()
        self.assertTrue(lines[0].endswith("own.h5: session, complete, written by trilat python"), lines[0])
        self.assertEqual([line.split() for line in lines[2:4]], [["left", "91", "91", "3.00", "30.000", "0", "0"], ["right", "46", "46", "3.00", "15.000", "0", "0"]])
        told = json.loads(trilat("info", self.folder / "own.h5", "--json"))
        self.assertEqual([sensor["name"] for sensor in told["sensors"]], ["left", "right"])
        self.assertAlmostEqual(told["sensors"][1]["rate_hz"], 15.0, places=3)
        self.assertAlmostEqual(told["sensors"][0]["duration_s"], 90 * 0.0333333, places=9)


if __name__ == "__main__":
    ran = unittest.main(verbosity=2, exit=False).result
    sys.exit(77 if len(ran.skipped) >= max(1, ran.testsRun) else not ran.wasSuccessful())
