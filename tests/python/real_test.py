# SPDX-License-Identifier: MIT
"""Clocks and poses from the motion, on made-up motion and on the real recordings of ../shared where they are there."""
import contextlib
import gzip
import io
import json
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

import trilat
from trilat.convert import ui_prmd
from trilat.convert.__main__ import main
from trilat.convert.campaign import quaternion_xyzw
from trilat.convert.motion import Comparison, Motion, centred_pair, rotation_of
from trilat.program import call, program_path

SHARED = Path(__file__).resolve().parents[3] / "shared/data/kinect-real"
ui_prmd_rotation = ui_prmd.rotations
STUDY = Path(__file__).resolve().parents[2] / "pipeline/studies/one_sensor.json"


def turn(axis, angle_rad):
    axis = np.array(axis, float) / np.linalg.norm(axis)
    cross = np.cross(np.eye(3), axis) * -1
    return np.eye(3) + np.sin(angle_rad) * cross + (1 - np.cos(angle_rad)) * cross @ cross


def made_up_motion(seed, time_s):
    """Smooth, without a period: sums of waves, (N, 6, 3) metres."""
    rng = np.random.default_rng(seed)
    waves = rng.uniform(0.2, 1.0, 5)[:, None, None], rng.uniform(0, 6.28, (5, 6, 3)), rng.normal(0, 0.1, (5, 6, 3))
    return sum(size * np.sin(6.28 * hz * time_s[:, None, None] + phase) for hz, phase, size in zip(*waves, strict=True))


class MotionTest(unittest.TestCase):
    def pair(self, seed, other_seed, ratio=1.0, offset_s=0.0, noise_m=0.01):
        rng, rotation = np.random.default_rng(seed), turn([1, 2, 3], 0.7 + seed)
        first_s, second_s = np.arange(90) / 30, np.arange(600) / 100 - 1
        first = Motion(first_s, made_up_motion(seed, first_s) + rng.normal(0, noise_m, (90, 6, 3)) + rng.normal(0, 1, (6, 3)))
        second = Motion(second_s, made_up_motion(other_seed, (second_s - offset_s) / ratio) @ rotation.T + rng.normal(0, 1, (6, 3)))
        return first, second, rotation

    def test_offset_ratio_and_axes_are_found(self):
        inside = 0
        for seed in range(20):
            first, second, rotation = self.pair(seed, seed, 1.02, 0.234)
            comparison = Comparison(first, second, 0.5, (1.0, 1.01, 1.02, 1.03))
            found = comparison.pairing()
            self.assertEqual((found.problem, found.ratio), ("", 1.02))
            self.assertAlmostEqual(found.offset_s, 0.234, delta=0.011)
            inside += found.low_s - 0.006 <= 0.234 <= found.high_s + 0.006
            np.testing.assert_allclose(rotation_of(comparison.covariance(found)), rotation, atol=0.02)
        self.assertGreaterEqual(inside, 18)

    def test_different_takes_are_refused_with_the_correlation(self):
        for seed in range(10):
            first, second, rotation = self.pair(seed, seed + 50)
            self.assertRegex(Comparison(first, second, 0.5).pairing(rotation).problem, r"no motion in common \(correlation -?0\.\d\d\)|edge|overlap")

    def test_a_motion_that_does_not_tell_the_time_is_refused(self):
        time_s = np.arange(300) / 30
        swing = np.sin(6.28 * time_s / 0.6)[:, None, None] * np.array([[[0.1, 0, 0], [0, 0.1, 0]]])
        noise = np.random.default_rng(0).normal(0, 0.03, (2, *swing.shape))
        problem = Comparison(Motion(time_s, swing + noise[0]), Motion(time_s, swing + noise[1]), 1.0).pairing().problem
        self.assertIn("does not tell their offset", problem)

    def test_recordings_that_do_not_overlap_are_refused(self):
        first, second, _ = self.pair(1, 1)
        with self.assertRaisesRegex(trilat.InputError, "overlap too little"):
            Comparison(Motion(first.time_s + 60, first.joint_m), second, 0.5)
        with self.assertRaisesRegex(trilat.InputError, "have 1 and 600 samples; 20 are needed"):
            Comparison(Motion(first.time_s[:1], first.joint_m[:1]), second, 0.5)

    def test_quaternions_turn_as_the_matrix_does(self):
        for seed in range(20):
            rotation = turn(np.random.default_rng(seed).normal(size=3), 0.3 * seed)
            x, y, z, w = quaternion_xyzw(rotation)
            cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
            np.testing.assert_allclose(np.eye(3) + 2 * w * cross + 2 * cross @ cross, rotation, atol=1e-12)


class RealTest(unittest.TestCase):
    def setUp(self):
        if not SHARED.exists():
            self.skipTest(f"{SHARED} is not there")
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = Path(holder.name)

    def converted(self, *words, code=0):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            self.assertEqual(main([*map(str, words)]), code, err.getvalue())
        return out.getvalue() + err.getvalue()

    def some_of_ui_prmd(self, pattern):
        for part in ("Kinect/Positions", "Kinect/Angles", "Vicon/Positions"):
            (self.folder / "data" / part).mkdir(parents=True, exist_ok=True)
            for path in (SHARED / "ui-prmd" / part).glob(pattern):
                shutil.copy(path, self.folder / "data" / part)
        return self.folder / "data"

    def knee_error_m(self, files, name):
        """Root mean square of both knees against Vicon in a deep squat, less a constant offset of each."""
        take = ui_prmd.read_take(name, *files)
        first, second = take.motions()
        comparison = Comparison(first, second, 1.5)
        found = comparison.pairing()
        _, a, b = centred_pair(first, second, found.ratio, found.offset_s)
        error = (b - a @ rotation_of(comparison.covariance(found)).T)[:, [list(take.mapping).index(f"knee_{s}") for s in ("left", "right")]]
        return np.sqrt((error**2).sum(axis=2).mean())

    def test_ui_prmds_chain_has_rigid_bones_and_knees_where_vicon_has_them(self):
        for participant in range(1, 6):
            name = f"m01_s0{participant}_e02"
            files = [SHARED / "ui-prmd" / part / f"{name}_{end}.txt.gz" for part, end in
                     (("Kinect/Positions", "positions"), ("Kinect/Angles", "angles"), ("Vicon/Positions", "positions"))]
            joint_m = ui_prmd.chained_m(*(ui_prmd.table(path, 66).reshape(-1, 22, 3) for path in files[:2]))
            change_m = [np.linalg.norm(joint_m[:, j] - joint_m[:, parent], axis=1).std()
                        for j, (_, parent) in enumerate(ui_prmd.CHAIN) if parent >= 0]
            self.assertTrue(np.median(change_m) < 0.015 and max(change_m) < 0.05, (name, np.round(change_m, 3)))
            right_m = self.knee_error_m(files, name)
            with mock.patch.object(ui_prmd, "rotations", lambda angle_deg: np.einsum(  # Rz Ry Rx
                    "nij,njk,nkl->nil", *(ui_prmd_rotation(angle_deg * keep) for keep in ([0, 0, 1], [0, 1, 0], [1, 0, 0])))):
                wrong_m = self.knee_error_m(files, name)
            self.assertLess(right_m, 0.08, name)
            self.assertGreater(wrong_m, 2 * right_m, name)

    def test_ui_prmd_from_its_folder_to_a_table(self):
        data = self.some_of_ui_prmd("m10_s0[345]_e02_*")
        text = self.converted("ui-prmd", data, "-o", self.folder / "campaign")
        self.assertIn("3 takes of 3 participants", text)
        campaign = json.loads((self.folder / "campaign/campaign.json").read_text())
        self.assertEqual((campaign["simulated"], campaign["takes"][0]["activity"]), (False, "shoulder scaption"))
        results = trilat.run(STUDY, campaign=self.folder / "campaign", output=self.folder / "results")
        errors = {row["group"]: 100 * row["value"]
                  for row in trilat.numbers(results.folder, measure="distance", statistic="mean", alignment="mean")}
        self.assertTrue(0.1 < errors["ankle"] < 1.0 and 0.5 < errors["elbow"] < 3.0 and 0.5 < errors["wrist"] < 4.0, errors)
        self.assertFalse(results.summary["simulated"])
        self.assertIn("is there already", self.converted("ui-prmd", data, "-o", self.folder / "campaign", code=2))
        raw = self.folder / "campaign/raw"
        shutil.copytree(data, raw)
        text = self.converted("ui-prmd", raw, "-o", self.folder / "campaign", "--force", code=2)
        self.assertIn("an output is never an input", text)
        self.assertTrue(any(raw.rglob("*.txt.gz")))

    def test_ui_prmds_files_of_different_takes_and_torn_ones_are_left_out(self):
        data = self.some_of_ui_prmd("m0[17]_s0[45]_e01_*")
        vicon = data / "Vicon/Positions"
        shutil.copy(SHARED / "ui-prmd/Vicon/Positions/m05_s04_e01_positions.txt.gz", vicon / "m07_s04_e01_positions.txt.gz")
        for part, end in (("Kinect/Positions", "positions"), ("Kinect/Angles", "angles")):  # a take of ten frames
            rows = gzip.open(data / part / f"m01_s04_e01_{end}.txt.gz", "rt").read().split("\n")
            (data / part / f"m08_s04_e01_{end}.txt").write_text("\n".join(rows[:10]) + "\n")
        (vicon / "m08_s04_e01_positions.txt").write_text(gzip.open(vicon / "m01_s04_e01_positions.txt.gz", "rt").read())
        torn = vicon / "m07_s05_e01_positions.txt.gz"
        torn.write_bytes(torn.read_bytes()[:2000])
        (data / "Kinect/Angles/m01_s05_e01_angles.txt.gz").unlink()
        text = self.converted("ui-prmd", data, "-o", self.folder / "campaign", code=1)
        self.assertIn("1 takes of 1 participants", text)
        self.assertRegex(text, r"m07-s04-e01: sensor and motion capture (show no motion in common|fit best|show a motion that does not)")
        self.assertIn("m08-s04-e01: sensor and motion capture have 10 and", text)
        self.assertRegex(text, "m07_s05_e01_positions.txt.gz: cannot be read")
        self.assertRegex(text, "m01_s05_e01_positions.txt.gz, which has no Kinect/Angles")
        self.assertIn("Kinect/Positions", self.converted("ui-prmd", self.folder, "-o", self.folder / "c2", code=2))
        self.assertEqual(list(self.folder.glob("c2*")), [])

    def test_keraals_rates_are_found(self):
        self.converted("keraal", SHARED / "keraal", "-o", self.folder / "campaign")
        rates_hz = [float((self.folder / "campaign" / take["mocap"]).read_text().split("\n")[2].split("\t")[0])
                    for take in json.loads((self.folder / "campaign/campaign.json").read_text())["takes"]]
        self.assertEqual(len(rates_hz), 3)
        self.assertTrue(all(59.5 < rate < 61.0 for rate in rates_hz), rates_hz)

    def test_kinectmultitrack_gives_sound_sessions_of_two_sensors(self):
        file = SHARED / "kinectmultitrack/Study_2_Kinect_2_Time_12_26_01_PM.csv"
        text = self.converted("kinectmultitrack", file, "-o", self.folder / "p2")
        self.assertIn("by the motion", text)
        for session in ("standing", "steps", "walking"):
            verified = subprocess.run([program_path(), "verify", self.folder / f"p2/{session}.h5"], capture_output=True, text=True)
            self.assertEqual(verified.returncode, 0, verified.stderr)
        call("calibrate", self.folder / "p2/walking.h5", "--method", "bodies", "-o", self.folder / "p2/calibration.json")
        sensors = json.loads((self.folder / "p2/calibration.json").read_text())["sensors"]
        dot = abs(np.dot(sensors[0]["rotation_xyzw"], sensors[1]["rotation_xyzw"]))
        self.assertAlmostEqual(np.degrees(2 * np.arccos(dot)), 90.0, delta=5.0)  # as its authors placed them
        call("init", self.folder)
        campaign = json.loads((self.folder / "campaign.json").read_text())
        self.assertEqual([(take["id"], take["participant"], take["activity"]) for take in campaign["takes"]],
                         [(f"p2-{name}", "p2", name) for name in ("standing", "steps", "walking")])
        results = trilat.run(self.folder / "study.json", campaign=self.folder, output=self.folder / "results")
        self.assertEqual(results.summary["truth"], "left_out_sensor")
        bearing, bone = ({row["method"]: row["value"] for row in trilat.numbers(results.folder, condition="walking", measure=measure)}
                         for measure in ("bearing", "bone"))
        self.assertLess(bearing["mean"], 0.15)
        self.assertLess(bone["window"], 0.3 * bone["mean"])
        cut = self.folder / "cut.csv"
        cut.write_text("\n".join(file.read_text().split("\n")[:400]) + "\n2, 2, 1, 635")
        self.assertIn("1 rows are torn and left out; first: " + str(cut), self.converted("kinectmultitrack", cut, "-o", self.folder / "cut", code=1))
        cut.write_text("Study, Scenario\n1, 2\n")
        self.assertIn("has no column Skeleton_Time", self.converted("kinectmultitrack", cut, "-o", self.folder / "c3", code=2))


if __name__ == "__main__":
    unittest.main()
