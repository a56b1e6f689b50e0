# SPDX-License-Identifier: MIT
"""The main job at its quick scale: it ends well, and its report has what docs/explanation/paper.md says it has."""
import re
import unittest

from made import SOURCE, ScratchTest, trilat


class Reproduce(ScratchTest):
    def test_everything_that_the_documents_name_is_in_the_report(self):
        trilat("reproduce", "--scale", "quick", "-o", self.folder / "out")
        made = {str(path.relative_to(root).with_suffix("")) for root in (self.folder / "out/report/tables", self.folder / "out/report/figures")
                for path in root.rglob("*.csv")}
        text = (SOURCE / "docs/explanation/paper.md").read_text().split("## Tables and figures")[1].split("##")[0]
        named = [name for row in text.splitlines() if row.startswith("|") for name in re.findall(r"`([a-z0-9_]+/[^`]+)`", row.split("|")[-2])]
        self.assertGreater(len(named), 12)
        for name in named:
            start = name.removesuffix("…")
            self.assertTrue(any(entry.startswith(start) if name.endswith("…") else entry == start for entry in made), name)
        self.assertFalse([name for name in made if name.endswith("_")], "two tables of a study have one id")


if __name__ == "__main__":
    unittest.main()
