// Parts of level 0 of a brick that decode alone, given level 1.
//
// A model may cut level 0 at 32 voxels along some of its axes. What lies beyond an inner face of a
// part, its neighborhoods see as the means of level 1, repeated along the axes that are split
// already; magnitudes end at the face. So one part knows nothing of another:
//
//      level 1, known               a part at level 0, y split
//      . . . . . . . .              = = = =           the means around it, once for every
//      . . . . . . . .              = = = =           sample that they stand for
//      . . +-----+ . .              +-------+
//      . . |  o  | . .      ->      | o o o | = =
//      . . |  o  | . .              | o o o | = =
//      . . +-----+ . .              +-------+ = =
//
// The lengths and checksums of the parts stand at the front of the segment of level 1, which a part
// needs in any case. All boxes here are in the codec's axes.
#pragma once

#include <cstdint>
#include <vector>

#include "octavo/codec/brick_codec.h"
#include "octavo/codec/grey/grey_stage.h"
#include "octavo/core/recycled.h"

namespace octavo::grey {

inline constexpr std::int64_t kPartSide = 32;

/// A box of a level that is coded by itself: the whole level, or a part of level 0.
struct Part {
  BrickShape shape;         ///< of the brick; the level and the next one have the sizes of the part
  Index3 at;                ///< its first sample
  Index3 coarse_at;         ///< its first sample at the next level
  Faces outer = kAllFaces;  ///< those at the border of the brick
};

/// How many parts level 0 has when these axes are cut.
std::int64_t part_count(const BrickShape& shape, std::uint8_t cut_axes);
inline bool has_parts(const BrickShape& shape, std::uint8_t cut_axes) {
  return part_count(shape, cut_axes) > 1;
}

/// The parts of level 0, x fastest; a single one unless has_parts.
std::vector<Part> parts_of(const BrickShape& shape, std::uint8_t cut_axes);

/// The box of a part along the brick's own axes.
Box own_box(const Part& part, const AxisOrder& order);

/// The flagged cells of a part; no flags when none of them is flagged.
UniformCells cells_of(const Part& part, const UniformCells& cells);

/// States of the streams of a part: where x is cut, rows are too short for 16.
constexpr int most_part_states(std::uint8_t cut_axes) { return (cut_axes & 1) != 0 ? 8 : 16; }

/// What segment 1 tells of the bytes of a part.
struct PartBytes {
  std::uint64_t length = 0;
  std::uint32_t crc = 0;  ///< CRC-32C of the bytes

  static PartBytes of(ByteSpan bytes);
};

/// Both directions of the list of parts (docs/format-grey.md, section 16).
void put_part_list(Bytes& out, const std::vector<PartBytes>& entries);
/// Throws Error{corrupt}.
std::vector<PartBytes> take_part_list(ByteSpan& bytes, std::size_t count);

/// The parts along the brick's own axes, and where their bytes stand.
/// Throws Error{corrupt} where one is longer than any segment.
std::vector<BrickParts::Part> placed_parts(const std::vector<Part>& parts,
                                           const std::vector<PartBytes>& entries,
                                           const AxisOrder& order);

/// The samples of level 1 of a brick with margins, from which parts take those in and around them.
template <class Sample>
class CoarseSamples {
 public:
  /// Takes the samples of a grid, whose margins it fills.
  explicit CoarseSamples(SampleGrid<Sample>& grid);
  CoarseSamples(const CoarseSamples&) = delete;
  CoarseSamples& operator=(const CoarseSamples&) = delete;

  /// Puts the samples of a part and those around it into a grid.
  void put(const Part& part, SampleGrid<Sample>& grid) const;

 private:
  static constexpr std::int64_t kX = SampleGrid<Sample>::kMarginX;
  static constexpr std::int64_t kYZ = SampleGrid<Sample>::kMargin;

  std::size_t place(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return static_cast<std::size_t>(((z + kYZ) * rows_ + y + kYZ) * row_ + x + kX);
  }

  std::int64_t row_;
  std::int64_t rows_;
  Recycled<UnsetBytes, CoarseSamples> bytes_;
  Sample* samples_;  ///< in the bytes
};

}  // namespace octavo::grey
