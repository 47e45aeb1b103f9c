#!/usr/bin/env python3
"""Which lines and branches of the reading side were reached, from what its tests counted.

usage: tools/coverage_figures.py BUILD PROGRAM...
BUILD/profiles/*.profraw are what the programs counted. Prints the shares of core, codec and file
and writes BUILD/lines.txt: for every file its shares, the lines that were not reached, and the
lines where some branch was never taken.

A branch is one outcome of a condition in the source, of if, loops, ?:, && and ||, and a case of a
switch, as Clang sees the source: calls that may throw and code of the standard library have none.
(GCC's counters know only jumps of the compiled function: they take every call that may throw for
one, and every copy that was inlined.) Of templates a branch counts once, and as taken when any of
the copies takes it. Conditions that the compiler knows, as those of `if constexpr`, are no
branches, and functions that only it runs (consteval) have no lines.

What Highway compiles for several instruction sets is left out: the counters of the copies that ran
do not match their source with Clang 14, which would show all of it as never reached. That it gives
what the portable code gives is tested for each set (grey_stage_test.cpp, label_walk_test.cpp).
"""

import collections
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
MODULES = ("core", "codec", "file")
VECTORIZED = ("-inl.h", "_simd.cpp", "least_squares.cpp")
LINE = re.compile(r" *(\d+)\| *([\d.kMGTPEZY]+)\|")
BRANCH = re.compile(r".*\| +Branch \((\d+):(\d+)\): \[True: ([^,]+), False: ([^\]]+)\]")


class FileCounts:
    def __init__(self):
        self.lines = {}  # line that holds code -> whether it was reached
        self.branches = collections.defaultdict(lambda: [False, False])  # (line, column) -> taken


def counted(build, programs):
    """File below src/octavo -> its FileCounts, from the counters of all programs."""
    merged = build / "profiles/all.profdata"
    raw = sorted(str(path) for path in (build / "profiles").glob("*.profraw"))
    subprocess.run(["llvm-profdata", "merge", "--sparse", f"--output={merged}", *raw], check=True)
    objects = [part for program in programs[1:] for part in ("--object", program)]
    told = subprocess.run(
        ["llvm-cov", "show", f"--instr-profile={merged}", "--show-branches=count",
         "--show-instantiations=false", "--use-color=false",
         "--ignore-filename-regex=(^|/)(tests|usr)/", programs[0], *objects],
        check=True, stdout=subprocess.PIPE, text=True)
    files = collections.defaultdict(FileCounts)
    here = FileCounts()
    for text in told.stdout.splitlines():
        if text.startswith("/") and text.endswith(":"):
            # A compiler cache has names relative to the build folder.
            name = os.path.relpath(os.path.normpath(text[:-1]), ROOT / "src/octavo")
            here = files[name] if name.split("/")[0] in MODULES else FileCounts()
        elif found := LINE.match(text):
            here.lines[int(found[1])] = found[2] != "0"
        elif found := BRANCH.match(text):
            taken = here.branches[int(found[1]), int(found[2])]
            for outcome in (0, 1):
                taken[outcome] |= found[3 + outcome] != "0"
    return files


def runs(numbers):
    """'3-5,9' of 3, 4, 5, 9."""
    ends = []
    for number in numbers:
        if ends and ends[-1][1] == number - 1:
            ends[-1][1] = number
        else:
            ends.append([number, number])
    return ",".join(str(a) if a == b else f"{a}-{b}" for a, b in ends)


def share(reached, total):
    return f"{100 * reached / max(1, total):.1f} %"


def main():
    build = pathlib.Path(sys.argv[1])
    sums = collections.defaultdict(collections.Counter)
    report = []
    for name, counts in sorted(counted(build, sys.argv[2:]).items()):
        if name.endswith(VECTORIZED):
            continue
        missing = [number for number, is_reached in counts.lines.items() if not is_reached]
        half = sorted({line for (line, _), both in counts.branches.items() if not all(both)})
        taken = sum(sum(both) for both in counts.branches.values())
        lines, branches = len(counts.lines), 2 * len(counts.branches)
        for module in ("all", name.split("/")[0]):
            sums[module].update(lines=lines, reached=lines - len(missing), branches=branches,
                                taken=taken)
        report.append(f"{name}: {lines - len(missing)} of {lines} lines, {taken} of {branches} "
                      f"branches\n  not reached: {runs(missing)}\n  not every branch: "
                      f"{runs(half)}\n")
    if not report:
        sys.exit("coverage_figures: the programs have counted no line of src/octavo")
    (build / "lines.txt").write_text("".join(report))
    print("goal Q1: " + "; ".join(
        f"{module} {share(sums[module]['reached'], sums[module]['lines'])} of lines, "
        f"{share(sums[module]['taken'], sums[module]['branches'])} of branches"
        for module in ("all", *MODULES)))


main()
