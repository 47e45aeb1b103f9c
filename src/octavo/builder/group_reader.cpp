#include "octavo/builder/group_reader.h"

#include <algorithm>
#include <chrono>
#include <span>

#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"

namespace octavo {

namespace {

ByteSpan bytes_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
}

std::atomic<std::uint64_t> bytes_of_group = kGroupBytes;

}  // namespace

SmallGroups::SmallGroups(std::uint64_t bytes) { bytes_of_group = bytes; }

SmallGroups::~SmallGroups() { bytes_of_group = kGroupBytes; }

std::int64_t group_planes(const Levels& levels, VoxelType type) {
  const Size3& size = levels.size(0);
  const std::int64_t layer_planes = levels.brick_side(0).z;
  const auto layer_bytes =
      static_cast<std::uint64_t>(size.x * size.y * layer_planes * bytes_per_voxel(type));
  const std::uint64_t bytes = bytes_of_group;
  const auto layers = static_cast<std::int64_t>((bytes + layer_bytes - 1) / layer_bytes);
  return std::min(layers * layer_planes, size.z);
}

GroupReader::GroupReader(PlaneSource& source, const Levels& levels, Progress& progress,
                         const FloatPlanes* floats)
    : GroupReader(source, levels, progress, floats, 0, levels.size(0).z, 1, false) {}

GroupReader::GroupReader(PlaneSource& source, const Levels& levels, Progress& progress,
                         const FloatPlanes* floats, std::int64_t first, std::int64_t end,
                         std::int64_t step)
    : GroupReader(source, levels, progress, floats, first, end, step, true) {}

GroupReader::GroupReader(PlaneSource& source, const Levels& levels, Progress& progress,
                         const FloatPlanes* floats, std::int64_t first, std::int64_t end,
                         std::int64_t step, bool seeks)
    : source_(source),
      progress_(progress),
      floats_(floats),
      size_(levels.size(0)),
      type_(source.description().type),
      planes_per_group_(group_planes(levels, type_)),
      step_planes_(step * planes_per_group_),
      seeks_(seeks),
      first_plane_(first),
      next_plane_(first),
      end_plane_(end),
      thread_([this] { read_groups(); }) {}

GroupReader::~GroupReader() {
  is_stopped_ = true;
  {
    const std::lock_guard lock(mutex_);
    changed_.notify_all();
  }
  thread_.join();
}

VoxelBlock GroupReader::next(Workers& workers) {
  std::unique_lock lock(mutex_);
  workers.wait(changed_, lock, [&] { return read_ > taken_ || failure_ != nullptr; });
  if (read_ == taken_) std::rethrow_exception(failure_);
  Buffer& buffer = buffers_[taken_++ % buffers_.size()];
  VoxelBlock block{buffer.voxels.bytes().data(), type_, size_, next_plane_};
  if (floats_ != nullptr) block.floats = buffer.floats.data();
  block.size.z = end_of_group(next_plane_) - next_plane_;
  next_plane_ += step_planes_;
  block.crc = buffer.crc;
  return block;
}

void GroupReader::release() {
  const std::lock_guard lock(mutex_);
  ++released_;
  changed_.notify_all();
}

std::int64_t GroupReader::end_of_group(std::int64_t first) const {
  return std::min(first + planes_per_group_, end_plane_);
}

void GroupReader::read_groups() {
  const bool has_gaps = step_planes_ > planes_per_group_;
  try {
    if (seeks_ && !has_gaps) source_.seek(first_plane_, end_plane_);
    std::size_t group = 0;
    for (std::int64_t at = first_plane_; at < end_plane_; at += step_planes_, ++group) {
      if (!wait_for_room(group)) return;
      if (has_gaps) source_.seek(at, end_of_group(at));
      fill(buffers_[group % buffers_.size()], end_of_group(at) - at);
      const std::lock_guard lock(mutex_);
      read_ = group + 1;
      changed_.notify_all();
    }
  } catch (...) {
    const std::lock_guard lock(mutex_);
    failure_ = std::current_exception();
    changed_.notify_all();
  }
}

bool GroupReader::wait_for_room(std::size_t group) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return group < released_ + buffers_.size() || is_stopped_; });
  return !is_stopped_;
}

void GroupReader::fill(Buffer& buffer, std::int64_t planes) {
  const auto plane_bytes = static_cast<std::size_t>(size_.x * size_.y * bytes_per_voxel(type_));
  buffer.voxels.resize(static_cast<std::size_t>(planes) * plane_bytes);
  buffer.floats.clear();
  buffer.crc = 0;
  const auto start = std::chrono::steady_clock::now();
  for (std::size_t at = 0; at < buffer.voxels.size() && !is_stopped_; at += plane_bytes) {
    if (progress_.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped while reading planes");
    const auto voxels = buffer.voxels.bytes().subspan(at, plane_bytes);
    source_.read_plane(voxels);
    if (floats_ != nullptr) {
      const auto plane = floats_->voxels();
      buffer.floats.insert(buffer.floats.end(), plane.begin(), plane.end());
      buffer.crc = crc32c(bytes_of(std::as_bytes(plane)), buffer.crc);
    } else {
      buffer.crc = crc32c(bytes_of(voxels), buffer.crc);
    }
    progress_.advance(1);
  }
  read_seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace octavo
