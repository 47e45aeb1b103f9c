#!/usr/bin/env python3
"""Files have the same bytes for any number of threads, any instruction set and any compiler.

usage: same_bytes_test.py FILE_HASHES [FILE_HASHES of another build ...]

A third of the volumes in fewer ways, but all under tools/nightly.
"""

import os
import subprocess
import sys

IS_FULL = "OCTAVO_NIGHTLY_SHARE" in os.environ
THREADS = [1, 2, 3, 4, 8, 16] if IS_FULL else [1, 16]
STEP = 1 if IS_FULL else 3


def lines_of(program, argument, level=None):
    environment = dict(os.environ)
    environment.pop("OCTAVO_SIMD", None)
    if level:
        environment["OCTAVO_SIMD"] = level
    result = subprocess.run([program, str(argument), str(STEP)], env=environment, text=True,
                            capture_output=True, check=False)
    if result.returncode != 0:
        sys.exit(f"{program} {argument}: {result.stderr}")
    return result.stdout.splitlines()


def main():
    programs = sys.argv[1:]
    runs = [(programs[0], threads, None) for threads in THREADS]
    for program in programs:
        runs += [(program, 2, level) for level in lines_of(program, "--levels")]
    expected = lines_of(*runs[0])
    if len(expected) < 20 // STEP:
        sys.exit(f"{len(expected)} files only")
    differences = 0
    for run in runs[1:]:
        for one, other in zip(expected, lines_of(*run), strict=True):
            if one != other:
                differences += 1
                print(f"{run}: {other}, but {one} by {runs[0]}")
    print(f"goal E1: {len(expected)} of {len(expected)} volumes built in {len(runs)} ways "
          f"(threads, instruction sets, {len(programs)} builds), {differences} different")
    return 1 if differences else 0


if __name__ == "__main__":
    sys.exit(main())
