#include "octavo/builder/float_trial.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "octavo/codec/brick_codec.h"

namespace octavo {

namespace {

constexpr std::int64_t kTrialSide = 32;
constexpr std::int64_t kMostBoxes = 8;
/// What few values take must be so much less: planes yet to come may hold more of them.
constexpr double kWorthwhile = 0.95;

/// Boxes spread evenly along the diagonal of the stack, one after another, dense [z][y][x].
std::vector<float> boxes_of(const TrialStack& stack, const Size3& side, std::int64_t count) {
  const auto planes = static_cast<std::int64_t>(stack.planes.count());
  const auto first = [&](std::int64_t i, std::int64_t size, std::int64_t length) {
    return (size - length) * (2 * i + 1) / (2 * count);
  };
  std::vector<float> voxels(static_cast<std::size_t>(side.voxel_count() * count));
  const auto fill = [&](std::span<const float> plane, std::int64_t i, std::int64_t k) {
    // Along another diagonal of the plane every other time
    const std::int64_t y = first(i % 2 == 0 ? i : count - 1 - i, stack.y, side.y);
    const std::int64_t x = first(i, stack.x, side.x);
    auto out = voxels.begin() + i * side.voxel_count() + k * side.x * side.y;
    for (std::int64_t j = 0; j < side.y; ++j) {
      const auto row = plane.begin() + (plane.size() == 1 ? 0 : (y + j) * stack.x + x);
      out = plane.size() == 1 ? std::fill_n(out, side.x, *row) : std::copy_n(row, side.x, out);
    }
  };
  // Each plane is looked at once.
  for (std::int64_t z = 0; z < planes; ++z) {
    std::span<const float> plane;
    for (std::int64_t i = 0; i < count; ++i) {
      const std::int64_t k = z - first(i, planes, side.z);
      if (k < 0 || k >= side.z) continue;
      if (plane.empty()) plane = stack.planes.plane(static_cast<std::size_t>(z));
      fill(plane, i, k);
    }
  }
  return voxels;
}

/// Boxes as bricks of their own.
std::vector<TrainingBrick> bricks_of(const void* voxels, VoxelType type, const Size3& side,
                                     std::int64_t count) {
  const Levels levels(side, choose_halvings(side, {1, 1, 1}));
  const BrickShape shape = brick_shape(levels, 0, {0, 0, 0});
  const auto* first = static_cast<const std::byte*>(voxels);
  std::vector<TrainingBrick> bricks;
  for (std::int64_t i = 0; i < count; ++i, first += side.voxel_count() * bytes_per_voxel(type)) {
    bricks.push_back({shape, {first, type, side, side.x, side.x * side.y}});
  }
  return bricks;
}

std::size_t bytes_of(const BrickCodec& codec, const std::vector<TrainingBrick>& bricks) {
  std::size_t bytes = 0;
  for (const TrainingBrick& brick : bricks) {
    for (const Bytes& segment : codec.encode(brick.shape, brick.view).segments) {
      bytes += segment.size();
    }
  }
  return bytes;
}

/// Boxes of a stack, and how many and large they are.
struct TrialBoxes {
  Size3 side;
  std::int64_t count = 0;
  std::vector<float> voxels;
};

TrialBoxes trial_boxes(const TrialStack& stack) {
  const auto planes = static_cast<std::int64_t>(stack.planes.count());
  TrialBoxes boxes;
  boxes.side = {std::min(stack.x, kTrialSide), std::min(stack.y, kTrialSide),
                std::min(planes, kTrialSide)};
  boxes.count = std::clamp<std::int64_t>(
      stack.x * stack.y * planes / boxes.side.voxel_count(), 1, kMostBoxes);
  boxes.voxels = boxes_of(stack, boxes.side, boxes.count);
  return boxes;
}

CodecSettings trial_settings() {
  CodecSettings settings;
  settings.preset = Preset::fast;
  settings.access = Access::none;
  return settings;
}

std::size_t exact_bytes(const TrialBoxes& boxes, const SampleCoding& coding) {
  const auto bricks =
      bricks_of(boxes.voxels.data(), VoxelType::float32, boxes.side, boxes.count);
  return bytes_of(*train_exact_model(bricks, trial_settings(), coding), bricks);
}

bool is_clearly_less(std::size_t bytes, std::size_t than) {
  return static_cast<double>(bytes) < kWorthwhile * static_cast<double>(than);
}

}  // namespace

bool is_smaller_coding(const TrialStack& stack, const SampleCoding& one,
                       const SampleCoding& other) {
  const TrialBoxes boxes = trial_boxes(stack);
  return is_clearly_less(exact_bytes(boxes, one), exact_bytes(boxes, other));
}

bool is_smaller_exact(const TrialStack& stack, const SampleCoding& exact,
                      const SampleCoding& within, std::int64_t codec_error) {
  const TrialBoxes boxes = trial_boxes(stack);
  std::vector<std::int32_t> codes;
  codes.reserve(boxes.voxels.size());
  for (const float voxel : boxes.voxels) {
    const double steps = (static_cast<double>(voxel) - within.offset) / within.scale;
    codes.push_back(static_cast<std::int32_t>(std::nearbyint(steps)));
  }
  CodecSettings settings = trial_settings();
  settings.max_error = codec_error;
  const auto rounded = bricks_of(codes.data(), VoxelType::int32, boxes.side, boxes.count);
  const std::size_t rounded_bytes = bytes_of(
      *train_model(VolumeKind::grey, VoxelType::int32, rounded, settings), rounded);
  return is_clearly_less(exact_bytes(boxes, exact), rounded_bytes);
}

}  // namespace octavo
