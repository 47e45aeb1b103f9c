#!/usr/bin/env python3
"""Repairs damaged files with the program: the bytes that were written, or nothing and the reason.

usage: repair_bits_faults.py OCTAVO [unittest arguments]
"""

import array
import json
import os
import random
import sys
import unittest

import program_faults

# The polynomial of CRC-32C as bytes: changed by a sum of it, at any place, bytes keep their
# checksum.
POLYNOMIAL = (0x82F63B78 << 1 | 1).to_bytes(5, "little")


def garble_unseen(content, begin, end):
    numbers = random.Random(3)
    for at in range(begin, end - len(POLYNOMIAL) + 1):
        if numbers.random() < 0.5:
            for i, byte in enumerate(POLYNOMIAL):
                content[at + i] ^= byte


class RepairBits(program_faults.InFolder):
    def setUp(self):
        super().setUp()
        # Three bricks of the same size, which fill most of the file.
        self.expect(0, "build", *self.noisy_raw("v.raw", 192, 64, 20), "-o", "good.8vo")
        self.good = (self.folder / "good.8vo").read_bytes()

    def write(self, content):
        (self.folder / "bad.8vo").write_bytes(content)

    def damage(self, *fractions):
        """bad.8vo: good.8vo with a flipped bit at each fraction of its length."""
        damaged = bytearray(self.good)
        places = [int(len(damaged) * fraction) for fraction in fractions]
        for place in places:
            damaged[place] ^= 4
        self.write(damaged)
        return places

    def advice(self):
        return self.expect(4, "verify", "bad.8vo", "--progress", "none").stderr.splitlines()[-1]

    def expect_repaired(self, words, good=None):
        said = self.expect(0, "repair", "bad.8vo", "-o", "repaired.8vo", "--force").stdout
        self.assertEqual((self.folder / "repaired.8vo").read_bytes(), good or self.good)
        for word in [*words, "every checksum matches"]:
            self.assertIn(word, said)

    def expect_rejected(self, words):
        self.expect_error(4, ["bad.8vo: ", *words], "repair", "bad.8vo", "-o", "x.8vo")
        self.assertEqual([name for name in self.names() if name.startswith(("x", "."))], [])

    def test_flipped_bits_are_turned_back(self):
        places = self.damage(0.0001, 0.15, 0.45, 0.9999)
        result = self.expect(0, "repair", "bad.8vo", "-o", "repaired.8vo", "--json")
        self.assertEqual([flip["byte"] for flip in json.loads(result.stdout)["flipped_bits"]],
                         places)
        self.expect_repaired([f"4 flipped bits turned back (byte {places[0]}, "])

    def test_other_damage_is_rejected(self):
        self.damage(0.2, 0.21)
        self.expect_rejected(["brick o-code 0x", "more than one flipped bit", "--salvage"])
        self.write(self.good[:-9])
        self.expect_rejected(["cut short", "cannot restore"])
        self.expect_error(2, ["is sound"], "repair", "good.8vo", "-o", "x.8vo")
        self.expect_error(2, ["is the file to repair"], "repair", "good.8vo", "-o", "good.8vo",
                          "--force")
        self.expect_error(3, ["not an 8vo file"], "repair", "v.raw", "-o", "x.8vo")

    def test_verify_names_what_helps(self):
        for fractions in [(0.15,), (0.15, 0.45)]:
            self.damage(*fractions)
            self.assertIn("repair turns flipped bits back", self.advice())
        for fractions in [(0.0001,), (0.9999,)]:
            self.damage(*fractions)
            self.assertIn("repair restores it, unless what it hides is damaged", self.advice())
        # Two bits of one brick.
        self.damage(0.15, 0.45, 0.46)
        self.assertIn("export --salvage writes them", self.advice())
        self.assertNotIn("repair", self.advice())

    def test_a_trailer_is_made_anew_and_bytes_behind_the_end_are_left_out(self):
        self.write(self.good[:-40] + bytes(40))
        self.assertIn("repair restores it", self.advice())
        self.expect_repaired(["trailer made anew; "])
        self.write(self.good + bytes(100))
        self.expect_error(4, ["bad.8vo: bytes follow its end", "repair restores it"], "verify",
                          "bad.8vo")
        self.expect_repaired(["100 bytes behind its end left out; "])

    def test_damaged_metadata_are_named_and_rejected(self):
        metadata = bytearray(self.good)
        at = self.good.rindex(b'"source"')
        metadata[at] ^= 5
        self.write(metadata)
        self.assertNotIn("repair", self.advice())
        self.expect_rejected(["metadata at byte ", "repair cannot restore this"])

    def test_a_garbled_sector_that_passes_for_a_flipped_bit_is_rejected(self):
        numbers = random.Random(8)
        voxels = array.array("h", numbers.choices(range(-32768, 32768), k=100 * 64 * 8))
        (self.folder / "v.raw").write_bytes(voxels.tobytes())
        self.expect(0, "build", "v.raw", "--raw", "100,64,8,int16", "--spacing", "1", "-o",
                    "good.8vo", "--force")
        damaged = bytearray((self.folder / "good.8vo").read_bytes())
        damaged[30000] ^= 1
        garble_unseen(damaged, 20480, 20992)
        self.write(damaged)
        self.expect_error(4, ["(one flipped bit, byte 30000)", "export --salvage writes them"],
                          "verify", "bad.8vo")
        self.expect_rejected(["one flipped bit would explain it, but so would other damage"])


if __name__ == "__main__":
    program_faults.OCTAVO = os.path.abspath(sys.argv.pop(1))
    unittest.main()
