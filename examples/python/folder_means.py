"""The mean of every scan in a folder, computed by dask brick by brick.

usage: folder_means.py FOLDER [LEVEL]
"""

import pathlib
import sys

import dask

import octavo


def main(folder, level="0"):
    paths = sorted(pathlib.Path(folder).glob("*.8vo"))
    volumes = [octavo.open(path) for path in paths]
    means = dask.compute(*(octavo.as_dask(volume.real.levels[int(level)]).mean(dtype="f8")
                           for volume in volumes))
    for path, mean in zip(paths, means):
        print(f"{path.name}: {mean:.3f}")


if __name__ == "__main__":
    main(*sys.argv[1:])
