# SPDX-License-Identifier: MIT
"""scripts/first_kinect: its numbers against made ones, and the ten minutes in a short form against a virtual Kinect."""
import array
import json
import math
import os
import random
import subprocess
import sys
import unittest
import zipfile
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path

from made import PROGRAM, SOURCE, ScratchTest

SCRIPT = SOURCE / "scripts/first_kinect"
AGENT = os.environ.get("TRILAT_AGENT", Path(PROGRAM).with_name("trilat-agent"))
sys.dont_write_bytecode = True
loader = SourceFileLoader("first_kinect", str(SCRIPT))
first_kinect = module_from_spec(spec_from_loader("first_kinect", loader))
loader.exec_module(first_kinect)
LENS = {"fx_px": 365.5, "fy_px": 366.0, "cx_px": 255.0, "cy_px": 207.0, "k1": 0.09, "k2": -0.27, "k3": 0.1, "p1": 0.0, "p2": 0.0}


def wall(distance_mm, tilt_deg, noise_mm, error_mm=lambda u: 0.0, frames=20):
    """Depth frames of a wall that is turned about the vertical axis, as a lens with distortion sees it."""
    normal_x, normal_z = math.sin(math.radians(tilt_deg)), math.cos(math.radians(tilt_deg))
    true_mm = {}
    for v in range(first_kinect.HEIGHT // 4, first_kinect.HEIGHT, first_kinect.STEP):
        for u in range(0, first_kinect.WIDTH, first_kinect.STEP):
            x, _ = first_kinect.ray_of(u, v, LENS)
            true_mm[v * first_kinect.WIDTH + u] = distance_mm / (normal_x * x + normal_z) + error_mm(u)
    draws, made = random.Random(1), []
    for _ in range(frames):
        frame = array.array("H", bytes(2 * first_kinect.WIDTH * first_kinect.HEIGHT))
        for index, depth_mm in true_mm.items():
            frame[index] = round(draws.gauss(depth_mm, noise_mm))
        made.append(frame)
    return made


class Numbers(unittest.TestCase):
    def test_a_wall_has_its_distance_tilt_and_noise_and_no_residual(self):
        numbers = first_kinect.wall_numbers(wall(1500.0, 12.0, 2.0), LENS)
        self.assertAlmostEqual(numbers["distance_mm"], 1500.0, delta=0.3)
        self.assertAlmostEqual(numbers["tilt_deg"], 12.0, delta=0.1)
        self.assertAlmostEqual(numbers["noise_in_time_mm"], 2.0, delta=0.15)
        self.assertLess(numbers["residual_rms_mm"], 0.7)

    def test_what_stands_before_the_wall_is_left_out(self):
        numbers = first_kinect.wall_numbers(wall(1500.0, 0.0, 1.0, lambda u: -400.0 if u > 340 else 0.0), LENS)
        self.assertAlmostEqual(numbers["distance_mm"], 1500.0, delta=0.5)
        self.assertLess(numbers["pixels_on_the_plane"], 0.9)

    def test_a_bowl_is_seen_by_column(self):
        numbers = first_kinect.wall_numbers(wall(2000.0, 0.0, 0.1, lambda u: 0.001 * (u - 256) ** 2), LENS)
        by_column = numbers["residual_by_column_mm"]
        self.assertLess(by_column["256"], -2.0)
        self.assertGreater(by_column["128"], 4.0)

    def test_a_dark_picture_is_no_wall(self):
        self.assertIn("problem", first_kinect.wall_numbers(wall(0.0, 0.0, 0.0), LENS))

    def test_a_stream_tells_rate_gaps_drift_and_lateness(self):
        stamps = [(n, 333_333 * n, round(1e9 + 33_333_300 * n * (1 + 50e-6)) + (7_000_000 if n == 500 else 0))
                  for n in range(1000) if n not in (100, 101)]
        numbers = first_kinect.stream_numbers(stamps, 100)
        self.assertEqual(numbers["missing_numbers"], 2)
        self.assertEqual(numbers["steps_by_periods"], {"1": 996, "3": 1})
        self.assertAlmostEqual(numbers["arrival_drift_ppm"], 50.0, delta=0.2)
        self.assertAlmostEqual(numbers["arrival_late_ms"]["max"], 7.0, delta=0.01)
        self.assertLess(numbers["arrival_late_ms"]["median"], 0.01)

    def test_joints_are_counted_by_state(self):
        body = bytes(708) + bytes([2] * 20 + [1] * 4 + [0]) + bytes(4)
        self.assertEqual(len(body), first_kinect.BODY_BYTES)
        numbers = first_kinect.body_numbers([bytes(40) + bytes([1]) + body, bytes(40) + bytes([0])])
        self.assertEqual(numbers, {"frames_with_a_body": 0.5, "joints_tracked": 0.8, "joints_inferred": 0.16, "joints_not_seen": 0.04})


class TenMinutes(ScratchTest):
    def tried(self, *more, code=0):
        words = [sys.executable, "-B", SCRIPT, "--yes", "--walk-s", "3", "--wall-s", "2", "-o", self.folder / "sent.zip", *more]
        done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, code, done.stderr)
        return done

    def test_the_archive_of_a_virtual_kinect_holds_every_part(self):
        self.tried("--agent", AGENT, "--source", "synthetic:1")
        archive = zipfile.ZipFile(self.folder / "sent.zip")
        self.assertEqual(set(archive.namelist()), {"report.json", "agent.txt", "wall_near.pgm", "wall_far.pgm"})
        report = json.loads(archive.read("report.json"))
        self.assertTrue(report["sensor"]["simulated"])
        self.assertEqual(report["sensor"]["tick_ns"], 100)
        self.assertAlmostEqual(report["walk"]["depth"]["rate_by_ticks_hz"], 30.0, delta=0.05)
        self.assertGreater(report["walk"]["depth"]["frames"], 40)
        self.assertGreater(report["walk"]["person"]["joints_tracked"], 0.5)

    def test_an_agent_that_is_not_there_or_ends_is_said(self):
        self.assertIn("--agent PATH", self.tried("--agent", "/nowhere/trilat-agent", code=2).stderr)
        self.assertIn("the agent ended with 2", self.tried("--agent", AGENT, "--source", "nothing", code=2).stderr)
        self.assertFalse((self.folder / "sent.zip").exists())


if __name__ == "__main__":
    unittest.main()
