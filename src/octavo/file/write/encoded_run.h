// Layers that another writer has encoded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "octavo/core/bytes.h"
#include "octavo/file/layout.h"
#include "octavo/file/write/journal.h"

namespace octavo {

/// A run as run_writer.h describes it. Thread-compatible.
class EncodedRun {
 public:
  virtual ~EncodedRun() = default;

  /// Its groups, which tile its layers; offsets of models are counted from the start of stream 0.
  virtual const std::vector<JournalGroup>& groups() const = 0;

  /// The length and the checksum of a stream.
  virtual Section stream(std::size_t number) const = 0;

  /// Reads bytes of a stream from `offset` on, unproven. Throws Error{io, truncated}
  virtual void read(std::size_t stream, std::uint64_t offset,
                    std::span<std::uint8_t> out) const = 0;

  /// Hands the bytes of a stream to `sink`, a block at a time: 0 is level 0 with models and slab
  /// trailers, the others are those of the spool.
  /// Throws  Error{corrupt, truncated} behind the last block where they are not those that were
  ///         written; Error{io}
  virtual void copy(std::size_t stream, const std::function<void(ByteSpan)>& sink) const = 0;

  /// How many bytes of a stream, its first ones, stand in a file as they are: who leaves out runs
  /// leaves out these.
  virtual std::uint64_t stored_bytes(std::size_t number) const { return stream(number).length; }

  /// As copy, of the bytes behind those.
  virtual void copy_rest(std::size_t, const std::function<void(ByteSpan)>&) const {}
};

}  // namespace octavo
