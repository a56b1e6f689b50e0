#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Evaluates two small simulated campaigns again from their raw files and compares with what the program writes.

    recompute_test.py PROGRAM
"""
import copy
import csv
import itertools
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import h5py
import numpy as np

import read_take
import solve
import tables
import trilat

PROGRAM = sys.argv.pop(1) if len(sys.argv) > 1 else "build/release/trilat"
SAME_M = 1e-6  # single precision at 4 m
SAME_ANGLE_RAD = 3e-5  # arc cosines near a straight joint
SAME_RATIO = 1e-6  # of numbers that are stored in single precision
BIN_M, BIN_SHARE = 1e-3, 5e-3  # quantiles are of histograms; beyond 2 m their bins grow
SENSORS = ["k1", "k2", "k3", "k4"]
ALIGNMENTS = ["mean", "none", "first", "rigid", "held_out", "joint_offset"]
REFERENCE = "nonlinear"

# Heights that differ much, and 12 s, after which a clock's drift is known; the tracker's model on a rig that is nearly
# flat, where the hint decides between the sides of the sensors' plane; and a rig in between.
SHORT = {"activities": [{"name": "walking", "duration_s": 6}], "body_tracker": {}}
SIMULATIONS = {
    "high and low": {"activities": [{"name": "walking", "duration_s": 12}]},
    "nearly flat": {**SHORT, "rig": {"heights_m": [1.39, 1.41, 1.395, 1.405]}},
    "in between": {**SHORT, "rig": {"heights_m": [1.3, 1.5, 1.35, 1.4]}},
    # A person whose intervals are between blocks of time, seen by three sensors; arms and legs have markers in turn.
    "one person": {"activities": [{"name": "arm_swing", "duration_s": 12}, {"name": "leg_crossing", "duration_s": 16}], "participants": 1,
                   "body_tracker": {}, "rig": {"heights_m": [0.6, 2.2, 0.9]}},
    "stages": SHORT,
    "one take": {"activities": [{"name": "walking", "duration_s": 11}], "participants": 1, "body_tracker": {},
                 "rig": {"heights_m": [0.6, 2.2, 0.9]}}}
# What a study's stages change, one after the other.
STAGES = {"stages": [{"name": "as recorded"}, {"name": "live clocks", "sensor_clocks": "causal"},
                     {"name": "newest frames", "frames": "newest"}]}
OF_THREE_SENSORS = ("nonlinear", "mean", "median", "geometric")

# Each method's entry in the study and how it is computed again: solver, sensors, settings.
METHODS = {
    "linear": ({"method": "linear"}, solve.linear, SENSORS, {}),
    "linear k3": ({"method": "linear", "reference": "k3"}, solve.linear, SENSORS, {"reference": 2}),
    "linear all pairs": ({"method": "linear", "reference": "all_pairs"}, solve.linear, SENSORS, {"reference": None}),
    "geometric": ({"method": "geometric"}, solve.geometric, SENSORS[:3], {}),
    "nonlinear": ({"method": "nonlinear"}, solve.nonlinear, SENSORS, {}),
    "nonlinear, three": ({"method": "nonlinear", "sensors": ["k1", "k2", "k4"]}, solve.nonlinear,
                         ["k1", "k2", "k4"], {}),
    "nonlinear, sure": ({"method": "nonlinear", "range_sigma_m": 0}, solve.nonlinear, SENSORS, {"range_sigma_m": 1e-9}),
    "as printed": ({"method": "nonlinear", "gradient": "printed", "damping": "none", "stop": "printed",
                    "start": "guess"}, solve.as_printed, SENSORS, {}),
    "mean": ({"method": "mean"}, solve.mean, SENSORS, {}),
    "mean, three": ({"method": "mean", "sensors": ["k1", "k2", "k4"]}, solve.mean, ["k1", "k2", "k4"], {}),
    "tracked_mean": ({"method": "tracked_mean"}, solve.tracked_mean, SENSORS, {}),
    "mean, unoccluded": ({"method": "mean", "occlusion": "corrected"}, solve.mean, SENSORS, {}),
    "nonlinear, unoccluded": ({"method": "nonlinear", "occlusion": "printed", "fewest_sensors": 3}, solve.nonlinear,
                              SENSORS, {}),
    "median": ({"method": "median"}, solve.median, SENSORS, {}),
    **{f"single {name}": ({"method": "single", "sensors": [name]}, solve.mean, [name], {}) for name in SENSORS}}


def run_program(*arguments):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"{arguments} ended with {done.returncode}: {done.stderr}")


class Different(AssertionError):
    """Says which number differs, and both values."""


def require_same(what, expected, written, tolerance):
    """`what(*index)` names an element. NaN equals NaN; texts and counts must be equal."""
    expected, written = np.asarray(expected), np.asarray(written)
    if expected.shape != written.shape:
        raise Different(f"{what()}: {expected.shape} computed again, {written.shape} in the results")
    if expected.dtype == object or tolerance == 0:
        same = expected == written
    else:
        same = (np.abs(expected - written) <= tolerance) | (np.isnan(expected) & np.isnan(written))
    if not same.all():
        wrong = np.argwhere(~same)
        at = tuple(wrong[0])
        raise Different(f"{what(*at)}: {expected[at]!r} computed again, {written[at]!r} in the results "
                        f"({len(wrong)} of {same.size} differ)")


class Samples:
    """One take's samples: arrays instants x joints x methods."""

    def __init__(self, file):
        group = file["samples/0"]
        self.joints, self.methods = (list(file.attrs[name].astype(str)) for name in ("joints", "methods"))
        names = np.array(file.attrs["status_names"].astype(str), object)
        for name in ("time_ns", "heading_rad", "truth_m", "ranges", "occluded", "estimate_m", "iterations", "cost_m2",
                     "gdop"):
            setattr(self, name, group[name][:])
        self.estimate_m = self.estimate_m.astype(float)
        self.condition = np.char.decode(file.attrs["condition"]).item()
        self.status = names[group["status"][:]]
        self.usable = np.isin(self.status, solve.ANSWERS)
        self.asked = np.isfinite(self.truth_m[:, :, 0])
        self.answered = np.isin(self.status, solve.ANSWERS) & self.asked[:, :, None]


def sensors_used(take, name):
    """Instants x joints x sensors: those that see the joint, and that the method takes."""
    entry, _, sensors, _ = METHODS[name]
    used = (take.state > 0) & np.isin(take.sensors, sensors)  # of those that the campaign has
    if "occlusion" not in entry:
        return used
    count = np.where(used, take.crossings[entry["occlusion"]] + (take.state == 1), 10**6)
    wanted = np.clip(used.sum(axis=2), 1, entry.get("fewest_sensors", 1))
    most = np.take_along_axis(np.sort(count, axis=2), wanted[:, :, None] - 1, axis=2)
    return used & (count <= most)


def solve_again(take, name):
    """The method `name` for all instants and joints: estimate_m, status, iterations."""
    _, solver, _, settings = METHODS[name]
    shape = take.range_m.shape
    flat = [a.reshape(shape[0] * shape[1], *a.shape[2:]) for a in (take.world_m, take.range_m, take.state,
                                                                             sensors_used(take, name))]
    found = solver(take.sensor_m, *flat, **settings)
    return [a.reshape(shape[0], shape[1], *a.shape[1:]) for a in found]


def compare_take(take, samples):
    """Instants, truth, and every method's estimates and statuses."""
    def place(i=0, j=0, axis=0):
        return f"take {take.id}, instant {i}, joint {take.joints[j]}"

    require_same(lambda i=0: f"time_ns of {place(i)}", take.time_ns, samples.time_ns, 0)
    require_same(lambda *at: f"truth_m of {place(*at)}", take.truth_m, samples.truth_m, SAME_M)
    require_same(lambda *at: f"ranges of {place(*at)}", (take.state > 0).sum(axis=2), samples.ranges, 0)
    occluded = (take.state == 1) | ((take.state == 2) & (take.crossings["corrected"] > 0))
    require_same(lambda *at: f"occluded of {place(*at)}", occluded.sum(axis=2), samples.occluded, 0)
    for m, name in enumerate(samples.methods):
        estimate_m, status, iterations = solve_again(take, name)
        require_same(lambda *at: f"status of {name}, {place(*at)}", status, samples.status[:, :, m], 0)
        answered = np.isin(status, solve.ANSWERS)
        require_same(lambda *at: f"estimate_m of {name}, {place(*at)}",
                     np.where(answered[:, :, None], estimate_m, np.nan),
                     np.where(answered[:, :, None], samples.estimate_m[:, :, m], np.nan), SAME_M)
        require_same(lambda *at: f"iterations of {name}, {place(*at)}",
                     np.where(iterations < 0, samples.iterations[:, :, m], iterations), samples.iterations[:, :, m], 0)
        compare_geometry(take, name, samples, m, place)


def compare_geometry(take, name, samples, m, place):
    """cost_m2 = sum f_i^2 and gdop = sqrt trace (J^T J)^-1 of answers by ranges."""
    if METHODS[name][0]["method"] not in ("linear", "geometric", "nonlinear"):
        return
    used = sensors_used(take, name)
    away_m = samples.estimate_m[:, :, m, None] - take.sensor_m
    d_m = np.linalg.norm(away_m, axis=3)
    u = np.where(used[..., None], away_m / d_m[..., None], 0.0)
    cost_m2 = np.where(used, (d_m - take.range_m)**2, 0.0).sum(axis=2)
    answered = np.isin(samples.status[:, :, m], solve.ANSWERS)
    finite = answered & np.isfinite(samples.gdop[:, :, m])  # not so where a clamped point lies in the sensors' plane
    normal = np.einsum("nsa,nsb->nab", u[finite], u[finite])
    gdop = np.sqrt(np.trace(np.linalg.inv(normal), axis1=1, axis2=2))
    require_same(lambda *at: f"cost_m2 of {name}, {place(*at)}", cost_m2[answered],
                 samples.cost_m2[:, :, m][answered], SAME_M)
    require_same(lambda *at: f"gdop of {name}, {place(*at)}, relative", np.ones(finite.sum()),
                 samples.gdop[:, :, m][finite] / gdop, 1e-4)


class Stored:
    """The rows of numbers.csv. Each is compared once and taken out, so that in the end none is left."""

    def __init__(self, folder):
        with open(folder / "numbers.csv", newline="") as file:
            self.rows = {tuple(row[key] for key in trilat.NUMBER_KEYS):
                         {key: float(row[key] or "nan") for key in ("value", "low", "high", "n", "clusters")} for row in csv.DictReader(file)}

    def require(self, value, n, tolerance=None, **keys):
        """Gives the row; nothing where the value is NaN, which is not stored."""
        where = ", ".join(f"{key} {text}" for key, text in keys.items())
        row = self.rows.pop(tuple(keys.get(key, "") for key in trilat.NUMBER_KEYS), None)
        if (row is None) != bool(np.isnan(value)):
            raise Different(f"{where}: {value} computed again, {row} in the results")
        if row is not None:
            require_same(lambda: where, np.asarray(float(value)), np.asarray(row["value"]),
                         SAME_RATIO * max(1.0, abs(value)) if tolerance is None else tolerance)
            require_same(lambda: f"n of {where}", np.asarray(float(n)), np.asarray(row["n"]), 0)
        return row


def compare_tables(takes, stored):
    """The numbers of all takes together, of all samples and of those that a sensor sees occluded."""
    for condition in dict.fromkeys(s.condition for s in takes):
        of_condition = [s for s in takes if s.condition == condition]
        for m, name in enumerate(takes[0].methods):
            for alignment in ALIGNMENTS:
                compare_method(of_condition, condition, m, name, alignment, stored)


def compare_method(takes, condition, m, name, alignment, stored):
    groups, reference = tables.joints_of_groups(takes[0].joints), takes[0].methods.index(REFERENCE)
    errors_m = [tables.errors_of(s, m, alignment, s.answered[:, :, m]) for s in takes]
    pairs = [tables.lengths_on_both(s, m, reference, alignment) for s in takes]
    asked = [s.asked & tables.in_test_part(s, alignment) for s in takes]
    for condition, parts in ((condition, asked), (f"{condition}, occluded", [a & (s.occluded > 0) for a, s in zip(asked, takes)])):
        computed = {g: tables.cell_of(takes, m, joints, errors_m, parts) for g, joints in groups.items()}
        computed = {g: cell for g, cell in computed.items() if cell["asked"] > 0}
        against = tables.differences_of(pairs, {g: groups[g] for g in computed}, parts)
        computed["average"] = tables.average_of(computed.values())
        for group, cell in computed.items():
            keys = {"condition": condition, "group": group, "method": name, "alignment": alignment}
            mean = compare_cell(cell, keys, stored)
            if alignment in ("none", "mean") and group != "average":
                compare_limits(takes, errors_m, parts, groups[group], keys, stored)
            if mean and mean["clusters"] > 1 and len(takes) == 1 and group != "average" and parts is asked:
                low_m, high_m, clusters = tables.interval_of_blocks(takes[0], m, groups[group], alignment)
                for key, value in (("low", max(0.0, low_m)), ("high", high_m), ("clusters", clusters)):
                    require_same(lambda: f"{key} of {keys}", np.asarray(value), np.asarray(mean[key]), 1e-5 * max(1.0, value))
            if m != reference:
                n, difference_m, share = against[group]
                for statistic, value in (("difference", difference_m), ("relative_difference", share)):
                    stored.require(value, n, **keys, against=REFERENCE, measure="distance", statistic=statistic)


def compare_cell(cell, keys, stored):
    for status, count in cell["statuses"].items():
        stored.require(count / cell["asked"], count, **keys, measure="status", statistic=status)
    stored.require(cell["answered"] / cell["asked"], cell["asked"], **keys, measure="answered", statistic="share")
    for (measure, statistic), value in cell["statistics"].items():
        n = cell["asked"] if measure == "iterations" else cell["answered"]
        off_m = max(BIN_M, BIN_SHARE * value) if value > 2.0 else BIN_M
        stored.require(value, n, off_m if statistic in tables.QUANTILES else None, **keys, measure=measure, statistic=statistic)
    return stored.require(cell["mean"], cell["answered"], **keys, measure="distance", statistic="mean")


def compare_limits(takes, errors_m, parts, joints, keys, stored):
    for axis, measure in enumerate("xyz"):
        for statistic, value in tables.limits_of(takes, errors_m, parts, joints, axis).items():
            n = sum(np.isfinite(e[:, joints, 0][part[:, joints]]).sum() for e, part in zip(errors_m, parts))
            stored.require(value, n, **keys, measure=measure, statistic=statistic)


def compare_bodies(takes, stored):
    for condition in dict.fromkeys(s.condition for s in takes):
        of_condition = [s for s in takes if s.condition == condition]
        for m, name in enumerate(takes[0].methods):
            bodies = tables.bodies_of(of_condition, m)
            for (measure, statistic, alignment), (value, n) in bodies.items():
                if measure != "truth":
                    stored.require(value, n, **{"condition": condition, "method": name, "measure": measure, "statistic": statistic, "alignment": alignment})
        value, n = bodies["truth", "mean", ""]
        stored.require(value, n, condition=condition, measure="jerk", statistic="mean_of_truth")


def compare_angles(takes, ids, stored):
    """Joint angles, of all takes of a condition and of each."""
    for condition in dict.fromkeys(s.condition for s in takes):
        of_condition = [(s, take) for s, take in zip(takes, ids) if s.condition == condition]
        for (m, name), (angle, joints) in itertools.product(enumerate(takes[0].methods), tables.ANGLES.items()):
            if not {f"{joint}_left" for joint in joints} <= set(takes[0].joints):
                continue
            found = [tables.angles_of(s, m, joints) for s, _ in of_condition]
            keys = {"condition": condition, "group": angle, "method": name, "measure": "angle"}
            clusters = [np.array(part) for part in (found[0]["error"] if len(found) == 1 else [sum(one["error"], []) for one in found])]
            error = np.concatenate(clusters)
            if not len(error):
                continue
            bias, sd = error.mean(), tables.spread_of(clusters)
            for statistic, value in {"mean_abs": np.abs(error).mean(), "rms": np.sqrt((error**2).mean()), "bias": bias, "sd": sd,
                                     "lower_limit": bias - 1.96 * sd, "upper_limit": bias + 1.96 * sd}.items():
                stored.require(value, len(error), SAME_ANGLE_RAD, **keys, statistic=statistic)
            for statistic, of in (("motion_range", "estimate"), ("true_motion_range", "truth")):
                stored.require(np.mean([np.ptp(one[of]) for one in found]), len(found), SAME_ANGLE_RAD, **keys, statistic=statistic)
            for (_, take), one in zip(of_condition, found):
                errors = sum(one["error"], [])
                for statistic, value in (("bias", np.mean(errors)), ("mean_of_truth", np.mean(one["truth"]))):
                    stored.require(value, len(errors), SAME_ANGLE_RAD, **keys, statistic=statistic, take=take)


def compare_rows_of_takes(takes, ids, stored, error_m):
    """Numbers by take, and the errors that the Python module gives: both under the study's first alignment."""
    shapes = [s.estimate_m.shape for s in takes]
    given_m = [part.reshape(shape) for part, shape in
               zip(np.split(error_m, np.cumsum([np.prod(shape[:3]) for shape in shapes])[:-1]), shapes)]
    for s, take, given in zip(takes, ids, given_m):
        for m, name in enumerate(s.methods):
            errors_m = tables.errors_of(s, m, ALIGNMENTS[0], s.answered[:, :, m])
            require_same(lambda i=0, j=0, axis=0: f"error_m of {name}, take {take}, instant {i}, joint {s.joints[j]}",
                         errors_m, given[:, :, m], SAME_M)
            for condition, part in ((s.condition, s.asked), (f"{s.condition}, occluded", s.asked & (s.occluded > 0))):
                for j in np.flatnonzero(part.any(axis=0)):
                    keys = {"condition": condition, "take": take, "group": s.joints[j], "method": name, "alignment": ALIGNMENTS[0]}
                    asked, length_m = int(part[:, j].sum()), np.linalg.norm(errors_m[s.answered[:, j, m] & part[:, j], j], axis=1)
                    stored.require(len(length_m) / asked, asked, **keys, measure="answered", statistic="share")
                    stored.require(tables.mean_of(length_m), len(length_m), **keys, measure="distance", statistic="mean")


class Results:
    """A campaign, simulated and evaluated by the program, and its takes as the raw files have them."""

    def __init__(self, folder, name):
        simulation = {"format": "trilat.simulation", "version": 1, "name": name, "seed": 7, "participants": 2, **SIMULATIONS[name]}
        three = len(simulation.get("rig", {}).get("heights_m", SENSORS)) == 3
        study = {"format": "trilat.study", "version": 1, "kind": "accuracy", "name": name, "alignments": ALIGNMENTS,
                 "reference": REFERENCE, "clock": "stated", "repair_exchanges": False,
                 "occluded_apart": True,
                 **({"stages": STAGES[name]} if name in STAGES else {}),
                 "methods": [{"name": method, **entry[0]} for method, entry in METHODS.items() if not three or method in OF_THREE_SENSORS]}
        (folder / f"{name}_simulation.json").write_text(json.dumps(simulation))
        (folder / f"{name}_study.json").write_text(json.dumps(study))
        run_program("simulate", folder / f"{name}_simulation.json", "-o", folder / name)
        results = folder / f"{name}_results"
        run_program("run", folder / f"{name}_study.json", "--campaign", folder / name, "-o", results)
        self.stored = Stored(results)
        manifest = json.loads((results / "manifest.json").read_text())
        items = [results / "items" / manifest["items"]["takes/" + take["id"]] for take in manifest["takes"]]
        self.samples = []
        for item in items:
            with h5py.File(item / "take.h5") as file:
                self.samples.append(Samples(file))
        entries = json.loads((folder / name / "campaign.json").read_text())["takes"]
        self.takes, stage = [], {}
        for number, changes in enumerate(STAGES.get(name, [{}]), 1):
            stage = {**stage, **changes}
            for entry in entries:
                take = read_take.TakeAtInstants(folder / name, entry, self.samples[0].joints,
                                                SENSORS[:3] if three else SENSORS, stage=stage)
                take.id += f".{number}" if name in STAGES else ""
                self.takes.append(take)
        columns = trilat.results(results).columns()
        self.error_m = np.stack([columns[f"error_{axis}_m"] for axis in "xyz"], axis=1)

    def compare(self):
        for take, samples in zip(self.takes, self.samples):
            compare_take(take, samples)
        stored = copy.deepcopy(self.stored)
        compare_rows_of_takes(self.samples, [take.id for take in self.takes], stored, self.error_m)
        compare_tables(self.samples, stored)
        compare_bodies(self.samples, stored)
        compare_angles(self.samples, [take.id for take in self.takes], stored)
        if stored.rows:
            raise Different(f"numbers.csv also has {list(stored.rows)}")


class Recompute(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory() as folder:
            cls.results = {name: Results(pathlib.Path(folder), name) for name in SIMULATIONS}

    def test_samples_and_tables_follow_from_the_raw_files(self):
        for name, results in self.results.items():
            with self.subTest(campaign=name):
                results.compare()

    def test_angles_are_among_the_numbers(self):
        for name in ("one person", "one take"):
            self.assertTrue(any("angle" in key for key in self.results[name].stored.rows))

    def test_every_kind_of_answer_is_among_the_samples(self):
        found = set().union(*(s.status.ravel() for results in self.results.values() for s in results.samples))
        self.assertLessEqual({"converged", "closed_form", "clamped", "mirror_ambiguous", "rank_deficient",
                              "too_few_ranges", "no_observation"}, found)

    def says(self, alter, *words):
        """`alter` changes a copy of the results; the comparison must say all these words."""
        altered = copy.deepcopy(self.results["high and low"])
        alter(altered)
        with self.assertRaises(Different) as raised:
            altered.compare()
        for word in words:
            self.assertIn(word, str(raised.exception))

    def test_an_estimate_that_is_two_micrometres_off_is_named(self):
        def alter(results):
            results.samples[1].estimate_m[100, 3, 4, 0] += 2e-6
        self.says(alter, "estimate_m of nonlinear, take p02-walking, instant 100, joint elbow_left",
                  "computed again", "in the results (1 of")

    def test_an_instant_that_is_a_nanosecond_late_is_named(self):
        def alter(results):
            results.samples[0].time_ns[7] += 1
        self.says(alter, "time_ns of take p01-walking, instant 7")

    def test_a_status_that_differs_is_named(self):
        def alter(results):
            results.samples[0].status[50, 2, 0] = "diverged"
        self.says(alter, "status of linear, take p01-walking, instant 50, joint shoulder_right", "'diverged'")

    def row_that_is_off(self, off_m, **keys):
        def alter(results):
            row = next(row for key, row in results.stored.rows.items() if keys.items() <= dict(zip(trilat.NUMBER_KEYS, key)).items())
            row["value"] += off_m
        self.says(alter, *(f"{key} {text}" for key, text in keys.items()))

    def test_a_number_that_is_two_micrometres_off_is_named(self):
        mean = {"measure": "distance", "statistic": "mean"}
        self.row_that_is_off(2e-6, group="elbow", method="mean", alignment="rigid", **mean)
        self.row_that_is_off(2e-6, method="geometric", take="p01-walking", **mean)
        self.row_that_is_off(-2e-6, group="average", method="linear", measure="distance", statistic="difference")
        self.row_that_is_off(2e-6, method="mean", measure="z", statistic="upper_limit")

    def test_a_number_more_is_named(self):
        def alter(results):
            results.stored.rows["walking", *7 * ["more"]] = {}
        self.says(alter, "numbers.csv also has [('walking', 'more'")


if __name__ == "__main__":
    unittest.main(verbosity=2)
