#include "octavo/file/plane_digests.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "octavo/core/sha256.h"

namespace octavo {

Sha256Digest voxel_digest_of(std::span<const Sha256Digest> planes) {
  Sha256 hasher;
  for (const Sha256Digest& plane : planes) hasher.add(plane);
  return hasher.digest();
}

PlaneDigests::PlaneDigests(const VolumeDescription& description, const Levels& levels,
                           MakeHasher make_hasher, std::int64_t rows_bytes)
    : description_(description),
      levels_(levels),
      make_hasher_(std::move(make_hasher)),
      voxel_bytes_(static_cast<std::size_t>(bytes_per_voxel(description.type))) {
  const Size3& size = description.size;
  const Size3 side = levels.brick_side(0);
  // As many rows of bricks as fit, else as many of their planes, else as many rows of one plane
  const std::int64_t row = size.x * static_cast<std::int64_t>(voxel_bytes_);
  const std::int64_t rows = std::max(std::int64_t{1}, rows_bytes / row);
  const std::int64_t depth = std::min(side.z, size.z);
  share_ = {size.x, std::min(rows, side.y), std::clamp(rows / side.y, std::int64_t{1}, depth)};
  if (rows / side.y >= depth) share_.y = rows / depth / side.y * side.y;
}

void PlaneDigests::begin_layer(std::int64_t layer) {
  layer_ = levels_.brick_box(0, {0, 0, layer});
  layer_.hi.x = description_.size.x;
  layer_.hi.y = description_.size.y;
  while (static_cast<std::int64_t>(hashers_.size()) < layer_.size().z) {
    hashers_.push_back(make_hasher_());
  }
  begin_share(layer_.lo);
}

void PlaneDigests::begin_share(const Index3& lo) {
  const Index3 hi{lo.x + share_.x, lo.y + share_.y, lo.z + share_.z};
  room_ = intersection(layer_, {lo, hi});
  if (room_.is_empty()) return;
  rows_.resize(static_cast<std::size_t>(room_.size().voxel_count()) * voxel_bytes_);
}

Box PlaneDigests::next_bricks() const {
  if (room_.is_empty()) return {};
  const Size3 side = levels_.brick_side(0);
  const std::int64_t layer = layer_.lo.z / side.z;
  return {{0, room_.lo.y / side.y, layer},
          {levels_.brick_grid(0).x, (room_.hi.y - 1) / side.y + 1, layer + 1}};
}

std::uint8_t* PlaneDigests::row_at(std::int64_t x, std::int64_t y, std::int64_t z) {
  const Size3 size = room_.size();
  const std::int64_t row = (z - room_.lo.z) * size.y + y - room_.lo.y;
  return rows_.data() + static_cast<std::size_t>(row * size.x + x) * voxel_bytes_;
}

void PlaneDigests::put(const Index3& brick, const void* decoded) {
  const Box box = levels_.brick_box(0, brick);
  const Box part = intersection(box, room_);
  const auto* voxels = static_cast<const std::uint8_t*>(decoded);
  std::vector<float> floats;
  if (description_.coding && !description_.coding->is_exact) {
    floats.resize(static_cast<std::size_t>(box.size().voxel_count()));
    decode_samples(*description_.coding, decoded, floats);
    voxels = reinterpret_cast<const std::uint8_t*>(floats.data());
  }
  const std::size_t row_bytes = static_cast<std::size_t>(box.size().x) * voxel_bytes_;
  for (std::int64_t z = part.lo.z; z < part.hi.z; ++z) {
    for (std::int64_t y = part.lo.y; y < part.hi.y; ++y) {
      const auto row =
          static_cast<std::size_t>((z - box.lo.z) * box.size().y + y - box.lo.y);
      std::memcpy(row_at(box.lo.x, y, z), voxels + row * row_bytes, row_bytes);
    }
  }
}

void PlaneDigests::put_uniform(const Index3& brick, std::int64_t code) {
  const Box part = intersection(levels_.brick_box(0, brick), room_);
  with_voxel_type(description_.type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    const std::vector<T> row(static_cast<std::size_t>(part.size().x),
                             static_cast<T>(description_.voxel_of(code)));
    for (std::int64_t z = part.lo.z; z < part.hi.z; ++z) {
      for (std::int64_t y = part.lo.y; y < part.hi.y; ++y) {
        std::memcpy(row_at(part.lo.x, y, z), row.data(), row.size() * sizeof(T));
      }
    }
  });
}

void PlaneDigests::add_rows(const ForEach& for_each) {
  const std::int64_t planes = room_.size().z;
  const std::size_t plane_bytes = rows_.size() / static_cast<std::size_t>(planes);
  for_each(planes, [&](std::int64_t z) {
    const auto plane = static_cast<std::size_t>(z);
    hashers_[static_cast<std::size_t>(room_.lo.z - layer_.lo.z) + plane]->add(
        ByteSpan(rows_).subspan(plane * plane_bytes, plane_bytes));
  });
  // On along y, then along z
  const bool has_rows = room_.hi.y < layer_.hi.y;
  begin_share(has_rows ? Index3{0, room_.hi.y, room_.lo.z}
                       : Index3{0, layer_.lo.y, room_.hi.z});
}

std::vector<Sha256Digest> PlaneDigests::digests() {
  std::vector<Sha256Digest> all(static_cast<std::size_t>(layer_.size().z));
  for (std::size_t z = 0; z < all.size(); ++z) all[z] = hashers_[z]->digest();
  return all;
}

}  // namespace octavo
