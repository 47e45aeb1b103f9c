#include "octavo/planes/slab_planes.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "octavo/core/error.h"

namespace octavo {

namespace {

std::size_t bytes_of_plane(const VolumeDescription& volume) {
  return static_cast<std::size_t>(volume.size.x * volume.size.y * bytes_per_voxel(volume.type));
}

}  // namespace

SlabPlanes::SlabPlanes(std::int64_t planes, std::int64_t count, std::string name)
    : planes_(planes), count_(count), name_(std::move(name)), cursor_(count) {}

std::uint64_t SlabPlanes::slab_bytes() const {
  return bytes_of_plane(description()) * static_cast<std::uint64_t>(std::min(planes_, count_));
}

void SlabPlanes::read_plane(std::span<std::byte> plane) {
  const std::size_t bytes = bytes_of_plane(description());
  if (plane.size() != bytes || cursor_.is_done()) {
    throw Error(ErrorKind::internal, "a plane of the wrong size or beyond the last was asked for",
                name_);
  }
  const std::int64_t z = cursor_.next();
  if (z < begin_ || z >= end_) {
    const std::int64_t begin = z - z % planes_;
    const std::int64_t end = std::min(begin + planes_, count_);
    end_ = begin_;  // nothing, should filling fail
    slab_.resize(static_cast<std::size_t>(end - begin) * bytes);
    fill_slab(begin, end, slab_);
    begin_ = begin;
    end_ = end;
  }
  std::memcpy(plane.data(), slab_.data() + static_cast<std::size_t>(z - begin_) * bytes, bytes);
  cursor_.take();
}

}  // namespace octavo
