#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Numbers of calibration studies again from the samples in their items, and what numbers of clocks and sweeps say of each other.

    other_kinds_test.py PROGRAM
"""
import csv
import itertools
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import tables

PROGRAM = sys.argv.pop(1) if len(sys.argv) > 1 else "build/release/trilat"
BENCH = {"format": "trilat.simulation", "version": 1, "name": "bench", "participants": 1, "activities": [{"name": "walking", "duration_s": 6}],
         "rig": {"heights_m": [0.6, 2.2, 0.9]}, "wand": {"positions": 7, "hold_s": 0.7, "move_s": 0.2},
         "bench": {"places": 24, "hold_s": 0.07, "walls_m": [2], "wall_s": 0.2}}
SWEEP = {"rigs": [{"name": "a", "heights_m": [0.3, 2.3, 0.3, 2.3]}], "trials": 400, "max_iterations": 50,
         "vary": {"gradient": ["printed", "corrected"], "threshold": [1, 1e-6], "error_cm": [[0, 5], [15, 30]]}}
FINDERS = ["as printed", "corrected, but eq. 1 as printed", "corrected, but E1 as printed", "corrected, but E2 as printed",
           "corrected, but E3 as printed", "corrected", "corrected by the mid-range", "ours"]
SHOWN_BY_BIN = ("ours", "corrected", "corrected by the mid-range")
KEY = ("condition", "group", "method", "against", "measure", "statistic", "take")
NONE = (math.nan, math.nan)


def stored(results):
    """numbers.csv: value, low, high, n and clusters by key."""
    with open(results / "numbers.csv", newline="") as file:
        return {tuple(row[key] for key in KEY): [float(row[key] or "nan") for key in ("value", "low", "high", "n", "clusters")]
                for row in csv.DictReader(file)}


def items(results):
    keys = json.loads((results / "manifest.json").read_text())["items"]
    return {name: json.loads((results / "items" / key / "item.json").read_text())["outcome"] for name, key in keys.items()}


def by_sensor(errors):
    """Sums and counts by sensor of the errors that are known: clusters of an interval."""
    known = [(sensor, error) for sensor, error in errors if error is not None]
    sensors = sorted({sensor for sensor, _ in known})
    return {s: np.array([(error, 1.0) for sensor, error in known if sensor == s]).sum(axis=0) for s in sensors}, [error for _, error in known]


def linearised(parts, mean):
    count = sum(n for _, n in parts.values())
    return {sensor: (total - mean * n) / count for sensor, (total, n) in parts.items()}


def interval(value, moved):
    """Student's t of a linearised value between clusters (Wolter, Introduction to Variance Estimation, chapter 6)."""
    k = len(moved)
    if k < 2:
        return NONE
    half = tables.STUDENT[k - 1] * math.sqrt(k / (k - 1) * sum(m * m for m in moved))
    return value - half, value + half


def spreads(key, samples):
    """Of the samples of a zone, as (sensor, distance error, error): mean, deviation and quantiles of both errors, and what is answered."""
    found = {}
    for measure, column in (("ball_distance", 1), ("ball_position", 2)):
        parts, known = by_sensor([(s[0], s[column]) for s in samples])
        if not known:
            continue
        mean = np.mean(known)
        low, high = interval(mean, linearised(parts, mean).values())
        found[*key, measure, "mean", ""] = (mean, max(0.0, low) if low == low else low, high, len(known), len(parts))
        for name, value in (("median", np.median(known)), ("p95", np.quantile(known, 0.95)), ("max", max(known))):
            found[*key, measure, name, ""] = (value, *NONE, len(known), 0)
        if len(known) > 1:
            found[*key, measure, "sd", ""] = (np.std(known, ddof=1), *NONE, len(known), 0)
    answered = [s for s in samples if s[1] is not None]
    if samples:
        found[*key, "answered", "share", ""] = (len(answered) / len(samples), *NONE, len(samples), 0)
    return found


def of_a_ball(name, recording):
    """All numbers of one recording of a ball."""
    found = {}
    for number, method in enumerate(FINDERS):
        samples = [s[1:] for s in recording["samples"] if s[0] == number]  # sensor, place, distance, angle, both errors
        inside = [s for s in samples if 0.8 <= s[2] <= 3.0 and s[3] is not None and math.degrees(s[3]) < 26]
        zones = {"inside": inside, "all": samples, "near": [s for s in samples if s[2] < 0.5]}
        if method in SHOWN_BY_BIN:
            for of, unit, edges, at in (("distance", "m", (0.5, 0.8, 1.5, 2.25, 3.0, 3.75), lambda s: s[2]),
                                        ("angle", "degrees", (9, 18, 26), lambda s: math.nan if s[3] is None else math.degrees(s[3]))):
                zones[f"{of} below {edges[0]:g} {unit}"] = [s for s in samples if at(s) < edges[0]]
                zones[f"{of} from {edges[-1]:g} {unit}"] = [s for s in samples if at(s) >= edges[-1]]
                for low, high in itertools.pairwise(edges):
                    zones[f"{of} {low:g} to {high:g} {unit}"] = [s for s in samples if low <= at(s) < high]
        for zone, chosen in zones.items():
            found.update(spreads((name, zone, method, ""), [(s[0], s[4], s[5]) for s in chosen]))
        base, _ = by_sensor([(s[0], s[4]) for s in inside])
        for zone, (near, far), (from_deg, to_deg) in (("nearer", (0.5, 0.8), (0, 26)), ("farther", (3.0, 8.0), (0, 26)), ("aside", (0.8, 3.0), (26, 90))):
            beside, known = by_sensor([(s[0], s[4]) for s in samples if s not in inside and near <= s[2] < far and s[3] is not None
                                       and from_deg <= math.degrees(s[3]) < to_deg])
            if not known or not base:
                continue
            a, b = np.mean(known), sum(t for t, _ in base.values()) / sum(n for _, n in base.values())
            of_a, of_b = linearised(beside, a), linearised(base, b)
            moved = [of_a.get(s, 0.0) / b - a / b**2 * of_b.get(s, 0.0) for s in set(of_a) | set(of_b)]
            found[name, zone, method, "inside", "ball_distance", "relative_difference", ""] = (a / b - 1, *interval(a / b - 1, moved), len(known), len(moved))
        if samples:
            another = sum((s[5] if s[5] is not None else s[4] or 0.0) > 2 * recording["ball_radius_m"] for s in samples)
            for status, count in {"another_thing": another, **recording["statuses"][number]}.items():
                found[name, "all", method, "", "status", status, ""] = (count / len(samples), *NONE, count, 0)
    for pose in recording["poses"]:
        for measure, statistic, key in (("pose", "difference", "position_m"), ("pose", "sigma", "position_sigma_m"),
                                        ("rotation", "difference", "rotation_rad"), ("rotation", "sigma", "rotation_sigma_rad")):
            if pose[key] is not None:
                found[name, pose["sensor"], pose["method"], "", measure, statistic, ""] = (pose[key], *NONE, 0, 0)
    return found


def of_a_wall(name, row):
    found, key = {}, (name, row["sensor"], "", "")
    columns = np.arange(512)
    for measure, statistic, value in (("wall", "distance", row["distance_m"]), ("wall", "stated", row["stated_m"]),
                                      ("wall", "noise", row["noise_m"]), ("tilt", "mean", row["tilt_rad"])):
        if value is not None:
            found[*key, measure, statistic, ""] = (value, *NONE, row["frames"], 0)
    for measure, name in (("residual", "residual_m"), ("sideways", "printed_error_m")):
        by_column = np.array([math.nan if value is None else value for value in row[name]])
        for statistic, chosen in (("left", columns < 150), ("middle", (columns >= 150) & (columns <= 350)), ("right", columns > 350),
                                  ("edge", (columns < 150) | (columns > 350))):
            found[*key, measure, statistic, ""] = (np.nanmean(by_column[chosen]), *NONE, row["frames"], 0)
        found[*key, measure, "max", ""] = (np.nanmax(by_column), *NONE, row["frames"], 0)
    return found


class OtherKinds(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.scratch.name)
        (cls.folder / "bench.json").write_text(json.dumps(BENCH))
        cls.run_program("simulate", "bench.json", "-o", "bench")

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    @classmethod
    def run_program(cls, *words):
        subprocess.run([pathlib.Path(PROGRAM).resolve(), *words], cwd=cls.folder, check=True, capture_output=True)

    def studied(self, kind, *more, **settings):
        (self.folder / f"{kind}.json").write_text(json.dumps({"format": "trilat.study", "version": 1, "kind": kind, "name": kind, **settings}))
        self.run_program("run", f"{kind}.json", *more, "-o", kind)
        return self.folder / kind

    def test_calibration_follows_from_its_samples(self):
        results = self.studied("calibration", "--campaign", "bench")
        outcomes, names = items(results), json.loads((results / "summary.json").read_text())["recordings"]
        kinds = sorted(outcomes, key=lambda name: ("distances", "wand", "walls").index(name.split("/")[0]))
        expected, by_method = {}, {}
        for kind, name in zip(kinds, names, strict=True):
            outcome = outcomes[kind]
            for row in outcome["rows"] if kind.startswith("walls/") else ():
                expected.update(of_a_wall(name, row))
            if not kind.startswith("walls/"):
                expected.update(of_a_ball(name, outcome))
                for pose in outcome["poses"]:
                    by_method.setdefault(pose["method"], []).append(pose["position_m"])
        for method, offs in by_method.items():
            known = [off for off in offs if off is not None]
            if known:
                low, high = interval(np.mean(known), (np.array(known) - np.mean(known)) / len(known))
                expected["", "", method, "", "pose", "mean_difference", ""] = (np.mean(known), max(0.0, low), high, len(known), len(known))
        found = stored(results)
        self.assertGreater(len(expected), 500)
        self.assertEqual(set(found), set(expected))
        for key, values in expected.items():
            for mine, its, digits in zip(values, found[key], (1e-9, 1e-4, 1e-4, 0, 0), strict=True):
                self.assertTrue(math.isclose(mine, its, rel_tol=digits, abs_tol=1e-4 * digits) or mine != mine and its != its, f"{key}: {values} and {found[key]}")

    def test_shares_of_clocks_are_those_of_their_computers(self):
        found = stored(self.studied("clocks", "--campaign", "bench"))
        checked = 0
        for (condition, group, method, _, measure, statistic, take), (value, low, high, n, clusters) in found.items():
            if take or statistic not in ("share_below_2ms", "share_below_4ms", "taken"):
                continue
            units = [other for key, other in found.items() if key[0] == condition and key[2:6] == (method, "", measure, statistic) and key[6]]
            share = sum(round(u[0] * u[3]) for u in units) / sum(u[3] for u in units)
            self.assertAlmostEqual(value, share, places=12)
            self.assertEqual(clusters, len(units))
            self.assertTrue(low <= value <= high)
            checked += 1
            if statistic == "taken":
                fates = [found[condition, group, method, "", "queue", fate, ""] for fate in ("untimed", "too_early", "too_late", "taken")]
                self.assertAlmostEqual(sum(fate[0] for fate in fates), 1.0, places=12)
                self.assertEqual(sum(fate[3] for fate in fates), found[condition, group, method, "", "queue", "came", ""][3])
            if statistic == "share_below_4ms":
                below = [found["", "", method, "", measure, name, ""][0] for name in ("share_below_2ms", "share_from_2_to_4ms")]
                self.assertAlmostEqual(value, sum(below), places=12)
        self.assertGreater(checked, 20)

    def test_numbers_of_a_cell_agree_with_each_other(self):
        results = self.studied("threshold_sweep", **SWEEP)
        found, cells = stored(results), json.loads((results / "summary.json").read_text())["cells"]
        self.assertEqual(len(cells), 8)
        whole = 0
        for cell in cells:
            def of(measure, statistic, column=0):
                return found[cell["condition"], cell["group"], cell["method"], "", measure, statistic, ""][column]
            mean, rms, n = of("distance", "mean"), of("distance", "rms"), of("distance", "mean", 3)
            statuses = {key[5]: row for key, row in found.items() if key[:3] == (cell["condition"], cell["group"], cell["method"]) and key[4] == "status"}
            self.assertEqual(sum(row[3] for row in statuses.values()), of("answered", "share", 3))
            self.assertEqual(statuses["converged"][3], n)
            self.assertAlmostEqual(of("answered", "share"), n / 400)
            self.assertTrue(of("distance", "median") <= of("distance", "p95") <= of("distance", "max"))
            self.assertTrue(mean <= rms <= of("distance", "max"))
            axes = [of(axis, "mean_abs") for axis in "xyz"]
            self.assertTrue(max(axes) <= mean <= sum(axes))
            half = 0.5 * (of("distance", "mean", 2) - of("distance", "mean", 1))
            if n == 400:
                self.assertAlmostEqual(half / math.sqrt((rms**2 - mean**2) / (n - 1)), 1.96593, places=4)  # Student's t of 399 degrees
                whole += 1
            self.assertTrue(of("iterations", "median") <= of("iterations", "p99") <= of("iterations", "max") <= 50)
        self.assertGreaterEqual(whole, 4)


if __name__ == "__main__":
    unittest.main(verbosity=2)
