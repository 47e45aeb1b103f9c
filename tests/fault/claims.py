#!/usr/bin/env python3
"""Files that claim much and hold little: what they cost is what is there.

usage: claims.py OCTAVO [unittest arguments]

Every verb is stopped in one of its forms, under tools/nightly in all of them.
Everything is generated. Memory and processor time are those of the program, so that no limit
depends on what else runs.
"""

import functools
import gzip
import os
import pathlib
import signal
import struct
import subprocess
import sys
import unittest
import zlib

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "support"))
import dicom_bytes  # pylint: disable=wrong-import-position
import processor_time  # pylint: disable=wrong-import-position
# pylint: disable-next=wrong-import-position
from file_bytes import TRAILER_LENGTH, ClaimedVolume, crc32c
from shared_folder import folder_of  # pylint: disable=wrong-import-position

OCTAVO = "octavo"
IS_FULL_FORM = "OCTAVO_NIGHTLY_SHARE" in os.environ
GOLDEN = ROOT / "tests" / "golden" / "v1"
MIB = 1 << 20
# A program that does nothing takes about 25 MiB.
SMALL_BYTES = 96 * MIB
SIDE = 4096


def is_odd(i, j, k):
    return (i + j + k) & 1


class InFolder(unittest.TestCase):
    """All tests of a class share a folder."""

    @classmethod
    def setUpClass(cls):
        cls.folder = folder_of(cls)

    def start(self, *arguments):
        return subprocess.Popen([OCTAVO, *arguments, "--progress", "none"], cwd=self.folder,
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)

    def outcome(self, process):
        """Exit code, what was said, and what was used."""
        said = process.stderr.read()
        process.stderr.close()
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        return process.returncode, said, used

    def write(self, name, data):
        (self.folder / name).parent.mkdir(exist_ok=True)
        (self.folder / name).write_bytes(data)

    def expect_cheap(self, code, words, *arguments):
        """An outcome with `words` in it, in little memory and time."""
        found, said, used = self.outcome(self.start(*arguments))
        self.assertEqual(found, code, said)
        for word in words:
            self.assertIn(word, said)
        self.assertLess(used.ru_maxrss * 1024, SMALL_BYTES, said)
        self.assertLess(used.ru_utime + used.ru_stime, 2, said)


class Lengths(InFolder):
    def sparse_file(self, section, length):
        """A file of 8 KiB on the disk whose header claims a section of `length` bytes."""
        data = bytearray((GOLDEN / "minimal.8vo").read_bytes())
        header, trailer = data[:512], data[-TRAILER_LENGTH:]
        sections = {at: list(struct.unpack_from("<QQ", header, at)) for at in (256, 304, 232, 280)}
        sections[section][1] = length
        at = sections[256][0]
        for field, (_, size) in sections.items():
            struct.pack_into("<QQ", header, field, at, size)
            at += size
        struct.pack_into("<Q", header, 224, at + TRAILER_LENGTH)
        struct.pack_into("<I", header, 508, crc32c(header[:508]))
        trailer[8:24] = header[216:232]
        trailer[24:28] = header[508:512]
        struct.pack_into("<I", trailer, 92, crc32c(trailer[:92]))
        with (self.folder / "sparse.8vo").open("wb") as file:
            file.write(header)
            file.seek(at)
            file.write(trailer)

    def test_an_index_that_no_volume_of_the_size_has_is_rejected_before_it_is_read(self):
        for section, name in ((280, "index root"), (256, "index pages")):
            self.sparse_file(section, 3 << 30)
            for verb in (["info"], ["verify"], ["repair", "-o", "out.8vo"],
                         ["export", "-o", "out.raw"], ["slice", "-o", "out.png"]):
                with self.subTest(section=name, verb=verb[0]):
                    self.expect_cheap(4, [name, "such a volume takes"], verb[0], "sparse.8vo",
                                      *verb[1:])

    def test_voxels_that_compressed_bytes_cannot_hold_are_rejected_before_memory_is_taken(self):
        side = 60000
        packed = zlib.compress(bytes(1000))
        self.write("scan.nrrd", b"NRRD0004\ntype: uint8\ndimension: 3\nencoding: gzip\n" +
                   f"sizes: {side} {side} 100\n\n".encode() + packed)
        self.write("scan.mha", f"NDims = 3\nDimSize = {side} {side} 100\n".encode() +
                   b"ElementType = MET_UCHAR\nCompressedData = True\nElementDataFile = LOCAL\n" +
                   packed)
        self.write("scan.png", png(side, packed))
        self.write("deflated.tif", tiff(8, side, packed))
        self.write("lzw.tif", tiff(5, side, b"\x80" * 100))
        self.write("packed.tif", tiff(32773, side, b"\x81\0" * 100))
        self.write("plain.tif", tiff(1, side, bytes(1000)))
        cannot = dict.fromkeys(("scan.nrrd", "scan.mha", "scan.png", "deflated.tif", "lzw.tif",
                                "packed.tif"), "cannot hold")
        for name, words in {**cannot, "plain.tif": "rows need 3600000000"}.items():
            with self.subTest(name):
                self.expect_cheap(7, [name, words], "build", name, "-o", "out.8vo")

    def write_slice(self, name, syntax, picture, side=60000, bits=16):
        self.write(name, dicom_bytes.compressed_slice(syntax, side, bits, picture))

    def test_frames_that_compressed_bytes_cannot_hold_are_rejected_before_memory_is_taken(self):
        d = dicom_bytes
        self.write_slice("runs.dcm", d.RUN_LENGTHS, d.run_lengths(51200))
        self.write_slice("jpeg.dcm", d.JPEG, d.jpeg(60000, 4000), bits=8)
        self.write_slice("lossless.dcm", d.JPEG_LOSSLESS, bytes(1000))
        self.write_slice("rows.dcm", d.JPEG_LS, d.jpeg_ls(60000, 1000))
        for name in ("runs.dcm", "jpeg.dcm", "lossless.dcm", "rows.dcm"):
            with self.subTest(name):
                self.expect_cheap(7, [name, "cannot hold"], "build", name, "-o", "out.8vo")

    def test_what_no_decoder_takes_costs_no_plane_of_the_claimed_size(self):
        d = dicom_bytes
        side = 40000
        pictures = {"none.dcm": (side, bytes(1000), "cannot be decoded"),
                    "cut.dcm": (side, d.jpeg_2000(side, 1000)[:60], "cannot be decoded"),
                    "other.dcm": (side, d.jpeg_2000(512, 1000), "512 x 512"),
                    "large.dcm": (60000, d.jpeg_2000(60000, 1000), "GDCM reads 4294967295")}
        for name, (claimed, picture, words) in pictures.items():
            self.write_slice(name, d.JPEG_2000, picture, claimed)
            self.write_slice("copy.dcm", d.JPEG_2000, picture, claimed)
            for line in (["build", name, "-o", "no.8vo"],
                         ["build", name, "-o", "no.8vo", "--no-isolation"],
                         ["build", name, "copy.dcm", "--drop-duplicates", "-o", "no.8vo"],
                         ["compare", name, name]):
                with self.subTest(" ".join(line)):
                    self.expect_cheap(7, [".dcm", words], *line)

    def test_pictures_compressed_as_far_as_can_be_are_read(self):
        d = dicom_bytes
        side = 4096
        for syntax, picture, bits in ((d.RUN_LENGTHS, d.run_lengths(side * side), 16),
                                      (d.JPEG, d.jpeg(side, side * side // 64), 8),
                                      (d.JPEG_LS, d.jpeg_ls(side, side), 16),
                                      (d.JPEG_2000, d.jpeg_2000(side, 100), 16)):
            with self.subTest(syntax):
                self.write_slice("scan.dcm", syntax, picture, side, bits)
                process = self.start("build", "scan.dcm", "-o", "small.8vo", "--force", "-q")
                code, said, _ = self.outcome(process)
                self.assertEqual(code, 0, said)

    def test_a_mosaic_of_millions_of_slices_is_rejected_before_they_are_listed(self):
        self.write("mosaic.dcm", mosaic(2048))
        self.expect_cheap(7, ["mosaic.dcm", "4194304 slices", "at most 4096"],
                          "build", "mosaic.dcm", "-o", "out.8vo")

    def test_millions_of_frames_are_rejected_before_they_are_listed(self):
        d = dicom_bytes
        frames = 1 << 21
        packed = d.compressed_frames(d.RUN_LENGTHS, 8, 16, frames, [bytes(64)])
        head = packed[:packed.index(b"\xe0\x7f\x10\x00OB")]
        self.write("packed.dcm", packed)
        self.write("plain.dcm", head.replace(d.RUN_LENGTHS.encode(), d.PLAIN.encode()) +
                   d.element(0x7fe00010, "OB", bytes(64)))
        for name, words in (("packed.dcm", "1 compressed fragment;"), ("plain.dcm", "64 bytes;")):
            with self.subTest(name):
                self.expect_cheap(7, [name, "2097152", words], "build", name, "-o", "out.8vo",
                                  "--spacing", "1,1,1")


def has_ended(process):
    """Whether it has, without asking what it used: it is said once."""
    flags = os.WEXITED | os.WNOHANG | os.WNOWAIT
    return os.waitid(os.P_PID, process.pid, flags) is not None


def let_run(process, seconds):
    """Returns once a process has used `seconds`, or has ended."""
    processor_time.wait_until(
        lambda: has_ended(process) or (processor_time.of_process(process) or 0) >= seconds)


def png(side, data):
    def chunk(kind, body):
        return (struct.pack(">I", len(body)) + kind + body +
                struct.pack(">I", zlib.crc32(kind + body)))

    head = struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", data) +
            chunk(b"IEND", b""))


def tiff(compression, side, data):
    data += bytes(len(data) & 1)
    fields = [(256, 4, side), (257, 4, side), (258, 3, 8), (259, 3, compression), (262, 3, 1),
              (273, 4, 8), (277, 3, 1), (278, 4, side), (279, 4, len(data))]
    listed = b"".join(struct.pack("<HHII", tag, kind, 1, value) for tag, kind, value in fields)
    return (b"II*\0" + struct.pack("<I", 8 + len(data)) + data +
            struct.pack("<H", len(fields)) + listed + bytes(4))


def mosaic(side):
    """A DICOM picture of side x side voxels that says it has as many slices."""
    def element(group, number, kind, value):
        value += bytes(len(value) & 1)
        length = struct.pack("<xxI" if kind == "OB" else "<H", len(value))
        return struct.pack("<HH", group, number) + kind.encode() + length + value

    def entry(name, *values):
        head = struct.pack("<64si4s3i", name.encode(), len(values), b"DS", 3, len(values), 77)
        return head + b"".join(struct.pack("<4i", 8, 8, 77, 8) + value.encode().ljust(8, b"\0")
                               for value in values)

    header = (b"SV10\4\3\2\1" + struct.pack("<2i", 2, 77) +
              entry("NumberOfImagesInMosaic", str(side * side)) +
              entry("SliceNormalVector", "0", "0", "1"))
    numbers = [(2, 1), (0x10, side), (0x11, side), (0x100, 8), (0x101, 8), (0x102, 7), (0x103, 0)]
    return bytes(128) + b"DICM" + b"".join(
        [element(2, 0x10, "UI", b"1.2.840.10008.1.2.1"),
         element(8, 8, "CS", b"ORIGINAL\\PRIMARY\\M\\MOSAIC"),
         element(0x18, 0x88, "DS", b"3"),
         element(0x20, 0x32, "DS", b"0\\0\\0"),
         element(0x20, 0x37, "DS", b"1\\0\\0\\0\\1\\0"),
         element(0x28, 0x30, "DS", b"1\\1")] +
        [element(0x28, number, "US", struct.pack("<H", value)) for number, value in numbers] +
        [element(0x28, 4, "CS", b"MONOCHROME2"),
         element(0x29, 0x11, "LO", b"SIEMENS CSA HEADER"),
         element(0x29, 0x1110, "OB", header),
         element(0x7fe0, 0x10, "OB", bytes(2))])


@functools.cache
def claimed_volumes():
    """The bytes of volumes of 4096 x 4096 x 4096 voxels in 800 kB, by the names of their files."""
    grey = (GOLDEN / "minimal.8vo").read_bytes()
    labels = (GOLDEN / "labels-uint8.8vo").read_bytes()
    size = (SIDE, SIDE, SIDE)
    files = {
        "g.8vo": ClaimedVolume(size, lambda i, j, k: 50 * is_odd(i, j, k), grey),
        "flat.8vo": ClaimedVolume(size, lambda i, j, k: 0, grey),
        "l.8vo": ClaimedVolume(size, is_odd, labels),
        "long.8vo": ClaimedVolume((1 << 21, 64, 64), is_odd, labels),
    }
    return {name: volume.bytes() for name, volume in files.items()}


class Volumes(InFolder):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        for name, data in claimed_volumes().items():
            (cls.folder / name).write_bytes(data)


class Limits(Volumes):
    def expect_limit(self, words, *arguments):
        code, said, used = self.outcome(self.start(*arguments))
        self.assertEqual(code, 6, said)
        for word in words:
            self.assertIn(word, said)
        self.assertLess(used.ru_utime + used.ru_stime, 1, said)
        self.assertEqual(list(self.folder.glob("o*")), [])

    def test_a_picture_that_no_png_holds_is_rejected_before_a_voxel_is_read(self):
        for axis in ("y", "z", "all"):
            with self.subTest(axis):
                self.expect_limit(["2097152 pixels", "coarser level"],
                                  "slice", "long.8vo", "--axis", axis, "-o", "o.png")

    def test_no_verb_reads_or_makes_more_voxels_than_asked(self):
        words = ["4096 x 4096 x 4096 voxels; the limit is 1000000000; raise --max-voxels"]
        for line in Work.VERBS:
            if line.startswith("verify"):
                continue
            with self.subTest(line):
                self.expect_limit(words, *line.split(), "--max-voxels", "1e9")
        self.expect_limit(["limit is 1000; raise"], "phantom", "--size", "64",
                          "-o", "o.8vo", "--max-voxels", "1000")
        self.write("v.raw", bytes(1000))
        layout = ["v.raw", "--raw", "10,10,10,uint8", "--spacing", "1,1,1"]
        self.expect_limit(["limit is 999; raise"], "build", *layout, "-o", "o.8vo",
                          "--max-voxels", "999")
        process = self.start("build", *layout, "-o", "small.8vo", "--max-voxels", "1000", "-q")
        self.assertEqual(self.outcome(process)[:2], (0, ""))
        self.expect_limit(["20 x 20 x 20 voxels; the limit is 1000"], "transform", "small.8vo",
                          "--scale", "2", "-o", "o.8vo", "--max-voxels", "1000")

    def test_what_reads_no_voxel_and_what_proves_all_bytes_has_no_such_limit(self):
        for verb in ("info", "verify"):
            process = self.start(verb, "flat.8vo", "--max-voxels", "1", "-q")
            self.assertEqual(self.outcome(process)[:2], (0, ""))


class Work(Volumes):
    VERBS = [
        "verify g.8vo", "verify g.8vo --against l.8vo",
        "export g.8vo -o o.raw", "export g.8vo -o o.nii.gz", "export g.8vo -o o.tif",
        "export g.8vo -o o/", "export g.8vo --salvage coarse -o o.nrrd",
        "extract g.8vo --box :,:,0:2000 -o o.mha",
        "slice g.8vo --axis z -o o.png", "slice g.8vo --axis all --overlay l.8vo -o o.png",
        "render l.8vo -o o.png", "render g.8vo --range 10: --mode surface -o o.png",
        "render g.8vo --range 10: --mode transparency -o o.png",
        "compare g.8vo l.8vo", "compare l.8vo l.8vo --labels",
        "codes l.8vo --list", "codes g.8vo --range 10:", "condense g.8vo --flat 1 -o o.8vo",
        "threshold g.8vo --range 10: -o o.8vo", "combine l.8vo l.8vo --union -o o.8vo",
        "components l.8vo", "components l.8vo -o o.8vo", "measure l.8vo",
        "measure l.8vo --of l.8vo",
        "touch l.8vo l.8vo", "fill-holes l.8vo -o o.8vo", "dilate l.8vo --voxels 2 -o o.8vo",
        "erode l.8vo --voxels 2 -o o.8vo", "open l.8vo --voxels 2 -o o.8vo",
        "close l.8vo --mm 2 -o o.8vo", "shell l.8vo -o o.8vo",
        "transform g.8vo --rotate z:90 -o o.8vo", "transform l.8vo --mirror x -o o.8vo",
        "transform g.8vo --scale 2 -o o.8vo", "build g.8vo -o o.8vo",
        "build g.8vo --max-error 2 -o o.8vo",
    ]

    def test_a_signal_ends_every_verb_within_2_seconds_of_processor_time(self):
        stopped = set()
        first_lines = {line.split()[0]: line for line in reversed(self.VERBS)}
        lines = self.VERBS if IS_FULL_FORM else sorted(first_lines.values())
        for number, line in enumerate(lines):
            asked = signal.SIGTERM if number % 2 == 0 else signal.SIGINT
            process = self.start(*line.split(), "--force")
            let_run(process, 0.7 if IS_FULL_FORM else 0.4)
            before = processor_time.of_process(process) or 0
            os.kill(process.pid, asked)
            code, said, used = self.outcome(process)
            with self.subTest(line):
                self.assertIn(code, (0, 1, 2, 128 + asked), said)
                after = used.ru_utime + used.ru_stime - before
                self.assertLess(after, 2, f"{after:.1f} s after the signal")
                if code == 128 + asked:
                    stopped.add(line.split()[0])
                    left = sorted(p.name for p in self.folder.glob("[.o]*"))
                    self.assertEqual(left, [], "what is left behind")
            subprocess.run(["rm", "-rf", *self.folder.glob("[.o]*")], check=True)
        # Verbs that are done by then show nothing.
        self.assertGreaterEqual(len(stopped), 12, stopped)

    def expect_end_by_signal(self, process):
        """Ends in the midst of its work, soon, and leaves nothing behind."""
        let_run(process, 0.4)
        before = processor_time.of_process(process) or 0
        os.kill(process.pid, signal.SIGTERM)
        code, said, used = self.outcome(process)
        self.assertEqual(code, 128 + signal.SIGTERM, said)
        self.assertLess(used.ru_utime + used.ru_stime - before, 2)
        self.assertEqual(list(self.folder.glob("[.o]*")), [], "what is left behind")

    def test_a_signal_ends_the_choice_of_a_type_for_numbers_of_64_bits(self):
        with (self.folder / "zeros.raw").open("wb") as file:
            file.truncate(8 * 1024 * 1024 * 4096)
        process = self.start("build", "zeros.raw", "--raw", "1024,1024,4096,float64",
                             "--spacing", "1,1,1", "-o", "o.8vo")
        self.expect_end_by_signal(process)

    def test_a_signal_ends_the_inflation_of_what_is_read_to_prove_its_length(self):
        member = gzip.compress(bytes(64 * MIB))
        (self.folder / "zeros.gz").write_bytes(member * 128)
        self.write("zeros.nhdr", b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2048 2048 2048\n"
                   b"spacings: 1 1 1\nencoding: gzip\ndata file: zeros.gz\n")
        process = self.start("build", "zeros.nhdr", "-o", "o.8vo")
        self.expect_end_by_signal(process)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    OCTAVO = os.path.abspath(sys.argv.pop(1))
    unittest.main()
