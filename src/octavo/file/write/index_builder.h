// Makes the index while bricks come in: pages are encoded as they fill and wait in the spool.
#pragma once

#include <vector>

#include "octavo/file/index.h"
#include "octavo/file/write/spool.h"

namespace octavo {

/// The bytes of a root whose PageRefs hold totals.
Bytes encode_root(const IndexRoot& root, const Levels& levels, const FileHeader& header);

/// The bytes of a page; the offsets of its pieces are not looked at.
Bytes encode_page(const IndexPage& page);

/// Memory  that of the page in work, and about 90 bytes per finished page
class IndexBuilder {
 public:
  /// Pages go to stream `page_stream` of `spool`; all three references outlive this.
  IndexBuilder(const Levels& levels, const FileHeader& header, Spool& spool,
               std::size_t page_stream);

  void add_model(const ModelRef& model) { root_.models.push_back(model); }
  void add_slab_trailer(std::uint32_t bytes) { root_.slab_trailer_bytes.push_back(bytes); }

  /// The next brick of `tier`; offsets of its pieces are not needed.
  /// error_steps  0 unless the tier has errors
  void add_brick(int tier, const ValueRange& range, std::uint64_t error_steps,
                 const std::vector<PieceRef>& pieces);

  /// Ends the page in work, if it has bricks, before it is full.
  void end_page(int tier);

  /// Takes over a page of tier 0 whose bytes stand in the spool.
  void restore_page(const PageRef& page) { root_.tiers.front().pages.push_back(page); }

  const IndexRoot& root() const { return root_; }

 private:
  void finish_page(int tier);

  const Levels& levels_;
  const FileHeader& header_;
  Spool& spool_;
  std::size_t page_stream_;
  IndexRoot root_;
  IndexPage page_;
};

}  // namespace octavo
