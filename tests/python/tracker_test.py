#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Measuring the simulated tracker on recordings: scripts/measure_tracker."""
import importlib.machinery
import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "scripts/measure_tracker"

try:
    import pandas
except ImportError:
    pandas = None

DECLARED = {"bias_sigma_m": 0.02, "view_bias_sigma_m": 0.04, "own_bias_sigma_m": 0.01, "drift_sigma_m": 0.01, "view_drift_sigma_m": 0.02,
            "own_drift_sigma_m": 0.005, "drift_path_m": 0.5, "jitter_sigma_m": 0.002, "jump_rate_per_minute": 0, "lag_s": 0,
            "inferred_error_sigma_m": 0.1, "ray_ratio": 1, "exchanged_share": 1, "back_view_angle_rad": 2.1}


def loaded():
    loader = importlib.machinery.SourceFileLoader("measure_tracker", str(SCRIPT))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("measure_tracker", loader))
    sys.modules["measure_tracker"] = module
    loader.exec_module(module)
    return module


@unittest.skipIf(pandas is None, "python3-pandas is not installed")
class MeasureTracker(unittest.TestCase):
    def test_the_document_has_what_the_script_measured(self):
        script = loaded()
        stored = json.loads((ROOT / "datasets/synthetic/measured_pairs.json").read_text())
        document = (ROOT / "docs/explanation/real_recordings.md").read_text()
        sets = {one["name"]: pandas.DataFrame(one["rows"]).rename(columns={f"q{q}_m": f"q{q}" for q in (50, 90, 99)}) for one in stored["sets"]}
        for rows in sets.values():
            rows[["q50", "q90", "q99"]] *= 100
        self.assertEqual({len(rows) for rows in sets.values()}, {3 * 3 * 7})
        twins = (ROOT / "docs/explanation/real_recordings/twins.csv").read_text()
        self.assertEqual(script.beside(sets["judged"], sets["simulated"]).to_csv(), twins)
        for ours, theirs, name in (("simulated", "fitted", "twins beside participants 2, 4 and 10, on whom the tracker is measured"),
                                   ("simulated", "judged", "twins beside participants 12, 14 and 16"),
                                   ("fitted", "judged", "participants 2, 4 and 10 beside 12, 14 and 16")):
            shares = script.likeness(sets[ours], sets[theirs])
            for q in ("q50", "q90"):
                self.assertAlmostEqual(shares[q], stored["alike"][name][q])
            self.assertTrue(f"| {name} | {100 * shares['q50']:.0f} | {100 * shares['q90']:.0f} |" in document, name)

    def test_the_declared_tracker_comes_back_from_simulated_pairs(self):
        script = loaded()
        with tempfile.TemporaryDirectory() as folder:
            spec, campaign = Path(folder) / "spec.json", Path(folder) / "kinectmultitrack"
            spec.write_text(json.dumps({
                "format": "trilat.simulation", "version": 1, "name": "pairs", "participants": 6, "body_tracker": DECLARED,
                "activities": [{"name": "walk_about", "duration_s": 30, "marker_joints": ["head"]},
                               {"name": "steps", "duration_s": 15, "marker_joints": ["head"]}],
                "rig": {"radius_m": 2.4, "heights_m": [1, 1], "arc_deg": 120, "arc_start_deg": -30}}))
            subprocess.run([os.environ["TRILAT"], "simulate", spec, "-o", campaign], check=True, capture_output=True)
            takes = json.loads((campaign / "campaign.json").read_text())
            for take in takes["takes"]:  # as of people without markers
                take.pop("mocap"), take.pop("mapping"), take.pop("mocap_start_host_ns")
            (campaign / "campaign.json").write_text(json.dumps(takes))
            script.FITTED = {"kinectmultitrack": tuple(f"p0{number}" for number in range(1, 7))}
            measured = script.measure(Path(folder))
        def mean_of(parameter, *groups):
            return sum(measured["groups"][parameter][group] for group in groups) / len(groups)

        everywhere = script.TRACKER_GROUPS
        for parameter, share in (("jitter_sigma_m", 0.03), ("view_bias_sigma_m", 0.2), ("view_drift_sigma_m", 0.2), ("own_bias_sigma_m", 0.6)):
            self.assertAlmostEqual(mean_of(parameter, *everywhere) / DECLARED[parameter], 1, delta=share, msg=parameter)
        self.assertAlmostEqual(mean_of("inferred_error_sigma_m", "elbow", "wrist", "hand", "hand_tip") / 0.1, 1, delta=0.2)
        values = {name: entry["value"] for name, entry in measured["values"].items()}
        self.assertAlmostEqual(values["drift_path_m"] / DECLARED["drift_path_m"], 1, delta=0.3)
        self.assertGreater(values["exchanged_share"], 0.95)
        self.assertAlmostEqual(values["back_view_angle_rad"], DECLARED["back_view_angle_rad"], delta=0.2)
        self.assertIn("6 participants", measured["groups"]["jitter_sigma_m"]["source"])

    def test_folders_without_recordings_are_named(self):
        with tempfile.TemporaryDirectory() as folder:
            ended = subprocess.run([sys.executable, SCRIPT, "--kinectmultitrack", folder, "-o", f"{folder}/out"], capture_output=True, text=True)
        self.assertEqual(ended.returncode, 2, ended.stderr)
        self.assertIn(f"{folder}: has no Study_*_Kinect_*.csv", ended.stderr)


class Help(unittest.TestCase):
    def test_help_needs_no_libraries(self):
        ended = subprocess.run([sys.executable, "-S", SCRIPT, "--help"], capture_output=True, text=True, check=True)
        self.assertIn("measured_pairs.json", ended.stdout)


if __name__ == "__main__":
    ran = unittest.main(verbosity=2, exit=False).result
    sys.exit(77 if len(ran.skipped) >= max(1, ran.testsRun) else not ran.wasSuccessful())
