"""The release program carries the hardening that cmake/OctavoModule.cmake asks for.

usage: hardened_program.py PROGRAM    reads its ELF tables with readelf (binutils)
"""

import re
import subprocess
import sys


def readelf(option, program):
    done = subprocess.run(["readelf", "--wide", option, program], check=True,
                          capture_output=True, text=True)
    return done.stdout


def main(program):
    header = readelf("--file-header", program)
    segments = readelf("--program-headers", program)
    dynamic = readelf("--dynamic", program)
    symbols = readelf("--dyn-syms", program)
    expected = {
        "a position-independent executable": re.search(r"Type:\s+DYN", header),
        "relocations read-only after start (RELRO)": "GNU_RELRO" in segments,
        "all symbols bound at start (now)": re.search(r"BIND_NOW|FLAGS_1.*\bNOW\b", dynamic),
        "a stack that is not executable": re.search(r"GNU_STACK.*\bRW\s", segments),
        "stack protectors": "__stack_chk_fail" in symbols,
        "checked copies (_FORTIFY_SOURCE)": re.search(r"__\w+_chk\b(?<!__stack_chk)", symbols),
        "checked containers (_GLIBCXX_ASSERTIONS)": "__glibcxx_assert_fail" in symbols,
    }
    missing = [name for name, found in expected.items() if not found]
    for name in missing:
        print(f"{program}: lacks {name}", file=sys.stderr)
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
