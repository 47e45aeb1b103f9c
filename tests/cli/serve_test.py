#!/usr/bin/env python3
"""Files given out over HTTP, and folders for web servers, from outside.

usage: serve_test.py OCTAVO [unittest arguments]

The page of the viewer is a made-up one here: OCTAVO_WEB names its folder.
"""

import functools
import http.client
import json
import os
import pathlib
import random
import re
import signal
import socket
import stat
import subprocess
import sys
import tempfile
import unittest
import urllib.parse
import urllib.request

import cli_test
import lying_server
from lying_behaviors import Behaviors

PAGE = {"index.html": "<p>page", "style.css": "p {}", "viewer.js": "1", "worker.js": "2",
        "octavo.wasm": "3", "HOSTING.md": "4"}
ORIGIN = "https://viewer.example"


@functools.cache
def phantom():
    """The bytes of a file that all tests give out."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([cli_test.OCTAVO, "phantom", "--size", "40", "-q", "-o", "p.8vo"],
                       cwd=folder, check=True)
        return pathlib.Path(folder, "p.8vo").read_bytes()


class Serving(cli_test.InFolder):
    """A folder with a volume, a page, and a server that ends with the test."""

    def setUp(self):
        super().setUp()
        self.bytes = phantom()
        (self.folder / "a b.8vo").write_bytes(self.bytes)
        self.page = self.folder / "page"
        self.page.mkdir()
        for name, text in PAGE.items():
            (self.page / name).write_text(text)
        self.environment = {**os.environ, "OCTAVO_WEB": str(self.page)}

    def serve(self, *arguments, before=(), page=True):
        environment = self.environment if page else {**self.environment,
                                                     "OCTAVO_WEB": str(self.folder / "none")}
        # pylint: disable=consider-using-with
        process = subprocess.Popen(
            [*before, cli_test.OCTAVO, *arguments, "--json"], cwd=self.folder, env=environment,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
        self.addCleanup(self.end, process)
        line = process.stdout.readline()
        self.assertTrue(line, process.stderr.read() if not line else "")
        text = line
        while not text.rstrip().endswith("}") or text.count("{") != text.count("}"):
            text += process.stdout.readline()
        return process, json.loads(text)

    def end(self, process):
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGTERM)
        process.communicate()

    def ask(self, site, path, method="GET", **fields):
        connection = http.client.HTTPConnection("127.0.0.1", site["port"], timeout=30)
        headers = {name.replace("_", "-"): value for name, value in fields.items()}
        connection.request(method, path, headers=headers)
        answer = connection.getresponse()
        body = answer.read()
        connection.close()
        return answer, body


class ZarrFacade(Serving):
    """The files of a zarr hierarchy that are made when they are asked for."""

    SIZE = (70, 66, 130)  # x, y, z

    def setUp(self):
        super().setUp()
        x, y, z = self.SIZE
        self.voxels = random.Random(4).randbytes(x * y * z)
        (self.folder / "v.raw").write_bytes(self.voxels)
        self.expect(0, "build", "v.raw", "--raw", f"{x},{y},{z},uint8", "--spacing", "2", "-o",
                    "v.8vo", "-q")

    def chunk(self, voxels, size, place):
        """64^3 voxels from x, y, z of a volume of that size, 0 behind its end."""
        out = bytearray(64 ** 3)
        for dz, dy in ((dz, dy) for dz in range(64) for dy in range(64)):
            z, y = 64 * place[2] + dz, 64 * place[1] + dy
            if z >= size[2] or y >= size[1]:
                continue
            start = (z * size[1] + y) * size[0]
            row = voxels[start + 64 * place[0]:start + min(size[0], 64 * place[0] + 64)]
            at = (dz * 64 + dy) * 64
            out[at:at + len(row)] = row
        return bytes(out)

    def test_texts_and_chunks_of_all_levels_are_there(self):
        _, site = self.serve("serve", "v.8vo", "--as", "zarr3")
        base = f"http://127.0.0.1:{site['port']}/v.8vo.zarr/"
        self.assertEqual(site["zarr3"], [base])
        answer, body = self.ask(site, "/v.8vo.zarr/zarr.json")
        self.assertEqual((answer.status, answer.headers["Content-Type"]),
                         (200, "application/json"))
        image = json.loads(body)["attributes"]["ome"]["multiscales"][0]
        # Of coarser levels than one chunk the last voxel reaches far beyond the volume.
        self.assertEqual([dataset["path"] for dataset in image["datasets"]], ["0", "1", "2"])
        for level in range(7):
            array = json.loads(self.ask(site, f"/v.8vo.zarr/{level}/zarr.json")[1])
            size = array["shape"][::-1]
            self.expect(0, "export", "v.8vo", "--level", str(level), "-o", "l.mhd", "-f")
            voxels = (self.folder / "l.raw").read_bytes()
            if level == 0:
                self.assertEqual(voxels, self.voxels)
            for z in range(-(-size[2] // 64)):
                for y in range(-(-size[1] // 64)):
                    for x in range(-(-size[0] // 64)):
                        answer, body = self.ask(site, f"/v.8vo.zarr/{level}/c/{z}/{y}/{x}")
                        self.assertEqual(answer.status, 200)
                        self.assertEqual(body, self.chunk(voxels, size, (x, y, z)))
        answer, body = self.ask(site, "/v.8vo.zarr/0/c/0/0/0", Range="bytes=64-127")
        self.assertEqual((answer.status, body), (206, self.voxels[70:134]))

    def test_nothing_else_is_there(self):
        _, site = self.serve("serve", "v.8vo", "--as", "zarr3")
        for key in ("", "0", "0/", "0/c", "0/c/0/0", "0/c/0/0/0/", "0/c/0/0/0/0", "0/c/3/0/0",
                    "0/c/0/2/0", "0/c/0/0/2", "0/c/-1/0/0", "0/c/00/0/0", "0/c/+0/0/0",
                    "0/c/0/0/99999999999999999999", "00/zarr.json", "99/zarr.json", "0/zarr.json/",
                    "../v.8vo", "0/../zarr.json", "0//zarr.json", "/zarr.json", ".zgroup",
                    "0/c/0/0/0%00", "zarr.json%2f", "%2e%2e/%2e%2e/etc/passwd"):
            self.assertEqual(self.ask(site, f"/v.8vo.zarr/{key}")[0].status, 404, key)
        self.assertEqual(self.ask(site, "/v.8vo.zarr/zarr.json", "POST")[0].status, 405)
        self.assertEqual(self.ask(site, "/v.8vo.zarr/zarr.json", Host="x.example")[0].status, 403)
        self.assertEqual(self.ask(site, "/v.8vo.zarr/zarr.json", Origin=ORIGIN)[0].status, 403)
        _, plain = self.serve("serve", "v.8vo")
        self.assertEqual(self.ask(plain, "/v.8vo.zarr/zarr.json")[0].status, 404)
        self.assertNotIn("zarr3", plain)

    def test_pages_of_allowed_origins_read_it_behind_a_token(self):
        _, site = self.serve("serve", "v.8vo", "--as", "zarr3", "--allow-origin", ORIGIN,
                             "--token", "auto")
        path = urllib.parse.urlsplit(site["zarr3"][0]).path
        answer, _ = self.ask(site, path + "zarr.json", Origin=ORIGIN)
        self.assertEqual(answer.status, 200)
        self.assertEqual(answer.headers["Access-Control-Allow-Origin"], ORIGIN)
        self.assertEqual(self.ask(site, "/v.8vo.zarr/zarr.json", Origin=ORIGIN)[0].status, 404)

    def test_a_damaged_brick_is_an_error_and_the_others_go_on(self):
        held = bytearray((self.folder / "v.8vo").read_bytes())
        held[len(held) // 3] ^= 1
        (self.folder / "v.8vo").write_bytes(held)
        _, site = self.serve("serve", "v.8vo", "--as", "zarr3")
        answers = [self.ask(site, f"/v.8vo.zarr/0/c/{z}/{y}/{x}")[0].status
                   for z in range(3) for y in range(2) for x in range(2)]
        self.assertEqual(sorted(set(answers)), [200, 500], answers)


class Server(Serving):
    def test_a_file_its_page_and_the_list_are_there_and_nothing_else(self):
        _, site = self.serve("serve", "a b.8vo")
        self.assertEqual(site["url"], f"http://127.0.0.1:{site['port']}/?url=a%20b.8vo")
        answer, body = self.ask(site, "/a%20b.8vo")
        self.assertEqual((answer.status, body), (200, self.bytes))
        self.assertEqual(answer.headers["Content-Type"], "application/vnd.octavo")
        answer, body = self.ask(site, "/a%20b.8vo", Range="bytes=100-199")
        self.assertEqual((answer.status, body), (206, self.bytes[100:200]))
        self.assertEqual(self.ask(site, "/")[1], b"<p>page")
        listed = json.loads(self.ask(site, "/files.json")[1])
        self.assertEqual(listed, [{"title": "a b.8vo", "url": "a%20b.8vo"}])
        for path in ("/page", "/none", "/../a%20b.8vo", "/%2e%2e/x", "/etc/passwd", "//a%20b.8vo"):
            self.assertEqual(self.ask(site, path)[0].status, 404, path)

    def test_requests_are_answered_where_the_system_opens_no_more_connections(self):
        _, site = self.serve("serve", "a b.8vo",
                             before=("bash", "-c", 'ulimit -n 24; exec "$0" "$@"'))
        idle = [socket.create_connection(("127.0.0.1", site["port"]), timeout=30)
                for _ in range(60)]
        for one in idle:
            self.addCleanup(one.close)
        self.assertEqual(self.ask(site, "/a%20b.8vo")[1], self.bytes)

    def test_no_address_opens_another_file(self):
        log = self.folder / "opened"
        _, site = self.serve("serve", "a b.8vo",
                             before=("strace", "-f", "-qq", "-e", "trace=openat", "-o", log))
        self.ask(site, "/")
        before = log.read_text().count("openat")
        source = random.Random(3)
        pieces = ["..", "%2e%2e", "/", "\\", "%5c", "%00", "a b.8vo", "etc", "passwd", "//", "%2f",
                  "%c0%ae", "?", "#", ";", "~", "proc/self/environ", "%252e", "."]
        for _ in range(300):
            path = "/" + "".join(source.choice(pieces) for _ in range(source.randint(1, 6)))
            with socket.create_connection(("127.0.0.1", site["port"]), timeout=30) as client:
                client.sendall(f"GET {path.replace(' ', '%20')} HTTP/1.0\r\n"
                               f"Host: localhost:{site['port']}\r\n\r\n".encode())
                status = int(client.makefile("rb").readline().split()[1])
            expected = (200,) if path.split("?")[0] in ("/", "/a b.8vo") else (400, 404)
            self.assertIn(status, expected, path)
        self.assertEqual(log.read_text().count("openat"), before)

    def test_only_this_machine_is_listened_to_and_other_names_are_rejected(self):
        _, site = self.serve("serve", "a b.8vo")
        own = f"localhost:{site['port']}"
        self.assertEqual(self.ask(site, "/", Host=own)[0].status, 200)
        for host in ("evil.example", f"evil.example:{site['port']}", "localhost", "127.0.0.1"):
            self.assertEqual(self.ask(site, "/", Host=host)[0].status, 403, host)
        self.assertEqual(self.ask(site, "/", Origin=ORIGIN)[0].status, 403)
        listening = pathlib.Path("/proc/net/tcp").read_text()
        self.assertRegex(listening, rf"0100007F:{site['port']:04X} 00000000:0000 0A")
        self.assertNotRegex(listening, rf"00000000:{site['port']:04X} 00000000:0000 0A")

    def test_pages_of_other_sites_may_read_where_that_is_asked_for(self):
        _, site = self.serve("serve", "a b.8vo", "--allow-origin", ORIGIN)
        answer, _ = self.ask(site, "/a%20b.8vo", Origin=ORIGIN, Range="bytes=0-9")
        self.assertEqual((answer.status, answer.headers["Access-Control-Allow-Origin"]),
                         (206, ORIGIN))
        self.assertEqual(self.ask(site, "/", Origin="https://x.example")[0].status, 403)

    def test_others_need_a_token(self):
        error = self.expect(2, "serve", "a b.8vo", "--bind", "0.0.0.0", env=self.environment)
        self.assertIn("--token auto", error.stderr)
        self.expect(2, "serve", "a b.8vo", "--token", "short", env=self.environment)
        _, site = self.serve("serve", "a b.8vo", "--bind", "0.0.0.0", "--token", "auto")
        host, token = re.fullmatch(r"http://([\d.]+):\d+/([\w-]{22})/\?url=a%20b\.8vo",
                                   site["url"]).groups()
        self.assertNotEqual(host, "0.0.0.0")
        with urllib.request.urlopen(site["files"][0], timeout=30) as answer:
            self.assertEqual(answer.read(), self.bytes)
        self.assertEqual(self.ask(site, f"/{token}/a%20b.8vo", Host="my.host")[1], self.bytes)
        self.assertEqual(self.ask(site, f"/{token}/")[1], b"<p>page")
        for path in ("/", "/a%20b.8vo", f"/{token[:-1]}/", f"/{token}x/"):
            self.assertEqual(self.ask(site, path)[0].status, 404, path)

    def test_a_file_that_is_replaced_is_served_as_it_is_now(self):
        _, site = self.serve("serve", "a b.8vo")
        first, _ = self.ask(site, "/a%20b.8vo")
        self.expect(0, "phantom", "--size", "44", "-o", "a b.8vo", "--force")
        second, body = self.ask(site, "/a%20b.8vo")
        self.assertEqual(body, (self.folder / "a b.8vo").read_bytes())
        self.assertNotEqual(first.headers["ETag"], second.headers["ETag"])
        stale, _ = self.ask(site, "/a%20b.8vo", If_Match=first.headers["ETag"])
        self.assertEqual(stale.status, 412)

    def test_a_file_that_becomes_a_link_is_not_followed(self):
        _, site = self.serve("serve", "a b.8vo")
        (self.folder / "secret").write_text("of others")
        (self.folder / "a b.8vo").unlink()
        (self.folder / "a b.8vo").symlink_to("secret")
        answer, body = self.ask(site, "/a%20b.8vo")
        self.assertEqual(answer.status, 404)
        self.assertNotIn(b"of others", body)

    def test_without_a_page_files_alone_are_served_and_view_says_what_is_missing(self):
        _, site = self.serve("serve", "a b.8vo", page=False)
        self.assertFalse(site["page"])
        self.assertEqual(self.ask(site, "/")[0].status, 404)
        self.assertEqual(self.ask(site, "/a%20b.8vo")[1], self.bytes)
        error = self.expect(5, "view", "a b.8vo",
                            env={**self.environment, "OCTAVO_WEB": str(self.folder / "none")})
        self.assertIn("tools/build_web", error.stderr)

    def test_what_is_no_volume_is_not_served(self):
        (self.folder / "x.8vo").write_bytes(b"nothing")
        self.expect(3, "serve", "x.8vo", env=self.environment)
        self.expect(5, "serve", "none.8vo", env=self.environment)
        self.expect(2, "serve", "https://example.org/a.8vo", env=self.environment)

    def test_a_taken_port_is_an_error_and_a_signal_ends_the_server(self):
        process, site = self.serve("serve", "a b.8vo")
        error = self.expect(5, "serve", "a b.8vo", "--port", str(site["port"]),
                            env=self.environment)
        self.assertIn("--port", error.stderr)
        os.kill(process.pid, signal.SIGINT)
        self.assertEqual(process.wait(timeout=30), 130)

    def test_view_opens_the_browser_that_is_named(self):
        browser = self.folder / "browser"
        browser.write_text('#!/bin/sh\necho "$1" > opened\n')
        # Opening it waits until the browser has opened the other end.
        os.mkfifo(self.folder / "opened")
        browser.chmod(browser.stat().st_mode | stat.S_IXUSR)
        self.environment["BROWSER"] = str(browser)
        _, site = self.serve("view", "a b.8vo")
        self.assertEqual((self.folder / "opened").read_text().strip(), site["url"])
        _, site = self.serve("view", "https://example.org/c d.8vo")
        self.assertEqual((self.folder / "opened").read_text().strip(), site["url"])
        query = urllib.parse.urlparse(site["url"]).query
        self.assertEqual(urllib.parse.parse_qs(query), {"url": ["https://example.org/c d.8vo"]})


class Publishing(Serving):
    def publish(self, code, *arguments):
        return self.expect(code, "publish", *arguments, env=self.environment)

    def test_a_folder_has_the_page_the_volumes_and_a_list_of_them(self):
        (self.folder / "sub").mkdir()
        (self.folder / "sub" / "a b.8vo").write_bytes(self.bytes)
        self.publish(0, "a b.8vo", "sub/a b.8vo", "-o", "site")
        site = self.folder / "site"
        self.assertEqual(sorted(path.name for path in site.iterdir()),
                         sorted([*PAGE, "a b.8vo", "a b-2.8vo", "files.json"]))
        self.assertEqual((site / "a b-2.8vo").read_bytes(), self.bytes)
        listed = json.loads((site / "files.json").read_text())
        self.assertEqual([row["url"] for row in listed], ["a%20b.8vo", "a%20b-2.8vo"])

    def test_what_is_behind_a_url_is_called_without_its_secrets(self):
        (self.folder / "far.8vo").write_bytes(self.bytes)
        _, site = self.serve("serve", "far.8vo")
        self.publish(0, f"http://127.0.0.1:{site['port']}/far.8vo?token=a/b.8vo", "-o", "site")
        self.assertEqual(sorted(path.name for path in (self.folder / "site").iterdir()),
                         sorted([*PAGE, "far.8vo", "files.json"]))
        self.assertEqual((self.folder / "site" / "far.8vo").read_bytes(), self.bytes)

    def test_what_was_changed_on_its_way_is_copied_once_more(self):
        server = lying_server.Server()
        self.addCleanup(server.close)
        behaviors = Behaviors(self.bytes)
        for count in (1, 2):
            url = server.url(str(count), behaviors.flipped_byte_at_first(count))
            self.publish(0, url, "-o", f"site{count}")
            published = self.folder / f"site{count}" / "scan.8vo"
            self.assertEqual(published.read_bytes(), self.bytes, count)
        error = self.publish(4, server.url("damaged", behaviors.flipped_byte), "-o", "site")
        self.assertIn("scan.8vo: model 0 at byte 512: ", error.stderr)
        self.assertIn("one flipped bit, byte 600", error.stderr)
        # That takes files alone.
        self.assertNotIn("repair", error.stderr)
        self.assertFalse((self.folder / "site").exists())

    def test_a_page_without_words_on_hosting_is_not_said_to_have_them(self):
        self.assertIn("HOSTING.md", self.publish(0, "a b.8vo", "-o", "told").stdout)
        (self.page / "HOSTING.md").unlink()
        self.assertNotIn("HOSTING.md", self.publish(0, "a b.8vo", "-o", "untold").stdout)

    def test_nothing_is_replaced_unless_that_is_asked_for(self):
        self.publish(0, "a b.8vo", "-o", "site")
        (self.folder / "site" / "own.txt").write_text("mine")
        before = {p.name: p.read_bytes() for p in (self.folder / "site").iterdir()}
        (self.page / "viewer.js").write_text("new")
        self.publish(5, "a b.8vo", "-o", "site")
        self.assertEqual(before,
                         {p.name: p.read_bytes() for p in (self.folder / "site").iterdir()})
        self.publish(0, "a b.8vo", "-o", "site", "--force")
        self.assertEqual((self.folder / "site" / "viewer.js").read_text(), "new")
        self.assertEqual((self.folder / "site" / "own.txt").read_text(), "mine")

    def listed(self, site):
        return [row["title"] for row in json.loads((self.folder / site / "files.json").read_text())]

    def test_what_was_published_before_stays_listed_while_it_is_there(self):
        (self.folder / "a.8vo").write_bytes(self.bytes)
        (self.folder / "c d.8vo").write_bytes(self.bytes)
        self.assertNotIn("before", self.publish(0, "a b.8vo", "c d.8vo", "-o", "site").stdout)
        said = self.publish(0, "a.8vo", "-o", "site", "--force").stdout
        self.assertIn("site/files.json: also lists what was published before: a b.8vo and 1 more",
                      said)
        self.assertEqual(self.listed("site"), ["a.8vo", "a b.8vo", "c d.8vo"])
        # One of the same name is listed once, one that is gone no more, others as they were.
        (self.folder / "site" / "a b.8vo").unlink()
        list_path = self.folder / "site" / "files.json"
        rows = json.loads(list_path.read_text())
        rows += [{"title": "far", "url": "https://example.org/a.8vo"}, 5, {"title": "no address"}]
        list_path.write_text(json.dumps(rows))
        result = json.loads(self.publish(0, "c d.8vo", "-o", "site", "--force", "--json").stdout)
        self.assertEqual(result["listed"], ["a.8vo", "far"])
        self.assertEqual(self.listed("site"), ["c d.8vo", "a.8vo", "far"])

    def test_a_list_that_is_none_is_said_to_be_replaced(self):
        self.publish(0, "a b.8vo", "-o", "site")
        for wrong in ["[", "{}", '"a"', "[{", "\xff", ""]:
            (self.folder / "site" / "files.json").write_text(wrong, encoding="latin-1")
            said = self.publish(0, "a b.8vo", "-o", "site", "--force")
            self.assertIn("files.json was no list of volumes; it is replaced", said.stderr)
            self.assertEqual(self.listed("site"), ["a b.8vo"])

    def test_a_published_folder_gives_its_page_alone(self):
        (self.folder / "other.8vo").write_bytes(self.bytes)
        self.publish(0, "other.8vo", "-o", "first")
        self.environment["OCTAVO_WEB"] = str(self.folder / "first")
        self.publish(0, "a b.8vo", "-o", "second")
        self.assertEqual(sorted(path.name for path in (self.folder / "second").iterdir()),
                         sorted([*PAGE, "a b.8vo", "files.json"]))
        _, site = self.serve("serve", "a b.8vo")
        self.assertEqual(self.ask(site, "/other.8vo")[0].status, 404)

    def test_a_failure_leaves_nothing(self):
        (self.folder / "x.8vo").write_bytes(self.bytes[:-1])
        self.publish(4, "a b.8vo", "x.8vo", "-o", "site")
        (self.page / "worker.js").unlink()
        error = self.publish(5, "a b.8vo", "-o", "site")
        self.assertIn("worker.js", error.stderr)
        self.assertFalse((self.folder / "site").exists())

    def test_a_damaged_volume_is_not_published(self):
        damaged = bytearray(self.bytes)
        damaged[600] ^= 1
        (self.folder / "x.8vo").write_bytes(damaged)
        error = self.publish(4, "a b.8vo", "x.8vo", "-o", "site")
        self.assertRegex(error.stderr,
                         r"x.8vo: model 0 at byte 512: .*\(one flipped bit, byte 600\)")
        self.assertIn("repair", error.stderr)
        self.assertFalse((self.folder / "site").exists())
        self.publish(0, "a b.8vo", "-o", "site")
        kept = {path.name: path.read_bytes() for path in (self.folder / "site").iterdir()}
        damaged[600:700] = bytes(100)
        (self.folder / "a b.8vo").write_bytes(damaged)
        error = self.publish(4, "a b.8vo", "-o", "site", "--force")
        self.assertIn("a b.8vo: model 0 at byte 512: ", error.stderr)
        self.assertNotIn("repair", error.stderr)
        self.assertEqual(
            {path.name: path.read_bytes() for path in (self.folder / "site").iterdir()}, kept)


if __name__ == "__main__":
    cli_test.OCTAVO = os.path.abspath(sys.argv.pop(1))
    unittest.main()
