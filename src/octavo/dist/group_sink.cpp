#include "octavo/dist/group_sink.h"

#include <utility>

namespace octavo {

void GroupSink::expect(const RunStart& start) {
  const std::lock_guard lock(mutex_);
  expected_.push_back(start);
}

std::optional<EncodedGroup> GroupSink::take(std::chrono::milliseconds time) {
  std::unique_lock lock(mutex_);
  if (!changed_.wait_for(lock, time, [&] { return !whole_.empty(); })) return std::nullopt;
  EncodedGroup group = std::move(whole_.front());
  whole_.pop_front();
  return group;
}

void GroupSink::add_model(const Bytes& model) {
  RunStart start;
  {
    const std::lock_guard lock(mutex_);
    start = expected_.front();
    expected_.pop_front();
  }
  growing_ = std::make_unique<Growing>();
  growing_->streams = std::make_unique<Spool>(run_streams(levels_));
  growing_->run.emplace(header_, levels_, growing_->out, *growing_->streams, true, start);
  growing_->run->add_model(model);
}

void GroupSink::add_brick(int tier, const EncodedBrick& brick) {
  growing_->run->add_brick(tier, brick);
  if (header_.detail_level > 0) growing_->squared_errors.push_back(brick.squared_error);
}

void GroupSink::add_plane_digests(std::span<const Sha256Digest> digests) {
  growing_->run->add_plane_digests(digests);
}

void GroupSink::end_group(std::uint32_t voxels_crc) {
  EncodedGroup group;
  group.group = growing_->run->take_group(voxels_crc);
  group.level_0 = growing_->out.take();
  group.streams = std::move(growing_->streams);
  group.squared_errors = std::move(growing_->squared_errors);
  growing_.reset();
  const std::lock_guard lock(mutex_);
  whole_.push_back(std::move(group));
  changed_.notify_all();
}

}  // namespace octavo
