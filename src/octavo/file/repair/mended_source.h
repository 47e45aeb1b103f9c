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
struct Mendings {
  std::uint64_t size = 0;               ///< bytes behind it are left out
  std::vector<BitFlip> flips;           ///< turned back: in the order of the file, each once
  std::optional<TrailerBlock> trailer;  ///< in place of the one that stands there
};

/// Adds flips, in any order, to those of `mendings`; one that is there already stays once.
void add_flips(Mendings& mendings, const std::vector<BitFlip>& flips);

/// The changes without which nothing in a file can be found: in its header, trailer, metadata and
/// index root, and of its length. A trailer that no flipped bit explains gets a digest of 0.
/// Throws Error{corrupt} when the file was still growing; Error{not_octavo}, Error{truncated},
///        Error{corrupt} when the header cannot be mended; Error{io}
Mendings mend_envelope(const ByteSource& source);

/// A source with some changes; named as the one below. Thread-safe where that is.
class MendedSource final : public ByteSource {
 public:
  MendedSource(std::shared_ptr<const ByteSource> inner, Mendings mendings);

  std::uint64_t size() const override { return mendings_.size; }
  const std::string& name() const override { return inner_->name(); }
  void read(std::uint64_t offset, std::span<std::uint8_t> out) const override;

 private:
  std::shared_ptr<const ByteSource> inner_;
  Mendings mendings_;
};

}  // namespace octavo
