// Bricks of labels for the tests of the label codec.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

#include "octavo/codec/brick_codec.h"

namespace octavo::testing {

using LabelTypes = ::testing::Types<std::int8_t, std::uint8_t, std::int16_t, std::uint16_t,
                                    std::int32_t, std::uint32_t>;

/// One brick with dense voxels of type T.
template <class T>
struct LabelBrick {
  Levels levels;
  BrickShape shape;
  std::vector<T> voxels;

  explicit LabelBrick(const Size3& size, const Point3& spacing = {1, 1, 1})
      : levels(size, choose_halvings(size, spacing)),
        shape(brick_shape(levels, 0, {0, 0, 0})),
        voxels(static_cast<std::size_t>(size.voxel_count())) {}

  BrickView view() const {
    const Size3& size = shape.size[0];
    return {voxels.data(), voxel_type_of<T>(), size, size.x, size.x * size.y};
  }
  TrainingBrick training() const { return {shape, view()}; }
};

/// Nested balls, so that every octant kind occurs.
template <class T>
LabelBrick<T> balls(const Size3& size, const std::vector<T>& labels,
                    const Point3& spacing = {1, 1, 1}) {
  LabelBrick<T> sample(size, spacing);
  std::size_t at = 0;
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y) {
      for (std::int64_t x = 0; x < size.x; ++x) {
        const std::int64_t r2 = (x - 20) * (x - 20) + (y - 25) * (y - 25) + (z - 15) * (z - 15);
        const auto shell = static_cast<std::size_t>(r2 / 200);
        sample.voxels[at++] = labels[std::min(shell, labels.size() - 1)];
      }
    }
  }
  return sample;
}

/// White noise of `count` neighboring values, of all that T has when 0.
template <class T>
LabelBrick<T> noise(const Size3& size, std::uint64_t seed, std::uint64_t count = 0) {
  LabelBrick<T> sample(size);
  std::mt19937_64 random(seed);
  for (T& voxel : sample.voxels) {
    const std::uint64_t drawn = random() >> 8;
    voxel = static_cast<T>(count == 0 ? drawn : drawn % count);
  }
  return sample;
}

inline std::size_t byte_count(const EncodedBrick& brick) {
  std::size_t bytes = 0;
  for (const Bytes& segment : brick.segments) bytes += segment.size();
  return bytes;
}

inline std::vector<ByteSpan> spans(const EncodedBrick& brick) {
  return {brick.segments.begin(), brick.segments.end()};
}

template <class T>
std::vector<T> decoded(const BrickCodec& codec, const LabelBrick<T>& sample,
                       const EncodedBrick& brick, int level) {
  const Size3& size = sample.shape.size[static_cast<std::size_t>(level)];
  std::vector<T> out(static_cast<std::size_t>(size.voxel_count()));
  codec.decode(sample.shape, voxel_type_of<T>(), brick.range, spans(brick), level, out.data());
  return out;
}

}  // namespace octavo::testing
