#include "octavo/tasks/file_planes.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "octavo/core/error.h"
#include "octavo/file/parallel_read.h"

namespace octavo {

namespace {

/// The planes of a brick at a level inside its tier.
std::int64_t layer_planes(const Levels& levels, int level) {
  const int tier = Levels::tier_of(level);
  const int halvings =
      levels.halving_count(level, 2) - levels.halving_count(Levels::first_level(tier), 2);
  return std::max<std::int64_t>(levels.brick_side(tier).z >> halvings, 1);
}

}  // namespace

FilePlanes::FilePlanes(std::shared_ptr<const FileReader> reader, int level, int threads,
                       bool keep_identity)
    : reader_(std::move(reader)),
      level_(level),
      threads_(threads),
      description_(reader_->description()),
      files_(files_of_volume({reader_->source().name()})),
      layer_planes_(layer_planes(reader_->levels(), level)) {
  const double slope = std::abs(description_.rescale.slope);
  description_.metadata =
      description_.metadata.for_copy(reader_->achieved_error() * slope, keep_identity);
  description_.size = reader_->levels().size(level);
  cursor_ = PlaneCursor(description_.size.z);
  description_.geometry = reader_->levels().geometry(reader_->description().geometry, level);
}

std::uint64_t FilePlanes::resident_bytes() const {
  const Size3& size = description_.size;
  return static_cast<std::uint64_t>(size.x * size.y * std::min(layer_planes_, size.z) *
                                    bytes_per_voxel(description_.type));
}

void FilePlanes::read_plane(std::span<std::byte> plane) {
  const Size3& size = description_.size;
  const auto bytes = static_cast<std::size_t>(size.x * size.y * bytes_per_voxel(description_.type));
  if (plane.size() != bytes || cursor_.is_done()) {
    throw Error(ErrorKind::internal, "a plane of the wrong size or beyond the last was asked for",
                reader_->source().name());
  }
  const std::int64_t z = cursor_.next();
  if (z < layer_z_ || z >= layer_end_) read_layer_of(z);
  const auto at = static_cast<std::size_t>(z - layer_z_) * bytes;
  std::memcpy(plane.data(), layer_.data() + at, bytes);
  cursor_.take();
}

void FilePlanes::read_layer_of(std::int64_t z) {
  const Size3& size = description_.size;
  layer_z_ = z - z % layer_planes_;
  layer_end_ = std::min(layer_z_ + layer_planes_, size.z);
  layer_.resize(static_cast<std::size_t>(size.x * size.y * (layer_end_ - layer_z_) *
                                         bytes_per_voxel(description_.type)));
  const Box layer = {{0, 0, layer_z_}, {size.x, size.y, layer_end_}};
  read_parallel(*reader_, layer, level_, layer_.data(), threads_);
}

}  // namespace octavo
