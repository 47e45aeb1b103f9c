// The bytes of a damaged file as they were written, where that is known.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "octavo/file/bit_flip.h"
#include "octavo/file/layout.h"
#include "octavo/file/storage/byte_source.h"

namespace octavo {

/// What is changed in a damaged file.
struct Repairs {
  std::uint64_t size = 0;               ///< bytes behind it are left out
  std::vector<BitFlip> flips;           ///< turned back: in the order of the file, each once
  std::optional<TrailerBlock> trailer;  ///< in place of the one that stands there
};

/// Adds flips, in any order, to those of `repairs`; one that is there already stays once.
void add_flips(Repairs& repairs, const std::vector<BitFlip>& flips);

/// The changes without which nothing in a file can be found: in its header, trailer, metadata and
/// index root, and of its length. A trailer that no flipped bit explains gets a digest of 0.
/// Throws Error{corrupt} when the file was still growing; Error{not_octavo}, Error{truncated},
///        Error{corrupt} when the header cannot be repaired; Error{io}
Repairs repair_envelope(const ByteSource& source);

/// A source with some changes; named as the one below. Thread-safe where that is.
class RepairedSource final : public ByteSource {
 public:
  RepairedSource(std::shared_ptr<const ByteSource> inner, Repairs repairs);

  std::uint64_t size() const override { return repairs_.size; }
  const std::string& name() const override { return inner_->name(); }
  void read(std::uint64_t offset, std::span<std::uint8_t> out) const override;

 private:
  std::shared_ptr<const ByteSource> inner_;
  Repairs repairs_;
};

}  // namespace octavo
