"""OME-Zarr: a volume as a zarr store and as dask arrays, images written and read."""

import itertools
import os
import re

import numpy as np

from . import _octavo
from ._building import BUILD_OPTIONS, _given, _output, build, build_zarr, is_zarr
from ._errors import ArgumentError, Error, package_error
from ._sources import require_there, written_path
from ._tasks import FileTasks, opened_file
from ._volume import RealView, View, Volume
from ._work import warn_of, whole_number, work_of

_CHUNK = 64
_NUMBER = re.compile("0|[1-9][0-9]{0,18}")


class ZarrFiles:
    """The files of an OME-Zarr 0.5 image that a volume is, made when they are asked for.

    Arrays are those of the levels; a chunk is a brick of 64^3 voxels, uncompressed. Any number of
    threads may ask.
    """

    def __init__(self, volume):
        self._volume = volume
        self._name = os.path.basename(volume.name).partition(".")[0] or "octavo"

    @property
    def volume(self):
        """That the files are of."""
        return self._volume

    def keys(self, prefix=""):
        """The keys of all files that begin so, without making any."""
        yield from self._begun(["zarr.json"], prefix)
        for view in self._volume.levels:
            folder = f"{view.level}/"
            if not folder.startswith(prefix[:len(folder)]):
                continue
            yield from self._begun([folder + "zarr.json"], prefix)
            places = itertools.product(*map(range, _chunk_counts(view)))
            yield from self._begun((f"{folder}c/{z}/{y}/{x}" for z, y, x in places), prefix)

    def folder(self, path):
        """The names in a folder."""
        first, *rest = path.strip("/").split("/")
        if not first:
            return ["zarr.json", *(str(view.level) for view in self._volume.levels)]
        view = self._level_of(first)
        if view is None:
            return []
        if not rest:
            return ["zarr.json", "c"]
        if rest[0] != "c" or len(rest) > 3 or not _are_chunks(view, rest[1:]):
            return []
        return map(str, range(_chunk_counts(view)[len(rest) - 1]))

    @staticmethod
    def _begun(keys, prefix):
        return (key for key in keys if key.startswith(prefix))

    def get(self, key):
        """The bytes of a file; None where there is none."""
        if key == "zarr.json":
            return self._text(None)
        first, *rest = key.split("/")
        view = self._level_of(first)
        if view is None:
            return None
        if rest == ["zarr.json"]:
            return self._text(view.level)
        if len(rest) != 4 or rest[0] != "c" or not _are_chunks(view, rest[1:]):
            return None
        return self._chunk(view, map(int, rest[1:]))

    def _level_of(self, name):
        """The level whose folder has that name; None where none has."""
        return next((view for view in self._volume.levels if str(view.level) == name), None)

    def _text(self, level):
        return _octavo.zarr_text(self._volume._file._opened(), level, self._name).encode()

    @staticmethod
    def _chunk(view, place):
        start = [p * _CHUNK for p in place]
        stop = [min(a + _CHUNK, n) for a, n in zip(start, view.shape)]
        chunk = np.zeros((_CHUNK,) * 3, view.dtype)
        part = tuple(slice(0, b - a) for a, b in zip(start, stop))
        view.read((start, stop), out=chunk[part])
        return chunk.tobytes()


def _chunk_counts(view):
    return [-(-n // _CHUNK) for n in view.shape]


def _are_chunks(view, names):
    """Whether all are names of chunks along the first axes."""
    return all(_NUMBER.fullmatch(name) and int(name) < count
               for name, count in zip(names, _chunk_counts(view)))


def as_zarr(volume):
    """A volume as a read-only zarr v3 store with the metadata of OME-Zarr 0.5.

        group = zarr.open_group(octavo.as_zarr(v), mode="r")
        group["0"][40:60, :, 128]        # arrays "0", "1", ... are the levels

    Chunks are decoded when they are asked for.

    Parameters
    ----------
    volume : Volume or LabelMap
        Of a map the levels are made first, in a file in the folder for these.

    Returns
    -------
    zarr.abc.store.Store

    Raises
    ------
    octavo.ArgumentError
        Where zarr 3 is not installed.
    """
    import asyncio
    try:
        from zarr.abc.store import OffsetByteRequest, RangeByteRequest, Store, SuffixByteRequest
    except ImportError as error:
        raise package_error("zarr", "as_zarr needs zarr 3 (pip install zarr)", error) from None

    class OctavoStore(Store):
        """Files of an image, read only."""

        supports_writes = False
        supports_deletes = False
        supports_listing = True

        def __init__(self, files):
            super().__init__(read_only=True)
            self._files = files

        def __eq__(self, other):
            return isinstance(other, OctavoStore) and other._files.volume is self._files.volume

        def __reduce__(self):
            return as_zarr, (self._files.volume,)

        async def get(self, key, prototype, byte_range=None):
            """The bytes under a key, or a range of them; None where there are none."""
            held = await asyncio.to_thread(self._files.get, key)
            if held is None:
                return None
            if isinstance(byte_range, RangeByteRequest):
                held = held[byte_range.start:byte_range.end]
            elif isinstance(byte_range, OffsetByteRequest):
                held = held[byte_range.offset:]
            elif isinstance(byte_range, SuffixByteRequest):
                held = held[-byte_range.suffix:]
            return prototype.buffer.from_bytes(held)

        async def get_partial_values(self, prototype, key_ranges):
            """As get, of several."""
            return [await self.get(key, prototype, part) for key, part in key_ranges]

        async def exists(self, key):
            """Whether there is anything under a key."""
            return await asyncio.to_thread(self._files.get, key) is not None

        async def set(self, key, value):
            """Raises: files are not changed."""
            raise NotImplementedError("an .8vo file is read only")

        async def delete(self, key):
            """Raises: files are not changed."""
            raise NotImplementedError("an .8vo file is read only")

        async def list(self):
            """The keys of all files."""
            for key in self._files.keys():
                yield key

        async def list_prefix(self, prefix):
            """Those that begin so."""
            for key in self._files.keys(prefix):
                yield key

        async def list_dir(self, prefix):
            """What stands in a folder."""
            for name in self._files.folder(prefix):
                yield name

    volume = _with_levels(volume)
    return OctavoStore(ZarrFiles(volume))


def as_dask(volume, level=0, *, chunks=None):
    """A level as a dask array, decoded where it is computed.

    Parameters
    ----------
    volume : Volume, LabelMap, View or RealView
        A volume's or map's `level`; a view as it is.
    chunks : int or tuple, optional
        Those of the bricks where it is not given.

    Returns
    -------
    dask.array.Array
    """
    try:
        import dask.array
    except ImportError as error:
        raise package_error("dask", "as_dask needs dask (pip install dask)", error) from None
    if isinstance(volume, FileTasks):
        volume = _with_levels(volume)
        level = whole_number(level, "level", 0, len(volume.levels) - 1)
        view = volume.levels[level]
    elif isinstance(volume, (View, RealView)):
        view = volume
    else:
        raise ArgumentError(f"give a volume or a view of it, not {type(volume).__name__}")
    return dask.array.from_array(view, chunks=chunks or view.chunks, asarray=False, fancy=False,
                                 meta=np.empty((0, 0, 0), view.dtype))


def _with_levels(given):
    """A volume as it is; of a label map one that lives as long as it is used."""
    if isinstance(given, Volume):
        return given
    if not isinstance(given, FileTasks):
        raise ArgumentError("give an open volume, a label map or a mask, not "
                            f"{type(given).__name__}")
    volume = Volume(given.saved().name)
    volume.made_of = given  # whose end would remove the file
    return volume


def export(volume, path, *, level=0, compression="zstd", chunk_side=64, shard_chunks=4,
           overwrite=False, threads=0, max_memory=0, progress=None):
    """Write a volume with all its levels as an OME-Zarr 0.5 image of sharded zarr v3 arrays.

    Parameters
    ----------
    volume : Volume
    path : str or os.PathLike
        Ends in .ome.zarr or .zarr (a folder), or .ozx (one zip file).
    level : int
        The finest one that is written.
    compression : {"zstd", "blosc", "none"}
    chunk_side : int
        Voxels, 16 to 256.
    shard_chunks : int
        Chunks along each side of a file, 1 to 16.

    Returns
    -------
    dict
        levels, files, bytes.

    Raises
    ------
    octavo.ArgumentError, octavo.StorageError
    """
    path = written_path(path)
    if not path.rstrip("/").endswith((".zarr", ".ozx")):
        raise ArgumentError(f"{path}: the name of an OME-Zarr image ends in .ome.zarr or .ozx; "
                            "the program octavo writes other formats", path=path)
    name, handle = opened_file(volume, "volume")
    asked = dict(overwrite=bool(overwrite), level=whole_number(level, "level", 0, 63),
                 compression=compression, chunk_side=whole_number(chunk_side, "chunk_side", 0),
                 shard_chunks=whole_number(shard_chunks, "shard_chunks", 0))
    with work_of(threads, max_memory, progress) as work:
        levels, files, written = _octavo.export_zarr(handle, name, path, asked, work)
    return dict(levels=levels, files=files, bytes=written)


def from_ome_zarr(source, path, *, level=0, channel=None, time=None, **options):
    """Build an .8vo file of an OME-Zarr image, 0.4 or 0.5.

    Parameters
    ----------
    source : str, os.PathLike or zarr.Group
        A folder, an .ozx file, or a URL that zarr opens.
    path : str or os.PathLike
        Ends in .8vo.
    level : int
        Of the image: its resolution that becomes level 0.
    channel : int or str, optional
    time : int, optional
        What is taken where there are several; a channel also by its label.
    **options
        Of `octavo.build`; what is not given is what the image says: the spacing in mm, and all
        else of one that `export` wrote. Paths and groups of local folders are read as by the
        program; other groups and URLs through zarr 3, which has to be installed.

    Returns
    -------
    Volume

    Raises
    ------
    octavo.ArgumentError
        For what is no such image, axes that are missing, and channels or times to choose from.
    """
    if isinstance(source, (str, os.PathLike)) and is_zarr(os.fspath(source)):
        return _build_of_path(os.fspath(source), path, level, channel, time, options)
    if isinstance(source, (str, os.PathLike)):
        require_there(os.fspath(source))
    try:
        import zarr
    except ImportError as error:
        raise package_error("zarr", "from_ome_zarr needs zarr 3 for URLs (pip install zarr), and a "
                            "folder or an .ozx file otherwise", error) from None
    if isinstance(source, zarr.Group):
        folder = _folder_of(zarr, source)
        if folder and is_zarr(folder):
            return _build_of_path(folder, path, level, channel, time, options)
    group = source if isinstance(source, zarr.Group) else _opened_group(zarr, source)
    attributes = dict(group.attrs)
    try:
        chosen, facts = _volume_of(group, attributes, level, channel, time, source)
    except Error:
        raise
    except (LookupError, TypeError, ValueError, AttributeError) as error:
        raise ArgumentError(f"{source}: what it says is not that of an OME-Zarr image 0.4 or 0.5 "
                            f"({type(error).__name__}: {error})") from None
    facts.update(options)
    if "spacing" not in facts and "octavo" not in attributes:
        warn_of([f"{source}: its axes have no unit of length that is known here: its scale and "
                 "place are left out; 1 mm assumed"])
    made = build(chosen, path, **facts)
    is_replaced = options.get("nan") is not None or options.get("inf") is not None
    if level == 0 and not is_replaced \
            and not made.max_error and not made._file.facts["detail_level"]:
        _compare_with_export(attributes, made, source)
    return made


def _volume_of(group, attributes, level, channel, time, source):
    """The array that is built of an image, and what `build` is told of it."""
    said = attributes.get("ome", attributes)
    if not said.get("multiscales"):
        raise ArgumentError(f"{source}: is no OME-Zarr image: it has no multiscales")
    image = said["multiscales"][0]
    axes = [axis["name"] if isinstance(axis, dict) else axis for axis in image["axes"]]
    units = {axis["name"]: axis.get("unit") for axis in image["axes"] if isinstance(axis, dict)}
    datasets = image["datasets"]
    dataset = datasets[whole_number(level, "level", 0, len(datasets) - 1)]
    if isinstance(channel, str):
        channel = _numbered(channel, said.get("omero", {}).get("channels", ()), source)
    chosen = _Chosen(group[dataset["path"]], axes, {"c": channel, "t": time}, source)
    return chosen, {"kind": "grey",
                    **_facts_of_image(attributes, image, dataset, axes, units, level)}


def _numbered(channel, channels, source):
    """The number of a channel that is given as text: its label, or its number."""
    labels = [one.get("label") for one in channels]
    if channel in labels:
        return labels.index(channel)
    if channel.isdecimal():
        return int(channel)
    raise ArgumentError(f"{source}: channel {channel} is not there: "
                        f"{', '.join(map(str, labels)) or 'its channels have no labels'}")


def _compare_with_export(attributes, made, source):
    """Warns as `build` of a path does: of chunks that zarr does not miss."""
    own = attributes.get("octavo")
    exported = own.get("voxels_sha256") if isinstance(own, dict) else None
    if exported and exported != made.voxels_sha256:
        warn_of([f"{source}: its voxels are not those that were exported (voxels_sha256): chunks "
                 "were changed since, are missing, or are damaged"])


def _build_of_path(source, path, level, channel, time, options):
    progress = options.pop("progress", None)
    said = {name: options.pop(name, None) for name in
            ("kind", "spacing", "origin", "direction", "unit", "slope", "intercept",
             "label_names")}
    given = {name: options.pop(name, usual) for name, usual in BUILD_OPTIONS.items()}
    if options:
        raise TypeError(f"build has no option {next(iter(options))}")
    return build_zarr(source, _output(path), said, _given(**given), progress, level=level,
                      channel=channel, time=time)


_MM_PER = {"millimeter": 1.0, "micrometer": 1e-3, "nanometer": 1e-6, "angstrom": 1e-7,
           "centimeter": 10.0, "meter": 1e3, "picometer": 1e-9}


class _Chosen:
    """The volume [z, y, x] of one channel and time of an array."""

    def __init__(self, array, axes, asked, source):
        if len(axes) != array.ndim or not {"z", "y", "x"} <= set(axes):
            raise ArgumentError(f"{source}: its axes are {' '.join(axes)}; a volume has z, y and x")
        names = {"c": "channel", "t": "time"}
        for axis, number in asked.items():
            if number is not None and axis not in axes:
                raise ArgumentError(f"{source}: has no axis {axis}: leave out {names[axis]}")
        picks = []
        for axis, size in zip(axes, array.shape):
            if axis in "zyx":
                continue
            number = asked.get(axis)
            name = names.get(axis, axis)
            if number is None and size > 1:
                raise ArgumentError(f"{source}: has {size} of axis {axis}: give {name}=0 to "
                                    f"{size - 1}")
            picks.append(whole_number(number or 0, name, 0, size - 1))
        self._array = array
        self._axes = axes
        self._picks = picks
        order = [axis for axis in axes if axis in "zyx"]
        self._turn = [order.index(axis) for axis in "zyx"]
        self.shape = tuple(array.shape[axes.index(axis)] for axis in "zyx")
        self.dtype = array.dtype
        inner = getattr(array, "shards", None) or array.chunks
        self.chunks = tuple(inner[axes.index(axis)] for axis in "zyx")

    def __getitem__(self, planes):
        picks = iter(self._picks)
        key = tuple(planes if axis == "z" else slice(None) if axis in "yx" else next(picks)
                    for axis in self._axes)
        return np.asarray(self._array[key]).transpose(self._turn)


def _folder_of(zarr, group):
    """The folder of a group of zarr on a local disk; None of others."""
    if not isinstance(group.store, zarr.storage.LocalStore):
        return None
    return os.path.normpath(os.path.join(group.store.root, group.path))


def _opened_group(zarr, source):
    place = os.fspath(source)
    if place.endswith(".ozx"):
        return zarr.open_group(zarr.storage.ZipStore(place, mode="r"), mode="r")
    try:
        return zarr.open_group(place, mode="r")
    except Exception as error:
        raise ArgumentError(f"{place}: {str(error).splitlines()[0] or 'is no zarr group'}",
                            path=place) from None


def _facts_of_image(attributes, image, dataset, axes, units, level):
    """What `build` is told of an image."""
    scale, translation = np.ones(len(axes)), np.zeros(len(axes))
    for transforms in (dataset.get("coordinateTransformations", ()),
                       image.get("coordinateTransformations", ())):
        for one in transforms:
            if one["type"] == "scale":
                scale = scale * one["scale"]
                translation = translation * one["scale"]
            elif one["type"] == "translation":
                translation = translation + one["translation"]
    places = [axes.index(axis) for axis in "zyx"]
    mm = np.array([_MM_PER.get(units.get(axis), np.nan) for axis in "zyx"])
    facts = {}
    if np.isfinite(mm).all():
        facts["spacing"] = tuple(scale[places] * mm)
        facts["origin"] = tuple(translation[places] * mm)
    if "image-label" in attributes.get("ome", attributes):
        facts["kind"] = "labels"
    return {**facts, **_own_facts(attributes, translation[places] * np.nan_to_num(mm, nan=1.0))}


def _own_facts(attributes, place):
    """What an image that was written here says beside."""
    own = attributes.get("octavo")
    if not isinstance(own, dict) or "direction" not in own:
        return {}
    metadata = own.get("metadata", {})
    direction = np.array(own["direction"], float).reshape(3, 3)
    facts = dict(direction=direction, slope=own["slope"], intercept=own["intercept"],
                 origin=tuple((direction @ place[::-1])[::-1]),
                 kind="labels" if own.get("content") == "label map" else "grey")
    if metadata.get("unit"):
        facts["unit"] = metadata["unit"]
    if isinstance(metadata.get("labels"), dict):
        # A label may have a color alone.
        facts["label_names"] = {int(label): said["name"]
                                for label, said in metadata["labels"].items() if "name" in said}
    return facts
