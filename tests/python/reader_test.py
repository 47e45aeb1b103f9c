#!/usr/bin/env python3
"""Compares python/octavo_reader with the program and with the golden files.

usage: reader_test.py OCTAVO [unittest arguments]

The package was written from docs/format.md alone, so that a difference is a fault of the program,
of the package or of the document. Every level of every golden file is read; a fifth of the files
is verified, under tools/nightly all of them. Exits with 77, which means skipped, where NumPy is
missing.
"""

import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

from reader_path import ROOT  # first: it finds the others
import numpy as np
import volumes
from file_bytes import with_metadata
from octavo_reader import OctavoError, OctavoFile, grey_brick, verify
from octavo_reader.byte_cursor import crc32c

OCTAVO = "octavo"
IS_FULL_FORM = "OCTAVO_NIGHTLY_SHARE" in os.environ
GOLDEN = ROOT / "tests" / "golden" / "v1"


class InFolder(unittest.TestCase):
    """Each test works in a fresh folder."""

    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)

    def octavo(self, *arguments):
        command = [OCTAVO, *map(str, arguments), "--quiet", "--force"]
        result = subprocess.run(command, capture_output=True, text=True, check=False)
        self.assertEqual(result.returncode, 0, f"{command}\n{result.stderr}")

    def build(self, case):
        """The path of the file that the program makes of a case."""
        path = self.folder / "volume.8vo"
        if case.voxels.dtype == np.float32:
            source = self.folder / "volume.nii"
            source.write_bytes(volumes.nifti(case.voxels))
            layout = []
        else:
            source = self.folder / "volume.raw"
            case.voxels.tofile(source)
            size = ",".join(map(str, case.voxels.shape[::-1]))
            layout = ["--raw", f"{size},{case.voxels.dtype}", "--spacing", case.spacing]
        self.octavo("build", source, *layout, *case.options, "-o", path)
        return path


class AgreesWithTheProgram(InFolder):
    def test_every_level_is_that_of_the_program_and_lossless_ones_begin_with_the_source(self):
        for case in volumes.cases():
            with self.subTest(case.name), OctavoFile(self.build(case)) as file:
                self.assertTrue(case.uses(file), "the file does not use what this case is for")
                for level in range(file.header.level_count):
                    raw = self.folder / "level.raw"
                    self.octavo("export", self.folder / "volume.8vo", "--level", level,
                                "--stored", "-o", raw)
                    samples = file.read_level(level)
                    self.assertEqual(samples.shape[::-1], file.header.level_size(level))
                    self.assertTrue(samples.tobytes() == raw.read_bytes(), f"level {level}")
                    is_lossless = file.header.max_error == 0 and file.header.detail_level == 0
                    if level == 0 and is_lossless:
                        self.assertTrue(samples.tobytes() == case.voxels.tobytes())

    def test_cells_of_one_value_are_flagged(self):
        case = next(case for case in volumes.cases() if case.name == "cells")
        seen = []
        inner = grey_brick._Brick._cell_flags

        def cell_flags(brick, data):
            seen.append(inner(brick, data))
            return seen[-1]

        with (mock.patch.object(grey_brick._Brick, "_cell_flags", cell_flags),
              OctavoFile(self.build(case)) as file):
            self.assertTrue(np.array_equal(file.read_level(0), case.voxels))
        self.assertTrue(any(flags.any() for flags in seen))


class GoldenFiles(unittest.TestCase):
    def test_every_level_has_the_checksum_noted_beside_the_file(self):
        lines = [line.split() for line in (GOLDEN / "levels.txt").read_text().splitlines()]
        self.assertGreater(len(lines), 0)
        for name, level, checksum in lines:
            with self.subTest(f"{name} {level}"), OctavoFile(GOLDEN / name) as file:
                samples = file.read_level(int(level))
                self.assertEqual(f"{crc32c(samples.tobytes()):08x}", checksum)

    def test_every_file_is_sound(self):
        names = {line.split()[0] for line in (GOLDEN / "levels.txt").read_text().splitlines()}
        for name in ["minimal.8vo", *sorted(names)[::1 if IS_FULL_FORM else 5]]:
            with self.subTest(name), OctavoFile(GOLDEN / name) as file:
                verify(file)

    def test_the_start_weights_of_labels_are_those_of_the_registry(self):
        table = ROOT / "src" / "octavo" / "codec" / "label" / "label_start_weights.inc"
        numbers = [int(text) for text in table.read_text().split(",") if text.strip()]
        checksum = crc32c(bytes(number & 255 for number in numbers))
        self.assertIn(f"| {checksum:08x} |", (ROOT / "docs" / "registry.md").read_text())

    def test_files_of_other_versions_are_rejected_as_their_list_says(self):
        lines = [line.split() for line in (GOLDEN / "newer" / "kinds.txt").read_text().splitlines()]
        self.assertGreater(len(lines), 0)
        for name, kind in lines:
            with self.subTest(name), self.assertRaises(OctavoError) as rejection:
                OctavoFile(GOLDEN / "newer" / f"{name}.8vo")
            self.assertEqual(rejection.exception.kind, kind)

    def test_files_use_what_they_are_named_for(self):
        for name, uses in volumes.GOLDEN_USES.items():
            with self.subTest(name), OctavoFile(GOLDEN / f"{name}.8vo") as file:
                self.assertTrue(uses(file))


class Damage(InFolder):
    """Of a file with one byte changed or missing no wrong voxel comes out."""

    def read_all(self, data):
        """All levels, or None when the file is rejected."""
        path = self.folder / "damaged.8vo"
        path.write_bytes(data)
        try:
            with OctavoFile(path) as file:
                return [file.read_level(k).tobytes() for k in range(file.header.level_count)]
        except OctavoError:
            return None

    def test_a_changed_byte_is_rejected_or_changes_nothing(self):
        data = (GOLDEN / "minimal.8vo").read_bytes()
        sound = self.read_all(data)
        rejected = 0
        for at in range(len(data)):
            changed = self.read_all(data[:at] + bytes([data[at] ^ 1 << at % 8]) + data[at + 1 :])
            rejected += changed is None
            self.assertIn(changed, (None, sound), f"byte {at}")
        # The trailer of the slab is for repair and verification alone.
        with OctavoFile(GOLDEN / "minimal.8vo") as file:
            _, trailer_length = file.root.slab_trailers[0]
        self.assertEqual(rejected, len(data) - trailer_length)

    def test_every_truncation_is_rejected(self):
        data = (GOLDEN / "minimal.8vo").read_bytes()
        for length in range(len(data)):
            self.assertIsNone(self.read_all(data[:length]), f"{length} bytes")

    def test_changed_segments_and_models_are_rejected(self):
        for name in ("small-int16.8vo", "labels-uint8.8vo"):
            data = (GOLDEN / name).read_bytes()
            with OctavoFile(GOLDEN / name) as file:
                pages = file.header.pages.offset
                lengths = sum(length for brick in file.bricks(0) for _, length, _ in brick.pieces)
                planes = file.header.size[2]
            trailer = data.find(b"8slb")
            self.assertGreater(lengths, 0)
            for at in range(pages - lengths, pages, lengths // 20):
                changed = bytearray(data)
                changed[at] ^= 16
                is_in_trailer = trailer <= at < trailer + 64 + 32 * planes
                if not is_in_trailer:
                    self.assertIsNone(self.read_all(bytes(changed)), f"{name}, byte {at}")


class Claims(InFolder):
    """Lengths that a header claims, and metadata that are none; all checksums fit."""

    def rejected(self, data):
        path = self.folder / "claim.8vo"
        path.write_bytes(data)
        with self.assertRaises(OctavoError) as rejection, OctavoFile(path) as file:
            self.assertIsNotNone(file.metadata)
        self.assertEqual(rejection.exception.kind, "corrupt")
        return str(rejection.exception)

    def test_lengths_of_the_index_follow_from_the_size(self):
        data = (GOLDEN / "minimal.8vo").read_bytes()
        pages, root = (struct.unpack_from("<QQ", data, at) for at in (256, 280))
        for (begin, length), at, name in ((pages, 256, "pages"), (root, 280, "root")):
            for growth in (200, -length):
                end = begin + length
                changed = bytearray(data[:end] + bytes(max(growth, 0)) + data[end:])
                if growth < 0:
                    del changed[begin:end]
                for section in (232, 256, 280, 304):
                    offset, = struct.unpack_from("<Q", data, section)
                    behind = offset > begin or (offset == begin and section != at)
                    struct.pack_into("<Q", changed, section, offset + growth * behind)
                struct.pack_into("<Q", changed, at + 8, length + growth)
                struct.pack_into("<I", changed, at + 16,
                                 crc32c(bytes(changed[begin : end + growth])))
                struct.pack_into("<Q", changed, 224, len(changed))
                struct.pack_into("<I", changed, 508, crc32c(bytes(changed[:508])))
                self.assertIn(f"index {name} do", self.rejected(bytes(changed)))

    def test_metadata_that_are_no_json_object_are_rejected(self):
        data = (GOLDEN / "minimal.8vo").read_bytes()
        deep = b'{"a":' + b"[" * 100_000 + b"]" * 100_000 + b"}"
        for text in (b"", b"  ", b"not json", b"[1]", b"null", b'{"unit":"\xff\xfe"}', b"{} {}",
                     '{"a":1}'.encode("utf-16"), b'{"a":NaN}', b'{"a":"\\ud800"}', deep,
                     b'{"a":[' + b"1," * 65536 + b"1]}", b'{"a":"' + b"b" * 65537 + b'"}',
                     b'{"a":' + b"[" * 16 + b"]" * 16 + b"}"):
            self.assertIn("metadata", self.rejected(with_metadata(data, text)), text[:40])

    def test_metadata_within_the_limits_are_read(self):
        data = (GOLDEN / "minimal.8vo").read_bytes()
        for value in (b"1" * 5000, b'"' + b"[" * 65536 + b'"', b"[" + b"1," * 65533 + b"1]",
                      b"[" * 15 + b"]" * 15):
            text = b'{"a":' + value + b"} "
            (self.folder / "sound.8vo").write_bytes(with_metadata(data, text))
            with OctavoFile(self.folder / "sound.8vo") as file:
                self.assertEqual(list(file.metadata), ["a"])


class CommandLine(InFolder):
    def run_reader(self, *arguments, before=""):
        environment = {**os.environ, "PYTHONPATH": before + str(ROOT / "python")}
        return subprocess.run([sys.executable, "-m", "octavo_reader", *map(str, arguments)],
                              env=environment, capture_output=True, text=True, check=False)

    def test_a_level_becomes_an_array(self):
        path, out = GOLDEN / "small-int16.8vo", self.folder / "level.npy"
        self.assertEqual(self.run_reader(path, "--level", 3, "-o", out).returncode, 0)
        with OctavoFile(path) as file:
            self.assertTrue(np.array_equal(np.load(out), file.read_level(3)))

    def test_other_files_and_levels_are_rejected_in_one_line(self):
        for path, level, status in ((__file__, 0, 3), (GOLDEN / "minimal.8vo", 2, 2)):
            result = self.run_reader(path, "--level", level, "-o", self.folder / "out.npy")
            self.assertEqual((result.returncode, result.stderr.count("\n")), (status, 1),
                             result.stderr)

    def test_a_missing_numpy_is_named_in_one_line(self):
        text = "raise ModuleNotFoundError('No module named numpy', name='numpy')\n"
        (self.folder / "numpy.py").write_text(text)
        result = self.run_reader(GOLDEN / "small-int16.8vo", before=f"{self.folder}:")
        self.assertEqual((result.returncode, result.stderr.count("\n")), (1, 1), result.stderr)
        self.assertIn("NumPy is missing", result.stderr)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    OCTAVO = sys.argv.pop(1)
    unittest.main()
