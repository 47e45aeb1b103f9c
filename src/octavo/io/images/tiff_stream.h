// The compressed bytes of a strip or tile of TIFF, and what a stream makes of them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "octavo/io/source/source_file.h"

namespace octavo {

/// Where the bytes of a strip or tile stand in a file.
struct CodedBlock {
  std::uint64_t offset = 0;
  std::uint64_t length = 0;
  bool is_mirrored = false;  ///< the bits of each byte stand in reverse (FillOrder 2)
};

/// What a stream makes.
struct MadeBytes {
  std::uint64_t count = 0;  ///< up to its end or its damage, or a few more than were allowed
  std::string damage;       ///< what is wrong with it; empty where it is whole or was left
};

/// The bytes of a block, piece by piece, with their bits in order.
class BlockPieces {
 public:
  BlockPieces(const SourceFile& file, const CodedBlock& block) : file_(file), left_(block) {}
  /// Those behind the ones before, until the next call; empty at the end. Throws Error{io}.
  std::span<std::byte> next();

 private:
  const SourceFile& file_;
  CodedBlock left_;
  std::array<std::byte, std::size_t{1} << 15> piece_;
};

/// Where a stream writes: into rows, and then into nothing.
class RowSink {
 public:
  explicit RowSink(std::span<std::byte> rows) : rows_(rows) {}
  /// Room for what follows; never empty.
  std::span<std::byte> room() {
    return taken_ < rows_.size() ? rows_.subspan(static_cast<std::size_t>(taken_)) : behind_;
  }
  /// Says how much of it was used.
  void take(std::size_t bytes) { taken_ += bytes; }
  std::uint64_t taken() const { return taken_; }

 private:
  std::span<std::byte> rows_;
  std::uint64_t taken_ = 0;
  std::array<std::byte, std::size_t{1} << 15> behind_;
};

}  // namespace octavo
