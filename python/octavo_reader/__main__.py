"""python3 -m octavo_reader FILE [--verify] [--level K -o OUT.npy]"""

import argparse
import sys

try:
    import numpy as np
except ModuleNotFoundError:
    sys.exit(f"octavo_reader: NumPy is missing for {sys.executable}; install python3-numpy")

from . import OctavoError, OctavoFile, verify  # noqa: E402
from .errors import EXIT_STATUS  # noqa: E402

_READING_FAILED = 5
_OUT_OF_MEMORY = 6


def _describe(file: OctavoFile) -> None:
    header = file.header
    print(f"{header.kind}, {header.voxel_type}, max error {header.max_error:g}")
    print(f"origin {header.origin} mm, spacing {header.spacing} mm, direction {header.direction}")
    print(f"sha256 {file.voxel_digest.hex()}")
    print(f"real value = {header.slope:g} * voxel + {header.intercept:g}")
    for level in range(header.level_count):
        print("level {}: {} x {} x {}".format(level, *header.level_size(level)))


def main() -> int:
    parser = argparse.ArgumentParser(prog="octavo_reader", description="Reads .8vo files.")
    parser.add_argument("file", metavar="FILE", help="an .8vo file, described without --level")
    parser.add_argument("--level", type=int, metavar="K", help="read level K; 0 is the scan")
    parser.add_argument("--verify", action="store_true", help="prove every byte and voxel")
    parser.add_argument("-o", "--output", metavar="OUT", help="array [z][y][x]: .npy, else raw")
    options = parser.parse_args()
    if (options.level is None) != (options.output is None):
        parser.error("--level and -o go together")
    try:
        with OctavoFile(options.file) as file:
            if options.verify:
                verify(file)
            if options.level is None:
                _describe(file)
                return 0
            samples = file.read_level(options.level)
            if options.output.endswith(".npy"):
                np.save(options.output, samples)
            else:
                samples.tofile(options.output)
    except (OctavoError, OSError, MemoryError) as error:
        print(f"{options.file}: {error}", file=sys.stderr)
        if isinstance(error, OctavoError):
            return EXIT_STATUS[error.kind]
        return _OUT_OF_MEMORY if isinstance(error, MemoryError) else _READING_FAILED
    return 0


if __name__ == "__main__":
    sys.exit(main())
