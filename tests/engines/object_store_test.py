#!/usr/bin/env python3
"""Joins parts inside an S3 server of this machine, and reads the object by its URL.

usage: object_store_test.py OCTAVO JOIN_IN_STORE [unittest arguments]
"""

import importlib.util
import json
import logging
import os
import random
import subprocess
import sys
import unittest

import boto3
from moto.server import ThreadedMotoServer

import engine_scan

JOIN_IN_STORE = ""


def example():
    """The example as a module."""
    spec = importlib.util.spec_from_file_location("join_in_store", JOIN_IN_STORE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class Pieces(unittest.TestCase):
    def test_pieces_are_the_runs_and_none_but_the_last_is_too_short(self):
        join = example()
        numbers = random.Random(3)
        for _ in range(2000):
            lengths = [numbers.choice([0, 1, 512, 4 << 20, join.SHORTEST - 1, join.SHORTEST,
                                       join.SHORTEST + 1, 9 << 20, join.LONGEST,
                                       join.LONGEST + 1, 12 << 30])
                       for _ in range(numbers.randrange(1, 9))]
            runs = [(numbers.choice(["own", "part"]), 7 * at, length)
                    for at, length in enumerate(lengths)]
            pieces = list(join.pieces_of(runs, "own"))
            for piece in pieces[:-1]:
                self.assertGreaterEqual(join.length_of(piece), join.SHORTEST)
            for piece in pieces:
                copied = len(piece) == 1 and piece[0][0] == "part"
                self.assertLessEqual(join.length_of(piece),
                                     join.LONGEST if copied else join.LONGEST_UPLOAD)
            self.assertEqual(self.united(run for piece in pieces for run in piece),
                             self.united(run for run in runs if run[2]))

    @staticmethod
    def united(runs):
        result = []
        for path, offset, length in runs:
            if result and result[-1][0] == path and sum(result[-1][1:]) == offset:
                path, offset, before = result.pop()
                length += before
            result.append((path, offset, length))
        return result


class InStore(engine_scan.OfScan):
    def setUp(self):
        super().setUp()
        server = ThreadedMotoServer(ip_address="127.0.0.1", port=0)
        server.start()
        self.addCleanup(server.stop)
        host, port = server.get_host_and_port()
        os.environ.update(AWS_ENDPOINT_URL=f"http://{host}:{port}", AWS_ACCESS_KEY_ID="a",
                          AWS_SECRET_ACCESS_KEY="b", AWS_DEFAULT_REGION="us-east-1")
        self.store = boto3.client("s3")
        self.store.create_bucket(Bucket="scans")
        self.octavo("plan", *engine_scan.PLAN_OPTIONS, "-o", "scan.plan")
        self.octavo("part", "scan.plan", "--parts", "0-2", "-o", "parts")
        self.parts = sorted((self.folder / "parts").iterdir())
        for path in self.parts:
            self.store.upload_file(str(path), "scans", f"parts/{path.name}")

    def join(self):
        return subprocess.run(
            [sys.executable, JOIN_IN_STORE, "scan.plan", "parts", "s3://scans/parts/",
             "s3://scans/made/scan.8vo"], cwd=self.folder, capture_output=True, text=True,
            check=False)

    def check_nothing_is_left(self):
        self.assertNotIn("Uploads", self.store.list_multipart_uploads(Bucket="scans"))
        self.assertEqual(self.files(), ["parts", "scan.plan", "scan.raw"])

    def test_the_object_is_the_file_of_one_machine_and_its_url_is_read(self):
        result = self.join()
        self.assertEqual(result.returncode, 0, result.stderr)
        made = self.store.get_object(Bucket="scans", Key="made/scan.8vo")["Body"].read()
        self.assertTrue(made == self.whole, "other bytes")
        words = result.stdout.split()
        self.assertEqual((words[1], words[2]), (str(len(made)), "bytes,"))
        self.assertGreater(int(words[3]), 0.7 * len(made))
        self.check_nothing_is_left()
        url = self.store.generate_presigned_url(
            "get_object", Params={"Bucket": "scans", "Key": "made/scan.8vo"})
        info = json.loads(subprocess.run(["octavo", "info", url, "--json"], check=True,
                                         capture_output=True).stdout)
        self.assertEqual((info["size"], info["file_bytes"]), ([512, 512, 140], len(made)))

    def test_a_part_that_is_not_in_the_store_or_is_cut_is_an_error_and_leaves_nothing(self):
        name = self.parts[1].name
        self.store.put_object(Bucket="scans", Key=f"parts/{name}", Body=b"cut")
        result = self.join()
        self.assertEqual(result.returncode, 1)
        self.assertIn(f"parts/{name} has ", result.stderr)
        self.store.delete_object(Bucket="scans", Key=f"parts/{name}")
        result = self.join()
        self.assertEqual(result.returncode, 1)
        self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
        self.assertIn(name, result.stderr)
        self.check_nothing_is_left()

    def test_an_upload_that_fails_in_the_middle_leaves_nothing(self):
        join = example()
        upload = join.Upload(self.store, "s3://scans/made/scan.8vo", "s3://scans/none/", "own")
        with self.assertRaises(join.ClientError):
            upload.run([[(str(self.parts[0]), 0, 512), (str(self.parts[0]), 512, 6 << 20)],
                        [(str(self.parts[0]), 512, 6 << 20)]])
        self.check_nothing_is_left()


if __name__ == "__main__":
    OCTAVO, JOIN_IN_STORE = map(os.path.abspath, sys.argv[1:3])
    del sys.argv[1:3]
    engine_scan.use(OCTAVO)
    logging.getLogger("werkzeug").setLevel(logging.ERROR)
    unittest.main()
