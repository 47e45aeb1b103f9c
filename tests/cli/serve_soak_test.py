#!/usr/bin/env python3
"""octavo serve under 32 clients for a long time: every byte right, nothing kept.

usage: serve_soak_test.py OCTAVO [unittest arguments]

OCTAVO_SOAK_REQUESTS (200000 where absent) says for how long. The figures are printed.
"""

import multiprocessing
import os
import pathlib
import random
import re
import socket
import sys
import time
import unittest

import cli_test
import serve_test

PROCESSES = 4
CLIENTS = 8
REQUESTS = int(os.environ.get("OCTAVO_SOAK_REQUESTS", "200000"))
# What comes before is warming up: buffers of connections, pages of the file.
WARM_SHARE = 0.1
MOST_GROWTH_KB = 2048


class Client:
    """A connection that asks for ranges, and now and then breaks off."""

    def __init__(self, port, content):
        self.port = port
        self.content = content
        self.socket = None
        self.reader = None

    def connect(self):
        self.socket = socket.create_connection(("127.0.0.1", self.port), timeout=120)
        self.reader = self.socket.makefile("rb")

    def close(self):
        if self.socket:
            self.reader.close()
            self.socket.close()
        self.socket = None

    def head(self):
        status = int(self.reader.readline().split()[1])
        length = 0
        while (line := self.reader.readline()) not in (b"\r\n", b""):
            name, value = line.split(b":", 1)
            if name.lower() == b"content-length":
                length = int(value)
        return status, length

    def ask(self, choice):
        """One request; what is wrong about its answer, or None."""
        if not self.socket:
            self.connect()
        size = len(self.content)
        first = choice.randrange(size)
        last = min(size - 1, first + choice.choice((0, 100, 4000, 40_000)))
        kind = choice.random()
        if kind < 0.01:
            field, expected = f"bytes={size}-", (416, None)
        else:
            field, expected = f"bytes={first}-{last}", (206, self.content[first:last + 1])
        self.socket.sendall(f"GET /scan.8vo HTTP/1.1\r\nHost: 127.0.0.1:{self.port}\r\n"
                            f"Range: {field}\r\n\r\n".encode())
        if kind > 0.995:
            # Gone before the answer.
            self.close()
            return None
        status, length = self.head()
        body = self.reader.read(length)
        if status != expected[0] or (expected[1] is not None and body != expected[1]):
            return f"{field}: {status}, {len(body)} bytes"
        if kind > 0.98:
            self.close()
        return None


def run_clients(seed, port, content, requests, results):
    """The work of one process: its clients take turns."""
    choice = random.Random(seed)
    clients = [Client(port, content) for _ in range(CLIENTS)]
    wrong = []
    times = []
    for i in range(requests):
        began = time.perf_counter()
        found = clients[i % CLIENTS].ask(choice)
        times.append(time.perf_counter() - began)
        if found:
            wrong.append(found)
            break
    for client in clients:
        client.close()
    results.put((wrong, sorted(times)[int(len(times) * 0.99)], len(times)))


class Soak(serve_test.Serving):
    def memory_kb(self, process):
        text = pathlib.Path(f"/proc/{process.pid}/status").read_text()
        return int(re.search(r"VmRSS:\s+(\d+)", text).group(1))

    def descriptors(self, process):
        return len(os.listdir(f"/proc/{process.pid}/fd"))

    def run_for(self, port, requests, seed):
        results = multiprocessing.Queue()
        content = (self.folder / "scan.8vo").read_bytes()
        started = [multiprocessing.Process(
            target=run_clients, args=(seed + i, port, content, requests // PROCESSES, results))
            for i in range(PROCESSES)]
        for one in started:
            one.start()
        found = [results.get() for _ in started]
        for one in started:
            one.join()
        self.assertEqual([wrong for wrong, _, _ in found if wrong], [])
        return max(p99 for _, p99, _ in found), sum(count for _, _, count in found)

    def settled_descriptors(self, process, expected):
        """Connections that clients closed are seen soon."""
        for _ in range(600):
            if self.descriptors(process) <= expected:
                break
            time.sleep(0.1)
        return self.descriptors(process)

    def test_memory_and_connections_stay_and_every_byte_is_right(self):
        self.expect(0, "phantom", "--size", "96", "--noise", "20", "-o", "scan.8vo")
        process, site = self.serve("serve", "scan.8vo")
        idle = self.descriptors(process)
        self.run_for(site["port"], int(REQUESTS * WARM_SHARE), 1)
        self.assertLessEqual(self.settled_descriptors(process, idle), idle)
        before = self.memory_kb(process)
        began = time.monotonic()
        p99, count = self.run_for(site["port"], REQUESTS, 100)
        seconds = time.monotonic() - began
        growth = self.memory_kb(process) - before
        print(f"{count} requests in {seconds:.0f} s, p99 {p99 * 1000:.1f} ms, "
              f"memory {before} kB, growth {growth} kB", flush=True)
        self.assertLess(growth, MOST_GROWTH_KB)
        self.assertLessEqual(self.settled_descriptors(process, idle), idle)
        self.assertIsNone(process.poll())


if __name__ == "__main__":
    cli_test.OCTAVO = os.path.abspath(sys.argv.pop(1))
    unittest.main()
