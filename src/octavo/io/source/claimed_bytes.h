// Voxels that a header claims, against the bytes that are there.
#pragma once

#include <cstdint>
#include <string>

namespace octavo {

// How many bytes of voxels a byte can stand for, at most. Those of pictures: how many samples.
inline constexpr std::uint64_t kPlainRatio = 1;
inline constexpr std::uint64_t kPackBitsRatio = 64;   ///< 128 bytes in 2
inline constexpr std::uint64_t kDeflateRatio = 1032;  ///< 258 bytes in 2 bits
inline constexpr std::uint64_t kLzwRatio = 4096;      ///< less than 4096 bytes in 9 to 12 bits
inline constexpr std::uint64_t kJpegSamples = 512;      ///< a block of 8 x 8 in a bit
inline constexpr std::uint64_t kJpegLsRun = 32768;      ///< samples of a row in a bit

/// Rejects a file that claims more voxels than its bytes can hold, before memory is taken for them.
/// Claims that cost little are left to the decoder, which says where the bytes end.
/// Throws Error{source_rejected} with both lengths
void require_holdable(const std::string& path, std::uint64_t bytes_there,
                      std::uint64_t claimed_bytes, std::uint64_t ratio);

}  // namespace octavo
