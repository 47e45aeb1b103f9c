"""What members of metadata are called stands in core/metadata_fields.h alone, and JSON is read by
core alone.

usage: metadata_words_test.py SOURCE_FOLDER
"""
import pathlib
import re
import sys
import tempfile
import unittest

from cpp_strings import strings, strings_in

ROOT = pathlib.Path(sys.argv.pop())

FIELDS = "src/octavo/core/metadata_fields.h"
# Who may include it.
READERS = {"src/octavo/core/metadata.cpp", "src/octavo/core/metadata_reading.cpp"}
# Who prints JSON that the library made, whole and unread: metadata, objects of reports.
PRINTED = {"cli/text/volume_json.cpp", "cli/text/fact_json.cpp"}
# Options of the library, by the names of their fields and what they may be set to.
OPTIONS = re.compile(r'(with_field\(|\{\{?)\s*"(max_error|on_gap|segment|channel|time|index)"')

# Words that are names of members as well, and what they are here.
OTHERS = {
    "src/octavo/builder/build_outline.cpp": {"keep_details": "a field of an error"},
    "src/octavo/codec/brick_codec.h": {"slices": "what an option is set to"},
    "src/octavo/builder/recover.cpp": {"repaired": "what is done"},
    "src/octavo/core/text.cpp": {"nan": "how a number is printed"},
    "src/octavo/file/write/interrupted.cpp": {"access": "a setting of a build",
                                              "keep_details": "a setting of a build",
                                              "labels": "a kind of volume",
                                              "max_error": "a setting of a build",
                                              "preset": "a setting of a build"},
    "src/octavo/io/dicom/dicom_counts.cpp": {"slices": "a noun"},
    "src/octavo/io/dicom/dicom_palette.cpp": {"index": "what an option is set to"},
    "src/octavo/io/dicom/dicom_stack.cpp": {"fill": "what an option is set to"},
    "src/octavo/io/http/answer_head.cpp": {"identity": "a coding of HTTP"},
    "src/octavo/io/images/tiff_description.cpp": {"unit": "a line of ImageJ",
                                                  "place_known": "a line of our exports",
                                                  "slices": "a line of ImageJ"},
    "src/octavo/io/open_source.cpp": {"on_gap": "an option", "segment": "an option"},
    "src/octavo/io/source_options.cpp": {"on_gap": "an option", "segment": "an option"},
    "src/octavo/io/volumes/nrrd_geometry.cpp": {"unit": "a noun"},
    "src/octavo/io/volumes/nrrd_header.cpp": {"labels": "a field of NRRD",
                                              "max": "a field of NRRD",
                                              "number": "a field of NRRD"},
    "src/octavo/io/volumes/nrrd_source.cpp": {"time": "a kind of NRRD"},
    "src/octavo/io/zarr/ome_image.cpp": {"identity": "a transformation of OME-Zarr",
                                         "name": "a member of OME-Zarr",
                                         "unit": "a member of OME-Zarr"},
    "src/octavo/io/zarr/zarr_layout.cpp": {"attributes": "a member of zarr",
                                           "name": "a member of zarr"},
    "src/octavo/io/zarr/zarr_source.cpp": {"attributes": "a member of zarr"},
    "src/octavo/io/zarr/zarr_text.cpp": {"attributes": "a member of zarr",
                                         "name": "a member of zarr",
                                         "unit": "a member of OME-Zarr"},
    "src/octavo/mesh/formats/glb_buffers.cpp": {"count": "a member of glTF"},
    "src/octavo/mesh/formats/glb_file.cpp": {"attributes": "a member of glTF",
                                             "max": "a member of glTF",
                                             "name": "a member of glTF"},
    "src/octavo/mesh/formats/ply_reader.cpp": {"format": "a word of PLY"},
    "src/octavo/mesh/hexahedra/hex_vtu.cpp": {"labels": "an array of VTU"},
    "src/octavo/render/rays/ray_camera.cpp": {"angle_degrees": "an option"},
    "src/octavo/tasks/files/export_part.cpp": {"number": "a noun"},
    "src/octavo/tasks/files/label_hint.cpp": {"labels": "a word of file names"},
    "src/octavo/tasks/hexahedra.cpp": {"max": "a fact"},
    "src/octavo/tasks/inputs.h": {"labels": "a noun"},
    "src/octavo/tasks/pictures/cube_scene.cpp": {"labels": "a piece of work"},
    "src/octavo/tasks/pictures/render.cpp": {"angle_degrees": "an option"},
    "src/octavo/tasks/pictures/transfer_file.cpp": {"color": "a member of transfer files"},
    "src/octavo/tasks/pictures/slice.cpp": {"index": "an option"},
    "src/octavo/tasks/structure/morphometry_rows.cpp": {"count": "a fact"},
    "src/octavo/tasks/structure/region_rows.cpp": {"max": "a fact", "name": "a fact"},
    "src/octavo/tasks/surfaces/surface_report.cpp": {"labels": "a noun"},
    "src/octavo/tasks/touch.cpp": {"labels": "a noun"},
    "src/octavo/tasks/transform_plan.cpp": {"time": "a noun", "outside": "a setting of made_by"},
    "src/octavo/tasks/volume_facts.h": {"labels": "a kind of volume"},
}


def names_of_members(root):
    path = root / FIELDS
    return {text for _, text in strings(path) if not text.endswith(".h")}


def sources(root, *folders):
    for folder in folders:
        for path in sorted((root / folder).rglob("*")):
            if path.suffix in {".h", ".cpp", ".inc"}:
                yield path, path.relative_to(root).as_posix()


def literals(root, names):
    """Names of members in strings of the library: alone, or in quotes as in JSON text."""
    in_json = re.compile(r'\\?"(' + "|".join(sorted(names)) + r')\\?"\s*:')
    for path, place in sources(root, "src/octavo"):
        if place == FIELDS:
            continue
        source = path.read_text()
        for at, text in strings_in(source):
            line = source.count("\n", 0, at) + 1
            is_option = any(match.end() == at + len(text) + 2
                            for match in OPTIONS.finditer(source, max(at - 40, 0), at + 40))
            if text in names and not is_option and text not in OTHERS.get(place, {}):
                yield f"{place}:{line}: \"{text}\""
            for match in in_json.finditer(text):
                yield f"{place}:{line}: \"{match[1]}\" in JSON text"


def includes(root):
    """Who includes what only core or only the face may."""
    for path, place in sources(root, "src", "cli", "python", "examples", "bench"):
        source = path.read_text()
        if '#include "octavo/core/metadata_fields.h"' in source and place not in READERS:
            yield f"{place}: includes metadata_fields.h"
        if re.search(r"#include\s*[<\"]nlohmann/", source) and not place.startswith("cli/"):
            yield f"{place}: includes nlohmann"


def readers(root):
    """Where the face takes JSON apart."""
    for path, place in sources(root, "cli"):
        if place not in PRINTED and re.search(r"json(::|\.)(parse|accept|sax_parse)\b",
                                          path.read_text()):
            yield f"{place}: reads JSON"


def findings(root, names):
    return [*literals(root, names), *includes(root), *readers(root)]


class MetadataWords(unittest.TestCase):
    def test_names_of_members_stand_in_one_place_and_core_alone_reads_them(self):
        names = names_of_members(ROOT)
        self.assertGreater(len(names), 40)
        self.assertGreater(len(list(sources(ROOT, "src/octavo"))), 300)
        self.assertEqual(findings(ROOT, names), [])

    def test_every_exception_is_needed(self):
        for place, words in OTHERS.items():
            found = {text for _, text in strings(ROOT / place)}
            self.assertEqual(sorted(set(words) - found), [], place)

    def test_what_is_planted_is_found(self):
        names = names_of_members(ROOT)
        for place, code, found in [
                ("src/octavo/io/a.cpp", 'f(json["spacing_known"]);', ':1: "spacing_known"'),
                ("src/octavo/tasks/touch.cpp", 'f("labels", "unit");', ':1: "unit"'),
                ("src/octavo/io/a.h", 'f(R"({"unit":"HU"})");', ':1: "unit" in JSON text'),
                ("src/octavo/io/a.h", '\nf("{\\"kept\\" :1}");', ':2: "kept" in JSON text'),
                ("src/octavo/ops/a.cpp", '#include "octavo/core/metadata_fields.h"',
                 ": includes metadata_fields.h"),
                ("src/octavo/file/a.h", "#include <nlohmann/json_fwd.hpp>", ": includes nlohmann"),
                ("examples/a.cpp", "#include <nlohmann/json.hpp>", ": includes nlohmann"),
                ("cli/verb_a.cpp", "nlohmann::json::parse(text)", ": reads JSON")]:
            with tempfile.TemporaryDirectory() as folder:
                path = pathlib.Path(folder) / place
                path.parent.mkdir(parents=True)
                path.write_text(code)
                self.assertEqual(findings(pathlib.Path(folder), names), [place + found], code)

    def test_comments_and_options_are_no_literals(self):
        code = '// "unit"\nerror.with_field("max_error"); hints.push_back({"on_gap", "fills"});\n'
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "src/octavo/a.cpp"
            path.parent.mkdir(parents=True)
            path.write_text(code)
            self.assertEqual(findings(pathlib.Path(folder), names_of_members(ROOT)), [])


unittest.main(verbosity=0)
