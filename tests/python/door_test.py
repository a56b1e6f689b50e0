# SPDX-License-Identifier: MIT
"""Sessions, results and the program from Python, held to the program's own CSV, `verify` and `info`."""
import contextlib
import csv
import importlib.util
import io
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

import made_up_files as made
import trilat
from trilat.convert.__main__ import main as convert
from trilat.program import call, program_path

STUDY = {"format": "trilat.study", "version": 1, "kind": "accuracy", "name": "door", "alignments": ["none", "mean"],
         "methods": [{"method": "nonlinear"}, {"method": "mean"}]}
SIMULATION = {"format": "trilat.simulation", "version": 1, "participants": 2, "activities": [{"name": "walking", "duration_s": 3}]}


def missing(*modules):
    return [name for name in modules if importlib.util.find_spec(name) is None]


class Opened(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.holder.cleanup)
        cls.folder = Path(cls.holder.name)
        (cls.folder / "simulation.json").write_text(json.dumps(SIMULATION))
        (cls.folder / "study.json").write_text(json.dumps(STUDY))
        call("simulate", cls.folder / "simulation.json", "-o", cls.folder / "camp")
        cls.results = trilat.run(cls.folder / "study.json", campaign=cls.folder / "camp", output=cls.folder / "results")

    def errors_of_the_wrists(self):
        return trilat.numbers(self.results.folder, method="mean", group="wrist", alignment="none", measure="distance", statistic="mean")


class Door(Opened):
    def test_a_failing_run_raises_with_the_programs_message(self):
        with self.assertRaisesRegex(trilat.ProgramError, "absent.json") as raised:
            trilat.run(self.folder / "absent.json", output=self.folder / "none")
        self.assertEqual(raised.exception.code, 2)

    def test_three_cameras_of_ntu_go_from_their_files_to_a_table(self):
        """Simulated bodies, written as NTU RGB+D writes them: no truth, so each camera is predicted from the others."""
        (self.folder / "three.json").write_text(json.dumps(SIMULATION | {
            "participants": 1, "activities": [{"name": "arm_swing", "duration_s": 8}],
            "rig": {"radius_m": 2.5, "heights_m": [1.2, 1.2, 1.2], "arc_deg": 90}}))
        call("simulate", self.folder / "three.json", "-o", self.folder / "three")
        own = self.folder / "ntu/p1"
        own.mkdir(parents=True)
        with trilat.session(self.folder / "three/p01-arm_swing/session.h5") as session:
            for number, name in enumerate(("k1", "k2", "k3"), 1):
                bodies, frames = session[name].bodies(), []
                number_of = np.round(30 * bodies.time_s)
                for frame in range(int(number_of[-1]) + 1):
                    shown = np.flatnonzero(number_of == frame)[:1]
                    frames.append(made.ntu_frame(*(made.ntu_body(frame, joints_m=bodies.position_m[k], states=bodies.tracking_state[k])
                                                   for k in shown)))
                (own / f"S001C00{number}P001R001A001.skeleton").write_text(f"{len(frames)}\n" + "".join(frames))
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            self.assertEqual(convert(["ntu", *map(str, sorted(own.glob("*.skeleton"))), "-o", str(own / "swing.h5")]), 0)
        call("calibrate", own / "swing.h5", "--method", "bodies", "-o", own / "calibration.json")
        call("init", own.parent)
        results = trilat.run(own.parent / "study.json", campaign=own.parent, output=self.folder / "ntu_results")
        self.assertEqual(results.summary["truth"], "left_out_sensor")
        mean = {row["measure"]: row for row in trilat.numbers(self.folder / "ntu_results", condition="swing", method="mean", group="")}
        self.assertTrue(0.01 < mean["bearing"]["value"] < 0.15 and mean["bearing"]["n"] > 1000, mean)
        self.assertTrue(0.0 < mean["bone"]["value"] < 0.1 < mean["jerk"]["value"], mean)
        columns = results.columns()
        errors_m = {track: np.nanmean(columns["error_m"][(columns["track"] == track) & (columns["method"] == "mean")]) for track in ("C001", "C002")}
        self.assertTrue(0.0 < errors_m["C001"] != errors_m["C002"] > 0.0, errors_m)

    def test_mean_error_of_the_columns_is_the_tables(self):
        columns = self.results.columns()
        (mean,) = self.errors_of_the_wrists()
        chosen = (columns["method"] == "mean") & np.isin(columns["joint"], ["wrist_left", "wrist_right"])
        self.assertAlmostEqual(np.nanmean(columns["error_m"][chosen]), mean["value"], 7)

    def test_errors_under_every_alignment_are_those_of_the_tables(self):
        for alignment in ("none", "first", "mean", "rigid", "held_out", "joint_offset"):
            with self.subTest(alignment):
                (self.folder / "aligned.json").write_text(json.dumps({**STUDY, "alignments": [alignment]}))
                results = trilat.run(self.folder / "aligned.json", campaign=self.folder / "camp", output=self.folder / "aligned")
                columns = results.columns()
                checked = 0
                for row in trilat.numbers(results.folder, measure="distance", statistic="mean"):
                    chosen = (columns["method"] == row["method"]) & np.isin(columns["joint"], [row["group"], f"{row['group']}_left",
                                                                                               f"{row['group']}_right"])
                    if row["group"] == "average":
                        continue
                    self.assertAlmostEqual(np.nanmean(columns["error_m"][chosen]), row["value"], 7)
                    checked += 1
                self.assertGreater(checked, 5)

    def test_joints_are_written_as_they_are_or_refused(self):
        time_s, at_m = np.arange(5) / 30, {"head": np.arange(15.0).reshape(5, 3) / 7}
        at_m["head"][2] = np.nan
        trilat.write_joints(self.folder / "mine.csv", time_s, at_m)
        rows = list(csv.DictReader((self.folder / "mine.csv").open()))
        self.assertEqual([float(row["time_s"]) for row in rows], time_s.tolist())
        self.assertEqual([row["x_m"] for row in rows][:3], ["0.0", repr(3 / 7), ""])
        trilat.write_joints(self.folder / "mine.trc", time_s, at_m)
        lines = (self.folder / "mine.trc").read_text().splitlines()
        self.assertEqual(lines[2].split("\t")[:5], ["30.000000", "30.000000", "5", "1", "mm"])
        self.assertEqual(lines[7].split("\t"), ["2", "0.033333", "428.571429", "571.428571", "714.285714"])
        self.assertEqual(lines[8].split("\t"), ["3", "0.066667", "", "", ""])
        with_hole = np.delete(np.arange(6), 3) / 30
        for name, times, joints, problem in (
                ("a.trc", with_hole, at_m, "a TRC needs times at a fixed rate"), ("a.csv", time_s[::-1], at_m, "rising times"),
                ("a.csv", time_s[:0], {}, "rising times"), ("a.csv", time_s[:4], at_m, r"head has the shape \(5, 3\)"),
                ("a.csv", time_s, {"a,b": at_m["head"]}, "without commas"), ("a.csv", time_s, {}, "no joints"), ("a.txt", time_s, at_m, "must end in")):
            with self.subTest(problem), self.assertRaisesRegex(trilat.InputError, problem):
                trilat.write_joints(self.folder / name, times, joints)
            self.assertFalse((self.folder / name).exists())
        trilat.write_joints(self.folder / "hole.csv", with_hole, at_m)

    def test_a_session_is_what_info_says(self):
        path = self.folder / "camp/p01-walking/session.h5"
        told = json.loads(call("info", "--json", path))["sensors"]
        with trilat.session(path) as session:
            self.assertEqual(session.sensors, tuple(s["name"] for s in told))
            self.assertTrue(session.simulated)
            for sensor in told:
                bodies = session[sensor["name"]].bodies()
                self.assertEqual(len(bodies), sensor["bodies"])
                self.assertEqual(len(session[sensor["name"]].frame_times_s()), sensor["body_frames"])
                self.assertTrue((bodies.position_m[bodies.tracking_state == 2][:, 2] > 0.4).all())
                self.assertAlmostEqual(float(np.median(np.diff(np.unique(bodies.time_s)))), 1 / 30, 3)
            with self.assertRaisesRegex(trilat.InputError, 'no sensor "k9"; it has k1, k2'):
                session["k9"]

    def sensor(self, frames=5):
        position_m = np.zeros((frames, 25, 3), np.float32) + np.arange(3, dtype=np.float32)
        return trilat.SensorFrames(device_ticks=np.arange(frames) * 333_333, frame=np.arange(frames), position_m=position_m,
                                   tracking_state=np.full((frames, 25), 2),
                                   depth=[(i, i * 333_333, i, np.full((424, 512), 1000 + i, np.uint16)) for i in range(frames)])

    def test_a_written_session_is_sound_and_reads_back(self):
        path = trilat.write_session(self.folder / "own.h5", {"k1": self.sensor(), "k2": self.sensor(3)}, note="made up")
        verified = subprocess.run([program_path(), "verify", path], capture_output=True, text=True)
        self.assertEqual(verified.returncode, 0, verified.stderr)
        with trilat.session(path) as session:
            self.assertEqual((session.note, session.sensors), ("made up", ("k1", "k2")))
            np.testing.assert_array_equal(session["k1"].bodies().position_m, self.sensor().position_m)
            self.assertAlmostEqual(float(session["k1"].depth(4)[0, 0]), 1.004, 6)
            with self.assertRaisesRegex(IndexError, "5 depth images, not number 5"):
                session["k1"].depth(5)
        told = json.loads(call("info", "--json", path))["sensors"][1]
        self.assertEqual((told["body_frames"], told["bodies"], told["depth_frames"]), (3, 3, 3))

    def test_what_cannot_be_a_session_is_refused_and_leaves_nothing(self):
        def with_(**changed):
            sensor = self.sensor()
            for key, value in changed.items():
                setattr(sensor, key, value)
            return {"k1": sensor}

        nan = self.sensor().position_m.copy()
        nan[2, 3] = np.nan
        for sensors, words in (({}, "1 to 64 sensors"), ({"a/b": self.sensor()}, 'no "/"'),
                               (with_(device_ticks=[0, 5, 5, 9, 10]), "do not rise after frame 1"),
                               (with_(frame=[0, 1, 2, 3, 5]), "rise from 0 to at most 4"),
                               (with_(device_ticks=np.arange(5) * 33), "303030 frames .* of 100 ns, .*; with tick_ns=1000000 it has 30.3"),
                               (with_(device_ticks=np.arange(5) * 33_333_333), "0.3 frames .*; with tick_ns=1 it has 30"),
                               (with_(device_ticks=np.arange(5) * 33_333, tick_ns=1_000_000), "with tick_ns=1000 it has 30"),
                               (with_(position_m=np.zeros((5, 20, 3))), r"position_m has the shape \(5, 20, 3\); \(5, 25, 3\)"),
                               (with_(position_m=nan), "call it not tracked"),
                               (with_(tracking_state=np.full((5, 25), 3)), "goes from 0 to 2"),
                               (with_(tracking_state=np.full((5, 25), True)), "goes from 0 to 2: not tracked, inferred, tracked"),
                               (with_(tracking_state=np.full((5, 25), 0.9)), "tracking_state has 0.9; whole numbers from 0 to 255 are stored"),
                               (with_(tracking_state=np.full((5, 25), -1)), "tracking_state has -1; whole numbers"),
                               (with_(hand_state=np.full((5, 2), 256)), "hand_state has 256; whole numbers from 0 to 255"),
                               (with_(device_ticks=np.arange(5) / 30), r"rise by 0.03333, as seconds do; write np.rint\(seconds \* 1e9 / tick_ns\)"),
                               (with_(device_ticks=(1.7e9 + np.arange(5) / 30) * 1e7), "54 years from 0, as since 1970; take the first of all sensors"),
                               (with_(device_ticks=(6.4e8 + np.arange(5) / 30) * 1e7), "20 years from 0"),
                               (with_(depth=[(0, 0, 0, np.zeros((10, 10)))]), "depth frame 0 has the shape")):
            with self.assertRaisesRegex(trilat.InputError, words):
                trilat.write_session(self.folder / "refused.h5", sensors)
            self.assertEqual(list(self.folder.glob("refused*")), [])
        path = self.folder / "kept.h5"
        trilat.write_session(path, with_(device_ticks=np.arange(5) * 333_333.3, tracking_state=np.full((5, 25), 2.0), arrival_ns=np.arange(5) * 33_333_330.4))
        with h5py.File(path) as file:
            np.testing.assert_array_equal(file["sensors/k1/body_frames/device_ticks"][:], [0, 333_333, 666_667, 1_000_000, 1_333_333])
        exact = 2**58 + 1 + np.arange(5) * 33_333_331  # beyond what a float counts by ones
        trilat.write_session(path, with_(device_ticks=exact, arrival_ns=exact, tick_ns=1), force=True)
        with h5py.File(path) as file:
            for column in ("device_ticks", "arrival_ns"):
                np.testing.assert_array_equal(file[f"sensors/k1/body_frames/{column}"][:], exact)
        with self.assertRaisesRegex(trilat.InputError, "is there already"):
            trilat.write_session(path, {"k1": self.sensor()})

    def test_joints_out_of_reach_are_not_tracked_and_counted(self):
        position_m = np.zeros((2, 25, 3))
        position_m[0, :, 2] = 2.0
        position_m[0, :5, 2] = [0.39, 0.4, 10.0, 10.01, np.nan]
        state, beyond = trilat.skeleton.states_within_reach(position_m, np.array([[2] * 25, [0] * 25]))
        self.assertEqual(state[0].tolist(), [0, 2, 2, 0, 0] + [2] * 20)
        self.assertEqual((state[1].tolist(), beyond), ([0] * 25, 3))

    def test_ticks_and_arrivals_in_another_unit_are_an_error_of_verify_and_run(self):
        def changed(tick_ns=100, divide_arrivals=1):
            camp = self.folder / f"ticks{tick_ns}-{divide_arrivals}"
            shutil.copytree(self.folder / "camp", camp)
            with h5py.File(camp / "p01-walking/session.h5", "r+") as file:
                file["sensors/k2"].attrs["tick_ns"] = np.int64(tick_ns)
                arrivals = file["sensors/k2/body_frames/arrival_ns"]
                arrivals[:] = arrivals[:] // divide_arrivals
            return camp

        both = "; with ticks of 100 ns both agree: write the session again with that tick_ns"
        for camp, words in ((changed(1_000_000), r"0.003 frames a second by device ticks of 1000000 ns, and 30.* by their arrivals" + both),
                            (changed(1000), r"3 frames a second by device ticks of 1000 ns" + ".*" + both),
                            (changed(1), r"3000.* frames a second by device ticks of 1 ns" + ".*" + both),
                            (changed(1_000_000, 10**13), "ticks of 1000000 ns, where a Kinect makes 30; with ticks of 100 ns it has 30"),
                            (changed(100, 1_000), r"30.* by arrival_ns, and 30.* by device ticks; arrivals in microseconds would agree"),
                            (changed(100, 1_000_000), r"arrivals in milliseconds would agree: write them in nanoseconds")):
            verified = subprocess.run([program_path(), "verify", camp / "p01-walking/session.h5"], capture_output=True, text=True)
            self.assertEqual(verified.returncode, 1, verified.stderr)
            self.assertRegex(verified.stdout + verified.stderr, "k2: .*" + words)
            ran = subprocess.run([program_path(), "run", self.folder / "study.json", "--campaign", camp, "-o", camp.with_suffix(".results")],
                                 capture_output=True, text=True)
            self.assertNotEqual(ran.returncode, 0)
            self.assertRegex(re.sub(r"\s+", " ", ran.stdout + ran.stderr), "k2: .*" + words)

    def test_newer_and_other_files_are_refused(self):
        newer = self.folder / "newer"
        shutil.copytree(self.results.folder, newer)
        summary = json.loads((newer / "summary.json").read_text())
        (newer / "summary.json").write_text(json.dumps({**summary, "version": 99}))
        with self.assertRaisesRegex(trilat.InputError, "has version 99; this module reads up to 12"):
            trilat.results(newer)
        (newer / "summary.json").write_text(json.dumps(summary))
        for samples in newer.glob("items/*/take.h5"):
            with h5py.File(samples, "r+") as file:
                file.attrs["version"] = 99
        with self.assertRaisesRegex(trilat.InputError, "take.h5: has version 99"):
            trilat.results(newer)
        with self.assertRaisesRegex(trilat.InputError, "a folder that `trilat run` wrote"):
            trilat.results(self.folder / "camp")
        with self.assertRaisesRegex(trilat.InputError, '"trilat.take"; "trilat.session" is expected'):
            trilat.session(next(self.results.folder.glob("items/*/take.h5")))
        cut = self.folder / "cut.h5"
        cut.write_bytes((self.folder / "camp/p01-walking/session.h5").read_bytes()[:5000])
        with self.assertRaisesRegex(trilat.InputError, "cut short"):
            trilat.session(cut)


@unittest.skipIf(missing("pandas", "matplotlib"), "pandas or matplotlib is not installed (Debian: python3-pandas python3-matplotlib)")
class Frames(Opened):
    def test_samples_become_a_csv_of_all_rows(self):
        self.results.samples().to_csv(self.folder / "samples.csv", index=False)
        columns = self.results.columns()
        with open(self.folder / "samples.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([row["method"] for row in rows], list(columns["method"]))
        for axis in "xyz":
            for kind in ("truth", "estimate"):
                written = [float(row[f"{kind}_{axis}_m"] or "nan") for row in rows]
                np.testing.assert_array_equal(written, columns[f"{kind}_{axis}_m"])

    def test_tables_are_those_of_the_report(self):
        import pandas
        call("report", self.folder / "results", "-o", self.folder / "report")
        tables = self.results.tables()
        self.assertIn("errors-walking", tables)
        self.assertIn("average_mae_from_cm", tables["errors-walking"])
        self.assertIn("simulated", tables["errors-walking"].attrs["title"])
        for name, table in tables.items():
            shown = pandas.read_csv(self.folder / f"report/tables/results/{name}.csv", dtype=str, keep_default_na=False)
            self.assertEqual(list(table.columns), list(shown.columns), name)
            for key in table:
                if table[key].dtype.kind in "if":
                    wanted = [float(text or "nan") for text in shown[key]]
                    np.testing.assert_allclose(table[key], wanted, rtol=1e-15, err_msg=f"{name} {key}")
                else:
                    self.assertEqual(list(table[key]), list(shown[key]), f"{name} {key}")
        with self.assertRaisesRegex(trilat.InputError, "tables.json"):
            trilat.tables(self.folder)

    def test_sums_of_the_table_of_errors_are_the_numbers_of_the_tables(self):
        errors = self.results.errors()
        rows = errors[(errors.method == "mean") & (errors.alignment == "none") & (errors.subset == "all") & (errors.measure == "distance")
                      & errors.quantity.isin(["wrist_left", "wrist_right"])]
        (mean,) = self.errors_of_the_wrists()
        self.assertAlmostEqual(rows["sum"].sum() / rows.n.sum(), mean["value"], 12)
        self.assertEqual(rows.n.sum(), mean["n"])
        (jerk,) = trilat.numbers(self.results.folder, measure="jerk", statistic="mean_of_truth")
        rows = errors[(errors.method == "truth") & (errors.measure == "jerk")]
        self.assertEqual((set(rows.quantity), set(rows.alignment)), ({"body"}, {""}))
        self.assertAlmostEqual(rows["sum"].sum() / rows.n.sum(), jerk["value"], 9)

    def test_tables_and_timelines(self):
        samples = self.results.samples("p01-walking")
        self.assertEqual(set(samples["take"]), {"p01-walking"})
        table = self.results.table()
        self.assertEqual(list(table.index), ["nonlinear", "mean"])
        self.assertEqual(table.loc["mean", "wrist"], self.errors_of_the_wrists()[0]["value"])
        self.assertLess(self.results.table("median").loc["mean", "wrist"], self.results.table("p95").loc["mean", "wrist"])
        self.assertEqual(len(self.results.numbers(take="p01-walking", measure="distance", method="mean")), len(self.results.joints))
        timeline = self.results.timeline("p01-walking", "wrist_left")
        self.assertEqual(list(timeline.columns), ["nonlinear", "mean"])
        self.assertGreater(len(timeline), 80)
        for wrong, words in ((lambda: self.results.table(alignment="rigid"), 'no alignment "rigid"; it has none, mean'),
                             (lambda: self.results.timeline("p01-walking", "tail"), 'no joint "tail"; it has head'),
                             (lambda: self.results.timeline("p01-walking", "head", "k9"), 'no track "k9"; it has mocap'),
                             (lambda: self.results.samples("p09"), 'no take "p09"; it has p01-walking'),
                             (lambda: self.results.numbers(joint="head"), 'no column "joint"; it has condition'),
                             (lambda: self.results.table("mode"), "has no mode of distance")):
            with self.assertRaisesRegex(trilat.InputError, words):
                wrong()

    def test_numbers_that_are_cut_are_refused_and_not_read_as_others(self):
        folder = self.folder / "cut numbers"
        folder.mkdir()
        shutil.copy(self.results.folder / "summary.json", folder)
        whole = (self.results.folder / "numbers.csv").read_text(encoding="utf-8")
        header, row = whole.splitlines()[:2]
        for text, words in ((whole[:-1], "a row is cut"),
                            (whole.replace(row, row.rpartition(",")[0], 1), "a row is cut"),
                            (whole.replace(row + "\n", "", 1), " were written"),
                            (whole.replace(row, row + ",", 1), "a row is cut"),
                            (header + "\n", "has 0 numbers, and")):
            (folder / "numbers.csv").write_text(text, encoding="utf-8")
            with self.assertRaisesRegex(trilat.InputError, words):
                trilat.numbers(folder)
        (folder / "numbers.csv").write_text(whole, encoding="utf-8")
        self.assertGreater(len(trilat.numbers(folder)), 100)

    def test_a_missing_package_is_one_line_that_says_what_to_install(self):
        (self.folder / "hidden").mkdir()
        (self.folder / "hidden/h5py.py").write_text("raise ImportError")
        paths = [str(self.folder / "hidden"), str(Path(trilat.__file__).resolve().parents[1])]
        for words, code, traceback in ((["-c", "import trilat"], 1, 1), (["-m", "trilat.convert", "c3d"], 2, 0)):
            done = subprocess.run([sys.executable, *words], capture_output=True, text=True, check=False,
                                  env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)})
            self.assertEqual((done.returncode, done.stderr.count("Traceback")), (code, traceback), done.stderr)
            self.assertTrue(done.stderr.rstrip().endswith("apt install python3-h5py python3-numpy"), done.stderr)

    def test_a_plot_in_three_lines(self):
        import matplotlib
        matplotlib.use("Agg")
        axes = trilat.results(self.results.folder).plot("p01-walking", "wrist_left")
        axes.figure.savefig(self.folder / "plot.png")
        self.assertEqual(axes.get_title(), "p01-walking, wrist_left, simulated")
        self.assertEqual(len(axes.get_lines()), 2)

    def test_the_documents_example_runs(self):
        page = (Path(__file__).resolve().parents[2] / "docs/how-to/python.md").read_text(encoding="utf-8")
        blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
        self.assertEqual(len(blocks), 4)
        shutil.copytree(self.folder, self.folder.with_suffix(".page"), ignore=shutil.ignore_patterns("own.h5"))
        self.addCleanup(shutil.rmtree, self.folder.with_suffix(".page"))
        subprocess.run([sys.executable, "-c", "import matplotlib; matplotlib.use('Agg')\n" + "\n".join(blocks)],
                       cwd=self.folder.with_suffix(".page"), check=True, stdout=subprocess.DEVNULL,
                       env={**os.environ, "PYTHONPATH": str(Path(trilat.__file__).resolve().parents[1])})
        for picture in ("errors.png", "wrist.png"):
            self.assertTrue((self.folder.with_suffix(".page") / picture).exists(), picture)
        call("verify", self.folder.with_suffix(".page") / "own.h5")

    def test_the_notebook_runs(self):
        notebook = Path(__file__).resolve().parents[2] / "docs/tutorials/notebook.ipynb"
        cells = ["".join(cell["source"]) for cell in json.loads(notebook.read_text())["cells"] if cell["cell_type"] == "code"]
        folder = self.folder / "jupyter"
        folder.mkdir()
        subprocess.run([sys.executable, "-c", "import matplotlib; matplotlib.use('Agg')\n" + "\n".join(cells)],
                       cwd=folder, check=True, stdout=subprocess.DEVNULL,
                       env={**os.environ, "PYTHONPATH": str(Path(trilat.__file__).resolve().parents[1])})
        self.assertTrue((folder / "notebook/wrist.png").exists())


if __name__ == "__main__":
    ran = unittest.main(verbosity=2, exit=False).result
    sys.exit(77 if len(ran.skipped) >= max(1, ran.testsRun) else not ran.wasSuccessful())
