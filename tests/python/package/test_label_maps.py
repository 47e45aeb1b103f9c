"""Masks and label maps as octrees: against scipy, and against the program."""

import json
import pickle
import threading
import tracemalloc

import numpy as np
import pytest

import octavo
from png_pixels import pixels_of, pixels_of_png

ndimage = pytest.importorskip("scipy.ndimage")

SPACING = (2.0, 0.5, 0.25)


@pytest.fixture(scope="module")
def grey():
    random = np.random.default_rng(3)
    noise = random.normal(0, 400, (70, 66, 81))
    return ndimage.gaussian_filter(noise, 1.5).astype(np.int16)


@pytest.fixture(scope="module")
def scan(grey, tmp_path_factory):
    path = tmp_path_factory.mktemp("masks") / "grey.8vo"
    octavo.build(grey, path, spacing=SPACING, origin=(5, 6, 7), unit="HU", slope=2,
                 intercept=-100).close()
    return str(path)


@pytest.fixture
def volume(scan):
    with octavo.open(scan) as volume:
        yield volume


@pytest.fixture
def mask(volume):
    return volume.threshold(-90, 60)


@pytest.fixture(scope="module")
def inside(grey):
    real = grey.astype(float) * 2 - 100
    return (real >= -90) & (real <= 60)


def structure(connectivity):
    return ndimage.generate_binary_structure(3, {6: 1, 18: 2, 26: 3}[connectivity])


def test_a_threshold_is_that_of_numpy(mask, inside):
    assert mask.is_mask and mask.dtype == np.uint8 and mask.shape == inside.shape
    assert np.array_equal(mask.to_numpy(), inside)
    assert mask.voxels == inside.sum() and mask.counts == {1: inside.sum()}
    assert mask.spacing == SPACING and bool(mask)


@pytest.mark.parametrize("key", [np.s_[...], np.s_[3], np.s_[-1, ..., 5], np.s_[10:40:3, ::-1, 7],
                                 np.s_[1, 2, 3], np.s_[5:5], np.s_[69:2:-30, :, ::40]], ids=str)
def test_an_index_chooses_what_numpy_does(mask, inside, key):
    chosen, wanted = mask[key], inside[key].astype(np.uint8)
    assert np.array_equal(chosen, wanted) and np.shape(chosen) == np.shape(wanted)


def test_other_ranges_are_those_of_numpy(volume, grey):
    assert np.array_equal(volume.threshold(high=3, stored=True)[...], grey <= 3)
    two = volume.threshold(ranges=[(-300, -200), (0, None)])[...]
    real = grey * 2.0 - 100
    assert np.array_equal(two, ((real >= -300) & (real <= -200)) | (real >= 0))


def test_set_operations_are_those_of_numpy(volume, mask, inside, grey):
    other = volume.threshold(low=0, stored=True)
    b = grey >= 0
    for made, wanted in [(mask & other, inside & b), (mask | other, inside | b),
                         (mask - other, inside & ~b), (mask ^ other, inside ^ b),
                         (~mask, ~inside)]:
        assert np.array_equal(made[...], wanted)
    assert not mask - mask
    assert mask == ~~mask and mask != other


@pytest.mark.parametrize("connectivity", [6, 18, 26])
def test_morphology_is_that_of_scipy(mask, inside, connectivity):
    element = structure(connectivity)
    eroded = ndimage.binary_erosion(inside, element, 2, border_value=1)
    assert np.array_equal(mask.dilate(2, connectivity=connectivity)[...],
                          ndimage.binary_dilation(inside, element, 2))
    assert np.array_equal(mask.erode(2, connectivity=connectivity)[...], eroded)
    assert np.array_equal(mask.open(2, connectivity=connectivity)[...],
                          ndimage.binary_dilation(eroded, element, 2))
    closed = ndimage.binary_erosion(ndimage.binary_dilation(inside, element, 2), element, 2,
                                    border_value=1)
    assert np.array_equal(mask.close(2, connectivity=connectivity)[...], closed)


def test_a_ball_in_mm_is_that_of_scipy(mask, inside):
    reached = ndimage.distance_transform_edt(~inside, SPACING) <= 1.1
    assert np.array_equal(mask.dilate(mm=1.1)[...], reached)


def test_filled_holes_are_those_of_scipy(mask, inside):
    assert np.array_equal(mask.fill_holes()[...], ndimage.binary_fill_holes(inside))
    assert np.array_equal(mask.fill_holes(connectivity=6)[...],
                          ndimage.binary_fill_holes(inside, structure(26)))
    assert mask.fill_holes(max_mm3=0) == mask


@pytest.mark.parametrize("connectivity", [6, 18, 26])
def test_components_are_those_of_scipy(mask, inside, connectivity):
    found = mask.components(connectivity=connectivity)
    labels, count = ndimage.label(inside, structure(connectivity))
    voxels = found[...]
    assert found.found == count == len(found.counts)
    pairs = set(zip(labels[inside].tolist(), voxels[inside].tolist()))
    assert len(pairs) == count and (voxels[~inside] == 0).all()
    sizes = [row["voxels"] for row in found.table]
    assert sizes == sorted(np.bincount(labels.ravel())[1:].tolist(), reverse=True)
    assert sizes == [found.counts[label] for label in range(1, count + 1)]


def test_the_largest_component_alone_is_a_mask(mask, inside):
    largest = mask.components(keep_largest=1)
    labels, _ = ndimage.label(inside)
    sizes = np.bincount(labels.ravel())[1:]
    assert np.array_equal(largest[...] > 0, labels == 1 + sizes.argmax())
    assert (mask & largest) == mask.components(keep_largest=1).select(1)


def test_files_are_those_of_the_program(run, scan, volume, tmp_path):
    def program(*words):
        out = tmp_path / f"{words[0]}.8vo"
        done = run(*words, "-o", out)
        assert done.returncode == 0, done.stderr
        return out
    first = program("threshold", scan, "--range", "-90:60")
    filled = program("fill-holes", first)
    grown = program("dilate", filled, "--mm", "1.1")
    labels = program("components", grown, "--connectivity", "26")
    mask = volume.threshold(-90, 60)
    made = mask.fill_holes().dilate(mm=1.1).components(connectivity=26)
    mask.save(tmp_path / "mask.8vo").close()
    made.save(tmp_path / "made.8vo").close()
    assert (tmp_path / "mask.8vo").read_bytes() == first.read_bytes()
    assert (tmp_path / "made.8vo").read_bytes() == labels.read_bytes()


def test_measures_are_those_of_the_program_and_of_numpy(run, scan, volume, tmp_path):
    labels = volume.threshold(-90, 60).components(keep_largest=5)
    labels.save(tmp_path / "labels.8vo").close()
    rows = labels.measure(of=volume, percentiles=(50,))
    done = run("measure", tmp_path / "labels.8vo", "--of", scan, "--percentile", 50, "--csv")
    lines = [line.split(",") for line in done.stdout.splitlines()]
    assert list(rows[0]) == lines[0]
    for row, line in zip(rows, lines[1:]):
        for value, text in zip(row.values(), line):
            assert str(value) == text or float(value) == float(text)
    real, held = volume[...] * 2.0 - 100, labels[...]
    for row in rows:
        inside = held == row["label"]
        assert row["voxels"] == inside.sum()
        assert row["mean"] == pytest.approx(real[inside].mean())
        assert row["mm3"] == pytest.approx(inside.sum() * np.prod(SPACING))
        z, y, x = (np.argwhere(inside).mean(0) * SPACING) + (5, 6, 7)
        assert (row["centroid_z_mm"], row["centroid_y_mm"], row["centroid_x_mm"]) == (
            pytest.approx(z), pytest.approx(y), pytest.approx(x))


def test_label_maps_of_files_keep_their_labels_and_names(tmp_path):
    voxels = np.zeros((20, 30, 40), np.uint16)
    voxels[2:9, 3:20, 5:30] = 7
    voxels[10:15, 3:20, 5:30] = 300
    path = tmp_path / "labels.8vo"
    octavo.build(voxels, path, kind="labels", label_names={7: "liver", 300: "spleen"}).close()
    with octavo.open(path) as volume:
        labels = volume.label_map()
        assert labels.dtype == np.uint16 and np.array_equal(labels[...], voxels)
        assert labels.label_names == {7: "liver", 300: "spleen"}
        assert labels.counts == {7: (voxels == 7).sum(), 300: (voxels == 300).sum()}
        assert np.array_equal(volume.mask()[...], voxels > 0)
        assert np.array_equal(volume.mask("spleen")[...], voxels == 300)
        assert np.array_equal(labels.select("liver")[...], voxels == 7)
        with pytest.raises(octavo.ArgumentError, match="no label is called heart"):
            labels.select("heart")
        saved = labels.save(tmp_path / "again.8vo")
        assert saved.voxels_sha256 == volume.voxels_sha256
        rows = labels.agreement(volume.label_map([7]))
        assert labels.agreement(volume) == labels.agreement(volume.label_map())
        assert [(row["label"], row["dice"]) for row in rows] == [(7, 1.0), (300, 0.0)]


def test_compare_tells_what_differs(volume, tmp_path):
    same = volume.compare(volume)
    assert same["equal"] and same["different_voxels"] == 0
    voxels = volume[...].copy()
    voxels[5, 6, 7] += 3
    other = octavo.build(voxels, tmp_path / "other.8vo", spacing=SPACING, origin=(5, 6, 7),
                         unit="HU", slope=2, intercept=-100)
    found = volume.compare(other)
    assert not found["equal"] and found["different_voxels"] == 1
    assert found["first_different"] == (5, 6, 7) and found["max_difference"] == 6
    assert volume.compare(other, max_error=6)["equal"]
    assert found["nan_in_one"] == 0


def test_compare_counts_what_is_nan_in_one_alone(tmp_path):
    voxels = np.zeros((4, 4, 4), np.float32)
    plain = octavo.build(voxels, tmp_path / "plain.8vo", spacing=SPACING)
    voxels[1, 2, 3] = np.nan
    voxels[2, 2, 2] = 5
    other = octavo.build(voxels, tmp_path / "other.8vo", spacing=SPACING)
    found = plain.compare(other)
    assert found["different_voxels"] == 2 and found["nan_in_one"] == 1
    assert found["max_difference"] == 5 and found["first_different"] == (1, 2, 3)


def test_a_surface_encloses_the_mask(mask):
    solid = mask.components(keep_largest=1).fill_holes()
    surface = solid.surface()
    points, faces = surface.vertices, surface.faces
    assert points.dtype == np.float32 and faces.dtype == np.uint32
    assert surface.facts["closed"] and surface.facts["manifold"]
    a, b, c = (points[faces[:, i]].astype(float) for i in range(3))
    enclosed = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6
    assert enclosed == pytest.approx(surface.facts["volume_mm3"])
    assert enclosed > 0
    index = (points[:, ::-1] - (5, 6, 7)) / SPACING
    assert (index >= -0.5001).all() and (index <= np.array(solid.shape) - 0.4999).all()
    # Every point of a mask's surface lies half way between a voxel inside and one outside.
    away = np.abs(index - np.round(index))
    assert np.allclose(away.max(1), 0.5, atol=1e-3) and np.allclose(np.sort(away)[:, 1], 0,
                                                                    atol=1e-3)


def test_surfaces_in_files_are_those_of_the_program(run, scan, volume, tmp_path):
    facts = volume.save_surface(tmp_path / "mine.stl", 60)
    done = run("surface", scan, "--isovalue", "60", "--max-deviation", "0", "-o",
               tmp_path / "theirs.stl")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "mine.stl").read_bytes() == (tmp_path / "theirs.stl").read_bytes()
    arrays = volume.surface(60)
    assert len(arrays.faces) == facts["triangles"]
    assert len(volume.surface(60, triangles=2000).faces) <= 2000


def test_pictures_are_those_of_the_program(run, scan, volume, tmp_path):
    from octavo import _notebook
    picture = volume.slice("y", 20, window=(-200, 100))
    assert picture.shape[2] == 3 and picture.dtype == np.uint8
    done = run("slice", scan, "--axis", "y", "--index", "20", "--window=-50,300", "-o",
               tmp_path / "slice.png")
    assert done.returncode == 0, done.stderr
    theirs = pixels_of(tmp_path / "slice.png")
    assert np.array_equal(picture, theirs)
    assert np.array_equal(pixels_of_png(_notebook.png_of(picture)), picture)
    drawn = volume.threshold(-90, 60).render(size=(200, 160), view="front")
    assert drawn.shape == (160, 200, 3) and drawn.std() > 10
    around = volume.render("mip", size=(60, 50), turntable=3)
    assert around.shape == (3, 50, 60, 3)
    assert "<img" in volume._repr_html_() and "HU" in volume._repr_html_()


def test_transforms_are_those_of_numpy_and_the_program(run, scan, volume, tmp_path):
    voxels = volume[...]
    mirrored = volume.transform(tmp_path / "mirrored.8vo", mirror="x")
    assert np.array_equal(mirrored[...], voxels[:, :, ::-1])
    turned = volume.transform(tmp_path / "turned.8vo", rotate=("z", 90))
    assert np.array_equal(turned[...], np.rot90(voxels, -1, (1, 2)))
    both = volume.transform(tmp_path / "both.8vo", rotate=("x", 30), translate_mm=(1, 2, 3))
    done = run("transform", scan, "--rotate", "x:30", "--translate-mm", "3,2,1", "-o",
               tmp_path / "theirs.8vo")
    assert done.returncode == 0, done.stderr
    assert both.compare(octavo.open(tmp_path / "theirs.8vo"))["same_stored"]
    onto = volume.threshold(60).transform(tmp_path / "onto.8vo", grid_of=mirrored)
    assert onto.shape == mirrored.shape and onto.kind == "labels"
    with pytest.raises(octavo.ArgumentError, match="no step is called turn"):
        volume.transform(tmp_path / "none.8vo", turn=3)


def test_condensed_volumes_are_those_of_the_program(run, scan, volume, tmp_path):
    mine = volume.condense(tmp_path / "mine.8vo", 40)
    assert run("condense", scan, "--flat", "40", "-o", tmp_path / "theirs.8vo").returncode == 0
    assert mine.compare(octavo.open(tmp_path / "theirs.8vo"))["same_stored"]


def test_tasks_work_on_bytes_and_on_closed_files_raise(scan):
    with open(scan, "rb") as file:
        volume = octavo.open(file.read())
    mask = volume.threshold(0)
    assert mask.measure(of=volume)[0]["voxels"] == mask.voxels
    assert volume.surface(0, level=1).facts["closed"]
    volume.close()
    with pytest.raises(octavo.ArgumentError, match="is closed"):
        volume.threshold(0)


@pytest.mark.parametrize("call, text", [
    (lambda v: v.threshold(), "needs a range"),
    (lambda v: v.threshold(5, 1), "begins above its end"),
    (lambda v: v.threshold("a"), "is .low, high."),
    (lambda v: v.threshold(float("nan")), "has no end that is NaN"),
    (lambda v: v.threshold(ranges=3), "ranges are several, not 3"),
    (lambda v: v.threshold(tissue=[3]), "tissue is text, not 3"),
    (lambda v: v.label_map(), "holds grey values"),
    (lambda v: v.threshold(0).dilate(1, mm=2), "not both"),
    (lambda v: v.threshold(0).dilate(connectivity=7), "connectivity is 6"),
    (lambda v: v.threshold(0).close(mm=1, connectivity=26), "with mm it says nothing"),
    (lambda v: v.threshold(0).dilate(-1), "voxels is a whole number"),
    (lambda v: v.threshold(0).fill_holes(max_mm3="x"), "max_mm3 is a number"),
    (lambda v: v.threshold(0).fill_holes(max_mm3=-1), "max_mm3 is 0 or more"),
    (lambda v: v.threshold(0).components(min_mm3=-1), "min_mm3 is 0 or more"),
    (lambda v: v.threshold(0).save("x.nii"), "ends in .8vo"),
    (lambda v: octavo.build(v, "x.8vo", max_error="x"), "max_error is a number"),
    (lambda v: octavo.build(v, "x.8vo", nan="x"), "nan is a number, not 'x'"),
    (lambda v: octavo.build(v, "x.8vo", inf="x"), "inf is a number, not 'x'"),
    (lambda v: v.threshold(0).select(0), "0 is the background"),
    (lambda v: v.surface(), "needs an isovalue"),
    (lambda v: v.surface(1e9), "no voxel has"),
    (lambda v: v.render("photo"), "mode is \"cubes\""),
    (lambda v: v.render(azimuth="left"), "azimuth is a number, not 'left'"),
    (lambda v: v.render(elevation=10**400), "elevation is a number"),
    (lambda v: v.render(level=1.5), "level is a whole number"),
    (lambda v: v.render(level=99), "the file has levels 0 to"),
    (lambda v: v.render("iso", isovalue="x"), "isovalue is a number"),
    (lambda v: v.render(view=3), "view is text, not 3"),
    (lambda v: v.render(background=0), "background is text"),
    (lambda v: v.render(transfer=3), "transfer is text"),
    (lambda v: v.render(tissues=[3]), "tissues is text"),
    (lambda v: v.render(labels=1.5), "labels are several, not 1.5"),
    (lambda v: v.render(size=64), "are several, not 64"),
    (lambda v: v.render(size=(64,)), "size is .width, height."),
    (lambda v: v.render(size=("a", 2)), "a side of size is a whole number"),
    (lambda v: v.render(zoom="x"), "zoom is a number"),
    (lambda v: v.render(turntable=1.5), "turntable is a whole number"),
    (lambda v: v.slice("w"), "axis is"),
    (lambda v: v.slice(index=1.5), "index is a whole number"),
    (lambda v: v.slice(level="x"), "level is a whole number"),
    (lambda v: v.slice(preset=3), "preset is text"),
    (lambda v: v.slice(overlays=[3]), "an overlay is a Volume or a LabelMap, not int"),
    (lambda v: v.surface(0, level="x"), "level is a whole number"),
    (lambda v: v.threshold(0).measure(of=v[...]), "of is a Volume or a LabelMap, not ndarray"),
    (lambda v: v.compare(3), "other is a Volume or a LabelMap"),
    (lambda v: octavo.export(3, "x.ome.zarr"), "volume is a Volume or a LabelMap, not int"),
    (lambda v: v.transform("x.8vo", grid_of=3), "grid_of is a Volume or a LabelMap"),
    (lambda v: v.transform("x.8vo", affine="x"), "affine is a 4 x 4 matrix"),
    (lambda v: v.transform("x.8vo", affine=np.diag([1, 1, 1, 2])), "0, 0, 0, 1 as its last row"),
    (lambda v: v.transform("x.8vo", affine=np.diag([1, 1, 1, np.nan])), "of finite numbers"),
    (lambda v: v.transform("x.8vo", affine=[[1, 0, 0, 0]] * 3 + [[5, 0, 0, 1]]), "last row"),
    (lambda v: v.compare(v, max_error=-1), "max_error is 0 or more"),
    (lambda v: v.threshold(0).saved().mask([]), "labels holds none"),
    (lambda v: v.threshold(0).saved().label_map(()), "labels holds none"),
    (lambda v: v.threshold(0).measure(labels=np.array([], int)), "labels holds none"),
    (lambda v: v.threshold(0).surface(labels=iter([])), "labels holds none"),
    (lambda v: v.measure(), "holds grey values, not labels"),
    (lambda v: v.threshold(0).save_surface("x.xyz"), "a surface is written as"),
])
def test_what_makes_no_sense_is_rejected(volume, call, text):
    with pytest.raises(octavo.ArgumentError, match=text):
        call(volume)


def test_sets_are_of_maps_and_not_of_arrays(mask):
    voxels = mask.to_numpy()
    for combine in (lambda a, b: a & b, lambda a, b: a | b, lambda a, b: a ^ b, lambda a, b: a - b):
        for pair in ((mask, voxels), (voxels, mask), (mask, voxels > 0), (voxels > 0, mask)):
            with pytest.raises(TypeError, match="combined with a LabelMap"):
                combine(*pair)
    # As an array it is one in everything else.
    assert (mask == voxels).all() and (voxels == mask).all()
    assert np.array_equal(voxels * mask, voxels) and np.add(mask, 1).max() == 2
    assert np.sum(mask) == mask.voxels and np.add.reduce(mask, axis=None) == mask.voxels
    with pytest.raises(TypeError, match="does not change"):
        np.add(mask, 1, out=mask)


def test_a_range_of_a_value_finds_it(tmp_path):
    values = np.arange(-128, 128, dtype=np.int16).reshape(4, 8, 8)
    with octavo.build(values, tmp_path / "s.8vo", slope=0.1, intercept=-1024) as scaled:
        for at in np.ndindex(4, 8, 8):
            real = scaled.real[at]
            assert np.argwhere(scaled.threshold(real, real).to_numpy()).tolist() == [list(at)]


def test_masks_of_other_grids_do_not_go_together(volume, mask, tmp_path):
    small = octavo.build(np.ones((4, 5, 6), bool), tmp_path / "small.8vo", spacing=SPACING)
    with pytest.raises(octavo.ArgumentError, match="voxels"):
        mask & small.mask()
    moved = octavo.build(np.ones(mask.shape, bool), tmp_path / "moved.8vo", spacing=SPACING)
    with pytest.raises(octavo.ArgumentError, match="lies up to"):
        mask | moved.mask()
    for other in (3, None):
        with pytest.raises(TypeError, match="unsupported operand"):
            mask & other


def test_a_transfer_function_is_named_by_a_path(volume, tmp_path):
    path = tmp_path / "größe.json"
    path.write_text('{"points": [{"value": 0, "color": "sand", "opacity": 0},'
                    ' {"value": 50, "color": "white", "opacity": 1}]}')
    drawn = volume.render("volume", transfer=path, size=(60, 50))
    assert np.array_equal(drawn, volume.render("volume", transfer=str(path), size=(60, 50)))


def test_an_empty_mask_warns(volume):
    with pytest.warns(UserWarning, match="the mask is empty"):
        nothing = volume.threshold(1e6)
    assert not nothing and nothing.components().table == [] and nothing.counts == {}


def test_work_lets_other_threads_run_and_tells_progress(volume):
    told = []
    volume.threshold(0, progress=lambda done, total, what: told.append((done, total, what)))
    assert told and told[-1][2] == "mask"

    def stop(*_):
        raise KeyboardInterrupt
    with pytest.raises(KeyboardInterrupt):
        volume.threshold(0, progress=stop)
    masks = []
    threads = [threading.Thread(target=lambda: masks.append(volume.threshold(0)))
               for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(one == masks[0] for one in masks)


def test_metadata_say_how_a_mask_was_made(mask):
    assert "dilate" in json.dumps(mask.dilate(2).attrs)


def test_a_volume_still_pickles(volume):
    assert pickle.loads(pickle.dumps(volume)).threshold(0) == volume.threshold(0)


def test_a_call_amid_another_one_leaves_it_its_files(grey, tmp_path):
    octavo.build(grey, tmp_path / "a.8vo", spacing=(1, 1, 1)).close()
    volume = octavo.open((tmp_path / "a.8vo").read_bytes())
    mask = volume.threshold(0)
    told = []

    def progress(*_):
        told.append(volume.threshold(0).voxels)

    mask.morphometry(of=volume, progress=progress)
    assert told and set(told) == {mask.voxels}


def test_a_map_pickles_as_what_it_is(mask):
    for one in mask, mask.components(keep_largest=5), mask - mask, mask.dilate(2):
        there = pickle.loads(pickle.dumps(one))
        assert there == one and np.array_equal(there[...], one[...])
        for name in ("is_mask", "dtype", "spacing", "origin", "label_names", "attrs", "table",
                     "found", "counts"):
            assert getattr(there, name) == getattr(one, name), name
        assert np.array_equal(there.affine, one.affine)


def test_maps_that_lie_elsewhere_are_not_equal(mask, inside, tmp_path):
    elsewhere = octavo.build(inside, tmp_path / "a.8vo", spacing=(9, 2, 1)).mask()
    there = octavo.build(inside, tmp_path / "b.8vo", spacing=(9, 2, 1)).mask()
    assert elsewhere == there and mask != elsewhere and mask not in [elsewhere]


def test_steps_through_a_map_hold_what_they_choose(mask, inside):
    for key in np.s_[::30, ::-20, 3::40], np.s_[60:2:-7, 5, ::3], np.s_[::69], np.s_[:, 1:2:5]:
        assert np.array_equal(mask[key], inside[key])
    tracemalloc.start()
    mask[::69]
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < mask.size / 4


def test_build_of_a_label_map_is_its_save(mask, tmp_path):
    saved, built = mask.save(tmp_path / "a.8vo"), octavo.build(mask, tmp_path / "b.8vo")
    assert (tmp_path / "a.8vo").read_bytes() == (tmp_path / "b.8vo").read_bytes()
    assert (built.kind, built.spacing, built.origin) == ("labels", mask.spacing, mask.origin)
    with pytest.raises(octavo.StorageError, match="overwrite=True"):
        octavo.build(mask, tmp_path / "b.8vo")
    again = octavo.build(mask, tmp_path / "b.8vo", kind="labels", overwrite=True, thumbnail=True)
    assert again.voxels_sha256 == saved.voxels_sha256
    for option in ({"spacing": (1, 1, 1)}, {"kind": "grey"}, {"preset": "fast"}, {"resume": True}):
        with pytest.raises(octavo.ArgumentError, match=f"{[*option][0]} cannot be given"):
            octavo.build(mask, tmp_path / "c.8vo", **option)
    assert not (tmp_path / "c.8vo").exists()
