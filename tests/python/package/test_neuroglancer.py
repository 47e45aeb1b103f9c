"""neuroglancer in a browser, unchanged, on what the program serves as zarr."""

import http.client
import http.server
import os
import re
import shutil
import subprocess
import threading

import numpy as np
import pytest

import octavo

neuroglancer = pytest.importorskip("neuroglancer")
CHROMIUM = shutil.which("chromium")
pytestmark = pytest.mark.skipif(CHROMIUM is None or "OCTAVO_LONG" not in os.environ,
                                reason="starts a browser")
SHAPE = (80, 96, 150)
SIDE = 64
BRIGHT = 900
ZOOM = 4
WINDOW = (700, 560)


class Witness(http.server.BaseHTTPRequestHandler):
    """Passes requests on to the program and writes down what it answers."""

    protocol_version = "HTTP/1.1"
    port = 0
    answers = {}
    changed = threading.Condition()

    def pass_on(self):
        """The same request and the same answer; the Host is that of the program."""
        there = http.client.HTTPConnection("127.0.0.1", self.port)
        fields = {name: value for name, value in self.headers.items()
                  if name.lower() not in ("host", "connection")}
        there.request(self.command, self.path, headers=fields)
        answer = there.getresponse()
        body = answer.read()
        there.close()
        self.send_response(answer.status)
        for name, value in answer.getheaders():
            if name.lower() not in ("connection", "content-length", "date", "server"):
                self.send_header(name, value)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)
        if self.command == "GET":
            with self.changed:
                self.answers[self.path] = (answer.status, body)
                self.changed.notify_all()

    do_GET = do_HEAD = do_OPTIONS = pass_on

    def log_message(self, *_):
        pass


@pytest.fixture
def voxels():
    """Bright where x, y and z are small: no turn and no mirror image looks the same."""
    z, y, x = np.indices(SHAPE)
    return np.where((z < 60) & (y < 40) & (x < 100), BRIGHT, z % 7).astype(np.int16)


@pytest.fixture
def witness(voxels, tmp_path):
    octavo.build(voxels, tmp_path / "scan.8vo", spacing=(0.5, 0.5, 0.5)).close()
    served = subprocess.Popen(
        [os.environ["OCTAVO"], "serve", tmp_path / "scan.8vo", "--as", "zarr3", "--allow-origin",
         "*", "--json"], stdout=subprocess.PIPE, text=True)
    said = ""
    while "scan.8vo.zarr" not in said:
        line = served.stdout.readline()
        assert line, said
        said += line
    Witness.port = int(re.search(r"127\.0\.0\.1:(\d+)/scan\.8vo\.zarr", said)[1])
    Witness.answers = {}
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Witness)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_address[1]}/scan.8vo.zarr/"
    server.shutdown()
    served.terminate()
    served.wait()


def chunk_of(voxels, place):
    """The bytes of a chunk of level 0, whose voxels outside are 0."""
    padded = np.zeros((SIDE,) * 3, "<i2")
    part = voxels[tuple(slice(SIDE * n, SIDE * (n + 1)) for n in place)]
    padded[tuple(slice(0, n) for n in part.shape)] = part
    return padded.tobytes()


def test_neuroglancer_asks_for_the_chunks_it_shows_and_shows_them_in_place(witness, voxels,
                                                                          tmp_path):
    neuroglancer.set_server_bind_address("127.0.0.1")
    viewer = neuroglancer.Viewer()
    with viewer.txn() as state:
        state.dimensions = neuroglancer.CoordinateSpace(names=["z", "y", "x"], units="mm",
                                                        scales=[0.5, 0.5, 0.5])
        state.layers["scan"] = neuroglancer.ImageLayer(
            source=f"zarr3://{witness}",
            shader_controls={"normalized": {"range": [0, BRIGHT]}})
        state.layout = "xy"
        state.position = [SHAPE[0] / 2, SHAPE[1] / 2, SHAPE[2] / 2]
        state.cross_section_scale = 1 / ZOOM
        state.show_axis_lines = state.show_scale_bar = state.show_default_annotations = False
        state.cross_section_background_color = "#000000"
    browser = subprocess.Popen(
        [CHROMIUM, "--headless=new", "--no-sandbox", "--use-angle=swiftshader",
         "--enable-unsafe-swiftshader", "--no-first-run", "--disable-background-networking",
         "--disable-component-update", "--disable-sync", f"--window-size={WINDOW[0]},{WINDOW[1]}",
         f"--user-data-dir={tmp_path / 'profile'}", viewer.get_viewer_url()],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        # The client takes z, the first axis, to the right and y down, and stands in the middle of
        # x: it needs the chunks there.
        needed = {"/scan.8vo.zarr/0/c/" + "/".join(map(str, (z, y, SHAPE[2] // 2 // SIDE)))
                  for z in range(2) for y in range(2)}
        with Witness.changed:
            Witness.changed.wait_for(lambda: needed <= set(Witness.answers))
        picture = viewer.screenshot(size=WINDOW).screenshot.image_pixels
    finally:
        browser.terminate()
        browser.wait()
    assert Witness.answers["/scan.8vo.zarr/zarr.json"][0] == 200
    chunks = {path: answer for path, answer in Witness.answers.items() if "/0/c/" in path}
    assert len(chunks) >= 4
    for path, (status, body) in chunks.items():
        assert status == 200, path
        place = tuple(int(n) for n in path.split("/c/")[1].split("/"))
        assert body == chunk_of(voxels, place), path
    if folder := os.environ.get("OCTAVO_PICTURES"):
        from PIL import Image
        Image.fromarray(picture).save(os.path.join(folder, "neuroglancer.png"))
    for z, y, is_bright in ((30, 20, True), (2, 2, True), (57, 37, True), (70, 20, False),
                            (30, 60, False), (77, 93, False), (84, 20, False), (30, 100, False)):
        column = round(WINDOW[0] / 2 + (z - SHAPE[0] / 2 + 0.5) * ZOOM)
        row = round(WINDOW[1] / 2 + (y - SHAPE[1] / 2 + 0.5) * ZOOM)
        assert (picture[row, column, :3].min() > 230) == is_bright, (z, y)
        if not is_bright:
            assert picture[row, column, :3].max() < 10, (z, y)
