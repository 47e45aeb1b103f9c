"""Readers for other tools, each with the real package, where it is installed."""

import numpy as np
import pytest

import octavo

DIRECTIONS = {
    "upright": np.eye(3),
    "oblique": np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]]),
    "left-handed": np.diag([1.0, -1.0, 1.0]),
}


@pytest.fixture(params=DIRECTIONS, scope="module")
def scan(request, tmp_path_factory):
    random = np.random.default_rng(2)
    voxels = random.integers(-30, 31, (40, 70, 90)).cumsum(2).astype(np.int16)
    path = tmp_path_factory.mktemp("tools") / "scan.8vo"
    return octavo.build(voxels, path, spacing=(3, 0.7, 0.5), origin=(-9, 40, 11.5), slope=2,
                        intercept=-1000, unit="HU", direction=DIRECTIONS[request.param])


def test_simpleitk_has_every_voxel_at_its_place(scan, tmp_path):
    pytest.importorskip("SimpleITK")
    from octavo.sitk import from_sitk, to_sitk
    for view in scan.levels[:3]:
        start = tuple(n // 3 for n in view.shape)
        image = to_sitk(view, (start, view.shape))
        for index in [(0, 0, 0), (2, 3, 4)]:
            at = tuple(a + b for a, b in zip(start, index))
            assert image[index[::-1]] == view[at]
            world = image.TransformIndexToPhysicalPoint(index[::-1])
            assert np.allclose(world, (view.affine @ [*at, 1])[:3])
    real = to_sitk(scan, real=True)
    assert real[4, 3, 2] == scan.real[2, 3, 4]
    back = from_sitk(to_sitk(scan), tmp_path / "back.8vo")
    assert back.voxels_sha256 == scan.voxels_sha256
    assert np.allclose(back.affine, scan.affine)


def test_vtk_decodes_the_extent_that_it_asks_for(scan):
    pytest.importorskip("vtkmodules")
    from vtkmodules.util import numpy_support
    from octavo.vtk import Reader
    reader = Reader(scan.name, level=1)
    view = scan.real.levels[1]
    reader.UpdateExtent((5, 20, 3, 30, 2, 11))
    image = reader.GetOutputDataObject(0)
    assert image.GetExtent() == (5, 20, 3, 30, 2, 11)
    values = numpy_support.vtk_to_numpy(image.GetPointData().GetScalars()).reshape(10, 28, 16)
    assert np.array_equal(values, view[2:12, 3:31, 5:21])
    world = [0.0, 0.0, 0.0]
    image.TransformIndexToPhysicalPoint((7, 9, 5), world)
    assert np.allclose(world, (scan.levels[1].affine @ [5, 9, 7, 1])[:3])
    reader.SetLevel(0)
    reader.Update()
    assert reader.GetOutputDataObject(0).GetDimensions() == scan.shape[::-1]


def test_napari_gets_all_levels_and_their_place(scan, tmp_path):
    pytest.importorskip("dask.array")
    from octavo.napari import get_reader
    assert get_reader("scan.nii") is None
    (levels, attributes, kind), = get_reader(scan.name)(scan.name)
    assert kind == "image" and attributes["multiscale"] and len(levels) > 2
    assert np.array_equal(levels[1][3].compute(), scan.real.levels[1][3])
    world = attributes["affine"] @ [5, 6, 7, 1]
    assert np.allclose(world[2::-1], (scan.affine @ [5, 6, 7, 1])[:3])
    labels = octavo.build(np.arange(24, dtype=np.uint8).reshape(2, 3, 4) % 3,
                          tmp_path / "labels.8vo", kind="labels")
    assert get_reader(labels.name)([labels.name])[0][2] == "labels"


def test_npe2_finds_the_reader_of_the_manifest(scan):
    npe2 = pytest.importorskip("npe2")
    import pathlib
    manifest = npe2.PluginManifest.from_file(pathlib.Path(octavo.__file__).parent / "napari.yaml")
    manager = npe2.PluginManager()
    manager.register(manifest)
    assert [r.command for r in manager.iter_compatible_readers([scan.name])] == ["octavo.read"]


def test_a_viewer_of_napari_shows_the_scan_where_it_lies(scan):
    components = pytest.importorskip("napari.components")
    from octavo.napari import layer_of
    levels, attributes, _ = layer_of(scan)
    viewer = components.ViewerModel()
    layer = viewer.add_image(levels, **attributes)
    at = (scan.affine @ [5, 6, 7, 1])[2::-1]
    assert layer.multiscale
    assert np.allclose(layer.world_to_data(at), (5, 6, 7))


def test_a_slider_of_notebooks_shows_the_slices(scan):
    pytest.importorskip("ipywidgets")
    from octavo._notebook import png_of
    mask = scan.threshold(0)
    slider, picture = octavo.viewer(scan, overlays=mask).children
    assert (slider.min, slider.max, slider.value) == (0, 39, 20)
    for index in (3, 39):
        slider.value = index
        assert bytes(picture.value) == png_of(scan.slice("z", index, overlays=mask))
    assert octavo.viewer(mask, axis="x").children[0].max == 89
