"""A web server that answers byte by byte, as tests say, so that it can lie.

Each name under a server has a behavior of its own: a function that takes an Exchange and writes the
answer to it. It returns True where the connection may carry another request. Requests for the last
bytes of a file go to those that `knows_ends` marks; others answer that they have no such range.
"""

import itertools
import re
import socket
import socketserver
import ssl
import threading

END = b"\r\n\r\n"


def knows_ends(behavior):
    behavior.knows_ends = True
    return behavior


class Exchange:
    """One request and the connection its answer goes to.

    number   of the request of its name, from 0
    place    of the request on its connection, from 0
    headers  by names in lower case
    first, last, asked  the range that was asked for: asked = last - first + 1
    end      of a request for the last bytes, how many they are; else None
    server   the Server it came to
    """

    def __init__(self, connection, server, target, lines):
        self._connection = connection
        self.server = server
        self.target = target
        self.number = self.place = 0
        pairs = (line.split(":", 1) for line in lines if ":" in line)
        self.headers = {name.strip().lower(): value.strip() for name, value in pairs}
        field = self.headers.get("range", "")
        end = re.fullmatch(r"bytes=-(\d+)", field)
        self.end = int(end[1]) if end else None
        found = re.fullmatch(r"bytes=(\d+)-(\d+)", field)
        self.first, self.last = map(int, found.groups()) if found else (0, 0)
        self.asked = self.last - self.first + 1

    def send(self, data):
        self._connection.sendall(data if isinstance(data, bytes) else data.encode())

    def send_for_ever(self, data):
        while not self.server.is_closing.is_set():
            self.send(data)

    def wait(self, seconds):
        """Returns early when the server closes."""
        self.server.is_closing.wait(seconds)

    def fall_silent(self):
        """Keeps the connection open without a word until the other side has gone."""
        self._connection.settimeout(0.2)
        while not self.server.is_closing.is_set():
            try:
                if not self._connection.recv(1 << 16):
                    return
            except TimeoutError:
                continue

    def head(self, status, *headers, version="HTTP/1.1"):
        self.send("\r\n".join([f"{version} {status}", *headers, "", ""]))

    def answer(self, status, *headers, body=b"", version="HTTP/1.1"):
        self.head(status, *headers, f"Content-Length: {len(body)}", version=version)
        self.send(body)
        return True


class Server:
    """Serves on a free port of this machine, a thread for each connection, until it is closed.

    certificate  a file with certificate and key, for https
    family       AF_INET or AF_INET6: no address of the other is listened to
    requests     (target, headers) of all that came in
    """

    def __init__(self, certificate=None, family=socket.AF_INET):
        self.is_closing = threading.Event()
        self.requests = []
        self._behaviors = {}
        self._numbers = {}
        self._lock = threading.Lock()
        self._context = None
        if certificate:
            self._context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
            self._context.load_cert_chain(certificate)
        server = self

        class Handler(socketserver.BaseRequestHandler):
            def handle(self):
                server.serve(self.request)

        class Listener(socketserver.ThreadingTCPServer):
            address_family = family
            daemon_threads = True
            block_on_close = False
            request_queue_size = 64

        host = "127.0.0.1" if family == socket.AF_INET else "::1"
        self._listener = Listener((host, 0), Handler)
        self.port = self._listener.server_address[1]
        self.host = host if family == socket.AF_INET else f"[{host}]"
        threading.Thread(target=self._listener.serve_forever, daemon=True).start()

    def url(self, name, behavior=None, user="", query=""):
        """The URL of a file of this name, which is answered by `behavior` from now on."""
        if behavior:
            self._behaviors[name] = behavior
        scheme = "https" if self._context else "http"
        return (f"{scheme}://{user + '@' if user else ''}{self.host}:{self.port}/{name}/scan.8vo"
                f"{'?' + query if query else ''}")

    def close(self):
        self.is_closing.set()
        self._listener.shutdown()
        self._listener.server_close()

    def serve(self, connection):
        try:
            if self._context:
                connection = self._context.wrap_socket(connection, server_side=True)
            for place in itertools.count():
                if not self._serve_one(connection, place):
                    return
        except (OSError, ValueError):
            pass  # the other side has left
        finally:
            connection.close()

    def _serve_one(self, connection, place):
        head = b""
        while END not in head:
            data = connection.recv(1 << 16)
            if not data:
                return False
            head += data
        request, *lines = head.decode("latin-1").split("\r\n")
        target = request.split()[1]
        # A proxy is asked for whole URLs.
        name = re.sub(r"^https?://[^/]*", "", target).split("/")[1]
        exchange = Exchange(connection, self, target, lines)
        exchange.place = place
        self.requests.append((target, exchange.headers))
        behavior = self._behaviors[name]
        if exchange.end and not getattr(behavior, "knows_ends", False):
            return exchange.answer("416 Range Not Satisfiable")
        with self._lock:
            exchange.number = next(self._numbers.setdefault(name, itertools.count()))
        return behavior(exchange)
