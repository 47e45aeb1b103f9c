"""A web server of one file that answers byte ranges, counts them, and may be late."""

import http.server
import os
import re
import threading
import time


class _Ranges(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def do_GET(self):
        owner = self.server.owner
        size = len(owner.content)
        asked = re.fullmatch(r"bytes=(\d*)-(\d+)", self.headers.get("Range", ""))
        if asked is None:
            self.send_error(400)
            return
        first, last = int(asked[1] or max(0, size - int(asked[2]))), size - 1
        if asked[1]:
            last = min(int(asked[2]), last)
        owner.count(first, last)
        time.sleep(owner.latency_seconds)
        self.send_response(206)
        self.send_header("ETag", '"one"')
        self.send_header("Content-Range", f"bytes {first}-{last}/{size}")
        self.send_header("Content-Length", str(last + 1 - first))
        self.end_headers()
        self.wfile.write(memoryview(owner.content)[first:last + 1])
        owner.end_one()

    def log_message(self, *_):
        pass


class RangeServer:
    """Serves `path` at `url` while it is entered; every answer begins so many seconds late."""

    def __init__(self, path, latency_seconds=0):
        with open(path, "rb") as file:
            self.content = file.read()
        self.latency_seconds = latency_seconds
        self._lock = threading.Lock()
        self._server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), _Ranges)
        self._server.owner = self
        self.url = f"http://127.0.0.1:{self._server.server_port}/{os.path.basename(path)}"
        self.forget()

    def __enter__(self):
        threading.Thread(target=self._server.serve_forever, daemon=True).start()
        return self

    def __exit__(self, *_):
        self._server.shutdown()
        self._server.server_close()

    def forget(self):
        """Counts from nothing again."""
        with self._lock:
            self.ranges = []
            self.at_once = self.most_at_once = 0

    def count(self, first, last):
        with self._lock:
            self.ranges.append((first, last))
            self.at_once += 1
            self.most_at_once = max(self.most_at_once, self.at_once)

    def end_one(self):
        with self._lock:
            self.at_once -= 1

    @property
    def request_count(self):
        return len(self.ranges)

    @property
    def byte_count(self):
        return sum(last + 1 - first for first, last in self.ranges)
