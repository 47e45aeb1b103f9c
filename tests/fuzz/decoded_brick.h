// What a decoder makes of one input, told by both builds of the reading half.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

struct DecodedLevel {
  std::string error;  ///< empty when there was none
  std::vector<std::uint8_t> voxels;
};

namespace octavo_portable::fuzz {
/// Levels from the coarsest to the finest, and the finest from parts that decode alone (zeros where
/// there are none); a single error when the input is no brick.
std::vector<DecodedLevel> decode_brick(const std::uint8_t* data, std::size_t size);
}  // namespace octavo_portable::fuzz

namespace octavo_simd::fuzz {
/// The same with vectorized decoders.
std::vector<DecodedLevel> decode_brick(const std::uint8_t* data, std::size_t size);
}  // namespace octavo_simd::fuzz
