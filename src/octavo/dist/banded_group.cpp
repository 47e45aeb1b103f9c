#include "octavo/dist/banded_group.h"

#include <algorithm>
#include <utility>

#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/file/slab_trailer.h"
#include "octavo/file/storage/storage.h"
#include "octavo/file/write/index_builder.h"

namespace octavo {

namespace {

/// Collects bricks that come in pieces of pages into whole pages of a layer.
class PageJoiner {
 public:
  explicit PageJoiner(std::int64_t layer_bricks) : left_(layer_bricks) {}

  /// The next bricks, of which none reaches beyond the page in work.
  void add(const IndexPage& bricks, const PageRef& ref) {
    page_.piece_count = bricks.piece_count;
    const auto append = [](auto& to, const auto& from) {
      to.insert(to.end(), from.begin(), from.end());
    };
    const bool is_first = page_.ranges.empty();
    append(page_.ranges, bricks.ranges);
    append(page_.error_steps, bricks.error_steps);
    append(page_.pieces, bricks.pieces);
    ref_.range = is_first ? ref.range
                          : ValueRange{std::min(ref_.range.min, ref.range.min),
                                       std::max(ref_.range.max, ref.range.max)};
    ref_.error_steps = std::max(ref_.error_steps, ref.error_steps);
    ref_.uniform_count += ref.uniform_count;
    for (std::size_t i = 0; i < ref_.piece_start.size(); ++i) {
      ref_.piece_start[i] += ref.piece_start[i];
    }
    if (static_cast<std::int64_t>(page_.ranges.size()) == std::min(left_, kPageBricks)) end();
  }

  std::vector<PageRef> take_refs() { return std::move(refs_); }
  Bytes take_bytes() { return std::move(bytes_); }

 private:
  void end() {
    const Bytes bytes = encode_page(page_);
    ref_.length = static_cast<std::uint32_t>(bytes.size());
    ref_.crc = crc32c(bytes);
    refs_.push_back(std::exchange(ref_, {}));
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    left_ -= static_cast<std::int64_t>(std::exchange(page_, {}).ranges.size());
  }

  std::int64_t left_;  ///< bricks of the layer in pages that are not whole
  IndexPage page_;
  PageRef ref_;
  std::vector<PageRef> refs_;
  Bytes bytes_;
};

/// A page of so many bricks of tier 0, whose piece_start holds the lengths of its pieces, read as
/// if it were all of an index.
IndexPage parse_band_page(ByteSpan bytes, const PageRef& ref, std::int64_t bricks,
                          const Levels& levels, const FileHeader& header) {
  IndexRoot root;
  TierIndex& tier = root.tiers.emplace_back();
  tier.grid = {bricks, 1, 1};
  tier.layer_bricks = bricks;
  tier.layer_pages = 1;
  tier.pages = {ref};
  tier.pages.front().piece_start = {};
  tier.piece_end = ref.piece_start;
  return parse_page(bytes, root, levels, 0, 0, header);
}

/// The length of piece 0 of each brick, 0 of a uniform one.
void add_lengths(const IndexPage& page, std::vector<std::uint64_t>& lengths) {
  const auto step = static_cast<std::size_t>(page.piece_count);
  std::size_t slot = 0;
  for (const ValueRange& range : page.ranges) {
    lengths.push_back(range.min == range.max ? 0 : page.pieces[step * slot++].length);
  }
}

}  // namespace

// The stamps of files say whether they were changed; where there are none, this does.
void require_one_group(const std::vector<std::shared_ptr<PartFile>>& bands) {
  for (const auto& part : bands) {
    const JournalGroup& first = bands.front()->groups().front();
    const JournalGroup& band = part->groups().front();
    const ModelRef& model = band.models.front();
    const bool is_same = band.voxels_crc == first.voxels_crc &&
                         model.crc == first.models.front().crc &&
                         model.length == first.models.front().length;
    if (is_same) continue;
    throw Error(ErrorKind::source_rejected,
                "was made of other voxels of " +
                    place_text({0, part->place().first_group, part->place().end_group}) +
                    " than " + escaped(base_name_of(bands.front()->path())) +
                    "; make both parts anew",
                part->path())
        .with_field("parts.anew");
  }
}

BandedGroup::BandedGroup(std::vector<std::shared_ptr<PartFile>> bands, const FileHeader& header,
                         const Levels& levels)
    : bands_(std::move(bands)), header_(header), levels_(levels) {
  require_one_group(bands_);
  const PartFile& first = *bands_.front();
  const JournalGroup& first_band = first.groups().front();
  layer_ = first_band.end_layer - 1;

  // The streams of the bands, one behind the other
  streams_.resize(first.stream_count());
  for (std::size_t stream = 0; is_stored(stream); ++stream) {
    for (const auto& band : bands_) {
      const Section bytes = band->stream(stream);
      streams_[stream].length += bytes.length;
      streams_[stream].crc =
          crc32c_joined(streams_[stream].crc, bytes.crc, crc32c_shift(bytes.length));
    }
  }
  slab_crc_ = streams_.front().crc;

  // What is made of them
  Made made = make();
  streams_.back() = {0, made.pages.size(), crc32c(made.pages)};
  streams_.front().length += made.trailer.size();
  streams_.front().crc = crc32c(made.trailer, slab_crc_);
  JournalGroup group;
  group.end_layer = layer_ + 1;
  group.voxels_crc = first_band.voxels_crc;
  group.file_bytes = kHeaderBytes + streams_.front().length;
  group.squared_error = first_band.squared_error;
  group.models = first_band.models;
  group.slab_trailer_bytes = {static_cast<std::uint32_t>(made.trailer.size())};
  group.pages = std::move(made.refs);
  for (const auto& band : bands_) {
    const auto& digests = band->groups().front().plane_digests;
    group.plane_digests.insert(group.plane_digests.end(), digests.begin(), digests.end());
  }
  groups_.push_back(std::move(group));
}

Bytes BandedGroup::pages_of(const PartFile& band) const {
  const std::size_t stream = streams_.size() - 1;
  Bytes bytes(static_cast<std::size_t>(band.stream(stream).length));
  band.read(stream, 0, bytes);
  if (checksum_matches(crc32c(bytes), band.stream(stream).crc)) return bytes;
  throw Error(ErrorKind::corrupt,
              "stream " + std::to_string(stream) +
                  " of the part fails its checksum; make the part anew",
              band.path());
}

BandedGroup::Made BandedGroup::make() const {
  const Size3 grid = levels_.brick_grid(0);
  PageJoiner pages(grid.x * grid.y);
  SlabTrailer trailer;
  for (const auto& part : bands_) {
    const Bytes bytes = pages_of(*part);
    std::size_t at = 0;
    std::int64_t brick = part->place().first_brick;
    for (const PageRef& ref : part->groups().front().pages) {
      const std::int64_t end = std::min((brick / kPageBricks + 1) * kPageBricks,
                                        part->place().end_brick);
      try {
        if (ref.length > bytes.size() - at) {
          throw Error(ErrorKind::corrupt, "the index pages of the part end early");
        }
        const IndexPage page =
            parse_band_page(ByteSpan(bytes).subspan(at, ref.length), ref, end - brick, levels_,
                            header_);
        add_lengths(page, trailer.lengths);
        pages.add(page, ref);
      } catch (const Error& error) {
        throw error.path().empty() ? error.with_path(part->path()) : error;
      }
      at += ref.length;
      brick = end;
    }
    trailer.plane_digests.insert(trailer.plane_digests.end(),
                                 part->groups().front().plane_digests.begin(),
                                 part->groups().front().plane_digests.end());
  }
  trailer.build_id = header_.build_id;
  trailer.slab = static_cast<std::uint64_t>(layer_);
  trailer.model = static_cast<std::uint64_t>(bands_.front()->place().first_group);
  trailer.slab_crc = slab_crc_;
  return {encode_slab_trailer(trailer), pages.take_bytes(), pages.take_refs()};
}

std::uint64_t BandedGroup::stored_bytes(std::size_t stream) const {
  std::uint64_t bytes = 0;
  for (const auto& band : bands_) {
    if (band->is_joined(stream)) bytes += band->stream(stream).length;
  }
  return bytes;
}

void BandedGroup::read(std::size_t stream, std::uint64_t offset,
                       std::span<std::uint8_t> out) const {
  for (const auto& band : bands_) {
    const std::uint64_t length = band->is_joined(stream) ? band->stream(stream).length : 0;
    if (offset < length && !out.empty()) {
      const auto count = static_cast<std::size_t>(
          std::min<std::uint64_t>(length - offset, out.size()));
      band->read(stream, offset, out.first(count));
      out = out.subspan(count);
      offset += count;
    }
    offset -= std::min(offset, length);
  }
  if (out.empty()) return;
  copy_rest(stream, [&](ByteSpan made) {
    if (offset > made.size() || out.size() > made.size() - offset) {
      throw Error(ErrorKind::internal, "bytes behind the end of a run are read");
    }
    std::ranges::copy(made.subspan(static_cast<std::size_t>(offset), out.size()), out.begin());
  });
}

void BandedGroup::copy(std::size_t stream, const std::function<void(ByteSpan)>& sink) const {
  for (const auto& band : bands_) {
    if (band->is_joined(stream)) band->copy(stream, sink);
  }
  copy_rest(stream, sink);
}

void BandedGroup::copy_rest(std::size_t stream, const std::function<void(ByteSpan)>& sink) const {
  if (stream == 0) sink(make().trailer);
  else if (!is_stored(stream)) sink(make().pages);
}

}  // namespace octavo
