# SPDX-License-Identifier: MIT
"""python3 -m trilat.convert on recordings of our own making, and on real ones where ../shared is there."""
import contextlib
import io
import json
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
from trilat.convert.__main__ import main
from trilat.convert.campaign import refuse_other_files
from trilat.errors import InputError
from trilat.outputs import folder_aside, refuse_inputs_within
from trilat.program import program_path

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
        rows = "".join(made.labanotation_row(i, 690 + 33 * i) for i in range(5))  # milliseconds
        self.assertRegex(self.refused("labanotation", self.file("a.csv", rows)), "a.csv: has 303030 frames a second.*milliseconds")

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
        with self.assertRaisesRegex(InputError, "notes.txt: is no file of the campaign"):
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
            with mock.patch("trilat.convert.joint_rows.integer", side_effect=KeyError("odd")):
                self.assertEqual(main(["labanotation", str(recording), "-o", str(self.folder / "s.h5")]), 2)
        self.assertRegex(err.getvalue(), "a.csv.*[Nn]ot a directory")
        self.assertRegex(err.getvalue(), "a.csv: cannot be read as labanotation: KeyError")

    def test_umons_taichi_calls_every_joint_tracked(self):
        text = made.umons_row(0, 12) + made.umons_row(1, 45)
        _, sensors, note = self.converted("umons-taichi", self.file("a.txt", text))
        self.assertEqual(sensors["k1/body_frames/device_ticks"][:].tolist(), [120000, 450000])
        self.assertTrue((sensors["k1/bodies/tracking_state"][:] == 2).all())
        self.assertIn("not yet been run on a real file", note)

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
        self.assertEqual(subprocess.run([program_path(), "verify", self.folder / "session.h5"], capture_output=True).returncode, 0)

    def test_ntu_refuses_other_recordings_and_other_files(self):
        name, text = "S001C002P003R002A013.skeleton", "1\n" + made.ntu_frame(made.ntu_body(0))
        one = self.file(name, text)
        self.assertIn("another recording", self.refused("ntu", one, self.file("S001C003P003R002A014.skeleton", text)))
        self.assertIn("camera C002", self.refused("ntu", one, one))
        self.assertIn("no name", self.refused("ntu", one, self.file("b.skeleton", text)))
        for content, message in (("", "no .skeleton"), ("frame,time\n", "skeleton:1"), ("0\n", "no frame"),
                                 ("1\n" + made.ntu_frame(made.ntu_body(0, 1, "1.25")), "averaged")):
            self.assertIn(message, self.refused("ntu", self.file(name, content)))
        report, _, _ = self.converted("ntu", self.file(name, "5\n" + made.ntu_frame(made.ntu_body(0)) + "1\n"), code=1)
        self.assertIn("4 of 5 frames are lost", report["C002"]["first_left_out"])

    def test_node_kinect2_bodies_of_one_time_are_one_frame(self):
        body = made.kinectron_body
        bodies = [body(0, 0), body(0, 0, body_id="7"), body(1, 33), body(1, 33, tracked=False), body(3, 100)]
        report, sensors, note = self.converted("node-kinect2", self.file("a.json", made.kinectron_text(bodies)))
        self.assertEqual(sensors["k1/body_frames/body_count"][:].tolist(), [2, 1, 1])
        self.assertEqual(sensors["k1/body_frames/sequence"][:].tolist(), [0, 1, 3])
        self.assertEqual(sensors["k1/bodies/tracking_id"][0], made.ID)
        self.assertIn("no tracking states", note)
        self.assertEqual(sensors.file.attrs["started_utc"], b"2017-07-14T02:40:00.000Z")

    def test_node_kinect2_sensors_share_a_clock_or_are_refused(self):
        text, body = made.kinectron_text, made.kinectron_body
        first = self.file("a.json", text([body(0, 0), body(1, 33)]))
        later = self.file("b.json", text([body(0, 0, start=1_500_000_000_500)]))
        _, sensors, _ = self.converted("node-kinect2", first, later)
        self.assertEqual(sensors["k2/body_frames/arrival_ns"][0], 500_000_000)
        unknown = self.file("c.json", text([body(0, 0, start=None)]))
        self.assertIn("shares no clock", self.refused("node-kinect2", first, unknown))
        self.assertIn("unknown beginning", self.converted("node-kinect2", unknown)[2])
        self.assertIn("does not begin with", self.refused("node-kinect2", self.file("a.json", "{}")))
        cut = self.file("a.json", text([body(0, 0), body(1, 33)])[:-100])
        self.assertEqual(self.converted("node-kinect2", cut, code=1)[0]["k1"]["torn_rows"], 1)

    def xef(self, archived):
        xef = made.Xef(3, archived)
        for stream, guid in ((1, xef.DEPTH), (2, xef.BODIES), (3, xef.INFRARED)):
            xef.describe(stream, guid)
        if archived:
            xef.index_block(0x6000)
        for i in (0, 1, 3):  # frame 2 was lost
            xef.event(1, i * ENDS, 100 + i, made.depth_mm(i).tobytes())
            xef.event(3, i * ENDS, 100 + i, made.depth_mm(i).tobytes())
            xef.event(2, i * ENDS + 50, 100 + i, made.xef_bodies(i))
            if i == 1:
                xef.index_block(0x7000)
        if not archived:
            xef.footer()
        return xef.data

    def test_xef_plain_and_archived(self):
        for archived in (False, True):
            report, sensors, _ = self.converted("xef", self.file("a.xef", self.xef(archived)))
            k1 = sensors["k1"]
            self.assertEqual(k1["body_frames/sequence"][:].tolist(), [100, 101, 103])
            self.assertEqual(k1["body_frames/device_ticks"][2], 3 * ENDS + 50)
            self.assertEqual(k1["body_frames/floor_plane"][2, 1], 1.0)
            self.assertEqual(k1["bodies/tracking_id"][2], made.ID)
            np.testing.assert_allclose(k1["bodies/position_m"][2, 9], [0.03, 0, 2.09], rtol=1e-6)
            self.assertEqual((k1["bodies/hand_state"][2].tolist(), k1["bodies/hand_confidence"][2].tolist()), ([3, 2], [1, 0]))
            np.testing.assert_array_equal(k1["depth/frame_mm"][2], made.depth_mm(3))
            self.assertEqual([report["k1"][key] for key in ("skipped_events", "skipped_bytes", "torn_rows")], [3, 0, 0])
            with trilat.session(self.folder / "session.h5") as session:
                self.assertAlmostEqual(float(session["k1"].depth(2)[0, 5]), 0.805, 6)
            self.assertEqual(subprocess.run([program_path(), "verify", self.folder / "session.h5"], capture_output=True).returncode, 0)

    def test_xef_steps_over_damage_and_keeps_what_stands_before_a_cut(self):
        xef = made.Xef(1)
        xef.describe(1, xef.DEPTH)
        for i in range(2):
            xef.event(1, i * ENDS, i, made.depth_mm(i).tobytes())
        whole = xef.data
        xef.data += b"\x55" * 1000
        xef.event(1, 2 * ENDS, 2, made.depth_mm(2).tobytes())
        report, _, _ = self.converted("xef", self.file("a.xef", xef.data), code=1)
        self.assertEqual((report["k1"]["depth_frames"], report["k1"]["skipped_bytes"]), (3, 1000))
        report, _, _ = self.converted("xef", self.file("a.xef", whole[:-5000]), code=1)
        self.assertEqual(report["k1"]["depth_frames"], 1)
        archived = made.Xef(1, True)
        archived.describe(1, xef.BODIES)
        archived.event(1, 0, 0, made.xef_bodies(0))
        archived.event(1, ENDS, 1, made.xef_bodies(1, hand_state=4))
        report, _, _ = self.converted("xef", self.file("a.xef", archived.data), code=1)
        self.assertEqual((report["k1"]["body_frames"], report["k1"]["torn_rows"]), (1, 1))

    def test_xef_refuses_other_files_by_their_signature(self):
        raw = made.Xef(1)
        raw.describe(1, raw.RAW)
        raw.event(1, 0, 0, b"raw")
        for content, message in ((b"", "EVENTS1"), (b"x" * 100, "EVENTS1"), (b"PK\3\4" + b"x" * 100, "HoloLens"), (raw.data, ".xrf"),
                                 (made.Xef(1).data, "neither depth nor bodies")):
            self.assertIn(message, self.refused("xef", self.file("a.xef", content)))

    def test_png_needs_unit_and_times(self):
        try:
            from PIL import Image
        except ImportError:
            self.skipTest("Pillow is not installed (Debian: python3-pil)")
        images = self.folder / "depth"
        images.mkdir()
        for i in range(3):
            Image.fromarray(made.depth_mm(i)).save(images / f"d-{0.25 * i + 9.5}.png")
        _, sensors, note = self.converted("png", images, options=["--depth-unit-mm", "1", "--time-from-name"])
        self.assertEqual(sensors["k1/depth/device_ticks"][:].tolist(), [95000000, 97500000, 100000000])
        np.testing.assert_array_equal(sensors["k1/depth/frame_mm"][1], made.depth_mm(1))
        self.assertIn("the last number of each name", note)
        self.assertIn("--depth-unit-mm", self.refused("png", images, options=["--rate-hz", "30"]))
        self.assertIn("give one of them", self.refused("png", images, options=["--depth-unit-mm", "1"]))
        err = io.StringIO()
        with contextlib.redirect_stderr(err):
            self.converted("png", images, options=["--depth-unit-mm", "10", "--rate-hz", "30"])
        self.assertIn("are these depth images", err.getvalue())
        times = self.file("times.txt", "0\n0.1\n")
        self.assertIn("2 times for 3", self.refused("png", images, options=["--depth-unit-mm", "1", "--timestamps", str(times)]))
        Image.new("L", (512, 424)).save(images / "z-99.png")
        self.assertIn("16 bits", self.refused("png", images, options=["--depth-unit-mm", "1", "--rate-hz", "30"]))
        (images / "z-99.png").write_bytes((images / "d-9.5.png").read_bytes()[:300])
        report, _, _ = self.converted("png", images, code=1, options=["--depth-unit-mm", "1", "--rate-hz", "30"])
        self.assertEqual((report["k1"]["depth_frames"], report["k1"]["torn_rows"]), (3, 1))
        for path in images.glob("d-*"):
            path.unlink()
        self.assertIn("holds no frame", self.refused("png", images, options=["--depth-unit-mm", "1", "--rate-hz", "30"]))

    # Rows and steps of two periods were counted with awk.
    def test_real_labanotation_files(self):
        folder = SHARED / "kinect-bodies/labanotation"
        if not folder.exists():
            self.skipTest(f"{folder} is not there")
        for name, frames, gaps in (("joints", 371, 2), ("Ges01_wavehand", 154, 2), ("Ges02_balancinghands", 161, 2),
                                   ("Ges03_drawlines", 213, 5), ("Ges04_comehere", 172, 5), ("Ges05_demopoint", 190, 2),
                                   ("Ges06_chickenwing", 160, 1)):
            report, _, _ = self.converted("labanotation", folder / f"{name}.csv")
            self.assertEqual((report["k1"]["body_frames"], report["k1"]["gap_frames"]), (frames, gaps), name)

    def test_real_kinectron_file(self):
        path = SHARED / "kinect-bodies/kinectron-node-kinect2/recorded_skeleton.json"
        if not path.exists():
            self.skipTest(f"{path} is not there")
        report, sensors, _ = self.converted("node-kinect2", path)
        self.assertEqual((report["k1"]["body_frames"], sensors["k1/bodies/tracking_id"][0]), (286, 72057594037928243))
        self.assertLess(report["k1"]["intrinsics_rms_px"], 0.3)
        self.assertAlmostEqual(sensors["k1"].attrs["fx_px"], 366.0, delta=3.0)

    def test_help_lists_every_format(self):
        ended = subprocess.run([sys.executable, "-m", "trilat.convert", "--help"], capture_output=True, text=True)
        for name in ("kimore", "labanotation", "node-kinect2", "ntu", "png", "umons-taichi", "xef"):
            self.assertIn(f"\n    {name}", ended.stdout)


if __name__ == "__main__":
    unittest.main()
