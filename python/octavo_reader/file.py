"""A file that is open: docs/format.md, section 11."""

import os
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

import numpy as np

from .byte_cursor import crc32c
from .directory import Part, parse_directory
from .errors import OctavoError, require, require_known
from .exact_floats import ExactCoding, decode_exact_brick
from .grey_brick import coarse_codes, decode_grey_brick
from .grey_model import GreyModel, parse_grey_model
from .header import (
    BRICKS_PER_PAGE,
    HEADER_LENGTH,
    LEVELS_PER_TIER,
    TRAILER_LENGTH,
    Header,
    Section,
    parse_header,
)
from .index import Brick, Root, brick_order, o_code, parse_page, parse_root, split_pieces
from .label_brick import decode_label_brick
from .label_model import LabelModel, parse_label_model
from .metadata import parse_metadata
from .slab_trailer import SlabTrailer, parse_slab_trailer

_TRAILER_MAGIC = b"\x8f8voend\n"
_MODEL_LEVEL = 255
_FIRST_PART = 1 << 20


class OctavoFile:
    """Reads a file; nothing it gives out is uncovered by a checksum.

    header        sizes, geometry and types
    parts         what stands beside the voxels, as the directory lists it
    voxel_digest  SHA-256 of those of the planes of level 0, as the trailer has it
    A file is a context manager; not thread-safe.
    """

    def __init__(self, path: str | os.PathLike) -> None:
        """Opens a file. Raises OctavoError when it is none or damaged, OSError as open does."""
        self._file = Path(path).open("rb")
        try:
            self.header = parse_header(self._file.read(HEADER_LENGTH))
            self.voxel_digest = self._prove_trailer()
            self.parts = parse_directory(self._section(self.header.directory, "directory"),
                                         self.header)
            self._root = parse_root(self._section(self.header.root, "index root"), self.header)
            self._metadata = self._section(self.header.metadata, "metadata")
        except BaseException:
            self._file.close()
            raise
        self._page = lru_cache(maxsize=64)(self._read_page)
        self._parsed_model = lru_cache(maxsize=4)(self._read_model)

    def __enter__(self) -> "OctavoFile":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        self._file.close()

    @property
    def metadata(self) -> dict:
        """The JSON object that builds write. Raises OctavoError "corrupt" where it is none."""
        return parse_metadata(self._metadata)

    def part(self, part: Part) -> bytes:
        """The bytes of a part. Raises OctavoError "corrupt"."""
        return self._section(part.section, "part " + part.tag)

    @property
    def root(self) -> Root:
        return self._root

    @property
    def model_count(self) -> int:
        return len(self._root.models)

    def model(self, number: int) -> GreyModel | LabelModel:
        """One of the models, numbered as they stand in the file. Raises OctavoError "corrupt"."""
        return self._parsed_model(number)

    def bricks(self, tier: int) -> Iterator[Brick]:
        """The bricks of a tier, layer by layer in brick order. Raises OctavoError "corrupt"."""
        for layer, pages in enumerate(self._root.pages[tier]):
            for number in range(len(pages)):
                yield from self._page(tier, layer, number)

    def read_level(self, level: int) -> np.ndarray:
        """All samples of a level, of the voxel type of the file and shape [z][y][x].

        Raises  OctavoError "invalid_argument" if there is no such level, "corrupt" on damage,
                "unsupported_version"
        """
        header = self.header
        if not 0 <= level < header.level_count:
            raise OctavoError("invalid_argument",
                              f"there is no level {level}, only 0 to {header.level_count - 1}")
        tier = level // LEVELS_PER_TIER
        shifts = header.brick_shifts(tier)
        masks = header.halvings[LEVELS_PER_TIER * tier : level]
        sides = [1 << h - sum(mask >> axis & 1 for mask in masks) for axis, h in enumerate(shifts)]
        samples = np.empty(header.level_size(level)[::-1], header.voxel_type)
        bricks_x, bricks_y, layers = header.bricks(tier)
        for k in range(layers):
            for place, (i, j) in enumerate(brick_order(bricks_x, bricks_y)):
                box = self._read_brick(tier, level, (i, j, k), place)
                x, y, z = (n * side for n, side in zip((i, j, k), sides))
                samples[z : z + sides[2], y : y + sides[1], x : x + sides[0]] = box
        return samples

    def parents(self, tier: int) -> np.ndarray:
        """The samples of the first level of the next tier, as the bricks of a tier determine them.

        Raises  as read_level
        """
        bricks_x, bricks_y, layers = self.header.bricks(tier)
        samples = np.empty((layers, bricks_y, bricks_x), self.header.voxel_type)
        for k in range(layers):
            for place, (i, j) in enumerate(brick_order(bricks_x, bricks_y)):
                parent = self._read_brick(tier, LEVELS_PER_TIER * (tier + 1), (i, j, k), place)
                samples[k, j, i] = parent.reshape(())
        return samples

    def _read_brick(self, tier: int, level: int, at: tuple[int, int, int], place: int
                    ) -> np.ndarray:
        """The samples of one level of a brick, or the one value that all of them have.

        level  also the first one of the next tier, of which a brick determines one sample
        """
        header = self.header
        number = place // BRICKS_PER_PAGE
        brick = self._page(tier, at[2], number)[place % BRICKS_PER_PAGE]
        if brick.smallest == brick.largest:
            return self.voxels_of(np.array(brick.smallest))
        first = LEVELS_PER_TIER * tier
        segments = self._segments(tier, brick, level - first, o_code(*at))
        size = tuple(min(n - (i << h), 1 << h) for n, i, h in
                     zip(header.level_size(first), at, header.brick_shifts(tier)))
        halvings = list(header.halvings[first : first + len(segments)])
        halvings += [7] * (len(segments) - len(halvings))  # beyond the last level
        model = self.model(self._root.model_number(tier, at[2], header.bricks(0)[2]))
        weights = header.brick_weights(tier, at)
        detailed = header.detail_level if tier == 0 else 0
        if header.kind == "labels":
            codes = decode_label_brick(model, brick.smallest, brick.largest, segments, size,
                                       halvings, weights, level - first)
        else:
            def decode_codes(low: int, high: int, rests: list[bytes]) -> np.ndarray:
                return decode_grey_brick(model, low, high, rests, size, halvings, weights,
                                         level - first, detailed)

            def coarsened(finest: np.ndarray) -> np.ndarray:
                return coarse_codes(model, finest, halvings, weights, level - first)

            if header.is_exact:
                return decode_exact_brick(self._exact(), brick.smallest, brick.largest, segments,
                                          size, halvings, first, level - first, decode_codes,
                                          weights, coarsened)
            codes = decode_codes(brick.smallest, brick.largest, segments)
        return self.voxels_of(codes)

    def _exact(self) -> ExactCoding:
        return ExactCoding(self.header.code_scale, self.header.code_offset)

    def _segments(self, tier: int, brick: Brick, place: int, code: int) -> list[bytes]:
        """The segments of a brick that its level `place` takes; the others are left empty."""
        is_stored = brick.pieces[-1][1] == 0
        pieces = []
        for i, (offset, length, crc) in enumerate(brick.pieces):
            is_finer = i < min(place, len(brick.pieces) - 1)
            if length == 0 or (is_finer and not is_stored):
                pieces.append(b"")
                continue
            level = LEVELS_PER_TIER * tier + i
            pieces.append(self._piece(offset, length, crc, level, code, "a piece"))
        return split_pieces(pieces, len(self.header.tier_levels(tier)))

    def voxels_of(self, codes: np.ndarray) -> np.ndarray:
        """Codes as voxels of the type of the file."""
        header = self.header
        if header.is_exact:
            return self._exact().voxels(codes)
        if header.voxel_type != "float32":
            return codes.astype(header.voxel_type)
        most = float(np.finfo(np.float32).max)
        values = codes.astype(np.float64) * header.code_scale + header.code_offset
        return values.clip(-most, most).astype(np.float32) + np.float32(0)  # -0 becomes 0

    def slab_trailer(self, slab: int) -> SlabTrailer:
        """What ends a slab. Raises OctavoError "corrupt"."""
        header = self.header
        bricks_x, bricks_y, _ = header.bricks(0)
        depth = 1 << header.brick_shifts(0)[2]
        planes = min(depth, header.size[2] - slab * depth)
        data = self.read_bytes(*self._root.slab_trailers[slab])
        trailer = parse_slab_trailer(data, bricks_x * bricks_y, planes)
        model = self._root.model_number(0, slab, header.bricks(0)[2])
        require((trailer.build_id, trailer.slab, trailer.model) == (header.build_id, slab, model),
                "a slab trailer belongs to another slab")
        return trailer

    def _prove_trailer(self) -> bytes:
        """The voxel digest. Raises OctavoError."""
        header = self.header
        self._file.seek(0, os.SEEK_END)
        if self._file.tell() < header.file_length:
            raise OctavoError("truncated", f"{header.file_length} bytes are due, "
                                           f"{self._file.tell()} are there")
        require(self._file.tell() == header.file_length, "there is something behind the trailer")
        data = self.read_bytes(header.file_length - TRAILER_LENGTH, TRAILER_LENGTH)
        require(_u32(data, 92) == crc32c(data[:92]), "the trailer's checksum is wrong")
        require(data[:8] == _TRAILER_MAGIC, "the trailer begins as none does")
        require_known(not any(data[32:40]) and not any(data[72:92]), "something in the trailer")
        require(int.from_bytes(data[8:16], "little") == header.build_id
                and int.from_bytes(data[16:24], "little") == header.file_length
                and _u32(data, 24) == header.crc, "header and trailer disagree")
        self.body_crc = _u32(data, 28)
        return data[40:72]

    def _read_page(self, tier: int, layer: int, number: int) -> list[Brick]:
        page = self._root.pages[tier][layer][number]
        data = self.read_bytes(page.offset, page.length)
        require(crc32c(data) == page.crc, "the checksum of an index page is wrong")
        return parse_page(data, page, self.header)

    def _read_model(self, number: int) -> GreyModel | LabelModel:
        model = self._root.models[number]
        data = self._piece(model.offset, model.length, model.crc, _MODEL_LEVEL, number, "a model")
        if self.header.kind == "labels":
            return parse_label_model(data, self.header.voxel_type)
        model = parse_grey_model(data)
        require(not model.is_lossy or self.header.max_error > 0,
                "a model leaves out precision in a file without a max error")
        coarse = self._root.model_number(1, 0, self.header.bricks(0)[2])
        require(not model.is_lossy or self.header.tier_count == 1 or number != coarse,
                "a model leaves out precision of coarse levels")
        require(self.header.detail_level == 0 or not (model.is_lossy or model.cut_axes),
                "a model with a max error or parts, where details are left out")
        require(not self.header.is_exact or model.cut_axes == 0,
                "a model of exact floats cuts axes")
        return model

    def _section(self, section: Section, name: str) -> bytes:
        data = self.read_bytes(section.offset, section.length)
        require(crc32c(data) == section.crc, f"the checksum of the {name} is wrong")
        return data

    def _piece(self, offset: int, length: int, crc: int, level: int, code: int, name: str) -> bytes:
        data = self.read_bytes(offset, length)
        before = (self.header.build_id.to_bytes(8, "little") + bytes([level])
                  + code.to_bytes(8, "little"))
        require(crc32c(data, before) == crc, f"the checksum of {name} at {offset} is wrong")
        return data

    def read_bytes(self, offset: int, length: int) -> bytes:
        """Bytes of the file that nothing proves. Raises OctavoError "truncated"."""
        self._file.seek(offset)
        data = bytearray()
        while len(data) < length:
            part = self._file.read(min(length - len(data), max(_FIRST_PART, len(data))))
            if not part:
                raise OctavoError("truncated", f"{length} bytes are due at {offset}")
            data += part
        return bytes(data)


def _u32(data: bytes, at: int) -> int:
    return int.from_bytes(data[at : at + 4], "little")
