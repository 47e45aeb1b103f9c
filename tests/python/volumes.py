"""Small volumes, and the files of them that together use every feature of the format."""

import dataclasses
import struct
from collections.abc import Callable

import numpy as np
from octavo_reader import OctavoFile


@dataclasses.dataclass
class Case:
    """A volume and how the program builds it.

    uses  tells whether an open file uses what the case is for
    """

    name: str
    voxels: np.ndarray
    options: tuple[str, ...]
    uses: Callable[[OctavoFile], bool]
    spacing: str = "1"


def waves(size, amplitude, noise):
    """A smooth volume with Gaussian noise, float64 of shape `size` = (z, y, x)."""
    z, y, x = np.meshgrid(*[np.linspace(0, 3, n) for n in size], indexing="ij")
    random = np.random.default_rng(sum(size))
    return amplitude * np.sin(2 * x + y) * np.cos(z + 1.5 * y) + random.normal(0, noise, size)


def blocks(size, side, low, high):
    """Cubes of equal numbers in [low, high)."""
    grid = np.random.default_rng(3).integers(low, high, [n // side + 1 for n in size])
    for axis in range(3):
        grid = grid.repeat(side, axis)
    return grid[: size[0], : size[1], : size[2]]


def object_in_air(size):
    """A noisy block within zeros."""
    voxels = np.zeros(size)
    inside = tuple(slice(n // 4, 3 * n // 4) for n in size)
    voxels[inside] = waves(voxels[inside].shape, 300, 2)
    return voxels


def speckles(size, amplitude):
    """Small bright things on a ground of 0."""
    random = np.random.default_rng(4)
    bright = random.integers(amplitude // 4, amplitude, size)
    voxels = np.where(random.random(size) < 0.01, bright, 0)
    return np.maximum(voxels, np.roll(voxels, 1, 2) // 2)


def nifti(voxels):
    """The bytes of a NIfTI file of float32 voxels in the scanner's axes, 1 mm apart."""
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, *voxels.shape[::-1], 1, 1, 1, 1)
    struct.pack_into("<hh", header, 70, 16, 32)
    struct.pack_into("<8f", header, 76, 1, 1, 1, 1, 0, 0, 0, 0)
    struct.pack_into("<ff", header, 108, 352, 1)
    struct.pack_into("<h", header, 254, 1)
    struct.pack_into("<12f", header, 280, -1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0)
    header[344:348] = b"n+1\0"
    return bytes(header) + voxels.astype("<f4").tobytes()


def predicts(number):
    return lambda file: file.model(0).predictor == number


def is_wide(file):
    return any(brick.largest - brick.smallest > 65535 for brick in file.bricks(0))


def is_rounded(file):
    return file.model(0).voxel_step > 1


def is_corrected(file):
    return file.model(0).correction_step > 0


def is_on_lattice(file):
    value_map = file.model(0).value_map
    return value_map is not None and value_map.step > 1


def has_gaps(file):
    value_map = file.model(0).value_map
    return value_map is not None and bool(value_map.codes)


def has_edges(file):
    return file.model(0).has_edges


def is_stored_brick(brick):
    return brick.pieces[0][1] > 0 and brick.pieces[-1][1] == 0


def is_stored(file):
    return any(is_stored_brick(brick) for brick in file.bricks(0))


def is_coded(file):
    return any(brick.pieces[-1][1] > 0 for brick in file.bricks(0))


def has_uniform_brick(file):
    return any(brick.smallest == brick.largest for brick in file.bricks(0))


def holds_plain_floats(file):
    heads = (file.read_bytes(brick.pieces[0][0], 1)[0] for brick in file.bricks(0)
             if is_stored_brick(brick))
    return file.header.is_exact and any(head & 16 for head in heads)


def is_exact(file):
    return file.header.is_exact


def with_gaps(voxels):
    """Float voxels of which some are NaN of several sorts, infinite or -0."""
    voxels = voxels.astype("float32")
    flat = voxels.reshape(-1)
    flat[: flat.size // 5] = np.nan
    flat[7::31] = np.inf
    flat[9::37] = -0.0
    flat[11::41] = 0.0
    flat.view(np.uint32)[13::43] = 0xFF800001 + np.arange(flat[13::43].size) % 5
    return voxels


def is_thick_along(axis):
    return lambda file: not file.header.halvings[0] >> axis & 1


def leaves_details_out(file):
    return file.header.detail_level > 0


GOLDEN_USES = {
    "small-int16": predicts(0),
    "small-int32-wide": is_wide,
    "small-axis-order": lambda file: file.model(0).axis_order != (0, 1, 2),
    "small-two-tiers": lambda file: file.header.tier_count > 1,
    "small-uint8-thick": is_thick_along(2),
    "small-lattice": is_on_lattice,
    "small-gaps": has_gaps,
    "small-edges": has_edges,
    "stored-uint8": is_stored,
    "fast-int16": predicts(1),
    "fast-int32-wide": is_wide,
    "float32-exact": lambda file: is_exact(file) and len(list(file.bricks(0))) > 1,
    "float32-exact-fast": lambda file: is_exact(file) and file.model(0).predictor == 1,
    "float32-plain": holds_plain_floats,
    "max-error-rounded": is_rounded,
    "max-error-quantised": is_corrected,
    "max-error-fast": predicts(1),
    "details-int16": leaves_details_out,
    "details-uint8-thick": leaves_details_out,
    "details-last": leaves_details_out,
    "details-stored": lambda file: leaves_details_out(file) and is_stored(file),
}


def cases():
    noise = np.random.default_rng(1).integers
    return [
        Case("small", waves((27, 34, 41), 300, 1).astype("int16"), (), predicts(0)),
        Case("fast", waves((27, 34, 41), 300, 2).astype("uint16") // 2,
             ("--preset", "fast"), predicts(1)),
        Case("two tiers", waves((9, 30, 70), 50, 1).astype("int8"), (),
             lambda file: file.header.tier_count > 1 and len(list(file.bricks(0))) > 1),
        Case("thick x", waves((33, 30, 9), 300, 2).astype("int16"), (), is_thick_along(0), "4,1,1"),
        Case("thick y", waves((33, 9, 30), 300, 2).astype("int16"), (), is_thick_along(1), "1,4,1"),
        Case("thick z", waves((9, 33, 30), 99, 2).astype("uint8"), (), is_thick_along(2), "1,1,4"),
        Case("wide", waves((20, 21, 22), 1.5e9, 1e3).astype("int32"), (), is_wide),
        Case("wide steps", np.where(waves((20, 21, 22), 1, 0) > 0, 2**31 - 1, -(2**31))
             .astype("int32") ^ noise(0, 8, (20, 21, 22), "int32"),
             ("--preset", "fast"), is_wide),
        Case("cells", object_in_air((40, 41, 42)).astype("int16"), (), is_coded),
        Case("uniform bricks", np.pad(waves((20, 20, 20), 300, 2), ((0, 0), (0, 0), (0, 60)))
             .astype("int16"), ("--preset", "fast"), has_uniform_brick),
        Case("one plane", waves((1, 50, 41), 300, 2).astype("uint16") // 3, (), is_coded),
        Case("multiples", waves((27, 34, 41), 200, 2).astype("uint16") // 5 * 16 + 3, (),
             is_on_lattice),
        Case("multiples, fast", waves((27, 34, 41), 200, 2).astype("int16") // 5 * 257,
             ("--preset", "fast"), is_on_lattice),
        Case("gaps", (np.abs(waves((27, 34, 41), 60, 2)).astype("int64") % 70 * 255 // 70)
             .astype("uint8"), (), has_gaps),
        Case("gaps, thick x", (np.abs(waves((27, 34, 23), 60, 2)).astype("int64") % 70 * 255 // 70)
             .astype("uint8"), (), has_gaps, "4,1,1"),
        Case("two values", np.where(waves((27, 34, 41), 60, 2) > 0, 255, 0).astype("uint8"), (),
             has_gaps),
        Case("edges", speckles((30, 29, 28), 300).astype("int16") - 5, (), has_edges),
        Case("edges, fast", speckles((22, 30, 29), 200).astype("uint8"), ("--preset", "fast"),
             has_edges),
        Case("wide edges", speckles((22, 20, 29), 1 << 20).astype("int32"), (), has_edges),
        Case("noise", noise(0, 256, (9, 10, 11)).astype("uint8"), (), is_stored),
        Case("one value", np.full((5, 6, 7), -3, "int16"), (), has_uniform_brick),
        Case("rounded", waves((27, 34, 41), 300, 20).astype("int16"),
             ("--max-error", "3"), is_rounded),
        Case("corrected", object_in_air((50, 60, 70)).astype("int16"),
             ("--max-error", "6"), is_corrected),
        Case("details left out", waves((27, 34, 41), 300, 2).astype("int16"),
             ("--keep-details", "1"), leaves_details_out),
        Case("details left out, fast", waves((9, 30, 70), 50, 1).astype("int8"),
             ("--keep-details", "2", "--preset", "fast"), leaves_details_out),
        Case("details left out, thick y", waves((33, 9, 37), 300, 9).astype("uint16") // 3,
             ("--keep-details", "3"), leaves_details_out, "1,4,1"),
        Case("details left out, multiples", waves((27, 34, 41), 200, 2).astype("uint16") // 5 * 16,
             ("--keep-details", "1"),
             lambda file: leaves_details_out(file) and is_on_lattice(file)),
        Case("details left out, gaps", (np.abs(waves((27, 34, 41), 60, 2)).astype("int64") % 70
                                        * 255 // 70).astype("uint8"), ("--keep-details", "1"),
             leaves_details_out),
        Case("details left out, cells", object_in_air((40, 41, 42)).astype("int16"),
             ("--keep-details", "1"), leaves_details_out),
        Case("details left out, wide", waves((20, 21, 22), 1.5e9, 1e3).astype("int32"),
             ("--keep-details", "2"), lambda file: leaves_details_out(file) and is_wide(file)),
        Case("details left out, noise", noise(0, 256, (4, 5, 6)).astype("uint8"),
             ("--keep-details", "1"), lambda file: leaves_details_out(file) and is_stored(file)),
        Case("all details left out", waves((20, 21, 37), 300, 2).astype("int16"),
             ("--keep-details", "5"), leaves_details_out),
        Case("float32 of steps", (np.round(waves((20, 21, 22), 800, 2)) + 5000)
             .astype("float32") * np.float32(0.125), (), predicts(0)),
        Case("float32 of noise", waves((20, 21, 22), 7, 0.1).astype("float32"), (), is_exact),
        Case("float32 with gaps", with_gaps(waves((20, 70, 22), 7, 0.1)), (), is_exact),
        Case("float32 in two tiers, fast", with_gaps(waves((9, 10, 70), 7, 0.1)),
             ("--preset", "fast"), is_exact),
        Case("float32 near zero", (waves((12, 11, 10), 7, 1) ** 9 * 1e-20).astype("float32"), (),
             is_exact),
        Case("float32 of any bits", noise(0, 2**32, (11, 23, 37), "uint32").view("float32"), (),
             holds_plain_floats),
        Case("float32 of any bits, thick y", noise(0, 2**32, (13, 9, 70), "uint32").view("float32"),
             ("--preset", "fast"), holds_plain_floats, "1,4,1"),
        Case("no numbers", np.full((5, 6, 7), np.nan, "float32"), (), is_exact),
        Case("float32 with an error", waves((20, 21, 22), 7, 0.1).astype("float32"),
             ("--max-error", "0.01"), is_rounded),
        Case("labels", blocks((30, 31, 70), 7, 0, 9).astype("uint8"), ("--labels",), is_coded),
        Case("many labels", blocks((23, 24, 25), 5, -400000, 400000).astype("int32"),
             ("--labels",), is_coded),
        Case("mask", (waves((30, 31, 32), 9, 0) > 3).astype("uint8"), ("--labels",), is_coded),
        Case("thick labels", blocks((9, 30, 31), 4, 0, 5).astype("int16"), ("--labels",),
             is_thick_along(2), "1,1,4"),
        Case("stored labels", noise(0, 1 << 32, (20, 18, 17)).astype("uint32"), ("--labels",),
             is_stored),
    ]
