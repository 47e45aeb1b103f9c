// Samples without a value: voxels that are NaN or infinite, and coarse samples of nothing else.
//
// A coarse sample is absent when all samples below it are. The flags of a level are coded given
// those of the level above: below an absent sample all are absent, and nothing is coded.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "octavo/core/bytes.h"
#include "octavo/core/levels.h"

namespace octavo::exact {

/// The bits of a coarse sample that is absent, and of most voxels that are.
inline constexpr std::uint32_t kUsualNan = 0x7fc00000;

/// 1 where a sample is absent, dense [z][y][x].
using AbsentFlags = std::vector<std::uint8_t>;

/// The flags of the next coarser level.
AbsentFlags coarser_flags(const AbsentFlags& fine, const Size3& size, HalvingMask halving);

/// The flags of a level given those of the next coarser one, and what the absent voxels are.
/// coarse   empty: none is known, all may be present
/// halving  from this level to the coarser one
/// bits     of each voxel where level 0 is meant, else empty; those of absent voxels are coded
Bytes encode_absent(const AbsentFlags& flags, const Size3& size, const AbsentFlags& coarse,
                    HalvingMask halving, std::span<const std::uint32_t> bits);

/// bits     written where a voxel is absent; empty: none are coded
/// Throws   Error{corrupt}
AbsentFlags decode_absent(ByteSpan bytes, const Size3& size, const AbsentFlags& coarse,
                          HalvingMask halving, std::span<std::uint32_t> bits);

/// Gives absent voxels codes of which nothing is seen: in each cube they become the mean of the
/// samples that are present beside them, each by how many voxels inside the volume lie below it,
/// absent ones too, so that the means of codes are those of the samples present, level by level.
/// codes   dense [z][y][x] of shape.size[0]; 0 where all are absent
void fill_absent(const BrickShape& shape, const AbsentFlags& flags,
                 std::vector<std::int32_t>& codes);

}  // namespace octavo::exact
