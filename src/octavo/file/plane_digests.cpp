#include "octavo/file/plane_digests.h"

#include <algorithm>
#include <cstring>
#include <numeric>
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
  hashed_as_.resize(hashers_.size());
  std::iota(hashed_as_.begin(), hashed_as_.end(), 0);
  begin_share(layer_.lo);
}

bool PlaneDigests::Share::is_uniform() const {
  return std::all_of(codes.begin(), codes.end(), [](const auto& code) { return code.has_value(); });
}

void PlaneDigests::begin_share(const Index3& lo) {
  const Index3 hi{lo.x + share_.x, lo.y + share_.y, lo.z + share_.z};
  now_ = {intersection(layer_, {lo, hi}), {}};
  if (lo.y == layer_.lo.y) {
    alike_.clear();
    are_alike_ = true;
  }
  if (now_.room.is_empty()) return;
  rows_.resize(static_cast<std::size_t>(now_.room.size().voxel_count()) * voxel_bytes_);
  now_.codes.resize(static_cast<std::size_t>(next_bricks().size().voxel_count()));
}

Box PlaneDigests::next_bricks() const { return bricks_of(now_.room); }

Box PlaneDigests::bricks_of(const Box& room) const {
  if (room.is_empty()) return {};
  const Size3 side = levels_.brick_side(0);
  const std::int64_t layer = layer_.lo.z / side.z;
  return {{0, room.lo.y / side.y, layer},
          {levels_.brick_grid(0).x, (room.hi.y - 1) / side.y + 1, layer + 1}};
}

std::uint8_t* PlaneDigests::row_at(std::int64_t x, std::int64_t y, std::int64_t z) {
  const Size3 size = now_.room.size();
  const std::int64_t row = (z - now_.room.lo.z) * size.y + y - now_.room.lo.y;
  return rows_.data() + static_cast<std::size_t>(row * size.x + x) * voxel_bytes_;
}

Hasher& PlaneDigests::hasher_of(std::int64_t z) {
  return *hashers_[static_cast<std::size_t>(z - layer_.lo.z)];
}

void PlaneDigests::put(const Index3& brick, const void* decoded) {
  const Box box = levels_.brick_box(0, brick);
  const Box part = intersection(box, now_.room);
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
  const Box bricks = next_bricks();
  const std::int64_t row = (brick.y - bricks.lo.y) * bricks.size().x;
  now_.codes[static_cast<std::size_t>(row + brick.x)] = code;
}

// The voxels of uniform bricks in a plane of a share.
void PlaneDigests::fill_uniform(const Share& share, std::uint8_t* plane) const {
  const Box& room = share.room;
  const Box bricks = bricks_of(room);
  for (std::size_t i = 0; i < share.codes.size(); ++i) {
    if (!share.codes[i]) continue;
    const auto place = static_cast<std::int64_t>(i);
    const Index3 brick{place % bricks.size().x, bricks.lo.y + place / bricks.size().x,
                       bricks.lo.z};
    const Box part = intersection(levels_.brick_box(0, brick), room);
    with_voxel_type(description_.type, [&](auto tag) {
      using T = typename decltype(tag)::type;
      const std::vector<T> row(static_cast<std::size_t>(part.size().x),
                               static_cast<T>(description_.voxel_of(*share.codes[i])));
      for (std::int64_t y = part.lo.y; y < part.hi.y; ++y) {
        const auto at = static_cast<std::size_t>((y - room.lo.y) * room.size().x + part.lo.x);
        std::memcpy(plane + at * sizeof(T), row.data(), row.size() * sizeof(T));
      }
    });
  }
}

// The other planes get what the first one had alone.
void PlaneDigests::part_planes(const ForEach& for_each) {
  are_alike_ = false;
  for (const Share& share : alike_) {
    Bytes plane(static_cast<std::size_t>(share.room.size().x * share.room.size().y) *
                voxel_bytes_);
    fill_uniform(share, plane.data());
    for_each(share.room.size().z - 1, [&](std::int64_t i) {
      hasher_of(share.room.lo.z + 1 + i).add(plane);
    });
  }
  alike_.clear();
}

void PlaneDigests::add_rows(const ForEach& for_each) {
  const Box room = now_.room;
  const std::int64_t planes = room.size().z;
  const std::size_t plane_bytes = rows_.size() / static_cast<std::size_t>(planes);
  const auto add_plane = [&](std::int64_t z) {
    const std::size_t first = static_cast<std::size_t>(z) * plane_bytes;
    fill_uniform(now_, rows_.data() + first);
    hasher_of(room.lo.z + z).add(ByteSpan(rows_).subspan(first, plane_bytes));
  };
  if (are_alike_ && now_.is_uniform()) {
    add_plane(0);
    alike_.push_back(std::move(now_));
  } else {
    if (are_alike_) part_planes(for_each);
    for_each(planes, add_plane);
  }
  // On along y, then along z
  const bool has_rows = room.hi.y < layer_.hi.y;
  if (!has_rows && are_alike_) {
    const auto first = hashed_as_.begin() + (room.lo.z - layer_.lo.z);
    std::fill(first, first + planes, room.lo.z - layer_.lo.z);
  }
  begin_share(has_rows ? Index3{0, room.hi.y, room.lo.z} : Index3{0, layer_.lo.y, room.hi.z});
}

std::vector<Sha256Digest> PlaneDigests::digests() {
  std::vector<Sha256Digest> all(static_cast<std::size_t>(layer_.size().z));
  for (std::size_t z = 0; z < all.size(); ++z) {
    const auto hashed = static_cast<std::size_t>(hashed_as_[z]);
    all[z] = hashed < z ? all[hashed] : hashers_[z]->digest();
  }
  return all;
}

}  // namespace octavo
