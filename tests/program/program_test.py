# SPDX-License-Identifier: MIT
"""The program as a person uses it: what it replaces, what it refuses, and what it leaves behind."""
import json
import math
import os
import re
import shutil
import struct
import subprocess
import tempfile
import time
import unittest
import zlib
from pathlib import Path

from made import PROGRAM, SOURCE, ScratchTest, cells, made, numbers, trilat

STUDY = {"format": "trilat.study", "version": 1, "kind": "accuracy", "name": "lab", "alignments": ["none"],
         "methods": [{"method": "mean"}, {"method": "nonlinear"}]}
SIMULATION = {"format": "trilat.simulation", "version": 1, "name": "walks", "participants": 2,
              "activities": [{"name": "walking", "duration_s": 4}]}
MOTIVE = """Format Version,1.23,Take Name,Take,Take Notes,{notes},Capture Frame Rate,50.000000,Export Frame Rate,50.000000,\
Capture Start Frame,0,Total Frames in Take,{promised},Total Exported Frames,{promised},Rotation Type,Quaternion,Length Units,Meters,\
Coordinate Space,Global

,Type,Marker,Marker,Marker,Marker,Marker,Marker
,Name,a,a,a,b,b,b
,ID,1,1,1,2,2,2
,,Position,Position,Position,Position,Position,Position
Frame,Time (Seconds),X,Y,Z,X,Y,Z
"""


def rows_of_png(picture):
    """The rows of an 8-bit RGB picture without interlacing (PNG, ISO/IEC 15948)."""
    width, data, at = struct.unpack(">I", picture[16:20])[0], b"", 8
    while at < len(picture):
        size, kind = struct.unpack(">I4s", picture[at:at + 8])
        data += picture[at + 8:at + 8 + size] if kind == b"IDAT" else b""
        at += 12 + size
    lines, rows, before = zlib.decompress(data), [], bytearray(3 * width)
    for start in range(0, len(lines), 1 + 3 * width):
        how, row = lines[start], bytearray(lines[start + 1:start + 1 + 3 * width])
        for i in range(3 * width) if how else ():
            left, up, corner = (row[i - 3], before[i], before[i - 3]) if i >= 3 else (0, before[i], 0)
            paeth = min((left, up, corner), key=lambda value: abs(left + up - corner - value))
            row[i] = (row[i] + (0, left, up, (left + up) // 2, paeth)[how]) & 255
        rows.append(bytes(row))
        before = row
    return rows


class ProgramTest(ScratchTest):
    @classmethod
    def setUpClass(cls):
        holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(holder.cleanup)
        cls.made = Path(holder.name)
        (cls.made / "simulation.json").write_text(json.dumps(SIMULATION))
        trilat("simulate", cls.made / "simulation.json", "-o", cls.made / "campaign")

    def campaign(self, **changes):
        """A copy of the campaign whose takes are changed."""
        folder = self.folder / "campaign"
        shutil.copytree(self.made / "campaign", folder)
        document = json.loads((folder / "campaign.json").read_text())
        document.update({key: value for key, value in changes.items() if key != "takes"})
        for take in document["takes"]:
            take.update(changes.get("takes", {}))
        (folder / "campaign.json").write_text(json.dumps(document))
        return folder

    def ran(self, study=STUDY, campaign=None, **options):
        return trilat("run", self.written("study.json", study), "--campaign", campaign or self.made / "campaign",
                      "-o", self.folder / "results", *(["--force"] if options.pop("force", False) else []), **options)

    def test_every_step_of_a_walk_prints_one_json_document(self):
        def document(*words, code=0):
            done = subprocess.run([PROGRAM, *map(str, words), "--json"], capture_output=True, text=True, timeout=300, check=False)
            self.assertEqual(done.returncode, code, done.stderr)
            return json.loads(done.stdout)

        take, results = self.made / "campaign/p01-walking", self.folder / "results"
        self.assertEqual(len(document("simulate", self.made / "simulation.json", "-o", self.folder / "campaign")["takes"]), 2)
        session = document("info", take / "session.h5")
        self.assertEqual((len(session["sensors"]), session["complete"]), (4, True))
        self.assertAlmostEqual(session["sensors"][0]["rate_hz"], 30, delta=1.5)
        self.assertLess(session["sensors"][0]["clock"]["offset_bound_s"], 0.002)
        self.assertTrue(document("verify", take / "session.h5")["sound"])
        mocap = document("info", take / "mocap.csv")
        self.assertEqual((len(mocap["assets"]), mocap["frames"], mocap["rate_hz"]), (28, 401, 100))
        study = self.written("study.json", {**STUDY, "alignments": ["none", "mean"]})
        self.assertEqual(len(document("run", study, "--campaign", self.made / "campaign", "--dry-run")["takes"]), 2)
        self.assertFalse(results.exists())
        ran = document("run", study, "--campaign", self.made / "campaign", "-o", results, "--cross-check")
        self.assertEqual((ran["takes_failed"], ran["cross_check_passed"]), (0, True))
        self.assertEqual({row["alignment"] for row in ran["errors"]}, {"none"})  # the first
        for file in document("report", results, "-o", self.folder / "report")["files"]:
            self.assertTrue(Path(file).exists(), file)
        (self.folder / "campaign/p02-walking/session.h5").write_bytes((take / "session.h5").read_bytes()[:3000])
        worse = self.folder / "worse"
        self.assertEqual(document("run", study, "--campaign", self.folder / "campaign", "-o", worse, code=1)["takes_failed"], 1)
        self.assertIn("QUIET", trilat("gate", results, "--baseline", results))
        self.assertIn("p02-walking", trilat("gate", worse, "--baseline", results, code=1))

    def test_nights_of_equal_numbers_are_quiet_and_a_method_3_percent_worse_is_the_first_line(self):
        study = self.written("lab.json", STUDY)
        worse = self.folder / "worse"
        worse.write_text(f"""#!/usr/bin/env python3
import csv, subprocess, sys
code = subprocess.call([{str(PROGRAM)!r}, *sys.argv[1:]])
if sys.argv[1] == "run":
    file = sys.argv[sys.argv.index("-o") + 1] + "/numbers.csv"
    head, *rows = csv.reader(open(file, newline=""))
    for row in rows:
        cell = dict(zip(head, row))
        if (cell["method"], cell["measure"], cell["statistic"]) == ("nonlinear", "distance", "mean"):
            row[head.index("value")] = 1.03 * float(cell["value"])
    csv.writer(open(file, "w", newline=""), lineterminator="\\n").writerows([head, *rows])
sys.exit(code)
""")
        worse.chmod(0o755)

        def night(program):
            done = subprocess.run([SOURCE / "scripts/nightly", f"{study}={self.made / 'campaign'}"], capture_output=True, text=True, timeout=300,
                                  check=False, env={**os.environ, "TRILAT_NIGHTLY_DIR": str(self.folder / "nightly"), "TRILAT_NIGHTLY_PROGRAM": str(program)})
            time.sleep(1)  # names of nights are seconds
            return done.returncode, done.stdout.splitlines()[0]

        self.assertEqual(night(PROGRAM)[0], 0)
        code, first = night(PROGRAM)
        self.assertEqual((code, first.split(":")[0]), (0, "QUIET"))
        code, first = night(worse)
        self.assertEqual(code, 1)
        self.assertRegex(first, r"^REGRESSION: lab, nonlinear, walking, \w+: larger errors, \+3(\.0)? %")

    def test_depth_walks_to_a_calibration_by_the_wand(self):
        made = self.written("simulation.json", {**SIMULATION, "participants": 1, "seed": 5, "depth": {"takes": False},
                                                "rig": {"heights_m": [0.8, 1.7]}, "wand": {"positions": 8, "hold_s": 0.6, "move_s": 0.4}})
        done = subprocess.run([PROGRAM, "simulate", made, "-o", self.folder / "campaign", "--json"], capture_output=True, text=True, check=True)
        start_ns, wand = json.loads(done.stdout)["wand"]["mocap_start_host_ns"], self.folder / "campaign/wand"
        trilat("calibrate", wand / "session.h5", "-o", self.folder / "c.json", "--mocap", wand / "mocap.csv", "--asset", "wand",
               "--mocap-start-host-ns", start_ns)
        self.check_drawing(wand)
        errors = {}
        for name, more in (("exact", []), ("calibrated", ["--calibration", self.folder / "c.json"])):
            trilat("run", self.written("study.json", STUDY), "--campaign", self.folder / "campaign", "-o", self.folder / name, *more)
            errors[name] = next(c["mae_m"] for c in cells(self.folder / name) if c["method"] == "mean" and c["group"] == "head")
            trilat("report", self.folder / name, "-o", self.folder / f"{name}-report")
            page = (self.folder / f"{name}-report/report.html").read_text()
            self.assertEqual("--calibration c.json" in page, name == "calibrated")
        self.assertAlmostEqual(errors["calibrated"], errors["exact"], delta=0.01)
        self.assertNotEqual(errors["calibrated"], errors["exact"])

    def check_drawing(self, wand):
        """The ball is found in a drawn frame as far from the sensor as its marker is."""
        said = trilat("draw", wand / "session.h5", "--sensor", "k1", "--frame", 96, "-o", self.folder / "depth.png",
                      "--calibration", self.folder / "campaign/calibration.json")
        sensor = json.loads((self.folder / "campaign/calibration.json").read_text())["sensors"][0]["position_m"]
        at_m = [float(x) for x in (wand / "mocap.csv").read_text().splitlines()[8 + 320].split(",")[-3:]]  # 96 / 30 s at 100 Hz
        self.assertAlmostEqual(float(re.search(r"k1, depth frame 96, simulated: bodies: 1, ball at (\S+) m", said)[1]),
                               math.dist(sensor, at_m), delta=0.025)  # a unit's depth is up to 2.4 cm off
        picture = (self.folder / "depth.png").read_bytes()
        self.assertEqual(struct.unpack(">8s8xII", picture[:24]), (b"\x89PNG\r\n\x1a\n", 1024, 848))
        radius_px = 2 * 365 * 0.075 / math.dist(sensor, at_m)
        magenta = sum(row[i:i + 3] == b"\xff\x00\xff" for row in rows_of_png(picture) for i in range(0, len(row), 3))
        self.assertAlmostEqual(magenta / (math.pi * radius_px**2), 1.0, delta=0.4)  # the ball's pixels are tinted

    def test_a_reference_that_answers_nothing_is_named_and_another_is_taken(self):
        three = self.written("simulation.json", {**SIMULATION, "rig": {"heights_m": [0.6, 2.2, 0.9]}})
        trilat("simulate", three, "-o", self.folder / "campaign")
        methods = [{"method": name} for name in ("linear", "nonlinear", "mean")]
        study = self.written("study.json", {**STUDY, "methods": methods})
        words = ["run", study, "--campaign", self.folder / "campaign"]
        self.assertIn("note: linear answers nothing on this rig (rank_deficient): the others are compared with the first that answers",
                      trilat(*words, "--dry-run"))
        self.assertIn('"linear" answers nothing in any take; the others are compared with "nonlinear"', trilat(*words, "-o", self.folder / "one"))
        self.written("study.json", {**STUDY, "methods": methods, "reference": "nonlinear"})
        trilat(*words, "-o", self.folder / "named")
        self.assertEqual(json.loads((self.folder / "one/summary.json").read_text())["reference"], "nonlinear")
        one, named = (numbers(self.folder / name, statistic="difference") for name in ("one", "named"))
        self.assertTrue(one)
        self.assertEqual(list(map(str, one)), list(map(str, named)))

    def test_a_comparison_with_simulated_motion_capture_says_so(self):
        take = self.made / "campaign/p01-walking"
        said = trilat("compare", take / "mocap.csv", take / "truth.csv", "--mapping", take / "mapping.json", "-o", self.folder / "compared")
        self.assertIn("simulated sensors", said)
        self.assertIn("Simulated data", trilat("report", self.folder / "compared", "-o", self.folder / "report")
                      + (self.folder / "report/report.md").read_text())

    def test_what_is_mistyped_is_named_with_what_was_meant(self):
        self.assertIn("--campagin is not an option of run; did you mean --campaign?", trilat("run", "table3", "--campagin", "x", "-o", "r", code=2))
        self.assertIn("--methd is not an option of fuse; did you mean --method?", trilat("fuse", "s.h5", "--calibration", "c", "-o", "x.trc", "--methd", "mean", code=2))
        said = trilat("record", "-o", self.folder / "x.h5", "--duration-s", "1s", code=2)
        self.assertIn('--duration-s: "1s" is not a number', said)
        self.assertNotRegex(said, r"\d{20}")
        self.assertIn("--rate-hz: is 0; it must lie between 0.1 and 1000", trilat("fuse", "s.h5", "--rate-hz", "0", "--calibration", "c", "-o", "x.trc", code=2))

    def test_recordings_in_the_place_of_a_study_or_of_joints_are_named_with_what_takes_them(self):
        campaign = made() / "campaign"
        session = next(campaign.glob("*/session.h5"))
        for given in (campaign, campaign / "campaign.json"):
            self.assertIn(f"is a campaign, and no study; `trilat run table3 --campaign {campaign} -o RESULTS` evaluates it", trilat("run", given, "-o", self.folder / "r", code=2))
        self.assertIn("is a recording, and no study; `trilat init FOLDER` makes", trilat("run", session, "-o", self.folder / "r", code=2))
        (self.folder / "table1").mkdir()  # a campaign that is called as a study is
        shutil.copy(campaign / "campaign.json", self.folder / "table1/campaign.json")
        trilat("run", "table1", "--dry-run", "-o", self.folder / "t", cwd=self.folder)
        truth = session.with_name("truth.csv")
        for words in ((session, truth), (truth, session)):
            self.assertIn("`trilat fuse` writes the joints of a session as TRC or CSV", trilat("compare", *words, "-o", self.folder / "r", code=2))
        # what was refused is in the way of nothing
        trilat("compare", session.with_name("mocap.csv"), truth, "--mapping", session.with_name("mapping.json"), "-o", self.folder / "r")
        self.assertIn("r: holds what `trilat compare` wrote", trilat("compare", truth, truth, "-o", self.folder / "r", code=2))

    def test_a_session_that_was_cut_is_named_so(self):
        session = next((made() / "campaign").glob("*/session.h5"))
        cut = self.folder / "cut.h5"
        cut.write_bytes(session.read_bytes()[:20000])
        for words in (["info", cut], ["verify", cut], ["fuse", cut, "--calibration", made() / "campaign/calibration.json", "-o", self.folder / "x.trc"]):
            self.assertIn("cut.h5: is cut short or damaged: it begins as HDF5 does", trilat(*words, code=2))

    def test_a_figure_of_no_known_style_is_refused_at_its_place(self):
        shutil.copytree(made() / "results", self.folder / "results")
        figures = self.folder / "results/figures.json"
        text = figures.read_text()
        self.assertIn('"style": "dots"', text)
        figures.write_text(text.replace('"style": "dots"', '"style": "dotted"', 1))
        self.assertRegex(trilat("report", self.folder / "results", "-o", self.folder / "report", code=2), r"figures.json /figures/\d+/series/\d+/style: unknown value \"dotted\"; allowed: dots, line")

    def test_names_that_differ_in_case_alone_are_noted(self):
        campaign = self.campaign()
        document = json.loads((campaign / "campaign.json").read_text())
        one, other = document["takes"]
        one["activity"], other["participant"] = "Walking", "P-01"
        document["takes"] += [{**other, "id": f"other{n}", "participant": name, "activity": "rest"} for n, name in enumerate(("1-12", "11-2"))]  # tell apart
        (campaign / "campaign.json").write_text(json.dumps(document))
        said = self.ran(campaign=campaign, study={**STUDY, "conditions": ["walking"]})
        self.assertIn('note: campaign.json: has the participants "P-01" and "p01", which count as 2 persons; if they are one, write one name', said)
        self.assertIn('note: campaign.json: has the activities "Walking" and "walking", which count as 2 conditions; if they are one, write one name', said)
        self.assertEqual(said.count("note: campaign.json"), 2, said)
        self.assertNotIn("campaign.json", self.ran(force=True))

    def test_two_joints_with_the_same_markers_are_refused(self):
        campaign = self.campaign()
        for mapping in campaign.glob("*/mapping.json"):
            document = json.loads(mapping.read_text())
            document["joints"]["wrist_left"] = document["joints"]["elbow_left"]
            mapping.write_text(json.dumps(document))
        self.assertIn("mapping.json /joints/wrist_left: names the same assets as elbow_left: which of both are they?",
                      self.ran(campaign=campaign, code=2))

    def test_a_recording_that_is_there_twice_counts_once(self):
        """The same data under another name would look like another person's, and make intervals of no width."""
        self.ran()
        once = json.loads((self.folder / "results/summary.json").read_text())
        numbers_once = (self.folder / "results/numbers.csv").read_text()
        campaign = self.campaign()
        shutil.copy(campaign / "p01-walking/session.h5", campaign / "copy.h5")
        document = json.loads((campaign / "campaign.json").read_text())
        first = next(take for take in document["takes"] if take["id"] == "p01-walking")
        document["takes"].append({**first, "id": "p09-walking", "participant": "p09", "session": "copy.h5"})
        (campaign / "campaign.json").write_text(json.dumps(document))
        for _ in range(2):  # computed, and found again
            self.assertIn("failed: take p09-walking: copy.h5: is the recording of take p01-walking again, with the same motion capture; it counts once",
                          self.ran(campaign=campaign, code=1))
        twice = json.loads((self.folder / "results/summary.json").read_text())
        self.assertEqual((twice["takes"], twice["takes_failed"]), (once["takes"] + 1, 1))
        self.assertEqual((twice["participants"], twice["best"]), (once["participants"], once["best"]))
        self.assertEqual((self.folder / "results/numbers.csv").read_text(), numbers_once)

    def test_a_demo_makes_a_page_once_and_again(self):
        for _ in range(2):
            self.assertIn("6 of 6 takes, 6 participants, simulated sensors", trilat("demo", "-o", self.folder / "demo"))
        self.assertTrue((self.folder / "demo/report/report.html").exists())

    def test_a_recording_walks_to_a_calibration_and_to_a_table(self):
        said = trilat("record", "--source", "synthetic:4,depth=no,duration=6", "--truth", self.folder / "truth", "-o", self.folder / "s.h5")
        self.assertIn(f"s.h5: 6.0 s, {1e-6 * (self.folder / 's.h5').stat().st_size:.1f} MB", said)
        trilat("calibrate", self.folder / "s.h5", "--method", "bodies", "-o", self.folder / "calibration.json")
        study = self.written("study.json", {**STUDY, "alignments": ["rigid"]})
        said = trilat("run", study, "--campaign", self.folder / "truth", "--calibration", self.folder / "calibration.json",
                      "-o", self.folder / "results")
        self.assertIn("average", said)
        average = {cell["method"]: cell for cell in cells(self.folder / "results") if cell["group"] == "average"}
        self.assertGreater(average["mean"]["answered"], 1000)
        self.assertLess(average["mean"]["mae_m"], 0.12)
        self.assertLess(average["nonlinear"]["mae_m"], 0.25)

    def test_results_of_another_study_or_campaign_are_not_replaced(self):
        self.ran()
        before = (self.folder / "results/summary.json").read_bytes()
        said = self.ran({**STUDY, "name": "other"}, code=2)
        self.assertIn('results: holds what `trilat run` wrote of "lab" on campaign "walks"', said)
        self.assertIn("--force", said)
        self.assertIn('campaign "walks"', self.ran(campaign=self.campaign(name="another"), code=2))
        self.assertEqual((self.folder / "results/summary.json").read_bytes(), before)
        self.ran({**STUDY, "sensor_gap_s": 0.2})  # changed settings go on in place
        self.ran({**STUDY, "name": "other"}, force=True)

    def test_campaigns_reports_and_calibrations_of_something_else_are_not_replaced(self):
        other = self.written("simulation.json", {**SIMULATION, "name": "runs", "participants": 1})
        trilat("simulate", other, "-o", self.folder / "sim")
        self.assertIn('sim: holds what `trilat simulate` wrote of "runs"', trilat("simulate", self.made / "simulation.json", "-o", self.folder / "sim", code=2))
        trilat("simulate", other, "-o", self.folder / "sim")
        self.ran()
        trilat("report", self.folder / "results", "-o", self.folder / "report")
        trilat("report", self.folder / "results", "-o", self.folder / "report")
        self.ran({**STUDY, "name": "other"}, force=True)
        self.assertIn('report: holds what `trilat report` wrote of "lab"', trilat("report", self.folder / "results", "-o", self.folder / "report", code=2))
        first, second = (self.made / f"campaign/{take}-walking/session.h5" for take in ("p01", "p02"))
        calibration = self.folder / "calibration.json"
        trilat("calibrate", first, "--method", "bodies", "-o", calibration)
        self.assertIn("calibration.json: exists", trilat("calibrate", second, "--method", "bodies", "-o", calibration, code=2))

    def test_a_misspelled_joint_is_named_before_anything_is_computed(self):
        mapping = json.loads((self.made / "campaign/p01-walking/mapping.json").read_text())
        mapping["joints"]["left_wrist"] = mapping["joints"].pop("wrist_left")
        folder = self.campaign(takes={"mapping": "mapping.json"})
        (folder / "mapping.json").write_text(json.dumps(mapping))
        said = self.ran(campaign=folder, code=2)
        self.assertIn('mapping.json /joints/left_wrist: is not a joint; did you mean "wrist_left"?', said)
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), ["campaign", "study.json"])

    def test_up_axis_that_is_stated_later_makes_new_results(self):
        folder = self.campaign(takes={"up_axis": "y"})
        self.ran(campaign=folder)
        document = json.loads((folder / "campaign.json").read_text())
        for take in document["takes"]:
            take["up_axis"] = "z"
        (folder / "campaign.json").write_text(json.dumps(document))
        self.assertNotIn("nothing changed", self.ran(campaign=folder))
        self.assertIn("nothing changed", self.ran(campaign=folder))

    def test_an_axis_that_is_guessed_is_refused_with_what_to_write(self):
        said = self.ran(campaign=self.campaign(takes={"up_axis": "auto"}), code=2)
        self.assertIn('/takes/0/up_axis: "auto" was removed; leave the key out for y, or state "z"', said)

    def test_a_simulation_states_the_up_axis(self):
        takes = json.loads((self.made / "campaign/campaign.json").read_text())["takes"]
        self.assertEqual({take["up_axis"] for take in takes}, {"y"})

    def test_a_cross_check_that_compares_nothing_fails_and_each_method_is_compared(self):
        study = {**STUDY, "methods": [{"method": "nonlinear"}, {"method": "newton"}]}
        said = trilat("run", self.written("study.json", study), "--campaign", self.made / "campaign", "-o",
                      self.folder / "results", "--cross-check")
        for method in ("nonlinear", "newton"):
            self.assertRegex(said, rf'cross-check of "{method}" with Ceres: [1-9]\d* samples.*agrees')
        study["sensors"] = ["k1", "k2"]  # two spheres meet in a circle
        said = trilat("run", self.written("study.json", study), "--campaign", self.made / "campaign", "-o",
                      self.folder / "two", "--cross-check", code=1)
        self.assertIn("NOTHING COMPARED", said)

    def own_folder(self, *names):
        """Recordings under these names with their motion capture beside them, as somebody has them."""
        folder = self.folder / "own"
        for k, name in enumerate(names):
            take = self.made / f"campaign/p0{k + 1}-walking"
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(take / "session.h5", folder / f"{name}.h5")
            shutil.copy(take / "mocap.csv", folder / f"{name}.csv")
        shutil.copy(self.made / "campaign/calibration.json", folder)
        return folder

    def test_names_are_whatever_a_file_system_allows(self):
        folder = self.own_folder("Müller, A <b> & \"c\" %_$#\\{}~^\ttab/walk", "Möller, A <b> & \"c\" %_$#\\{}~^\ttab/walk")
        trilat("init", folder)
        takes = json.loads((folder / "campaign.json").read_text())["takes"]
        self.assertEqual(len({take["id"] for take in takes}), 2)
        trilat("run", folder / "study.json", "--campaign", folder, "-o", self.folder / "results")
        trilat("report", self.folder / "results", "-o", self.folder / "report")
        self.assertNotIn("A <b>", (self.folder / "report/report.html").read_text())
        shutil.rmtree(folder)
        folder = self.own_folder("a/walk")
        os.rename(os.fsencode(folder / "a"), os.fsencode(folder) + b"/M\xfcller")
        self.assertIn("is not UTF-8", trilat("init", folder, code=2))

    def test_init_names_a_motion_capture_that_cannot_be_read_and_keeps_nothing(self):
        folder = self.own_folder("p1/walk")
        mocap = folder / "p1/walk.csv"
        text = mocap.read_text()
        mocap.write_text(text.replace("Length Units,Meters", "Length Units,Cubits"))
        self.assertIn('walk.csv:1: "Length Units" is "Cubits"', trilat("init", folder, code=2))
        self.assertEqual(sorted(path.name for path in folder.iterdir()), ["calibration.json", "p1"])

    def test_init_says_what_it_takes_for_persons_and_one_rig_has_one_calibration(self):
        folder = self.own_folder("first", "second")
        said = trilat("init", folder)
        self.assertIn("each is taken for another participant", said)
        (folder / "calibration.json").unlink()
        self.assertIn(f"-o {folder}/calibration.json", trilat("init", folder, "--force", code=2))

    def test_init_and_run_say_the_likely_cause_where_motion_does_not_tell_the_start(self):
        folder = self.own_folder("p1/walk", "p2/walk")
        first, second = folder / "p1/walk.csv", folder / "p2/walk.csv"
        text = first.read_text()
        first.write_text(text.replace("Length Units,Meters", "Length Units,Millimeters"))
        said = trilat("init", folder)
        self.assertIn("metres under Millimeters", said)
        first.write_text(second.read_text())
        second.write_text(text)
        said = trilat("init", folder, "--force", "--start-within-s", "1")
        self.assertIn("The files of two persons may be exchanged", said)

    def test_a_mapping_alone_is_proposed(self):
        said = trilat("init", "--propose-mapping", self.made / "campaign/p01-walking/mocap.csv")
        self.assertIn('"trilat.mapping"', said)
        self.assertIn("joints by their names; look at them", said)
        rows = "".join(f"{i},{0.02 * i:.6f},0.1,1.6,0.2,0.3,0.9,0.2\n" for i in range(30))
        nameless = self.written("nameless.csv", MOTIVE.format(notes="", promised=30) + rows)
        self.assertIn("has no names that tell which joint is which", trilat("init", "--propose-mapping", nameless, code=2))

    def test_exports_that_others_have_changed(self):
        rows = "".join(f"{i},{0.02 * i:.6f},{0.1 * i:.6f},1.6,0.2,{0.1 * i:.6f},0.9,0.2\n" for i in range(30))
        notes = self.written("notes.csv", MOTIVE.format(notes='"first line\n\nsecond line"', promised=30) + rows)
        self.assertIn("30 frames from 0 at 50 Hz", trilat("info", notes))
        notes = self.written("notes.csv", MOTIVE.format(notes="first line\n\nsecond line", promised=30) + rows)
        self.assertIn("30 frames from 0 at 50 Hz", trilat("info", notes))
        cut = self.written("cut.csv", MOTIVE.format(notes="", promised=200) + rows)
        self.assertIn("the header promises 200 frames, the file has 30", trilat("info", cut))
        comma = self.written("comma.csv", MOTIVE.format(notes="", promised=30) + rows.replace(".", ","))
        self.assertIn("decimal comma", trilat("info", comma, code=2))

    def test_same_results_compares_reports_by_value(self):
        def compared(*words):
            ended = subprocess.run([SOURCE / "scripts/same_results", *map(str, words)], capture_output=True, text=True, check=False)
            return ended.returncode, ended.stdout + ended.stderr

        head = "method,condition,mae_m,took_us\n"
        self.written("one/tables/errors.csv", head + "mean,walking,0.021,7\nnonlinear,walking,0.030,9\n")
        self.written("two/tables/errors.csv", head + "nonlinear,walking,0.030,8\nmean,walking,0.021,7\n")
        one, two = self.folder / "one", self.folder / "two"
        self.assertEqual(compared(one, two, "--except", "*:*_us"), (0, "1 tables compared, 0 differences\n"))
        code, said = compared(one, two)
        self.assertEqual(code, 1)
        self.assertIn("tables/errors: row nonlinear | walking, took_us: 9 and 8", said)
        self.written("two/tables/errors.csv", head + "mean,walking,0.022,7\nmedian,walking,0.021,7\n")
        self.written("two/tables/pace.csv", "pace,mae_m\nslow,1\n")
        code, said = compared(one, two)
        self.assertIn("row mean | walking, mae_m: 0.021 and 0.022", said)
        self.assertIn("row nonlinear | walking is in the first report only", said)
        self.assertIn("row median | walking is in the second report only", said)
        self.assertIn("tables/pace: is in the second report only", said)
        self.assertEqual(compared(one, self.folder / "none")[0], 2)

    def test_scripts_print_their_help_and_do_nothing_else(self):
        for script in (SOURCE / "scripts").iterdir():
            if not script.is_file() or not os.access(script, os.X_OK):
                continue
            with self.subTest(script.name):
                ended = subprocess.run([script, "--help"], capture_output=True, text=True, cwd=self.folder, timeout=10, check=False)
                self.assertEqual(ended.returncode, 0, ended.stderr)
                self.assertGreater(len(ended.stdout), 50)
                self.assertEqual(list(self.folder.iterdir()), [])


if __name__ == "__main__":
    unittest.main(verbosity=2)
