# SPDX-License-Identifier: MIT
"""What Python computes, against numbers that follow by hand."""
import argparse
import json
import tempfile
import unittest
from pathlib import Path

import numpy as np

from trilat.convert import keraal, ui_prmd
from trilat.convert.campaign import Take, means_m, pair_takes, pose_of, write_take, y_up
from trilat.convert.motion import Comparison, Motion, Pairing, centred_pair, enough, rotation_of
from trilat.convert.recording import Body, Recording, Stamps, TornRow, integer, numbers, states_of, time_of
from trilat.errors import InputError
from trilat.read_session import Bodies, _at_instants, _turn
from trilat.skeleton import JOINT_COUNT, JOINT_NUMBER

HALF = np.sqrt(0.5)


def waves(time_s, seed=1):
    """(N, 4, 3) metres, without a period."""
    rng = np.random.default_rng(seed)
    return sum(np.sin(6.28 * hz * time_s[:, None, None] + phase) * 0.2
               for hz, phase in zip(rng.uniform(0.2, 1.0, 4), rng.uniform(0, 6.28, (4, 4, 3)), strict=True))


class Turns(unittest.TestCase):
    def test_a_quaternion_turns_each_axis_to_the_next(self):
        for xyzw, images in (((HALF, 0, 0, HALF), "x z -y"), ((0, HALF, 0, HALF), "-z y x"), ((0, 0, HALF, HALF), "y -x z"),
                             ((0.5, 0.5, 0.5, 0.5), "y z x"), ((0, 0, 0, 1), "x y z")):
            axes = [np.eye(3)["xyz".index(word[-1])] * (-1 if word[0] == "-" else 1) for word in images.split()]
            np.testing.assert_allclose(_turn(list(xyzw)), np.stack(axes, axis=1), atol=1e-12, err_msg=str(xyzw))

    def test_ui_prmds_angles_turn_about_x_y_and_z_in_their_order(self):
        about = ui_prmd.rotations(np.array([[90.0, 0, 0], [0, 90, 0], [0, 0, 90], [90, 90, 0], [0, 0, 0]]))
        np.testing.assert_allclose(about[0], [[1, 0, 0], [0, 0, -1], [0, 1, 0]], atol=1e-12)
        np.testing.assert_allclose(about[1], [[0, 0, 1], [0, 1, 0], [-1, 0, 0]], atol=1e-12)
        np.testing.assert_allclose(about[2], [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-12)
        np.testing.assert_allclose(about[3], about[0] @ about[1], atol=1e-12)
        np.testing.assert_allclose(about[4], np.eye(3), atol=1e-12)

    def test_ui_prmds_joints_hang_on_their_parents(self):
        position_cm, angle_deg = np.zeros((1, 22, 3)), np.zeros((1, 22, 3))
        position_cm[0, 0], position_cm[0, 1], position_cm[0, 2] = [10, 90, 200], [0, 20, 0], [0, 30, 0]
        angle_deg[0, 0] = [0, 0, 90]   # the first frame turns y to -x
        angle_deg[0, 1] = [0, 0, -90]  # the second back
        joint_m = ui_prmd.chained_m(position_cm, angle_deg)[0]
        np.testing.assert_allclose(joint_m[0], [-0.1, 0.9, -2.0], atol=1e-12)
        np.testing.assert_allclose(joint_m[1], [0.1, 0.9, -2.0], atol=1e-12)
        np.testing.assert_allclose(joint_m[2], [0.1, 1.2, -2.0], atol=1e-12)

    def test_the_best_rotation_is_no_mirror_image(self):
        np.testing.assert_allclose(rotation_of(np.diag([3.0, 2.0, 1.0])), np.eye(3), atol=1e-12)
        np.testing.assert_allclose(rotation_of(np.diag([3.0, 2.0, -1.0])), np.eye(3), atol=1e-12)
        turned = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
        np.testing.assert_allclose(rotation_of(turned @ np.diag([3.0, 2.0, 1.0])), turned, atol=1e-12)
        np.testing.assert_allclose(y_up(np.array([1.0, 2.0, 3.0])), [1.0, 3.0, -2.0])


class Instants(unittest.TestCase):
    def bodies(self, frame, x_m, state):
        position_m = np.zeros((len(frame), JOINT_COUNT, 3))
        position_m[:, :, 0] = np.array(x_m)[:, None]
        states = np.array(state, np.uint8)[:, None] * np.ones((1, JOINT_COUNT), np.uint8)
        return Bodies(**{name: {"frame": np.array(frame), "position_m": position_m, "tracking_state": states}.get(name)
                         for name in Bodies.__dataclass_fields__})

    def test_joints_are_interpolated_and_never_across_a_gap(self):
        frame_s = np.array([0.0, 0.1, 0.2, 0.5])
        at_m, state = _at_instants(self.bodies([0, 1, 2, 3], [1.0, 2.0, 4.0, 8.0], [2, 2, 1, 2]), frame_s,
                                   np.array([-0.01, 0.0, 0.025, 0.15, 0.3, 0.5, 0.51]), 0.11)
        np.testing.assert_allclose(at_m[:, 0, 0], [np.nan, 1.0, 1.25, 3.0, np.nan, np.nan, np.nan])
        np.testing.assert_array_equal(state[:, 0], [0, 2, 2, 1, 0, 0, 0])
        at_m, _ = _at_instants(self.bodies([0, 1, 2, 3], [1.0, 2.0, 4.0, 8.0], [2, 2, 1, 2]), frame_s, np.array([0.5]), 0.31)
        self.assertEqual(at_m[0, 24, 0], 8.0)

    def test_of_two_bodies_the_better_tracked_counts_and_what_is_not_tracked_is_none(self):
        frame_s = np.array([0.0, 0.1])
        at_m, state = _at_instants(self.bodies([0, 0, 1, 1], [5.0, 1.0, 2.0, 6.0], [1, 2, 2, 1]), frame_s, np.array([0.0, 0.1]), 0.11)
        np.testing.assert_allclose(at_m[:, 3, 0], [1.0, 2.0])
        at_m, state = _at_instants(self.bodies([0, 1], [1.0, 2.0], [0, 2]), frame_s, np.array([0.05]), 0.11)
        self.assertTrue(np.isnan(at_m).all() and not state.any())


class Motions(unittest.TestCase):
    def test_a_motion_is_linear_between_its_samples(self):
        motion = Motion(np.array([0.0, 0.1, 0.3]), np.array([[[0.0, 1, 2]], [[1, 1, 2]], [[3, 1, 2]]]))
        np.testing.assert_allclose(motion.at(np.array([-0.1, 0.0, 0.05, 0.2, 0.3, 0.4]))[:, 0, 0], [np.nan, 0, 0.5, np.nan, np.nan, np.nan])
        np.testing.assert_allclose(motion.at(np.array([0.2, 0.3]), 0.2)[:, 0, 0], [2.0, 3.0])

    def test_a_pair_is_centred_over_what_both_have(self):
        time_s = np.arange(3) * 0.05
        first = Motion(time_s, np.array([1.0, 2, 6])[:, None, None] * np.ones((3, 2, 3)))
        second = Motion(time_s + 1.0, np.array([10.0, 20, 30])[:, None, None] * np.ones((3, 2, 3)))
        first.joint_m[2, 1] = np.nan
        rows, a, b = centred_pair(first, second, 1.0, 1.0)
        np.testing.assert_array_equal(rows, [0, 1, 2])
        np.testing.assert_allclose(a[:, 0, 0], [-2, -1, 3])
        np.testing.assert_allclose(b[:, 0, 0], [-10, 0, 10])
        np.testing.assert_allclose(a[:, 1, 0], [-0.5, 0.5, 0])
        np.testing.assert_allclose(b[:, 1, 0], [-5, 5, 0])
        for mean_m, wanted in zip(means_m(first, second, Pairing(1.0, 1, 1, 1.0, 1, 1, 1.0)), (2.25, 17.5), strict=True):
            np.testing.assert_allclose(mean_m, [wanted] * 3)
        pose = pose_of([(np.eye(3), np.array([1.0, 2, 3]), np.array([2.0, 2, 3])), (np.eye(3), np.zeros(3), np.array([0.0, 2, 0]))])
        np.testing.assert_allclose(pose.position_m, [0.5, 1.0, 0.0])

    def test_enough_is_twenty_samples_and_six_tenths_of_the_shorter(self):
        first = Motion(np.arange(100) / 30, np.zeros((100, 1, 3)))
        longer, shorter = (Motion(np.arange(n) / 60, np.zeros((n, 1, 3))) for n in (400, 100))
        self.assertTrue(enough(first, longer, 1.0, np.arange(60)) and not enough(first, longer, 1.0, np.arange(59)))
        self.assertTrue(enough(first, shorter, 1.0, np.arange(30)) and not enough(first, shorter, 1.0, np.arange(29)))
        few = Motion(np.arange(30) / 30, np.zeros((30, 1, 3)))
        self.assertTrue(enough(few, longer, 1.0, np.arange(20)) and not enough(few, longer, 1.0, np.arange(19)))

    def test_a_pairing_says_what_is_wrong_with_it(self):
        def problem(correlation=0.9, low_s=-0.1, high_s=0.1, at_edge=False):
            return Pairing(0.0, low_s, high_s, 1.0, 1.0, 1.0, correlation, at_edge).problem
        self.assertEqual((problem(), problem(0.5)), ("", ""))
        self.assertIn("no motion in common (correlation 0.49)", problem(0.49))
        self.assertIn("no motion in common", problem(np.nan))
        self.assertIn("does not tell their offset", problem(high_s=0.11))
        self.assertIn("begin to overlap too little", problem(at_edge=True))

    def test_the_offset_at_the_end_of_the_search_is_no_answer(self):
        first = Motion(np.arange(120) / 30, waves(np.arange(120) / 30))
        for shift_s, is_found in ((0.3, True), (0.7, False), (-0.7, False)):
            other_s = np.arange(-200, 900) / 100
            pairing = Comparison(first, Motion(other_s, waves(other_s - shift_s)), 0.5).pairing(np.eye(3))
            self.assertEqual((pairing.at_edge, abs(pairing.offset_s - shift_s) < 0.006), (not is_found, is_found), shift_s)

    def test_a_sensors_pose_and_its_spread_follow_from_its_takes(self):
        takes = []
        for k, more_m in enumerate((0.0, 0.03, -0.03)):
            time_s, other_s = np.arange(120) / 30, np.arange(600) / 100
            sensor_m, truth_m = waves(time_s, k), waves(other_s - 0.2, k)
            takes.append(Take(f"t{k}", "p1", "walk", 30.0, sensor_m + [1.0, 2.0, 3.0 + more_m], tuple("abcd"), 100.0,
                              truth_m[..., [0, 2, 1]] * [1.0, -1.0, 1.0], tuple("ABCD"), {name: (name.upper(),) for name in "abcd"}))
        pairings, pose, problems = pair_takes(takes, 0.5, (1.0,))
        self.assertEqual(problems, {})
        for pairing in pairings.values():
            self.assertAlmostEqual(pairing.offset_s, 0.2, delta=0.006)
        np.testing.assert_allclose(pose.rotation, np.eye(3), atol=0.01)
        np.testing.assert_allclose(pose.position_m, [-1.0, -2.0, -3.0], atol=0.03)
        # means without one take are 0, -1.5 and 1.5 cm off; a jackknife of three takes, as a root mean square over three axes
        self.assertAlmostEqual(pose.position_sigma_m, np.sqrt(2 / 3) * np.sqrt(2 / 3) * 0.015, delta=0.004)

    def test_a_take_is_written_with_its_clock(self):
        with tempfile.TemporaryDirectory() as folder:
            take = Take("t", "p1", "walk", 30.0, np.full((40, 1, 3), 2.0), ("head",), 100.0, np.zeros((50, 1, 3)) + [1.0, 2.0, 3.0], ("M",),
                        {"head": ("M",)})
            entry = write_take(Path(folder), take, Pairing(0.5, 0.4, 0.6, 1.01, 1, 1, 1.0), "note", "source")
            self.assertEqual(entry["mocap_start_host_ns"], round(1e9 * (10.0 - 0.5 / 1.01)))
            lines = (Path(folder) / "t/mocap.trc").read_text().split("\n")
            self.assertAlmostEqual(float(lines[2].split("\t")[0]), 101.0, places=3)
            self.assertEqual([float(cell) for cell in lines[-2].split("\t")[2:5]], [1000.0, 3000.0, -2000.0])  # mm


class Rows(unittest.TestCase):
    def test_cells_are_numbers_or_torn(self):
        np.testing.assert_array_equal(numbers(["1", " 2.5 "], "x"), [1.0, 2.5])
        for cells, said in ((["1_0"], "1_0 is not"), (["a"], "not a number where x"), (["1", "inf"], 'has "inf" where x should be')):
            with self.assertRaisesRegex(TornRow, said):
                numbers(cells, "x")
        self.assertEqual((integer("12", "n"), time_of("12"), time_of("0.5")), (12, 12, 0.5))
        with self.assertRaises(TornRow):
            integer("1_2", "n")
        np.testing.assert_array_equal(states_of(np.array([0.0, 1, 2]), "f"), [0, 1, 2])
        with self.assertRaisesRegex(InputError, "the tracking state 1.5"):
            states_of(np.array([1.0, 1.5]), "f")
        for states in ([3.0], [-1.0]):
            with self.assertRaisesRegex(TornRow, "goes from 0 to 2"):
                states_of(np.array(states), "f")

    def test_frames_are_numbered_by_the_file_or_by_their_time(self):
        stamps = Stamps(30.0)
        self.assertEqual([stamps.next(ticks, None) for ticks in (1000, 334333, 1334333, 1334400)], [0, 1, 4, 5])
        self.assertEqual(stamps.gap_frames, 2)
        stamps = Stamps(30.0)
        self.assertEqual([stamps.next(ticks, k) for ticks, k in ((0, 7), (333333, 9), (666666, 9), (1000000, 3))], [7, 9, 10, 11])
        self.assertEqual(stamps.gap_frames, 1)
        with self.assertRaisesRegex(TornRow, "beyond all clocks"):
            stamps.next(2**59 // 100 + 1, None)

    def test_the_camera_follows_from_joints_in_space_and_in_pixels(self):
        def camera(fx=365.0, fy=-366.0, noise_px=0.0, spread=1.0, bodies=20):
            recording, rng = Recording("k1", Path("f")), np.random.default_rng(1)
            for k in range(bodies):
                position_m = rng.uniform(-0.5, 0.5, (JOINT_COUNT, 3)) * [spread, spread, 1.0] + [0, 0, 2.0]
                body = Body(position_m)
                body.depth_px = position_m[:, :2] / position_m[:, 2:] * [fx, fy] + [256.0, 206.0] + rng.normal(0, noise_px, (JOINT_COUNT, 2))
                body.depth_px[0], body.tracking_state[1], body.depth_px[1] = [-5.0, 10.0], 0, [9.0, 9.0]  # neither counts
                recording.bodies.append((k, body))
            return recording._intrinsics(), recording.rms_px

        intrinsics, rms_px = camera()
        self.assertEqual({key: round(value, 6) for key, value in intrinsics.items()},
                         {"fx_px": 365.0, "fy_px": 366.0, "cx_px": 256.0, "cy_px": 206.0})
        self.assertLess(rms_px, 1e-6)
        self.assertAlmostEqual(camera(noise_px=0.5)[1], 0.5, delta=0.05)
        for other in ({"noise_px": 1.2}, {"fx": 1001.0}, {"fx": 99.0}, {"fy": -1001.0}, {"fy": 365.0}, {"spread": 0.01}, {"bodies": 8}):
            self.assertEqual(camera(**other), (None, None), other)

    def test_keraals_rows_are_joints_of_seven_numbers(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "rows.txt"
            path.write_text(" ".join(str(k) for k in range(14)) + "\n")
            np.testing.assert_array_equal(keraal.table(path, 2), np.arange(14.0).reshape(1, 2, 7))
            with self.assertRaisesRegex(InputError, "rows of 14 numbers, .*; 21 are expected"):
                keraal.table(path, 3)
            self.assertEqual((keraal.RATIOS[0], keraal.RATIOS[-1], len(keraal.RATIOS)), (0.95, 1.05, 41))

    def test_ui_prmds_files_become_a_take(self):
        with tempfile.TemporaryDirectory() as folder:
            paths = [Path(folder) / name for name in ("positions", "angles", "vicon")]
            for path, row in zip(paths, (np.arange(66.0), np.zeros(66), np.r_[np.zeros(3), np.arange(1.0, 115.0)]), strict=True):
                path.write_text(",".join(map(str, row)) + "\n")
            take = ui_prmd.read_take("m03_s02_e01", *paths)
            self.assertEqual((take.id, take.participant, take.activity, take.rate_hz, take.truth_hz),
                             ("m03-s02-e01", "s02", "inline lunge", 30.0, 100.0))
            self.assertEqual(take.joints.index("head"), 4)
            np.testing.assert_allclose(take.sensor_m[0, 0], [0.0, 0.01, -0.02])
            np.testing.assert_allclose(take.sensor_m[0, 1], [-0.03, 0.05, -0.07])
            self.assertTrue(np.isnan(take.truth_m[0, 0]).all())  # three zeros are no marker
            np.testing.assert_allclose(take.truth_m[0, 1], [0.001, 0.002, 0.003])
            paths[1].write_text(paths[1].read_text() * 2)
            with self.assertRaisesRegex(InputError, "has 2 rows for 1 of positions"):
                ui_prmd.read_take("m03_s02_e01", *paths)


if __name__ == "__main__":
    unittest.main()
