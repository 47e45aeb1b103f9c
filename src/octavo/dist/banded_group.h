// A group whose bands stand in several parts, as one run.
//
//   stream 0   level 0 of the bands, one behind the other | slab trailer
//   levels     those of the bands, one behind the other
//   pages      made anew: those of the bands end where these do
//
// What is made is made again whenever it is copied, from the index pages of the bands: about 40
// bytes a brick, which are not kept.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "octavo/core/levels.h"
#include "octavo/dist/part_file.h"
#include "octavo/file/layout.h"
#include "octavo/file/write/encoded_run.h"

namespace octavo {

/// Proves that bands of one group were made of the same voxels, and trained alike.
/// Throws Error{source_rejected} that names one of two that were not
void require_one_group(const std::vector<std::shared_ptr<PartFile>>& bands);

class BandedGroup final : public EncodedRun {
 public:
  /// bands   of one group, in the order of its bricks, which they tile; each with its groups proven
  /// header  of the file; it and `levels` outlive the run
  /// Throws  Error{corrupt} for damaged pages; Error{source_rejected} where two bands were made of
  ///         other voxels of the group, or trained otherwise; Error{io}
  /// Memory  while it is made, 100 bytes a brick of the group; then that of its pages
  BandedGroup(std::vector<std::shared_ptr<PartFile>> bands, const FileHeader& header,
              const Levels& levels);

  const std::vector<std::shared_ptr<PartFile>>& bands() const { return bands_; }

  /// One group, without the samples of its bricks: those stand in the parts.
  const std::vector<JournalGroup>& groups() const override { return groups_; }
  Section stream(std::size_t number) const override { return streams_.at(number); }
  void read(std::size_t stream, std::uint64_t offset,
            std::span<std::uint8_t> out) const override;
  void copy(std::size_t stream, const std::function<void(ByteSpan)>& sink) const override;
  std::uint64_t stored_bytes(std::size_t stream) const override;
  void copy_rest(std::size_t stream, const std::function<void(ByteSpan)>& sink) const override;

 private:
  struct Made {
    Bytes trailer;
    Bytes pages;
    std::vector<PageRef> refs;
  };

  Bytes pages_of(const PartFile& band) const;
  Made make() const;
  bool is_stored(std::size_t stream) const { return stream + 1 < streams_.size(); }

  std::vector<std::shared_ptr<PartFile>> bands_;
  const FileHeader& header_;
  const Levels& levels_;
  std::int64_t layer_ = 0;
  std::uint32_t slab_crc_ = 0;
  std::vector<Section> streams_;
  std::vector<JournalGroup> groups_;
};

}  // namespace octavo
