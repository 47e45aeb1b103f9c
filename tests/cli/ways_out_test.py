#!/usr/bin/env python3
"""What a file keeps of the identity of its source leaves it by no verb that is not asked for it.

usage: ways_out_test.py OCTAVO [unittest arguments]

The files have a secret in every place of the identity; every byte of what is made of them is
searched, packed or not.
"""

import gzip
import io
import json
import pathlib
import shutil
import sys
import unittest
import zipfile

import cli_test
import serve_test
from file_bytes import with_metadata

SECRET = "Zaphod"
SIZE = (16, 16, 16)
NAMES = ["PatientName", "PatientID", "PatientComments", "InstitutionName", "SegmentLabel",
         "FileName", "comment", "descrip", "aux_file", "key/value pair", "title", "label"]

# What is made of g, grey values, and l, labels; each into a folder of its own.
WAYS = {
    "build": [["g.8vo", "-o", "out/a.8vo"],
              ["g.8vo", "--max-error", "1", "-o", "out/b.8vo"],
              ["g.8vo", "--isotropic", "-o", "out/c.8vo"],
              ["g.8vo", "--parts", "2", "-o", "out/d.8vo"],
              ["l.8vo", "-o", "out/e.8vo"]],
    "export": [[f"{name}.8vo", "-o", f"out/{name}{ending}"] for name in "gl" for ending in
               (".raw", ".nrrd", ".nii", ".nii.gz", ".mha", ".mhd", ".tif", "-stack/",
                ".ome.zarr", ".zarr", ".ozx")] +
              [["g.8vo", "--level", "1", "-o", f"out/1{ending}"] for ending in
               (".ome.zarr", ".ozx", ".nii.gz")],
    "extract": [["g.8vo", "--box", "0:4,0:4,0:4", "-o", "out/x.nrrd"]],
    "slice": [["g.8vo", "-o", "out/s.png"], ["l.8vo", "--axis", "all", "-o", "out/l.png"]],
    "render": [["g.8vo", "--size", "32x32", "--mode", "mip", "-o", "out/r.png"],
               ["l.8vo", "--size", "32x32", "--mode", "surface", "-o", "out/l.png"],
               ["g.8vo", "--size", "32x32", "--mode", "mip", "--turntable", "2", "-o",
                "out/t.apng"]],
    "threshold": [["g.8vo", "--range", "20:", "-o", "out/t.8vo"]],
    "condense": [["g.8vo", "--flat", "1", "-o", "out/c.8vo"]],
    "combine": [["l.8vo", "l.8vo", "--union", "-o", "out/c.8vo"]],
    "components": [["l.8vo", "-o", "out/c.8vo"]],
    "shell": [["l.8vo", "-o", "out/s.8vo"]],
    "fill-holes": [["l.8vo", "-o", "out/f.8vo"]],
    **{verb: [["l.8vo", "--voxels", "1", "-o", "out/m.8vo"]] for verb in
       ("dilate", "erode", "open", "close")},
    "distance": [["l.8vo", "-o", "out/d.8vo"]],
    "transform": [["g.8vo", *step, "-o", "out/t.8vo"] for step in
                  (["--rotate", "z:90"], ["--rotate", "z:9"], ["--translate", "1,2,3"],
                   ["--mirror", "x"])],
    "surface": [[name, *options, "-o", f"out/s{ending}"] for name, options in
                (("g.8vo", ["--isovalue", "20"]), ("l.8vo", ["--label", "1"])) for ending in
                (".stl", ".ply", ".obj", ".glb", ".vtp", ".3mf")] +
               [["l.8vo", "--parts", "-o", "out/parts"],
                ["g.8vo", "--isovalue", "20", "-o", "out/s.stl", "--report", "out/s.json"]],
    "hexahedra": [["l.8vo", "-o", f"out/h{ending}"] for ending in
                  (".vtu", ".inp", ".msh", ".mesh")],
    "align": [["l.8vo", "l.8vo", "-o", "out/pose.txt", "--picture", "out/pose.png"]],
    "morphometry": [["l.8vo", "--thickness-map", "out/t.8vo"]],
    "measure": [["l.8vo"], ["l.8vo", "--of", "g.8vo", "--csv"]],
    "codes": [["l.8vo", "--counts"], ["l.8vo", "--list"]],
    "compare": [["g.8vo", "g.8vo"]],
    "touch": [["l.8vo"]],
    "probe": [["g.8vo", "--at", "1,1,1"]],
    "verify": [["g.8vo"]],
    "plan": [["g.8vo", "--parts", "2", "-o", "out/scan.plan"]],
}
# Files as they are (of a plan what it plans), and what no volume goes into.
OTHERS = {"part", "join", "info", "repair", "serve", "view", "publish", "phantom", "completion",
          "manual"}


def unpacked(data):
    """The bytes, and those that are packed in them."""
    yield data
    if data.startswith(b"\x1f\x8b"):
        yield from unpacked(gzip.decompress(data))
    if data.startswith(b"PK"):
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            for name in archive.namelist():
                yield name.encode()
                yield from unpacked(archive.read(name))


def holds_secret(data):
    forms = [form.encode(encoding) for form in (SECRET, SECRET.upper(), SECRET.lower())
             for encoding in ("utf-8", "utf-16-le", "utf-16-be")]
    return any(form in part for part in unpacked(data) for form in forms)


class Kept(cli_test.InFolder):
    """Two files that hold what --keep-identity keeps, in places of their metadata."""

    def setUp(self):
        super().setUp()
        voxels = bytearray(x + y + z for z in range(16) for y in range(16) for x in range(16))
        (self.folder / "g.raw").write_bytes(voxels)
        (self.folder / "l.raw").write_bytes(bytes(voxel > 20 for voxel in voxels))
        layout = ",".join(map(str, SIZE)) + ",uint8"
        for name, options in [("g", ["--grey"]), ("l", ["--labels"])]:
            self.expect(0, "build", f"{name}.raw", "--raw", layout, "--spacing", "1,1,2", *options,
                        "-o", f"{name}.8vo", "-q")
        self.bytes = {name: (self.folder / f"{name}.8vo").read_bytes() for name in "gl"}
        self.give({"kept": True, "dropped": {"private": 3},
                   "attributes": {name: f"{SECRET}^{i}" for i, name in enumerate(NAMES)}})

    def give(self, identity, **more):
        for name in "gl":
            metadata = {"source": {"format": "NRRD", "files": 1}, "identity": identity,
                        "spacing_known": True, "unit": "mm", **more}
            self.put(name, json.dumps(metadata).encode())

    def put(self, name, metadata):
        (self.folder / f"{name}.8vo").write_bytes(with_metadata(self.bytes[name], metadata))

    def assert_no_secret(self, label):
        for path in sorted((self.folder / "out").rglob("*")):
            self.assertFalse(holds_secret(str(path.relative_to(self.folder)).encode()), label)
            if path.is_file():
                self.assertFalse(holds_secret(path.read_bytes()), (label, path.name))

    def go(self, verb, arguments):
        (self.folder / "out").mkdir(exist_ok=True)
        result = self.expect(0, verb, *arguments, "-f", "--progress", "none")
        self.assertFalse(holds_secret((result.stdout + result.stderr).encode()), arguments)
        self.assertTrue("-o" not in arguments or any((self.folder / "out").iterdir()), arguments)


class WaysOut(Kept):
    def test_every_verb_stands_in_the_list(self):
        listed = self.expect(0, "--help").stdout.split("Verbs:")[1].split("\n\n")[0]
        verbs = {line.split()[0] for line in listed.splitlines() if line.strip()}
        self.assertEqual(verbs, set(WAYS) | OTHERS)

    def test_nothing_that_is_made_holds_a_secret(self):
        self.assertTrue(holds_secret((self.folder / "g.8vo").read_bytes()))
        for verb, ways in WAYS.items():
            for arguments in ways:
                with self.subTest(verb=verb, arguments=arguments):
                    shutil.rmtree(self.folder / "out", ignore_errors=True)
                    self.go(verb, arguments)
                    self.assert_no_secret((verb, arguments))
        self.go("export", ["g.8vo", "-o", "out/g.ome.zarr"])
        names = json.loads((self.folder / "out" / "g.ome.zarr" / "zarr.json").read_text())[
            "attributes"]["octavo"]["metadata"]["identity"]
        self.assertEqual(names, {"dropped": {**dict.fromkeys(NAMES, 1), "private": 3},
                                 "kept": False})

    def test_parts_of_a_plan_hold_none(self):
        self.go("plan", WAYS["plan"][0])
        self.go("part", ["out/scan.plan", "--parts", "0", "-o", "out/parts/"])
        self.go("join", ["out/scan.plan", "out/parts/", "-o", "out/joined.8vo"])
        self.assert_no_secret("parts")

    def test_metadata_of_any_form_hold_none(self):
        ways = [("build", ["g.8vo", "-o", "out/b.8vo"]), ("export", ["g.8vo", "-o", "out/e.ozx"]),
                ("transform", ["g.8vo", "--mirror", "x", "-o", "out/t.8vo"]),
                ("transform", ["g.8vo", "--translate", "1,2,3", "-o", "out/u.8vo"]),
                ("threshold", ["g.8vo", "--range", "20:", "-o", "out/m.8vo"])]
        kept = {"attributes": {"PatientName": SECRET}}
        for text in (json.dumps({"identity": SECRET}), json.dumps({"identity": [SECRET]}),
                     json.dumps({"identity": {**kept, "more": SECRET, "kept": SECRET}}),
                     json.dumps({"identity": {"attributes": {"PatientName": [SECRET]}}}),
                     json.dumps({"identity": {"dropped": {"PatientName": SECRET}}}),
                     '{"identity":' + json.dumps(kept) + ',"identity":{"dropped":{}}}',
                     '{"\\u0069dentity":' + json.dumps(kept) + "}",
                     json.dumps({"unreadable": SECRET}),
                     f'{{"identity":"{SECRET}"', f'"{SECRET}"'):
            self.put("g", text.encode())
            for verb, arguments in ways:
                with self.subTest(metadata=text, verb=verb):
                    shutil.rmtree(self.folder / "out", ignore_errors=True)
                    self.go(verb, arguments)
                    self.assert_no_secret(text)

    def test_an_image_built_back_keeps_what_is_no_identity(self):
        self.give({"kept": True, "attributes": {"PatientName": SECRET}}, lossy_source=True,
                  source_max_error=0.5, labels={"1": {"name": "bone", "color": "#ff0000"}})
        for image in ("out/l.ome.zarr", "out/l.ozx"):
            self.go("export", ["l.8vo", "-o", image])
            self.go("build", [image, "--keep-identity", "-o", "out/back.8vo"])
            self.assert_no_secret(image)
            back = self.info("out/back.8vo")["metadata"]
            self.assertEqual((back["unit"], back["lossy_source"], back["source_max_error"]),
                             ("mm", True, 0.5))
            self.assertEqual(back["labels"], {"1": {"name": "bone", "color": "#ff0000"}})


class Served(Kept, serve_test.Serving):
    """Files that are given out as they are."""

    def test_a_zarr_face_says_no_secret_and_files_are_warned_of(self):
        process, site = self.serve("serve", "g.8vo", "--as", "zarr3")
        text = self.ask(site, "/g.8vo.zarr/zarr.json")[1]
        self.assertIn(b"voxels_sha256", text)
        self.assertFalse(holds_secret(text))
        self.end(process)
        process, _ = self.serve("serve", "g.8vo", "a b.8vo")
        process.terminate()
        told = process.communicate()[1]
        self.assertRegex(told, "warning: g.8vo: keeps 12 attributes that may tell who")
        self.assertNotIn("a b.8vo", told)

    def test_publish_rejects_a_file_that_keeps_identity_unless_asked(self):
        def publish(code, *options):
            return self.expect(code, "publish", "a b.8vo", "g.8vo", "-o", "site", *options,
                               env=self.environment)
        said = publish(2).stderr
        for words in ("g.8vo: keeps 12 attributes that may tell who", "octavo build",
                      "--keep-identity publishes"):
            self.assertIn(words, said)
        self.assertFalse((self.folder / "site").exists())
        publish(0, "--keep-identity")
        self.assertEqual((self.folder / "site" / "g.8vo").read_bytes(),
                         (self.folder / "g.8vo").read_bytes())


if __name__ == "__main__":
    cli_test.OCTAVO = str(pathlib.Path(sys.argv.pop(1)).resolve())
    unittest.main()
