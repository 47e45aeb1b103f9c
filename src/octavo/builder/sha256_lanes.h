// SHA-256 of runs of bytes that grow side by side, as planes of a volume do.
//
// An instruction of SHA waits for the one before it; those of a second run fill the time.
//
// Source  FIPS 180-4, section 6.2
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "octavo/core/bytes.h"
#include "octavo/core/hasher.h"

namespace octavo {

/// The eight words between two blocks, in the order in which the instructions take them.
using Sha256State = std::array<std::uint32_t, 8>;

/// States behind runs of zeros, each computed once. Safe on many threads at once.
class ZeroStates {
 public:
  /// The state behind so many blocks of 64 zeros. Memory: 40 bytes for each 16 KiB of zeros
  /// Requires  a processor with instructions for it
  Sha256State after(std::uint64_t block_count);

 private:
  std::mutex mutex_;
  std::vector<Sha256State> states_;  // kBlocksApart blocks apart
};

class Sha256Lanes {
 public:
  /// count            runs
  /// zero_states      must outlive this
  /// by_instructions  false: by libcrypto, whatever the processor has
  Sha256Lanes(std::size_t count, ZeroStates& zero_states, bool by_instructions = is_native());
  ~Sha256Lanes();

  /// bytes  the next ones of each run, as many of each, run after run
  void add(ByteSpan bytes);
  /// The same for so many zeros in each run; nearly free where nothing else came before.
  void add_zeros(std::uint64_t byte_count);

  /// Of each run, as it is then; nothing can be added afterwards.
  std::vector<Sha256Digest> digests();

  /// Whether the processor has instructions for it; libcrypto computes it otherwise.
  static bool is_native();

 private:
  static constexpr std::size_t kBlockBytes = 64;
  struct Lane {
    Sha256State state;
    std::array<std::uint8_t, kBlockBytes> rest;  // of a block that is not full
  };

  void add_blocks(const std::uint8_t* first, std::size_t apart, std::size_t block_count);
  void add_rests();

  std::vector<Lane> lanes_;
  std::vector<std::unique_ptr<Hasher>> hashers_;  // where there are no instructions
  ZeroStates& zero_states_;
  std::uint64_t byte_count_ = 0;  // of each run
  bool is_zero_ = true;           // all so far
};

}  // namespace octavo
