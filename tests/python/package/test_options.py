"""What the verbs of the program can be asked, asked in Python: the results are the program's."""

import json

import numpy as np
import pytest

import octavo
from png_pixels import pixels_of

ndimage = pytest.importorskip("scipy.ndimage")
SPACING = (2.0, 0.5, 0.75)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("options")


@pytest.fixture(scope="module")
def scan(folder):
    random = np.random.default_rng(3)
    grey = ndimage.gaussian_filter(random.normal(0, 900, (40, 70, 66)), 3)
    grey += ndimage.gaussian_filter((np.indices(grey.shape)[0] % 20 < 10) * 400.0, 4)
    return octavo.build(grey.astype(np.int16), folder / "scan.8vo", spacing=SPACING,
                        origin=(5, 6, 7), unit="HU")


def test_messages_count_z_y_x(scan, folder):
    other = octavo.build(np.ones((3, 4, 5), np.int16), folder / "other.8vo", spacing=(3, 2, 1))
    with pytest.raises(octavo.ArgumentError, match="has 3 x 4 x 5 voxels, .* has 40 x 70 x 66"):
        scan.threshold(0) & other.threshold(0)
    with pytest.raises(octavo.ArgumentError, match="seed 90,2,3 lies outside its 40 x 70 x 66"):
        scan.surface(0, seed=(90, 2, 3))
    with pytest.warns(UserWarning, match="a shift by 99,0,1 moves all of its 40 x 70 x 66"):
        scan.transform(folder / "moved.8vo", shift=(99, 0, 1), in_place=True)


def test_who_has_called_is_warned_whatever_thread_works(scan):
    fsspec = pytest.importorskip("fsspec")
    with open(scan.name, "rb") as file:
        fsspec.filesystem("memory").pipe("/scan.8vo", file.read())
    for volume in scan, octavo.open("memory://scan.8vo"):
        with pytest.warns(UserWarning, match="the mask is empty") as caught:
            volume.threshold(1e6)
        assert [one.filename for one in caught] == [__file__]


@pytest.fixture(scope="module")
def labels(folder):
    at = np.indices((40, 70, 66)) - np.array([20, 35, 33]).reshape(3, 1, 1, 1)
    far = np.sqrt((at ** 2).sum(0))
    found = np.where(far < 8, 7, np.where((far < 15) & (at[2] > 0), 3, np.where(far < 15, 2, 0)))
    return octavo.build(found.astype(np.uint8), folder / "labels.8vo", kind="labels",
                        spacing=SPACING, origin=(5, 6, 7),
                        label_names={7: "core", 3: "right", 2: "left"})


@pytest.fixture(scope="module")
def mesh(labels, folder):
    labels.save_surface(folder / "core.stl", labels=7)
    return folder / "core.stl"


def test_slices_are_those_of_the_program(run, scan, labels, folder):
    cases = {
        "plane": (dict(plane=((40, 20, 30), (1, 0.5, 0.25))), ["--plane", "30,20,40,0.25,0.5,1"]),
        "normal": (dict(plane=(1, 1, 0)), ["--plane", "0,1,1"]),
        "montage": (dict(montage=(3, 2), every=5), ["--montage", "3x2", "--every", "5"]),
        "wash": (dict(overlays=[(labels, dict(kind="wash", opacity=0.3))], labels=["core", 3]),
                 ["--overlay", labels.name, "--overlay-as", "wash", "--overlay-opacity", "0.3",
                  "--label", "core", "--label", "3"]),
        "lines": (dict(overlays=[(scan, dict(levels=[0, 150], color="red"))]),
                  ["--overlay", scan.name, "--overlay-levels", "0,150", "--overlay-color", "red"]),
    }
    for name, (asked, words) in cases.items():
        done = run("slice", scan.name, *words, "-o", folder / f"{name}.png")
        assert done.returncode == 0, done.stderr
        drawn, theirs = scan.slice(**asked), pixels_of(folder / f"{name}.png")
        assert drawn.shape == theirs.shape, name
        if name == "lines":  # a file over itself has another name in the legend
            drawn, theirs = drawn[:400, :300], theirs[:400, :300]
        assert np.array_equal(drawn, theirs), name


VIEWS = {
    "cubes": (dict(mode="cubes", labels=["core", 3], shade="smooth", fade=0.2, cuts="x<30",
                   removed=[((0, 0, 0), (20, 35, None))], direction=(1, 2, 3)),
              ["--mode", "cubes", "--label", "core", "--label", "3", "--shade", "smooth", "--fade",
               "0.2", "--cut", "x<30", "--cut", "0:,0:35,0:20", "--direction", "3,2,1"]),
    "colors": (dict(mode="surface", ranges=[(2, 2, "red"), (3, 3)]),
               ["--mode", "surface", "--range", "2:2=red", "--range", "3:3"]),
}
RAYS = {
    "volume": (dict(shadows=True, ambient_shade=True, perspective=30, smooth_edges=True),
               ["--shadows", "--ambient-shade", "--perspective", "30", "--smooth-edges"]),
    "adaptive": (dict(adaptive=True, moving=True), ["--adaptive", "--moving"]),
    "marks": (dict(marks=[((40, 20, 25), "here", "yellow"), (35, 25, 20)]),
              ["--mark", "20,25,35"]),
    "sums": (dict(mode="transparency", average=True, ranges=[(0, 200, "green", 0.02)]),
             ["--mode", "transparency", "--average", "--range", "0:200=green:0.02"]),
}


@pytest.mark.parametrize("name", VIEWS)
def test_views_of_labels_are_those_of_the_program(run, labels, folder, name):
    asked, words = VIEWS[name]
    done = run("render", labels.name, *words, "--size", "200x150", "-o", folder / f"{name}.png")
    assert done.returncode == 0, done.stderr
    drawn = labels.render(size=(200, 150), **asked)
    assert np.array_equal(drawn, pixels_of(folder / f"{name}.png"))


@pytest.mark.parametrize("name", RAYS)
def test_views_of_grey_values_are_those_of_the_program(run, scan, folder, name):
    asked, words = RAYS[name]
    if name == "marks":
        # The program's marks have no color of their own.
        assert not np.array_equal(scan.render(size=(200, 150), **asked),
                                  scan.render(size=(200, 150)))
        asked = dict(marks=[(35, 25, 20)])
    words = words if "--mode" in words else ["--mode", "volume", *words]
    done = run("render", scan.name, *words, "--size", "200x150", "-o", folder / f"{name}.png")
    assert done.returncode == 0, done.stderr
    assert np.array_equal(scan.render(size=(200, 150), **asked), pixels_of(folder / f"{name}.png"))


def test_company_of_a_view_is_that_of_the_program(run, scan, labels, mesh, folder):
    words = ["render", scan.name, "--mode", "volume", "--size", "200x150"]
    done = run(*words, "--labels", labels.name, "--label-look", "core=red:0.2", "--label-look",
               "3=mr", "--label-look", "other=none", "--mesh", f"{mesh}=blue:0.5", "-o",
               folder / "company.png")
    assert done.returncode == 0, done.stderr
    drawn = scan.render(size=(200, 150), label_map=labels, meshes=[(mesh, "blue", 0.5)],
                        label_looks={"core": ("red", 0.2), 3: "mr", None: None})
    assert np.array_equal(drawn, pixels_of(folder / "company.png"))
    done = run("render", scan.name, "--mode", "mip", "--size", "200x150", "--mask", labels.name,
               "-o", folder / "masked.png")
    assert done.returncode == 0, done.stderr
    masked = scan.render("mip", size=(200, 150), mask=labels)
    assert np.array_equal(masked, pixels_of(folder / "masked.png"))
    in_memory = scan.render("mip", size=(200, 150), mask=labels.mask())
    assert np.array_equal(masked[:100, :100], in_memory[:100, :100])


def test_surfaces_with_fewer_triangles_are_those_of_the_program(run, scan, folder):
    for name, asked, words in (
            ("voxels", dict(max_deviation_voxels=0.5), ["--max-deviation", "0.5voxel"]),
            ("octree", dict(max_deviation_voxels=0.5, method="octree"),
             ["--max-deviation", "0.5voxel", "--method", "octree"]),
            ("share", dict(triangles="20%"), ["--triangles", "20%"])):
        facts = scan.save_surface(folder / f"{name}-mine.stl", 150, report=folder / f"{name}.json",
                                  allow_faults=True, **asked)
        done = run("surface", scan.name, "--isovalue", "150", *words, "--allow-open", "-o",
                   folder / f"{name}-theirs.stl")
        assert done.returncode == 0, done.stderr
        assert ((folder / f"{name}-mine.stl").read_bytes() ==
                (folder / f"{name}-theirs.stl").read_bytes()), name
        assert facts["triangles"] < facts["full_triangles"]
        assert json.loads((folder / f"{name}.json").read_text())["triangles"] == facts["triangles"]


def test_surfaces_of_labels_are_those_of_the_program(run, labels, folder):
    facts = labels.save_label_surfaces(folder / "mine", labels=["core", 3], smooth=5,
                                       max_deviation_voxels=0.5)
    done = run("surface", labels.name, "--parts", "--label", "core", "--label", "3", "--smooth",
               "5", "-o", folder / "theirs", "--json")
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert [row["label"] for row in facts["labels"]] == [3, 7]
    for mine, theirs in zip(facts["labels"], said["labels"]):
        for key in ("label", "triangles", "points", "closed", "manifold", "voxels"):
            assert mine[key] == theirs[key]
    files = sorted(path.name for path in (folder / "mine").iterdir())
    assert files == sorted(path.name for path in (folder / "theirs").iterdir())
    for name in files:
        if name.endswith(".stl"):
            assert (folder / "mine" / name).read_bytes() == (folder / "theirs" / name).read_bytes()
    both = labels.save_label_surfaces(folder / "all.ply", form="interfaces", max_deviation_voxels=0)
    assert both["pairs"] == 5 and both["triangles"] == both["full_triangles"]
    with pytest.raises(octavo.ArgumentError):
        labels.threshold(1).saved().save_label_surfaces(folder / "all.stl", form="interfaces")


def test_hexahedra_are_those_of_the_program(run, scan, labels, folder):
    facts = labels.save_hexahedra(folder / "mine.inp", method="conforming", level=1,
                                  keep_largest=True, of=scan, density=(0.001, 1), quality=True,
                                  modulus=(6850, 1.49), bins=8)
    done = run("hexahedra", labels.name, "--conforming", "--level", "1", "--keep-largest", "--of",
               scan.name, "--density", "0.001,1", "--modulus", "6850,1.49", "--bins", "8",
               "--quality", "-o", folder / "theirs.inp", "--json")
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    for key in ("elements", "nodes", "hanging_nodes", "voxels", "labels", "materials",
                "file_bytes", "parts", "quality"):
        assert facts[key] == said[key], key
    assert (folder / "mine.inp").read_bytes() == (folder / "theirs.inp").read_bytes()


def test_classes_and_contacts_are_those_of_numpy(run, scan, labels, folder):
    made = scan.classify({1: (None, 0), 2: (-50, 150), 9: (150, None)})
    grey = scan[...]
    assert np.array_equal(made[...], np.select([grey <= 0, grey <= 150], [1, 2], 9))
    rows = labels.touch()
    voxels = labels[...]
    area = {"x": 1.0, "y": 1.5, "z": 0.375}
    for row in rows:
        pair = {row["first"], row["second"]}
        faces = 0.0
        for axis, name in enumerate("zyx"):
            a, b = np.delete(voxels, -1, axis), np.delete(voxels, 0, axis)
            faces += area[name] * sum(((a == p) & (b == q)).sum()
                                      for p, q in (tuple(pair), tuple(pair)[::-1]))
        assert row["area_mm2"] == pytest.approx(faces)
    assert [(row["first"], row["second"]) for row in rows] == [(2, 3), (2, 7), (3, 7)]
    met = labels.mask(7).touch(labels.mask([2, 3]))
    assert met["overlap"] == {"voxels": 0, "box": None}
    assert met["area_mm2"] == pytest.approx(sum(r["area_mm2"] for r in rows[1:]))
    core = np.argwhere(voxels == 7)
    low, high = met["contact"]["box"]
    assert (np.array(low) >= core.min(0)).all() and (np.array(high) <= core.max(0) + 1).all()
    shell = labels.mask().shell()
    assert 0 < shell.voxels < labels.mask().voxels and not (shell - labels.mask())


def test_references_between_cubes_are_counted_as_the_program_does(run, scan, folder):
    coded = octavo.build(scan[...], folder / "coded.8vo", spacing=SPACING, max_error=4)
    found = scan.self_similarity(8, up_to_mean=True, coded=coded)
    done = run("condense", scan.name, "--self-similar", "8", "--up-to-mean", "--coded", coded.name,
               "--json")
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert found["saved_bytes"] == pytest.approx(said["saved_bytes"])
    assert found["levels"] == said["levels"]


def test_meshes_points_and_lines_are_laid_onto_masks(run, labels, mesh, folder):
    mask = labels.mask([7, 3])
    vertices, _, _ = mask.surface()
    turn = np.array([[0, -1, 0, 30], [1, 0, 0, -20], [0, 0, 1, 12.5], [0, 0, 0, 1.0]])
    moved = (np.linalg.inv(turn) @ np.c_[vertices, np.ones(len(vertices))].T).T[:, :3]
    found = mask.align_features(moved[::3], output=folder / "pose.txt",
                                picture=folder / "pose.png")
    assert found["found"] and np.abs(found["matrix_mm"] - turn).max() < 0.5
    assert pixels_of(folder / "pose.png").shape[2] == 3
    saved = mask.save(folder / "moved-onto.8vo")
    np.savetxt(folder / "points.csv", moved[::3], delimiter=",", fmt="%.17g")
    done = run("align", folder / "points.csv", saved.name, "-o", folder / "theirs.txt", "--json")
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert np.array_equal(found["matrix_mm"][:3], np.array(said["matrix_mm"])[:3])
    assert {**found, "matrix_mm": said["matrix_mm"]}.items() <= said.items()
    assert (folder / "pose.txt").read_text() == (folder / "theirs.txt").read_text()
    by_file = labels.mask(7).align_features(mesh)
    assert by_file["points"] > 100 and not by_file["has_lines"]


def test_histograms_of_thickness_are_drawn(labels, folder):
    labels.mask().morphometry(histogram=folder / "thickness.png")
    assert pixels_of(folder / "thickness.png").shape[0] > 50


@pytest.mark.parametrize("call, text", [
    (lambda v: v.slice(plane=(1, 2)), "the point of a plane is .z, y, x."),
    (lambda v: v.slice(plane="z"), "plane is .z, y, x."),
    (lambda v: v.slice(montage=(2,)), "montage is .columns, rows."),
    (lambda v: v.slice(every=0), "every is a whole number from 1"),
    (lambda v: v.slice(overlays=[(v, {"shade": "red"})]), "how an overlay is drawn"),
    (lambda v: v.slice(overlays=[(v, {"kind": "dots"})]), "kind is"),
    (lambda v: v.slice(salvage="much"), "salvage is a number"),
    (lambda v: v.render(cuts="w<3"), "a cut is like"),
    (lambda v: v.render("mip", removed=[((0, 0), (1, 1))]), "a box is"),
    (lambda v: v.render(fade=2), "fade is from 0 to 1"),
    (lambda v: v.render(shade="dark"), "shade is"),
    (lambda v: v.render(ranges=[(1,)]), "a range is"),
    (lambda v: v.render(meshes=[(1, 2)]), "path of a mesh is text"),
    (lambda v: v.render(meshes=["none.stl"]), "none.stl"),
    (lambda v: v.render(marks=[(1, 2)]), "the place of a mark|a mark is"),
    (lambda v: v.render(label_looks={1: "red"}), "label"),
    (lambda v: v.render(label_looks=[1]), "label_looks is a dict"),
    (lambda v: v.render(mask=3), "mask is a Volume or a LabelMap"),
    (lambda v: v.render("cubes", shadows=True, ranges=[(0, 1)]), "shadow"),
    (lambda v: v.surface(0, triangles="5"), "triangles is a number or like"),
    (lambda v: v.surface(0, method="best"), "method is"),
    (lambda v: v.surface(0, max_deviation_mm=1, max_deviation_voxels=1), "not both"),
    (lambda v: v.save_label_surfaces("parts"), "grey"),
    (lambda v: v.classify([1]), "classes are a dict"),
    (lambda v: v.classify({0: (1, 2)}), "a label is a whole number from 1"),
    (lambda v: v.self_similarity(-1), "difference"),
    (lambda v: v.threshold(0).align_features([[1, 2]]), "features are a file"),
    (lambda v: v.threshold(0).align_features("none.stl"), "none.stl"),
    (lambda v: v.threshold(0).touch(v), "grey"),
    (lambda v: v.threshold(0).touch(connectivity=7), "connectivity"),
    (lambda v: v.threshold(0).save_hexahedra("m.inp", modulus=3), "modulus are several|modulus is"),
])
def test_what_makes_no_sense_is_rejected(scan, call, text):
    with pytest.raises(octavo.Error, match=text):
        call(scan)
