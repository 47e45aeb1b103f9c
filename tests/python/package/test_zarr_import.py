"""Images and arrays of zarr into files, without zarr; test_zarr.py has those that zarr wrote."""

import json

import numpy as np
import pytest

import octavo


@pytest.fixture
def image(volume, tmp_path):
    with pytest.warns(UserWarning, match="no slope") as caught:
        octavo.export(volume, tmp_path / "image.ome.zarr")
    assert {one.filename for one in caught} == {__file__}
    return tmp_path / "image.ome.zarr"


def plain(folder, voxels, chunks, axes=None, version=2):
    """An array of zarr 2, chunks as they are; an image with `axes`."""
    array = folder / "0" if axes else folder
    array.mkdir(parents=True)
    (array / ".zarray").write_text(json.dumps(dict(
        zarr_format=version, shape=voxels.shape, chunks=chunks, dtype=voxels.dtype.str, order="C",
        fill_value=0, filters=None, compressor=None)))
    for place in np.ndindex(*(-(-n // c) for n, c in zip(voxels.shape, chunks))):
        chunk = np.zeros(chunks, voxels.dtype)
        part = voxels[tuple(slice(p * c, p * c + c) for p, c in zip(place, chunks))]
        chunk[tuple(map(slice, part.shape))] = part
        (array / ".".join(map(str, place))).write_bytes(chunk.tobytes())
    if axes:
        (folder / ".zattrs").write_text(json.dumps({"multiscales": [{
            "axes": [{"name": n, "unit": "micrometer"} if n in "zyx" else {"name": n}
                     for n in axes],
            "datasets": [{"path": "0", "coordinateTransformations": [
                {"type": "scale", "scale": [1] * (len(axes) - 3) + [4, 2, 1]}]}]}]}))
        (folder / ".zgroup").write_text('{"zarr_format": 2}')


def test_the_program_and_the_package_read_the_same(run, volume, image, tmp_path):
    made = octavo.build(image, tmp_path / "a.8vo")
    done = run("build", image, "-o", tmp_path / "b.8vo")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "a.8vo").read_bytes() == (tmp_path / "b.8vo").read_bytes()
    assert made.voxels_sha256 == volume.voxels_sha256
    assert made.unit == volume.unit and made.slope == volume.slope
    assert np.array_equal(made.affine, volume.affine)


@pytest.mark.parametrize("compression", ["none", "zstd", "blosc"])
@pytest.mark.parametrize("name", ["image.ome.zarr", "image.ozx"])
def test_what_was_exported_comes_back(run, volume, tmp_path, name, compression):
    done = run("export", volume.name, "-o", tmp_path / name, "--compression", compression)
    assert done.returncode == 0, done.stderr
    back = octavo.build(tmp_path / name, tmp_path / "back.8vo")
    assert back.voxels_sha256 == volume.voxels_sha256
    assert [view.shape for view in back.levels] == [view.shape for view in volume.levels]


def test_a_level_keeps_its_place(volume, image, tmp_path):
    for level, made in ((2, octavo.from_ome_zarr(image, tmp_path / "a.8vo", level=2)),
                        (1, octavo.build(image / "1", tmp_path / "b.8vo"))):
        view = volume.levels[level]
        assert np.array_equal(made[...], view[...])
        assert np.allclose(made.affine, view.affine, rtol=0, atol=1e-9)


def test_channels_and_times_are_chosen(run, tmp_path):
    voxels = np.random.default_rng(1).integers(0, 900, (2, 3, 8, 9, 10)).astype(">u2")
    plain(tmp_path / "five.zarr", voxels, (1, 2, 3, 4, 10), "tczyx")
    made = octavo.build(tmp_path / "five.zarr", tmp_path / "x.8vo", channel=2, time=1)
    assert np.array_equal(made[...], voxels[1, 2])
    assert made.spacing == pytest.approx((0.004, 0.002, 0.001))
    with pytest.raises(octavo.SourceError) as raised:
        octavo.build(tmp_path / "five.zarr", tmp_path / "y.8vo", channel=2)
    done = run("build", tmp_path / "five.zarr", "--channel", 2, "-o", tmp_path / "y.8vo")
    assert done.returncode == 7 and raised.value.detail in done.stderr
    with pytest.raises(octavo.ArgumentError, match="channel 7 is not there"):
        octavo.build(tmp_path / "five.zarr", tmp_path / "y.8vo", channel=7, time=0)
    assert not (tmp_path / "y.8vo").exists()


def test_arrays_that_are_no_image_have_no_spacing(tmp_path):
    voxels = np.arange(5 * 6 * 7, dtype=np.int16).reshape(5, 6, 7)
    plain(tmp_path / "plain.zarr", voxels, (2, 4, 5))
    with pytest.warns(UserWarning, match="spacing") as caught:
        made = octavo.build(tmp_path / "plain.zarr", tmp_path / "x.8vo")
        octavo.from_ome_zarr(tmp_path / "plain.zarr", tmp_path / "z.8vo")
    assert {one.filename for one in caught} == {__file__}
    assert np.array_equal(made[...], voxels) and not made.is_spacing_known
    given = octavo.build(tmp_path / "plain.zarr", tmp_path / "y.8vo", spacing=(3, 2, 1))
    assert given.spacing == (3, 2, 1)


def test_a_group_without_units_is_told_as_its_folder_is(tmp_path):
    zarr = pytest.importorskip("zarr", minversion="3")
    group = zarr.open_group(tmp_path / "a.zarr", mode="w")
    voxels = np.arange(5 * 6 * 7, dtype=np.int16).reshape(5, 6, 7)
    group.create_array("0", data=voxels)
    scale = {"type": "scale", "scale": [1, 2, 3]}
    group.attrs["ome"] = {"version": "0.5", "multiscales": [
        {"axes": [{"name": axis, "type": "space"} for axis in "zyx"],
         "datasets": [{"path": "0", "coordinateTransformations": [scale]}]}]}
    for source in (group, tmp_path / "a.zarr"):
        with pytest.warns(UserWarning, match="no unit of length"):
            made = octavo.from_ome_zarr(source, tmp_path / "x.8vo", overwrite=True)
        assert np.array_equal(made[...], voxels) and not made.is_spacing_known
        with pytest.warns(UserWarning, match="place are left out"):
            made = octavo.from_ome_zarr(source, tmp_path / "x.8vo", overwrite=True,
                                        spacing=(3, 2, 1))
        assert made.spacing == (3, 2, 1)


@pytest.mark.parametrize("dtype", ["bool", "int8", ">u2", "int64", "uint64", "float32", "float64"])
def test_a_group_of_a_folder_is_read_as_its_path_is(tmp_path, dtype):
    zarr = pytest.importorskip("zarr", minversion="3")
    group = zarr.open_group(tmp_path / "a.zarr", mode="w", zarr_format=3).create_group("inner")
    voxels = (np.arange(8 * 9 * 10).reshape(8, 9, 10) % 100).astype(dtype)
    group.create_array("0", shape=voxels.shape, chunks=(8, 8, 8), dtype=dtype)[...] = voxels
    group.attrs["ome"] = {"version": "0.5", "multiscales": [{
        "axes": [{"name": n, "type": "space", "unit": "millimeter"} for n in "zyx"],
        "datasets": [{"path": "0", "coordinateTransformations": [
            {"type": "scale", "scale": [1, 2, 3]}]}]}]}
    of_group = octavo.from_ome_zarr(group, tmp_path / "x.8vo")
    of_path = octavo.from_ome_zarr(tmp_path / "a.zarr/inner", tmp_path / "y.8vo")
    assert (of_group.dtype, of_group.kind) == (of_path.dtype, of_path.kind)
    assert of_group.spacing == of_path.spacing == (1, 2, 3)
    assert np.array_equal(of_group[...], voxels.astype(of_path.dtype))


@pytest.mark.parametrize("options", [dict(slope=2), dict(kind="other"), dict(level=40),
                                     dict(channel=3), dict(time=-1), dict(label_names={1: "a"})])
def test_options_that_do_not_fit_are_rejected(image, tmp_path, options):
    with pytest.raises(octavo.ArgumentError):
        octavo.from_ome_zarr(image, tmp_path / "x.8vo", **options)
    assert not (tmp_path / "x.8vo").exists()


def test_a_damaged_chunk_is_named_and_nothing_is_left(run, image, tmp_path):
    shard = image / "0" / "c" / "0" / "0" / "0"
    held = bytearray(shard.read_bytes())
    held[len(held) // 3] ^= 255
    held[40] ^= 255
    shard.write_bytes(held)
    with pytest.raises(octavo.SourceError) as raised:
        octavo.build(image, tmp_path / "x.8vo")
    assert "chunk" in str(raised.value) and "image.ome.zarr/0" in raised.value.path
    done = run("build", image, "-o", tmp_path / "x.8vo")
    assert done.returncode == 7 and raised.value.detail in done.stderr
    assert [p.name for p in tmp_path.iterdir()] == ["image.ome.zarr"]


def test_an_iterator_gives_planes(tmp_path):
    voxels = np.random.default_rng(2).integers(0, 99, (7, 8, 9)).astype(np.uint8)
    seen = []
    made = octavo.build((plane for plane in voxels), tmp_path / "i.8vo", shape=voxels.shape,
                        progress=lambda done, total, what: seen.append((done, total)))
    assert np.array_equal(made[...], voxels) and seen[-1] == (7, 7)
    for planes, shape in ((iter(voxels[:3]), voxels.shape), (iter(()), (1, 2, 3)),
                          (voxels, voxels.shape), (iter(voxels), (6, 8, 9))):
        with pytest.raises(octavo.ArgumentError):
            octavo.build(planes, tmp_path / "j.8vo", shape=shape)
        assert not (tmp_path / "j.8vo").exists()


def test_what_the_extension_cannot_take_is_an_error_of_octavo(tmp_path):
    with pytest.raises(octavo.ArgumentError, match="type"):
        octavo._octavo.build_zarr("in.zarr", str(tmp_path / "x.8vo"), dict(channel=3), {}, None)
