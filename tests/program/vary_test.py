# SPDX-License-Identifier: MIT
"""scripts/vary: a small grid and a small sample of a simulation, against the numbers of the runs themselves."""
import json
import subprocess
import sys
import unittest

from made import PROGRAM, SOURCE, ScratchTest, cells, numbers, trilat

try:
    import pandas
    from scipy import stats
except ImportError as missing:
    print(f"skipped: {missing.name} is not installed (Debian: python3-pandas python3-scipy)")
    sys.exit(77)

SIMULATION = {"format": "trilat.simulation", "version": 1, "name": "walk", "participants": 1, "activities": [{"name": "walking", "duration_s": 3}],
              "body_tracker": {}, "rig": {"heights_m": {"sensors": 4, "mean_m": 1.4, "spread_m": 1.6, "order": 0.1}}}
STUDY = {"format": "trilat.study", "version": 1, "kind": "accuracy", "name": "varied", "clock": "stated", "alignments": ["none", "mean"],
         "methods": [{"method": "nonlinear"}, {"method": "mean"}, {"method": "median"}]}
COMPARISONS = [{"name": "nonlinear first", "better": "nonlinear", "than": ["mean", "median"]},
               {"name": "mean close", "better": "mean", "than": ["nonlinear"], "margin_percent": 2}]


class Vary(ScratchTest):
    def vary(self, document, *more, code=0):
        words = [sys.executable, "-B", SOURCE / "scripts/vary", self.written("vary.json", document), "-o", self.folder / "out", "--program", PROGRAM, *more]
        ended = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
        self.assertEqual(ended.returncode, code, ended.stderr)
        return ended.stderr

    def table(self, name):
        return pandas.read_csv(self.folder / "out" / name)

    def grid(self, **more):
        return {"simulation": SIMULATION, "study": STUDY, "comparisons": COMPARISONS,
                "settings": {"/rig/heights_m/sensors": [3, 5], "/body_tracker/ray_ratio": [0.2, 1.0]}, **more}

    def test_a_grid_gives_the_numbers_of_its_runs_and_exact_shares(self):
        self.vary(self.grid())
        points, shares = self.table("points.csv"), self.table("shares.csv")
        self.assertEqual([*zip(points["/rig/heights_m/sensors"], points["/body_tracker/ray_ratio"])][::2], [(3, 0.2), (3, 1.0), (5, 0.2), (5, 1.0)])
        last = {**SIMULATION, "seed": 1003, "rig": {"heights_m": {**SIMULATION["rig"]["heights_m"], "sensors": 5}}, "body_tracker": {"ray_ratio": 1.0}}
        trilat("simulate", self.written("last.json", last), "-o", self.folder / "campaign")
        for reference in ("mean", "median"):
            study = self.written(f"{reference}.json", {**STUDY, "reference": reference})
            trilat("run", study, "--campaign", self.folder / "campaign", "-o", self.folder / reference)
        for row in points[points["point"] == 4].to_dict("records"):
            worst = -100.0
            for reference in ("mean", "median"):
                of = {(d["alignment"], d["method"]): 100 * d["value"]
                      for d in numbers(self.folder / reference, statistic="relative_difference", group="average")}
                worst = max(worst, of[row["alignment"], "nonlinear"])
                cell = next(c for c in cells(self.folder / reference) if (c["group"], c["method"], c["alignment"]) == ("average", "mean", row["alignment"]))
                self.assertAlmostEqual(row["mean (m)"], cell["mae_m"], delta=1e-12)
            self.assertAlmostEqual(row["nonlinear first (%)"], worst, delta=1e-6)
        for row in shares.to_dict("records"):
            percent = points[points["alignment"] == row["alignment"]][f"{row['comparison']} (%)"]
            holds = (percent < 0).sum()
            low = stats.beta.ppf(0.025, holds, 5 - holds) if holds else 0.0
            self.assertAlmostEqual(row["from"], 100 * low, delta=1e-6)
            self.assertEqual((row["compared"], row["share_percent"]), (4, 25 * holds))

    def test_ranges_are_drawn_alike_and_the_same_line_goes_on(self):
        document = self.grid(points=3, settings={"/rig/radius_m": {"low": 1.8, "high": 2.2}, "/rig/heights_m/sensors": {"low": 3, "high": 6, "whole": True},
                                                 "/body_tracker/ray_ratio": {"low": 0.2, "high": 1.0, "logarithmic": True}})
        self.vary(document)
        whole = self.table("points.csv")
        self.assertTrue(whole["/rig/radius_m"].between(1.8, 2.2).all() and whole["/rig/radius_m"].nunique() == 3)
        whole[whole["point"] != 2].to_csv(self.folder / "out/points.csv", index=False)
        self.assertIn("3 of 3 campaigns", self.vary(document))
        pandas.testing.assert_frame_equal(self.table("points.csv"), whole)
        self.assertIn("holds something else", self.vary({**document, "seed": 2}, code=2))

    def test_what_cannot_be_is_named(self):
        for changed, said in (({"settings": {"/rig/radius_m": [2], "/rig/arc_deg": {"low": 90, "high": 180}}}, "all are lists"),
                              ({"comparisons": [{"name": "x", "better": "magic", "than": ["mean"]}]}, 'no method "magic"'),
                              ({"settings": {"/rig/nothing": [1]}}, "/rig/nothing: is an unknown key"), ({"study": {}}, 'has no "study"'),
                              ({"tries": 3}, 'unknown key "tries"')):
            with self.subTest(said):
                self.assertIn(said, self.vary(self.grid(**changed), code=2))


if __name__ == "__main__":
    unittest.main(verbosity=2)
