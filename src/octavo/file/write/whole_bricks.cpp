#include "octavo/file/write/whole_bricks.h"

#include <algorithm>
#include <utility>

#include "octavo/core/crc32c.h"
#include "octavo/file/layer_order.h"
#include "octavo/octree/o_code.h"

namespace octavo {

WholeBricks::WholeBricks(InterruptedBuild build) : build_(std::move(build)) {
  header_ = parse_unsealed_header(build_.head.header);
  header_.description.metadata = Metadata::read(build_.head.metadata);
  levels_ = Levels(header_.description.size, header_.halvings);
  const auto groups = proven_groups(*build_.file, *build_.journal, levels_);
  if (groups.empty()) {
    throw Error(ErrorKind::corrupt, "its build was interrupted before any plane was whole",
                build_.file->path());
  }
  place(groups);
}

// Where everything stands: as in a finished file up to the slab trailers, and level by level in the
// streams of the journal. A page behind the last one tells where that ends.
void WholeBricks::place(const std::vector<WholeGroup>& groups) {
  layer_count_ = groups.back().group.end_layer;
  squared_error_ = groups.back().group.squared_error;
  streams_.resize(static_cast<std::size_t>(levels_.count()) + 1);
  root_.tiers.push_back(make_tier_index(levels_, 0));
  TierIndex& tier = root_.tiers.front();
  for (const auto& [group, blocks, end] : groups) {
    root_.models.insert(root_.models.end(), group.models.begin(), group.models.end());
    root_.slab_trailer_bytes.insert(root_.slab_trailer_bytes.end(),
                                    group.slab_trailer_bytes.begin(),
                                    group.slab_trailer_bytes.end());
    tier.pages.insert(tier.pages.end(), group.pages.begin(), group.pages.end());
    parents_.insert(parents_.end(), group.parents.begin(), group.parents.end());
    plane_digests_.insert(plane_digests_.end(), group.plane_digests.begin(),
                          group.plane_digests.end());
    for (const JournalBlock& block : blocks) streams_[block.stream].blocks.push_back(block);
  }
  range_ = tier.pages.front().range;
  std::array<std::uint64_t, kTierPieces> cursor{};
  cursor[0] = kHeaderBytes;
  auto model = root_.models.begin();
  for (std::size_t number = 0; number < tier.pages.size(); ++number) {
    PageRef& page = tier.pages[number];
    const std::int64_t slab = tier.layer_of(number);
    const bool starts = tier.first_place(number) == 0;
    if (starts && model != root_.models.end() && model->first_slab == slab) {
      cursor[0] += model->length;
      ++model;
    }
    for (std::size_t piece = 0; piece < cursor.size(); ++piece) {
      cursor[piece] += std::exchange(page.piece_start[piece], cursor[piece]);
    }
    range_ = {std::min(range_.min, page.range.min), std::max(range_.max, page.range.max)};
    if (tier.first_place(number) + tier.brick_count(number) < tier.layer_bricks) continue;
    tier.piece_end[0] = cursor[0];
    cursor[0] += root_.slab_trailer_bytes[static_cast<std::size_t>(slab)];
  }
  std::copy(cursor.begin() + 1, cursor.end(), tier.piece_end.begin() + 1);
  PageRef behind;
  behind.piece_start = cursor;
  tier.pages.push_back(behind);
}

bool WholeBricks::has_model() const {
  if (next_model_ == root_.models.size()) return false;
  const auto first = static_cast<std::size_t>(root_.models[next_model_].first_slab) *
                     static_cast<std::size_t>(root_.tiers.front().layer_bricks);
  return given_ == first;
}

Bytes WholeBricks::model() {
  const ModelRef& model = root_.models[next_model_];
  Bytes bytes(model.length);
  build_.file->read(model.offset, bytes);
  if (piece_crc(header_.build_id, kModelLevel, next_model_, bytes) != model.crc) {
    throw Error(ErrorKind::corrupt, "model " + std::to_string(next_model_) + " is damaged",
                build_.file->path(), model.offset);
  }
  ++next_model_;
  return bytes;
}

Bytes WholeBricks::take(std::size_t number, std::uint64_t count) {
  Stream& stream = streams_[number];
  Bytes bytes;
  while (count > 0) {
    if (stream.block == stream.blocks.size()) {
      throw Error(ErrorKind::corrupt, "ends before the bricks it lists", build_.journal->path());
    }
    const JournalBlock& block = stream.blocks[stream.block];
    const std::uint64_t part = std::min(count, block.length - stream.at);
    const std::size_t at = bytes.size();
    bytes.resize(at + static_cast<std::size_t>(part));
    build_.journal->read(block.offset + stream.at, std::span(bytes).subspan(at));
    count -= part;
    stream.at += part;
    if (stream.at < block.length) continue;
    stream.at = 0;
    ++stream.block;
  }
  return bytes;
}

void WholeBricks::open_page() {
  const PageRef& ref = root_.tiers.front().pages[next_page_];
  const Bytes bytes = take(streams_.size() - 1, ref.length);
  if (crc32c(bytes) != ref.crc) {
    throw Error(ErrorKind::corrupt, "index page " + std::to_string(next_page_) + " is damaged",
                build_.journal->path());
  }
  page_ = parse_page(bytes, root_, levels_, 0, next_page_, header_);
  ++next_page_;
  in_page_ = 0;
}

Bytes WholeBricks::proven_piece(Bytes bytes, int level, std::uint32_t crc) const {
  const TierIndex& tier = root_.tiers.front();
  const auto layer_bricks = static_cast<std::size_t>(tier.layer_bricks);
  Index3 position =
      position_in_layer(tier.grid, static_cast<std::int64_t>(given_ % layer_bricks));
  position.z = static_cast<std::int64_t>(given_ / layer_bricks);
  if (piece_crc(header_.build_id, level, interleave(position), bytes) == crc) return bytes;
  throw Error(ErrorKind::corrupt, "a piece of level " + std::to_string(level) + " is damaged",
              build_.file->path());
}

EncodedBrick WholeBricks::next() {
  if (next_page_ == 0 || in_page_ == page_.ranges.size()) open_page();
  EncodedBrick brick;
  brick.range = page_.ranges[in_page_];
  brick.parent = parents_[given_];
  if (!page_.error_steps.empty()) {
    brick.max_error = static_cast<std::int64_t>(page_.error_steps[in_page_]);
  }
  const int level_count = levels_.tier_level_count(0);
  brick.segments.resize(static_cast<std::size_t>(level_count));
  if (brick.range.min != brick.range.max) {
    std::array<Bytes, kTierPieces> pieces;
    const auto count = static_cast<std::size_t>(page_.piece_count);
    for (std::size_t i = 0; i < count; ++i) {
      const PieceRef& ref = page_.pieces[page_.slots[in_page_] * count + i];
      if (ref.length == 0) continue;
      Bytes bytes(i == 0 ? ref.length : 0);
      if (i == 0) build_.file->read(ref.offset, bytes);
      else bytes = take(i, ref.length);
      pieces[i] = proven_piece(std::move(bytes), static_cast<int>(i), ref.crc);
    }
    const auto segments = segments_of(std::span<const Bytes>(pieces).first(count), level_count);
    for (std::size_t i = 0; i < brick.segments.size(); ++i) {
      brick.segments[i].assign(segments[i].begin(), segments[i].end());
    }
  }
  ++in_page_;
  ++given_;
  return brick;
}

}  // namespace octavo
