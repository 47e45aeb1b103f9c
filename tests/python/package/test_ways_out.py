"""What a file keeps of the identity of its source: no way out of Python has any of it."""

import pickle
import zipfile

import numpy as np
import pytest

import octavo
from octavo._zarr import ZarrFiles

SECRET = b"Zaphod"


@pytest.fixture(name="kept")
def file_that_keeps_identity(run, tmp_path):
    head = (f"NRRD0004\n# {SECRET.decode()}\ntype: uchar\ndimension: 3\nsizes: 9 8 7\n"
            f"encoding: raw\nspacings: 1 1 2\ncontent: {SECRET.decode()}\n"
            f"PatientName:={SECRET.decode()}\n\n")
    scan = tmp_path / f"{SECRET.decode()}.nrrd"
    scan.write_bytes(head.encode() + bytes(range(252)) * 2)
    path = tmp_path / "kept.8vo"
    done = run("build", scan, "--keep-identity", "-o", path)
    assert done.returncode == 0, done.stderr
    assert SECRET in path.read_bytes()
    with octavo.open(path) as volume:
        yield volume


def assert_none_in(folder):
    """Of all files, and of what is in zip files."""
    for path in folder.rglob("*"):
        if not path.is_file():
            continue
        assert SECRET not in path.read_bytes(), path
        if zipfile.is_zipfile(path):
            with zipfile.ZipFile(path) as archive:
                assert not any(SECRET in archive.read(name) for name in archive.namelist()), path


def test_no_written_file_holds_it(kept, tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    octavo.export(kept, out / "a.ome.zarr")
    octavo.export(kept, out / "b.ozx", compression="none")
    octavo.export(kept, out / "c.zarr", level=1)
    octavo.build(kept, out / "d.8vo").close()
    octavo.build(kept.levels[1], out / "e.8vo").close()
    octavo.build(kept, out / "f.8vo", max_error=2).close()
    octavo.from_ome_zarr(out / "a.ome.zarr", out / "g.8vo").close()
    mask = kept.threshold(100, 200)
    mask.save(out / "h.8vo").close()
    mask.dilate(2).save(out / "i.8vo").close()
    kept.transform(out / "j.8vo", rotate=("z", 90)).close()
    kept.condense(out / "k.8vo", flat=1).close()
    mask.save_surface(out / "l.vtp")
    (out / "m").write_bytes(pickle.dumps(mask))
    assert_none_in(out)


def test_no_face_of_a_volume_shows_it(kept):
    files = ZarrFiles(kept)
    keys = list(files.keys())
    assert "zarr.json" in keys
    assert not any(SECRET in files.get(key) for key in keys)
    assert b"voxels_sha256" in files.get("zarr.json")
    assert SECRET.decode() not in repr(kept)


def test_arrays_of_xarray_do_not_show_it(kept, tmp_path):
    xarray = pytest.importorskip("xarray")
    from octavo.xarray import OctavoBackend  # pylint: disable=import-outside-toplevel
    with xarray.open_dataset(kept.name, engine=OctavoBackend) as dataset:
        assert SECRET.decode() not in str(dataset.to_dict())
        (tmp_path / "out").mkdir()
        pytest.importorskip("scipy")
        assert dataset["voxels"].astype(np.int16).attrs["kind"] == "grey"
        dataset.astype(np.int16).to_netcdf(tmp_path / "out" / "a.nc", engine="scipy")
    assert_none_in(tmp_path / "out")


def test_layers_of_napari_do_not_show_it(kept):
    pytest.importorskip("dask")
    from octavo import napari  # pylint: disable=import-outside-toplevel
    arrays, attributes, _ = napari.layer_of(kept)
    assert SECRET.decode() not in str(attributes) + str(arrays)


def test_images_of_simpleitk_do_not_show_it(kept, tmp_path):
    pytest.importorskip("SimpleITK")
    from octavo import sitk  # pylint: disable=import-outside-toplevel
    image = sitk.to_sitk(kept)
    assert not any(SECRET.decode() in image.GetMetaData(key) for key in image.GetMetaDataKeys())
