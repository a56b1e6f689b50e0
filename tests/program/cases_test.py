# SPDX-License-Identifier: MIT
"""Runs the command lines of cases.json and checks exit code, messages and files.

`@` is the folder that made.py makes. What is refused changes no byte anywhere and says one line."""
import json
import os
import shutil
import signal
import subprocess
import time
import unittest
from pathlib import Path

from made import PROGRAM, ScratchTest, ended, everything_in, made, trilat

CASES = json.loads((Path(__file__).parent / "cases.json").read_text())
VERBS = ("info", "verify", "recover", "record", "simulate", "calibrate", "run", "report", "reproduce", "demo", "init", "gate", "fuse", "schema")


def looks_finished(output):
    """Folders are finished by one file, which comes last."""
    return output.is_file() or any((output / mark).exists() for mark in ("summary.json", "campaign.json", "report.html"))


class Cases(ScratchTest):
    def place(self, name):
        return Path(name.replace("@", str(made()))) if name.startswith("@") else self.folder / name

    def filled(self, words):
        return [word.replace("@", str(made())) if word.startswith("@") else word for word in words]

    def put(self, files):
        """Text, a document, {"copy": of}, {"cut": of, "bytes": n}; null removes."""
        for name, content in {**CASES["documents"], **files}.items():
            path = self.folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            if content is None:
                path.unlink()
            elif "copy" in content and self.place(content["copy"]).is_dir():
                shutil.copytree(self.place(content["copy"]), path)
            elif "copy" in content:
                shutil.copy(self.place(content["copy"]), path)
            elif "cut" in content:
                path.write_bytes(self.place(content["cut"]).read_bytes()[:content["bytes"]])
            else:
                self.written(name, content)

    def each(self, list_name, check):
        """Every case in a folder of its own."""
        holder = self.folder
        for number, case in enumerate(CASES[list_name]):
            with self.subTest(case["name"]):
                self.folder = holder / str(number)
                self.folder.mkdir()
                self.put(case.get("files", {}))
                check(case)

    def refused(self, words, says):
        """Exit code 2, one line on stderr that begins with the program's name, and every byte is where it was."""
        before = everything_in(self.folder)
        done = ended(*words, cwd=self.folder)
        self.assertEqual(done.returncode, 2, f"{words}: {done.stdout}{done.stderr}")
        self.assertEqual(done.stdout, "")
        self.assertRegex(done.stderr, r"\Atrilat: .*\n\Z")
        self.assertIn(says, done.stderr)
        self.assertEqual(everything_in(self.folder), before, words)

    def test_what_is_wrong_is_refused(self):
        def check(case):
            self.refused(self.filled(case["words"]), case["says"])

        self.each("refused", check)

    def test_every_verb_has_help_and_knows_its_options(self):
        every = trilat("--help")
        for verb in VERBS:
            with self.subTest(verb):
                self.assertIn(f"\n  {verb}", every)
                self.assertIn(verb, trilat(verb, "--help"))
                self.refused([verb, "a", "-o", "b", "--levitate"], "")

    def test_what_is_done_says_so_and_leaves_its_files(self):
        def check(case):
            done = ended(*self.filled(case["words"]), cwd=self.folder)
            self.assertIn(done.returncode, case.get("code", [0]), done.stderr)
            for words in case["says"]:
                self.assertIn(words, done.stdout + done.stderr)
            for name in case.get("left", []):
                self.assertTrue((self.folder / name).exists(), name)
            if "left" in case and not case["left"]:
                self.assertEqual({path.name for path in self.folder.iterdir()}, {*CASES["documents"], *case.get("files", {})})

        self.each("done", check)

    def test_a_full_disk_leaves_nothing_that_looks_finished(self):
        def check(case):
            output = self.folder / case["words"][-1]
            for bytes_left in (0, 5000):
                done = ended(*self.filled(case["words"]), cwd=self.folder, largest_file=bytes_left or 1)
                self.assertIn(done.returncode, (1, 2), f"{bytes_left}: {done.stderr}")
                self.assertIn("annot be ", done.stderr)
                if output.suffix != ".h5":  # a recording closes in order what it could write
                    self.assertFalse(looks_finished(output), bytes_left)
                for left in self.folder.glob("x.h5*"):
                    left.unlink()
            self.assertEqual(ended(*self.filled(case["words"]), cwd=self.folder).returncode, 0)

        self.each("full disk", check)

    def test_an_interrupt_ends_with_130_and_leaves_nothing_half_written(self):
        def check(case):
            process = subprocess.Popen([PROGRAM, *self.filled(case["words"])], cwd=self.folder, stdout=subprocess.DEVNULL,
                                       stderr=subprocess.PIPE, text=True)
            before, begun = set(os.listdir(self.folder)), time.monotonic()
            while set(os.listdir(self.folder)) == before and time.monotonic() - begun < 60:
                time.sleep(0.005)
            time.sleep(0.1)
            process.send_signal(signal.SIGINT)
            said = process.communicate(timeout=60)[1]
            self.assertEqual(process.returncode, 130, said)
            self.assertIn("interrupted", said)
            self.assertFalse(looks_finished(self.folder / "x"))
            self.assertIn("kept in x", said)

        self.each("interrupted", check)

    def write_to(self, case, output, *more):
        for name in [case["gone"]] if "gone" in case else []:
            (self.folder / name).unlink(missing_ok=True)
        self.put(case.get("again", {}))
        return [*self.filled(case["words"]), case.get("option", "-o"), str(output), *more]

    def test_outputs_are_never_inputs_and_never_what_others_wrote(self):
        def check(case):
            suffix, forces, is_folder = case.get("suffix", ""), case.get("forces", True), case["is"] == "folder"
            self.put(case.get("again", {}))
            for name in case.get("reads", []):
                own, words = self.place(name), self.filled(case["words"])
                if name.startswith("@"):  # the made folder is not written to even where the program is wrong
                    top = name.split("/")[1]
                    shutil.copytree(made() / top, self.folder / "own" / top)
                    own = Path(name.replace("@", str(self.folder / "own")))
                    words = [word.replace(str(made() / top), str(self.folder / "own" / top)) for word in words]
                link = self.folder / f"link{suffix}"
                link.symlink_to(own)
                names = [own, link]
                if own.is_file():
                    names.append(self.folder / f"hard{suffix}")
                    os.link(own, names[-1])
                for output in names:
                    for force in ([], ["--force"]) if forces else ([],):
                        self.refused([*words, case.get("option", "-o"), output, *force], str(output))
                for output in names[1:]:
                    output.unlink()
                shutil.rmtree(self.folder / "own", ignore_errors=True)
            file, folder = self.folder / f"notes{suffix}", self.folder / f"thesis{suffix}"
            file.write_text("ten years of work")
            folder.mkdir()
            (folder / "notes").write_text("ten years of work")
            self.refused(self.write_to(case, file), "is a file" if is_folder else "--force" if forces else file.name)
            self.refused(self.write_to(case, folder), "--force" if is_folder else "folder")
            output = self.folder / f"own output{suffix}"
            for _ in range(1 if case.get("kept") else 2):
                done = ended(*self.write_to(case, output), cwd=self.folder)
                self.assertEqual(done.returncode, 0, done.stderr)
            if case.get("kept"):
                self.refused(self.write_to(case, output), "--force")
            if forces:
                done = ended(*self.write_to(case, folder if is_folder else file, "--force"), cwd=self.folder)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertTrue(is_folder or file.read_bytes() != b"ten years of work")

        self.each("outputs", check)


if __name__ == "__main__":
    unittest.main(verbosity=2)
