#!/usr/bin/env python3
"""Nothing that tells who, where or when enters a file, unless it is asked for.

usage: identity_test.py OCTAVO [unittest arguments]

The sources are generated with secrets in them; the bytes of what is built are searched for each.
"""

import gzip
import json
import os
import struct
import sys
import unittest

import channel_test
import cli_test
from dicom_series_test import COLUMNS, ROWS

# Value representation -> (tag, secret): one of every kind of text, and one of bytes.
SECRETS = {
    "PN": (0x00100010, "SECRET^PERSON"),
    "LO": (0x00100020, "SECRET-LO-4711"),
    "SH": (0x00080050, "SECRETSH4712"),
    "ST": (0x00080081, "SECRET ST Hospital Road 1"),
    "LT": (0x001021B0, "SECRET LT fell off a horse"),
    "UT": (0x0040A160, "SECRET UT seen by a doctor"),
    "UC": (0x00080119, "SECRET-UC"),
    "UR": (0x00081190, "http://secret.example/UR"),
    "UI": (0x0020000D, "1.2.987654.3.21"),
    "AE": (0x00080054, "SECRETAE"),
    "AS": (0x00101010, "097Y"),
    "CS": (0x001021A0, "SECRETCS"),
    "DA": (0x00100030, "19310417"),
    "TM": (0x00080030, "112233.987"),
    "DT": (0x0008002A, "20310418223344.55"),
    "DS": (0x00101030, "71.23459"),
    "IS": (0x00200011, "919191"),
    "OB": (0x00420011, "SECRETOB"),
}
KEYWORDS = ["PatientName", "PatientID", "AccessionNumber", "InstitutionAddress",
            "AdditionalPatientHistory", "TextValue", "LongCodeValue", "RetrieveURL",
            "StudyInstanceUID", "RetrieveAETitle", "PatientAge", "SmokingStatus",
            "PatientBirthDate", "StudyTime", "AcquisitionDateTime", "PatientWeight",
            "SeriesNumber", "EncapsulatedDocument"]
LONG = {"OB", "OW", "SQ", "UT", "UC", "UR", "UN"}


def element(tag, vr, value, implicit):
    value = value.encode("latin-1") if isinstance(value, str) else value
    value += (b"\0" if vr in ("UI", "OB") else b" ") * (len(value) % 2)
    head = struct.pack("<HH", tag >> 16, tag & 0xFFFF)
    if implicit:
        return head + struct.pack("<I", len(value)) + value
    if vr in LONG:
        return head + vr.encode() + struct.pack("<xxI", len(value)) + value
    return head + vr.encode() + struct.pack("<H", len(value)) + value


def item(content):
    return struct.pack("<HHI", 0xFFFE, 0xE000, len(content)) + content


def dicom(z, implicit, more=()):
    """A slice with every secret, one nested twice, and two in a private group; `more` elements."""
    short = {0x00280002: 1, 0x00280010: ROWS, 0x00280011: COLUMNS, 0x00280100: 16,
             0x00280101: 16, 0x00280102: 15, 0x00280103: 1}
    elements = [(tag, vr, text) for vr, (tag, text) in SECRETS.items()]
    elements += [(tag, "US", struct.pack("<H", value)) for tag, value in short.items()]
    elements += [(0x00080005, "CS", "ISO_IR 100"), (0x00080060, "CS", "CT"),
                 (0x00080070, "LO", "Maker"), (0x00100040, "CS", "O"),
                 (0x0020000E, "UI", "1.2.3.777888"), (0x00200032, "DS", f"0\\0\\{z}"),
                 (0x00200037, "DS", "1\\0\\0\\0\\1\\0"), (0x00280004, "CS", "MONOCHROME2"),
                 (0x00280030, "DS", "0.5\\0.5"), (0x00080090, "PN", "SECRET^J\xfcrgen"),
                 (0x00290010, "LO", "SECRET PRIVATE CREATOR"),
                 (0x00291001, "UN", b"SECRET PRIVATE VALUE"),
                 (0x7FE00010, "OW", struct.pack("<h", z) * (COLUMNS * ROWS))]
    elements += more
    inner = element(0x00100010, "PN", "SECRET^NESTED", implicit)
    middle = element(0x00400275, "SQ", item(inner), implicit)
    elements.append((0x00400275, "SQ", item(middle)))
    meta = element(0x00020003, "UI", "1.2.3.555666", False)
    syntax = "1.2.840.10008.1.2" if implicit else "1.2.840.10008.1.2.1"
    meta += element(0x00020010, "UI", syntax, False)
    meta += element(0x00020016, "AE", "SECRETSENDER", False)
    group = element(0x00020000, "UL", struct.pack("<I", len(meta)), False)
    data_set = b"".join(element(*each, implicit) for each in sorted(elements))
    return b"\0" * 128 + b"DICM" + group + meta + data_set


def tiff(texts):
    """One page of 4 x 3 voxels with text tags."""
    entries, extra = [], b""
    start = 8 + 12
    layout = [(256, 3, 1, 4), (257, 3, 1, 3), (258, 3, 1, 8), (259, 3, 1, 1), (262, 3, 1, 1),
              (273, 4, 1, 8), (277, 3, 1, 1), (278, 3, 1, 3), (279, 4, 1, 12)]
    for tag, text in texts.items():
        data = text.encode() + b"\0"
        layout.append((tag, 2, len(data), start + len(extra)))
        extra += data + b"\0" * (len(data) % 2)
    for tag, kind, count, value in sorted(layout):
        entries.append(struct.pack("<HHII", tag, kind, count, value))
    directory = struct.pack("<H", len(entries)) + b"".join(entries) + b"\0" * 4
    return b"II*\0" + struct.pack("<I", start + len(extra)) + bytes(12) + extra + directory


def nifti(texts):
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, 4, 3, 2, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, 2, 8)
    struct.pack_into("<8f", header, 76, 1, 2, 2, 2, 0, 0, 0, 0)
    struct.pack_into("<f", header, 108, 352)
    header[123] = 2
    struct.pack_into("<h", header, 252, 1)
    header[344:348] = b"n+1\0"
    for (offset, _), text in texts.items():
        header[offset:offset + len(text)] = text.encode()
    return bytes(header) + bytes(range(24))


class Identity(cli_test.InFolder):
    def build(self, *arguments):
        return self.expect(0, "build", *arguments, "-o", "a.8vo", "-f", "--progress", "none")

    def assert_no_secret(self, secrets, name="a.8vo"):
        data = (self.folder / name).read_bytes()
        self.assertIn(b'"format"', data, "the metadata are not plain: the search says nothing")
        for secret in secrets:
            for form in {secret, secret.lower(), secret.replace("^", " ")}:
                self.assertNotIn(form.encode(), data)
                self.assertNotIn(form.encode("utf-16-le"), data)

    def write_dicom(self, implicit):
        folder = self.folder / "SECRET-FOLDER"
        folder.mkdir(exist_ok=True)
        for z in range(3):
            (folder / f"SECRET-FILE-{z}.dcm").write_bytes(dicom(z, implicit))
        return [text for _, text in SECRETS.values()] + [
            "SECRET", "NESTED", "PRIVATE VALUE", "PRIVATE CREATOR", "rgen", "777888", "555666"]

    def test_dicom_keeps_nothing_and_lists_every_name(self):
        for implicit in (False, True):
            with self.subTest(implicit=implicit):
                secrets = self.write_dicom(implicit)
                self.build("SECRET-FOLDER")
                self.assert_no_secret(secrets)
                info = self.info("a.8vo")
                self.assertEqual(info["identity"], "dropped")
                identity = info["metadata"]["identity"]
                self.assertFalse(identity["kept"])
                self.assertNotIn("attributes", identity)
                for keyword in KEYWORDS:
                    self.assertIn(keyword, identity["dropped"])
                self.assertEqual(identity["dropped"]["PatientBirthDate"], 3)
                self.assertEqual(identity["dropped"]["private"], 6)
                self.assertEqual(identity["dropped"]["SourceApplicationEntityTitle"], 3)
                self.assertNotIn("Manufacturer", identity["dropped"])
                self.assertNotIn("Rows", identity["dropped"])
                if not implicit:
                    self.assertEqual(identity["dropped"]["PatientName"], 6)
                shown = self.expect(0, "info", "a.8vo").stdout
                self.assertRegex(shown, r"identity +dropped: \d+ attributes")
                listed = self.expect(0, "info", "a.8vo", "--metadata").stdout
                self.assertRegex(listed, r"PatientBirthDate +3\n")

    def test_dicom_attributes_are_told_only_in_the_form_that_they_have(self):
        told = {"ImageType": (0x00080008, "CS", "ORIGINAL\\PRIMARY\\AXIAL"),
                "KVP": (0x00180060, "DS", "120"),
                "ConvolutionKernel": (0x00181210, "SH", "B40f"),
                "BodyPartExamined": (0x00180015, "CS", "CHEST"),
                "PatientPosition": (0x00185100, "CS", "HFS"),
                "RescaleType": (0x00281054, "LO", "HU"),
                "Units": (0x00541001, "CS", "CNTS")}
        written_over = {"ImageType": "ORIGINAL\\Doe^John", "KVP": "Doe^John",
                        "BodyPartExamined": "Doe John", "PatientPosition": "DOE_JOHN",
                        "RescaleType": "Doe^John 1970", "Units": "DOE_JOHN"}
        folder = self.folder / "scan"
        folder.mkdir()
        for secrets in ({}, written_over):
            more = [(tag, vr, secrets.get(name, text)) for name, (tag, vr, text) in told.items()]
            for z in range(3):
                (folder / f"{z}.dcm").write_bytes(dicom(z, False, more))
            self.build("scan")
            metadata = self.info("a.8vo")["metadata"]
            for name in told:
                self.assertEqual(name in metadata["dicom"], name not in secrets, name)
                self.assertEqual(metadata["identity"]["dropped"].get(name, 0),
                                 3 if name in secrets else 0, name)
            self.assert_no_secret([*secrets.values(), "Doe^John", "Doe John"])
        self.build("scan", "--keep-identity")
        kept = self.info("a.8vo")["metadata"]["identity"]["attributes"]
        self.assertEqual(kept["RescaleType"], "Doe^John 1970")

    def test_what_is_kept_is_kept_under_its_keyword_and_said(self):
        self.write_dicom(False)
        self.build("SECRET-FOLDER", "--keep-identity")
        info = self.info("a.8vo")
        self.assertEqual(info["identity"], "kept")
        identity = info["metadata"]["identity"]
        self.assertTrue(identity["kept"])
        kept = identity["attributes"]
        for keyword, (vr, (_, text)) in zip(KEYWORDS, SECRETS.items()):
            if vr != "OB":
                self.assertEqual(kept[keyword], text)
        self.assertEqual(kept["ReferringPhysicianName"], "SECRET^J\xfcrgen")
        self.assertEqual(kept["FileName"], "SECRET-FOLDER")
        self.assertEqual(identity["dropped"]["private"], 6)
        self.assertIn("EncapsulatedDocument", identity["dropped"])
        self.assertNotIn("PatientName", identity["dropped"])
        self.assertRegex(self.expect(0, "info", "a.8vo").stdout, r"identity +kept: \d+ attributes")
        self.assertIn("SECRET^PERSON", self.expect(0, "info", "a.8vo", "--metadata").stdout)

    def test_a_file_and_exports_made_of_a_kept_one_hold_nothing(self):
        secrets = self.write_dicom(False)
        self.build("SECRET-FOLDER", "--keep-identity")
        os.rename(self.folder / "a.8vo", self.folder / "kept.8vo")
        self.build("kept.8vo")
        self.assert_no_secret(secrets)
        identity = self.info("a.8vo")["metadata"]["identity"]
        self.assertEqual((identity["kept"], identity["dropped"]["PatientID"]), (False, 1))
        self.build("kept.8vo", "--keep-identity")
        self.assertEqual(self.info("a.8vo")["identity"], "kept")
        for ending in ["nii", "nrrd", "mha", "tif"]:
            name = "e." + ending
            self.expect(0, "export", "kept.8vo", "-o", name, "--progress", "none")
            data = (self.folder / name).read_bytes()
            for secret in secrets:
                self.assertNotIn(secret.encode(), data)

    def check_format(self, name, data, dropped, kept):
        (self.folder / name).write_bytes(data)
        self.check_built(name, dropped, kept)

    def check_built(self, name, dropped, kept):
        self.build(name, "--spacing", "1")
        self.assert_no_secret(["SECRET"])
        self.assertEqual(self.info("a.8vo")["metadata"]["identity"],
                         {"kept": False, "dropped": dropped})
        self.build(name, "--spacing", "1", "--keep-identity")
        attributes = self.info("a.8vo")["metadata"]["identity"]["attributes"]
        self.assertEqual(attributes, {**kept, "FileName": name})

    def test_nifti_texts(self):
        texts = {(4, "data_type"): "SECRET dt", (14, "db_name"): "SECRET db",
                 (148, "descrip"): "SECRET descrip", (228, "aux_file"): "SECRET.aux",
                 (328, "intent_name"): "SECRET int"}
        kept = {name: text for (_, name), text in texts.items()}
        self.check_format("SECRET.nii", nifti(texts), dict.fromkeys(kept, 1), kept)

    def test_nrrd_texts(self):
        head = ("NRRD0004\n# SECRET comment\n# SECRET again\ntype: uchar\ndimension: 3\n"
                "sizes: 4 3 2\nencoding: raw\ncontent: SECRET content\nPatient: SECRET\n"
                "SECRET key:=SECRET value\n\n")
        self.check_format("SECRET.nrrd", head.encode() + bytes(range(24)),
                          {"comment": 2, "content": 1, "key/value pair": 1, "other field": 1},
                          {"comment": "SECRET comment\nSECRET again", "content": "SECRET content",
                           "key/value pair": "SECRET key:=SECRET value",
                           "other field": "Patient: SECRET"})

    def test_metaimage_fields(self):
        head = ("ObjectType = Image\nNDims = 3\nComment = SECRET comment\nName = SECRET\n"
                "SecretName = SECRET\nDimSize = 4 3 2\nElementType = MET_UCHAR\n"
                "ElementDataFile = LOCAL\n")
        self.check_format("SECRET.mha", head.encode() + bytes(range(24)),
                          {"Comment": 1, "Name": 1, "other field": 1},
                          {"Comment": "SECRET comment", "Name": "SECRET",
                           "other field": "SecretName = SECRET"})

    def test_name_of_an_ome_zarr_image(self):
        image = self.folder / "SECRET.ome.zarr"
        (image / "0").mkdir(parents=True)
        axes = [{"name": name, "type": "space", "unit": "millimeter"} for name in "zyx"]
        datasets = [{"path": "0", "coordinateTransformations": [
            {"type": "scale", "scale": [1, 1, 1]}]}]
        (image / ".zgroup").write_text('{"zarr_format": 2}')
        (image / ".zattrs").write_text(json.dumps({"multiscales": [
            {"name": "SECRET", "axes": axes, "datasets": datasets}]}))
        (image / "0" / ".zarray").write_text(json.dumps(
            {"zarr_format": 2, "shape": [2, 3, 4], "chunks": [2, 3, 4], "dtype": "|u1",
             "order": "C", "fill_value": 0, "filters": None, "compressor": None}))
        (image / "0" / "0.0.0").write_bytes(bytes(range(24)))
        self.check_built("SECRET.ome.zarr", {"name": 1}, {"name": "SECRET"})

    def test_tiff_texts(self):
        texts = {269: "SECRET document", 270: "SECRET description", 305: "SECRET program",
                 306: "2031:04:17 01:02:03", 315: "SECRET artist", 316: "SECRET host"}
        names = ["DocumentName", "ImageDescription", "Software", "DateTime", "Artist",
                 "HostComputer"]
        self.check_format("SECRET.tif", tiff(texts), dict.fromkeys(names, 1),
                          dict(zip(names, texts.values())))

    def check_dropped(self, names, dropped):
        self.build(*names, "--spacing", "1", "--keep-identity")
        self.assertEqual(self.info("a.8vo")["metadata"]["identity"]["dropped"], dropped)
        self.build(*names, "--spacing", "1")
        self.assert_no_secret(["SECRET"])
        self.assertEqual(self.info("a.8vo")["metadata"]["identity"]["dropped"], dropped)

    def test_png_chunks_before_and_behind_the_picture(self):
        chunks = [(b"tEXt", b"Author\0SECRET"), (b"tIME", bytes([7, 239, 4, 17, 1, 2, 3])),
                  (b"seCr", b"SECRET")]
        late = [(b"iTXt", b"Title\0\0\0\0\0SECRET"), (b"tEXt", b"Title\0SECRET")]
        (self.folder / "1.png").write_bytes(channel_test.png([9], chunks, late))
        (self.folder / "2.png").write_bytes(channel_test.png([9], [], late))
        self.check_dropped(["1.png", "2.png"], {"iTXt": 2, "private": 1, "tEXt": 3, "tIME": 1})

    def test_vtk_title_and_gipl_text(self):
        head = ("# vtk DataFile Version 3.0\nSECRET title\nBINARY\nDATASET STRUCTURED_POINTS\n"
                "DIMENSIONS 4 3 2\nSPACING 1 1 1\nORIGIN 0 0 0\nPOINT_DATA 24\n"
                "SCALARS voxels unsigned_char 1\nLOOKUP_TABLE default\n")
        self.check_format("SECRET.vtk", head.encode() + bytes(range(24)), {"title": 1},
                          {"title": "SECRET title"})
        gipl = bytearray(256)
        struct.pack_into(">4HH4f", gipl, 0, 4, 3, 2, 1, 8, 1, 1, 1, 1)
        gipl[26:37] = b"SECRET text"
        struct.pack_into(">I", gipl, 252, 719555000)
        self.check_format("SECRET.gipl", bytes(gipl) + bytes(range(24)), {"text": 1},
                          {"text": "SECRET text"})

    def test_nifti_extensions_beside_a_separate_picture(self):
        header = bytearray(nifti({})[:352])
        header[344:348] = b"ni1\0"
        struct.pack_into("<f", header, 108, 0)
        (self.folder / "pair.img").write_bytes(bytes(range(24)))
        header[348] = 1
        extended = bytes(header) + struct.pack("<2i", 32, 6) + b"SECRET comment" + bytes(10)
        for name, pack in [("pair.hdr", bytes), ("pair.hdr.gz", gzip.compress)]:
            if name.endswith(".gz"):
                (self.folder / "pair.img.gz").write_bytes(gzip.compress(bytes(range(24))))
            (self.folder / name).write_bytes(pack(extended))
            self.check_dropped([name], {"header extension": 1})
            (self.folder / name).write_bytes(pack(bytes(header[:348])))
            self.build(name, "--spacing", "1")
            self.assertNotIn("identity", self.info("a.8vo")["metadata"])

    def test_sources_that_say_nothing_have_no_entry(self):
        layout = self.random_raw("v.raw", (4, 3, 2))
        self.build("v.raw", "--raw", layout, "--spacing", "1")
        self.assertNotIn("identity", self.info("a.8vo")["metadata"])
        self.assertEqual(self.info("a.8vo")["identity"], "none")
        self.assertNotIn("identity", self.expect(0, "info", "a.8vo").stdout)


if __name__ == "__main__":
    cli_test.OCTAVO = os.path.abspath(sys.argv.pop(1))
    unittest.main()
