# SPDX-License-Identifier: MIT
"""Joints that other methods and systems gave: `trilat compare`, and takes that bring joints."""
import importlib.util
import json
import math
import os
import re
import shutil
import subprocess
import sys
import time
import unittest
from pathlib import Path

import numpy as np

from made import SOURCE, ScratchTest, cells, made, numbers, trilat

sys.path.insert(0, str(SOURCE / "python"))
import trilat as library  # noqa: E402

RATE_HZ, FRAMES = 50.0, 400
SINGLE_M = 2e-7  # estimates are stored in single precision
NAMES = ("head", "knee_left", "ankle_left", "ankle_right", "LTH3", "Marker 7")
OPENSIM = SOURCE.parent / "shared/data/markers-other/opensim-core/test_walking.trc"


def walk(seed=1, frames=FRAMES, person=0.0):
    """A person's points over time, made up: (time_s, {name: (frames, 3) metres})."""
    rng, time_s = np.random.default_rng(seed), np.arange(frames) / RATE_HZ
    body = np.stack([np.sin(0.5 * time_s), 0.03 * np.sin(7 * time_s), np.cos(0.4 * time_s + person)], axis=1)
    points = {}
    for name, height_m in zip(NAMES, (1.7, 0.5, 0.1, 0.1, 0.8, 1.2)):
        phase = rng.uniform(0, 6, 3)
        swing = 0.3 * np.sin((3.1 + person) * time_s[:, None] + phase) * (1.8 - height_m)
        points[name] = body + swing + [0, height_m, 0] + rng.normal(0, 0.05, 3) * [1, 0, 1]
    return time_s, points


def bias_of(results, cell):
    keys = {key: cell[key] for key in ("group", "method", "alignment")}
    return [numbers(results, measure=axis, statistic="bias", **keys)[0]["value"] for axis in "xyz"]


class Compared(ScratchTest):
    def setUp(self):
        super().setUp()
        self.time_s, self.truth = walk()
        library.write_joints(self.folder / "truth.csv", self.time_s, self.truth)

    def brought(self, name, change, time_s=None):
        times = self.time_s if time_s is None else time_s
        library.write_joints(self.folder / name, times, {key: change(np.array(value), key) for key, value in self.truth.items()})
        return self.folder / name

    def late(self, key, late_s):
        return np.stack([np.interp(self.time_s - late_s, self.time_s, self.truth[key][:, axis]) for axis in range(3)], axis=1)

    def compared(self, *files, code=0, more=()):
        return trilat("compare", self.folder / "truth.csv", *files, "-o", self.folder / "results", "--force", *more, code=code)


class Compare(Compared):
    def test_errors_and_biases_are_those_of_numpy(self):
        rng = np.random.default_rng(2)
        noise = {key: rng.normal(0.02, 0.03, (FRAMES, 3)) for key in NAMES}
        holes = rng.uniform(size=FRAMES) < 0.1
        mine = self.brought("mine.csv", lambda at, key: np.where(holes[:, None] & (key == "head"), np.nan, at + noise[key]))
        # a hole is bridged by a straight line where it is short
        self.compared(mine)
        for key in NAMES:
            given = self.truth[key] + noise[key]
            if key == "head":
                known = np.flatnonzero(~holes)
                given = np.stack([np.interp(self.time_s, self.time_s[known], given[known, axis]) for axis in range(3)], axis=1)
                asked = np.array([holes[i - 1:i + 2].sum() <= 1 for i in range(FRAMES)])
            error = given - self.truth[key]
            cell = {c["alignment"]: c for c in cells(self.folder / "results") if c["group"] == key.replace("_left", "").replace("_right", "")}
            if key in ("head", "ankle_left", "ankle_right"):
                continue  # judged below, or two joints in one group
            self.assertAlmostEqual(cell["none"]["mae_m"], np.linalg.norm(error, axis=1).mean(), delta=SINGLE_M)
            np.testing.assert_allclose(bias_of(self.folder / "results", cell["none"]), error.mean(axis=0), atol=SINGLE_M)
            self.assertAlmostEqual(cell["mean"]["mae_m"], np.linalg.norm(error - error.mean(axis=0), axis=1).mean(), delta=SINGLE_M)
        self.assertTrue(asked.any())
        ankles = np.concatenate([noise["ankle_left"], noise["ankle_right"]])
        cell = next(c for c in cells(self.folder / "results") if c["group"] == "ankle" and c["alignment"] == "none")
        self.assertAlmostEqual(cell["mae_m"], np.linalg.norm(ankles, axis=1).mean(), delta=SINGLE_M)

    def test_it_prints_none_before_mean_in_centimetres_with_the_bias(self):
        said = self.compared(self.brought("mine.trc", lambda at, key: at + [0.03, 0, -0.04]))
        self.assertRegex(said, r"none +mine +5\.00 \(\S+ to \S+\) +100\.0 +3\.00 +0\.00 +-4\.00 +6\n")
        self.assertLess(said.index("none  "), said.index("mean  "))

    def test_a_point_with_the_name_of_the_mean_of_all_is_refused(self):
        self.truth["average"] = self.truth.pop("LTH3")
        library.write_joints(self.folder / "truth.csv", self.time_s, self.truth)
        self.assertIn('has a point called "average"', self.compared(self.brought("mine.csv", lambda at, key: at), code=2))

    def test_the_page_says_the_line_that_makes_it_again(self):
        self.compared(self.brought("mine.csv", lambda at, key: at))
        trilat("report", self.folder / "results", "-o", self.folder / "report")
        self.assertIn("<pre>trilat compare truth.csv mine.csv -o results\n", (self.folder / "report/report.html").read_text())

    def test_what_is_wrong_with_a_file_is_named_with_its_size(self):
        still = lambda at, key: at
        wrong = {
            "late.csv": (still, self.time_s + 0.3, "starts (about )?0.30* s (\\S+ )*later"),
            "early.csv": (still, self.time_s - 0.3, "starts (about )?0.30* s (\\S+ )*earlier"),
            "slow.csv": (still, 2 * self.time_s, "runs 0.5 times as fast as the truth"),
            "thousand.csv": (lambda at, key: at * 0.001, None, "is 0.001 times as large as the truth, as metres taken for millimetres: put right, .* falls from \\S+ to 0.0 cm"),
            "axes.csv": (lambda at, key: at[:, [0, 2, 1]], None, "has other axes than the truth, read as \\(x, z, y\\), which mirrors it: put right"),
            "half.csv": (lambda at, key: np.where(np.arange(FRAMES)[:, None] < FRAMES // 2, at, np.nan), None,
                         "has no position for 50 %|holds 0.00 to"),
            "other.csv": (lambda at, key: walk(seed=9, person=1.3)[1][key] + [2, 0, 1], None, ".*is it the same take, and the same person"),
        }
        for name, (change, times, words) in wrong.items():
            with self.subTest(name):
                said = self.compared(self.brought(name, change, times))
                self.assertRegex(said, f"note: {name}: ({words})")
        sound = self.compared(self.brought("sound.csv", lambda at, key: at + np.random.default_rng(3).normal(0, 0.02, at.shape)))
        self.assertNotIn("note: sound", sound)

    def test_what_turns_a_file_into_the_truth_is_named_with_what_is_left_of_the_error(self):
        def turn(degrees, axis=(0, 1, 0)):
            x, y, z = np.radians(degrees) * np.array(axis) / np.linalg.norm(axis)
            across = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
            return sum(np.linalg.matrix_power(across, n) / math.factorial(n) for n in range(24))
        half, t = np.arange(FRAMES)[:, None] >= FRAMES // 2, self.time_s
        as_it_is = lambda at, key: at
        exchanged = lambda one, other: lambda at, key: self.truth[{one: other, other: one}.get(key, key)]
        kinds = {
            "another frame": ((lambda at, key: at @ turn(25).T + [1, 0, 2], t, "turned by -25 degrees about y and shifted by .*\"rigid\""),
                              (lambda at, key: at @ turn(-70, (1, 2, 0)).T, t, "lies in another frame than the truth, turned by 70 degrees"),
                              (lambda at, key: at + [0.5, 0, 0.4], t, "another frame than the truth, shifted by \\(-0.50, 0.00, -0.40\\) m"),
                              (lambda at, key: at[:, [2, 0, 1]], t, "has other axes than the truth, read as \\(y, z, x\\): put right"),
                              (lambda at, key: at * [1, 1, -1], t, "read as \\(x, y, -z\\), which mirrors it")),
            "names": ((exchanged("ankle_left", "ankle_right"), t, "ankle_left and ankle_right exchanged"),
                      (exchanged("head", "Marker 7"), t, "has head and Marker 7 exchanged")),
            "rate": ((as_it_is, t * 30 / 25, "runs 0.833 times as fast as the truth: .*its stated rate by 1.2"),
                     (as_it_is, t * 25 / 30, "runs 1.2 times as fast as the truth"),
                     (as_it_is, t * 1.01, "runs 0.99 times as fast as the truth: .*its stated rate by 1.01"),
                     (as_it_is, t * 0.9, "runs 1.11 times as fast as the truth: .*its stated rate by 0.9")),
            "start": ((as_it_is, t - 40, "starts 40.00 s earlier than the truth: as it is they have no time in common"),
                      (as_it_is, t + 2, "starts 2.00 s later than the truth.*Take 2.000 s from its times")),
            "size": ((lambda at, key: at * 0.8, t, "is 0.8 times as large as the truth: .*Divide its numbers by 0.8"),
                     (lambda at, key: at * 39.3701, t, "is 39.3701 times as large as the truth, as inches taken for metres"),
                     (lambda at, key: at * (0.001 if key == "ankle_left" else 1), t, "has ankle_left 0.001 times as far away as it is"),
                     (lambda at, key: at * np.where(half, 0.1, 1), t, "is 0.1 times as large from 3.99 s on"),
                     (lambda at, key: at * np.where(half, 1, 0.01), t, "is 0.01 times as large until 3.99 s, as metres taken for centimetres")),
            "relative": ((lambda at, key: at - self.truth["head"], t, "gives positions relative to head"),
                         (lambda at, key: at - (self.truth["ankle_left"] + self.truth["ankle_right"]) / 2, t,
                          "gives positions relative to the middle of ankle_left and ankle_right"),
                         (lambda at, key: at - self.truth["head"] * [1, 0, 1], t, "gives positions relative to head, but for heights"),
                         (lambda at, key: at - at.mean(axis=0), t, "a constant of each point, .* falls from \\S+ to 0.0 cm.*\"mean\""),
                         (lambda at, key: at - at[0], t, "a constant of each point, .*first place")),
            "one axis": ((lambda at, key: at * [1, 1.25, 1], t, "has y 1.2\\d times as large as the truth: .*Divide its y by 1.2"),
                         (lambda at, key: at * [1, 1, 0.5], t, "has z 0.\\d+ times as large as the truth")),
            "names one place off": ((lambda at, key: self.truth[NAMES[NAMES.index(key) - 1]], t, "has points under the names of others: knee_left is head"),
                                    (lambda at, key: self.truth[NAMES[(NAMES.index(key) + 2) % 6]], t, "has points under the names of others:")),
            "one point": ((lambda at, key: self.late(key, 0.3) if key == "head" else at, t, "has head .* \\(0.30 s later than the others: 0 cm\\)"),
                          (lambda at, key: self.late(key, -0.25) if key == "ankle_left" else at, t, "has ankle_left .* \\(0.25 s earlier than the others")),
            "bursts": ((as_it_is, np.floor(t * 5) / 5 + 1e-3 * (np.arange(FRAMES) % 10), "its times come in bursts"),),
            "flat": ((lambda at, key: at * [1, 1, 0], t, "has the same z in every row"),
                     (lambda at, key: at * [1, 0, 1] + [0, 1, 0], t, "has the same y in every row"))}
        noise, tried = np.random.default_rng(4), 0
        for kind, variants in kinds.items():
            for number, (change, times, words) in enumerate(variants):
                name = f"mine.{('csv', 'trc')[number % 2]}"
                with self.subTest(f"{kind} {number}"):
                    said = self.compared(self.brought(name, lambda at, key: change(at, key) + noise.normal(0, 1e-4, at.shape) * (kind != "flat"), times),
                                         code=1 if "40.00" in words else 0)
                    self.assertRegex(said, f"note: {name}: .*{words}")
                    tried += 1
        self.assertEqual(tried, 32)

    def test_a_clock_that_jumps_once_is_named_with_the_time_that_puts_it_right(self):
        self.time_s, self.truth = walk(frames=1500)
        library.write_joints(self.folder / "truth.csv", self.time_s, self.truth)
        noise = np.random.default_rng(5)
        at_s = {}
        for number, (first, end, later_s) in enumerate(((600, 700, 0), (400, 475, 0), (1000, 1200, 0), (700, 700, 3.0), (500, 500, 1.4), (900, 900, 5.0))):
            with self.subTest(f"{first} to {end}, {later_s} s"):
                kept = np.r_[0:first, end:1500]
                times = self.time_s[:len(kept)] + np.where(np.arange(len(kept)) < first, 0.0, later_s)
                name = f"mine.{'trc' if later_s == 0 and number % 2 else 'csv'}"
                library.write_joints(self.folder / name, times, {key: at[kept] + noise.normal(0, 0.01, (len(kept), 3)) for key, at in self.truth.items()})
                said = self.compared(self.folder / name)
                found = re.search(rf"note: {name}: has a clock that jumps at (\S+) s, where .*: put right, .* falls from \S+ to [12].\d cm. (Add|Take) (\S+) s", said)
                self.assertIsNotNone(found, said)
                self.assertAlmostEqual(float(found[1]), first / RATE_HZ, delta=later_s + 0.1)
                self.assertEqual(found[2], "Take" if later_s else "Add")
                self.assertAlmostEqual(float(found[3]), later_s or (end - first) / RATE_HZ, delta=0.02)
                at_s[first] = found[1]
        self.assertEqual(len(at_s), 6)
        other = walk(seed=9, frames=1500, person=1.3)[1]
        library.write_joints(self.folder / "other.csv", self.time_s, {key: at + [2, 0, 1] for key, at in other.items()})
        self.assertRegex(self.compared(self.folder / "other.csv"), "is it the same take, and the same person")

    def test_a_change_in_a_part_of_a_file_is_named_with_where_it_begins(self):
        self.time_s, self.truth = walk(frames=1000)
        library.write_joints(self.folder / "truth.csv", self.time_s, self.truth)
        noise, frames, tried = np.random.default_rng(6), np.arange(1000), 0
        turned = np.array([[math.cos(0.5), 0, math.sin(0.5)], [0, 1, 0], [-math.sin(0.5), 0, math.cos(0.5)]])
        for name, part, change, words in (
                ("shift.csv", frames >= 400, lambda at: at + [0.4, 0.0, 0.5], r"from 8\.\d\d s on lies in another frame than the truth, shifted by"),
                ("shift.trc", frames < 650, lambda at: at + [-0.5, 0.2, 0.4], r"until 1[23]\.\d\d s lies in another frame than the truth, shifted by"),
                ("turn.csv", frames >= 600, lambda at: at @ turned.T, r"from 1[12]\.\d\d s on lies in another frame than the truth, turned by -?(28|29)"),
                ("axes.trc", frames >= 300, lambda at: at[:, [0, 2, 1]] * [1, 1, -1], r"from [56]\.\d\d s on has other axes than the truth"),
                ("mirror.csv", frames < 500, lambda at: at * [-1, 1, 1], r"until (9|10)\.\d\d s .*mirror")):
            with self.subTest(name):
                said = self.compared(self.brought(name, lambda at, key: np.where(part[:, None], change(at), at) + noise.normal(0, 0.01, at.shape)))
                self.assertRegex(said, f"note: {name}: {words}.*: put right there, its mean distance from the truth falls from \\S+ to [12]\\.\\d cm")
                tried += 1
        self.assertEqual(tried, 5)

    def test_stretches_in_which_all_stands_still_are_named_and_not_taken_for_a_lower_rate(self):
        frames = np.arange(FRAMES)
        for name, held, words, absent in (
                ("long.csv", (frames > 100) & (frames <= 250), "to the last digit from 2.00 to 5.00 s after its first frame, as", "true rate"),
                ("long.trc", (frames > 50) & (frames <= 110), "to the last digit from 1.00 to 2.20 s after", "true rate"),
                ("two.csv", ((frames > 50) & (frames <= 110)) | (frames > 300), "from 1.00 to 2.20 s, 6.00 to 7.98 s after", "true rate"),
                ("short.csv", (frames > 100) & (frames <= 140), "", "to the last digit"),
                ("half.csv", frames % 2 == 1, "in 50 % of its frames, so its true rate is 50 %", "to the last digit"),
                ("both.csv", (frames % 2 == 1) | (frames > 200), "true rate is 50 %", "is it a lower rate")):
            with self.subTest(name):
                source = np.maximum.accumulate(np.where(held, 0, frames))
                said = self.compared(self.brought(name, lambda at, key: at[source] + 0.001))
                self.assertRegex(said, f"note: {name}: repeats .*{words}" if words else "compare on truth")
                self.assertNotIn(absent, said)

    def test_positions_in_whole_centimetres_are_said_and_not_taken_for_a_lower_rate(self):
        for name, step_m, words in (("cm.csv", 0.01, "whole steps of 1 cm"), ("cm.trc", 0.01, "whole steps of 1 cm"), ("dm.csv", 0.1, "whole steps of 10 cm"),
                                    ("dm.trc", 0.1, "whole steps of 10 cm"), ("mm.csv", 0.001, ""), ("mm.trc", 0.001, "")):
            with self.subTest(name):
                said = self.compared(self.brought(name, lambda at, key, step=step_m: np.round(at / step) * step))
                self.assertEqual(bool(words), "whole steps" in said, said)
                self.assertIn(words, said)
                self.assertNotIn("true rate", said)

    def test_times_that_count_frames_are_said(self):
        words = "time_s counts by 1, as frame numbers do"
        for first in (0, 1, 1000):
            self.assertIn(words, self.compared(self.brought("mine.csv", lambda at, key: at, np.arange(FRAMES) + first), code=1 if first == 1000 else 0))
        for times in (self.time_s, np.arange(FRAMES) + 0.5, np.arange(FRAMES) * 0.5):
            self.assertNotIn(words, self.compared(self.brought("mine.csv", lambda at, key: at, times)))

    def test_a_missing_column_is_named_among_those_that_are_there(self):
        (self.folder / "mine.csv").write_text("frame,time_s,joint,x_cm,y_cm,z_cm\n0,0,head,1,2,3\n")
        self.assertIn("mine.csv:1: has no column x_m among frame, time_s, joint, x_cm, y_cm, z_cm; needed are time_s, joint, x_m, y_m, z_m",
                      self.compared(self.folder / "mine.csv", code=2))

    def test_a_file_without_a_named_point_says_why(self):
        library.write_joints(self.folder / "mine.trc", self.time_s, {f"Unlabeled {k}": at for k, at in enumerate(self.truth.values())})
        self.assertIn("here are unlabelled markers alone; label them", self.compared(self.folder / "mine.trc", code=2))
        rows = [["Format Version", "1.23", "Take Name", "walk", "Export Frame Rate", "100.000000", "Rotation Type", "Quaternion", "Length Units", "Meters",
                 "Coordinate Space", "Local"], [], ["", "Type", *["Bone"] * 3], ["", "Name", *["head"] * 3], ["", "ID", *["1"] * 3],
                ["", "", *["Position"] * 3], ["Frame", "Time (Seconds)", "X", "Y", "Z"], *([k, f"{k / 100:.6f}", 1, 2, 3] for k in range(50))]
        (self.folder / "mine.csv").write_text("".join(",".join(map(str, row)) + "\n" for row in rows))
        self.assertIn("here are bones relative to their parents alone; export again with the coordinate space Global", self.compared(self.folder / "mine.csv", code=2))
        library.write_joints(self.folder / "mine.csv", self.time_s, {"nose": self.truth["head"]})
        self.assertIn("here are nose; there head, knee_left", self.compared(self.folder / "mine.csv", code=2))

    def test_frames_a_second_apart_are_not_joined_by_lines(self):
        library.write_joints(self.folder / "mine.csv", self.time_s[::50], {key: at[::50] for key, at in self.truth.items()})
        said = self.compared(self.folder / "mine.csv")
        cell = next(c for c in cells(self.folder / "results") if c["group"] == "average" and c["alignment"] == "none")
        self.assertEqual(50 * cell["answered"], cell["asked"])
        self.assertLess(cell["mae_m"], 1e-6)
        self.assertIn("has no position for 9", said)

    def test_times_in_another_unit_or_since_1970_are_said_and_converted(self):
        for unit, begin, words in ((1e-3, 0, "taken as milliseconds, 50 Hz"), (1e-6, 0, "taken as microseconds"), (1e-9, 0, "taken as nanoseconds"),
                                   (1, 1.76e9, "seconds since 1970"), (1e-3, 1.76e9, "seconds since 1970")):
            with self.subTest(words):
                said = self.compared(self.brought("mine.csv", lambda at, key: at + [0.03, 0, 0.04], (self.time_s + begin) / unit))
                self.assertIn(words, said)
                cell = next(c for c in cells(self.folder / "results") if c["group"] == "average" and c["alignment"] == "none")
                self.assertAlmostEqual(cell["mae_m"], 0.05, delta=1e-4)
        library.write_joints(self.folder / "truth.csv", self.time_s + 1.76e9, self.truth)
        said = self.compared(self.brought("mine.csv", lambda at, key: at + [0.03, 0, 0.04], self.time_s + 1.76e9))
        self.assertNotIn("1970", said)
        self.assertIn("5.00 (5.00 to 5.00)", said)
        self.assertIn("not a camera's frame rate", self.compared(self.brought("mine.csv", lambda at, key: at, self.time_s * 1e14), code=2))

    def test_where_z_is_up_all_files_are_turned_alike_and_a_note_says_so(self):
        turned = {key: at[:, [0, 2, 1]] * [1, -1, 1] for key, at in self.truth.items()}
        library.write_joints(self.folder / "truth.csv", self.time_s, turned)
        library.write_joints(self.folder / "mine.csv", self.time_s, {key: at + [0.01, 0.02, 0.03] for key, at in turned.items()})
        said = self.compared(self.folder / "mine.csv", more=["--up", "z"])
        self.assertIn("has its z axis up, as stated", said)
        cell = next(c for c in cells(self.folder / "results") if c["group"] == "average" and c["alignment"] == "none")
        np.testing.assert_allclose(bias_of(self.folder / "results", cell), [0.01, 0.03, -0.02], atol=SINGLE_M)

    def test_a_start_that_the_motion_shows_is_applied_where_that_is_asked_for(self):
        late = self.brought("late.csv", lambda at, key: at, self.time_s + 0.2)
        self.compared(late, more=["--clock-by-motion"])
        cell = next(c for c in cells(self.folder / "results") if c["group"] == "average" and c["alignment"] == "none")
        self.assertLess(cell["mae_m"], 0.01)

    def test_bad_input_is_refused_at_its_place(self):
        mine = self.brought("mine.csv", lambda at, key: at)
        (self.folder / "again").mkdir()
        shutil.copy(mine, self.folder / "again/mine.csv")
        self.assertIn('is called "mine" as a file before it', self.compared(mine, self.folder / "again/mine.csv", code=2))
        (self.folder / "bad.csv").write_text("time_s,joint,x_m,y_m,z_m\n0,head,1,2,three\n")
        self.assertIn('bad.csv:2: z_m is "three", which is not a number', self.compared(self.folder / "bad.csv", code=2))
        (self.folder / "short.csv").write_text("time_s,joint,x_m,y_m\n0,head,1,2\n")
        self.assertIn("short.csv:1: has no column z_m", self.compared(self.folder / "short.csv", code=2))
        (self.folder / "mac.csv").write_bytes(b"time_s,joint,x_m,y_m,z_m\r0,head,1,2,3\r")
        self.assertIn("mac.csv:1: ends its lines by carriage returns alone", self.compared(self.folder / "mac.csv", code=2))
        (self.folder / "far.csv").write_text("time_s,joint,x_m,y_m,z_m\n0,head,1700,2,3\n")
        self.assertIn("far.csv:2: head is more than 100 m; have the numbers another unit", self.compared(self.folder / "far.csv", code=2))
        (self.folder / "two.csv").write_text("time_s,joint,x_m,y_m,z_m\n0,head,1,2,3\n0,head,2,2,3\n")
        self.assertIn("two.csv: has head twice at 0.000000 s", self.compared(self.folder / "two.csv", code=2))
        (self.folder / "notes.csv").write_text("a;b\n1;2\n")
        self.assertIn("notes.csv:1: is neither motion capture", self.compared(self.folder / "notes.csv", code=2))
        library.write_joints(self.folder / "names.csv", self.time_s, {"nobody": self.truth["head"]})
        said = self.compared(self.folder / "names.csv", code=2)
        self.assertIn("names.csv: has no point that truth.csv has: here are nobody; there head", said)

    def test_a_name_that_a_csv_cannot_hold_is_an_error(self):
        for name in ("", "a,b", 'a"b', "a\nb"):
            with self.assertRaisesRegex(library.InputError, "must have a name without commas"):
                library.write_joints(self.folder / "mine.csv", self.time_s, {name: self.truth["head"]})

    def test_one_joint_that_stands_still_says_nothing_on_units(self):
        still = np.tile([0.1, 1.7, 0.2], (FRAMES, 1))
        library.write_joints(self.folder / "truth.csv", self.time_s, {"head": still})
        library.write_joints(self.folder / "mine.csv", self.time_s, {"head": still + np.random.default_rng(6).normal(0, 0.02, still.shape)})
        self.assertNotIn("times as large", self.compared(self.folder / "mine.csv", more=["--up", "y"]))

    def test_what_a_mapping_names_and_no_file_has_is_said(self):
        mapping = self.written("mapping.json", {"format": "trilat.mapping", "version": 1, "joints": {"head": ["head"], "tail": ["Marker 7"]}})
        mine = self.brought("mine.csv", lambda at, key: at)
        mine.write_bytes(b"\xef\xbb\xbf" + mine.read_bytes())  # as a spreadsheet saves it
        said = self.compared(mine, more=["--mapping", mapping])
        self.assertIn("names tail that are in none of the files, and not compared", said)
        self.assertEqual({c["group"] for c in cells(self.folder / "results")}, {"head"})

    def test_names_of_pose_estimators_are_the_joints_that_they_mean(self):
        called = {"head": "Head", "knee_left": "LKnee", "ankle_left": "LAnkle", "ankle_right": "RAnkle"}
        library.write_joints(self.folder / "openpose.trc", self.time_s, {called[key]: self.truth[key] for key in called})
        self.compared(self.folder / "openpose.trc")
        self.assertEqual({c["group"] for c in cells(self.folder / "results")}, {"head", "knee", "ankle", "average"})

    def test_a_subject_before_the_names_changes_nothing_and_two_subjects_are_told_apart(self):
        def written(file, *subjects):
            library.write_joints(self.folder / file, self.time_s, {subject + key: at for subject in subjects for key, at in self.truth.items()})
            return self.folder / file
        for truth, mine in (([""], ["Ann:"]), (["Ann:"], [""]), (["Ann:"], ["Skeleton 001:"]), (["Ann:", "Bob:"], ["Ann:"]), (["Ann:"], ["Bob:", "Ann:"])):
            with self.subTest(f"{truth} {mine}"):
                said = trilat("compare", written("truth.trc", *truth), written("mine.trc", *mine), "-o", self.folder / "results", "--force")
                self.assertIn(f"joints of {len(NAMES)}", said)
                self.assertEqual("not compared" in said, len(mine) == 2)

    @unittest.skipUnless(OPENSIM.exists(), f"{OPENSIM} is not there")
    def test_a_real_trc_against_itself_has_the_shift_and_turn_that_were_put_in(self):
        head, rows = OPENSIM.read_text().splitlines()[:5], [line.split("\t") for line in OPENSIM.read_text().splitlines()[5:] if line.strip()]
        cos, sin = math.cos(0.1), math.sin(0.1)
        moved, lengths = list(head), []
        for row in rows:
            at = np.array([float(x or "nan") for x in row[2:2 + 3 * 40]]).reshape(40, 3)
            seen = np.isfinite(at[:, 0]) & np.any(at != 0, axis=1)
            to = np.stack([cos * at[:, 0] + sin * at[:, 2], at[:, 1], cos * at[:, 2] - sin * at[:, 0]], axis=1) + [10, -20, 5]
            lengths.append(np.where(seen, np.linalg.norm(to - at, axis=1), np.nan))
            moved.append("\t".join([*row[:2], *(f"{x:.6f}" if ok else "" for point, ok in zip(to, seen) for x in point)]))
        (self.folder / "moved.trc").write_text("\n".join(moved) + "\n")
        said = trilat("compare", OPENSIM, self.folder / "moved.trc", "--up", "z", "-o", self.folder / "results")
        groups = [c for c in cells(self.folder / "results") if c["group"] != "average" and c["alignment"] == "none"]
        names = head[3].split("\t")[2::3]
        by_name = dict(zip(names, np.nanmean(np.array(lengths), axis=0) / 1000))
        self.assertGreater(sum(cell["group"] in by_name for cell in groups), 20)
        for cell in groups:
            if cell["group"] in by_name:
                self.assertAlmostEqual(cell["mae_m"], by_name[cell["group"]], delta=1e-8, msg=cell["group"])


class Brought(ScratchTest):
    """A take of the made campaign brings the joints of an own method beside its session."""

    def own_fusion(self, name, repair):
        """Summary of a study with the mean of what the sensors see as a method of its own."""
        camp = self.folder / name
        shutil.copytree(made() / "campaign", camp)
        campaign = json.loads((camp / "campaign.json").read_text())
        for take in campaign["takes"]:
            with library.session(camp / take["session"]) as session:
                seen = session.joints_in_world(camp / take["calibration"], repair_exchanges=repair)
            tracked_m = np.where((seen.tracking_state == 2)[..., None], seen.position_m, np.nan)
            fused_m = np.nansum(tracked_m, axis=1) / np.isfinite(tracked_m).sum(axis=1)
            library.write_joints(camp / f"{take['id']}.csv", seen.time_s, {joint: fused_m[:, number] for number, joint in enumerate(library.JOINTS)})
            take["joints"] = [{"method": "mine", "file": f"{take['id']}.csv"}]
        (camp / "campaign.json").write_text(json.dumps(campaign))
        study = self.written(f"{name}.json", {"format": "trilat.study", "version": 1, "kind": "accuracy", "name": "own", "alignments": ["none"],
                                              "repair_exchanges": repair, "methods": [{"method": "mean"}, {"method": "nonlinear"}]})
        trilat("run", study, "--campaign", camp, "-o", self.folder / "results", "--force")
        return json.loads((self.folder / "results/summary.json").read_text())

    def test_an_own_fusion_stands_in_every_table_beside_the_built_in_methods(self):
        error = {}
        for repair in (False, True):
            with np.errstate(invalid="ignore"):
                summary = self.own_fusion(f"camp{repair}", repair)
            self.assertEqual(summary["methods"], ["mean", "nonlinear", "mine"])
            error[repair] = {c["method"]: c["mae_m"] for c in cells(self.folder / "results") if c["group"] == "average" and c["condition"] == "walking"}
            self.assertAlmostEqual(error[repair]["mine"], error[repair]["mean"], delta=0.01)
            self.assertNotEqual(error[repair]["mine"], error[repair]["mean"])
            self.assertTrue(numbers(self.folder / "results", method="mine", measure="status", statistic="given"))
            self.assertEqual([note for note in summary["notes"] if note["place"].endswith("walking.csv")], [])
        self.assertLess(error[True]["mine"], error[False]["mine"] - 0.01)
        trilat("report", self.folder / "results", "-o", self.folder / "report")
        self.assertIn(">mine<", (self.folder / "report/report.html").read_text())

    def test_takes_without_a_session_need_no_calibration_and_16_are_quick(self):
        takes = []
        (self.folder / "camp").mkdir()
        for person in range(16):
            time_s, truth = walk(seed=person)
            library.write_joints(self.folder / f"camp/{person}.csv", time_s, truth)
            for method, off_m in (("a", 0.02), ("b", 0.03)):
                library.write_joints(self.folder / f"camp/{person}-{method}.csv", time_s, {key: at + [off_m, 0, 0] for key, at in truth.items()})
            takes.append({"id": f"p{person}", "participant": f"p{person}", "activity": "walking", "mocap": f"{person}.csv",
                          "joints": [{"method": method, "file": f"{person}-{method}.csv"} for method in "ab"]})
        self.written("camp/campaign.json", {"format": "trilat.campaign", "version": 1, "name": "brought", "takes": takes})
        study = self.written("study.json", {"format": "trilat.study", "version": 1, "kind": "accuracy", "name": "brought",
                                            "alignments": ["none"], "reference": "b"})
        began = time.monotonic()
        trilat("run", study, "--campaign", self.folder / "camp", "-o", self.folder / "results")
        print(f"16 takes of two brought methods: {time.monotonic() - began:.2f} s")
        error_m = {c["method"]: c["mae_m"] for c in cells(self.folder / "results") if c["group"] == "average"}
        self.assertAlmostEqual(error_m["a"], 0.02, delta=SINGLE_M)
        self.assertAlmostEqual(error_m["b"], 0.03, delta=SINGLE_M)
        solved = self.written("solved.json", {**json.loads(study.read_text()), "methods": [{"method": "mean"}]})
        self.assertIn("/methods: need takes with a session", trilat("run", solved, "--campaign", self.folder / "camp", "-o", self.folder / "x", code=2))
        offsets = self.written("offsets.json", {**json.loads(study.read_text()), "alignments": ["joint_offset"]})
        self.assertIn("/alignments: has joint_offset, which needs a session",
                      trilat("run", offsets, "--campaign", self.folder / "camp", "-o", self.folder / "x", code=2))
        self.assertIn("found", trilat("run", study, "--campaign", self.folder / "camp", "-o", self.folder / "results", "--json"))

    def test_init_finds_the_joints_beside_a_motion_capture(self):
        own, source = self.folder / "own/p01", made() / "campaign/p01-walking"
        own.mkdir(parents=True)
        for name in ("session.h5", "mocap.csv"):
            shutil.copy(source / name, own)
        shutil.copy(made() / "campaign/calibration.json", self.folder / "own")
        mapping = json.loads((made() / "campaign/campaign.json").read_text())["takes"][0]["mapping"]
        shutil.copy(made() / "campaign" / mapping, self.folder / "own/mapping.json")
        time_s, truth = walk()
        library.write_joints(own / "pose2sim.trc", time_s, {"LKnee": truth["knee_left"], "LAnkle": truth["ankle_left"]})
        said = trilat("init", self.folder / "own")
        self.assertIn("beside it lie joints of pose2sim", said)
        take = json.loads((self.folder / "own/campaign.json").read_text())["takes"][0]
        self.assertEqual(take["joints"], [{"method": "pose2sim", "file": "p01/pose2sim.trc",
                                           "mapping": {"knee_left": ["marker:LKnee"], "ankle_left": ["marker:LAnkle"]}}])

    def test_a_method_of_one_name_twice_is_refused(self):
        time_s, truth = walk()
        library.write_joints(self.folder / "t.csv", time_s, truth)
        take = {"id": "a", "participant": "p", "mocap": "t.csv", "joints": [{"method": "m", "file": "t.csv"}] * 2}
        self.written("campaign.json", {"format": "trilat.campaign", "version": 1, "name": "n", "takes": [take]})
        study = self.written("study.json", {"format": "trilat.study", "version": 1, "kind": "accuracy", "name": "s"})
        said = trilat("run", study, "--campaign", self.folder, "-o", self.folder / "x", code=2)
        self.assertIn('/takes/0/joints/1/method: is "m", which other joints of this take have', said)


@unittest.skipIf(importlib.util.find_spec("pandas") is None, "pandas is not installed (Debian: python3-pandas)")
class Frames(Compared):
    def test_joint_angles_are_those_of_numpy(self):
        rng, names = np.random.default_rng(4), ("hip_left", "hip_right", "shoulder_left", "shoulder_right", "knee_left", "ankle_left")
        truth = {name: rng.normal(0, 0.3, 3) + 0.1 * np.sin(rng.uniform(1, 3) * self.time_s[:, None] + rng.uniform(0, 6, 3)) for name in names}
        given = {name: at + rng.normal(0.02, 0.02, at.shape) for name, at in truth.items()}
        library.write_joints(self.folder / "truth.csv", self.time_s, truth)
        library.write_joints(self.folder / "mine.csv", self.time_s, given)
        self.compared(self.folder / "mine.csv", more=["--up", "y"])

        def between(a, b):
            return np.degrees(np.arccos((a * b).sum(axis=1) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1)))

        def angles(at):
            up = np.array([[0.0, 1.0, 0.0]])
            return {"knee flexion": 180 - between(at["hip_left"] - at["knee_left"], at["ankle_left"] - at["knee_left"]),
                    "hip flexion": 180 - between(at["shoulder_left"] - at["hip_left"], at["knee_left"] - at["hip_left"]),
                    "trunk inclination": between((at["shoulder_left"] + at["shoulder_right"] - at["hip_left"] - at["hip_right"]) / 2, up)}

        table = library.tables(self.folder / "results")["angles-truth"].set_index("angle")
        self.assertNotIn("mae_deg_from", table, "one participant has no interval")
        true, mine = angles(truth), angles(given)
        self.assertEqual(set(table.index), set(true))
        for name in true:
            error, row = mine[name] - true[name], table.loc[name]
            for key, wanted in (("mae_deg", np.abs(error).mean()), ("rmse_deg", np.sqrt((error**2).mean())), ("bias_deg", error.mean()),
                                ("range_of_motion_deg", np.ptp(mine[name])), ("truth_range_of_motion_deg", np.ptp(true[name]))):
                self.assertAlmostEqual(row[key], wanted, delta=1e-6, msg=f"{name} {key}")
        self.compared(self.folder / "mine.csv")
        again = library.tables(self.folder / "results")["angles-truth"].set_index("angle")
        self.assertTrue(again.equals(table), "y is the axis that is taken when none is stated")

    def test_the_documents_example_runs(self):
        page = (SOURCE / "docs/how-to/own_method.md").read_text(encoding="utf-8")
        example = re.search(r"```python\n(.*?)```", page, re.DOTALL)[1]
        shutil.copytree(made() / "campaign", self.folder / "camp")
        shutil.copy(made() / "study.json", self.folder / "study.json")
        done = subprocess.run([sys.executable, "-c", example], cwd=self.folder, capture_output=True, text=True, check=False,
                              env={**os.environ, "PYTHONPATH": str(SOURCE / "python")})
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("mine", done.stdout)


if __name__ == "__main__":
    ran = unittest.main(verbosity=2, exit=False).result
    sys.exit(77 if len(ran.skipped) >= max(1, ran.testsRun) else not ran.wasSuccessful())
