#!/usr/bin/env python3
"""Runs the program as a user does and checks exit codes, messages, files.

usage: cli_test.py OCTAVO [unittest arguments]

A test's name states a law. Everything is generated; nothing but the standard library is needed.
"""

import array
import json
import math
import os
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
import processor_time  # pylint: disable=wrong-import-position

OCTAVO = "octavo"


def run(*arguments, cwd=None, **options):
    command = [OCTAVO, *map(str, arguments)]
    return subprocess.run(
        command, cwd=cwd, capture_output=True, text=True, check=False, **options
    )


class InFolder(unittest.TestCase):
    """Each test works in a fresh folder."""

    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)

    def octavo(self, *arguments, **options):
        return run(*arguments, cwd=self.folder, **options)

    def expect(self, code, *arguments, **options):
        result = self.octavo(*arguments, **options)
        self.assertEqual(result.returncode, code, f"{arguments}\n{result.stderr}")
        return result

    def expect_error(self, code, words, *arguments):
        """One line on standard error, with `words` in it, and nothing on standard output."""
        result = self.expect(code, *arguments, "--progress", "none")
        self.assertEqual(result.stdout, "")
        self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
        self.assertTrue(result.stderr.startswith("octavo: "), result.stderr)
        for word in words:
            self.assertIn(word, result.stderr)
        return result

    def info(self, name):
        return json.loads(self.expect(0, "info", name, "--json").stdout)

    def files(self):
        return sorted(p.name for p in self.folder.rglob("*"))

    def random_raw(self, name, size, code="h", top=1000):
        numbers = random.Random(3)
        count = size[0] * size[1] * size[2]
        voxels = array.array(code, (numbers.randrange(top) for _ in range(count)))
        (self.folder / name).write_bytes(voxels.tobytes())
        return f"{size[0]},{size[1]},{size[2]},{'int16' if code == 'h' else 'uint8'}"


class Usage(InFolder):
    def test_usage_errors_are_exit_2_and_point_to_the_help(self):
        table = [
            (),
            ("fold",),
            ("build",),
            ("build", "a.raw"),
            ("info", "a.8vo", "--no-such-option"),
            ("build", "a", "-o", "b.8vo", "--threads", "0"),
            ("build", "a", "-o", "b.8vo", "--max-memory", "lots"),
            ("build", "a", "-o", "b.8vo", "--labels", "--grey"),
            ("build", "a", "-o", "b.8vo", "--spacing", "1,0,1"),
            ("phantom", "-o", "p.8vo", "--size", "1,2"),
            ("phantom", "-o", "p.8vo", "--type", "float32"),
            ("extract", "a.8vo", "-o", "b.nrrd"),
        ]
        for arguments in table:
            with self.subTest(arguments):
                self.expect_error(2, [], *arguments)
        self.assertEqual(self.files(), [])

    def test_every_verb_explains_itself_with_an_example(self):
        main = self.expect(0, "--help").stdout
        self.assertIn("7 source rejected, or a warning under\n--strict;", main)
        for verb in ["build", "info", "verify", "export", "extract", "slice", "probe", "compare",
                     "codes", "phantom", "repair", "transform"]:
            self.assertIn(verb, main)
            self.assertIn(f"octavo {verb}", self.expect(0, verb, "--help").stdout)

    def test_json_failure_is_one_object_on_standard_error(self):
        result = self.expect(5, "info", "missing.8vo", "--json")
        self.assertEqual(result.stdout, "")
        error = json.loads(result.stderr.splitlines()[-1])["error"]
        self.assertEqual(error["kind"], "io")
        self.assertEqual(error["path"], "missing.8vo")
        self.assertEqual(error["exit_code"], 5)


class BadFiles(InFolder):
    def setUp(self):
        super().setUp()
        self.expect(0, "phantom", "--size", "20", "-o", "good.8vo", "-q")

    def test_what_is_no_octavo_file_is_exit_3(self):
        (self.folder / "text.8vo").write_text("this is no scan, but it is long enough " * 40)
        (self.folder / "empty.8vo").write_bytes(b"")
        self.expect_error(3, ["text.8vo"], "info", "text.8vo")
        result = self.octavo("info", "empty.8vo")
        self.assertIn(result.returncode, (3, 4))

    def test_a_missing_file_is_exit_5(self):
        for verb in ["info", "verify", "codes"]:
            self.expect_error(5, ["missing.8vo"], verb, "missing.8vo")

    def test_damage_is_exit_4_in_every_verb(self):
        whole = (self.folder / "good.8vo").read_bytes()
        (self.folder / "short.8vo").write_bytes(whole[:-10])
        flipped = bytearray(whole)
        flipped[600] ^= 8
        (self.folder / "flip.8vo").write_bytes(flipped)
        for verb in ["info", "verify"]:
            self.expect_error(4, ["short.8vo"], verb, "short.8vo")
        self.expect_error(4, ["flip.8vo"], "verify", "flip.8vo")
        self.expect_error(4, ["flip.8vo"], "export", "flip.8vo", "-o", "out.raw")
        self.assertNotIn("out.raw", self.files())

    def test_an_existing_output_is_kept_without_force(self):
        before = (self.folder / "good.8vo").read_bytes()
        rejected = self.expect_error(5, ["good.8vo"], "phantom", "--size", "9", "-o", "good.8vo")
        self.assertIn("force", rejected.stderr)
        self.assertEqual((self.folder / "good.8vo").read_bytes(), before)
        self.expect(0, "phantom", "--size", "9", "-o", "good.8vo", "-f")
        self.assertEqual(self.info("good.8vo")["size"], [9, 9, 9])

    def test_places_outside_the_volume_are_exit_2(self):
        table = [
            ("probe", "good.8vo", "--at", "20,0,0"),
            ("probe", "good.8vo", "--at", "-1,0,0"),
            ("probe", "good.8vo", "--mm", "1e6,0,0"),
            ("probe", "good.8vo"),
            ("extract", "good.8vo", "--box", "0:21,:,:", "-o", "b.raw"),
            ("extract", "good.8vo", "--box", "5:5,:,:", "-o", "b.raw"),
            ("extract", "good.8vo", "--level", "99", "-o", "b.raw"),
            ("export", "good.8vo", "-o", "b.unknown"),
            ("slice", "good.8vo", "--index", "20", "-o", "b.png"),
            ("slice", "good.8vo", "--window", "brian", "-o", "b.png"),
            ("codes", "good.8vo"),
        ]
        for arguments in table:
            with self.subTest(arguments):
                self.expect_error(2, [], *arguments)
        self.assertEqual(self.files(), ["good.8vo"])

    @unittest.skipUnless(os.path.exists("/dev/full"), "needs /dev/full")
    def test_a_full_disk_under_standard_output_is_exit_5(self):
        with open("/dev/full", "w", encoding="utf-8") as full:
            result = subprocess.run([OCTAVO, "info", "good.8vo"], cwd=self.folder, stdout=full,
                                    stderr=subprocess.PIPE, text=True, check=False)
        self.assertEqual(result.returncode, 5)
        self.assertIn("standard output", result.stderr)

    def test_a_closed_pipe_is_exit_5(self):
        reading, writing = os.pipe()
        os.close(reading)
        result = subprocess.run([OCTAVO, "info", "good.8vo"], cwd=self.folder, stdout=writing,
                                stderr=subprocess.PIPE, text=True, check=False)
        os.close(writing)
        self.assertEqual(result.returncode, 5)


class BadSources(InFolder):
    def test_unfit_raw_is_exit_7_and_leaves_no_file(self):
        layout = self.random_raw("v.raw", (10, 9, 8))
        (self.folder / "short.raw").write_bytes((self.folder / "v.raw").read_bytes()[:-1])
        (self.folder / "empty.raw").write_bytes(b"")
        before = self.files()
        for name in ["short.raw", "empty.raw"]:
            self.expect_error(7, [name], "build", name, "--raw", layout, "--spacing", "1", "-o",
                              "x.8vo")
        self.assertEqual(self.files(), before)

    def test_what_is_no_scan_is_exit_7_and_leaves_no_file(self):
        (self.folder / "not.nii.gz").write_text("hello")
        (self.folder / "not.nrrd").write_text("hello")
        (self.folder / "empty.dcm").write_bytes(b"")
        (self.folder / "nothing").mkdir()
        (self.folder / "dangling.mhd").write_text(
            "NDims = 3\nDimSize = 2 2 2\nElementType = MET_SHORT\nElementDataFile = gone.raw\n")
        before = self.files()
        for name in ["not.nii.gz", "not.nrrd", "empty.dcm", "nothing"]:
            with self.subTest(name):
                self.expect_error(7, [name], "build", name, "-o", "x.8vo")
        self.assertIn(self.octavo("build", "dangling.mhd", "-o", "x.8vo").returncode, (5, 7))
        self.assertIn(self.octavo("build", "missing.mhd", "-o", "x.8vo").returncode, (5, 7))
        self.assertEqual(self.files(), before)

    def test_strict_makes_a_warning_an_error(self):
        layout = self.random_raw("v.raw", (10, 9, 8))
        warned = self.expect(0, "build", "v.raw", "--raw", layout, "-o", "a.8vo")
        self.assertIn("octavo: warning:", warned.stderr)
        self.expect_error(7, ["--strict"], "build", "v.raw", "--raw", layout, "-o", "b.8vo",
                          "--strict")
        self.assertNotIn("b.8vo", self.files())


class Outputs(InFolder):
    def test_a_build_writes_8vo_files_only(self):
        layout = self.random_raw("v.raw", (10, 9, 8))
        for name in ["out.nrrd", "out", "out.8VO.raw"]:
            self.expect_error(2, [name, ".8vo"], "build", "v.raw", "--raw", layout, "-o", name)
        self.assertEqual(self.files(), ["v.raw"])

    def test_a_build_rejects_an_output_that_is_its_input(self):
        layout = self.random_raw("v.raw", (10, 9, 8))
        before = (self.folder / "v.raw").read_bytes()
        os.link(self.folder / "v.raw", self.folder / "same.8vo")
        os.symlink("v.raw", self.folder / "link.8vo")
        for name in ["same.8vo", "link.8vo"]:
            self.expect_error(2, [name, "input itself"], "build", "v.raw", "--raw", layout,
                              "--spacing", "1", "-o", name, "--force")
        self.assertEqual((self.folder / "v.raw").read_bytes(), before)
        self.expect(0, "build", "v.raw", "--raw", layout, "--spacing", "1", "-o", "v.8vo")
        before = (self.folder / "v.8vo").read_bytes()
        os.link(self.folder / "v.8vo", self.folder / "hard.8vo")
        os.symlink("v.8vo", self.folder / "soft.8vo")
        for name in ["v.8vo", "./v.8vo", "hard.8vo", "soft.8vo"]:
            self.expect_error(2, [name, "itself"], "build", "v.8vo", "--force", "-o", name)
            self.expect_error(2, [name, "itself"], "condense", "v.8vo", "--flat", "1", "--force",
                              "-o", name)
        self.assertEqual((self.folder / "v.8vo").read_bytes(), before)


class RoundTrips(InFolder):
    def test_raw_in_raw_out_is_identity(self):
        for size in [(1, 1, 1), (1, 7, 1), (65, 65, 65), (130, 3, 2), (17, 31, 70)]:
            with self.subTest(size):
                layout = self.random_raw("v.raw", size)
                source = ["v.raw", "--raw", layout, "--spacing", "0.5"]
                self.expect(0, "build", *source, "-o", "v.8vo", "-f")
                self.expect(0, "verify", "v.8vo", "--against", *source)
                self.expect(0, "export", "v.8vo", "-o", "back.raw", "-f")
                self.assertEqual((self.folder / "back.raw").read_bytes(),
                                 (self.folder / "v.raw").read_bytes())

    def test_the_file_does_not_depend_on_threads(self):
        files = []
        for threads in [1, 2, 3, 8]:
            self.expect(0, "phantom", "--size", "70,80,90", "--noise", "5", "-j", threads,
                        "-o", f"{threads}.8vo")
            files.append((self.folder / f"{threads}.8vo").read_bytes())
        self.assertEqual(len(set(files)), 1)

    def test_exported_volumes_compare_equal_to_their_file(self):
        self.expect(0, "phantom", "--size", "40,50,30", "--noise", "9", "--spacing", "0.5,0.5,1.25",
                    "-o", "p.8vo")
        for name in ["p.nrrd", "p.nii", "p.nii.gz", "p.mha", "p.mhd"]:
            with self.subTest(name):
                self.expect(0, "export", "p.8vo", "-o", name)
                result = self.expect(0, "compare", "p.8vo", name, "--json")
                self.assertTrue(json.loads(result.stdout)["equal"])

    def test_a_difference_is_exit_1_with_its_place(self):
        layout = self.random_raw("a.raw", (12, 11, 10))
        voxels = array.array("h", (self.folder / "a.raw").read_bytes())
        voxels[5 + 12 * (6 + 11 * 7)] += 3
        (self.folder / "b.raw").write_bytes(voxels.tobytes())
        source = ["--raw", layout, "--spacing", "1"]
        self.expect(0, "build", "a.raw", *source, "-o", "a.8vo")
        for command in [("verify", "a.8vo", "--against", "b.raw"), ("compare", "a.8vo", "b.raw")]:
            result = self.expect(1, *command, *source, "--json")
            found = json.loads(result.stdout)
            found = found.get("against", found)
            self.assertEqual(found["different"], 1)
            self.assertEqual(found["max_difference"], 3)
            self.assertEqual(found["first"]["index"], [5, 6, 7])
        self.assertIn("5,6,7", self.expect(1, "compare", "a.8vo", "b.raw", *source).stdout)

    def test_a_box_equals_the_crop(self):
        layout = self.random_raw("v.raw", (20, 19, 18))
        self.expect(0, "build", "v.raw", "--raw", layout, "--spacing", "1", "-o", "v.8vo")
        self.expect(0, "extract", "v.8vo", "--box", "3:9,:,10:12", "-o", "box.raw")
        voxels = array.array("h", (self.folder / "v.raw").read_bytes())
        crop = array.array("h", (voxels[x + 20 * (y + 19 * z)]
                                 for z in range(10, 12) for y in range(19) for x in range(3, 9)))
        self.assertEqual((self.folder / "box.raw").read_bytes(), crop.tobytes())
        self.expect(0, "extract", "v.8vo", "--box-mm=3:8,0:18,10:11", "-o", "mm.raw")
        self.assertEqual((self.folder / "mm.raw").read_bytes(), crop.tobytes())


class Floats(InFolder):
    SIZE = (20, 19, 18)

    def raw_floats(self, name, values):
        (self.folder / name).write_bytes(array.array("f", values).tobytes())
        return [name, "--raw", ",".join(map(str, self.SIZE)) + ",float32", "--spacing", "0.5"]

    def tenths(self):
        numbers = random.Random(4)
        return [numbers.randrange(-500, 900) * 0.1 for _ in range(20 * 19 * 18)]

    def noise(self):
        numbers = random.Random(4)
        return [numbers.gauss(0, 50) for _ in range(20 * 19 * 18)]

    def test_scaled_integers_are_lossless(self):
        source = self.raw_floats("v.raw", self.tenths())
        self.expect(0, "build", *source, "-o", "v.8vo")
        info = self.info("v.8vo")
        self.assertEqual(info["type"], "float32")
        self.assertEqual(info["coding"],
                         {"type": "int32", "scale": 0.1, "offset": 0.0, "exact": True})
        self.assertTrue(info["lossless"])
        self.expect(0, "verify", "v.8vo", "--against", *source)
        self.expect(0, "export", "v.8vo", "-o", "back.raw")
        self.assertEqual((self.folder / "back.raw").read_bytes(),
                         (self.folder / "v.raw").read_bytes())

    def test_every_format_carries_floats_there_and_back(self):
        self.expect(0, "build", *self.raw_floats("v.raw", self.tenths()), "-o", "v.8vo")
        for name in ["v.nrrd", "v.nii", "v.nii.gz", "v.mha", "v.mhd", "v.tif", "stack/"]:
            with self.subTest(name):
                if name == "v.mhd":
                    (self.folder / "v.raw").unlink()
                self.expect(0, "export", "v.8vo", "-o", name)
                self.expect(0, "build", name, "--spacing", "0.5", "-o", "again.8vo", "-f")
                self.assertEqual(self.info("again.8vo")["type"], "float32")
                self.expect(0, "export", "again.8vo", "-o", "again.raw", "-f")
                self.expect(0, "export", "v.8vo", "-o", "first.raw", "-f")
                self.assertEqual((self.folder / "again.raw").read_bytes(),
                                 (self.folder / "first.raw").read_bytes())

    def test_big_endian_floats_are_read(self):
        values = array.array("f", self.tenths())
        source = self.raw_floats("v.raw", values)
        values.byteswap()
        swapped = self.raw_floats("b.raw", [])
        (self.folder / "b.raw").write_bytes(values.tobytes())
        swapped[2] += ":be"
        self.expect(0, "build", *swapped, "-o", "b.8vo")
        self.expect(0, "verify", "b.8vo", "--against", *source)

    def test_noise_and_what_is_no_number_come_back_bit_by_bit(self):
        values = self.noise()
        values[0] = values[3 + 20 * (4 + 19 * 5)] = float("nan")
        values[7:9] = [float("inf"), float("-inf")]
        values[20] = -0.0
        source = self.raw_floats("v.raw", values)
        self.expect(0, "build", *source, "-o", "v.8vo")
        self.expect(0, "verify", "v.8vo", "--against", *source)
        self.expect(0, "compare", "v.8vo", *source)
        self.expect(0, "export", "v.8vo", "-o", "back.raw")
        self.assertEqual((self.folder / "back.raw").read_bytes(),
                         (self.folder / "v.raw").read_bytes())
        info = self.info("v.8vo")
        self.assertTrue(info["lossless"])
        self.assertTrue(info["coding"]["exact"])
        finite = [v for v in array.array("f", values) if math.isfinite(v)]
        self.assertLessEqual(info["min"], min(finite))
        self.assertGreaterEqual(info["max"], max(finite))
        self.assertLess(info["max"], 2 * max(finite))
        self.assertIn("lossless", self.expect(0, "info", "v.8vo").stdout)
        self.expect(0, "slice", "v.8vo", "-o", "v.png")

    def test_what_is_no_number_lies_in_no_range_and_enters_no_mean(self):
        values = self.noise()
        values[40:60] = [float("nan")] * 20
        values[7:9] = [float("inf"), float("-inf")]
        source = self.raw_floats("v.raw", values)
        self.expect(0, "build", *source, "-o", "v.8vo")
        finite = [v for v in array.array("f", values) if math.isfinite(v)]
        self.expect(0, "threshold", "v.8vo", "--range", "-1e9:", "-o", "all.8vo")
        mask = json.loads(self.expect(0, "codes", "all.8vo", "--json").stdout)
        self.assertEqual(mask["voxels"], len(finite))
        (self.folder / "ones.raw").write_bytes(bytes([1]) * len(values))
        self.expect(0, "build", "ones.raw", "--raw", "20,19,18,uint8", "--spacing", "0.5",
                    "--labels", "-o", "ones.8vo")
        found = json.loads(self.expect(0, "measure", "ones.8vo", "--of", "v.8vo", "--json").stdout)
        region = found["objects"][0]
        self.assertEqual(region["voxels"], len(values))
        self.assertAlmostEqual(region["mean"], sum(finite) / len(finite), delta=1e-5)
        self.assertEqual([region["min"], region["max"]], [min(finite), max(finite)])
        self.assertEqual(region["percentiles"]["50"],
                         sorted(finite)[math.ceil(len(finite) / 2) - 1])
        self.assertIn("22 of the voxels measured are NaN or infinite", found["warnings"][0])

    def test_noise_within_a_max_error_says_how_far_it_is(self):
        source = self.raw_floats("n.raw", self.noise())
        error = "12"
        self.expect(0, "build", *source, "-o", "n.8vo", "--max-error", error)
        self.expect(0, "verify", "n.8vo", "--against", *source)
        self.expect(0, "compare", "n.8vo", *source, "--max-error", error)
        self.expect(1, "compare", "n.8vo", *source)
        info = self.info("n.8vo")
        self.assertEqual(info["max_error"], float(error))
        self.assertLessEqual(info["achieved_error"], info["max_error"])
        self.assertFalse(info["lossless"])
        self.assertEqual(info["metadata"]["coding"]["max_error"], float(error))
        self.assertIn("promised", self.expect(0, "info", "n.8vo").stdout)
        point = json.loads(self.expect(0, "probe", "n.8vo", "--at", "3,4,5", "--json").stdout)
        self.assertAlmostEqual(point["points"][0]["stored"], self.noise()[3 + 20 * (4 + 19 * 5)],
                               delta=float(error))
        self.expect(0, "slice", "n.8vo", "-o", "n.png")
        mask = json.loads(self.expect(0, "codes", "n.8vo", "--range", "0:", "--json").stdout)
        self.assertTrue(0 < mask["voxels"] < 20 * 19 * 18)

    def test_what_is_no_number_is_counted_or_replaced(self):
        values = self.tenths()
        values[3 + 20 * (4 + 19 * 5)] = float("nan")
        values[0] = values[-1] = float("inf")
        source = self.raw_floats("v.raw", values)
        self.expect_error(7, ["1 NaN and 2 infinite", "0,0,0"], "build", *source, "-o", "v.8vo",
                          "--max-error", "0.5")
        self.expect_error(7, ["2 infinite", "--inf"], "build", *source, "-o", "v.8vo",
                          "--nan", "0", "--max-error", "0.5")
        self.expect(0, "build", *source, "-o", "v.8vo", "--nan", "0", "--inf", "99.9")
        self.assertEqual(self.info("v.8vo")["max"], array.array("f", [99.9])[0])
        self.expect(0, "verify", "v.8vo", "--against", *source)

    def test_a_copy_of_a_lossy_file_is_not_called_lossless(self):
        source = self.raw_floats("n.raw", self.noise())
        self.expect(0, "build", *source, "-o", "n.8vo", "--max-error", "1")
        self.expect(0, "build", "n.8vo", "-o", "copy.8vo")
        self.expect(0, "verify", "copy.8vo", "--against", "n.8vo")
        info = self.info("copy.8vo")
        self.assertTrue(info["source_lossy"])
        self.assertEqual(info["metadata"]["source_max_error"], self.info("n.8vo")["achieved_error"])
        self.assertNotIn("coding", info["metadata"])
        self.assertNotIn("lossless", self.expect(0, "info", "copy.8vo").stdout)

    def test_options_that_make_no_sense_are_exit_2(self):
        source = self.raw_floats("v.raw", self.tenths())
        for wrong in [("--max-error", "-1"), ("--max-error", "much"), ("--labels",),
                      ("--preset", "tiny"), ("--nan", "nan"), ("--inf", "1e39"),
                      ("--labels", "--max-error", "1")]:
            with self.subTest(wrong):
                self.expect_error(2, [], "build", *source, "-o", "v.8vo", *wrong)
        self.assertEqual(self.files(), ["v.raw"])


class MaxErrors(InFolder):
    def test_integers_stay_within_whole_steps(self):
        layout = self.random_raw("v.raw", (70, 19, 18))
        source = ["v.raw", "--raw", layout, "--spacing", "0.5"]
        for preset in ["small", "fast"]:
            self.expect(0, "build", *source, "-o", "v.8vo", "--max-error", "3.7", "--preset",
                        preset, "-f")
            info = self.info("v.8vo")
            self.assertEqual(info["max_error"], 3)
            self.assertLessEqual(info["achieved_error"], 3)
            self.expect(0, "verify", "v.8vo", "--against", *source)
            self.expect(0, "compare", "v.8vo", *source, "--max-error", "3")
            for name in ["v.nrrd", "v.nii.gz"]:
                self.expect(0, "export", "v.8vo", "-o", name, "-f")
                self.expect(0, "compare", "v.8vo", name)

    def test_an_error_below_one_step_is_told_to_be_lossless(self):
        layout = self.random_raw("v.raw", (20, 19, 18))
        told = self.expect(0, "build", "v.raw", "--raw", layout, "--spacing", "1", "-o", "v.8vo",
                           "--max-error", "0.5")
        self.assertIn("without loss", told.stderr)
        self.assertTrue(self.info("v.8vo")["lossless"])

    def test_the_largest_difference_is_told(self):
        layout = self.random_raw("a.raw", (12, 11, 10))
        voxels = array.array("h", (self.folder / "a.raw").read_bytes())
        voxels[9] += 3
        (self.folder / "b.raw").write_bytes(voxels.tobytes())
        source = ["--raw", layout, "--spacing", "1"]
        self.expect(0, "compare", "a.raw", "b.raw", *source, "--max-error", "3")
        told = self.expect(0, "compare", "a.raw", "b.raw", *source, "--tolerance", "4", "--json")
        self.assertEqual(json.loads(told.stdout)["max_difference"], 3)
        self.expect(1, "compare", "a.raw", "b.raw", *source, "--max-error", "2.9")


class Results(InFolder):
    def test_info_json_has_the_promised_keys(self):
        self.expect(0, "phantom", "--size", "40,30,70", "-o", "p.8vo", "-q")
        info = self.info("p.8vo")
        for key in ["kind", "type", "size", "spacing_mm", "origin_mm", "direction", "rescale",
                    "levels", "file_bytes", "raw_bytes", "ratio", "bits_per_voxel", "max_error",
                    "min", "max", "metadata"]:
            self.assertIn(key, info)
        self.assertEqual(info["size"], [40, 30, 70])
        self.assertEqual(info["raw_bytes"], 40 * 30 * 70 * 2)
        self.assertEqual(info["file_bytes"], (self.folder / "p.8vo").stat().st_size)
        self.assertEqual(set(info["levels"][0]),
                         {"level", "size", "spacing_mm", "bricks", "uniform_bricks", "bytes"})

    def test_info_fits_one_screen(self):
        self.expect(0, "phantom", "--size", "40,30,70", "-o", "p.8vo", "-q")
        lines = self.expect(0, "info", "p.8vo").stdout.splitlines()
        self.assertLessEqual(len(lines), 40)
        self.assertLessEqual(max(map(len, lines)), 110)

    def test_label_names_are_told_and_grey_overrides_them(self):
        layout = self.random_raw("head_labels.raw", (20, 20, 20), "B", 5)
        source = ["head_labels.raw", "--raw", layout, "--spacing", "1"]
        told = self.expect(0, "build", *source, "-o", "l.8vo")
        self.assertIn("looks like labels", told.stderr)
        self.assertIn("--grey", told.stderr)
        self.assertEqual(self.info("l.8vo")["kind"], "labels")
        self.expect(0, "build", *source, "-o", "g.8vo", "--grey")
        self.assertEqual(self.info("g.8vo")["kind"], "grey")
        self.expect(0, "verify", "l.8vo", "--against", *source)

    def test_codes_cover_the_object_in_either_notation(self):
        layout = self.random_raw("m_labels.raw", (9, 8, 7), "B", 3)
        self.expect(0, "build", "m_labels.raw", "--raw", layout, "--spacing", "1", "-o", "m.8vo")
        voxels = (self.folder / "m_labels.raw").read_bytes()
        for notation in ["mixed", "linear"]:
            listed = self.expect(0, "codes", "m.8vo", "--json", "--list", "--notation", notation)
            found = json.loads(listed.stdout)
            self.assertEqual(found["voxels"], sum(v != 0 for v in voxels))
            self.assertEqual(sum(8 ** c["level"] for c in found["codes"]), found["voxels"])
        one = json.loads(
            self.expect(0, "codes", "m.8vo", "--json", "--list", "--label", "2", "--notation",
                        "linear").stdout
        )
        self.assertEqual(one["voxels"], voxels.count(2))
        self.assertEqual(one["codes"], [c for c in found["codes"] if c["value"] == 2])

    def test_probe_tells_the_voxel(self):
        layout = self.random_raw("v.raw", (20, 19, 18))
        self.expect(0, "build", "v.raw", "--raw", layout, "--spacing", "0.5", "-o", "v.8vo")
        voxels = array.array("h", (self.folder / "v.raw").read_bytes())
        told = self.expect(0, "probe", "v.8vo", "--at", "3,4,5", "--json")
        point = json.loads(told.stdout)["points"][0]
        self.assertEqual(point["stored"], voxels[3 + 20 * (4 + 19 * 5)])
        self.assertEqual(point["world_mm"], [1.5, 2.0, 2.5])
        # x = 00011, y = 00100, z = 00101: digits 4z + 2x + y from the highest bit on.
        self.assertEqual(point["o_code"]["mixed_octal"], "00526")
        near = json.loads(self.expect(0, "probe", "v.8vo", "--mm", "1.4,2.1,2.5", "--json").stdout)
        self.assertEqual(near["points"][0]["index"], [3, 4, 5])

    def test_slices_are_pictures_of_all_three_directions(self):
        self.expect(0, "phantom", "--size", "40", "-o", "p.8vo", "-q")
        self.expect(0, "slice", "p.8vo", "--axis", "all", "-o", "s.png")
        for axis in "xyz":
            self.assertEqual((self.folder / f"s-{axis}.png").read_bytes()[:8], b"\x89PNG\r\n\x1a\n")

    def test_quiet_says_nothing_and_json_progress_is_json(self):
        quiet = self.expect(0, "phantom", "--size", "70", "-o", "q.8vo", "-q")
        self.assertEqual((quiet.stdout, quiet.stderr), ("", ""))
        shown = self.expect(0, "phantom", "--size", "70", "-o", "j.8vo", "--progress", "json",
                            "--json")
        json.loads(shown.stdout)
        last = json.loads(shown.stderr.splitlines()[-1])["progress"]
        self.assertEqual(last["done"], last["total"])
        self.assertEqual(last["what"], "phantom")
        shown = self.expect(0, "threshold", "j.8vo", "--range", "0:", "-o", "m.8vo", "--progress",
                            "json")
        last = json.loads(shown.stderr.splitlines()[-1])["progress"]
        self.assertEqual(last["what"], "threshold")


class Stopping(InFolder):
    def test_signals_stop_a_build_and_leave_nothing(self):
        for number in [signal.SIGTERM, signal.SIGINT, signal.SIGHUP]:
            with self.subTest(number):
                process = subprocess.Popen(
                    [OCTAVO, "phantom", "--size", "700", "--noise", "30", "-o", "big.8vo",
                     "--progress", "none"], cwd=self.folder, stderr=subprocess.PIPE, text=True)
                processor_time.let_run(process, 0.5)
                process.send_signal(number)
                _, errors = process.communicate()
                self.assertEqual(process.returncode, 128 + number, errors)
                self.assertEqual(errors.count("\n"), 1, errors)
                self.assertEqual(self.files(), [])

    def test_under_nohup_a_terminal_that_closes_ends_nothing(self):
        process = subprocess.Popen(
            [OCTAVO, "phantom", "--size", "200", "--noise", "30", "-o", "big.8vo", "-q"],
            cwd=self.folder, preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
        processor_time.let_run(process, 0.2)
        process.send_signal(signal.SIGHUP)
        self.assertEqual(process.wait(), 0)
        self.assertEqual(self.files(), ["big.8vo"])


if __name__ == "__main__":
    OCTAVO = os.path.abspath(sys.argv.pop(1))
    unittest.main()
