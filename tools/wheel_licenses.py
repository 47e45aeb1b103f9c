#!/usr/bin/env python3
"""Puts the licenses of all that a wheel carries into it, and a list of it in SPDX 2.3.

usage: tools/wheel_licenses.py WHEEL FOLDER

WHEEL is one that auditwheel repaired: the libraries under octavo.libs/ are those of Debian packages
of this machine. Their copyright files, and the licenses of what is linked within the extension, go
to licenses/ of its dist-info, the list to sboms/. The result stands in FOLDER under the same name.
"""

import datetime
import importlib.metadata
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest.mock
import zipfile

import zopfli.zlib

# Debian packages that a wheel may carry libraries of, and their licenses.
LIBRARIES = {
    "libblosc1": "BSD-3-Clause", "libfmt9": "MIT",
    "libfreetype6": "FTL OR GPL-2.0-only", "libhwy1": "Apache-2.0 OR BSD-3-Clause",
    "liblz4-1": "BSD-2-Clause", "libmeshoptimizer2d": "MIT", "libminizip1": "Zlib",
    "libpng16-16": "libpng-2.0", "libsnappy1v5": "BSD-3-Clause", "libtbb12": "Apache-2.0",
    "libwebp7": "BSD-3-Clause", "libwebpmux3": "BSD-3-Clause", "libzstd1": "BSD-3-Clause",
}
# Those that are linked within the extension, as far as it calls them.
INSIDE = ("libblosc1", "libfreetype6", "libhwy1", "libminizip1", "libzstd1")
SOURCE = pathlib.Path(__file__).resolve().parent.parent
FONT = SOURCE / "src/octavo/render/font/LICENSE"


def fail(text):
    sys.exit(f"tools/wheel_licenses.py: {text}")


def package_of(library):
    """The Debian package that has a library."""
    # Without the hash that auditwheel put into its name.
    name = re.sub(r"-[0-9a-f]{8}(?=\.so)", "", library.name)
    for folder in ("/usr/lib", "/lib"):
        for place in pathlib.Path(folder).glob(f"*-linux-gnu/{name}*"):
            owner = owner_of(place)
            if owner:
                return owner
    fail(f"no Debian package has {name}")


def owner_of(place):
    for path in {str(place), os.path.realpath(place), str(place).removeprefix("/usr"),
                 "/usr" + str(place)}:
        found = subprocess.run(["dpkg-query", "-S", path], capture_output=True, text=True,
                               check=False)
        if found.returncode == 0:
            return found.stdout.split(":")[0]
    return None


def part_of(package):
    """(name, version, license, text) of a Debian package."""
    version = subprocess.run(["dpkg-query", "-W", "-f=${Version}", package], check=True,
                             capture_output=True, text=True).stdout
    text = pathlib.Path("/usr/share/doc") / package / "copyright"
    return package, version, LIBRARIES[package], text.read_text()


def parts_of(wheel):
    """(name, version, license, text) of all that is in an unpacked wheel beside Octavo itself."""
    packages = set(INSIDE)
    for library in wheel.glob("octavo.libs/*.so*"):
        package = package_of(library)
        if package not in LIBRARIES:
            fail(f"{library.name} is of {package}: say its license in LIBRARIES")
        packages.add(package)
    nanobind = importlib.metadata.distribution("nanobind")
    texts = [file for file in nanobind.files if "licenses/" in str(file)]
    text = "\n".join(nanobind.locate_file(file).read_text() for file in texts)
    # robin-map within it is under the MIT license, which its headers hold.
    headers = [file for file in nanobind.files if str(file).endswith("robin_map.h")]
    map_text = nanobind.locate_file(headers[0]).read_text().split("*/")[0]
    return [*map(part_of, sorted(packages)), ("nanobind", nanobind.version, "BSD-3-Clause", text),
            ("robin-map", "of nanobind " + nanobind.version, "MIT", map_text),
            ("dejavu-sans-subset", "2.37", "Bitstream-Vera", FONT.read_text())]


def spdx_of(name, version, parts):
    """The list as a document of SPDX 2.3, in JSON."""
    def package(identity, name, version, license_name):
        return {"SPDXID": identity, "name": name, "versionInfo": version,
                "downloadLocation": "NOASSERTION", "filesAnalyzed": False,
                "licenseConcluded": license_name, "licenseDeclared": license_name,
                "copyrightText": "NOASSERTION"}
    packages = [package("SPDXRef-octavo", "octavo", version, "Apache-2.0")]
    relations = [{"spdxElementId": "SPDXRef-DOCUMENT", "relationshipType": "DESCRIBES",
                  "relatedSpdxElement": "SPDXRef-octavo"}]
    for part, part_version, license_name, _ in parts:
        identity = f"SPDXRef-{part}"
        packages.append(package(identity, part, part_version, license_name))
        relations.append({"spdxElementId": "SPDXRef-octavo", "relationshipType": "CONTAINS",
                          "relatedSpdxElement": identity})
    moment = int(os.environ.get("SOURCE_DATE_EPOCH", "0"))
    created = datetime.datetime.fromtimestamp(moment, datetime.timezone.utc)
    return json.dumps({
        "spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT",
        "name": name, "documentNamespace": f"https://spdx.org/spdxdocs/{name}",
        "creationInfo": {"created": created.strftime("%Y-%m-%dT%H:%M:%SZ"),
                         "creators": ["Tool: octavo-tools/wheel_licenses.py"]},
        "packages": packages, "relationships": relations}, indent=1)


class Smallest:
    """What zipfile asks to deflate a file: Zopfli, whose streams are 4 % shorter."""

    def __init__(self, *_):
        self.held = []

    def compress(self, data):
        self.held.append(data)
        return b""

    def flush(self):
        # Without the frame of zlib.
        return zopfli.zlib.compress(b"".join(self.held))[2:-4]


def pack_smallest(source, target):
    """The same archive, packed longer."""
    with unittest.mock.patch("zipfile._get_compressor", Smallest), \
            zipfile.ZipFile(source) as old, zipfile.ZipFile(target, "w") as new:
        for entry in old.infolist():
            new.writestr(entry, old.read(entry))


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    wheel, folder = map(pathlib.Path, sys.argv[1:])
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as work:
        command = [sys.executable, "-m", "wheel"]
        subprocess.run([*command, "unpack", "-d", work, wheel], check=True,
                       stdout=subprocess.DEVNULL)
        unpacked, = pathlib.Path(work).iterdir()
        facts, = unpacked.glob("*.dist-info")
        parts = parts_of(unpacked)
        texts = facts / "licenses" / "third_party"
        texts.mkdir(parents=True, exist_ok=True)
        for name, _, _, text in parts:
            (texts / f"{name}.txt").write_text(text)
        (facts / "sboms").mkdir(exist_ok=True)
        version = facts.name.removeprefix("octavo-").removesuffix(".dist-info")
        (facts / "sboms" / "octavo.spdx.json").write_text(spdx_of(wheel.stem, version, parts))
        subprocess.run([*command, "pack", "-d", work, unpacked], check=True,
                       stdout=subprocess.DEVNULL)
        made, = pathlib.Path(work).glob("*.whl")
        pack_smallest(made, folder / made.name)


if __name__ == "__main__":
    main()
