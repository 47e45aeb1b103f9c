#!/usr/bin/env python3
"""Reads a file from web servers that lie, stall, break off and redirect.

usage: http_test.py OCTAVO [unittest arguments]

Every row of the table is a server: what it does, how the program must end, what it must say, and
within which time and memory. URLs hold a user, a password and a token, which must never be seen.
"""

import concurrent.futures
import dataclasses
import json
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import cli_test
import lying_server
from lying_behaviors import Behaviors, WEAK_TAG

SECRET = "hunter2"
USER = "mallory:" + SECRET
QUERY = "sig=" + SECRET

# What a row may take where it says nothing else: generous, as other tests run beside it.
SECONDS = 40
PROCESSOR_SECONDS = 6
MEMORY_BYTES = 200 << 20


# --- The table -------------------------------------------------------------------------------

@dataclasses.dataclass
class Row:
    """A server, and what becomes of who reads from it.

    server       its behavior, or a URL
    code         exit code
    text         a pattern of what is said
    timeout      --timeout
    seconds      that it takes, from and to
    """

    name: str
    server: object
    code: int
    text: str
    timeout: float = 30
    seconds: tuple = (0, SECONDS)
    environment: dict = dataclasses.field(default_factory=dict)


def told(behavior, *arguments, **options):
    """A behavior that needs to be told more."""
    return lambda exchange: behavior(exchange, *arguments, **options)


def range_rows(b):
    """Servers that answer at once, rightly and wrongly."""
    sound = "sound"
    return [
        Row("good", b.good, 0, sound),
        Row("weak ETag", b.weak_tag, 0, sound),
        Row("HTTP/1.0", b.http_1_0, 0, sound),
        Row("garbage behind the body", b.garbage_behind, 0, sound),
        Row("garbage on a used connection", b.garbage_before, 0, sound),
        Row("wrong charset", b.wrong_charset, 0, sound),
        Row("short 206", b.short, 0, sound),
        Row("breaks off in each body", b.breaks_off, 0, sound),
        Row("200 with 100 GB", b.whole_file, 5, "ignores Range"),
        Row("wrong Content-Range", b.wrong_range, 5, "sent bytes 5-.*, asked were 0-65535"),
        Row("no Content-Range", b.no_range, 5, "Content-Range is ''"),
        Row("two Content-Ranges", b.two_ranges, 5, "Content-Range is 'bytes 0-.*7-9/10'"),
        Row("changing total", b.changing_total, 5, "was replaced"),
        Row("changing ETag", b.changing_tag, 5, "was replaced"),
        Row("changing weak ETag", b.changing_weak_tag, 5, "was replaced"),
        Row("changing ETag within a range", b.changing_in_between, 5, "was replaced"),
        Row("other file, no ETag", b.other_file, 4, "checksum"),
        Row("other file, weak ETag", told(b.other_file, WEAK_TAG), 4, "checksum"),
        Row("gzip", b.gzipped, 5, "encodes the file as gzip"),
        Row("gzip that is none", b.gzip_lie, 5, "encodes the file as gzip"),
        Row("short body", b.short_body, 5, "has 65526 bytes, announced were 65536"),
        Row("endless body", b.long_body, 5, "more bytes than were asked for"),
        Row("206 of no bytes, to come back", b.empty, 5, "the server sends no bytes",
            seconds=(0, 15)),
        Row("multipart", b.multipart, 5, "multipart"),
        Row("416", told(b.busy, "416 Range Not Satisfiable"), 5, "no such range"),
        Row("404", told(b.busy, "404 Not Found"), 5, "no such file"),
        Row("403", told(b.busy, "403 Forbidden"), 5, "denies access"),
        Row("flipped byte", b.flipped_byte, 4, r"\(one flipped bit, byte 600\)(?!.*repair)"),
        Row("flipped byte, once", b.flipped_byte_at_first(1), 0, sound),
        Row("terminal escapes", b.escapes, 5, r"\\x1b\[2Jx"),
        Row("no head", b.no_head, 5, "cannot be read"),
        Row("closes at once", b.closes, 5, "cannot be read"),
    ]


def end_rows(b):
    """Servers of which the last bytes are asked for together with the first."""
    sound = "sound"
    damaged = b.data[:-50] + bytes(50)
    return [
        Row("the end", b.with_end(b.good), 0, sound),
        Row("the whole for its end", b.with_end(b.whole_file), 0, sound),
        Row("the front for its end", b.with_end(told(b.part, first=0, last=9)), 0, sound),
        Row("the end of a longer file", b.with_end(told(b.part, total=10**9)), 0, sound),
        Row("the end of another version", b.with_end(told(b.part, 'ETag: "v2"')), 0, sound),
        Row("half of the end", b.with_end(b.breaks_off), 0, sound),
        Row("a part of the end", b.with_end(b.short), 0, sound),
        Row("more than the end", b.with_end(b.long_body), 0, sound),
        Row("headers for an end", b.with_end(b.endless_headers), 0, sound),
        Row("a way elsewhere for its end", b.with_end(told(b.redirect, "file:///etc")), 0, sound),
        Row("silent about its end", b.with_end(b.silent), 0, sound),
        Row("a damaged end, once", b.with_end(lambda x: b.part(x, 'ETag: "v1"', data=damaged)), 0,
            sound),
        Row("a damaged end", lambda x: b.part(x, 'ETag: "v1"', data=damaged), 4,
            "checksum|trailer"),
    ]


def endless_rows(b):
    """Servers that do not come to an end."""
    return [
        Row("endless headers", b.endless_headers, 5, "headers are longer than 64 KiB"),
        Row("endless header", b.endless_header, 5, "cannot be read|headers are longer"),
        Row("endless 100 Continue", b.endless_continue, 5, "headers are longer than 64 KiB"),
        Row("index root of 2.5 GiB", b.huge_root, 5, "nothing came .* 2 s", timeout=2),
        Row("silent", b.silent, 5, "nothing came .* 2 s; --timeout", timeout=2, seconds=(1.9, 15)),
        Row("stops in a body", b.stops_in_a_body, 5, "nothing came .* 2 s", timeout=2,
            seconds=(1.9, 15)),
        Row("forgets the connection", b.forgets_the_connection, 0, "sound", timeout=2),
        Row("stops in each body", b.stops_in_each_body, 0, "sound", timeout=2),
        Row("150 bytes a second", b.trickle, 5, "less than 10 kB .* 2 s", timeout=2,
            seconds=(1.9, 15)),
        Row("a byte an answer", b.one_byte, 5, "less than 10 kB", timeout=1),
        Row("late", b.late, 0, r"waiting for the server; it has 30 s; --timeout[^\n]*\n.*sound",
            seconds=(6, SECONDS)),
    ]


def busy_rows(b):
    """Servers that ask to come back."""
    busy = "503 Service Unavailable"
    return [
        Row("503", told(b.busy, busy), 5, r"busy \(503\)"),
        Row("500", told(b.busy, "500 Oops"), 5, "status 500"),
        Row("429 once", told(b.busy, "429 Slow Down", times=1), 0, "sound"),
        Row("503 for two seconds", told(b.busy, busy, "Retry-After: 1", times=2), 0, "sound",
            seconds=(2, SECONDS)),
        Row("503 for 3 s", told(b.busy, busy, "Retry-After: 3"), 5, "asks to wait 3 s", timeout=2,
            seconds=(0, 15)),
        Row("503 for 1 s before each byte", told(b.busy_before_each_byte, "Retry-After: 1"), 5,
            "asks to wait 1 s again, after pauses of 2 s in all", timeout=2, seconds=(2, 15)),
        Row("503 for a day", told(b.busy, busy, "Retry-After: 86400"), 5, "asks to wait 86400 s",
            seconds=(0, 15)),
        Row("503 for ever", told(b.busy, busy, "Retry-After: " + "9" * 40), 5,
            "asks to wait many years", seconds=(0, 15)),
        Row("503 until 2099", told(b.busy, busy, "Retry-After: Thu, 01 Jan 2099 00:00:00 GMT"), 5,
            r"asks to wait [\d.e+]+ s", seconds=(0, 15)),
    ]


def redirect_rows(b, server, elsewhere):
    here = server.url("target", b.needs_password)
    there = elsewhere.url("elsewhere", b.needs_no_password)
    return [
        Row("redirect elsewhere", told(b.redirect, there), 0, "sound"),
        Row("redirect on the server", told(b.redirect, here), 0, "sound"),
        Row("relative redirect", told(b.redirect, "/target/scan.8vo"), 0, "sound"),
        Row("redirect loop", b.to_itself, 5, "redirects more than 5 times"),
        Row("to a file", told(b.redirect, "file:///etc/passwd"), 5, "'file'"),
        Row("to gopher", told(b.redirect, "gopher://127.0.0.1/x"), 5, "'gopher'"),
        Row("to nowhere", told(b.redirect, "http://"), 5, "what is no URL"),
        Row("302 with 100 GB", told(b.endless_redirect, "302 Found", f"Location: {there}"), 0,
            "sound"),
        Row("300 with 100 GB", told(b.endless_redirect, "300 Choices", f"Location: {there}"), 0,
            "sound"),
        Row("300 with 100 GB to nowhere", told(b.endless_redirect, "300 Choices"), 5,
            "status 300"),
    ]


def way_rows(b, server, secure, certificate):
    """What is about the way to the server."""
    trust = {"SSL_CERT_FILE": str(certificate)}
    proxy = {"http_proxy": f"http://{USER}@127.0.0.1:{server.port}"}
    dead = {"http_proxy": f"http://{USER}@127.0.0.1:9"}
    server.url("proxied", b.good)
    good = secure.url("good", b.good)
    down = secure.url("down", told(b.redirect, server.url("proxied")))
    return [
        Row("self-signed", good, 5, "certificate"),
        Row("self-signed and known", good, 0, "sound", environment=trust),
        Row("http to https", told(b.redirect, good), 0, "sound", environment=trust),
        Row("https to http", down, 5, "redirects from https to http", environment=trust),
        Row("http to https to http", told(b.redirect, down), 5, "redirects from https to http",
            environment=trust),
        Row("proxy", "http://no.such.host.example/proxied/scan.8vo", 0, "sound",
            environment=proxy),
        Row("dead proxy", b.good, 5, "cannot be read", environment=dead),
        Row("no proxy for it", b.good, 0, "sound", environment={**dead, "no_proxy": "127.0.0.1"}),
    ]


# --- Reading ---------------------------------------------------------------------------------

@dataclasses.dataclass
class Outcome:
    """How a run of the program ended; code None: it did not."""

    code: int | None
    stdout: str
    stderr: str
    seconds: float
    processor_seconds: float
    memory_bytes: int


def clean_environment(**changes):
    kept = {name: value for name, value in os.environ.items()
            if not name.lower().endswith("_proxy") and name != "SSL_CERT_FILE"}
    return {**kept, **changes}


def run(arguments, environment, seconds):
    """Runs the program, at most for so long."""
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        begin = time.monotonic()
        process = subprocess.Popen([cli_test.OCTAVO, *arguments], stdout=out, stderr=err,
                                   env=environment)
        code = None
        while code is None and time.monotonic() - begin < seconds:
            pid, status, used = os.wait4(process.pid, os.WNOHANG)
            if pid:
                code = process.returncode = os.waitstatus_to_exitcode(status)
            else:
                time.sleep(0.02)
        if code is None:
            process.kill()
            _, status, used = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
        texts = []
        for file in (out, err):
            file.seek(0)
            texts.append(file.read().decode())
        return Outcome(code, *texts, time.monotonic() - begin, used.ru_utime + used.ru_stime,
                       used.ru_maxrss << 10)


def with_secrets(url):
    return url.replace("://", f"://{USER}@") + "?" + QUERY


class Reading(cli_test.InFolder):
    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.TemporaryDirectory()
        folder = pathlib.Path(cls.holder.name)
        scan = folder / "scan.8vo"
        subprocess.run([cli_test.OCTAVO, "phantom", "--size", "64", "--noise", "12", "-q", "-o",
                        scan], check=True)
        cls.behaviors = Behaviors(scan.read_bytes())
        assert len(cls.behaviors.data) > 3 << 16, "a file of several blocks"
        cls.certificate = folder / "certificate.pem"
        subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt",
                        "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2", "-subj",
                        "/CN=test", "-addext", "subjectAltName=IP:127.0.0.1", "-keyout",
                        cls.certificate, "-out", cls.certificate.with_suffix(".crt")],
                       check=True, capture_output=True)
        with cls.certificate.open("ab") as both:
            both.write(cls.certificate.with_suffix(".crt").read_bytes())
        cls.server = lying_server.Server()
        cls.elsewhere = lying_server.Server()
        cls.secure = lying_server.Server(cls.certificate)

    @classmethod
    def tearDownClass(cls):
        for server in (cls.server, cls.elsewhere, cls.secure):
            server.close()
        cls.holder.cleanup()

    def read(self, row, number):
        url = row.server
        if callable(url):
            url = self.server.url(str(number), url)
        return run(["verify", with_secrets(url), "--timeout", str(row.timeout), "-j", "2",
                    "--progress", "none"], clean_environment(**row.environment), SECONDS)

    def check(self, row, outcome):
        said = outcome.stderr + outcome.stdout
        self.assertEqual(outcome.code, row.code, said)
        self.assertRegex(said, re.compile(row.text, re.DOTALL))
        self.assertNotIn(SECRET, said)
        self.assertNotIn("\x1b", said)
        self.assertLessEqual(outcome.stderr.count("\n"), 1)
        self.assertGreaterEqual(outcome.seconds, row.seconds[0])
        self.assertLess(outcome.seconds, row.seconds[1])
        self.assertLess(outcome.processor_seconds, PROCESSOR_SECONDS)
        self.assertLess(outcome.memory_bytes, MEMORY_BYTES)

    def check_all(self, rows):
        with concurrent.futures.ThreadPoolExecutor(8) as pool:
            outcomes = list(pool.map(self.read, rows, range(len(rows))))
        for row, outcome in zip(rows, outcomes):
            with self.subTest(row.name):
                self.check(row, outcome)


class Servers(Reading):
    def test_every_server_ends_in_an_answer_or_one_line(self):
        b = self.behaviors
        self.check_all([
            *range_rows(b), *end_rows(b), *endless_rows(b), *busy_rows(b),
            *redirect_rows(b, self.server, self.elsewhere),
            *way_rows(b, self.server, self.secure, self.certificate)])
        for target, headers in self.server.requests + self.elsewhere.requests:
            self.assertEqual(headers.get("accept-encoding"), "identity", target)
            self.assertRegex(headers.get("range", ""), r"^bytes=\d*-\d+$", target)

    def test_ipv6_alone_is_enough(self):
        try:
            server = lying_server.Server(family=socket.AF_INET6)
        except OSError:
            self.skipTest("this machine has no IPv6")
        self.addCleanup(server.close)
        self.check_all([Row("IPv6", server.url("good", self.behaviors.good), 0, "sound")])
        self.assertTrue(server.requests)

    def test_a_signal_ends_waiting(self):
        url = self.server.url("signal", self.behaviors.silent)
        for verb in (["info"], ["export", "-o", "x.raw"]):
            with subprocess.Popen([cli_test.OCTAVO, verb[0], url, *verb[1:]], cwd=self.folder,
                                  env=clean_environment(), stderr=subprocess.PIPE) as process:
                count = len(self.server.requests)
                while len(self.server.requests) == count:
                    time.sleep(0.02)
                process.terminate()
                begin = time.monotonic()
                process.communicate(timeout=SECONDS)
                self.assertIn(process.returncode, (143, -signal.SIGTERM), verb)
                self.assertLess(time.monotonic() - begin, 10, verb)
        self.assertEqual(self.files(), [])


class Secrets(Reading):
    def setUp(self):
        super().setUp()
        self.scan = with_secrets(self.server.url("scan", self.behaviors.good))
        scan = self.folder / "scan.8vo"
        scan.write_bytes(self.behaviors.data)
        self.expect(0, "threshold", "scan.8vo", "--range", "300:", "-o", "mask.8vo", "-q")
        mask = (self.folder / "mask.8vo").read_bytes()
        self.mask = with_secrets(self.server.url("mask", Behaviors(mask).good))
        self.silent = with_secrets(self.server.url("silent", self.behaviors.silent))

    def check_secret(self, *arguments):
        for more in (["--verbose"], ["--json"]):
            outcome = run([*map(str, arguments), *more, "--force"], clean_environment(), SECONDS)
            self.assertIn(outcome.code, (0, 1, 2, 4, 5, 7), (arguments, outcome))
            self.assertNotIn(SECRET, outcome.stdout + outcome.stderr, arguments)
            self.assertNotIn("mallory", outcome.stdout + outcome.stderr, arguments)

    def test_no_verb_prints_or_writes_user_password_or_query(self):
        out = self.folder / "out"
        out.mkdir()
        name = out / "x.8vo"
        scan, mask = self.scan, self.mask
        for arguments in [
            ("info", scan), ("info", scan, "--metadata"), ("verify", scan),
            ("verify", scan, "--against", mask), ("verify", scan, "--against", scan),
            ("build", scan, "-o", name), ("build", scan, "--labels", "-o", name),
            ("export", scan, "-o", out / "x.nii"), ("export", scan, "-o", out / "x.mha"),
            ("extract", scan, "--box", "0:9,0:9,0:9", "-o", out / "x.nrrd"),
            ("slice", scan, "-o", out / "x.png"), ("slice", scan, "--overlay", mask, "-o",
                                                   out / "y.png"),
            ("render", mask, "--size", "64", "-o", out / "z.png"),
            ("render", scan, "--range", "1:2", "-o", out / "z.png"),
            ("probe", scan, "--at", "1,2,3"), ("compare", scan, mask), ("compare", mask, mask),
            ("compare", mask, mask, "--labels"), ("compare", scan, scan, "--labels"),
            ("codes", mask), ("codes", mask, "--counts"), ("codes", scan),
            ("condense", scan, "--flat", "20", "-o", name), ("condense", mask, "-o", name),
            ("threshold", scan, "--range", "99999:", "-o", name), ("threshold", mask, "-o", name),
            ("combine", mask, mask, "--union", "-o", name),
            ("combine", mask, scan, "--union", "-o", name),
            ("components", mask), ("components", mask, "--keep-largest", "1", "-o", name),
            ("measure", mask), ("measure", mask, "--of", scan), ("touch", mask),
            ("touch", mask, mask), ("fill-holes", mask, "-o", name),
            ("dilate", mask, "--voxels", "1", "-o", name),
            ("erode", mask, "--mm", "99", "-o", name),
            ("open", mask, "--voxels", "1", "-o", name),
            ("close", mask, "--voxels", "1", "-o", name),
            ("shell", mask), ("shell", mask, "-o", name), ("shell", scan),
            ("distance", mask, "-o", name), ("morphometry", mask),
            ("align", mask, mask, "-o", out / "pose.txt"),
            ("condense", scan, "--self-similar", "2"), ("surface", mask, "-o", out / "x.stl"),
            ("hexahedra", mask, "-o", out / "x.vtu"),
            ("transform", mask, "--shift", "1,1,1", "-o", name),
            ("transform", scan, "--grid-of", mask, "-o", name),
            ("repair", scan, "-o", name), ("phantom", "-o", scan), ("build", mask, "-o", scan),
            ("info", scan, scan), ("inf", scan), ("info", "--no-such", scan),
            ("info", scan, "--threads", scan), ("info", self.silent, "--timeout", "1"),
            ("info", "https://mallory:hunter2@127.0.0.1:9/x?hunter2", "--timeout", "1"),
            ("info", "http://mallory:hunter2/@nowhere/x"),
            ("http://mallory: hunter2@h/x",), ("http://mallory:it's \"hunter2@h/x",),
            ("probe", mask, "--at", "http://127.0.0.1:9/x?a= hunter2"),
            ("info", "http://mallory: hunter2@127.0.0.1:9/x?a \"hunter2", "--timeout", "1"),
        ]:
            with self.subTest(arguments):
                self.check_secret(*arguments)
        for path in out.rglob("*"):
            self.assertNotIn(SECRET, path.name)
            self.assertNotIn(SECRET.encode(), path.read_bytes(), path)

    def test_info_begins_with_the_public_name(self):
        name = self.server.url("scan")
        self.assertEqual(self.expect(0, "info", self.scan).stdout.splitlines()[0], name)
        self.assertEqual(self.info(self.scan)["file"], name)
        error = json.loads(self.expect(5, "info", self.silent, "--timeout", "1", "--json")
                           .stderr.splitlines()[-1])["error"]
        self.assertEqual(error["path"], self.server.url("silent"))

    def test_no_journal_holds_a_secret(self):
        self.expect(0, "phantom", "--size", "256,256,512", "--noise", "3",
                    "-o", "long.8vo", "-q")
        long = Behaviors((self.folder / "long.8vo").read_bytes())
        middle = len(long.data) * 5 // 8  # behind the first group, far before the end
        stopped = threading.Event()

        def stop_in_the_middle(x):
            if not x.first <= middle <= x.last:
                return long.good(x)
            stopped.set()
            return long.silent(x)

        (self.folder / "out").mkdir()
        url = with_secrets(self.server.url("half", stop_in_the_middle))
        with subprocess.Popen([cli_test.OCTAVO, "build", url, "--resume", "-o", "out/x.8vo"],
                              cwd=self.folder, env=clean_environment(),
                              stderr=subprocess.DEVNULL) as process:
            self.assertTrue(stopped.wait(SECONDS))
            journals = self.wait_for_journals(process)
            process.kill()
        self.assertEqual(len(journals), 1, self.files())
        self.assertIn(b"8jrn", journals[0].read_bytes())
        for path in (self.folder / "out").iterdir():
            self.assertNotIn(SECRET, path.name)
            self.assertNotIn(SECRET.encode(), path.read_bytes(), path)

    def wait_for_journals(self, process):
        """Those that hold more than their head once `process` has written them, or ended."""
        end = time.monotonic() + SECONDS
        while process.poll() is None and time.monotonic() < end:
            journals = list((self.folder / "out").glob(".*.journal"))
            if any(path.stat().st_size > 1 << 11 for path in journals):
                return journals
            time.sleep(0.02)
        return []


if __name__ == "__main__":
    cli_test.OCTAVO = os.path.abspath(sys.argv.pop(1))
    unittest.main()
