# SPDX-License-Identifier: MIT
"""What every report holds: golden Markdown, CSV and LaTeX of three tiny results, and what is true of any.

TRILAT_UPDATE_GOLDEN=1 writes tests/golden anew."""
import csv
import html
import json
import os
import re
import shutil
import subprocess
import unittest
from html.parser import HTMLParser
from pathlib import Path

from engine_test import STUDIES, WALK
from made import CELL, SOURCE, ScratchTest, everything_in, made, numbers, trilat

GOLDEN = SOURCE / "tests/golden"
NUMBER = re.compile(r"(?<![A-Za-z0-9_])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
TINY = {
    "accuracy": {**STUDIES["accuracy"], "occluded_apart": True, "alignments": ["mean", "none"],
                 "methods": [{"method": "nonlinear"}, {"method": "linear"}, {"method": "mean"}, {"method": "single", "sensors": ["k1"]},
                             {"method": "nonlinear", "name": "compensated", "occlusion": "printed"}]},
    "threshold_sweep": {**STUDIES["threshold_sweep"], "trials": 500, "time_problems": 0},
    "calibration": STUDIES["calibration"],
}


class Page(HTMLParser):
    """Ids, texts of headings and titles, cells of tables, and what is loaded or linked."""

    def __init__(self, text):
        super().__init__()
        self.ids, self.links, self.cells, self.captions, self.inside = [], [], [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.ids += [found["id"]] if "id" in found else []
        self.links += [found[key] for key in ("href", "src") if found.get(key)]
        self.inside.append(tag)
        if tag in ("td", "caption"):
            (self.cells if tag == "td" else self.captions).append("")

    def handle_endtag(self, tag):
        while self.inside and self.inside.pop() != tag:
            pass

    def handle_data(self, data):
        if "script" in self.inside or "style" in self.inside:
            return
        if "td" in self.inside:
            self.cells[-1] += data
        if "caption" in self.inside:
            self.captions[-1] += data


def alike(one, other):
    """Equal but for the last printed digit, which the processor's arithmetic may move. Up to six decimals are printed as a table says."""
    def close(a, b):
        digits = [len(number.partition(".")[2].partition("e")[0]) for number in (a, b)]
        as_said = digits[0] == digits[1] or max(digits) > 6
        return as_said and abs(float(a) - float(b)) <= max(1.01 * 10.0**-min(digits), 1e-6 * abs(float(a)))

    first, second = NUMBER.findall(one), NUMBER.findall(other)
    return NUMBER.sub("#", one) == NUMBER.sub("#", other) and all(close(a, b) for a, b in zip(first, second, strict=True))


def update(golden, files):
    """Writes the lines that are not alike, and removes files that are no longer there."""
    for path in [path for path in golden.rglob("*") if path.is_file() and path.relative_to(golden) not in files]:
        path.unlink()
    for name, text in files.items():
        before = (golden / name).read_text() if (golden / name).exists() else ""
        lines, others = text.splitlines(), before.splitlines()
        if len(lines) == len(others):
            text = "".join((other if alike(line, other) else line) + "\n" for line, other in zip(lines, others))
        if text != before:
            (golden / name).parent.mkdir(parents=True, exist_ok=True)
            (golden / name).write_text(text)


def without_steps_and_times(text):
    """A CSV without the columns that count steps, which depend on the last bits of the processor's arithmetic, and time."""
    rows = list(csv.reader(text.splitlines()))
    kept = [k for k, name in enumerate(rows[0]) if "iterations" not in name and name != "time_us"]
    return "".join(",".join(row[k] for k in kept) + "\n" for row in rows)


class Report(ScratchTest):
    def of(self, kind, study):
        """Folder of the report of a study."""
        self.written("walk.json", WALK)
        if study.get("campaign") == "bench":
            os.symlink(made() / "bench", self.folder / "bench")
        elif study.get("campaign"):
            trilat("simulate", self.written("two.json", {**WALK, "participants": 2, "seed": 7}), "-o", self.folder / "campaign")
        path = self.written("study.json", {"format": "trilat.study", "version": 1, "kind": kind, "name": "tiny", **study})
        trilat("run", path, "-o", self.folder / kind)
        trilat("report", self.folder / kind, "-o", self.folder / "report", "--time", "2026-01-01")
        return self.folder / "report"

    @unittest.skipIf("TRILAT_WITHOUT_GOLDEN" in os.environ, "golden tables are left out")
    def test_three_tiny_results_give_the_golden_tables(self):
        for kind, study in TINY.items():
            with self.subTest(kind):
                report, golden = self.of(kind, study), GOLDEN / kind
                files = {path.relative_to(report): path.read_text() for path in report.rglob("*") if path.suffix in (".md", ".csv", ".tex")
                         and "figures" not in path.parts and path.name != "sweep.tex" and path.stat().st_size < 60_000}  # it holds times
                for name in [name for name in files if name.suffix == ".csv"]:
                    files[name] = without_steps_and_times(files[name])
                shutil.rmtree(report)
                if os.environ.get("TRILAT_UPDATE_GOLDEN") == "1":
                    update(golden, files)
                wanted = {path.relative_to(golden): path.read_text() for path in golden.rglob("*") if path.is_file()}
                self.assertEqual(files.keys(), wanted.keys())
                for name, text in files.items():
                    lines, others = text.splitlines(), wanted[name].splitlines()
                    differ = [(a, b) for a, b in zip(lines, others) if not alike(a, b)]
                    self.assertEqual((len(lines), differ[:3]), (len(others), []), f"{name}: TRILAT_UPDATE_GOLDEN=1 when the change is meant")

    def test_what_is_true_of_every_report(self):
        for kind, study in STUDIES.items():
            with self.subTest(kind):
                self.check(self.of(kind, study))
                shutil.rmtree(self.folder / "report")

    def test_what_is_true_of_a_report_beside_the_paper(self):
        trilat("report", made() / "results", "-o", self.folder / "report", "--paper")
        self.check(self.folder / "report")
        self.assertIn("claims", Page((self.folder / "report/report.html").read_text()).ids)

    def test_without_gnuplot_there_is_a_report_that_says_so(self):
        report = self.folder / "report"
        trilat("report", made() / "results", "-o", report, env={**os.environ, "PATH": str(self.folder)})
        self.check(report)
        self.assertIn("There are no pictures, because gnuplot is not installed", (report / "report.md").read_text())
        self.assertEqual({path.suffix for path in report.glob("figures/**/*.*")}, {".csv"})

    def test_results_without_what_they_show_are_to_be_made_again(self):
        self.of("threshold_sweep", TINY["threshold_sweep"])
        results = next(path for path in self.folder.rglob("tables.json")).parent
        (results / "tables.json").unlink()
        self.assertIn("holds no tables.json: an older program made it; run its study again",
                      trilat("report", results, "-o", self.folder / "again", code=2))

    def check(self, report):
        text = (report / "report.html").read_text()
        page = Page(text)
        self.assertEqual(sorted(page.ids), sorted(set(page.ids)), "an id stands twice")
        self.assertTrue(page.captions)
        for caption in page.captions:
            self.assertRegex(caption.lower(), "simulated|recorded|paper|program|assume|configuration|input|machine|errat", caption)
        for link in page.links:
            if link.startswith("#"):
                self.assertIn(link[1:], page.ids)
            elif not link.startswith(("http", "data:")):
                self.assertTrue((report / html.unescape(link)).exists(), link)
        self.assertNotRegex(text, r'(src|href)="http[^"]*\.(js|css|png|svg|woff)', "the page loads something")
        for path in report.rglob("*"):
            if path.suffix in (".md", ".csv", ".tex", ".html"):
                shown = " ".join(page.cells) if path.suffix == ".html" else path.read_text()
                self.assertNotRegex(shown, r"(?i)(?<![a-z])-?(nan|inf)(?![a-z])", path.name)
        self.assertLess((report / "report.html").stat().st_size, 3_000_000)
        self.assertIn(f"version = {{{trilat('--version').split()[1]}}}", (report / "citation.bib").read_text())
        self.check_numbers(report)

    def check_numbers(self, report):
        """Every number of a Markdown table is one of its CSV, rounded."""
        numbers = {}
        for path in report.glob("tables/**/*.csv"):
            with path.open(newline="") as file:
                rows = list(csv.reader(file))
            self.assertEqual({len(row) for row in rows}, {len(rows[0])}, path)
            numbers[path.stem] = rows
        self.assertTrue(numbers)
        for name, rows in numbers.items():
            tex = next(report.glob(f"tables/**/{name}.tex"), None)
            if tex is None:
                continue
            known = [float(cell) for row in rows for cell in row if re.fullmatch(NUMBER, cell)]
            body = tex.read_text().partition("\\midrule")[2].partition("\\bottomrule")[0]
            body = re.sub(r"\n\\quad paper .*", "", body)  # the paper's numbers
            for cell in re.findall(r"[&\n]\s*(-?\d+\.\d+)\s*(?=&|\\\\)", body):
                unit = 10.0 ** -len(cell.partition(".")[2])
                self.assertTrue(any(abs(float(cell) - factor * value) <= 0.51 * unit for value in known for factor in (1, 100, 1000, 1e6)),
                                f"{name}: {cell} is not in its CSV")

    def test_equal_results_give_equal_bytes_and_a_used_folder_is_exchanged(self):
        for name in ("one", "other"):
            trilat("report", made() / "results", "-o", self.folder / name, "--time", "2026-01-01")
        self.assertEqual(everything_in(self.folder / "one"), everything_in(self.folder / "other"))
        (self.folder / "one/tables/left.csv").write_text("of an earlier report")
        trilat("report", made() / "results", "-o", self.folder / "one", "--time", "2026-01-01")
        self.assertEqual(everything_in(self.folder / "one"), everything_in(self.folder / "other"))
        cells = Page((self.folder / "one/report.html").read_text()).cells
        run = json.loads((made() / "results/manifest.json").read_text())
        self.assertTrue(any(run["inputs"][0]["sha256"][:12] in cell for cell in cells), "the inputs' hashes are not shown")

    @unittest.skipIf(shutil.which("pdflatex") is None, "pdflatex is not installed")
    def test_all_tables_compile_whatever_a_name_holds(self):
        nasty = '50 % & $1 #2 a_b {c} ~d ^e \\f "g" <b>'
        study = {**STUDIES["accuracy"], "methods": [{"method": "mean", "name": nasty}, {"method": "nonlinear"}]}
        report = self.of("accuracy", study)
        inputs = "".join(f"\\input{{{path.relative_to(report)}}}\n" for path in sorted(report.glob("tables/**/*.tex")))
        self.assertIn("errors-walking.tex", inputs)
        for document_class in ("{article}", "[twocolumn]{article}", "[journal]{IEEEtran}"):
            if document_class.endswith("{IEEEtran}") and not subprocess.run(["kpsewhich", "IEEEtran.cls"], capture_output=True, check=False).stdout:
                continue
            (report / "article.tex").write_text(f"\\documentclass{document_class}\n\\usepackage[utf8]{{inputenc}}\n\\usepackage[T1]{{fontenc}}\n"
                                                f"\\usepackage{{booktabs}}\n\\begin{{document}}\n{inputs}\\end{{document}}\n")
            done = subprocess.run(["pdflatex", "-halt-on-error", "-interaction=nonstopmode", "article.tex"], cwd=report, capture_output=True,
                                  text=True, errors="replace", check=False)
            self.assertEqual(done.returncode, 0, done.stdout[-1500:])
            if document_class.endswith("{IEEEtran}"):  # 178 mm wide, as the widest of them
                self.assertNotIn("Overfull \\hbox", done.stdout)
        page = (report / "report.html").read_text()
        self.assertNotIn("<b>", Page(page).cells)
        self.assertNotIn('"g" <b>', page)

    def test_what_follows_from_other_numbers_does(self):
        shares = numbers(made() / "results", measure="answered", statistic="share")
        self.assertTrue(shares)
        answered = {tuple(row[key] for key in CELL): row["n"] for row in numbers(made() / "results", measure="distance", statistic="mean")}
        for row in shares:
            self.assertAlmostEqual(row["value"], answered[tuple(row[key] for key in CELL)] / row["n"])
        differences = [row for row in numbers(made() / "results", statistic="difference") if row["clusters"] > 1]
        self.assertTrue(differences)
        for row in differences:
            self.assertEqual(float(row["p"]) < 0.05, row["low"] > 0 or row["high"] < 0)
            self.assertTrue(row["low"] <= row["value"] <= row["high"])
        self.assertEqual({True, False}, {float(row["p"]) < 0.05 for row in differences})

    def test_results_of_one_name_are_refused(self):
        shutil.copytree(made() / "results", self.folder / "a/results")
        self.assertIn("has the name of", trilat("report", self.folder / "a/results", made() / "results", "-o", self.folder / "report", code=2))


if __name__ == "__main__":
    unittest.main(verbosity=2)
