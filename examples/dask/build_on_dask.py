#!/usr/bin/env python3
"""Builds one .8vo file on the workers of a Dask cluster.

usage: build_on_dask.py SCHEDULER OUTPUT SOURCE... [options of octavo plan]

    build_on_dask.py tcp://head:8786 scan.8vo slices/ --spacing 0.0195 --part-size 4G

`octavo` and the Python package `distributed` are on every node, and all nodes see the folder by one
path. Parts lie beside OUTPUT, in OUTPUT.parts/, until they are joined; a run that failed goes on
with those that are there when the same command is given again.
"""

import json
import os
import pathlib
import subprocess
import sys

from distributed import Client, as_completed


def octavo(verb, *arguments, folder):
    """What the program prints as JSON; runs on a worker."""
    command = ["octavo", verb, *map(str, arguments), "--json", "--progress", "none"]
    result = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if result.returncode != 0:
        raise RuntimeError(f"octavo {verb} ended with {result.returncode}: {result.stderr.strip()}")
    return json.loads(result.stdout)


def make_part(number, plan, parts, folder):
    # One thread: a worker makes as many parts at a time as it has threads.
    return octavo("part", plan, "--part", number, "-j", 1, "-o", parts, folder=folder)


def build(client, output, source, retries=3, report=print):
    """Plans, makes the parts, joins. A part whose worker dies is made by another one."""
    output = pathlib.Path(output).absolute()
    plan, parts = output.with_suffix(".plan"), output.with_name(output.name + ".parts")
    folder = os.getcwd()
    # The same source and options make the same plan, so that its parts are kept.
    planned = client.submit(octavo, "plan", *source, "-f", "-o", plan, folder=folder,
                            pure=False).result()
    for warning in planned["warnings"]:
        report(f"warning: {warning}")
    made = client.map(make_part, range(planned["parts"]), plan=plan, parts=parts, folder=folder,
                      retries=retries, pure=False)
    for count, future in enumerate(as_completed(made), 1):
        future.result()
        report(f"{count} of {planned['parts']} parts")
    client.submit(octavo, "join", plan, parts, "--consume", "-f", "-o", output, folder=folder,
                  retries=retries, pure=False).result()
    parts.rmdir()
    plan.unlink()
    report(f"{output.name} is there")


def main(scheduler, output, *source):
    if os.path.exists(output):
        sys.exit(f"{output} exists")
    try:
        with Client(scheduler) as client:
            build(client, output, source)
    except (RuntimeError, OSError) as error:
        sys.exit(str(error))


if __name__ == "__main__":
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
