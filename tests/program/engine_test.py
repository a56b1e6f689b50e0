# SPDX-License-Identifier: MIT
"""What holds for studies of every kind, and for simulations: the same bytes for any number of threads, after any stop, and in shards."""
import json
import os
import shutil
import signal
import subprocess
import time
import unittest

from made import PROGRAM, ScratchTest, ended, everything_in, made, settled, stopped_with, trilat

WALK = {"format": "trilat.simulation", "version": 1, "name": "walk", "participants": 4, "body_tracker": {},
        "activities": [{"name": "walking", "duration_s": 2}]}
SOLVERS = [{"method": "nonlinear"}, {"method": "mean"}]
EVERY_METHOD = [{"method": name} for name in ("linear", "geometric", "nonlinear", "newton", "ceres", "range_bearing", "mean", "tracked_mean",
                                              "median", "single", "kalman", "rts", "window")]
STUDIES = {
    "accuracy": {"campaign": "campaign", "methods": EVERY_METHOD, "alignments": ["mean", "none", "joint_offset"]},
    "threshold_sweep": {"rigs": [{"name": "a", "heights_m": [0.3, 2.3, 0.3, 2.3]}], "trials": 20000,
                        "vary": {"gradient": ["printed", "corrected"], "threshold": [1, 1e-2, 1e-4, 1e-6],
                                 "error_cm": [[15, 30], [5, 15], [0, 5]]}, "max_iterations": 20, "time_problems": 5},
    "calibration": {"campaign": "bench", "frames": 2},
    "clocks": {"campaign": "campaign"},
}
MARK = {"simulation": "campaign.json"}  # the file that finishes an output
KINDS = set(os.environ.get("TRILAT_KINDS", "simulation " + " ".join(STUDIES)).split())


class Studies(ScratchTest):
    def setUp(self):
        super().setUp()
        self.written("walk.json", WALK)
        self.written("depth.json", {**WALK, "participants": 3, "depth": {"takes": True}, "wand": {"positions": 3, "hold_s": 0.1},
                                    "activities": [{"name": "walking", "duration_s": 0.5}]})
        for name in ("campaign", "bench"):
            os.symlink(made() / name, self.folder / name)

    studies = STUDIES

    def study(self, kind):
        return self.written(f"{kind}.json", {"format": "trilat.study", "version": 1, "kind": kind, "name": "tiny", **self.studies[kind]})

    def each(self):
        """Every kind of study as the words that run it, with a number of threads; and a simulation, which takes all there are."""
        for kind in [kind for kind in STUDIES if kind in KINDS]:
            yield kind, lambda threads, kind=kind: ["run", self.study(kind), "--threads", threads]
        if "simulation" in KINDS:
            yield "simulation", lambda threads: ["simulate", self.folder / "depth.json"]


class Threads(Studies):
    def test_all_kinds_are_here(self):
        said = ended("run", self.written("odd.json", {"format": "trilat.study", "version": 1, "kind": "odd", "name": "odd"})).stderr
        self.assertEqual(set(said.strip().split("allowed: ")[1].split(", ")), set(STUDIES))

    def test_any_number_of_threads_leaves_the_same_bytes(self):
        for kind, words in self.each():
            with self.subTest(kind):
                for threads in (1, 2, 8):
                    trilat(*words(threads), "-o", self.folder / f"{kind}-{threads}")
                    self.assert_same(self.folder / f"{kind}-1", self.folder / f"{kind}-{threads}")


class Stops(Studies):
    studies = {**STUDIES, "accuracy": {**STUDIES["accuracy"], "methods": SOLVERS}}

    def test_stops_leave_the_same_bytes(self):
        stops = 0
        for kind, words in self.each():
            with self.subTest(kind):
                whole, gone_on = self.folder / f"{kind}-whole", self.folder / f"{kind}-gone-on"
                trilat(*words(1), "-o", whole)
                for items, by in ((1, signal.SIGINT), (2, signal.SIGKILL), (2, signal.SIGTERM)):
                    code, said = stopped_with(items, gone_on, *words(1), "-o", gone_on, by=by)
                    if code in (-signal.SIGINT, -signal.SIGTERM):  # it had not begun
                        self.assertEqual(said, "")
                        continue
                    self.assertIn(code, (0, 130, -signal.SIGKILL), said)
                    if code == 0 or (gone_on / MARK.get(kind, "summary.json")).exists():  # a stop may also come between the last step and the program's end
                        self.assert_same(whole, gone_on)
                        break
                    stops += 1
                trilat(*words(2), "-o", gone_on)
                self.assert_same(whole, gone_on)
        self.assertGreater(stops, len(KINDS) // 2)

    def test_shards_fill_one_store_or_several_that_are_copied_together(self):
        for kind in [kind for kind in STUDIES if kind in KINDS]:
            with self.subTest(kind):
                words, whole = ["run", self.study(kind), "--threads", 2], self.folder / f"{kind}-whole"
                trilat(*words, "-o", whole)
                shared, apart = self.folder / f"{kind}-shared", self.folder / f"{kind}-apart"
                for k in (3, 1, 2):
                    trilat(*words, "-o", shared if k < 3 else apart, "--shard", f"{k}/3")
                    self.assertFalse((shared / "summary.json").exists())
                self.assertIn("is unfinished", trilat("report", shared, "-o", self.folder / "report", code=2))
                shutil.copytree(apart / "items", shared / "items", dirs_exist_ok=True)
                done = json.loads(ended(*words, "-o", shared, "--json").stdout)
                self.assertEqual((done["items_computed"], done["items_failed"]), (0, 0))
                self.assert_same(whole, shared)

    def test_a_shard_of_other_inputs_leaves_nothing_that_looks_finished(self):
        shutil.copytree(made() / "campaign", self.folder / "own")
        words = ["run", self.written("own.json", {**json.loads(self.study("accuracy").read_text()), "campaign": "own"})]
        trilat(*words, "-o", self.folder / "results")
        path = self.folder / "own/campaign.json"
        campaign = json.loads(path.read_text())
        for take in campaign["takes"]:
            take["mocap_start_host_ns"] += 200_000_000
        path.write_text(json.dumps(campaign))
        trilat(*words, "-o", self.folder / "results", "--shard", "1/1")
        self.assertFalse((self.folder / "results/summary.json").exists())
        self.assertIn("is unfinished", trilat("report", self.folder / "results", "-o", self.folder / "report", code=2))

    def test_items_that_are_damaged_or_of_another_key_are_named_and_computed_again(self):
        words, results = ["run", self.study("accuracy")], self.folder / "results"
        trilat(*words, "-o", results)
        before = settled(results)
        cut, other, *_ = sorted((results / "items").iterdir())
        (cut / "take.h5").write_bytes((cut / "take.h5").read_bytes()[:-100])
        shutil.rmtree(other)
        shutil.copytree(cut, other)
        said = trilat(*words, "-o", results)
        self.assertIn(f"{cut.name}/take.h5: is not whole", said)
        self.assertIn(f"{other.name}/item.json /key: is another than the name of its folder", said)
        self.assertEqual(settled(results), before)

    def test_what_did_not_change_is_not_touched_and_what_was_thrown_away_is_made_again(self):
        for kind in [kind for kind in STUDIES if kind in KINDS]:
            with self.subTest(kind):
                words, results = ["run", self.study(kind)], self.folder / kind
                trilat(*words, "-o", results)
                before = everything_in(results)
                times = {name: (results / name).stat().st_mtime_ns for name in before if name not in ("run.json", "timings.json")}
                self.assertEqual(json.loads(ended(*words, "-o", results, "--json").stdout)["items_computed"], 0)
                self.assertEqual(times, {name: (results / name).stat().st_mtime_ns for name in times})
                (results / "summary.json").unlink()
                trilat(*words, "-o", results)
                self.assertEqual((results / "summary.json").read_bytes(), before["summary.json"])
                self.assertEqual(json.loads(ended(*words, "-o", results, "--fresh", "--json").stdout)["items_found"], 0)

    def test_settings_that_change_leave_nothing_of_the_others(self):
        changes = (("accuracy", {"rate_hz": 15}), ("accuracy", {"alignments": ["none", "mean"]}), ("calibration", {"frames": 1}))
        for number, (kind, changed) in enumerate(changes):
            if kind not in KINDS:
                continue
            with self.subTest(kind, changed=changed):
                folder = self.folder / str(number)
                before = ["run", self.study(kind), "--threads", 1]
                after = ["run", self.written("after.json", {**json.loads(before[1].read_text()), **changed})]
                trilat(*before, "-o", folder / "before")
                trilat(*after, "-o", folder / "whole")
                for items in (1, 3, 5, 1000):  # the last is finished before
                    output = folder / str(items)
                    stopped_with(items, output, *before, "-o", output, by=signal.SIGKILL)
                    trilat(*after, "-o", output)
                    self.assert_same(folder / "whole", output)

    def test_files_of_others_in_the_folder_stay(self):
        words, results = ["run", self.study("clocks")], self.folder / "results"
        trilat(*words, "-o", results)
        for name in ("notes.csv", "notes.json"):
            (results / name).write_text("ten years of work")
        trilat(*words, "-o", results, "--fresh")
        for name in ("notes.csv", "notes.json"):
            self.assertEqual((results / name).read_text(), "ten years of work")

    def test_two_runs_cannot_fill_one_folder(self):
        words = ["run", self.study("clocks"), "-o", self.folder / "results"]
        os.symlink("results", self.folder / "link")
        first = subprocess.Popen([PROGRAM, *map(str, words)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        while not (self.folder / "results.lock").exists() and first.poll() is None:
            time.sleep(0.001)
        second = ended(*words[:-1], f"{self.folder}/link/")  # the same folder by another name
        self.assertEqual(first.wait(), 0)
        if second.returncode == 2:
            self.assertIn("results", second.stderr)
        else:  # the first was done before
            self.assertEqual(second.returncode, 0, second.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
