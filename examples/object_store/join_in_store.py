#!/usr/bin/env python3
"""Joins the parts of a plan inside an object store: its server copies the bytes.

usage: join_in_store.py PLAN PARTS s3://BUCKET/PREFIX/ s3://BUCKET/scan.8vo

    aws s3 cp parts/ s3://scans/parts/ --recursive
    join_in_store.py scan.plan parts/ s3://scans/parts/ s3://scans/scan.8vo

PARTS is the folder of the parts, and PREFIX the place of equal copies of them. Pieces below 5 MiB,
which no store copies, are gathered and uploaded from PARTS. `octavo` and the Python package `boto3`
are needed. AWS_ENDPOINT_URL, AWS_ACCESS_KEY_ID and so on say where the store is and who asks.
"""

import concurrent.futures
import json
import os
import subprocess
import sys
import tempfile

import boto3
from botocore.exceptions import BotoCoreError, ClientError

# Limits of multipart uploads.
SHORTEST, LONGEST, MOST_PIECES = 5 << 20, 5 << 30, 10000
LONGEST_UPLOAD = 64 << 20  # held in memory


def length_of(piece):
    return sum(length for _, _, length in piece)


def cut(path, offset, length, longest):
    """Runs of SHORTEST to `longest` bytes."""
    while length:
        now = min(length, longest)
        if 0 < length - now < SHORTEST:
            now = length - SHORTEST
        yield (path, offset, now)
        offset, length = offset + now, length - now


def pieces_of(runs, own_file):
    """Lists of runs: one of a part alone, for the server to copy, or several that are uploaded."""
    gathered = []
    for path, offset, length in runs:
        if gathered and length:
            fill = min(length, SHORTEST - length_of(gathered))
            gathered.append((path, offset, fill))
            offset, length = offset + fill, length - fill
            if length_of(gathered) == SHORTEST:
                yield gathered
                gathered = []
        if 0 < length < SHORTEST:
            gathered.append((path, offset, length))
        elif length:
            yield from ([run] for run in cut(path, offset, length,
                                             LONGEST_UPLOAD if path == own_file else LONGEST))
    if gathered:
        yield gathered


def read(path, offset, length):
    with open(path, "rb") as file:
        file.seek(offset)
        return file.read(length)


def place(url):
    """Bucket and key of s3://BUCKET/KEY."""
    if not url.startswith("s3://") or "/" not in url[5:]:
        sys.exit(f"{url}: not s3://BUCKET/KEY")
    return url[5:].split("/", 1)


class Upload:
    """A multipart upload: complete it has a name, otherwise nothing is left of it."""

    def __init__(self, store, url, prefix, own_file):
        self.store, self.own_file = store, own_file
        self.from_bucket, self.from_prefix = place(prefix)
        bucket, key = place(url)
        self.target = {"Bucket": bucket, "Key": key}

    def source(self, path):
        return {"Bucket": self.from_bucket, "Key": self.from_prefix + os.path.basename(path)}

    def check_parts(self, paths):
        for path in sorted(paths):
            source, length = self.source(path), os.path.getsize(path)
            try:
                there = self.store.head_object(**source)["ContentLength"]
            except ClientError as error:
                sys.exit(f"s3://{source['Bucket']}/{source['Key']}: {error}")
            if there != length:
                sys.exit(f"{path} has {length} bytes, its copy in the store {there}")

    def is_copied(self, piece):
        return len(piece) == 1 and piece[0][0] != self.own_file and piece[0][2] >= SHORTEST

    def send(self, number, piece):
        target = {**self.target, "PartNumber": number}
        if self.is_copied(piece):
            path, offset, length = piece[0]
            sent = self.store.upload_part_copy(
                **target, CopySource=self.source(path),
                CopySourceRange=f"bytes={offset}-{offset + length - 1}")["CopyPartResult"]
        else:
            sent = self.store.upload_part(**target, Body=b"".join(read(*run) for run in piece))
        return {"PartNumber": number, "ETag": sent["ETag"]}

    def run(self, pieces):
        self.target["UploadId"] = self.store.create_multipart_upload(**self.target)["UploadId"]
        try:
            with concurrent.futures.ThreadPoolExecutor(8) as threads:
                sent = list(threads.map(self.send, range(2, len(pieces) + 1), pieces[1:]))
            # Last, so that what ends early has no head and is taken for no file.
            sent.insert(0, self.send(1, pieces[0]))
            self.store.complete_multipart_upload(**self.target, MultipartUpload={"Parts": sent})
        except BaseException:
            self.store.abort_multipart_upload(**self.target)
            raise


def main(plan, parts, prefix, url):
    with tempfile.TemporaryDirectory() as folder:
        listed = subprocess.run(
            ["octavo", "join", plan, parts, "--runs", "--json", "--progress", "none", "-o",
             os.path.join(folder, "scan.8vo")], stdout=subprocess.PIPE, check=False)
        if listed.returncode != 0:
            sys.exit(listed.returncode)
        told = json.loads(listed.stdout)
        own_file = told["own_file"]
        runs = [(run["path"], run["offset"], run["length"]) for run in told["runs"]]
        pieces = list(pieces_of(runs, own_file))
        if len(pieces) > MOST_PIECES:
            sys.exit(f"{len(pieces)} pieces, and stores take {MOST_PIECES}: plan fewer parts")
        upload = Upload(boto3.client("s3"), url, prefix, own_file)
        try:
            upload.check_parts({path for path, _, _ in runs} - {own_file})
            upload.run(pieces)
        except (BotoCoreError, ClientError) as error:
            sys.exit(f"{url}: {error}")
        copied = sum(length_of(piece) for piece in pieces if upload.is_copied(piece))
        print(f"{url}: {told['file_bytes']} bytes, {copied} of them copied by the server")


if __name__ == "__main__":
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    main(*sys.argv[1:])
