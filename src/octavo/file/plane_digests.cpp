#include "octavo/file/plane_digests.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "octavo/core/sha256.h"

namespace octavo {

namespace {

constexpr std::int64_t kRowsBytes = std::int64_t{64} << 20;

}  // namespace

Sha256Digest voxel_digest_of(std::span<const Sha256Digest> planes) {
  Sha256 hasher;
  for (const Sha256Digest& plane : planes) hasher.add(plane);
  return hasher.digest();
}

PlaneDigests::PlaneDigests(const VolumeDescription& description, const Levels& levels,
                           MakeHasher make_hasher)
    : description_(description),
      levels_(levels),
      make_hasher_(std::move(make_hasher)),
      voxel_bytes_(static_cast<std::size_t>(bytes_per_voxel(description.type))) {
  const Size3 side = levels.brick_side(0);
  const std::int64_t row_bytes = std::min(side.z, description.size.z) * side.y *
                                 description.size.x * static_cast<std::int64_t>(voxel_bytes_);
  rows_at_once_ = std::max(std::int64_t{1}, kRowsBytes / row_bytes);
}

void PlaneDigests::begin_layer(std::int64_t layer) {
  layer_number_ = layer;
  next_row_ = 0;
  make_room();
  while (static_cast<std::int64_t>(hashers_.size()) < room_.size().z) {
    hashers_.push_back(make_hasher_());
  }
}

Box PlaneDigests::next_rows() const {
  const Size3 grid = levels_.brick_grid(0);
  const std::int64_t end = std::min(next_row_ + rows_at_once_, grid.y);
  return {{0, next_row_, layer_number_}, {grid.x, end, layer_number_ + 1}};
}

void PlaneDigests::make_room() {
  const Box rows = next_rows();
  if (rows.is_empty()) return;
  const Index3 last{rows.hi.x - 1, rows.hi.y - 1, rows.lo.z};
  room_ = {levels_.brick_box(0, rows.lo).lo, levels_.brick_box(0, last).hi};
  rows_.resize(static_cast<std::size_t>(room_.size().voxel_count()) * voxel_bytes_);
}

std::uint8_t* PlaneDigests::row_at(const Box& brick, std::int64_t y, std::int64_t z) {
  const Size3 size = room_.size();
  const std::int64_t row =
      (brick.lo.z + z - room_.lo.z) * size.y + brick.lo.y + y - room_.lo.y;
  return rows_.data() + static_cast<std::size_t>(row * size.x + brick.lo.x) * voxel_bytes_;
}

void PlaneDigests::put(const Index3& brick, const void* codes) {
  const Box box = levels_.brick_box(0, brick);
  const Size3 size = box.size();
  const auto count = static_cast<std::size_t>(size.voxel_count());
  const auto* from = static_cast<const std::uint8_t*>(codes);
  std::vector<float> voxels;
  if (description_.coding) {
    voxels.resize(count);
    decode_samples(*description_.coding, codes, voxels);
    from = reinterpret_cast<const std::uint8_t*>(voxels.data());
  }
  const std::size_t row_bytes = static_cast<std::size_t>(size.x) * voxel_bytes_;
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y, from += row_bytes) {
      std::memcpy(row_at(box, y, z), from, row_bytes);
    }
  }
}

void PlaneDigests::put_uniform(const Index3& brick, std::int64_t code) {
  const Box box = levels_.brick_box(0, brick);
  const Size3 size = box.size();
  with_voxel_type(description_.type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    const std::vector<T> row(static_cast<std::size_t>(size.x),
                             static_cast<T>(description_.voxel_of(code)));
    for (std::int64_t z = 0; z < size.z; ++z) {
      for (std::int64_t y = 0; y < size.y; ++y) {
        std::memcpy(row_at(box, y, z), row.data(), row.size() * sizeof(T));
      }
    }
  });
}

void PlaneDigests::add_rows(const ForEach& for_each) {
  const std::int64_t planes = room_.size().z;
  const std::size_t plane_bytes = rows_.size() / static_cast<std::size_t>(planes);
  for_each(planes, [&](std::int64_t z) {
    const auto plane = static_cast<std::size_t>(z);
    hashers_[plane]->add(ByteSpan(rows_).subspan(plane * plane_bytes, plane_bytes));
  });
  next_row_ = next_rows().hi.y;
  make_room();
}

std::vector<Sha256Digest> PlaneDigests::digests() {
  std::vector<Sha256Digest> all(static_cast<std::size_t>(room_.size().z));
  for (std::size_t z = 0; z < all.size(); ++z) all[z] = hashers_[z]->digest();
  return all;
}

}  // namespace octavo
