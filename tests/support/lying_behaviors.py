"""What web servers may do to a reader: each method answers one request, rightly or wrongly."""

import gzip
import itertools
import struct

import lying_server

# What a volume of 2^18 voxels a side may need.
ROOT_BYTES = 5 << 29
PAGES_BYTES = 10**12
CLAIMED_BYTES = 512 + PAGES_BYTES + 2 + ROOT_BYTES + 96

TAG = 'ETag: "v1"'
WEAK_TAG = 'ETag: W/"v1"'

GARBAGE = b"HTTP/1.1 200 OK\r\n\x00garbage" * 50


class Behaviors:
    """What a server of `data` may do; each takes an Exchange."""

    def __init__(self, data):
        self.data = data
        self.other = data[:-70_000] + bytes(70_000)

    def part(self, x, *headers, data=None, first=None, last=None, total=None, **options):
        """A right answer, but for what is given."""
        data = self.data if data is None else data
        first = x.first if first is None else first
        last = min(x.last, len(data) - 1) if last is None else last
        total = len(data) if total is None else total
        return x.answer("206 Partial Content", f"Content-Range: bytes {first}-{last}/{total}",
                        *headers, body=data[first : last + 1], **options)

    def with_end(self, answer):
        """Right ranges, but that requests for the last bytes get `answer`."""
        @lying_server.knows_ends
        def behavior(x):
            if x.end is None:
                return self.good(x)
            x.first, x.last = max(0, len(self.data) - x.end), len(self.data) - 1
            x.asked = x.last - x.first + 1
            return answer(x)
        return behavior

    def range_header(self, x):
        return f"Content-Range: bytes {x.first}-{self.last(x)}/{len(self.data)}"

    def last(self, x):
        return min(x.last, len(self.data) - 1)

    def body(self, x):
        return self.data[x.first : self.last(x) + 1]

    # Answers that are right, if odd.

    def good(self, x):
        return self.part(x, TAG)

    def weak_tag(self, x):
        return self.part(x, WEAK_TAG)

    def http_1_0(self, x):
        self.part(x, TAG, version="HTTP/1.0")

    def garbage_behind(self, x):
        self.part(x, TAG)
        x.send(GARBAGE)
        return True

    def garbage_before(self, x):
        if x.place > 0:
            x.send(GARBAGE)
        return self.part(x, TAG)

    def wrong_charset(self, x):
        return self.part(x, TAG, "Content-Type: text/html; charset=utf-16")

    def short(self, x):
        return self.part(x, TAG, last=min(x.first + 9_999, self.last(x)))

    def one_byte(self, x):
        return self.part(x, TAG, last=x.first)

    def breaks_off(self, x):
        x.head("206 Partial Content", self.range_header(x), TAG, f"Content-Length: {x.asked}")
        x.send(self.body(x)[: x.asked // 2 + 1])

    # Answers that are wrong.

    def whole_file(self, x):
        x.head("200 OK", f"Content-Length: {100 * 10**9}")
        x.send_for_ever(bytes(1 << 16))

    def wrong_range(self, x):
        return self.part(x, first=x.first + 5)

    def no_range(self, x):
        return x.answer("206 Partial Content", TAG, body=self.body(x))

    def two_ranges(self, x):
        return self.part(x, "Content-Range: bytes 7-9/10")

    def changing_total(self, x):
        return self.part(x, TAG, total=len(self.data) + x.number)

    def changing_tag(self, x):
        return self.part(x, f'ETag: "v{x.number}"')

    def changing_weak_tag(self, x):
        return self.part(x, f'ETag: W/"v{x.number}"')

    def changing_in_between(self, x):
        tag = f'ETag: "v{min(x.number, 1)}"'
        return self.part(x, tag, last=min(x.first + 9_999, self.last(x)))

    def other_file(self, x, *headers):
        return self.part(x, *headers, data=self.other if x.number else self.data)

    def gzipped(self, x):
        return x.answer("206 Partial Content", self.range_header(x), "Content-Encoding: gzip",
                        body=gzip.compress(self.body(x)))

    def gzip_lie(self, x):
        return self.part(x, "Content-Encoding: gzip")

    def short_body(self, x):
        return x.answer("206 Partial Content", self.range_header(x), body=self.body(x)[:-10])

    def long_body(self, x):
        x.head("206 Partial Content", self.range_header(x), "Connection: close")
        x.send_for_ever(bytes(1 << 16))

    def empty(self, x):
        x.head("206 Partial Content", self.range_header(x), "Retry-After: 1000")

    def multipart(self, x):
        part = (f"--cut\r\n{self.range_header(x)}\r\n\r\n").encode() + self.body(x) + b"\r\n--cut--"
        return x.answer("206 Partial Content", "Content-Type: multipart/byteranges; boundary=cut",
                        body=part)

    def flipped_byte(self, x):
        data = bytearray(self.data)
        data[600] ^= 8
        return self.part(x, TAG, data=bytes(data))

    def flipped_byte_at_first(self, count):
        """flipped_byte for so many answers that hold it."""
        numbers = itertools.count()

        def behavior(x):
            is_flipped = x.first <= 600 <= x.last and next(numbers) < count
            return self.flipped_byte(x) if is_flipped else self.good(x)
        return behavior

    def escapes(self, x):
        return x.answer("206 \x1b]0;mine\x07", "Content-Range: bytes \x1b[31m0-9/10\x1b[0m",
                        "Content-Encoding: \x1b[2Jx", TAG, body=self.body(x))

    def no_head(self, x):
        x.send(self.body(x))

    def closes(self, _):
        return False

    def huge_root(self, x):
        """Claims an index root of 2.5 GiB, of which a thousand bytes come."""
        if x.number == 0:
            return self.part(x, TAG, data=claims_a_root(self.data), total=CLAIMED_BYTES)
        if x.number > 1:
            return self.silent(x)
        x.head("206 Partial Content", f"Content-Range: bytes {x.first}-{x.last}/{CLAIMED_BYTES}",
               TAG, f"Content-Length: {x.asked}")
        x.send(bytes(1000))
        return x.fall_silent()

    # Servers that do not come to an end.

    def endless_headers(self, x):
        x.send("HTTP/1.1 206 Partial Content\r\n")
        x.send_for_ever("X-More: and more\r\n" * 100)

    def endless_header(self, x):
        x.send("HTTP/1.1 206 Partial Content\r\nX-More: ")
        x.send_for_ever("and more " * 100)

    def endless_continue(self, x):
        x.send_for_ever("HTTP/1.1 100 Continue\r\n\r\n" * 50)

    def silent(self, x):
        x.fall_silent()

    def stops_in_each_body(self, x):
        x.head("206 Partial Content", self.range_header(x), f"Content-Length: {x.asked}")
        x.send(self.body(x)[:60_000])
        x.fall_silent()

    def forgets_the_connection(self, x):
        return self.good(x) if x.place == 0 else x.fall_silent()

    def stops_in_a_body(self, x):
        return self.stops_in_each_body(x) if x.number == 0 else self.silent(x)

    def trickle(self, x):
        x.head("206 Partial Content", self.range_header(x), f"Content-Length: {x.asked}")
        for at in range(0, x.asked, 15):
            x.send(self.body(x)[at : at + 15])
            x.wait(0.1)

    def late(self, x):
        if x.number == 0:
            x.wait(6.5)
        return self.good(x)

    # Servers that are busy, and those that send elsewhere.

    def busy(self, x, status, *headers, times=10**9):
        return x.answer(status, *headers) if x.number < times else self.good(x)

    def busy_before_each_byte(self, x, *headers):
        return self.one_byte(x) if x.number % 2 else self.busy(x, "503 Busy", *headers)

    def redirect(self, x, location, status="302 Found"):
        return x.answer(status, f"Location: {location}")

    def to_itself(self, x):
        return self.redirect(x, x.target)

    def endless_redirect(self, x, status, *headers):
        x.head(status, *headers, f"Content-Length: {100 * 10**9}")
        x.send_for_ever(bytes(1 << 12))

    def needs_password(self, x):
        return self.good(x) if "authorization" in x.headers else x.answer("401 Unauthorized")

    def needs_no_password(self, x):
        return x.answer("400 Bad Request") if "authorization" in x.headers else self.good(x)


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x82F63B78 & -(crc & 1))
    return crc ^ 0xFFFFFFFF


def claims_a_root(data):
    """The head of `data` as that of a huge volume: its size, and what its parts have to measure."""
    header = bytearray(data[:512])
    header[14] = 18
    header[16:48] = bytes([7] * 18 + [0] * 14)
    struct.pack_into("<3Q", header, 48, *[1 << 18] * 3)
    metadata = 512 + PAGES_BYTES
    struct.pack_into("<Q", header, 224, CLAIMED_BYTES)
    struct.pack_into("<QQII", header, 232, metadata, 2, 0, 0)
    struct.pack_into("<QQII", header, 256, 512, PAGES_BYTES, 0, 0)
    struct.pack_into("<QQII", header, 280, metadata + 2, ROOT_BYTES, 0, 0)
    struct.pack_into("<QQII", header, 304, metadata, 0, 0, 0)
    struct.pack_into("<I", header, 508, crc32c(header[:508]))
    return bytes(header) + bytes(1 << 16)
