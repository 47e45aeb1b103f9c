// Blocks of SHA-256 by the instructions that x86-64 processors have for it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "octavo/builder/sha256_lanes.h"

namespace octavo {

/// Whether add_sha256_blocks may be called.
bool has_sha256_instructions();

/// The state before the first block.
Sha256State sha256_start();

/// The state behind the last block, as a digest.
Sha256Digest sha256_digest(const Sha256State& state);

/// Takes up `count` blocks of 64 bytes.
void add_sha256_blocks(Sha256State& state, const std::uint8_t* blocks, std::size_t count);

/// The same for two runs of blocks at a time.
void add_sha256_blocks(Sha256State& a, Sha256State& b, const std::uint8_t* blocks_a,
                       const std::uint8_t* blocks_b, std::size_t count);

}  // namespace octavo
