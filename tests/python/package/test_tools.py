"""Readers for other tools, each with the real package, where it is installed."""

import sys
import types

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


class SlicerOfTests(types.ModuleType):
    """What the reader calls of Slicer, which is in no package index: nodes are kept."""

    def __init__(self):
        super().__init__("slicer")
        self.nodes, self.said = [], []
        self.util = types.SimpleNamespace(addVolumeFromArray=self.add,
                                          errorDisplay=self.said.append)
        self.ScriptedLoadableModule = types.ModuleType("slicer.ScriptedLoadableModule")
        self.ScriptedLoadableModule.ScriptedLoadableModule = type("Base", (), {
            "__init__": lambda self, parent: None})

    def add(self, narray, ijkToRAS=None, name=None, nodeClassName=None):
        self.nodes.append((narray, ijkToRAS, name, nodeClassName))
        return types.SimpleNamespace(GetID=lambda: f"node{len(self.nodes)}")


@pytest.fixture
def slicer(monkeypatch):
    import octavo.slicer
    fake = SlicerOfTests()
    monkeypatch.setitem(sys.modules, "slicer", fake)
    monkeypatch.setitem(sys.modules, "slicer.ScriptedLoadableModule", fake.ScriptedLoadableModule)
    monkeypatch.syspath_prepend(octavo.slicer.module_folder())
    monkeypatch.delitem(sys.modules, "OctavoReader", raising=False)
    return fake


def test_the_reader_for_slicer_makes_nodes_of_voxels_at_their_places(scan, slicer, tmp_path):
    import OctavoReader
    module = OctavoReader.OctavoReader(types.SimpleNamespace())
    reader = OctavoReader.OctavoReaderFileReader(types.SimpleNamespace())
    assert module and reader.canLoadFile(scan.name) and not reader.canLoadFile("scan.nii")
    assert reader.load({"fileName": scan.name})
    assert reader.load({"fileName": scan.name, "nbytes": 60_000})
    assert reader.parent.loadedNodes == ["node2"]
    fine, coarse = slicer.nodes
    budget = scan.at_budget(60_000)
    assert fine[2:] == ("scan", "vtkMRMLScalarVolumeNode") and budget.level > 0
    assert coarse[2] == f"scan 1/{max(budget.factor)}"
    for (voxels, matrix, *_), view in ((fine, scan.levels[0]), (coarse, budget)):
        assert voxels.shape == view.shape and voxels.dtype == np.float32
        for i, j, k in ((0, 0, 0), (7, 11, 5)):
            i, j, k = (min(a, n - 1) for a, n in zip((i, j, k), view.shape[::-1]))
            assert voxels[k, j, i] == view[k, j, i] * scan.slope + scan.intercept
            x, y, z = (view.affine @ [k, j, i, 1])[:3]
            assert np.allclose(matrix @ [i, j, k, 1], [-x, -y, z, 1])
    labels = scan.threshold(-900).save(tmp_path / "labels.8vo")
    assert reader.load({"fileName": labels.name, "level": 0})
    assert slicer.nodes[2][0].dtype == np.uint8
    assert slicer.nodes[2][3] == "vtkMRMLLabelMapVolumeNode"
    (tmp_path / "none.8vo").write_bytes(b"nothing")
    assert not reader.load({"fileName": str(tmp_path / "none.8vo")})
    assert "none.8vo" in slicer.said[0] and len(slicer.nodes) == 3


def test_places_in_slicer_are_those_of_simpleitk(scan):
    pytest.importorskip("SimpleITK")
    import octavo.slicer
    from octavo.sitk import to_sitk
    for view in scan.levels[:3]:
        matrix = octavo.slicer.ijk_to_ras(view)
        image = to_sitk(view)
        for index in ((0, 0, 0), (3, 2, 1), tuple(n - 1 for n in view.shape[::-1])):
            lps = np.array(image.TransformIndexToPhysicalPoint(index))
            assert np.allclose((matrix @ [*index, 1])[:3], lps * (-1, -1, 1))


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


# Columns x, y, z of coronal, sagittal and oblique series.
PERMUTED = {
    "coronal": [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
    "sagittal": [[0, 0, -1], [1, 0, 0], [0, -1, 0]],
    "oblique": [[0, 0.6, 0.8], [0, 0.8, -0.6], [-1, 0, 0]],
}


@pytest.fixture(params=PERMUTED)
def permuted(request, tmp_path):
    random = np.random.default_rng(3)
    voxels = random.integers(-30, 31, (40, 50, 60)).cumsum(2).astype(np.int16)
    return octavo.build(voxels, tmp_path / "permuted.8vo", spacing=(3, 2, 1), origin=(-9, 40, 11.5),
                        direction=PERMUTED[request.param])


def test_layers_of_napari_have_the_axes_of_the_world(permuted):
    pytest.importorskip("dask.array")
    from octavo.napari import layer_of
    levels, attributes, _ = layer_of(permuted)
    affine = attributes["affine"]
    cosines = np.abs(affine[:3, :3] / np.linalg.norm(affine[:3, :3], axis=0))
    assert (np.diag(cosines) > 0.7).all()
    for view, level in zip(permuted.real.levels, levels):
        assert sorted(level.shape) == sorted(view.shape)
    for index in (0, 0, 0), (4, 5, 6), (39, 49, 59):
        world = (permuted.affine @ [*index, 1])[2::-1]
        there = np.linalg.solve(affine, [*world, 1])[:3].round().astype(int)
        assert levels[0][tuple(there)].compute() == permuted.real[index]


def test_a_slice_of_napari_is_one_of_the_world(permuted):
    components = pytest.importorskip("napari.components")
    from octavo.napari import layer_of
    levels, attributes, _ = layer_of(permuted)
    layer = components.ViewerModel().add_image(levels, **attributes)
    of_slice = layer._transforms.simplified.set_slice([1, 2]).affine_matrix
    assert abs(np.linalg.det(of_slice)) > 0.3


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
