"""Files out of arrays, of planes as they come, and of scans on disk."""

import contextlib
import itertools
import operator
import os

import numpy as np

from . import _octavo
from ._coordinates import facts_of_coordinates
from ._errors import ArgumentError, SourceError
from ._program import build_by_program
from ._sources import require_free, require_there, written_path
from ._volume import RealView, View, Volume
from ._work import MOST_THREADS, _reporter, if_given, number_of, warn_of, whole_number

_BLOCK_BYTES = 64 << 20
_OF_ARRAYS = ("slope", "intercept", "unit", "label_names", "direction", "origin")


def build(source, path, *, kind=None, spacing=None, origin=None, direction=None, unit=None,
          slope=None, intercept=None, label_names=None, preset="small", access=None,
          max_error=0.0, keep_details=0, nan=None, inf=None, thumbnail=False, overwrite=False,
          resume=False, threads=0, max_memory=0, progress=None, shape=None, channel=None,
          time=None, series=None):
    """Build an .8vo file.

    Parameters
    ----------
    source : array, Volume or View, LabelMap, path
        Anything of three dimensions [z, y, x] with `shape`, `dtype` and slices: a numpy, dask, zarr
        or h5py array. It is read some planes at a time, never as a whole, and may have any strides
        and byte order. bool becomes uint8 and float16 float32; int64, uint64 and float64 become
        int32, uint32 or float32, whichever holds what is in the first planes, with a warning where
        values are rounded. Or a path that the program `octavo` reads: a folder of DICOM or TIFF
        slices, NIfTI, NRRD, MetaImage and others; the program has to be on PATH. OME-Zarr images
        and arrays of zarr, a folder or an .ozx file, are read without it. Of a volume or one of its
        levels, what is not given below stays as it is; of an array of `octavo.xarray`, its kind
        and the place of its voxels. Of a LabelMap, what `LabelMap.save`
        writes. Or an iterator of planes [y, x], with `shape`.
    path : str or os.PathLike
        Ends in .8vo. Nothing stands there before the file is whole.
    kind : {"grey", "labels"}, optional
        "labels" for arrays of bool, else "grey".
    spacing, origin : sequence of float, optional
        mm along z, y, x; the world position of voxel [0, 0, 0], LPS. Without a spacing the file
        says that it is not known.
    direction : 3 x 3 array, optional
        Columns: the unit vectors of the axes x, y, z in the world, as ITK has it. None: identity.
    unit : str, optional
        Of real values; "HU" is understood.
    slope, intercept : float, optional
        real value = slope * voxel + intercept; 1 and 0 where not given.
    label_names : dict of int to str, optional
        Names of labels, of one line and at most 512 bytes. Labels that are built again keep their
        names and colors where none are given.
    preset : {"small", "fast"}
        Fewest bytes, or several times faster.
    access : {"none", "slices", "boxes"}, optional
        What shall decode alone; by the preset where not given.
    max_error : float
        The most that a real value may change; 0: nothing does.
    keep_details : int
        The finest level whose details are kept.
    nan, inf : float, optional
        Stored values that take the place of NaN and infinities; without a max error these are kept
        as they are.
    thumbnail : bool
        Put a small picture into the file: it may show a face.
    overwrite, resume : bool
        Replace a file; continue an interrupted build of the same voxels.
    threads, max_memory : int
        0: all cores, no limit (bytes).
    progress : callable or True, optional
        Called as progress(done, total, what); True shows a bar of tqdm.
    shape : (int, int, int), optional
        z, y, x, of planes that an iterator gives.
    channel : int or str, optional
    time : int, optional
    series : int or str, optional
        What is taken of a path that has several. A series is a number in one TIFF file, or a
        SeriesInstanceUID of DICOM.

    Returns
    -------
    Volume
        The file, opened.

    Raises
    ------
    octavo.ArgumentError, octavo.SourceError, octavo.StorageError, octavo.LimitError
    """
    given = _given(preset, access, max_error, keep_details, nan, inf, thumbnail, overwrite, resume,
                   threads, max_memory)
    path = _output(path)
    said = dict(kind=kind, spacing=spacing, origin=origin, direction=direction, unit=unit,
                slope=slope, intercept=intercept, label_names=label_names)
    if isinstance(source, (str, os.PathLike)):
        source = os.fspath(source)
        if is_zarr(source):
            if series is not None:
                raise ArgumentError("series are of DICOM and TIFF; zarr has none")
            return build_zarr(source, path, said, given, progress, channel=channel, time=time)
        require_there(source)
        require_free(path, given["overwrite"])
        chosen = {**given, "channel": channel, "time": time, "series": series}
        with _reporter(progress) as report:
            texts = build_by_program(source, path, _words_of(said, chosen), given, report)
        warn_of(texts)
        return Volume(path)
    if channel is not None or time is not None or series is not None:
        raise ArgumentError("channel, time and series are of paths; index an array")
    if shape is not None:
        return _build_of_planes(source, path, shape, said, given, progress)
    from ._label_map import LabelMap
    if isinstance(source, LabelMap):
        return _saved(source, path, said, given, progress)
    if isinstance(source, View):
        _require_not_own_source(source, path)
        shape, dtype = source.shape, source.dtype
        said = {**_facts_of_view(source), **{k: v for k, v in said.items() if v is not None}}
    elif isinstance(source, RealView):
        _require_not_own_source(source, path)
        shape, dtype = source.shape, source.dtype
        kept = {**_facts_of_view(source), "kind": None, "slope": None, "intercept": None,
                "source_metadata": None}
        said = {**kept, **{k: v for k, v in said.items() if v is not None}}
    else:
        shape, dtype = _shape_and_type(source)
        kept = facts_of_coordinates(source)
        said = {name: kept.get(name) if value is None else value for name, value in said.items()}
    facts = _facts(dtype, **said)
    read = source.__getitem__
    planes = _Planes(read, shape, np.dtype(facts["dtype"]), dtype, getattr(source, "chunks", None))
    given["kind"] = facts["kind"]
    with _reporter(progress) as report:
        texts = _octavo.build(path, shape, facts, planes.plane, given, report)
    warn_of(texts)
    return Volume(path)


def is_zarr(path):
    """Whether a path is an image or array of zarr that is read without the program."""
    try:
        path.encode()
    except UnicodeEncodeError:
        return False
    return "://" not in path and "\0" not in path and _octavo.is_zarr(path)


def build_zarr(source, path, said, given, progress, *, level=0, channel=None, time=None):
    """`build` of an image or array of zarr."""
    for name in _OF_ARRAYS:
        if said.get(name) is not None:
            raise ArgumentError(f"{name} comes from the files of a scan; it is for arrays")
    asked = dict(level=whole_number(level, "level", 0, 63), kind=said["kind"],
                 channel="" if channel is None else str(channel),
                 time=if_given(whole_number, time, "time", 0),
                 spacing=None if said["spacing"] is None else _three(said["spacing"], "spacing"))
    given["kind"] = said["kind"] or "grey"
    with _reporter(progress) as report:
        of_source, of_build = _octavo.build_zarr(source, path, asked, given, report)
    warn_of([*(f"{source}: {text}" for text in of_source), *of_build])
    return Volume(path)


def _saved(labels, path, said, given, progress):
    """`build` of a LabelMap: what its `save` writes."""
    kept = {name: given.pop(name) for name in ("overwrite", "thumbnail", "threads", "max_memory")}
    asked = {name for name, value in said.items() if value is not None}
    asked |= {name for name, value in given.items() if value != BUILD_OPTIONS[name]}
    if said["kind"] == "labels":
        asked.remove("kind")
    if asked:
        raise ArgumentError(f"a LabelMap is written as it is, so {sorted(asked)[0]} cannot be "
                            "given; .to_numpy() makes an array of it")
    return labels.save(path, **kept, progress=progress)


def _build_of_planes(planes, path, shape, said, given, progress):
    """`build` of planes that an iterator gives."""
    if hasattr(planes, "shape") or not hasattr(planes, "__iter__"):
        raise ArgumentError("shape is of an iterator of planes; an array has its own")
    shape = _volume_shape(shape)
    options = {name: value for name, value in given.items()}
    planes = iter(planes)
    first = next(planes, None)
    if first is None:
        raise ArgumentError(f"the iterator gives no plane, and {shape[0]} are announced")
    first = np.asanyarray(first)
    with Writer(path, shape, first.dtype, **said, **options) as writer, \
            _reporter(progress) as report:
        for plane in itertools.chain((first,), planes):
            writer.add(plane)
            if report:
                report(writer.added, shape[0], "building")
    return Volume(path)


class Writer:
    """Builds a file of planes as they come, in the order of z.

        with octavo.Writer("scan.8vo", (512, 2048, 2048), "uint16", spacing=(1, .5, .5)) as w:
            for plane in camera:
                w.add(plane)

    The file is sealed where the block ends; where it raises, or planes are missing, nothing stands
    under the name. Memory is that of `build`.

    Parameters
    ----------
    path : str or os.PathLike
    shape : (int, int, int)
        z, y, x.
    dtype : numpy.dtype
        Of 32 bits at most: what wider numbers become follows from values that are not there yet.
    **options
        As of `build`; with resume=True planes that an interrupted writer has encoded are compared
        with those given again, and not encoded again.
    """

    def __init__(self, path, shape, dtype, *, kind=None, spacing=None, origin=None,
                 direction=None, unit=None, slope=None, intercept=None, label_names=None,
                 preset="small", access=None, max_error=0.0, keep_details=0, nan=None, inf=None,
                 thumbnail=False, overwrite=False, resume=False, threads=0, max_memory=0):
        given = _given(preset, access, max_error, keep_details, nan, inf, thumbnail, overwrite,
                       resume, threads, max_memory)
        self.path = _output(path)
        self.shape = _volume_shape(shape)
        dtype = _dtype_of(dtype)
        facts = _facts(dtype, kind, spacing, origin, direction, unit, slope, intercept,
                       label_names)
        given["kind"] = facts["kind"]
        self.dtype = np.dtype(facts["dtype"])
        self._given_type = dtype
        self._writer = _octavo.PlaneWriter(self.path, self.shape, facts, given)

    @property
    def added(self):
        """Number of planes so far."""
        return self._open().added

    def add(self, planes):
        """Append a plane [y, x], or several [z, y, x].

        Raises
        ------
        octavo.ArgumentError
            For planes of another shape or dtype, and more of them than announced.
        """
        _require_no_mask(planes)
        planes = np.asarray(planes)
        if planes.ndim == 2:
            planes = planes[None]
        if planes.ndim != 3 or planes.shape[1:] != self.shape[1:]:
            raise ArgumentError(f"a plane has the shape {self.shape[1:]}, not {planes.shape}",
                                path=self.path)
        if not np.can_cast(planes.dtype, self._given_type, "equiv"):
            raise ArgumentError(f"planes are of {self._given_type}, not of {planes.dtype}",
                                path=self.path)
        if self.added + len(planes) > self.shape[0]:
            raise ArgumentError(f"{self.added} of {self.shape[0]} planes were added: there is no "
                                f"room for {len(planes)} more", path=self.path)
        for plane in planes:
            self._open().add(np.ascontiguousarray(plane, self.dtype))

    def close(self):
        """Seal the file. Again, or after `abandon`, it does nothing.

        Raises
        ------
        octavo.ArgumentError
            Where planes are missing; then nothing is written.
        """
        if self._writer is None:
            return
        writer, self._writer = self._writer, None
        warn_of(writer.finish())

    def abandon(self):
        """Give up: nothing is left under the name."""
        if self._writer is not None:
            writer, self._writer = self._writer, None
            writer.abandon()

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        if kind is None:
            self.close()
        else:
            self.abandon()

    def _open(self):
        if self._writer is None:
            raise ArgumentError(f"{self.path}: the writer is closed", path=self.path)
        return self._writer


class _Planes:
    """Planes of an array that is sliced, read in blocks as deep as its chunks are."""

    def __init__(self, read, shape, dtype, given_type, chunks):
        self._given_type = given_type
        self._read = read
        self._shape = shape
        self._dtype = dtype
        plane = max(1, shape[1] * shape[2] * dtype.itemsize)
        self._depth = min(_depth_of(chunks), max(1, _BLOCK_BYTES // plane))
        self._first = 0
        self._block = None

    def plane(self, z):
        if self._block is None or not 0 <= z - self._first < len(self._block):
            self._first = z - z % self._depth
            end = min(self._first + self._depth, self._shape[0])
            self._block = np.asanyarray(self._read(slice(self._first, end)))
            self._require_type()
            if self._block.shape != (end - self._first, *self._shape[1:]):
                raise SourceError(f"planes {self._first} to {end - 1} have the shape "
                                  f"{self._block.shape}")
        return np.ascontiguousarray(self._block[z - self._first], self._dtype)

    def _require_type(self):
        # Some arrays say another type than their slices have.
        _require_no_mask(self._block)
        if not np.can_cast(self._block.dtype, self._given_type, "equiv"):
            raise SourceError(f"the array is of {self._given_type}, and slices of it are of "
                              f"{self._block.dtype}")


def _depth_of(chunks):
    if chunks is None or chunks is True or len(chunks) == 0:
        return 1
    depth = chunks[0]
    return int(max(depth)) if isinstance(depth, (tuple, list)) else int(depth)


def _shape_and_type(source):
    shape, dtype = getattr(source, "shape", None), getattr(source, "dtype", None)
    if shape is None or dtype is None or not hasattr(source, "__getitem__"):
        raise ArgumentError("give an array, a path or an open volume, not "
                            f"{type(source).__name__}; of planes one after another say "
                            "shape=(z, y, x), or give them to octavo.Writer")
    _require_no_mask(source)
    # Arrays of tensorstore name the type of numpy that theirs is.
    return _volume_shape(shape), _dtype_of(getattr(dtype, "numpy_dtype", dtype))


def _volume_shape(shape):
    try:
        numbers = tuple(operator.index(n) for n in shape)
    except TypeError:
        numbers = ()
    if len(numbers) != 3 or min(numbers) < 1:
        raise ArgumentError(f"shape {shape} is no volume of one voxel or more, z, y, x")
    return numbers


def _require_no_mask(array):
    if isinstance(array, np.ma.MaskedArray):
        raise ArgumentError("files hold no mask: give .filled(value) of a masked array")


def _dtype_of(given):
    try:
        return np.dtype(given)
    except (TypeError, ValueError):
        raise ArgumentError(f"dtype is a type of numpy, not {given!r}") from None


def _stored_type(dtype):
    if dtype.kind not in "biuf":
        raise ArgumentError(f"voxels of type {dtype} have no place in a file (convert them with "
                            ".astype())")
    if dtype == np.bool_:
        return "uint8"
    if dtype.name == "float16":  # in either byte order
        return "float32"
    return dtype.name


def _facts(dtype, kind, spacing, origin, direction, unit, slope, intercept, label_names=None,
           source_metadata=None):
    """What the extension is told of a volume; None: by default. Labels without names are called
    as `source_metadata` says."""
    direction = np.eye(3) if direction is None else direction
    if kind is None:
        kind = "labels" if dtype == np.bool_ else "grey"
    slope = 1 if slope is None else slope
    intercept = 0 if intercept is None else intercept
    if unit is not None:
        _require_text(unit)
    if label_names is not None and not isinstance(label_names, dict):
        raise ArgumentError("label_names is a dictionary, label: name")
    for name in (label_names or {}).values():
        _require_text(name)
    return dict(dtype=_stored_type(dtype),
                kind=kind, spacing=None if spacing is None else _three(spacing, "spacing"),
                origin=_three((0, 0, 0) if origin is None else origin, "origin"),
                direction=_numbers(direction, 9, "direction has 3 x 3 numbers"),
                slope=_numbers(slope, 1, "slope is a number")[0],
                intercept=_numbers(intercept, 1, "intercept is a number")[0],
                unit="[hnsf'U]" if unit == "HU" else unit,
                label_names=None if label_names is None else
                {whole_number(label, "a label", -(1 << 62)): name
                 for label, name in label_names.items()},
                source_metadata=source_metadata, format="array")


def _facts_of_view(view):
    facts = view._file.facts
    return dict(kind=facts["kind"], spacing=view.spacing if facts["is_spacing_known"] else None,
                origin=view.origin, direction=facts["direction"], slope=facts["slope"],
                intercept=facts["intercept"], unit=facts["unit"],
                source_metadata=facts["metadata"])


def _three(numbers, what):
    return _numbers(numbers, 3, f"{what} has three numbers, along z, y, x")


def _numbers(given, count, what):
    try:
        numbers = tuple(map(float, np.ravel(np.asarray(given, float))))
    except (TypeError, ValueError):
        numbers = ()
    if len(numbers) != count:
        raise ArgumentError(f"{what}, not {given!r}")
    return numbers


def _require_text(text):
    try:
        is_text = isinstance(text, str) and "\0" not in text and text.encode() is not None
    except UnicodeEncodeError:
        is_text = False
    if not is_text:
        raise ArgumentError("unit is text, and label_names gives text to labels")


BUILD_OPTIONS = dict(preset="small", access=None, max_error=0.0, keep_details=0, nan=None, inf=None,
                     thumbnail=False, overwrite=False, resume=False, threads=0, max_memory=0)


def _given(preset, access, max_error, keep_details, nan, inf, thumbnail, overwrite, resume,
           threads, max_memory):
    max_error = number_of(max_error, "max_error")
    if max_error < 0:
        raise ArgumentError("max_error is 0 or more")
    if overwrite and resume:
        raise ArgumentError("overwrite starts anew, resume goes on: give one of them")
    keep_details = whole_number(keep_details, "keep_details", 0, 31)
    threads = whole_number(threads, "threads", 0, MOST_THREADS)
    max_memory = whole_number(max_memory, "max_memory", 0)
    return dict(preset=preset, access=access, max_error=max_error,
                keep_details=keep_details, nan=if_given(number_of, nan, "nan"),
                inf=if_given(number_of, inf, "inf"), thumbnail=bool(thumbnail),
                overwrite=bool(overwrite), resume=bool(resume), threads=threads,
                max_memory=max_memory)


def _output(path):
    path = written_path(path)
    if not path.endswith(".8vo"):
        raise ArgumentError(f"{path}: the name of a volume ends in .8vo", path=path)
    return path


def _require_not_own_source(view, path):
    place = view._file.place
    # Bytes and most URLs are no file here.
    with contextlib.suppress(OSError):
        if isinstance(place, str) and os.path.samefile(place.removeprefix("file://"), path):
            raise ArgumentError(f"{path}: is the volume that is read", path=path)


def _words_of(options, given):
    """What the program is told of the bytes that it makes of a scan."""
    for name in _OF_ARRAYS:
        if options.get(name) is not None:
            raise ArgumentError(f"{name} comes from the files of a scan; it is for arrays")
    _octavo.require_words({**given, "kind": options["kind"]})
    words = [] if given["preset"] == "small" else ["--preset", given["preset"]]
    if options["kind"] is not None:
        words.append(f"--{options['kind']}")
    if options["spacing"] is not None:
        words += ["--spacing", ",".join(map(repr, _three(options["spacing"], "spacing")[::-1]))]
    for name, flag in (("access", "--access"), ("nan", "--nan"), ("inf", "--inf"),
                       ("channel", "--channel"), ("time", "--time"), ("series", "--series")):
        # Builds by parts have none of the last three.
        if given.get(name) is not None:
            words += [flag, str(given[name])]
    for name, flag in (("max_error", "--max-error"), ("keep_details", "--keep-details")):
        if given[name]:
            words += [flag, repr(given[name])]
    if given["thumbnail"]:
        words.append("--thumbnail")
    return words
