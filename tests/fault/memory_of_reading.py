#!/usr/bin/env python3
"""Gives verbs that read volumes the memory that they ask for, and measures what they take.

usage: memory_of_reading.py OCTAVO

Each verb rejects 1 MiB and says what it needs; given that, it may say what more it needs, and then
it runs: its largest resident memory that is not of files stays within the limit.
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile

MIB = 1 << 20
UNITS = {"bytes": 1, "KiB": 1 << 10, "MiB": MIB, "GiB": 1 << 30}
MOST_TRIES = 4
RAYS = ["--size", "200", "-o", "out.png"]
VERBS = [["render", "a.8vo", "--mode", "mip", *RAYS],
         ["render", "a.8vo", "--mode", "volume", *RAYS],
         ["render", "a.8vo", "--mode", "iso", "--isovalue", "500", *RAYS],
         ["compare", "a.8vo", "b.8vo"],
         ["verify", "a.8vo", "--against", "b.8vo"],
         ["morphometry", "mask.8vo", "--no-thickness"]]
DONE = (0, 1)  # 1: there is a difference


def run(octavo, folder, *arguments):
    subprocess.run([octavo, *arguments, "--quiet"], cwd=folder, check=True)


def make_volumes(octavo, folder):
    for name, seed in (("a.8vo", "1"), ("b.8vo", "2")):
        run(octavo, folder, "phantom", "--size", "320,320,96", "--noise", "12", "--seed", seed,
            "-o", name)
    run(octavo, folder, "threshold", "a.8vo", "--range", "500:", "-o", "mask.8vo")


def anonymous_bytes(process):
    try:
        with open(f"/proc/{process.pid}/status", encoding="ascii") as status:
            found = re.search(r"RssAnon:\s+(\d+) kB", status.read())
    except (FileNotFoundError, ProcessLookupError):
        return 0
    return int(found[1]) * 1024 if found else 0


def measured(octavo, folder, verb, threads, limit):
    """Exit status, what was said, and the largest anonymous memory."""
    with open(folder / "said", "w+", encoding="utf-8") as said, \
            subprocess.Popen([octavo, *verb, "--threads", threads, "--max-memory", str(limit),
                              "--force", "--quiet"],
                             cwd=folder, stdout=subprocess.DEVNULL, stderr=said) as process:
        most = 0
        while process.poll() is None:
            most = max(most, anonymous_bytes(process))
            try:
                process.wait(0.002)
            except subprocess.TimeoutExpired:
                pass
        said.seek(0)
        return process.returncode, said.read(), most


def check(octavo, folder, verb, threads):
    limit = MIB
    for _ in range(MOST_TRIES):
        status, said, most = measured(octavo, folder, verb, threads, limit)
        if status in DONE:
            break
        found = re.search(r"(?:needs|would take) about (\d+) (bytes|KiB|MiB|GiB)", said)
        if status != 6 or not found:
            sys.exit(f"{verb}, {limit / MIB:.0f} MiB: exit {status}, {said}")
        if ("fewer threads" in said) and threads == "1":
            sys.exit(f"{verb}: fewer threads than one: {said}")
        limit = int(found[1]) * UNITS[found[2]]
    else:
        sys.exit(f"{verb}: rejected {MOST_TRIES} times: {said}")
    if limit == MIB:
        sys.exit(f"{verb}: runs within 1 MiB")
    if most > limit:
        sys.exit(f"{verb}, {threads} threads: {most / MIB:.1f} MiB, {limit / MIB:.1f} allowed")
    print(f"{' '.join(verb[:4])}, {threads} threads: {most / MIB:.0f} of {limit / MIB:.0f} MiB",
          flush=True)


def main():
    octavo = os.path.abspath(sys.argv[1])
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        make_volumes(octavo, folder)
        for threads in ("1", "2"):
            for verb in VERBS:
                check(octavo, folder, verb, threads)


if __name__ == "__main__":
    main()
