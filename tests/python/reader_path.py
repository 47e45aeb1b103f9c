"""Where the tests of the package find it. Imported ahead of it and of what stands on it.

Puts python/ and tests/support on the path; without NumPy it ends the program with 77, which means
skipped.
"""

import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "python"), str(ROOT / "tests" / "support")]

try:
    import numpy  # noqa: F401
except ImportError:
    print(f"skipped: {sys.executable} has no numpy; tools/setup installs python3-numpy")
    sys.exit(77)
