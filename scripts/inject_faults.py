#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Makes single system calls of the program fail, one a run, and judges what it made of that.
Usage: inject_faults.py PROGRAM [--faults N] [--seed N] [--scenario NAME]"""
import argparse
import collections
import concurrent.futures
import json
import os
import pathlib
import random
import re
import shutil
import sys
import tempfile

from fault_scenarios import SCENARIOS, files_of, prepare, run, stock

# system calls, and what they say when they fail; those of a row are one kind
KINDS = {
    "open": (["openat"], ["EMFILE", "EACCES", "ENOSPC", "EIO"]),
    "read": (["read", "pread64", "getdents64"], ["EIO"]),
    "look": (["newfstatat", "statx", "readlink"], ["EIO", "EACCES"]),
    "write": (["write", "pwrite64", "writev", "ftruncate", "copy_file_range", "sendfile"], ["ENOSPC", "EIO"]),
    "sync": (["fsync", "fdatasync"], ["EIO", "ENOSPC"]),
    "rename": (["rename", "renameat", "renameat2", "link", "linkat"], ["EIO", "ENOSPC", "EXDEV"]),
    "remove": (["unlink", "unlinkat", "rmdir"], ["EIO", "EACCES"]),
    "folder": (["mkdir", "mkdirat", "flock"], ["ENOSPC", "EACCES"]),
    "memory": (["mmap", "mremap", "brk"], ["ENOMEM"]),
}
# Files in memory, which do not fail, and gnuplot's own and its fonts, without which it draws as it can.
NOT_OURS = re.compile(r"""[<"](/memfd:|/usr/share/(gnuplot|fonts|fontconfig)|/etc/fonts|/var/cache/fontconfig)""")


def counted(lines, start):
    """The calls after the program has started to work, as (kind, call, its number in the thread)."""
    kind_of = {call: kind for kind, (calls, _) in KINDS.items() for call in calls}
    numbers, found, started, main = collections.Counter(), [], None, None
    for line in lines:
        match = re.match(r"(\d+) +(\w+)\((.*)", line)
        if not match or "resumed>" in line:
            continue
        thread, call, rest = match.groups()
        main = main or thread
        if started is None and call == "openat" and re.search(start, rest):
            started = {c: numbers[main, c] for c in kind_of}
        numbers[thread, call] += 1
        number = numbers[thread, call]
        beside = rest.startswith("2<") or NOT_OURS.search(line)
        if started and number > started.get(call, 0) and not beside:
            found.append((kind_of[call], call, number))  # strace counts each thread by itself
    return found


# What somebody is making, or another run left; the next one removes it.
UNFINISHED = re.compile(r"items/\.aside\.|.*\.(partial|trilog)$")


class Injector:
    def __init__(self, program, work):
        self.program, self.work = program, work
        self.clean = {}

    def tracer(self, scenario, folder, options):
        """What goes before the program, and what its environment has besides."""
        trace = ["strace", "-f", "-y", "-qq", "-o", str(folder / "trace"), *options]
        if "gnuplot" not in scenario.name:
            return trace, {}
        (folder / "bin").mkdir(exist_ok=True)
        wrapper = folder / "bin" / "gnuplot"
        wrapper.write_text(f"#!/bin/sh\nexec {' '.join(trace)} -a 1 /usr/bin/gnuplot \"$@\"\n")
        wrapper.chmod(0o755)
        return [], {"PATH": f"{folder}/bin:{os.environ['PATH']}"}

    def count(self, scenario):
        folder = self.work / f"clean{SCENARIOS.index(scenario)}"
        prepare(scenario, self.work / "stock", folder)
        calls = ",".join(call for row, _ in KINDS.values() for call in row)
        before, extra = self.tracer(scenario, folder, ["-e", "trace=" + calls])
        code, out, err = run(self.program, scenario.command, folder, before, extra)
        if code != 0:
            sys.exit(f"inject_faults: {scenario.name} ends with {code} without any fault: {err}")
        self.clean[scenario.name] = (out, files_of(scenario, folder / "out"))
        lines = (folder / "trace").read_text(errors="replace").splitlines()
        words = {word for word in re.split(r"[ =]", scenario.command) if word not in ("run", "out")}
        names = "|".join(re.escape(w) for w in sorted(words | {"out.trilog", "script", "fd"}) if "-" not in w)
        return counted(lines, f'"([^"]*/)?({names})[/".]')

    def judge(self, scenario, folder, earlier, result, silent):
        """What is wrong; nothing when all is right."""
        code, out, err = result
        clean_out, clean_files = self.clean[scenario.name]
        now = files_of(scenario, folder / "out")
        if code is None:
            return "hangs"
        if code < 0 or code > 128:
            return f"dies by signal: {err[-300:]}"
        if code not in (0, 1, 2):
            return f"ends with {code}: {err[-300:]}"
        if scenario.name in ("record", "recover"):
            return self.judge_recording(folder, scenario, result, silent)
        if code == 0:
            if out != clean_out and not scenario.name.startswith("sweep"):  # which prints times
                return "succeeds with another text"
            others = self.others(scenario, now, clean_files)
            return f"succeeds with other files: {others}" if others else ""
        if code == 1:
            return "" if "failed" in err else f"ends with 1 and names no failure: {err[-300:]}"
        if not err.startswith("trilat: ") and "\ntrilat: " not in err and not silent:
            return f"fails without a message: {err[-300:]}"
        if not scenario.finished:
            return "" if now in ({}, earlier, clean_files) else f"leaves what looks finished: {differences(now, clean_files)}"
        return self.judge_folder(scenario, now, earlier, clean_files)

    @staticmethod
    def others(scenario, now, clean_files):
        """What is not as it should be at the end. Items that nobody needs may be left. Which items are a shard's depends on
        which takes can be looked into; a run without --shard computes what none did."""
        if scenario.name == "run --shard":
            return [n for n, h in now.items() if n.startswith("items/") and clean_files.get(n, h) != h]
        return differences({n: h for n, h in now.items() if n in clean_files or not n.startswith("items/")}, clean_files)

    @staticmethod
    def judge_folder(scenario, now, earlier, clean_files):
        """An item is whole or not there; the folder looks finished only when it is, or as it was."""
        if now == earlier:
            return ""
        rest = {n: h for n, h in now.items() if not UNFINISHED.match(n)}
        half = [n for n, h in rest.items() if clean_files.get(n, h) != h and earlier.get(n) != h and
                (n != "manifest.json" or scenario.finished in rest)]
        if half:
            return f"leaves half files: {half}"
        missing = [n for n in clean_files if n not in rest]
        return f"looks finished without {missing}" if scenario.finished in rest and missing else ""

    def judge_recording(self, folder, scenario, result, silent):
        """A recording has its name only when it is sound and holds what was said."""
        code, out, err = result
        if not (folder / "out").exists():
            if code == 0:
                return "succeeds without a recording"
            return "" if err.strip() or silent else "fails without a message"
        if scenario.name == "recover" and code == 0 and files_of(scenario, folder / "out") != self.clean["recover"][1]:
            return "succeeds without all that was there"
        if code == 1 and "failed" not in err and "broke" not in err:
            return f"ends with 1 and names no failure: {err[-300:]}"
        verdict, text, _ = run(self.program, "verify out", folder)
        if verdict != 0 and "holds no frames" not in text:
            return f"ends with {code}, and verify with {verdict}: {text[-300:]}"
        if scenario.name == "record" and code == 0:
            _, found, _ = run(self.program, "info out --json", folder)
            counts = [[[s[k] for k in ("name", "body_frames", "depth_frames")] for s in json.loads(t)["sensors"]]
                      for t in (out, found)]
            return "" if counts[0] == counts[1] else f"says {counts[0]} and holds {counts[1]}"
        return ""

    def again(self, scenario, folder):
        """What is wrong with the same command once more, now that nothing fails."""
        recorded = (folder / "out").exists()
        command, right = scenario.command, (0,)
        if scenario.name == "record" and (folder / "out.trilog").exists() and not recorded:
            command, right = "recover out", (0, 1, 2)  # nothing may have been written yet
        _, clean_files = self.clean[scenario.name]
        code, _, err = run(self.program, command, folder)
        now = files_of(scenario, folder / "out")
        if code == 2 and "exists" in err and scenario.name in ("record", "recover"):
            return "" if recorded else f"again: {err[-300:]}"  # recordings are never replaced
        if code not in right or (code == 2 and not err.startswith("trilat: ")):
            return f"again: `{command}` ends with {code}: {err[-300:]}"
        if scenario.name == "record" or (scenario.name == "recover" and recorded):
            return ""
        others = self.others(scenario, now, clean_files)
        return f"again: other files: {others}" if others else ""

    def inject(self, number, scenario, fault):
        kind, call, which, error, lasting = fault
        folder = self.work / f"{number}"
        prepare(scenario, self.work / "stock", folder)
        earlier = files_of(scenario, folder / "out")
        when = f"{which}+" if lasting else f"{which}"
        error = "retval=0" if call == "brk" else f"error={error}"  # what the kernel says: the end did not move
        options = ["-e", f"trace={call}", "-e", f"inject={call}:{error}:when={when}"]
        before, extra = self.tracer(scenario, folder, options)
        result = run(self.program, scenario.command, folder, before, extra)
        trace = folder / "trace"
        lines = trace.read_text(errors="replace").splitlines() if trace.exists() else []
        hit = [line for line in lines if "(INJECTED)" in line]
        injected = bool(hit) and not any(NOT_OURS.search(line) for line in hit)
        silent = any(" write(2<" in line for line in hit)  # nobody can tell
        finding = self.judge(scenario, folder, earlier, result, silent)
        finding = finding or self.again(scenario, folder)
        shutil.rmtree(folder)
        return scenario, fault, injected, result[0], finding


def differences(now, clean):
    return sorted(name for name in now.keys() | clean.keys() if now.get(name) != clean.get(name))[:6]


def chosen(calls, scenario, quota, rng):
    """Faults of every kind, evenly over the calls of each."""
    faults = []
    for kind, (_, errors) in KINDS.items():
        of_kind = sorted({(call, number) for k, call, number in calls if k == kind})
        offset = rng.random()
        count = min(quota, len(of_kind) * len(errors) * 2)
        for k in range(count):
            call, number = of_kind[int((k + offset) * len(of_kind) / count) % len(of_kind)]
            lasting = kind in ("write", "memory", "open", "sync") and rng.random() < 0.4
            faults.append((scenario, (kind, call, number, rng.choice(errors), lasting)))
    return faults


def print_table(outcomes):
    rows = collections.defaultdict(collections.Counter)
    entries = ("injected", "failed", "equal", "finding")
    for scenario, fault, injected, code, finding in outcomes:
        row = rows[scenario.name, fault[0]]
        row["injected"] += injected
        row["finding" if finding else "equal" if code == 0 else "failed"] += injected
    columns = ("injected", "clean failures", "equal successes", "findings")
    print(f"{'scenario':<18} {'kind':<8}", *(f"{column:>15}" for column in columns))
    for (scenario, kind), row in rows.items():
        if row["injected"]:
            print(f"{scenario:<18} {kind:<8}", *(f"{row[entry]:>15}" for entry in entries))
    total = sum(rows.values(), collections.Counter())
    print(f"{'all':<27}", *(f"{total[entry]:>15}" for entry in entries))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--faults", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--scenario", default="")
    arguments = parser.parse_args()
    rng = random.Random(arguments.seed)
    scenarios = [s for s in SCENARIOS if arguments.scenario in ("", s.name)]
    with tempfile.TemporaryDirectory() as name, \
            concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        work = pathlib.Path(name).resolve()
        injector = Injector(str(arguments.program.resolve()), work)
        stock(injector.program, work / "stock")
        calls = {s: injector.count(s) for s in scenarios}
        quota = 1
        faults = []
        while len(faults) < arguments.faults and quota < 1000:
            faults = [f for s in scenarios for f in chosen(calls[s], s, quota, random.Random(arguments.seed))]
            quota += 1
        rng.shuffle(faults)
        print(f"{len(faults)} faults, seed {arguments.seed}", flush=True)
        outcomes = []
        for done in pool.map(lambda f: injector.inject(f[0], *f[1]), enumerate(faults)):
            outcomes.append(done)
            scenario, fault, injected, code, finding = done
            if finding and injected:
                print(f"FINDING {scenario.name}: {fault} -> {code}: {finding}", flush=True)
    outcomes.sort(key=lambda o: (SCENARIOS.index(o[0]), list(KINDS).index(o[1][0])))
    print_table(outcomes)
    sys.exit(any(injected and finding for _, _, injected, _, finding in outcomes))


if __name__ == "__main__":
    main()
