#!/usr/bin/env python3
"""Makes meshes of hexahedra as a user does, and reads the files back.

usage: hexahedra_test.py OCTAVO [unittest arguments]

Everything is generated.
"""

import json
import re
import struct
import sys

import cli_test

SIZE = (24, 20, 16)
SPACING = (0.5, 0.75, 2.0)
VOXEL_MM3 = 0.5 * 0.75 * 2.0
CORNERS = {12: 8, 14: 5, 10: 4}


def is_inside(x, y, z):
    return 4 <= x < 16 and 5 <= y < 16 and 2 <= z < 14 and (x - 10) ** 2 + (y - 10) ** 2 < 30


def places():
    return [(x, y, z) for z in range(SIZE[2]) for y in range(SIZE[1]) for x in range(SIZE[0])]


def label_at(x, y, z):
    return (1 if z < 9 else 3) if is_inside(x, y, z) else 0


def difference(a, b):
    return tuple(p - q for p, q in zip(a, b))


def determinant(a, b, c):
    return (a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
            + a[2] * (b[0] * c[1] - b[1] * c[0]))


def volume_of(points):
    """Of an element with sides that are parallelograms, by its number of corners."""
    side = {8: 3, 5: 3, 4: 2}[len(points)]
    top = {8: 4, 5: 4, 4: 3}[len(points)]
    whole = determinant(*(difference(points[i], points[0]) for i in (1, side, top)))
    return whole / {8: 1, 5: 3, 4: 6}[len(points)]


def read_vtu(path):
    """Points, elements as lists of numbers, and arrays by name."""
    data = path.read_bytes()
    start = data.index(b"_", data.index(b"<AppendedData")) + 1
    head = data[:start].decode()
    letters = {"Float64": "d", "Float32": "f", "Int64": "q", "Int32": "i", "UInt8": "B"}
    arrays = {}
    for kind, name, offset in re.findall(
            r'type="(\w+)" Name="(\w+)".*? offset="(\d+)"', head):
        at = start + int(offset)
        (size,) = struct.unpack_from("<Q", data, at)
        count = size // struct.calcsize(letters[kind])
        arrays[name] = struct.unpack_from(f"<{count}{letters[kind]}", data, at + 8)
    flat = arrays["Points"]
    points = [flat[i:i + 3] for i in range(0, len(flat), 3)]
    ends = arrays["offsets"]
    begins = (0, *ends[:-1])
    elements = [arrays["connectivity"][a:b] for a, b in zip(begins, ends)]
    assert [CORNERS[kind] for kind in arrays["types"]] == [len(e) for e in elements]
    return points, elements, arrays


def read_inp(path):
    """Nodes, elements of each set, and all data lines by keyword line."""
    blocks = {}
    for line in path.read_text().splitlines():
        if line.startswith("**"):
            continue
        if line.startswith("*"):
            lines = blocks.setdefault(line, [])
        else:
            lines.append([word.strip() for word in line.split(",")])
    nodes = {int(words[0]): tuple(map(float, words[1:]))
             for words in blocks["*NODE, NSET=ALL_NODES"]}
    return nodes, blocks


def read_equations(lines):
    """The masters and their weights of each node and axis."""
    equations, at = {}, 0
    while at < len(lines):
        (count,), terms = map(int, lines[at]), []
        at += 1
        while len(terms) < 3 * count:
            terms += lines[at]
            at += 1
        triples = [(int(terms[i]), int(terms[i + 1]), float(terms[i + 2]))
                   for i in range(0, len(terms), 3)]
        assert triples[0][2] == 1 and len({axis for _, axis, _ in triples}) == 1
        equations[triples[0][:2]] = [(node, -weight) for node, _, weight in triples[1:]]
    return equations


class Hexahedra(cli_test.InFolder):
    def setUp(self):
        super().setUp()
        self.build("map.8vo", bytes(label_at(*place) for place in places()), "uint8", "--labels")
        grey = struct.pack("<%dh" % len(places()), *(10 * x + y for x, y, _ in places()))
        self.build("grey.8vo", grey, "int16", "--grey")
        self.voxels = sum(is_inside(*place) for place in places())

    def build(self, name, data, kind, *arguments):
        (self.folder / "v.raw").write_bytes(data)
        self.expect(0, "build", "v.raw", "--raw", ",".join(map(str, SIZE)) + "," + kind,
                    "--spacing", ",".join(map(str, SPACING)), "-o", name, "-q", "-f", *arguments)

    def json(self, *arguments):
        return json.loads(self.expect(0, "hexahedra", *arguments, "--json", "--progress",
                                      "none").stdout)

    def expect_volume(self, points, elements):
        volumes = [volume_of([points[i] for i in element]) for element in elements]
        self.assertGreater(min(volumes), 0)
        self.assertAlmostEqual(sum(volumes), self.voxels * VOXEL_MM3, delta=1e-9)

    def test_every_method_fills_the_voxels_with_positive_volumes(self):
        shapes = {"--uniform": {8}, "--octree": {8}, "--conforming": {8, 5, 4}}
        for method, corners in shapes.items():
            with self.subTest(method):
                report = self.json("map.8vo", method, "--quality", "-o", "m.vtu", "-f")
                points, elements, arrays = read_vtu(self.folder / "m.vtu")
                self.assertEqual((len(points), len(elements)),
                                 (report["nodes"], report["elements"]))
                self.assertEqual({len(element) for element in elements}, corners)
                self.expect_volume(points, elements)
                self.assertEqual(set(arrays["label"]), {1, 3})
                self.assertEqual(report["voxels"], self.voxels)
                self.assertAlmostEqual(report["volume_mm3"], self.voxels * VOXEL_MM3)
                self.assertGreater(report["quality"]["scaled_jacobian"]["min"], 0.05)
        self.assertEqual(report["hanging_nodes"], 0)

    def test_places_are_those_of_the_voxels(self):
        self.json("map.8vo", "-o", "m.vtu")
        points, elements, _ = read_vtu(self.folder / "m.vtu")
        corners = {tuple(round(points[e[0]][a] / SPACING[a] + 0.5) for a in range(3))
                   for e in elements}
        self.assertEqual(corners, {place for place in places() if is_inside(*place)})

    def test_hanging_nodes_are_means_of_nodes_that_do_not_hang(self):
        report = self.json("map.8vo", "--octree", "-o", "m.inp")
        self.assertGreater(report["hanging_nodes"], 0)
        nodes, blocks = read_inp(self.folder / "m.inp")
        equations = read_equations(blocks["*EQUATION"])
        hanging = {node for node, _ in equations}
        self.assertEqual(len(hanging), report["hanging_nodes"])
        self.assertEqual(len(equations), 3 * len(hanging))
        for (node, _), terms in equations.items():
            self.assertIn([weight for _, weight in terms], ([0.5] * 2, [0.25] * 4))
            self.assertFalse({master for master, _ in terms} & hanging)
            for axis in range(3):
                mean = sum(nodes[master][axis] * weight for master, weight in terms)
                self.assertAlmostEqual(mean, nodes[node][axis], delta=1e-12)
        for axis, name in enumerate("XYZ"):
            for end, choose in (("MIN", min), ("MAX", max)):
                side = {int(word) for words in blocks[f"*NSET, NSET={name}_{end}"]
                        for word in words}
                at = choose(place[axis] for place in nodes.values())
                self.assertEqual(side, {node for node, place in nodes.items()
                                        if place[axis] == at and node not in hanging})

    def test_the_masters_of_vtu_are_those_of_the_equations(self):
        self.json("map.8vo", "--octree", "-o", "m.inp")
        self.json("map.8vo", "--octree", "-o", "m.vtu")
        _, blocks = read_inp(self.folder / "m.inp")
        equations = read_equations(blocks["*EQUATION"])
        _, _, arrays = read_vtu(self.folder / "m.vtu")
        masters = arrays["masters"]
        for node in range(len(masters) // 4):
            expected = {master - 1 for master, _ in equations.get((node + 1, 1), [])}
            self.assertEqual(set(masters[4 * node:4 * node + 4]) - {-1}, expected)

    def test_labels_are_sets_in_every_format(self):
        report = self.json("map.8vo", "-o", "m.inp")
        _, blocks = read_inp(self.folder / "m.inp")
        counts = {label: sum(label_at(*place) == label for place in places()) for label in (1, 3)}
        for label, count in counts.items():
            self.assertEqual(len(blocks[f"*ELEMENT, TYPE=C3D8, ELSET=LABEL_{label}"]), count)
        self.assertNotIn("*ELASTIC", blocks)
        self.assertEqual(report["labels"], [1, 3])
        self.json("map.8vo", "-o", "m.msh")
        text = (self.folder / "m.msh").read_text()
        self.assertIn('$PhysicalNames\n2\n3 1 "LABEL_1"\n3 3 "LABEL_3"\n', text)
        self.json("map.8vo", "-o", "m.mesh")
        lines = (self.folder / "m.mesh").read_text().split("elements\n")[1].splitlines()
        self.assertEqual(int(lines[0]), self.voxels)
        self.assertEqual({line.split()[0] for line in lines[1:self.voxels + 1]}, {"1", "3"})
        one = self.json("map.8vo", "--label", "3", "-o", "one.inp")
        self.assertEqual((one["elements"], one["labels"]), (counts[3], [3]))

    def test_sets_have_the_names_of_their_labels(self):
        (self.folder / "names.txt").write_text("3 Linke Niere / oben (größer) 255 128 0 255\n"
                                               "7 gone 1 2 3 4\n", encoding="utf-8")
        data = bytes(label_at(*place) for place in places())
        self.build("named.8vo", data, "uint8", "--labels", "--label-names", "names.txt")
        (name,) = [label["name"] for number, label in json.loads(
            self.expect(0, "info", "named.8vo", "--json").stdout)["metadata"]["labels"].items()
            if number == "3"]
        word = "LABEL_3_Linke_Niere_oben_gr_er"
        self.json("named.8vo", "-o", "m.inp")
        _, blocks = read_inp(self.folder / "m.inp")
        self.assertIn(f"*ELEMENT, TYPE=C3D8, ELSET={word}", blocks)
        self.assertIn("*ELEMENT, TYPE=C3D8, ELSET=LABEL_1", blocks)
        line = f"label 3, {name}, color 255 128 0\n"
        self.assertIn(f"** {word}: {line}", (self.folder / "m.inp").read_text(encoding="utf-8"))
        self.json("named.8vo", "-o", "m.msh")
        text = (self.folder / "m.msh").read_text(encoding="utf-8")
        self.assertIn(f'$PhysicalNames\n2\n3 1 "LABEL_1"\n3 3 "{word}"\n', text)
        self.assertIn(f"\n{word}: {line}$EndComments\n", text)
        self.json("named.8vo", "-o", "m.mesh")
        text = (self.folder / "m.mesh").read_text(encoding="utf-8")
        self.assertIn(f"# attribute 1 = label 1\n# attribute 3 = {line}", text)
        self.json("named.8vo", "-o", "m.vtu")
        read_vtu(self.folder / "m.vtu")
        head = (self.folder / "m.vtu").read_bytes().split(b"<Piece")[0].decode()
        fields = dict(re.findall(r'Name="(label\w+)".*?>\n(.*?)</DataArray>', head, re.S))
        self.assertEqual(fields["labels"].split(), ["1", "3"])
        codes = bytes(map(int, fields["label_names"].split()))
        self.assertEqual(codes.decode().split("\0"), ["1", name, ""])
        self.assertEqual(fields["label_colors"].split()[3:], ["255", "128", "0"])

    def test_bins_are_those_of_each_label(self):
        words = ["map.8vo", "--of", "grey.8vo", "--density", "0.01,1", "--modulus", "6850,1.49"]
        for bins, materials in [(1, 2), (2, 4)]:
            report = self.json(*words, "--bins", str(bins), "-o", "m.inp", "-f")
            self.assertEqual(report["materials"], materials)
        _, blocks = read_inp(self.folder / "m.inp")
        (sets,) = blocks["*ELSET, ELSET=LABEL_3"]
        self.assertEqual([name.split("_MATERIAL")[0] for name in sets], ["LABEL_3", "LABEL_3"])

    def test_mfem_is_told_the_parents_of_hanging_nodes(self):
        report = self.json("map.8vo", "--octree", "-o", "m.mesh")
        text = (self.folder / "m.mesh").read_text()
        self.assertTrue(text.startswith("MFEM mesh v1.1\n"))
        lines = text.split("vertex_parents\n")[1].splitlines()
        self.assertEqual(int(lines[0]), report["hanging_nodes"])
        points = [tuple(map(float, line.split()))
                  for line in text.split("vertices\n")[1].splitlines()[2:]]
        for line in lines[1:report["hanging_nodes"] + 1]:
            node, first, second = map(int, line.split())
            self.assertGreaterEqual(node, report["nodes"] - report["hanging_nodes"])
            for axis in range(3):
                self.assertAlmostEqual(points[node][axis],
                                       (points[first][axis] + points[second][axis]) / 2)

    def test_grey_values_become_moduli_and_materials(self):
        report = self.json("map.8vo", "--octree", "--of", "grey.8vo", "--density", "0.01,0.1",
                           "--modulus", "6850,1.49", "--bins", "5", "-o", "m.vtu")
        points, elements, arrays = read_vtu(self.folder / "m.vtu")
        for i, element in enumerate(elements):
            middle = [sum(points[n][a] for n in element) / 8 / SPACING[a] for a in range(3)]
            mean = 10 * middle[0] + middle[1]
            density = 0.01 * mean + 0.1
            self.assertAlmostEqual(arrays["mean"][i], mean, delta=1e-3)
            self.assertAlmostEqual(arrays["density_g_cm3"][i], density, delta=1e-5)
            self.assertAlmostEqual(arrays["modulus_mpa"][i], 6850 * density ** 1.49, delta=0.01)
        self.assertEqual(set(arrays["material"]), set(range(1, report["materials"] + 1)))
        self.assertLessEqual(report["materials"], 2 * 5)
        self.json("map.8vo", "--octree", "--of", "grey.8vo", "--density", "0.01,0.1", "--modulus",
                  "6850,1.49", "--bins", "5", "--poisson", "0.35", "-o", "m.inp")
        text = (self.folder / "m.inp").read_text()
        self.assertEqual(text.count("*SOLID SECTION"), report["materials"])
        self.assertEqual(text.count("*ELASTIC"), report["materials"])
        self.assertIn(", 0.35\n", text)
        numbers = re.findall(r"-?[\d.]+(?:e[+-]\d+)?", text)
        self.assertLessEqual(max(map(len, numbers)), 20)  # what CalculiX reads of a number
        moduli = [float(m) for m in re.findall(r"\*ELASTIC\n([\d.e+]+),", text)]
        lowest, highest = report["modulus_range_mpa"]
        self.assertTrue(all(lowest <= modulus <= highest for modulus in moduli))

    def test_densities_below_0_are_counted_and_have_the_modulus_of_density_0(self):
        told = []
        for name in ("m.vtu", "m.inp"):
            report = self.json("map.8vo", "--of", "grey.8vo", "--density", "0.01,-1", "--modulus",
                               "6850,1.49", "--min-modulus", "2", "-o", name)
            told.append(" ".join(map(str, report["warnings"])))
        _, _, arrays = read_vtu(self.folder / "m.vtu")
        below = [i for i, mean in enumerate(arrays["mean"]) if 0.01 * mean - 1 < -1e-9]
        self.assertGreater(len(below), 0)
        for i in below:
            self.assertAlmostEqual(arrays["density_g_cm3"][i], 0.01 * arrays["mean"][i] - 1, 5)
            self.assertEqual(arrays["modulus_mpa"][i], 2)
        for text in told:
            self.assertIn(f"grey.8vo: {len(below)} of {self.voxels} cells have a density below 0 "
                          "and get the modulus of density 0", text)
            self.assertIn("check --density", text)
        lines = (self.folder / "m.inp").read_text().split("*DENSITY\n")[1:]
        self.assertTrue(lines and all(float(text.split()[0]) > 0 for text in lines))

    def test_comments_say_the_label_of_each_attribute_of_mfem(self):
        data = struct.pack("<%dh" % len(places()), *(-300 * label_at(*place) for place in places()))
        self.build("below.8vo", data, "int16", "--labels")
        self.json("below.8vo", "-o", "m.mesh")
        head, behind = (self.folder / "m.mesh").read_text().split("\ndimension\n")
        comments = [line for line in head.splitlines() if line.startswith("# attribute")]
        self.assertEqual(comments, ["# attribute 1 = label -900", "# attribute 2 = label -300"])
        lines = behind.split("elements\n")[1].splitlines()[1:self.voxels + 1]
        counts = [sum(line.split()[0] == attribute for line in lines) for attribute in "12"]
        self.assertEqual(counts, [sum(label_at(*place) == label for place in places())
                                  for label in (3, 1)])
        report = self.json("map.8vo", "--of", "grey.8vo", "--density", "0.01,1", "--modulus",
                           "6850,1.49", "-o", "m.mesh", "-f")
        head = (self.folder / "m.mesh").read_text().split("\ndimension\n")[0]
        moduli = [float(modulus)
                  for modulus in re.findall(r"# attribute \d+ = label [13], (.+) MPa", head)]
        self.assertEqual(len(moduli), report["materials"])
        lowest, highest = report["modulus_range_mpa"]
        self.assertTrue(all(lowest <= modulus <= highest for modulus in moduli))

    def test_only_the_largest_part_is_kept(self):
        blocks = [((2, 2, 2), 6), ((8, 8, 8), 4)]  # touch in a corner
        mask = bytes(any(all(c <= p < c + s for p, c in zip(place, corner)) for corner, s in blocks)
                     for place in places())
        self.build("two.8vo", mask, "uint8", "--labels")
        both = self.json("two.8vo", "-o", "m.inp")
        self.assertEqual((both["parts"], both["elements"]), (2, 6 ** 3 + 4 ** 3))
        one = self.json("two.8vo", "--keep-largest", "-o", "n.inp")
        self.assertEqual((one["parts"], one["elements"]), (2, 6 ** 3))
        told = self.expect(0, "hexahedra", "two.8vo", "-o", "o.inp").stderr
        self.assertIn("--keep-largest", told)

    def test_levels_are_those_of_the_file(self):
        report = self.json("map.8vo", "--level", "1", "-o", "m.vtu")
        self.assertLess(report["elements"], self.voxels)
        points, elements, _ = read_vtu(self.folder / "m.vtu")
        volumes = [volume_of([points[i] for i in element]) for element in elements]
        self.assertAlmostEqual(sum(volumes), report["volume_mm3"], delta=1e-9)
        self.assertGreater(min(volumes), VOXEL_MM3)

    def test_bad_input_is_one_sentence_and_no_file(self):
        self.build("empty.8vo", bytes(len(places())), "uint8", "--labels")
        before = sorted(path.name for path in self.folder.iterdir())
        inp = ["map.8vo", "-o", "m.inp"]
        of = [*inp, "--of", "grey.8vo"]
        for code, words, expected in [
                (2, ["empty.8vo", "-o", "m.inp"], "is empty"),
                (2, [*inp, "--label", "2"], "asked for"),
                (2, [*inp, "--label", "3", "--label", "2", "--label", "13"],
                 "no voxel of level 0 has label 2 or label 13"),
                (2, [*inp, "--label", "3", "--label", "Bone"], "'Bone'"),
                (2, ["grey.8vo", "-o", "m.inp"], "octavo threshold"),
                (2, [*inp, "--level", "30"], "level 30"),
                (2, ["map.8vo", "-o", "m.stl"], ".vtu, .inp, .msh or .mesh"),
                (2, ["map.8vo", "--octree", "-o", "m.msh"], "--conforming"),
                (2, [*inp, "--octree", "--uniform"], "--uniform"),
                (2, [*inp, "--density", "1,0"], "give --of"),
                (2, [*of, "--modulus", "6850,1.49"], "give --density"),
                (2, [*of, "--density", "1"], "--density"),
                (2, [*of, "--density", "1,0", "--modulus", "-1,2"], "above 0"),
                (2, [*of, "--density", "1,0", "--modulus", "1,2", "--poisson", "0.5"], "Poisson"),
                (2, [*of, "--density", "1,0"], "give --modulus"),
                (2, ["map.8vo", "-o", "m.mesh", "--of", "grey.8vo", "--density", "1,0"], ".vtu"),
                (2, [*inp, "--poisson", "0.5"], "Poisson"),
                (2, [*of, "--density", "1e300,0", "--modulus", "1,2"], "check --density"),
                (2, ["map.8vo", "-o", "m.vtu", "--of", "grey.8vo", "--density", "0,1e300"],
                 "check --density"),
                (2, [*of, "--density", "1,2", "--modulus", "1e300,50"],
                 "check --density and --modulus"),
                (2, [*of, "--density", "1,0", "--modulus", "1,2", "--min-modulus", "1e300"],
                 "minimum modulus"),
                (2, [*inp, "--of", "map.8vo"], "not grey values"),
                (6, [*inp, "--max-memory", "1K"], "the limit is 1024 bytes"),
                (5, ["map.8vo", "-o", "missing/m.inp"], "missing"),
                (5, ["map.8vo", "-o", "grey.8vo/m.inp"], "grey.8vo"),
                (5, ["gone.8vo", "-o", "m.inp"], "gone.8vo")]:
            with self.subTest(words=words):
                failure = self.expect(code, "hexahedra", *words)
                self.assertIn(expected, failure.stderr)
                self.assertEqual(len(failure.stderr.strip().splitlines()), 1)
                self.assertEqual(sorted(path.name for path in self.folder.iterdir()), before)

    def test_memory_for_nodes_is_asked_before_they_are_made(self):
        mask = bytearray(256 * 256 * 64)
        for z in range(8, 64, 16):
            for y in range(8, 256, 16):
                for x in range(8, 256, 16):
                    mask[(z * 256 + y) * 256 + x] = 1
        (self.folder / "lone.raw").write_bytes(mask)
        self.expect(0, "build", "lone.raw", "--raw", "256,256,64,uint8", "--spacing", "1,1,1",
                    "--labels", "-o", "lone.8vo", "-q")
        # 1024 blocks of nodes of 1650 bytes, twice while they are numbered.
        failure = self.expect(6, "hexahedra", "lone.8vo", "-o", "m.inp", "--max-memory", "2M")
        self.assertIn("the hexahedra would take about 3", failure.stderr)
        self.expect(0, "hexahedra", "lone.8vo", "-o", "m.inp", "--max-memory", "4M")

    def test_a_file_that_is_there_stays(self):
        (self.folder / "m.inp").write_text("mine")
        failure = self.expect(5, "hexahedra", "map.8vo", "-o", "m.inp")
        self.assertIn("m.inp", failure.stderr)
        self.assertEqual((self.folder / "m.inp").read_text(), "mine")
        self.expect(5, "hexahedra", "map.8vo", "-o", "/dev/full/m.inp")

    def test_an_input_is_never_replaced(self):
        (self.folder / "map.8vo").rename(self.folder / "map.inp")
        (self.folder / "grey.8vo").rename(self.folder / "grey.inp")
        for output in ("map.inp", "grey.inp"):
            before = (self.folder / output).read_bytes()
            failure = self.expect(2, "hexahedra", "map.inp", "--of", "grey.inp", "-o", output, "-f")
            self.assertIn(f"{output}: is the input itself", failure.stderr)
            self.assertEqual((self.folder / output).read_bytes(), before)


if __name__ == "__main__":
    cli_test.OCTAVO = cli_test.os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
