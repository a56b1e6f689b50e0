# SPDX-License-Identifier: MIT
"""python3 -m trilat.convert on recordings of our own making, and on real ones where ../shared is there."""
import contextlib
import csv
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
from unittest import mock

import h5py
import numpy as np

import made_up_files as made
import trilat
from trilat.convert import azure_kinect
from trilat.convert.__main__ import main
from trilat.convert.campaign import refuse_other_files
from trilat.errors import InputError
from trilat.outputs import folder_aside, refuse_inputs_within
from trilat.program import program_path
from trilat.skeleton import JOINT_NUMBER

SHARED = Path(__file__).resolve().parents[3] / "shared/data"
ENDS = made.PERIOD_TICKS


class ConvertTest(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = Path(holder.name)

    def file(self, name, content):
        path = self.folder / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    def converted(self, kind, *files, code=0, options=()):
        """The report of each sensor and the session's sensors, opened."""
        out, session = io.StringIO(), self.folder / "session.h5"
        with contextlib.redirect_stdout(out):
            ended = main([kind, *map(str, files), "-o", str(session), "--force", "--json", *options])
        self.assertEqual(ended, code, out.getvalue())
        report = json.loads(out.getvalue())
        file = h5py.File(session)
        self.addCleanup(file.close)
        return {s["name"]: s for s in report["sensors"]}, file["sensors"], report["note"]

    def refused(self, kind, *files, options=()):
        """The message; nothing is left behind."""
        err, output = io.StringIO(), self.folder / "refused.h5"
        with contextlib.redirect_stderr(err):
            self.assertEqual(main([kind, *map(str, files), "-o", str(output), *options]), 2)
        self.assertEqual(list(self.folder.glob("refused*")), [])
        return err.getvalue()

    def test_labanotation_gives_positions_states_and_times_as_written(self):
        rows = made.labanotation_row(0, 31867373716) + made.labanotation_row(1, 31867707049, "1")
        report, sensors, note = self.converted("labanotation", self.file("a.csv", rows))
        k1 = sensors["k1"]
        self.assertEqual(k1["body_frames/arrival_ns"][1], 3186770704900)
        np.testing.assert_array_equal(k1["bodies/position_m"][1, 7], np.float32(made.joint_m(1, 7)))
        self.assertEqual(k1["bodies/tracking_state"][:, 7].tolist(), [2, 1])
        self.assertEqual(k1.attrs["source"], b"import labanotation")
        self.assertIn("Intrinsics: those of a typical Kinect v2", note)
        self.assertEqual(report["k1"]["first_left_out"], "")

    def test_lost_frames_are_gaps_and_jitter_is_none(self):
        row = made.labanotation_row
        report, sensors, _ = self.converted("labanotation", self.file("a.csv", row(0, 0) + row(1, 260000) + row(3, 1000000)))
        self.assertEqual(sensors["k1/body_frames/sequence"][:].tolist(), [0, 1, 3])
        self.assertEqual(report["k1"]["gap_frames"], 1)

    def test_torn_repeated_and_backward_rows_are_counted_with_the_first_place(self):
        row = made.labanotation_row
        text = row(0, 1000) + "1,2,3\n" + row(1, 1000) + row(2, 500) + row(3, 1000 + ENDS).replace("\n", "\r\n") + row(4, 2)[:200]
        text += "\n" + row(5, 10**9).replace(",0.", ",0_1.", 1)
        report, sensors, _ = self.converted("labanotation", self.file("a.csv", text), code=1)
        self.assertEqual(len(sensors["k1/body_frames/sequence"]), 2)
        self.assertEqual([report["k1"][key] for key in ("torn_rows", "repeated_times", "backward_times")], [3, 1, 1])
        self.assertIn("a.csv:2 has 3 cells", report["k1"]["first_left_out"])

    def test_what_cannot_be_meant_is_refused_with_its_place(self):
        row = made.labanotation_row
        self.assertRegex(self.refused("labanotation", self.file("a.csv", row(0, 0) + row(1, ENDS, "1.5"))), "a.csv:2.*averaged")
        self.assertRegex(self.refused("labanotation", self.file("a.csv", "0" + ",100,200,2500,2" * 25)), "must be in metres.*a.csv:1 has a joint")
        self.assertIn("holds no frame", self.refused("labanotation", self.file("a.csv", "")))
        self.assertIn("a.csv:1 has 2 cells", self.refused("labanotation", self.file("a.csv", "frame,time\n0,1\n")))
        self.assertIn("cannot be opened", self.refused("labanotation", self.folder / "absent.csv"))
        one, two = self.file("a.csv", row(0, 0)), self.file("b.csv", row(0, 0))
        self.assertIn("b.csv: is a second file", self.refused("labanotation", one, two))
        self.assertIn("--rate-hz", self.refused("labanotation", one, options=["--rate-hz", "30"]))
        err = io.StringIO()
        with contextlib.redirect_stderr(err):
            self.assertEqual(main(["labanotation", str(one), "-o", str(one), "--force"]), 2)
            self.assertEqual(main(["labanotation", str(one), "-o", str(two)]), 2)
        self.assertRegex(err.getvalue(), "also read.*\n.*is there already")
        self.assertEqual(one.read_text(), row(0, 0))

    def test_joints_where_no_kinect_measures_are_not_tracked_and_counted(self):
        cells = made.labanotation_row(0, 0).strip().split(",")
        cells[1 + 4 * 6:4 + 4 * 6] = "0", "0", "0"  # as missing joints are written: at the sensor
        cells[1 + 4 * 7:4 + 4 * 7] = "0", "0", "1e8"
        report, sensors, _ = self.converted("labanotation", self.file("a.csv", ",".join(cells) + "\n"))
        states = sensors["k1/bodies/tracking_state"][0].tolist()
        self.assertEqual((states[5], states[6], states[7]), (2, 0, 0))
        self.assertEqual(report["k1"]["out_of_reach"], 2)

    def test_times_in_another_unit_are_refused(self):
        for per_s, text, remedy in ((1_000, "{:.0f}", "as milliseconds they make 30[.0-9]*: multiply them by 10,000$"),
                                    (1_000_000, "{:.0f}", "as microseconds they make 30: multiply them by 10$"),
                                    (1, "{:.6f}", "as seconds they make 30[.0-9]*: multiply them by 10,000,000$"),
                                    (1_000_000_000, "{:.0f}", "as nanoseconds they make 30[.0-9]*: divide them by 100$"),
                                    (90_000, "{:.0f}", "in another unit")):
            times = [text.format((0.69 + i / 30) * per_s) for i in range(9)]
            rows = "".join(made.labanotation_row(0, time) for i, time in enumerate(times))
            with self.subTest(remedy):
                self.assertRegex(self.refused("labanotation", self.file("a.csv", rows)), f"a.csv: has [0-9.e+]+ frames a second.*{remedy}")
        for times, problem in (([7] * 9, "9 frames, of which 8 repeat a time.*a.csv:2"),
                               (range(2_700_000, 0, -300_000), "9 frames, of which 8 go back in time.*a.csv:2")):
            rows = "".join(made.labanotation_row(0, time) for i, time in enumerate(times))
            self.assertRegex(self.refused("labanotation", self.file("a.csv", rows)), problem)

    def test_persons_on_their_heads_are_refused(self):
        head, ankle = 4 * JOINT_NUMBER["head"] + 2, 4 * JOINT_NUMBER["ankle_left"] + 2  # y in a row that begins with the time

        def rows(frames, head_y, ankle_y):
            text = ""
            for i in range(frames):
                cells = made.labanotation_row(0, i * ENDS).strip().split(",")
                cells[head], cells[ankle] = str(head_y), str(ankle_y)
                text += ",".join(cells) + "\n"
            return self.file("a.csv", text)
        self.assertIn("heads below the feet in 100% of its bodies", self.refused("labanotation", rows(40, -0.6, 0.9)))
        self.converted("labanotation", rows(40, 0.6, -0.9))
        self.converted("labanotation", rows(20, -0.6, 0.9))  # too few to tell a handstand

    def test_nothing_is_deleted_that_the_run_did_not_make(self):
        recording = self.file("a.csv", made.labanotation_row(0, 0))
        partial = self.file("session.h5.partial", "what a killed recording left for `trilat recover`")
        self.converted("labanotation", recording)
        self.assertIn("killed recording", partial.read_text())
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), ["a.csv", "session.h5", "session.h5.partial"])

    def test_a_folder_is_exchanged_as_a_whole_and_with_its_own_files_alone(self):
        old, camp = self.folder / "camp.old", self.folder / "camp"
        for folder in (old, camp):
            folder.mkdir()
        (old / "thesis.txt").write_text("ten years of work")
        (camp / "campaign.json").write_text(json.dumps({"format": "trilat.campaign", "takes": [{"id": "a", "session": "a/session.h5"}]}))
        (camp / "notes.txt").write_text("mine")
        with self.assertRaisesRegex(InputError, "notes.txt: is not a file of the campaign"):
            refuse_other_files(camp)
        (camp / "notes.txt").unlink()
        refuse_other_files(camp)
        with self.assertRaisesRegex(InputError, "an output is never an input"):
            refuse_inputs_within(camp, [camp / "raw"])
        with self.assertRaises(ZeroDivisionError), folder_aside(camp) as aside:
            (aside / "half").write_text("1")
            1 / 0
        self.assertTrue((camp / "campaign.json").exists())
        with folder_aside(camp) as aside:
            (aside / "new").write_text("1")
        self.assertEqual([path.name for path in camp.iterdir()], ["new"])
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), ["camp", "camp.old"])
        self.assertTrue((old / "thesis.txt").exists())

    def test_what_no_check_foresaw_is_exit_code_2_with_the_place(self):
        recording = self.file("a.csv", made.labanotation_row(0, 0))
        err = io.StringIO()
        with contextlib.redirect_stderr(err):
            self.assertEqual(main(["labanotation", str(recording), "-o", str(recording / "below" / "s.h5")]), 2)
            with mock.patch("trilat.convert.labanotation.time_of", side_effect=KeyError("odd")):
                self.assertEqual(main(["labanotation", str(recording), "-o", str(self.folder / "s.h5")]), 2)
        self.assertRegex(err.getvalue(), "a.csv.*[Nn]ot a directory")
        self.assertRegex(err.getvalue(), "a.csv: cannot be read as labanotation: KeyError")

    def test_kimore_reads_three_files_row_by_row(self):
        _, sensors, note = self.converted("kimore", made.kimore_files(self.folder, 3))
        self.assertEqual(sensors["k1/body_frames/device_ticks"][:].tolist(), [1000 + ENDS * i for i in range(3)])
        np.testing.assert_array_equal(sensors["k1/bodies/orientation_xyzw"][1, 3], np.float32([0.1, 0.2, 0.3, 0.9]))
        self.assertIn("x, y, z, w", note)
        self.assertIn("--rate-hz", self.refused("kimore", self.folder / "JointPosition1.csv"))
        _, sensors, _ = self.converted("kimore", self.folder / "JointPosition1.csv", options=["--rate-hz", "30"])
        self.assertEqual(sensors["k1/body_frames/device_ticks"][:].tolist(), [0, 333333, 666667])
        with open(self.folder / "TimeStamp1.csv", "a") as times:
            times.write("9999999\n")
        report, _, _ = self.converted("kimore", self.folder, code=1)
        self.assertIn("one of the files has ended", report["k1"]["first_left_out"])
        self.file("JointPosition2.csv", "")
        self.assertIn("2 files JointPosition", self.refused("kimore", self.folder))

    def test_ntu_gives_exact_ids_turned_quaternions_and_the_camera(self):
        text = "20\n" + "".join(made.ntu_frame(made.ntu_body(i)) for i in range(20))
        report, sensors, _ = self.converted("ntu", self.file("S001C002P003R002A013.skeleton", text))
        c = sensors["C002"]
        self.assertEqual(c["bodies/tracking_id"][5], made.ID)
        np.testing.assert_array_equal(c["bodies/orientation_xyzw"][1, 5], np.float32([0.1, 0.2, 0.3, 0.9]))
        self.assertEqual((c["bodies/hand_state"][0].tolist(), c["bodies/hand_confidence"][0].tolist()), ([3, 2], [1, 0]))
        for key, value in zip(("fx_px", "fy_px", "cx_px", "cy_px"), made.CAMERA, strict=True):
            self.assertAlmostEqual(c.attrs[key], value, 3)
        self.assertLess(report["C002"]["intrinsics_rms_px"], 1e-6)

    def test_ntu_cameras_are_one_session_and_a_torn_frame_is_a_gap(self):
        files = []
        for camera in ("C003", "C001", "C002"):
            frames = [made.ntu_frame(made.ntu_body(i, 1), made.ntu_body(i, 2), made.ntu_body(i, 3)) for i in range(9)]
            frames[4] = made.ntu_frame()
            if camera == "C002":
                frames[7] = frames[7].replace(" 0.3 2\n", "\n", 1)
            files.append(self.file(f"S001{camera}P003R002A013.skeleton", "9\n" + "".join(frames)))
        report, sensors, _ = self.converted("ntu", *files, code=1, options=["--rate-hz", "15"])
        self.assertEqual(sensors["C001/body_frames/arrival_ns"][1], 66666700)
        self.assertEqual(sensors["C001/body_frames/body_count"][:].tolist(), [3, 3, 3, 3, 0, 3, 3, 3, 3])
        self.assertEqual(sensors["C002/body_frames/sequence"][:].tolist(), [0, 1, 2, 3, 4, 5, 6, 8])
        self.assertEqual((report["C002"]["torn_rows"], report["C002"]["gap_frames"]), (1, 1))
        verified = subprocess.run([program_path(), "verify", self.folder / "session.h5"], capture_output=True, text=True)
        self.assertEqual(verified.returncode, 0, verified.stderr)

    def test_ntu_refuses_other_recordings_and_other_files(self):
        name, text = "S001C002P003R002A013.skeleton", "1\n" + made.ntu_frame(made.ntu_body(0))
        one = self.file(name, text)
        self.assertIn("another recording", self.refused("ntu", one, self.file("S001C003P003R002A014.skeleton", text)))
        self.assertIn("camera C002", self.refused("ntu", one, one))
        self.assertIn("no name", self.refused("ntu", one, self.file("b.skeleton", text)))
        for content, message in (("", "not a .skeleton"), ("frame,time\n", "skeleton:1"), ("0\n", "no frame"),
                                 ("1\n" + made.ntu_frame(made.ntu_body(0, 1, "1.25")), "averaged")):
            self.assertIn(message, self.refused("ntu", self.file(name, content)))
        report, _, _ = self.converted("ntu", self.file(name, "5\n" + made.ntu_frame(made.ntu_body(0)) + "1\n"), code=1)
        self.assertIn("4 of 5 frames are lost", report["C002"]["first_left_out"])

    def azure(self, **changes):
        """Two frames of one body whose joint i is at (10 i, 20 i, 2000) mm."""
        names = [*dict.fromkeys(azure_kinect.NAMES), "CLAVICLE_LEFT", "CLAVICLE_RIGHT", "NOSE", "EYE_LEFT", "EAR_LEFT", "EYE_RIGHT", "EAR_RIGHT"]
        body = {"body_id": 7, "joint_positions": [[10 * i, 20 * i, 2000] for i in range(32)],
                "joint_orientations": [[1, 0, 0, 0]] * 32, **changes}
        frames = [{"frame_id": 5 + k, "timestamp_usec": 33333 * k, "num_bodies": 1, "bodies": [body]} for k in range(2)]
        return json.dumps({"joint_names": names[::-1], "frames": frames})

    def test_azure_kinect_is_turned_to_the_axes_of_a_kinect_v2(self):
        _, sensors, note = self.converted("azure-kinect", self.file("a.json", self.azure()))
        k1 = sensors["k1"]
        self.assertEqual(k1["body_frames/device_ticks"][:].tolist(), [0, 333330])
        self.assertEqual(k1["body_frames/sequence"][:].tolist(), [5, 6])
        self.assertEqual(k1["bodies/tracking_id"][0], 7)
        base = 31 - 0  # spine_base stands last among the reversed names
        np.testing.assert_allclose(k1["bodies/position_m"][0, 0], [-0.01 * base, -0.02 * base, 2.0], rtol=1e-6)
        np.testing.assert_allclose(k1["bodies/orientation_xyzw"][0, 0], [0, 0, 1, 0])  # half a turn about z
        self.assertIn("holds no confidences", note)
        levels = [0, 1, 2, 3] * 8
        _, sensors, note = self.converted("azure-kinect", self.file("a.json", self.azure(joint_confidence_levels=levels)))
        self.assertEqual(sensors["k1/bodies/tracking_state"][0, 0], 2)  # of level 3, the last
        self.assertNotIn("confidences", note)
        self.assertIn("/frames/0", self.refused("azure-kinect", self.file("a.json", self.azure(joint_positions=[[1, 2, 3]]))))
        self.assertIn("has no PELVIS", self.refused("azure-kinect", self.file("a.json", self.azure().replace("PELVIS", "PELVES"))))
        self.assertIn("cannot be read as JSON", self.refused("azure-kinect", self.file("a.json", self.azure()[:-9])))

    def test_azure_kinect_in_other_encodings_units_and_clocks(self):
        for encoding in ("utf-8-sig", "utf-16", "utf-16-le", "utf-32"):
            source = self.folder / "a.json"
            source.write_bytes(self.azure().encode(encoding))
            self.assertEqual(self.converted("azure-kinect", source)[1]["k1/bodies/tracking_id"][0], 7)
        since_1970 = json.loads(self.azure())
        for frame in since_1970["frames"]:
            frame["timestamp_usec"] += 1_760_000_000_000_000
        _, sensors, note = self.converted("azure-kinect", self.file("a.json", json.dumps(since_1970)))
        self.assertEqual(sensors["k1/body_frames/device_ticks"][:].tolist(), [0, 333330])
        self.assertIn("count since 1970, and were taken to begin with the first frame", note)
        for unit, factor in (("metres", 1000), ("centimetres", 10)):
            positions = [[10 * i / factor, 20 * i / factor, 2000 / factor] for i in range(32)]
            self.assertIn(f"as {unit} are; this format has millimetres: multiply joint_positions by {factor}",
                          self.refused("azure-kinect", self.file("a.json", self.azure(joint_positions=positions))))

    def test_azure_kinect_as_other_programs_write_it_anew(self):
        def changed(change, **of_body):
            document = json.loads(self.azure(**of_body))
            change(document)
            return self.file("a.json", json.dumps(document))

        def as_floats(document):
            for frame in document["frames"]:
                frame.update(timestamp_usec=float(frame["timestamp_usec"]), frame_id=float(frame["frame_id"]))
                frame["bodies"][0]["body_id"] = 7.0
        _, plain, _ = self.converted("azure-kinect", self.file("a.json", self.azure()))
        wanted = plain["k1/bodies/position_m"][:].tolist()
        for change in (as_floats,
                       lambda document: document.update(joint_names=[name.lower() for name in document["joint_names"]]),
                       lambda document: document.update(joint_names=["K4ABT_JOINT_" + name for name in document["joint_names"]]),
                       lambda document: [frame["bodies"][0].pop("joint_orientations") for frame in document["frames"]]):
            _, sensors, _ = self.converted("azure-kinect", changed(change))
            self.assertEqual(sensors["k1/bodies/position_m"][:].tolist(), wanted)
            self.assertEqual(sensors["k1/body_frames/sequence"][:].tolist(), [5, 6])
            self.assertEqual(sensors["k1/bodies/tracking_id"][0], 7)
        words = ["NONE", "LOW", "MEDIUM", "K4ABT_JOINT_CONFIDENCE_HIGH"] * 8
        _, sensors, _ = self.converted("azure-kinect", changed(lambda document: None, joint_confidence_levels=words))
        _, of_levels, _ = self.converted("azure-kinect", changed(lambda document: None, joint_confidence_levels=[0, 1, 2, 3] * 8))
        self.assertEqual(sensors["k1/bodies/tracking_state"][:].tolist(), of_levels["k1/bodies/tracking_state"][:].tolist())
        for change, problem in ((lambda frame: frame.pop("bodies"), 'has no list of "bodies"'),
                                (lambda frame: frame.pop("timestamp_usec"), 'has no "timestamp_usec"'),
                                (lambda frame: frame.update(timestamp_usec="0:00"), 'has "0:00" for "timestamp_usec", where a number'),
                                (lambda frame: frame.update(frame_id=0.5), 'has 0.5 for "frame_id", where a whole number'),
                                (lambda frame: frame["bodies"][0].pop("body_id"), 'has no "body_id"')):
            def in_both(document, change=change):
                for frame in document["frames"]:
                    change(frame)
            self.assertIn(problem, self.refused("azure-kinect", changed(in_both)))
        for by, remedy in ((1e-3, "as milliseconds they make 30: multiply them by 1,000"), (1e-6, "as seconds they make 30"),
                           (1e3, "as nanoseconds they make 30: divide them by 1,000")):
            document = json.loads(self.azure())
            document["frames"] = [{**document["frames"][0], "frame_id": k, "timestamp_usec": 33333 * k * by} for k in range(9)]
            self.assertIn(remedy, self.refused("azure-kinect", self.file("a.json", json.dumps(document))))

    def c3d(self, made_up, *options, code=0):
        """Converts a made-up C3D; gives what was said, the names, and positions (frames, markers, 3) in metres."""
        source, output = self.file("walk.c3d", made_up.data()), self.folder / "walk.csv"
        said = io.StringIO()
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            self.assertEqual(main(["c3d", str(source), "-o", str(output), "--force", *options]), code, said.getvalue())
        if code:
            return said.getvalue()
        with open(output, newline="") as file:
            rows = list(csv.reader(file))
        numbers = np.array([[float(cell or "nan") for cell in row[2:]] for row in rows[8:]])
        return said.getvalue(), rows[3][2::3], numbers.reshape(len(numbers), -1, 3)

    def test_c3d_of_another_unit_than_it_says_is_told_by_its_size(self):
        def person(per_m, labels=("head", "toe")):  # 1.65 m from head to toe
            return made.C3d(labels=labels, frames=[[0, 1.7 * per_m, 0, 0, 0.1 * per_m, 0.05 * per_m, 0.2 * per_m, 0]] * 3)

        def of_unit(units, per_m):
            found = person(per_m)
            found.parameters["POINT:UNITS"] = [units]
            return found
        self.assertEqual(self.c3d(of_unit("mm", 1000))[0].count("note"), 0)
        self.assertIn("spread over 0.0017 m, taken in millimetres as POINT:UNITS says; in metres over 1.65 m, as those of a person do: state --unit m",
                      self.c3d(of_unit("mm", 1.0), code=2))
        for units, per_m, right in (("mm", 100, "centimetres"), ("cm", 1000, "millimetres"), ("ft", 39.37, "inches")):
            said, _, position_m = self.c3d(of_unit(units, per_m))
            self.assertIn(f"note: the markers spread over {1.65 * per_m * {'mm': 0.001, 'cm': 0.01, 'ft': 0.3048}[units]:.2g} m", said)
            key = {"centimetres": "cm", "millimetres": "mm", "inches": "in"}[right]
            self.assertIn(f"in {right} over 1.65 m, as those of a person do: state --unit {key}", said)
            said, _, position_m = self.c3d(of_unit(units, per_m), "--unit", key)
            self.assertNotIn("note", said)
            np.testing.assert_allclose(position_m[0, 0], [0, 1.7, 0], rtol=1e-4)
        for nothing in (0.0, float("nan")):
            self.assertIn("has no position of any of 2 markers in its 3 frames", self.c3d(made.C3d(frames=[[nothing] * 8] * 3), code=2))

    def test_arena_gives_what_the_reader_of_its_rows_gave(self):
        """arena_files.json: 30 files, and what the program's own reader of such rows (0.4.0) made of them, or said."""
        files = json.loads((Path(__file__).parent / "arena_files.json").read_text())
        self.assertEqual(len(files), 30)
        for wanted in files:
            with self.subTest(wanted["name"]):
                source, output = self.file("arena.csv", wanted["text"]), self.folder / "motive.csv"
                if "refused" in wanted:
                    self.assertIn(wanted["refused"], self.refused("arena", source))
                    continue
                with contextlib.redirect_stdout(io.StringIO()):
                    self.assertEqual(main(["arena", str(source), "-o", str(output), "--force"]), 0)
                rows = list(csv.reader(output.read_text().splitlines()))
                frames = [[float(cell) if cell else None for cell in row] for row in rows[8:]]
                self.assertEqual([round(1e9 * (row[1] - frames[0][1])) for row in frames], [row[0] for row in wanted["frames"]])
                for row, (_, *positions) in zip(frames, wanted["frames"], strict=True):
                    read = [point if None not in point else None for point in (row[n:n + 3] for n in range(2, len(row), 3))]
                    self.assertEqual(read, [list(position) if position else None for position in positions])
                info = json.loads(subprocess.run([program_path(), "info", output, "--json"], capture_output=True, text=True, check=True).stdout)
                self.assertEqual((len(info["assets"]), info["frames"]), (len(wanted["assets"]), len(wanted["frames"])))
                self.assertEqual({asset["name"] for asset in info["assets"]}, {name.split(":", 1)[1].split("#")[0] for name in wanted["assets"]})

    def test_c3d_of_every_processor_as_real_and_as_integer(self):
        for processor in (84, 85, 86):
            for scale in (-1.0, 1.0):
                _, names, position_m = self.c3d(made.C3d(processor, scale))
                self.assertEqual(names, ["a", "b"])
                np.testing.assert_allclose(position_m[:, 0], [[1.5, 0.25, -0.1], [1.501, 0.25, -0.1]], atol=1e-9)
                np.testing.assert_allclose(position_m[0, 1], [1.004, 0.005, 0.006], atol=1e-9)
                self.assertTrue(np.isnan(position_m[1, 1]).all())
        np.testing.assert_allclose(self.c3d(made.C3d(scale=0.5))[2][0, 0], [0.75, 0.125, -0.05], atol=1e-9)
        self.assertTrue(subprocess.run([program_path(), "info", self.folder / "walk.csv"], capture_output=True, text=True).stdout.count("marker "))

    def test_c3d_steps_over_analog_numbers_and_what_is_no_marker(self):
        analog = made.C3d(analog=12, frames=[[1500 + i, 250, -100, 0, 1004, 5, 6, 0] for i in range(100)],
                          **{"ANALOG:USED": 6, "ANALOG:RATE": 200.0})
        self.assertEqual(self.c3d(analog)[2][1, 0, 0], 1.501)
        analog.of_header = {3: 6}  # of the header, as some programs count
        said, _, position_m = self.c3d(analog)
        self.assertEqual(position_m[1, 0, 0], 1.501)
        self.assertIn("states 6 analog numbers a frame (word 3), ANALOG states 12", said)
        points = [1500, 250, -100, 0]
        others = made.C3d(labels=("a", "*1", "LKneeMoment", "a"), frames=[points, points],
                          **{"POINT:MOMENTS": ["LKneeMoment"]})
        others.frames = [points + [9e6] * 4 + [9e6] * 4 + points] * 2
        said, names, _ = self.c3d(others)
        self.assertEqual(names, ["a#1", "a#4"])
        self.assertIn("2 of 4 points are no markers", said)
        self.assertIn("a stands twice: a#1, a#4", said)

    def test_c3d_has_more_labels_and_frames_than_its_first_words_hold(self):
        labels = tuple(f"L{i}" for i in range(300))
        self.assertEqual(self.c3d(made.C3d(labels=labels, frames=[[1.0] * 1200] * 2))[1][299], "L299")
        long = made.C3d(first=65535, last=65535, **{"TRIAL:ACTUAL_START_FIELD": [2, 1], "TRIAL:ACTUAL_END_FIELD": [3, 1]})
        self.assertIn("2 frames from 65538", self.c3d(long)[0])
        clamped = made.C3d(labels=("a",), first=65530, last=65535, frames=[[1, 2, 3, 0]] * 9)
        self.assertIn("9 frames are read", self.c3d(clamped)[0])

    def test_c3d_goes_by_the_axis_that_is_up(self):
        standing = [[0, 0, 1700, 0, 100, 0, 100, 0]] * 2
        for screen, options in ((["+Z"], []), ([""], []), ([""], ["--up-axis", "z"])):
            _, _, position_m = self.c3d(made.C3d(frames=standing, **{"POINT:Y_SCREEN": screen}), *options)
            np.testing.assert_allclose(position_m[0, 0], [0, 1.7, 0], atol=1e-9)
        said = self.c3d(made.C3d(frames=standing, **{"POINT:Y_SCREEN": ["+Y"]}), code=2)
        self.assertIn("which axis is up: POINT:Y_SCREEN is \"+Y\", the markers spread 0.10, 0.00 and 1.60 m", said)
        self.assertIn("--up-axis y or z", self.c3d(made.C3d(**{"POINT:Y_SCREEN": [""]}, frames=[[1000, 2000, 3000, 0, 4000, 5000, 6000, 0]]), code=2))

    def test_c3d_names_what_contradicts_itself(self):
        scale = made.C3d(scale=0.5, **{"POINT:SCALE": 0.2})
        self.assertIn("the scale is 0.5 in the header (block 1, words 7 and 8) and 0.2 in POINT:SCALE (block 2)", self.c3d(scale, code=2))
        used = made.C3d(**{"POINT:USED": 1})
        self.assertIn("2 points by the header (block 1, word 2), 1 by POINT:USED (block 2)", self.c3d(used, code=2))
        self.assertIn("the header states 100 Hz, POINT:RATE 50 Hz", self.c3d(made.C3d(**{"POINT:RATE": 50.0}))[0])
        start = made.C3d(**{"POINT:DATA_START": 4})
        self.assertIn("in block 3 by the header (word 9) and in block 4 by POINT:DATA_START", self.c3d(start, code=2))
        self.assertEqual(self.c3d(made.C3d(**{"POINT:DATA_START": 0}))[2][1, 0, 0], 1.501)
        analog = made.C3d(analog=12, frames=[[1500, 250, -100, 0, 1004, 5, 6, 0]] * 100, **{"ANALOG:USED": 6, "ANALOG:RATE": 300.0})
        analog.of_header = {3: 6}
        self.assertIn("6 analog numbers a frame by the header (block 1, word 3), 18 by ANALOG", self.c3d(analog, code=2))
        self.assertIn("promises 9 frames of 2 points, but has room for 2", self.c3d(made.C3d(last=9), code=2))
        self.assertIn('POINT:UNITS is "V"', self.c3d(made.C3d(units="V"), code=2))
        self.assertEqual(self.c3d(made.C3d(units="mete", frames=[[1, 2, 3, 0, 4, 5, 6, 0]]))[2][0, 0, 2], 3.0)
        self.assertEqual(self.c3d(made.C3d(units="V"), "--unit", "cm", "--up-axis", "y")[2][0, 0, 0], 15.0)
        self.assertIn("frame 1, a is more than 100 m away", self.c3d(made.C3d(units="m"), code=2))
        self.assertIn("analog channels only", self.c3d(made.C3d(labels=(), analog=12, frames=[[]]), code=2))

    def test_c3d_that_is_cut_anywhere_is_refused(self):
        whole = made.C3d().data()
        for size in range(0, len(whole), 7):
            source = self.file("cut.c3d", whole[:size])
            with contextlib.redirect_stderr(io.StringIO()):
                self.assertEqual(main(["c3d", str(source), "-o", str(self.folder / "cut.csv")]), 2, size)
        self.assertFalse((self.folder / "cut.csv").exists())

    def test_real_c3d_and_trc_of_a_recording_agree(self):
        folder = SHARED / "markers-other/opensim-core"
        if not folder.exists():
            self.skipTest(f"{folder} is not there")
        with contextlib.redirect_stdout(io.StringIO()):
            self.assertEqual(main(["c3d", str(folder / "test_walking.c3d"), "-o", str(self.folder / "walk.csv")]), 0)
        with open(self.folder / "walk.csv", newline="") as file:
            converted = np.array([[float(cell or "nan") for cell in row[2:]] for row in list(csv.reader(file))[8:]]).reshape(806, 40, 3)
        rows = [line.split("\t")[2:122] for line in (folder / "test_walking.trc").read_text().splitlines()[5:] if line.strip()]
        written = 1e-3 * np.array(rows, dtype=float).reshape(806, 40, 3)
        seen = np.isfinite(converted).all(axis=2)
        np.testing.assert_array_equal(seen, (written != 0).any(axis=2))
        np.testing.assert_allclose(converted[seen], written[seen][:, [0, 2, 1]] * [1, 1, -1], atol=2e-6)  # z is up in the TRC

    def recipe(self, number):
        """Runs the recipe of docs/how-to/other_formats.md in the folder."""
        page = (Path(__file__).resolve().parents[2] / "docs/how-to/other_formats.md").read_text(encoding="utf-8")
        blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
        self.assertEqual(len(blocks), 2)
        subprocess.run([sys.executable, "-c", blocks[number]], cwd=self.folder, check=True,
                       env={**os.environ, "PYTHONPATH": str(Path(trilat.__file__).resolve().parents[1])})

    def test_the_recipe_for_bodies_of_node_kinect2(self):
        body = made.kinectron_body
        bodies = [body(0, 0), body(1, 33), body(0, 0, body_id="7"), body(2, 66, tracked=False), body(3, 100)]
        self.file("recorded_skeleton.json", json.dumps(bodies))
        self.recipe(0)
        with h5py.File(self.folder / "kinectron.h5") as file:
            k1 = file["sensors/k1"]
            self.assertEqual(k1["body_frames/body_count"][:].tolist(), [2, 1, 1])
            self.assertEqual(k1["body_frames/device_ticks"][:].tolist(), [0, 330000, 1000000])
            self.assertEqual(k1["bodies/tracking_id"][:2].tolist(), [made.ID, 7])
            np.testing.assert_allclose(k1["bodies/position_m"][3, 4], made.joint_m(3, 4), rtol=1e-6)

    def test_the_recipe_for_bodies_of_node_kinect2_takes_a_real_file(self):
        path = SHARED / "kinect-bodies/kinectron-node-kinect2/recorded_skeleton.json"
        if not path.exists():
            self.skipTest(f"{path} is not there")
        shutil.copy(path, self.folder)
        self.recipe(0)
        with trilat.session(self.folder / "kinectron.h5") as session:
            self.assertEqual(len(session["k1"].bodies().position_m), 286)
        self.assertEqual(subprocess.run([program_path(), "verify", self.folder / "kinectron.h5"], capture_output=True).returncode, 0)

    def test_the_recipe_for_depth_images(self):
        try:
            from PIL import Image
        except ImportError:
            self.skipTest("Pillow is not installed (Debian: python3-pil)")
        (self.folder / "depth").mkdir()
        for i in range(3):
            Image.fromarray(made.depth_mm(i)).save(self.folder / f"depth/{i}.png")
        self.recipe(1)
        with trilat.session(self.folder / "depth.h5") as session:
            self.assertAlmostEqual(float(session["k1"].depth(2)[0, 5]), 0.705, 6)

    def test_real_labanotation_files(self):
        folder = SHARED / "kinect-bodies/labanotation"
        if not folder.exists():
            self.skipTest(f"{folder} is not there")
        for name, frames, gaps in (("joints", 371, 2), ("Ges01_wavehand", 154, 2), ("Ges02_balancinghands", 161, 2),
                                   ("Ges03_drawlines", 213, 5), ("Ges04_comehere", 172, 5), ("Ges05_demopoint", 190, 2),
                                   ("Ges06_chickenwing", 160, 1)):
            report, _, _ = self.converted("labanotation", folder / f"{name}.csv")
            self.assertEqual((report["k1"]["body_frames"], report["k1"]["gap_frames"]), (frames, gaps), name)

    def test_what_was_downloaded_in_place_of_a_recording_is_named(self):
        pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:1\n"
        for kind, name in (("ntu", "a.skeleton"), ("c3d", "walk.c3d"), ("azure-kinect", "a.json"), ("labanotation", "a.csv")):
            file = self.file(name, pointer)
            self.assertIn(f"{file}: is a pointer of Git LFS; `git lfs pull`", self.refused(kind, file))
            file.write_text("<!doctype html><html>")
            self.assertIn(f"{file}: is a web page", self.refused(kind, file))
        folder = self.folder / "set"
        (folder / "Kinect/Positions").mkdir(parents=True)
        (folder / "Kinect/Positions/m01_s01_e01_positions.txt").write_bytes(pointer)
        self.assertIn("m01_s01_e01_positions.txt: is a pointer of Git LFS", self.refused("ui-prmd", folder))

    def test_help_lists_every_format(self):
        ended = subprocess.run([sys.executable, "-m", "trilat.convert", "--help"], capture_output=True, text=True)
        for name in ("arena", "azure-kinect", "c3d", "kimore", "labanotation", "ntu"):
            self.assertIn(f"\n    {name}", ended.stdout)


if __name__ == "__main__":
    unittest.main()
