"""A web server of ranges of files, which may do what servers do."""

import contextlib
import http.server
import pathlib
import re
import threading


class RangedFiles(http.server.SimpleHTTPRequestHandler):
    """A server of ranges that counts what it sends."""

    sent = 0
    asked = []     # methods and ranges
    has_ranges = True
    has_suffixes = True
    status = None  # that every answer has
    wanted = None  # that requests are authorized by
    busy = []      # statuses of the answers that come next
    silence = None  # an event that requests wait for; then they get no answer
    is_waiting = None  # set by those
    flips = 0      # answers of more than this many bytes have a wrong one; 0: none has

    def log_message(self, *_):
        pass

    def do_HEAD(self):
        self.answer(False)

    def do_GET(self):
        self.answer(True)

    def answer(self, has_body):
        if self.silence is not None:
            self.is_waiting.set()
            self.silence.wait(30)
            self.close_connection = True
            return
        file = pathlib.Path(self.directory, self.path.partition("?")[0].lstrip("/"))
        if not file.exists():
            self.send_error(404)
            return
        if self.status or self.busy:
            self.send_error(self.status or self.busy.pop())
            return
        if self.wanted and self.headers.get("Authorization") != self.wanted:
            self.send_error(401)
            return
        held = file.read_bytes()
        span = self.headers.get("Range", "")
        self.asked.append((self.command, span))
        asked = re.fullmatch(r"bytes=(\d*)-(\d+)", span)
        part = held
        if asked and self.has_ranges and (asked[1] or self.has_suffixes):
            first, last = int(asked[1] or max(0, len(held) - int(asked[2]))), int(asked[2])
            last = last if asked[1] else len(held) - 1
            part = held[first:last + 1]
            self.send_response(206)
            self.send_header("Content-Range", f"bytes {first}-{first + len(part) - 1}/{len(held)}")
        else:
            self.send_response(200)
        if self.has_ranges:
            self.send_header("Accept-Ranges", "bytes")
        self.send_header("Content-Length", str(len(part)))
        self.end_headers()
        if has_body:
            type(self).sent += len(part)
            if self.flips and len(part) > self.flips:
                part = part[:self.flips] + bytes([part[self.flips] ^ 1]) + part[self.flips + 1:]
            try:
                self.wfile.write(part)
            except ConnectionError:
                pass  # who asked had enough


@contextlib.contextmanager
def serving(folder):
    """Serves a folder. Gives the class that answers, to be told how, and the URL of the folder."""
    handler = type("Handler", (RangedFiles,), {"directory": folder, "asked": [], "busy": [],
                                               "is_waiting": threading.Event()})
    server = http.server.ThreadingHTTPServer(
        ("127.0.0.1", 0), lambda *a: handler(*a, directory=folder))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield handler, f"http://127.0.0.1:{server.server_port}"
    server.shutdown()
    server.server_close()
