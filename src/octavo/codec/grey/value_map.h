// What is known of the values of a scan beyond their range: that they lie a step apart, and which
// of few values occur at all.
//
// Scans whose values are multiples of a number (12 bits in the upper part of 16, 8 bits stretched
// to 16) are coded as the multiples. Values that lie a step apart on average only, like 8 bits made
// of fewer by stretching the contrast, are not renumbered: means of numbers would not be means of
// values. Instead the details that lead from the means to the voxels leave out what would end in a
// value that does not occur, see ValueGaps.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "octavo/codec/brick_codec.h"
#include "octavo/codec/entropy/byte_io.h"

namespace octavo::grey {

/// Voxels to codes and back: code = (voxel - offset) / step, to the nearest.
struct CodeScale {
  std::int64_t step = 1;
  std::int64_t offset = 0;

  std::int64_t code_of(std::int64_t voxel) const {
    if (step == 1) return voxel - offset;
    const std::int64_t above = voxel - offset + (step - 1) / 2;
    const std::int64_t quotient = above / step;
    return quotient - (above % step < 0);
  }
  std::int64_t voxel_of(std::int64_t code) const { return code * step + offset; }
};

/// What a model knows of its values.
struct ValueMap {
  CodeScale lattice;               ///< all values of most bricks lie on it; offset 0 .. step - 1
  std::int64_t first = 0;          ///< lowest code that occurs
  std::vector<std::uint8_t> used;  ///< whether `first` + i occurs, both ends do; empty: not known

  bool is_empty() const { return lattice.step == 1 && used.empty(); }
};

inline constexpr std::int64_t kMaxLatticeStep = (std::int64_t{1} << 32) - 1;
inline constexpr std::size_t kMaxMappedCodes = 256;

/// The map of bricks of integer voxels; empty where it would save little.
/// finds_gaps  whether to look for values that do not occur
ValueMap learn_value_map(std::span<const TrainingBrick> bricks, bool finds_gaps);

/// Whether the voxels of bricks are of at most 16 values.
bool has_few_values(std::span<const TrainingBrick> bricks);

/// Both directions of its form in a model (docs/format-grey.md, section 11).
void put_value_map(Bytes& out, const ValueMap& map);
/// Throws Error{corrupt}.
ValueMap take_value_map(ByteSpan& bytes);

/// Which parts of its model's map hold for a brick.
struct BrickMap {
  bool is_on_lattice = false;
  bool has_gaps = false;
  std::vector<std::uint8_t> extras;  ///< codes that occur here alone, counted from the smallest one

  CodeScale scale(const ValueMap& map) const { return is_on_lattice ? map.lattice : CodeScale{}; }
};

/// range        of the voxels of the brick
/// wants_gaps   whether the brick is made of voxels, not of means
BrickMap map_brick(const ValueMap& map, const BrickView& brick, const ValueRange& range,
                   bool wants_gaps);

/// Both directions of its form in a brick (docs/format-grey.md, section 13).
void put_brick_map(Bytes& out, const BrickMap& brick);
/// range  of the voxels of the brick
/// Throws Error{corrupt}.
BrickMap take_brick_map(const ValueMap& map, const ValueRange& range, ByteSpan& bytes);

/// The details that a pair of a mean may have when both its samples are values that occur. Details
/// are known by their number among them, smallest first.
class ValueGaps {
 public:
  static constexpr int kReach = static_cast<int>(kMaxMappedCodes) - 1;
  static constexpr int kTogether = 4;

  /// The details of one mean. The rows of a table stand in different places of the cache.
  struct alignas(64) Details {
    std::int32_t last;  ///< the highest number; a mean without details has a 0
    /// Of the detail nearest to i - kReach; room for four that are written together.
    std::uint16_t numbers[2 * kReach + 1 + kTogether];
    std::int16_t values[2 * kReach + 2];  ///< rising

    /// The number of the detail nearest to one within +-kReach; the smaller of two.
    int nearest(std::int64_t detail) const {
      return numbers[std::clamp<std::int64_t>(detail, -kReach, kReach) + kReach];
    }
    /// The detail of a number, which is brought into their range.
    int detail(std::int64_t number) const {
      return values[std::clamp<std::int64_t>(number, 0, last)];
    }
  };

  /// used  whether the sample `lowest` + i occurs; not empty
  ValueGaps(std::int64_t lowest, std::span<const std::uint8_t> used, int rounding);

  const Details& of(std::int64_t mean) const {
    return details_[static_cast<std::size_t>(std::clamp(mean - lowest_, std::int64_t{0}, last_))];
  }
  bool occurs(std::int64_t sample) const {
    return sample >= lowest_ && sample - lowest_ <= last_ &&
           used_[static_cast<std::size_t>(sample - lowest_)] != 0;
  }

 private:
  std::int64_t lowest_;
  std::int64_t last_;
  std::vector<std::uint8_t> used_;
  std::unique_ptr<Details[]> details_;  ///< by mean
};

/// The gaps of a brick with such codes, at most kMaxMappedCodes.
/// lowest_sample  the sample of the smallest code
ValueGaps make_gaps(const ValueMap& map, const BrickMap& brick, const ValueRange& codes,
                    std::int64_t lowest_sample, int rounding);

}  // namespace octavo::grey
