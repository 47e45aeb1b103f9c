#include "octavo/builder/layer_sorter.h"

#include <utility>

#include "octavo/core/error.h"
#include "octavo/file/layer_order.h"

namespace octavo {

namespace {

constexpr std::size_t kHeldBackBytes = std::size_t{8} << 20;

}  // namespace

void LayerSorter::add_brick(int tier, const EncodedBrick& brick) {
  if (tier != 0) throw Error(ErrorKind::internal, "a brick above tier 0 among those of a layer");
  if (held_.empty()) {
    const Size3 grid = levels_.brick_grid(0);
    held_.reserve(static_cast<std::size_t>(grid.x * grid.y));
  }
  Held held{{brick.range, brick.parent, brick.max_error, {}, {}, brick.squared_error},
            {},
            written_ + tail_.size()};
  for (const Bytes& segment : brick.segments) {
    held.lengths.push_back(segment.size());
    tail_.insert(tail_.end(), segment.begin(), segment.end());
  }
  held_.push_back(std::move(held));
  if (tail_.size() >= kHeldBackBytes) write_held_back();
}

void LayerSorter::write_held_back() {
  if (!scratch_) scratch_ = storage_.create_scratch(folder_);
  scratch_->write(written_, tail_);
  written_ += tail_.size();
  tail_.clear();
}

void LayerSorter::end_layer(std::span<const Sha256Digest> digests) {
  const Size3 grid = levels_.brick_grid(0);
  if (held_.size() != static_cast<std::size_t>(grid.x * grid.y)) {
    throw Error(ErrorKind::internal, "a layer ends before its last brick");
  }
  write_held_back();
  std::size_t left = held_.size();
  for (const Index3& at : layer_order(grid)) {
    if (progress_.is_cancelled()) {
      throw Error(ErrorKind::cancelled, "stopped while sorting bricks");
    }
    Held& held = held_[static_cast<std::size_t>(at.y * grid.x + at.x)];
    std::uint64_t offset = held.offset;
    for (const std::size_t length : held.lengths) {
      Bytes& segment = held.brick.segments.emplace_back(length);
      if (length > 0) scratch_->read(offset, segment);
      offset += length;
    }
    if (--left == 0) sink_.add_plane_digests(digests);
    sink_.add_brick(0, held.brick);
    held.brick.segments = {};
  }
  held_.clear();
  written_ = 0;
  if (group_crc_) sink_.end_group(*std::exchange(group_crc_, std::nullopt));
}

}  // namespace octavo
