#include "octavo/build/group_reader.h"

#include <algorithm>
#include <chrono>
#include <span>
#include <utility>

#include "octavo/core/error.h"

namespace octavo {

std::int64_t group_planes(const Levels& levels, VoxelType type) {
  const Size3& size = levels.size(0);
  const std::int64_t layer_planes = levels.brick_side(0).z;
  const auto layer_bytes =
      static_cast<std::uint64_t>(size.x * size.y * layer_planes * bytes_per_voxel(type));
  const auto layers = static_cast<std::int64_t>((kGroupBytes + layer_bytes - 1) / layer_bytes);
  return std::min(layers * layer_planes, size.z);
}

GroupReader::GroupReader(PlaneSource& source, const Levels& levels, Progress& progress,
                         const FloatPlanes* floats)
    : source_(source),
      progress_(progress),
      floats_(floats),
      size_(levels.size(0)),
      type_(source.description().type),
      planes_per_group_(group_planes(levels, type_)) {
  start(0);
}

GroupReader::~GroupReader() {
  is_stopped_ = true;
  if (reading_.valid()) reading_.wait();
}

VoxelBlock GroupReader::next() {
  reading_.get();
  std::swap(taken_, filling_);
  VoxelBlock block{taken_.voxels.data(), type_, size_, next_plane_};
  if (floats_ != nullptr) block.floats = taken_.floats.data();
  next_plane_ = std::min(next_plane_ + planes_per_group_, size_.z);
  block.size.z = next_plane_ - block.first_plane;
  if (!is_done()) start(next_plane_);
  return block;
}

void GroupReader::start(std::int64_t first_plane) {
  const std::int64_t end = std::min(first_plane + planes_per_group_, size_.z);
  reading_ = std::async(std::launch::async, [this, first_plane, end] { read(first_plane, end); });
}

void GroupReader::read(std::int64_t first_plane, std::int64_t end) {
  const auto plane_bytes = static_cast<std::size_t>(size_.x * size_.y * bytes_per_voxel(type_));
  filling_.voxels.resize(static_cast<std::size_t>(end - first_plane) * plane_bytes);
  filling_.floats.clear();
  const auto start = std::chrono::steady_clock::now();
  for (std::size_t at = 0; at < filling_.voxels.size() && !is_stopped_; at += plane_bytes) {
    if (progress_.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped while reading planes");
    source_.read_plane(std::span(filling_.voxels).subspan(at, plane_bytes));
    if (floats_ != nullptr) {
      const auto plane = floats_->voxels();
      filling_.floats.insert(filling_.floats.end(), plane.begin(), plane.end());
    }
    progress_.advance(1);
  }
  read_seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace octavo
