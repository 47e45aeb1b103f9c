#!/usr/bin/env python3
"""Builds phantoms that are many times larger than the memory they are given.

usage: bounded_memory.py OCTAVO [SIDE ...]

For each side: a build rejects a limit below its need and tells the need; within that limit it runs,
under an address space of 1.2 times as much and what the program needs to start, and its peak stays
within 1.05 times the limit. Sides of 512, 1024 and 2048 under tools/nightly, with a small share of
them what has its part of the voxels; otherwise 512: several groups, each of which is trained on.
"""

import os
import pathlib
import re
import resource
import subprocess
import sys
import tempfile

MIB = 1 << 20
THREADS = 2


def phantom(octavo, side, folder, limit_mib, **options):
    return subprocess.Popen(
        [octavo, "phantom", "--size", str(side), "--noise", "12", "--threads", str(THREADS),
         "--max-memory", f"{limit_mib}M", "--quiet", "--force", "-o", "out.8vo"],
        cwd=folder, stderr=subprocess.PIPE, text=True, **options)


def finish(process):
    """Exit status, what was said, and the largest resident size in MiB."""
    said = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return process.returncode, said, usage.ru_maxrss / 1024


def needed_mib(octavo, side, folder):
    status, said, _ = finish(phantom(octavo, side, folder, 1))
    found = re.search(r"needs about (\d+) MiB", said)
    if status != 6 or not found:
        sys.exit(f"side {side}: exit {status}, {said}")
    return int(found[1])


def address_space_at_start(octavo):
    """Bytes that the program and its libraries occupy before they do anything, by halving."""
    low, high = 1, 4096
    while low < high:
        middle = (low + high) // 2

        def limit(mib=middle):
            resource.setrlimit(resource.RLIMIT_AS, (mib * MIB, mib * MIB))

        done = subprocess.run([octavo, "--version"], preexec_fn=limit, capture_output=True,
                              check=False)
        low, high = (low, middle) if done.returncode == 0 else (middle + 1, high)
    return low * MIB


def check(octavo, side, at_start):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        need = needed_mib(octavo, side, folder)
        space = int(1.2 * need * MIB) + at_start

        def limit():
            resource.setrlimit(resource.RLIMIT_AS, (space, space))

        status, said, peak = finish(phantom(octavo, side, folder, need, preexec_fn=limit))
        if status != 0:
            sys.exit(f"side {side}: exit {status} within {need} MiB: {said}")
        if peak > 1.05 * need:
            sys.exit(f"side {side}: {peak:.0f} MiB resident, {need} MiB allowed")
        raw = 2 * side ** 3 / MIB
        return f"{side}^3 ({raw:.0f} MiB): {peak:.0f} of {need} MiB"


def main():
    octavo = os.path.abspath(sys.argv[1])
    share = float(os.environ.get("OCTAVO_NIGHTLY_SHARE", "0"))
    sides = [side for side in (512, 1024, 2048) if side ** 3 <= share * 2048 ** 3] or [512]
    sides = [int(side) for side in sys.argv[2:]] or sides
    at_start = address_space_at_start(octavo)
    figures = [check(octavo, side, at_start) for side in sides]
    print(f"goal C2: {len(sides)} of {len(sides)} phantoms within their memory, "
          f"{', '.join(figures)}")


if __name__ == "__main__":
    main()
