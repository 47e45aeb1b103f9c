# The types of the package, for editors and checkers of types; test_types.py holds them beside it.
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, BinaryIO, Literal, NamedTuple, Protocol, overload

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

_Path = str | os.PathLike[str]
_Progress = Callable[[int, int, str], object] | Literal[True] | None
_Labels = int | str | Iterable[int | str] | None
_Range = Sequence[float | None]
_Point = Sequence[float]
_Box = Sequence[Sequence[int]]
_Overlay = Volume | LabelMap
_Look = str | os.PathLike[str] | tuple[str, float] | None

__version__: str

class _FileOfFsspec(Protocol):
    fs: Any
    path: str
    @property
    def full_name(self) -> str: ...

_Source = _Path | bytes | bytearray | memoryview | BinaryIO | _FileOfFsspec

class Error(ValueError):
    kind: str
    detail: str
    path: str
    offset: int | None
    def __init__(self, text: str, detail: str = "", path: str = "",
                 offset: int | None = None) -> None: ...

class ArgumentError(Error): ...
class FormatError(Error): ...
class VersionError(Error): ...
class CorruptError(Error): ...
class TruncatedError(CorruptError): ...
class LimitError(Error): ...
class SourceError(Error): ...
class StorageError(Error, OSError): ...

class MissingError(StorageError, FileNotFoundError):
    errno: int
    strerror: str
    filename: str

class ExistsError(StorageError, FileExistsError):
    errno: int
    strerror: str
    filename: str

class OutOfMemoryError(Error, MemoryError): ...
class Cancelled(Error): ...
class InternalError(Error): ...

class Surface(NamedTuple):
    vertices: NDArray[np.float32]
    faces: NDArray[np.uint32]
    facts: dict[str, Any]

class _StructureTasks:
    @overload
    def distance(self, path: None = None, *, to: Literal["faces", "centers"] = "faces",
                 max_mm: float | None = None, step_mm: None = None, within_mm: None = None,
                 overwrite: bool = False, threads: int = 0, max_memory: int = 0,
                 progress: _Progress = None) -> NDArray[np.float32]: ...
    @overload
    def distance(self, path: _Path, *, to: Literal["faces", "centers"] = "faces",
                 max_mm: float | None = None, step_mm: float | None = None,
                 within_mm: float | None = None, overwrite: bool = False, threads: int = 0,
                 max_memory: int = 0, progress: _Progress = None) -> Volume: ...
    def morphometry(self, *, region: Volume | LabelMap | None = None, of: Volume | None = None,
                    calibration: Sequence[float] = (1, 0), thickness: bool = True,
                    tortuosity: bool = False, diffusion: bool = False,
                    thickness_map: _Path | Literal[True] | None = None,
                    spacing_map: _Path | Literal[True] | None = None,
                    histogram: _Path | None = None, overwrite: bool = False, threads: int = 0,
                    max_memory: int = 0, progress: _Progress = None) -> dict[str, Any]: ...
    def align(self, fixed: Volume | LabelMap, *, scale: bool = False,
              output: _Path | None = None, picture: _Path | None = None, overwrite: bool = False,
              threads: int = 0, max_memory: int = 0,
              progress: _Progress = None) -> dict[str, Any]: ...
    def align_features(self, features: _Path | ArrayLike, *, scale: bool = False,
                       output: _Path | None = None, picture: _Path | None = None,
                       overwrite: bool = False, threads: int = 0, max_memory: int = 0,
                       progress: _Progress = None) -> dict[str, Any]: ...
    @overload
    def touch(self, other: None = None, *, connectivity: Literal[6, 18, 26] = 6, threads: int = 0,
              max_memory: int = 0, progress: _Progress = None) -> list[dict[str, Any]]: ...
    @overload
    def touch(self, other: Volume | LabelMap, *, connectivity: Literal[6, 18, 26] = 6,
              threads: int = 0, max_memory: int = 0,
              progress: _Progress = None) -> dict[str, Any]: ...
    def shell(self, *, threads: int = 0, max_memory: int = 0,
              progress: _Progress = None) -> LabelMap: ...

class _PictureTasks:
    def slice(self, axis: Literal["z", "y", "x"] = "z", index: int | None = None, *,
              position_mm: float | None = None, plane: _Point | Sequence[_Point] | None = None,
              montage: Sequence[int] | None = None, every: int | None = None, level: int = 0,
              window: _Range | None = None, preset: str = "", labels: _Labels = None,
              overlays: _Overlay | Iterable[_Overlay | tuple[_Overlay, dict[str, Any]]] = (),
              salvage: bool | Literal["coarse"] | float | None = None, text: bool = True,
              minimum_side: int = 512, threads: int = 0, max_memory: int = 0,
              progress: _Progress = None) -> NDArray[np.uint8]: ...
    def render(self, mode: str | None = None, *, view: str = "left-front-top",
               azimuth: float | None = None, elevation: float | None = None,
               direction: _Point | None = None, perspective: float | None = None,
               ranges: Iterable[Sequence[Any]] = (), tissues: str | Iterable[str] = (),
               labels: _Labels = None, level: int | None = None, isovalue: float | None = None,
               window: _Range | None = None, average: bool = False,
               transfer: _Path | None = None, shade: Literal["flat", "smooth"] | None = None,
               fade: float | None = None, cuts: str | Iterable[str] = (),
               removed: Iterable[Sequence[Sequence[int | None]]] = (),
               mask: _Overlay | None = None, label_map: _Overlay | None = None,
               label_looks: Mapping[int | str | None, _Look] | None = None,
               meshes: Iterable[_Path | tuple[Any, ...]] = (),
               marks: Iterable[Sequence[Any]] = (), ambient_shade: bool = False,
               shadows: bool = False, smooth_edges: bool = False, adaptive: bool = False,
               moving: bool = False, time_budget: float | None = None,
               size: Sequence[int] = (1024, 1024), zoom: float = 1.0, turntable: int = 0,
               grow: bool = False, background: str = "black", text: bool = True, threads: int = 0,
               max_memory: int = 0, progress: _Progress = None) -> NDArray[np.uint8]: ...

class _SurfaceTasks:
    def surface(self, isovalue: float | None = None, *, labels: _Labels = None,
                stored: bool = False, level: int = 0, seed: _Point | None = None,
                max_deviation_mm: float = 0.0, max_deviation_voxels: float | None = None,
                triangles: int | str | None = None,
                method: Literal["collapse", "octree"] = "collapse",
                space: Literal["lps", "ras"] = "lps", threads: int = 0, max_memory: int = 0,
                progress: _Progress = None) -> Surface: ...
    def save_surface(self, path: _Path, isovalue: float | None = None, *, labels: _Labels = None,
                     stored: bool = False, level: int = 0, seed: _Point | None = None,
                     max_deviation_mm: float = 0.0, max_deviation_voxels: float | None = None,
                     triangles: int | str | None = None,
                     method: Literal["collapse", "octree"] = "collapse",
                     space: Literal["lps", "ras"] = "lps", plain: bool = False,
                     report: _Path | None = None, allow_faults: bool = False,
                     overwrite: bool = False, threads: int = 0, max_memory: int = 0,
                     progress: _Progress = None) -> dict[str, Any]: ...
    def save_label_surfaces(self, path: _Path, *,
                            form: Literal["parts", "interfaces"] = "parts",
                            part_format: Literal["stl", "ply", "obj", "glb", "vtp", "3mf"] = "stl",
                            labels: _Labels = None, level: int = 0, smooth: int = 20,
                            max_deviation_mm: float = 0.0,
                            max_deviation_voxels: float | None = None,
                            triangles: int | str | None = None,
                            space: Literal["lps", "ras"] = "lps", overwrite: bool = False,
                            threads: int = 0, max_memory: int = 0,
                            progress: _Progress = None) -> dict[str, Any]: ...
    def save_hexahedra(self, path: _Path, *,
                       method: Literal["uniform", "octree", "conforming"] = "uniform",
                       labels: _Labels = None, level: int = 0, keep_largest: bool = False,
                       of: Volume | None = None, density: Sequence[float] | None = None,
                       modulus: Sequence[float] | None = None, min_modulus: float = 1.0,
                       poisson_ratio: float = 0.3, bins: int = 32, quality: bool = False,
                       overwrite: bool = False, threads: int = 0, max_memory: int = 0,
                       progress: _Progress = None) -> dict[str, Any]: ...

class _FileTasks(_StructureTasks, _PictureTasks, _SurfaceTasks):
    def measure(self, of: Volume | None = None, *, labels: _Labels = None,
                percentiles: Sequence[float] = (5, 25, 50, 75, 95), threads: int = 0,
                max_memory: int = 0, progress: _Progress = None) -> list[dict[str, Any]]: ...
    def compare(self, other: Volume | LabelMap, *, max_error: float = 0.0, threads: int = 0,
                max_memory: int = 0, progress: _Progress = None) -> dict[str, Any]: ...
    def transform(self, path: _Path, *, grid_of: Volume | LabelMap | None = None,
                  interpolation: Literal["nearest", "linear", "cubic"] | None = None,
                  fill: float | None = None, in_place: bool = False, inverse: bool = False,
                  preset: Literal["small", "fast"] = "small", max_error: float = 0.0,
                  overwrite: bool = False, threads: int = 0, max_memory: int = 0,
                  progress: _Progress = None, **steps: Any) -> Volume: ...

class View:
    ndim: int
    level: int
    shape: tuple[int, int, int]
    spacing: tuple[float, float, float]
    origin: tuple[float, float, float]
    factor: tuple[int, int, int]
    chunks: tuple[int, int, int]
    dtype: np.dtype[Any]
    @property
    def translation(self) -> tuple[float, ...]: ...
    @property
    def size(self) -> int: ...
    @property
    def nbytes(self) -> int: ...
    @property
    def affine(self) -> NDArray[np.float64]: ...
    @property
    def affine_ras(self) -> NDArray[np.float64]: ...
    def __len__(self) -> int: ...
    def __array__(self, dtype: DTypeLike | None = None,
                  copy: bool | None = None) -> NDArray[Any]: ...
    def __getitem__(self, key: Any) -> Any: ...
    def read(self, box: _Box | None = None, *, out: NDArray[Any] | None = None,
             threads: int = 0) -> NDArray[Any]: ...
    def at_mm(self, box_mm: ArrayLike) -> Any: ...

class RealView:
    dtype: np.dtype[np.float32]
    ndim: int
    level: int
    shape: tuple[int, int, int]
    spacing: tuple[float, float, float]
    origin: tuple[float, float, float]
    chunks: tuple[int, int, int]
    size: int
    affine: NDArray[np.float64]
    affine_ras: NDArray[np.float64]
    @property
    def nbytes(self) -> int: ...
    @property
    def levels(self) -> tuple[RealView, ...]: ...
    def __len__(self) -> int: ...
    def __array__(self, dtype: DTypeLike | None = None,
                  copy: bool | None = None) -> NDArray[Any]: ...
    def __getitem__(self, key: Any) -> Any: ...
    def at_mm(self, box_mm: ArrayLike) -> Any: ...

class Volume(_FileTasks, View):
    kind: Literal["grey", "labels"]
    unit: str
    slope: float
    intercept: float
    min: float
    max: float
    max_error: float
    label_names: dict[int, str]
    voxels_sha256: str
    is_spacing_known: bool
    def __init__(self, source: _Source, cache_bytes: int = ...,
                 storage_options: dict[str, Any] | None = None) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def file_bytes(self) -> int: ...
    @property
    def attrs(self) -> dict[str, Any]: ...
    @property
    def levels(self) -> tuple[View, ...]: ...
    @property
    def real(self) -> RealView: ...
    @property
    def closed(self) -> bool: ...
    def read(self, box: _Box | None = None, level: int = 0, *, out: NDArray[Any] | None = None,
             threads: int = 0) -> NDArray[Any]: ...
    def at_mm(self, box_mm: ArrayLike, level: int = 0) -> Any: ...
    def level_for(self, spacing_mm: float) -> int: ...
    def at_budget(self, nbytes: int) -> View: ...
    def brick_ranges(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
    def threshold(self, low: float | None = None, high: float | None = None, *,
                  ranges: Iterable[_Range] = (), tissue: str | Iterable[str] = (),
                  stored: bool = False, threads: int = 0, max_memory: int = 0,
                  progress: _Progress = None) -> LabelMap: ...
    def label_map(self, labels: _Labels = None, *, threads: int = 0, max_memory: int = 0,
                  progress: _Progress = None) -> LabelMap: ...
    def mask(self, labels: _Labels = None, *, threads: int = 0, max_memory: int = 0,
             progress: _Progress = None) -> LabelMap: ...
    def condense(self, path: _Path, flat: float, *, overwrite: bool = False, threads: int = 0,
                 max_memory: int = 0, progress: _Progress = None) -> Volume: ...
    def self_similarity(self, max_difference: float = 0.0, *, up_to_mean: bool = False,
                        coded: Volume | None = None, threads: int = 0, max_memory: int = 0,
                        progress: _Progress = None) -> dict[str, Any]: ...
    def classify(self, classes: Mapping[int, _Range], *, stored: bool = False, threads: int = 0,
                 max_memory: int = 0, progress: _Progress = None) -> LabelMap: ...
    def close(self) -> None: ...
    def __enter__(self) -> Volume: ...
    def __exit__(self, *_: object) -> None: ...

class LabelMap(_FileTasks):
    ndim: int
    shape: tuple[int, int, int]
    dtype: np.dtype[Any]
    spacing: tuple[float, float, float]
    origin: tuple[float, float, float]
    is_spacing_known: bool
    label_names: dict[int, str]
    table: list[dict[str, Any]]
    found: int
    def __init__(self, tree: Any, table: Iterable[dict[str, Any]] = (), found: int = 0) -> None: ...
    @property
    def affine(self) -> NDArray[np.float64]: ...
    @property
    def attrs(self) -> dict[str, Any]: ...
    @property
    def is_mask(self) -> bool: ...
    @property
    def size(self) -> int: ...
    @property
    def nbytes(self) -> int: ...
    @property
    def counts(self) -> dict[int, int]: ...
    @property
    def voxels(self) -> int: ...
    def __len__(self) -> int: ...
    def __bool__(self) -> bool: ...
    def __getitem__(self, key: Any) -> Any: ...
    def __array__(self, dtype: DTypeLike | None = None,
                  copy: bool | None = None) -> NDArray[Any]: ...
    def __and__(self, other: LabelMap) -> LabelMap: ...
    def __or__(self, other: LabelMap) -> LabelMap: ...
    def __sub__(self, other: LabelMap) -> LabelMap: ...
    def __xor__(self, other: LabelMap) -> LabelMap: ...
    def __invert__(self) -> LabelMap: ...
    def to_numpy(self) -> NDArray[Any]: ...
    def save(self, path: _Path, *, overwrite: bool = False, thumbnail: bool = False,
             threads: int = 0, max_memory: int = 0, progress: _Progress = None) -> Volume: ...
    def saved(self) -> Volume: ...
    def select(self, *labels: int | str) -> LabelMap: ...
    def fill_holes(self, *, connectivity: Literal[6, 18, 26] = 26, max_mm3: float | None = None,
                   threads: int = 0, max_memory: int = 0,
                   progress: _Progress = None) -> LabelMap: ...
    def dilate(self, voxels: int | None = None, *, mm: float | None = None,
               connectivity: Literal[6, 18, 26] | None = None, threads: int = 0, max_memory: int = 0,
               progress: _Progress = None) -> LabelMap: ...
    def erode(self, voxels: int | None = None, *, mm: float | None = None,
              connectivity: Literal[6, 18, 26] | None = None, threads: int = 0, max_memory: int = 0,
              progress: _Progress = None) -> LabelMap: ...
    def open(self, voxels: int | None = None, *, mm: float | None = None,
             connectivity: Literal[6, 18, 26] | None = None, threads: int = 0, max_memory: int = 0,
             progress: _Progress = None) -> LabelMap: ...
    def close(self, voxels: int | None = None, *, mm: float | None = None,
              connectivity: Literal[6, 18, 26] | None = None, threads: int = 0, max_memory: int = 0,
              progress: _Progress = None) -> LabelMap: ...
    def components(self, *, keep_largest: int = 0, min_mm3: float = 0,
                   connectivity: Literal[6, 18, 26] = 6, threads: int = 0, max_memory: int = 0,
                   progress: _Progress = None) -> LabelMap: ...
    def agreement(self, other: LabelMap | Volume) -> list[dict[str, Any]]: ...

class Writer:
    path: str
    shape: tuple[int, int, int]
    dtype: np.dtype[Any]
    def __init__(self, path: _Path, shape: Sequence[int], dtype: DTypeLike, *,
                 kind: Literal["grey", "labels"] | None = None, spacing: _Point | None = None,
                 origin: _Point | None = None, direction: ArrayLike | None = None,
                 unit: str | None = None, slope: float | None = None,
                 intercept: float | None = None, label_names: Mapping[int, str] | None = None,
                 preset: Literal["small", "fast"] = "small",
                 access: Literal["none", "slices", "boxes"] | None = None, max_error: float = 0.0,
                 keep_details: int = 0, nan: float | None = None, inf: float | None = None,
                 thumbnail: bool = False, overwrite: bool = False, resume: bool = False,
                 threads: int = 0, max_memory: int = 0) -> None: ...
    @property
    def added(self) -> int: ...
    def add(self, planes: ArrayLike) -> None: ...
    def close(self) -> None: ...
    def abandon(self) -> None: ...
    def __enter__(self) -> Writer: ...
    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None: ...

def open(source: _Source, *, cache_bytes: int = ...,
         storage_options: dict[str, Any] | None = None) -> Volume: ...
def build(source: Any, path: _Path, *, kind: Literal["grey", "labels"] | None = None,
          spacing: _Point | None = None, origin: _Point | None = None,
          direction: ArrayLike | None = None, unit: str | None = None, slope: float | None = None,
          intercept: float | None = None, label_names: Mapping[int, str] | None = None,
          preset: Literal["small", "fast"] = "small",
          access: Literal["none", "slices", "boxes"] | None = None, max_error: float = 0.0,
          keep_details: int = 0, nan: float | None = None, inf: float | None = None,
          thumbnail: bool = False, overwrite: bool = False, resume: bool = False, threads: int = 0,
          max_memory: int = 0, progress: _Progress = None, shape: Sequence[int] | None = None,
          channel: int | str | None = None, time: int | None = None,
          series: int | str | None = None) -> Volume: ...
def export(volume: Volume, path: _Path, *, level: int = 0,
           compression: Literal["zstd", "blosc", "none"] = "zstd", chunk_side: int = 64,
           shard_chunks: int = 4, overwrite: bool = False, threads: int = 0, max_memory: int = 0,
           progress: _Progress = None) -> dict[str, int]: ...
def from_ome_zarr(source: Any, path: _Path, *, level: int = 0, channel: int | str | None = None,
                  time: int | None = None, **options: Any) -> Volume: ...
def as_zarr(volume: Volume | LabelMap) -> Any: ...
def as_dask(volume: Volume | View | RealView | LabelMap, level: int = 0, *,
            chunks: Any = None) -> Any: ...
def viewer(volume: Volume | LabelMap, axis: Literal["z", "y", "x"] = "z", level: int | None = None,
           **look: Any) -> Any: ...
