"""OME-Zarr: keys without zarr, stores and images with what reads them, where it is installed."""

import json
import os
import subprocess
import sys
import zipfile
import zlib

import numpy as np
import pytest

import octavo
from octavo._zarr import ZarrFiles

DIRECTION = np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, -1.0]])


def world_of(dataset, index):
    """Where a voxel lies by the transforms of a dataset, z, y, x."""
    scale, translation = dataset["coordinateTransformations"]
    return np.array(index) * scale["scale"] + translation["translation"]


def test_keys_give_the_texts_and_bricks_of_all_levels(volume, voxels):
    files = ZarrFiles(volume)
    group = json.loads(files.get("zarr.json"))
    image = group["attributes"]["ome"]["multiscales"][0]
    assert len(image["datasets"]) == len(volume.levels)
    assert [axis["name"] for axis in image["axes"]] == ["z", "y", "x"]
    for view in volume.levels:
        array = json.loads(files.get(f"{view.level}/zarr.json"))
        assert tuple(array["shape"]) == view.shape and array["data_type"] == view.dtype.name
        chunk = np.frombuffer(files.get(f"{view.level}/c/0/0/0"), view.dtype).reshape(64, 64, 64)
        part = tuple(min(64, n) for n in view.shape)
        assert np.array_equal(chunk[:part[0], :part[1], :part[2]], view[:64, :64, :64])
        at = world_of(image["datasets"][view.level], (0, 0, 0))
        assert np.allclose(at, view.origin)
    last = np.frombuffer(files.get("0/c/2/1/2"), volume.dtype).reshape(64, 64, 64)
    assert np.array_equal(last[:2, :33, :22], voxels[128:, 64:, 128:])
    for key in ("0/c/3/0/0", "99/zarr.json", "99/c/0/0/0", "0/c/0/0", "other", "0/c/-1/0/0",
                "00/zarr.json", "\u00b2/zarr.json", "00/c/0/0/0", "0/c/00/0/0", "0/c/\u0661/0/0"):
        assert files.get(key) is None


@pytest.mark.filterwarnings("ignore:.*OME-Zarr has no slope")
@pytest.mark.parametrize("compression", ["none", "zstd", "blosc"])
def test_the_program_and_the_package_write_the_same(run, volume, tmp_path, compression):
    mine, theirs = tmp_path / "image.ome.zarr", tmp_path / "theirs" / "image.ome.zarr"
    theirs.parent.mkdir()
    made = octavo.export(volume, mine, compression=compression)
    done = run("export", volume.name, "-o", theirs, "--compression", compression)
    assert done.returncode == 0, done.stderr
    files = sorted(path.relative_to(mine) for path in mine.rglob("*") if path.is_file())
    assert files == sorted(p.relative_to(theirs) for p in theirs.rglob("*") if p.is_file())
    assert made["files"] == len(files) and made["levels"] == len(volume.levels)
    for file in files:
        assert (mine / file).read_bytes() == (theirs / file).read_bytes()
    with pytest.raises(octavo.StorageError, match="already exists"):
        octavo.export(volume, mine)


def test_shards_hold_what_their_index_says(volume, voxels, tmp_path):
    with pytest.warns(UserWarning):
        octavo.export(volume, tmp_path / "i.ome.zarr", compression="none", shard_chunks=2)
    shard = (tmp_path / "i.ome.zarr/0/c/0/0/1").read_bytes()
    index = np.frombuffer(shard[-4 - 8 * 16:-4], "<u8").reshape(2, 2, 2, 2)
    held = {}
    for z, y, x in np.ndindex(2, 2, 2):
        offset, length = map(int, index[z, y, x])
        if offset == 2 ** 64 - 1:
            continue
        voxels_of = np.frombuffer(shard[offset:offset + length - 4], "<i2")  # without its CRC-32C
        held[z, y, x] = voxels_of.reshape(64, 64, 64)
    # Two chunks along z and y, and the last 22 voxels along x.
    assert set(held) == {(z, y, 0) for z in (0, 1) for y in (0, 1)}
    assert np.array_equal(held[1, 1, 0][:, :33, :22], voxels[64:128, 64:, 128:])


def test_a_zip_file_has_its_texts_first_and_is_whole(run, volume, tmp_path):
    path = tmp_path / "image.ozx"
    assert run("export", volume.name, "-o", path).returncode == 0
    with zipfile.ZipFile(path) as archive:
        assert archive.testzip() is None
        names = archive.namelist()
        texts = [name for name in names if name.endswith("zarr.json")]
        assert names[0] == "zarr.json" and names[:len(texts)] == texts
        assert json.loads(archive.comment)["ome"]["version"] == "0.5"
        assert all(entry.compress_type == zipfile.ZIP_STORED for entry in archive.infolist())
        first = archive.infolist()[0]
        assert first.CRC == zlib.crc32(archive.read(first))


def test_replacing_takes_images_alone(run, volume, tmp_path):
    image, other = tmp_path / "image.zarr", tmp_path / "other.zarr"
    assert run("export", volume.name, "-o", image, "--level", 2).returncode == 0
    assert run("export", volume.name, "-o", image, "--level", 3, "--force").returncode == 0
    levels = [path for path in image.iterdir() if path.is_dir()]
    assert len(levels) == len(volume.levels) - 3
    other.mkdir()
    (other / "precious").write_text("kept")
    done = run("export", volume.name, "-o", other, "--force")
    assert done.returncode == 5 and "no zarr hierarchy" in done.stderr
    assert (other / "precious").read_text() == "kept"
    assert [path.name for path in tmp_path.iterdir() if path.name.startswith(".")] == []


@pytest.mark.parametrize("words", [("--box", "0:4,0:4,0:4"), ("--real",), ("--level", "99")])
def test_what_images_do_not_have_is_rejected(run, volume, tmp_path, words):
    done = run("export", volume.name, "-o", tmp_path / "image.ome.zarr", *words)
    assert done.returncode == 2, done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.fixture(scope="module")
def oblique(tmp_path_factory):
    random = np.random.default_rng(5)
    voxels = random.integers(-300, 300, (70, 40, 90)).cumsum(2).astype(np.int16)
    path = tmp_path_factory.mktemp("oblique") / "oblique.8vo"
    octavo.build(voxels, path, spacing=(3, 0.7, 0.5), origin=(-9, 40, 11.5), direction=DIRECTION,
                 unit="HU", slope=0.5, intercept=-10).close()
    return str(path)


@pytest.fixture
def zarr3():
    zarr = pytest.importorskip("zarr", minversion="3")
    return zarr


@pytest.mark.filterwarnings("ignore:.*OME-Zarr has no slope")
@pytest.mark.parametrize("name", ["image.ome.zarr", "image.ozx"])
@pytest.mark.parametrize("compression", ["none", "zstd", "blosc"])
def test_zarr_reads_images_and_they_come_back(zarr3, oblique, tmp_path, name, compression):
    volume = octavo.open(oblique)
    octavo.export(volume, tmp_path / name, compression=compression)
    store = str(tmp_path / name)
    if name.endswith(".ozx"):
        store = zarr3.storage.ZipStore(store, mode="r")
    group = zarr3.open_group(store, mode="r")
    for view in volume.levels:
        assert np.array_equal(group[str(view.level)][...], view[...])
    back = octavo.from_ome_zarr(tmp_path / name, tmp_path / "back.8vo")
    assert back.voxels_sha256 == volume.voxels_sha256
    assert back.unit == volume.unit and back.slope == volume.slope
    assert back.intercept == volume.intercept
    assert np.allclose(back.affine, volume.affine, rtol=0, atol=1e-9)


@pytest.fixture
def plain(voxels, tmp_path):
    return octavo.build(voxels, tmp_path / "plain.8vo", spacing=(2, 0.5, 0.25))


def damaged(image):
    """Leaves one bit after another of the chunks in a shard flipped; gives the shard's name."""
    shard = image / "0" / "c" / "0" / "0" / "0"
    whole = shard.read_bytes()
    chunks = len(whole) - 4 - 16 * 3 * 2 * 3
    for at in np.random.default_rng(7).integers(0, chunks, 24):
        bytes_ = bytearray(whole)
        bytes_[at] ^= 1 << int(at % 8)
        shard.write_bytes(bytes_)
        yield str(shard)


@pytest.mark.parametrize("compression", ["none", "zstd", "blosc"])
def test_a_flipped_bit_of_a_chunk_is_rejected(plain, tmp_path, compression):
    octavo.export(plain, tmp_path / "i.ome.zarr", compression=compression)
    for shard in damaged(tmp_path / "i.ome.zarr"):
        with pytest.raises(octavo.SourceError, match=r"chunk ././. of the shard") as found:
            octavo.build(tmp_path / "i.ome.zarr", tmp_path / "back.8vo", overwrite=True)
        assert found.value.path == shard


@pytest.mark.parametrize("compression", ["none", "zstd", "blosc"])
def test_zarr_and_tensorstore_reject_a_flipped_bit(zarr3, plain, tmp_path, compression):
    tensorstore = pytest.importorskip("tensorstore")
    octavo.export(plain, tmp_path / "i.ome.zarr", compression=compression)
    array = str(tmp_path / "i.ome.zarr" / "0")
    for _ in damaged(tmp_path / "i.ome.zarr"):
        with pytest.raises((ValueError, RuntimeError)):
            zarr3.open_array(array, mode="r")[...]
        with pytest.raises(ValueError):
            tensorstore.open({"driver": "zarr3", "kvstore": {"driver": "file", "path": array}}
                             ).result().read().result()


@pytest.mark.filterwarnings("error::UserWarning")
def test_a_chunk_that_is_missing_of_an_export_is_told(run, plain, tmp_path):
    image, back = tmp_path / "i.ome.zarr", tmp_path / "back.8vo"
    octavo.export(plain, image, shard_chunks=1)
    assert octavo.build(image, back).voxels_sha256 == plain.voxels_sha256
    octavo.build(image, back, max_error=3, overwrite=True)
    (image / "1" / "c" / "0" / "0" / "0").unlink()
    octavo.build(image, back, overwrite=True)
    (image / "0" / "c" / "1" / "0" / "1").unlink()
    with pytest.warns(UserWarning, match="its voxels are not those that were exported"):
        octavo.build(image, back, overwrite=True)
    done = run("build", image, "-o", back, "-f", "-q")
    assert done.returncode == 0 and "are not those that were exported" in done.stderr


@pytest.mark.filterwarnings("error::UserWarning")
def test_a_chunk_that_is_missing_of_a_group_of_zarr_is_told(zarr3, plain, tmp_path):
    octavo.export(plain, tmp_path / "i.ome.zarr", shard_chunks=1)
    for left_out in None, "0/c/1/0/1":
        with zipfile.ZipFile(tmp_path / "i.zip", "w") as archive:
            for file in sorted((tmp_path / "i.ome.zarr").rglob("*")):
                key = file.relative_to(tmp_path / "i.ome.zarr").as_posix()
                if file.is_file() and key != left_out:
                    archive.write(file, key)
        group = zarr3.open_group(zarr3.storage.ZipStore(tmp_path / "i.zip", mode="r"), mode="r")
        if not left_out:
            back = octavo.from_ome_zarr(group, tmp_path / "back.8vo")
            assert back.voxels_sha256 == plain.voxels_sha256
            continue
        with pytest.warns(UserWarning, match="are not those that were exported"):
            octavo.from_ome_zarr(group, tmp_path / "back.8vo", overwrite=True)


@pytest.mark.filterwarnings("error::UserWarning")
def test_values_that_were_replaced_by_0_are_no_damage(zarr3, tmp_path):
    voxels = np.ones((20, 20, 20), np.float32)
    voxels[1, 2, 3], voxels[4, 5, 6] = np.nan, np.inf
    octavo.export(octavo.build(voxels, tmp_path / "a.8vo", spacing=(1, 1, 1)), tmp_path / "a.ozx")
    group = zarr3.open_group(zarr3.storage.ZipStore(tmp_path / "a.ozx", mode="r"), mode="r")
    for given in {"nan": 0}, {"inf": 0.0}, {"nan": 0, "inf": 0, "max_error": 0.5}:
        made = octavo.from_ome_zarr(group, tmp_path / "b.8vo", overwrite=True, **given)
        assert made[1, 2, 3] == 0 or made[4, 5, 6] == 0


@pytest.mark.filterwarnings("ignore:.*OME-Zarr has no slope")
def test_a_landmark_stays_where_it_is_on_three_levels(zarr3, volume, tmp_path):
    octavo.export(volume, tmp_path / "image.ome.zarr")
    group = zarr3.open_group(str(tmp_path / "image.ome.zarr"), mode="r")
    datasets = group.attrs["ome"]["multiscales"][0]["datasets"]
    landmark = np.array([90.25, 40.0, 33.0])
    for view in volume.levels[:3]:
        scale, translation = (np.array(one[one["type"]]) for one in
                              datasets[view.level]["coordinateTransformations"])
        at = (landmark - translation) / scale
        world = view.affine @ [*at, 1]
        assert np.abs((world[2::-1] - landmark) / volume.spacing).max() < 0.01


def test_zarr_reads_a_volume_as_a_store(zarr3, volume, voxels):
    group = zarr3.open_group(octavo.as_zarr(volume), mode="r")
    assert np.array_equal(group["0"][50:90, 10:90:3, -7], voxels[50:90, 10:90:3, -7])
    for view in volume.levels:
        assert np.array_equal(group[str(view.level)][...], view[...])
    assert sorted(group.array_keys(), key=int) == [str(v.level) for v in volume.levels]


@pytest.mark.filterwarnings("ignore:.*OME-Zarr has no slope")
def test_ome_zarr_models_accept_both(zarr3, volume, tmp_path):
    image = pytest.importorskip("ome_zarr_models.v05").Image
    octavo.export(volume, tmp_path / "image.ome.zarr")
    for store in (octavo.as_zarr(volume), str(tmp_path / "image.ome.zarr")):
        model = image.from_zarr(zarr3.open_group(store, mode="r"))
        assert len(model.ome_attributes.multiscales[0].datasets) == len(volume.levels)


@pytest.mark.filterwarnings("ignore:.*OME-Zarr has no slope")
@pytest.mark.parametrize("compression", ["none", "zstd", "blosc"])
def test_tensorstore_reads_every_level(oblique, tmp_path, compression):
    tensorstore = pytest.importorskip("tensorstore")
    volume = octavo.open(oblique)
    octavo.export(volume, tmp_path / "image.ome.zarr", compression=compression)
    for view in volume.levels:
        array = tensorstore.open({"driver": "zarr3", "kvstore": {
            "driver": "file", "path": str(tmp_path / "image.ome.zarr" / str(view.level))}}).result()
        assert np.array_equal(array.read().result(), view[...])


def test_labels_go_there_and_back(zarr3, tmp_path):
    labels = np.zeros((30, 20, 70), np.uint8)
    labels[3:9, 4:9, 5:60], labels[20:25] = 3, 9
    volume = octavo.build(labels, tmp_path / "l.8vo", kind="labels", spacing=(1, 2, 3),
                          label_names={3: "liver", 9: "spleen"})
    octavo.export(volume, tmp_path / "l.ome.zarr")
    group = zarr3.open_group(str(tmp_path / "l.ome.zarr"), mode="r")
    assert {p["label-value"]: p["name"] for p in
            group.attrs["ome"]["image-label"]["properties"]} == {3: "liver", 9: "spleen"}
    with pytest.raises(octavo.ArgumentError, match="channel 7 is not there"):
        octavo.from_ome_zarr(tmp_path / "l.ome.zarr", tmp_path / "back.8vo", channel=7)
    back = octavo.from_ome_zarr(tmp_path / "l.ome.zarr", tmp_path / "back.8vo")
    assert back.kind == "labels" and back.label_names == volume.label_names
    assert back.voxels_sha256 == volume.voxels_sha256


def test_labels_may_have_a_color_alone(zarr3, run, tmp_path):
    octavo.build(np.full((3, 4, 5), 3, np.uint8), tmp_path / "l.8vo", kind="labels").close()
    (tmp_path / "names.txt").write_text('3 255 0 0 1 1 1 "liver"\n9 1 2 3 1 1 1 ""\n')
    done = run("build", tmp_path / "l.8vo", "--label-names", tmp_path / "names.txt", "-o",
               tmp_path / "named.8vo")
    assert done.returncode == 0, done.stderr
    group = zarr3.open_group(octavo.as_zarr(octavo.open(tmp_path / "named.8vo")), mode="r")
    assert octavo.from_ome_zarr(group, tmp_path / "back.8vo").label_names == {3: "liver"}


def test_channels_and_times_are_chosen(zarr3, tmp_path):
    group = zarr3.open_group(str(tmp_path / "five.zarr"), mode="w", zarr_format=3)
    voxels = np.random.default_rng(1).integers(0, 900, (2, 3, 8, 9, 10)).astype("u2")
    group.create_array("s0", data=voxels)
    group.attrs["ome"] = {"version": "0.5", "multiscales": [{
        "axes": [{"name": n, "type": "space", "unit": "micrometer"} if n in "zyx" else {"name": n}
                 for n in "tczyx"],
        "datasets": [{"path": "s0", "coordinateTransformations": [
            {"type": "scale", "scale": [1, 1, 4, 2, 1]}]}]}]}
    with pytest.raises(octavo.SourceError, match="3 channels and 2"):
        octavo.from_ome_zarr(tmp_path / "five.zarr", tmp_path / "x.8vo")
    made = octavo.from_ome_zarr(tmp_path / "five.zarr", tmp_path / "x.8vo", time=1, channel=2)
    assert np.array_equal(made[...], voxels[1, 2])
    assert made.spacing == pytest.approx((0.004, 0.002, 0.001))


@pytest.fixture
def in_memory(zarr3):
    """A group that no path leads to: two channels with labels, axes in micrometers."""
    group = zarr3.create_group(zarr3.storage.MemoryStore())
    voxels = np.random.default_rng(1).integers(0, 900, (2, 8, 9, 10)).astype("u2")
    group.create_array("0", data=voxels)
    space = [{"name": name, "type": "space", "unit": "micrometer"} for name in "zyx"]
    scale = {"type": "scale", "scale": [1, 4, 2, 1]}
    group.attrs["ome"] = {
        "version": "0.5", "omero": {"channels": [{"label": "DAPI"}, {"label": "GFP"}]},
        "multiscales": [{"axes": [{"name": "c", "type": "channel"}, *space],
                         "datasets": [{"path": "0", "coordinateTransformations": [scale]}]}]}
    return group, voxels


def test_a_channel_is_chosen_by_its_label(in_memory, tmp_path):
    group, voxels = in_memory
    for channel, number in ("DAPI", 0), ("GFP", 1), ("1", 1), (0, 0):
        made = octavo.from_ome_zarr(group, tmp_path / "a.8vo", channel=channel, overwrite=True)
        assert np.array_equal(made[...], voxels[number])
    for channel, said in (("RFP", "channel RFP is not there: DAPI, GFP"), ("2", "0 to 1")):
        with pytest.raises(octavo.ArgumentError, match=said):
            octavo.from_ome_zarr(group, tmp_path / "b.8vo", channel=channel)
    assert not (tmp_path / "b.8vo").exists()


def placed(scale):
    return {"datasets": [{"path": "0", "coordinateTransformations": [{"type": "scale", **scale}]}]}


@pytest.mark.parametrize("changed", [
    {"axes": None}, {"axes": [{"type": "space"}] * 4}, {"datasets": None}, {"datasets": []},
    {"datasets": [{"path": "none"}]}, placed({"path": "x"}), placed({"scale": [1, 2]})])
def test_a_group_that_is_no_image_is_rejected(in_memory, tmp_path, changed):
    group, _ = in_memory
    said = group.attrs["ome"]
    image = {**said["multiscales"][0], **changed}
    image = {name: value for name, value in image.items() if value is not None}
    group.attrs["ome"] = {**said, "multiscales": [image]}
    with pytest.raises(octavo.ArgumentError):
        octavo.from_ome_zarr(group, tmp_path / "a.8vo", channel=1)


def test_all_files_of_a_store_are_listed(volume):
    files = ZarrFiles(volume)
    keys = list(files.keys())
    assert len(keys) == len(set(keys)) and all(files.get(key) is not None for key in keys)
    # 130 x 97 x 150 voxels in chunks of 64^3
    assert len([key for key in keys if key.startswith("0/c/")]) == 3 * 2 * 3
    for prefix in ("", "0/", "0/c/1", "1", "zarr", "99"):
        assert list(files.keys(prefix)) == [key for key in keys if key.startswith(prefix)]
    for folder in ("", "0", "0/c", "0/c/2/", "0/c/2/1", "99", "zarr.json", "00", "\u00b2",
                   "0/c/99", "0/c/02", "0/c/\u00b2", "0/c/2/2"):
        start = folder.strip("/") + "/" if folder else ""
        inside = {key[len(start):].partition("/")[0] for key in keys if key.startswith(start)}
        assert set(files.folder(folder)) == inside, folder


def test_dask_reads_levels(volume, voxels):
    pytest.importorskip("dask.array")
    array = octavo.as_dask(volume)
    assert array.shape == voxels.shape and array.dtype == voxels.dtype
    assert array.mean().compute() == pytest.approx(voxels.mean())
    assert np.array_equal(octavo.as_dask(volume, 1)[3:9, ::2].compute(),
                          volume.levels[1][3:9, ::2])
    real = octavo.as_dask(volume.real)
    assert real.dtype == np.float32 and np.array_equal(real[5].compute(), volume.real[5])


@pytest.mark.parametrize("module, why", [
    (None, ""),
    ("import numpy.old_compat", "No module named 'numpy.old_compat'"),
    ("try:\n    import old_toolz\nexcept ImportError as error:\n"
     "    raise ImportError('get what\\nis missing') from error", "No module named 'old_toolz'"),
    ("raise ImportError", "ImportError")], ids=("none", "old", "without-others", "wordless"))
def test_a_dask_that_cannot_be_imported_is_told_from_none(path, tmp_path, module, why):
    if module is None:
        hidden = "import sys; sys.modules['dask'] = None\n"
    else:
        hidden = f"import sys; sys.path.insert(0, {os.fspath(tmp_path)!r})\n"
        (tmp_path / "dask").mkdir()
        (tmp_path / "dask" / "__init__.py").touch()
        (tmp_path / "dask" / "array.py").write_text(module + "\n")
    code = (f"{hidden}import octavo\ntry:\n    octavo.as_dask(octavo.open({os.fspath(path)!r}))\n"
            "except octavo.ArgumentError as error:\n    print(error)\n")
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    told = f"; the one that is installed cannot be imported: {why}" if why else ""
    assert said.stdout == f"as_dask needs dask (pip install dask){told}\n"


def test_xarray_opens_files_by_its_engine(path, volume, voxels):
    xarray = pytest.importorskip("xarray", minversion="2023.1")
    from octavo.xarray import OctavoBackend
    with xarray.open_dataset(path, engine=OctavoBackend) as dataset:
        held = dataset["voxels"]
        assert held.dims == ("z", "y", "x") and held.shape == voxels.shape
        assert np.array_equal(held[3, ::5, 2:9].values, voxels[3, ::5, 2:9])
        at = held.sel(z=90, y=40, x=33, method="nearest")
        index = np.round((np.array([90, 40, 33]) - volume.origin) / volume.spacing).astype(int)
        assert at.values == voxels[tuple(index)]
    with xarray.open_dataset(path, engine=OctavoBackend, level=1, real=True) as dataset:
        assert np.array_equal(dataset["voxels"].values, volume.real.levels[1][...])


@pytest.mark.parametrize("direction", (None, [[0, 1, 0], [-1, 0, 0], [0, 0, 1]],
                                       np.diag([-1, -1, 1]), DIRECTION))
def test_an_array_of_xarray_stands_where_it_did_when_it_is_built_again(direction, tmp_path, voxels):
    xarray = pytest.importorskip("xarray", minversion="2023.1")
    from octavo.xarray import OctavoBackend
    first = octavo.build(voxels % 7, tmp_path / "a.8vo", kind="labels", spacing=(2, 0.5, 0.25),
                         origin=(30, 20, 10), direction=direction)
    for level in 0, 1:
        with xarray.open_dataset(first.name, engine=OctavoBackend, level=level) as dataset:
            held = dataset["voxels"]
            again = octavo.build(held, tmp_path / "b.8vo", overwrite=True)
            assert np.allclose(again.affine, first.levels[level].affine) and again.kind == "labels"
            cut = octavo.build(held[10:, ::2, 7:], tmp_path / "c.8vo", overwrite=True)
            step = np.diag((1, 2, 1, 1))
            step[:3, 3] = 10, 0, 7
            assert np.allclose(cut.affine, first.levels[level].affine @ step)
            assert octavo.build(held, tmp_path / "d.8vo", spacing=(1, 1, 1),
                                overwrite=True).spacing == (1, 1, 1)
    plain = octavo.build(voxels, tmp_path / "plain.8vo")
    with xarray.open_dataset(plain.name, engine=OctavoBackend) as dataset:
        again = octavo.build(dataset["voxels"], tmp_path / "b.8vo", overwrite=True)
        assert not again._file.facts["is_spacing_known"]


def test_coordinates_of_xarray_are_those_of_the_world(tmp_path, voxels, oblique):
    xarray = pytest.importorskip("xarray", minversion="2023.1")
    from octavo.xarray import OctavoBackend
    scan = octavo.build(voxels, tmp_path / "ras.8vo", spacing=(2, 0.5, 0.25), origin=(30, 20, 10),
                        direction=np.diag([-1, -1, 1]))
    for level in 0, 1:
        with xarray.open_dataset(scan.name, engine=OctavoBackend, level=level) as dataset:
            held = dataset["voxels"]
            assert held.attrs["coordinate_system"] == "world LPS mm"
            z, y, x = (dataset[axis].values for axis in "zyx")
            assert z[1] > z[0] and y[1] < y[0] and x[1] < x[0]
            world = (scan.levels[level].affine @ [5, 6, 7, 1])[:3]
            assert np.allclose([x[7], y[6], z[5]], world)
            near = held.sel(z=world[2], y=world[1], x=world[0], method="nearest")
            assert near.values == scan.levels[level][5, 6, 7]
    with xarray.open_dataset(oblique, engine=OctavoBackend) as dataset:
        assert dataset["voxels"].attrs["coordinate_system"].startswith("mm along the axes")
        assert [float(dataset[axis][0]) for axis in "zyx"] == [0, 0, 0]
    plain = octavo.build(voxels, tmp_path / "plain.8vo", origin=(9, 8, 7),
                         direction=np.diag([-1, -1, 1]))
    for level, first in (0, 0), (1, 0.5):
        with xarray.open_dataset(plain.name, engine=OctavoBackend, level=level) as dataset:
            assert dataset["voxels"].attrs["coordinate_system"] == "voxels of level 0"
            for axis in "zyx":
                assert dataset[axis].values[:2].tolist() == [first, first + 2 ** level]
                assert "units" not in dataset[axis].attrs


def test_real_values_of_labels_are_built_as_grey_ones(tmp_path, voxels):
    xarray = pytest.importorskip("xarray", minversion="2023.1")
    from octavo.xarray import OctavoBackend
    octavo.build((voxels % 7).astype(np.uint8), tmp_path / "a.8vo", kind="labels").close()
    with xarray.open_dataset(tmp_path / "a.8vo", engine=OctavoBackend, real=True) as dataset:
        made = octavo.build(dataset["voxels"], tmp_path / "b.8vo")
    assert made.kind == "grey" and np.array_equal(made[...], voxels % 7)


def test_xarray_writes_netcdf_that_keeps_the_place(path, volume, tmp_path):
    xarray = pytest.importorskip("xarray", minversion="2023.1")
    pytest.importorskip("scipy")
    from octavo.xarray import OctavoBackend
    with xarray.open_dataset(path, engine=OctavoBackend, level=1) as dataset:
        dataset.to_netcdf(tmp_path / "scan.nc", engine="scipy")
    with xarray.open_dataset(tmp_path / "scan.nc", engine="scipy") as dataset:
        held = dataset["voxels"]
        assert held.attrs["slope"] == 2 and held.attrs["intercept"] == -1000
        assert np.array_equal(held.values, volume.levels[1][...])
        again = octavo.build(held, tmp_path / "again.8vo")
        assert np.allclose(again.affine, volume.levels[1].affine)


def test_xarray_may_be_told_what_other_formats_are_decoded_by(path, volume):
    xarray = pytest.importorskip("xarray", minversion="2023.1")
    from octavo.xarray import OctavoBackend
    with xarray.open_dataset(path, engine=OctavoBackend, mask_and_scale=False) as dataset:
        assert np.array_equal(dataset["voxels"][3].values, volume[3])
    with pytest.raises(TypeError, match="no option lavel"):
        xarray.open_dataset(path, engine=OctavoBackend, lavel=2)


@pytest.fixture
def served(path):
    """The address at which the program gives out the volume as zarr."""
    process = subprocess.Popen([os.environ["OCTAVO"], "serve", path, "--as", "zarr3", "--json"],
                               stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    with process:
        text = ""
        while not text.rstrip().endswith("}"):
            line = process.stdout.readline()
            assert line, text
            text += line
        yield json.loads(text)["zarr3"][0]
        process.terminate()


def test_zarr_reads_what_the_program_serves(zarr3, served, volume):
    pytest.importorskip("fsspec")
    pytest.importorskip("aiohttp")
    group = zarr3.open_group(served, mode="r")
    for view in volume.levels:
        assert np.array_equal(group[str(view.level)][...], view[...])


def test_tensorstore_reads_what_the_program_serves(served, volume):
    tensorstore = pytest.importorskip("tensorstore")
    for view in volume.levels:
        array = tensorstore.open({"driver": "zarr3", "kvstore": f"{served}{view.level}/"}).result()
        assert np.array_equal(array.read().result(), view[...])
