# SPDX-License-Identifier: MIT
"""The main job at its quick scale: it ends well, and its report has what docs/explanation/paper.md says it has.

tests/reference/ holds the numbers of Tables I to IV that it gave at 9d97fd2, but for times: every later version gives them again, or
what moved is listed in tests/reference/moved.md with its reason. TRILAT_UPDATE_REFERENCE=1 writes them anew."""
import csv
import json
import math
import os
import re
import unittest
from pathlib import Path

from made import CELL, SOURCE, cells, numbers, reproduced

REFERENCE = SOURCE / "tests/reference"
INTERPRETATION = ("rig", "joint", "error_model", "threshold_unit", "gradient", "curvature", "stop", "damping", "start")
STATISTICS = ("rms", "median", "p95", "max")


def rows_of_errors(results):
    """The statistics of every cell of an accuracy study."""
    rows = numbers(results, measure="distance")
    value = {(*(row[key] for key in CELL), row["statistic"]): row["value"] for row in rows}
    return [[cell["method"], cell["condition"], cell["group"], cell["alignment"], int(cell["answered"]), cell["mae_m"],
             *(value.get((*(cell[key] for key in CELL), statistic)) for statistic in STATISTICS)]
            for cell in sorted(cells(results), key=lambda c: [c[key] for key in CELL])]


def values_of(results):
    """The value and the count of each number of a study's takes together, by condition, group, method, measure and statistic."""
    return {tuple(row[key] for key in ("condition", "group", "method", "measure", "statistic")): row for row in numbers(results)}


def rows_of_sweep(results):
    """The numbers of every cell, whose setting summary.json has."""
    found, rows = values_of(results), []
    for cell in json.loads((results / "summary.json").read_text())["cells"]:
        def of(measure, statistic, field="value"):
            return found[cell["condition"], cell["group"], cell["method"], measure, statistic][field]
        rows.append(["/".join(cell[key] for key in INTERPRETATION), f"C = {cell['threshold']:g}", f"from {cell['error_low_m']:g} m",
                     int(of("answered", "share", "n")), int(of("distance", "mean", "n")), of("distance", "mean"),
                     sum(of(axis, "mean_abs") for axis in "xyz") / 3, of("distance", "rms"), of("distance", "p95"), of("start", "mean")])
    return rows


def rows_of_clocks(results):
    found = values_of(results)
    def of(method, statistic, field="value"):
        return found["", "", method, "clock_error", statistic][field]
    return [[method, int(of(method, "share_below_2ms", "n")), *(of(method, statistic) for statistic in ("median", "p95", "p99", "max", "share_below_2ms"))]
            for _, _, method, measure, statistic in found if (measure, statistic) == ("clock_error", "median")]


def rows_of_queues(results):
    found = values_of(results)
    return [[method, server, *(int(found[server, "", method, "queue", fate]["n"]) for fate in ("came", "too_early", "too_late", "taken"))]
            for server, _, method, measure, statistic in found if (measure, statistic) == ("queue", "taken")]


def tables_of(out):
    """By name the head and the rows of each table; texts name a row."""
    errors = ["method", "condition", "group", "alignment", "answered", "mae_m", "rmse_m", "median_m", "p95_m", "max_m"]
    return {
        "table1": (["reading", "C", "errors_from_m", "asked", "answered", "mae_m", "axis_mean_mae_m", "rmse_m", "p95_m", "start_mae_m"],
                   rows_of_sweep(out / "table1")),
        "table2": (errors, rows_of_errors(out / "table2")),
        "table3": (errors, rows_of_errors(out / "table3")),
        "table4-clocks": (["method", "asked", "median_s", "p95_s", "p99_s", "max_s", "below_2ms"], rows_of_clocks(out / "clocks")),
        "table4-queues": (["method", "server", "came", "too_early", "too_late", "taken"], rows_of_queues(out / "clocks"))}


def text_of(value):
    return "" if value is None or value != value else f"{value:.9g}" if isinstance(value, float) else str(value)


def alike(one, other):
    try:
        return math.isclose(float(one), float(other), rel_tol=1e-4, abs_tol=1e-9)
    except ValueError:
        return one == other


@unittest.skipIf("TRILAT_WITHOUT_GOLDEN" in os.environ, "golden tables are left out")
class Reproduce(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.out = reproduced()

    def test_everything_that_the_documents_name_is_in_the_report(self):
        made = {str(path.relative_to(root).with_suffix("")) for root in (self.out / "report/tables", self.out / "report/figures")
                for path in root.rglob("*.csv")}
        text = (SOURCE / "docs/explanation/paper.md").read_text().split("## Tables and figures")[1].split("##")[0]
        named = [name for row in text.splitlines() if row.startswith("|") for name in re.findall(r"`([a-z0-9_]+/[^`]+)`", row.split("|")[-2])]
        self.assertGreater(len(named), 12)
        for name in named:
            start = name.removesuffix("…")
            self.assertTrue(any(entry.startswith(start) if name.endswith("…") else entry == start for entry in made), name)
        self.assertFalse([name for name in made if name.endswith("_")], "two tables of a study have one id")

    def test_the_numbers_of_tables_1_to_4_are_those_of_the_reference(self):
        for name, (head, rows) in tables_of(self.out).items():
            now = [[text_of(value) for value in row] for row in rows]
            path = REFERENCE / f"{name}.csv"
            with path.open(newline="") as file:
                kept_head, *kept = csv.reader(file)
            if os.environ.get("TRILAT_UPDATE_REFERENCE") == "1":  # rows that are alike stay as they are
                same = len(kept) == len(now)
                kept = [old if same and all(map(alike, old, new)) else new for old, new in zip(kept if same else now, now)]
                kept_head = head
                with path.open("w", newline="") as file:
                    csv.writer(file, lineterminator="\n").writerows([kept_head, *kept])
            with self.subTest(name):
                self.assertEqual((kept_head, len(kept)), (head, len(now)))
                differ = [(old, new) for old, new in zip(kept, now) if not all(map(alike, old, new))]
                self.assertEqual(differ[:3], [], f"{len(differ)} rows differ")


if __name__ == "__main__":
    unittest.main()
