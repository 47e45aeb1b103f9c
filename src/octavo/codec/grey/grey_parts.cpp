#include "octavo/codec/grey/grey_parts.h"

#include <algorithm>

#include "octavo/codec/entropy/byte_io.h"
#include "octavo/core/crc32c.h"

namespace octavo::grey {

namespace {

constexpr std::size_t kCrcBytes = 4;
/// More than any segment may have: sums of lengths do not overflow.
constexpr std::uint64_t kMaxPartBytes = std::uint64_t{1} << 32;

/// Along an axis that is not cut all is one part.
std::int64_t part_side(const Size3& size, std::uint8_t cut_axes, int axis) {
  return (cut_axes >> axis & 1) != 0 ? kPartSide : size[axis];
}

}  // namespace

std::int64_t part_count(const BrickShape& shape, std::uint8_t cut_axes) {
  // A brick of fewer levels is not wider than 32 in any file.
  if (shape.level_count < 3) return 1;
  std::int64_t count = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t side = part_side(shape.size[0], cut_axes, axis);
    count *= (shape.size[0][axis] + side - 1) / side;
  }
  return count;
}

std::vector<Part> parts_of(const BrickShape& shape, std::uint8_t cut_axes) {
  if (!has_parts(shape, cut_axes)) return {{shape, {}, {}, kAllFaces}};
  const Size3& size = shape.size[0];
  Size3 side;
  for (int axis = 0; axis < 3; ++axis) side[axis] = part_side(size, cut_axes, axis);
  std::vector<Part> parts;
  visit_cells(box_of(size), side, [&](const Index3& cell) {
    Part& part = parts.emplace_back(Part{shape, {}, {}, 0});
    for (int axis = 0; axis < 3; ++axis) {
      const int half = shape.halving[0] >> axis & 1;
      const std::int64_t at = cell[axis] * side[axis];
      const std::int64_t length = std::min(side[axis], size[axis] - at);
      part.at[axis] = at;
      part.coarse_at[axis] = at >> half;
      part.shape.size[0][axis] = length;
      part.shape.size[1][axis] = (length + half) >> half;
      const bool is_at_end = at + length == size[axis];
      if (!is_at_end) part.shape.weights.last[axis] = shape.weights.each[axis];
      part.outer |= ((at == 0 ? 1u : 0u) | (is_at_end ? 2u : 0u)) << 2 * axis;
    }
    return true;
  });
  return parts;
}

Box own_box(const Part& part, const AxisOrder& order) {
  Box box;
  for (int place = 0; place < 3; ++place) {
    const int axis = order[static_cast<std::size_t>(place)];
    box.lo[axis] = part.at[place];
    box.hi[axis] = part.at[place] + part.shape.size[0][place];
  }
  return box;
}

UniformCells cells_of(const Part& part, const UniformCells& cells) {
  UniformCells own;
  Index3 at;
  for (int axis = 0; axis < 3; ++axis) {
    const int half = part.shape.halving[1] >> axis & 1;
    at[axis] = part.coarse_at[axis] >> half;
    own.size[axis] = (part.shape.size[1][axis] + half) >> half;
  }
  for (std::int64_t z = 0; z < own.size.z; ++z) {
    for (std::int64_t y = 0; y < own.size.y; ++y) {
      const auto* const row =
          cells.flags.data() + ((z + at.z) * cells.size.y + y + at.y) * cells.size.x + at.x;
      own.flags.insert(own.flags.end(), row, row + own.size.x);
    }
  }
  const auto is_flagged = [](std::uint8_t flag) { return flag != 0; };
  if (std::none_of(own.flags.begin(), own.flags.end(), is_flagged)) own.flags.clear();
  return own;
}

PartBytes PartBytes::of(ByteSpan bytes) { return {bytes.size(), crc32c(bytes)}; }

void put_part_list(Bytes& out, const std::vector<PartBytes>& entries) {
  for (const PartBytes& entry : entries) {
    put_varint(out, entry.length);
    if (entry.length == 0) continue;
    for (std::size_t i = 0; i < kCrcBytes; ++i) {
      out.push_back(static_cast<std::uint8_t>(entry.crc >> 8 * i));
    }
  }
}

std::vector<PartBytes> take_part_list(ByteSpan& bytes, std::size_t count) {
  std::vector<PartBytes> entries(count);
  for (PartBytes& entry : entries) {
    entry.length = take_varint(bytes);
    if (entry.length == 0) continue;
    const ByteSpan crc = take_bytes(bytes, kCrcBytes);
    for (std::size_t i = 0; i < kCrcBytes; ++i) {
      entry.crc |= static_cast<std::uint32_t>(crc[i]) << 8 * i;
    }
  }
  return entries;
}

std::vector<BrickParts::Part> placed_parts(const std::vector<Part>& parts,
                                           const std::vector<PartBytes>& entries,
                                           const AxisOrder& order) {
  std::vector<BrickParts::Part> placed;
  std::uint64_t offset = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (entries[i].length > kMaxPartBytes) throw Error(ErrorKind::corrupt, "a part is too long");
    placed.push_back({own_box(parts[i], order), offset, entries[i].length});
    offset += entries[i].length;
  }
  return placed;
}

template <class Sample>
CoarseSamples<Sample>::CoarseSamples(SampleGrid<Sample>& grid)
    : row_(grid.size().x + 2 * kX), rows_(grid.size().y + 2 * kYZ) {
  grid.fill_margins();
  const Size3& size = grid.size();
  // All of them are written below.
  const auto count = static_cast<std::size_t>(row_ * rows_ * (size.z + 2 * kYZ));
  bytes_.hold(count * sizeof(Sample));
  samples_ = reinterpret_cast<Sample*>(bytes_->data());
  for (std::int64_t z = -kYZ; z < size.z + kYZ; ++z) {
    for (std::int64_t y = -kYZ; y < size.y + kYZ; ++y) {
      std::copy_n(grid.row(y, z) - kX, row_, samples_ + place(-kX, y, z));
    }
  }
}

template <class Sample>
void CoarseSamples<Sample>::put(const Part& part, SampleGrid<Sample>& grid) const {
  const Size3& size = part.shape.size[1];
  const Index3& at = part.coarse_at;
  grid.set_size(size);
  for (std::int64_t z = -kYZ; z < size.z + kYZ; ++z) {
    for (std::int64_t y = -kYZ; y < size.y + kYZ; ++y) {
      std::copy_n(samples_ + place(at.x - kX, y + at.y, z + at.z), size.x + 2 * kX,
                  grid.row(y, z) - kX);
    }
  }
}

template class CoarseSamples<std::int16_t>;
template class CoarseSamples<std::int32_t>;

}  // namespace octavo::grey
