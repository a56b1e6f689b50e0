# SPDX-License-Identifier: MIT
"""Files of joints that differ from the truth in a few points, at some times, or in what they call things."""
import json
import unittest

import numpy as np

from compare_test import FRAMES, NAMES, Compared, cells, library, trilat, walk

LIMBS = ("shoulder", "elbow", "wrist", "hip", "knee", "ankle", "foot")
SKELETON = ("spine_base", "spine_shoulder", "neck", *(f"{joint}_{side}" for side in ("left", "right") for joint in LIMBS))
BONES = {  # what each joint is called where bones begin there, and the collar bones
    "mixamo": ("Hips", "Neck", "Head", "{side}Arm", "{side}ForeArm", "{side}Hand", "{side}UpLeg", "{side}Leg", "{side}Foot", "{side}ToeBase", "{side}Shoulder"),
    "unity": ("Hips", "Neck", "Head", "{side}UpperArm", "{side}LowerArm", "{side}Hand", "{side}UpperLeg", "{side}LowerLeg", "{side}Foot", "{side}Toes", "{side}Shoulder"),
    "xsens": ("Pelvis", "Neck", "Head", "{side}UpperArm", "{side}Forearm", "{side}Hand", "{side}UpperLeg", "{side}LowerLeg", "{side}Foot", "{side}Toe", "{side}Shoulder"),
    "unreal": ("pelvis", "neck_01", "head", "upperarm_{s}", "lowerarm_{s}", "hand_{s}", "thigh_{s}", "calf_{s}", "foot_{s}", "ball_{s}", "clavicle_{s}"),
    "prefix": tuple("mixamorig:" + name for name in ("Hips", "Neck", "Head", "{side}Arm", "{side}ForeArm", "{side}Hand", "{side}UpLeg", "{side}Leg", "{side}Foot",
                                                     "{side}ToeBase", "{side}Shoulder"))}


MOTIVE = ("Hip", "Neck", "Head", "{s}UArm", "{s}FArm", "{s}Hand", "{s}Thigh", "{s}Shin", "{s}Foot", "{s}Toe", "{s}Shoulder")


def called(names):
    """{joint: name} of a convention, and the names of both collar bones."""
    joints, collars = dict(zip(SKELETON[:3], names)), []
    for side in ("left", "right"):
        words = {"side": side.title(), "s": side[0] if names[3].endswith("}") else side[0].upper()}
        joints.update({f"{joint}_{side}": name.format(**words) for joint, name in zip(LIMBS, names[3:])})
        collars.append(names[10].format(**words))
    return joints, collars


def write_motive_bones(path, time_s, points):
    rows = [["Format Version", "1.23", "Take Name", "walk", "Export Frame Rate", f"{1 / (time_s[1] - time_s[0]):.6f}", "Rotation Type", "Quaternion",
             "Length Units", "Meters", "Coordinate Space", "Global"], [],
            ["", "Type", *["Bone"] * 3 * len(points)], ["", "Name", *(f"Ann:{name}" for name in points for _ in range(3))],
            ["", "ID", *(str(k) for k in range(len(points)) for _ in range(3))], ["", "", *["Position"] * 3 * len(points)],
            ["Frame", "Time (Seconds)", *["X", "Y", "Z"] * len(points)]]
    rows += [[k, f"{t:.6f}", *(f"{x:.6f}" for at in points.values() for x in at[k])] for k, t in enumerate(time_s)]
    path.write_text("".join(",".join(map(str, row)) + "\n" for row in rows))


def turn_y(angle):
    return np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])


class Odd(Compared):
    def setUp(self):
        super().setUp()
        self.noise = np.random.default_rng(8)

    def said_of(self, name, change):
        said = self.compared(self.brought(name, lambda at, key: change(at, key) + self.noise.normal(0, 0.01, at.shape)))
        return [line for line in said.splitlines() if line.startswith(f"note: {name}: ")]

    def test_points_that_alone_are_off_are_named(self):
        other = lambda at, key: at[:, [1, 0, 2]] if key == "ankle_left" else at
        copied = self.truth["knee_left"] + self.noise.normal(0, 0.01, (FRAMES, 3))
        for name, change, words in (
                ("axes.csv", other, "has ankle_left \\d+ cm from the truth, and half of its points less than \\d.\\d cm"),
                ("up.trc", lambda at, key: at + [0, 0.4 * (key == "LTH3"), 0], "has LTH3 40 cm from the truth"),
                ("still.csv", lambda at, key: at[0] + 0 * at if key == "head" else at, "has head \\d+ cm from the truth"),
                ("late.trc", lambda at, key: np.roll(at, 60, axis=0) if key == "knee_left" else at, "has knee_left \\d+ cm from the truth")):
            with self.subTest(name):
                self.assertRegex("\n".join(self.said_of(name, change)), words)
        for name in ("copy.csv", "copy.trc"):
            library.write_joints(self.folder / name, self.time_s, {**{key: at + 0.001 for key, at in self.truth.items()}, "knee_left": copied, "LTH3": copied})
            self.assertIn("has knee_left and LTH3 at one place to the last digit", self.compared(self.folder / name))
        self.assertEqual(self.said_of("sound.csv", lambda at, key: at), [])
        self.assertEqual(self.said_of("beside.trc", lambda at, key: at + [0, 0.12 * (key == "head"), 0]), [])

    def test_what_changes_as_time_goes_on_is_named(self):
        self.time_s, self.truth = walk(frames=1000)
        library.write_joints(self.folder / "truth.csv", self.time_s, self.truth)
        share = np.linspace(0, 1, 1000)[:, None]
        turned = np.stack([turn_y(0.6 * s) for s in share[:, 0]])
        for name, change, words in (
                ("drift.csv", lambda at, key: at + share * [0.5, 0, 0.1], r"moves against the truth, by (4|5)\d cm and \d degrees from its beginning to its end"),
                ("turning.trc", lambda at, key: np.einsum("fij,fj->fi", turned, at), r"moves against the truth, by \d+ cm and (2|3)\d degrees"),
                ("sinking.csv", lambda at, key: at - share * [0, 0.4, 0], r"moves against the truth, by (3|4)\d cm and \d degrees"),
                ("moved.trc", lambda at, key: at + [0.3, 0, 0] * (share > 0.5), r"from (9|10)\.\d\d s on lies in another frame than the truth, shifted by \(-0\.30, 0\.00, 0\.00\)"),
                ("few.csv", lambda at, key: at + 3 * ((share > 0.4) & (share < 0.42)), r"has [12]\.\d % of its positions more than \d+ cm from the truth, first at (7|8)\.\d\d s"),
                ("few.trc", lambda at, key: at * (1 - 4 * ((share > 0.6) & (share < 0.64)) * (key in ("head", "LTH3"))), r"has [12]\.\d % of its positions more than")):
            with self.subTest(name):
                self.assertRegex("\n".join(self.said_of(name, change)), words)
        self.assertEqual(self.said_of("sound.csv", lambda at, key: at + 0.04 * np.sin(share * 9)), [])

    def test_a_start_by_motion_is_missed_only_where_it_was_asked_for_and_needed(self):
        keeps = "keeps its own times, since the motion does not say when it starts"
        other = {key: at + [2, 0, 1] for key, at in walk(seed=9, person=1.3)[1].items()}
        library.write_joints(self.folder / "other.csv", self.time_s, other)
        sound = self.brought("sound.csv", lambda at, key: at + self.noise.normal(0, 0.01, at.shape))
        self.assertIn(keeps, self.compared(self.folder / "other.csv", more=["--clock-by-motion"]))
        self.assertNotIn(keeps, self.compared(self.folder / "other.csv"))
        self.assertNotIn(keeps, self.compared(sound, more=["--clock-by-motion"]))
        late = self.brought("late.csv", lambda at, key: at, self.time_s + 0.3)
        self.assertNotIn(keeps, self.compared(late, more=["--clock-by-motion"]))

    def test_a_table_says_below_it_who_answers_seldom_and_why(self):
        gone = np.arange(FRAMES) % 100 < 40
        mine = self.brought("mine.csv", lambda at, key: np.where(gone[:, None], np.nan, at + 0.01))
        self.compared(mine, self.brought("whole.csv", lambda at, key: at + 0.01))
        notes = "\n".join(note for table in json.loads((self.folder / "results/tables.json").read_text())["tables"] for note in table["notes"])
        self.assertRegex(notes, r"mine (59|60|61) % \(no_observation (39|40|41) %\)")
        self.assertNotRegex(notes, r"whole \d+ %")

    def test_a_value_of_three_equal_numbers_again_and_again_is_no_position(self):
        gone = self.noise.uniform(size=FRAMES) < 0.1
        for name, value in (("minus.csv", -1.0), ("minus.trc", -1.0), ("millimetre.trc", -0.001), ("one.csv", 1.5), ("tail.csv", -1.0)):
            missing = np.arange(FRAMES) > 300 if name == "tail.csv" else gone
            with self.subTest(name):
                library.write_joints(self.folder / name, self.time_s, {key: np.where(missing[:, None], value, at + [3, 0.002, 0]) for key, at in self.truth.items()})
                said = self.compared(self.folder / name)
                self.assertIn(f"{missing.sum() * len(NAMES)} positions", said)
                self.assertIn("written for what is missing", said)
                cell = next(c for c in cells(self.folder / "results") if c["group"] == "average" and c["alignment"] == "mean")
                self.assertLess(cell["mae_m"], 1e-3)

    def test_rows_that_stand_there_twice_are_refused_with_what_the_file_seems_to_be(self):
        head = "time_s,joint,x_m,y_m,z_m\n"
        row = lambda time, x=1.0, joint="head": f"{time},{joint},{x},1.7,2\n"
        for name, text, words in (
                ("same.csv", row(0) + row(0) + row(0.1, 1.1), "has head twice at 0.000000 s, with one position: rows stand there twice"),
                ("back.csv", row(0) + row(0.1, 1.1) + row(0.2, 1.2) + row(0.1, 1.3), "has head twice at 0.100000 s: its times go back there from 0.200000 s"),
                ("joined.csv", "".join(row(k / 10, k) for k in range(9)) + "".join(row(k / 10, k + 0.5) for k in range(9)), "its times go back there from 0.800000 s, as where two recordings or persons"),
                ("persons.csv", row(0) + row(0, 3) + row(0.1) + row(0.1, 3), "has head twice at 0.000000 s; the joints of one person are wanted"),
                ("date.csv", row("2026-11-30T12:00:00Z"), 'time_s is "2026-11-30T12:00:00Z", which is not a number; times are seconds'),
                ("dash.csv", row(0, "-"), 'x_m is "-", which is not a number; what is missing is left empty')):
            with self.subTest(name):
                (self.folder / name).write_text(head + text)
                self.assertIn(f"{name}:" if "not a number" in words else name, self.compared(self.folder / name, code=2))
                self.assertIn(words, self.compared(self.folder / name, code=2))

    def test_names_of_bones_are_the_joints_where_they_begin(self):
        heights_m = {"spine_base": 0.95, "spine_shoulder": 1.4, "neck": 1.5, "shoulder": 1.38, "elbow": 1.1, "wrist": 0.9, "hip": 0.9, "knee": 0.5, "ankle": 0.1, "foot": 0.05}
        self.truth = {}
        for k, joint in enumerate(SKELETON):
            limb, side = joint.rpartition("_")[::2] if joint.endswith(("_left", "_right")) else (joint, "")
            sway = 0.05 * np.sin((2 + 0.1 * k) * self.time_s)[:, None] * [1, 0.3, 1]
            self.truth[joint] = sway + [{"left": -0.2, "right": 0.2, "": 0}[side], heights_m[limb], 2 + 0.3 * k / 17] + 0.3 * np.sin(0.5 * self.time_s)[:, None] * [1, 0, 0]
        library.write_joints(self.folder / "truth.csv", self.time_s, self.truth)
        for convention, names in BONES.items():
            joints, collars = called(names)
            given = {**{joints[joint]: at for joint, at in self.truth.items()}, **{collar: self.truth["spine_shoulder"] + 0.1 for collar in collars}}
            for file in (f"{convention}.csv", f"{convention}.trc"):
                with self.subTest(file):
                    library.write_joints(self.folder / file, self.time_s, given)
                    said = self.compared(self.folder / file)
                    self.assertIn(f"each is taken as the joint where it begins, {joints['shoulder_left']} as shoulder_left", said)
                    cell = next(c for c in cells(self.folder / "results") if c["group"] == "average" and c["alignment"] == "none")
                    self.assertLess(cell["mae_m"], 1e-4)
                    self.assertEqual(cell["asked"], FRAMES * len(SKELETON))
        joints, collars = called(MOTIVE)
        given = {**{joints[joint]: at for joint, at in self.truth.items()}, **{collar: self.truth["spine_shoulder"] + 0.1 for collar in collars}}
        write_motive_bones(self.folder / "bones.csv", self.time_s, given)
        library.write_joints(self.folder / "joints.csv", self.time_s, {**self.truth, "head": self.truth["neck"] + 0.1})
        for truth, file in (("truth.csv", "bones.csv"), ("bones.csv", "joints.csv"), ("bones.csv", "bones.csv")):
            with self.subTest(truth, file=file):
                (self.folder / "mine.csv").write_bytes((self.folder / file).read_bytes())
                trilat("compare", self.folder / truth, self.folder / "mine.csv", "-o", self.folder / "results", "--force")
                cell = next(c for c in cells(self.folder / "results") if c["group"] == "average" and c["alignment"] == "none")
                self.assertLess(cell["mae_m"], 1e-4)
                self.assertGreaterEqual(cell["asked"], FRAMES * len(SKELETON))
        # beside an elbow an upper arm is a marker
        library.write_joints(self.folder / "markers.csv", self.time_s, {"LeftShoulder": self.truth["shoulder_left"], "LeftArm": self.truth["neck"], "LeftForearm": self.truth["neck"],
                                                                        "LeftElbow": self.truth["elbow_left"]})
        said = self.compared(self.folder / "markers.csv")
        self.assertNotIn("bones", said)
        self.assertRegex(said, r"none +markers +0\.00 .* 2\n")


if __name__ == "__main__":
    unittest.main()
