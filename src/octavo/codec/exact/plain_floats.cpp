#include "octavo/codec/exact/plain_floats.h"

#include <cmath>
#include <string>

#include "octavo/codec/grey/octant_transform.h"
#include "octavo/core/error.h"

namespace octavo::exact {

namespace {

constexpr std::size_t kFloatBytes = 4;

}  // namespace

Bytes encode_plain_floats(std::span<const float> voxels) {
  Bytes bytes;
  bytes.reserve(voxels.size() * kFloatBytes);
  for (const float voxel : voxels) {
    std::uint32_t bits = bits_of(voxel);
    for (std::size_t i = 0; i < kFloatBytes; ++i, bits >>= 8) {
      bytes.push_back(static_cast<std::uint8_t>(bits));
    }
  }
  return bytes;
}

void decode_plain_floats(ByteSpan bytes, const FloatBins& bins, const ValueRange& codes,
                         std::span<float> voxels) {
  if (bytes.size() != voxels.size() * kFloatBytes) {
    throw Error(ErrorKind::corrupt, "plain floats: " + std::to_string(bytes.size()) + " bytes, " +
                                        std::to_string(voxels.size() * kFloatBytes) + " expected");
  }
  const FloatBin inside{bins.bin_of(codes.min, 0).first, bins.bin_of(codes.max, 0).end};
  for (std::size_t at = 0; at < voxels.size(); ++at) {
    const ByteSpan one = bytes.subspan(at * kFloatBytes, kFloatBytes);
    const float voxel = float_of_bits(static_cast<std::uint32_t>(one[0]) |
                                      static_cast<std::uint32_t>(one[1]) << 8 |
                                      static_cast<std::uint32_t>(one[2]) << 16 |
                                      static_cast<std::uint32_t>(one[3]) << 24);
    if (std::isfinite(voxel) && !inside.contains(rank_of(voxel))) {
      throw Error(ErrorKind::corrupt, "a plain float lies outside the range of its brick");
    }
    voxels[at] = voxel;
  }
}

CodedLevel level_of(const QuantizedBrick& brick, const BrickShape& shape, int level,
                    const AxisOrder& order) {
  CodedLevel found{brick.codes, brick.absent};
  for (int i = 0; i < level; ++i) {
    const auto slot = static_cast<std::size_t>(i);
    found.codes = coarser_level(std::move(found.codes), shape, i, order);
    if (found.absent.empty()) continue;
    found.absent = coarser_flags(found.absent, shape.size[slot], shape.halving[slot]);
  }
  return found;
}

}  // namespace octavo::exact
