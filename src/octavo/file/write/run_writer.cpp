#include "octavo/file/write/run_writer.h"

#include <algorithm>
#include <utility>

#include "octavo/core/crc32c.h"
#include "octavo/file/layer_order.h"
#include "octavo/file/slab_trailer.h"
#include "octavo/file/write/new_header.h"
#include "octavo/octree/o_code.h"

namespace octavo {

std::size_t run_streams(const Levels& levels) { return page_stream(levels) + 1; }

std::size_t page_stream(const Levels& levels) { return static_cast<std::size_t>(levels.count()); }

RunWriter::RunWriter(const FileHeader& header, const Levels& levels, AppendFile& out,
                     Spool& spool, bool keeps_groups, const RunStart& start)
    : header_(header),
      levels_(levels),
      out_(out),
      spool_(spool),
      index_(levels, header, spool, page_stream(levels)),
      keeps_groups_(keeps_groups),
      start_(start),
      layer_(start.layer),
      place_(start.place),
      group_end_(start.layer) {}

void RunWriter::add_model(const Bytes& model) {
  const auto& models = index_.root().models;
  const bool is_coarse = tier_ == 1 && layer_ == 0 && tier_ < levels_.tier_count();
  const auto slab = static_cast<std::uint32_t>(is_coarse ? layer_count() : layer_);
  const bool has_model = !models.empty() && models.back().first_slab == slab;
  const bool is_inside = place_ != start_.place || (place_ != 0 && !start_.is_band());
  if ((tier_ != 0 && !is_coarse) || is_inside || has_model) misused("a model inside a layer");
  if (models.empty() && layer_ != start_.layer) misused("bricks before the first model");
  if (model.size() > kMaxModelBytes) misused("a model above 16 MiB");
  ModelRef ref;
  ref.offset = out_.size();
  ref.length = static_cast<std::uint32_t>(model.size());
  ref.crc = piece_crc(header_.build_id, kModelLevel, model_count(), model);
  ref.first_slab = slab;
  index_.add_model(ref);
  if (start_.place > 0) return;  // it stands in front of another band
  out_.append(model);
  if (!is_coarse) slab_crc_ = crc32c(model, slab_crc_);
}

// The o-code of the brick that comes next, after proving that one of `tier` may come.
std::uint64_t RunWriter::next_code(int tier) const {
  if (tier != tier_ || tier >= levels_.tier_count()) misused("a brick out of order");
  if (index_.root().models.empty()) misused("a brick before the first model");
  if (start_.is_band() && place_ == start_.end_place) misused("a brick behind its band");
  const Size3 grid = levels_.brick_grid(tier);
  Index3 position = position_in_layer(grid, place_);
  position.z = layer_;
  return interleave(position);
}

void RunWriter::check_brick(int tier, const EncodedBrick& brick) const {
  const auto level_count = static_cast<std::size_t>(levels_.tier_level_count(tier));
  if (brick.segments.size() != level_count) misused("a brick with another number of levels");
  const ValueRange bounds = value_range(header_.description.coded_type());
  if (brick.range.min < bounds.min || brick.range.max > bounds.max ||
      brick.range.min > brick.range.max) {
    misused("a brick range outside the voxel type");
  }
  const std::uint64_t most_error = tier == 0 ? max_error_steps(header_) : 0;
  if (brick.max_error < 0 || static_cast<std::uint64_t>(brick.max_error) > most_error) {
    misused("a brick beyond the max error");
  }
  const bool is_empty = std::ranges::all_of(brick.segments, &Bytes::empty);
  if (brick.range.min == brick.range.max && !is_empty) misused("bytes of a uniform brick");
}

void RunWriter::add_brick(int tier, const EncodedBrick& brick) {
  const std::uint64_t code = next_code(tier);
  check_brick(tier, brick);
  const auto pieces = encode_pieces(brick.segments);
  std::vector<PieceRef> refs(static_cast<std::size_t>(piece_count(levels_.tier_level_count(tier))));
  for (std::size_t i = 0; i < refs.size(); ++i) {
    const Bytes& piece = pieces[i];
    if (piece.size() > kMaxPieceBytes) misused("a piece above 4 MiB");
    refs[i].length = static_cast<std::uint32_t>(piece.size());
    if (piece.empty()) continue;
    const int level = Levels::first_level(tier) + static_cast<int>(i);
    refs[i].crc = piece_crc(header_.build_id, level, code, piece);
    if (level == 0) {
      out_.append(piece);
      slab_crc_ = crc32c(piece, slab_crc_);
    } else {
      spool_.append(static_cast<std::size_t>(level), piece);
    }
  }
  index_.add_brick(tier, brick.range, static_cast<std::uint64_t>(brick.max_error), refs);
  if (tier == 0) squared_error_ += brick.squared_error;
  if (tier == 0) slab_lengths_.push_back(refs.front().length);
  if (tier == 0 && keeps_groups_) group_parents_.push_back(brick.parent);
  advance(tier);
}

void RunWriter::advance(int tier) {
  const Size3 grid = levels_.brick_grid(tier);
  ++place_;
  if (start_.is_band()) {
    if (place_ % kPageBricks == 0 || place_ == start_.end_place) index_.end_page(tier);
    return;
  }
  if (place_ < grid.x * grid.y) return;
  if (tier == 0) append_slab_trailer();
  place_ = 0;
  if (++layer_ < grid.z) return;
  layer_ = 0;
  ++tier_;
}

void RunWriter::add_plane_digests(std::span<const Sha256Digest> digests) {
  const Size3 planes = levels_.brick_box(0, {0, 0, layer_}).size();
  if (tier_ != 0 || !slab_digests_.empty() ||
      static_cast<std::int64_t>(digests.size()) != planes.z) {
    misused("digests of other planes");
  }
  slab_digests_.assign(digests.begin(), digests.end());
}

void RunWriter::append_slab_trailer() {
  if (slab_digests_.empty()) misused("a layer without the digests of its planes");
  for (const Sha256Digest& digest : slab_digests_) planes_hasher_.add(digest);
  if (keeps_groups_) {
    group_digests_.insert(group_digests_.end(), slab_digests_.begin(), slab_digests_.end());
  }
  SlabTrailer trailer;
  trailer.build_id = header_.build_id;
  trailer.slab = static_cast<std::uint64_t>(layer_);
  trailer.model = model_count() - 1;
  trailer.lengths = std::exchange(slab_lengths_, {});
  trailer.plane_digests = std::exchange(slab_digests_, {});
  trailer.slab_crc = std::exchange(slab_crc_, 0);
  const Bytes bytes = encode_slab_trailer(trailer);
  index_.add_slab_trailer(static_cast<std::uint32_t>(bytes.size()));
  out_.append(bytes);
}

JournalGroup RunWriter::take_band(std::uint32_t voxels_crc, std::vector<Sha256Digest> digests) {
  if (!start_.is_band() || place_ != start_.end_place) misused("a band without its end");
  JournalGroup band;
  band.end_layer = layer_ + 1;
  band.voxels_crc = voxels_crc;
  band.file_bytes = out_.size();
  band.digest = out_.digest();
  band.squared_error = squared_error_;
  band.models = index_.root().models;
  band.pages = index_.root().tiers.front().pages;
  band.parents = std::exchange(group_parents_, {});
  band.plane_digests = std::move(digests);
  return band;
}

JournalGroup RunWriter::take_group(std::uint32_t voxels_crc) {
  if (place_ != 0 || tier_ > 1 || (tier_ == 1 && layer_ != 0)) misused("a group without its end");
  const IndexRoot& root = index_.root();
  const std::vector<PageRef>& pages = root.tiers.front().pages;
  const std::int64_t before = group_end_ - start_.layer;  // layers
  JournalGroup group;
  group.end_layer = tier_ == 0 ? layer_ : layer_count();
  group.voxels_crc = voxels_crc;
  group.file_bytes = out_.size();
  group.digest = out_.digest();
  group.squared_error = squared_error_;
  for (const ModelRef& model : root.models) {
    if (model.first_slab >= group_end_) group.models.push_back(model);
  }
  group.slab_trailer_bytes.assign(root.slab_trailer_bytes.begin() + before,
                                  root.slab_trailer_bytes.end());
  group.pages.assign(pages.begin() + before * root.tiers.front().layer_pages, pages.end());
  group.parents = std::exchange(group_parents_, {});
  group.plane_digests = std::exchange(group_digests_, {});
  group_end_ = group.end_layer;
  return group;
}

void RunWriter::take_over(const JournalGroup& group) {
  for (const ModelRef& model : group.models) index_.add_model(model);
  for (const std::uint32_t bytes : group.slab_trailer_bytes) index_.add_slab_trailer(bytes);
  for (const PageRef& page : group.pages) index_.restore_page(page);
  for (const Sha256Digest& digest : group.plane_digests) planes_hasher_.add(digest);
  squared_error_ = group.squared_error;
  layer_ = group_end_ = group.end_layer;
  if (layer_ < layer_count()) return;
  layer_ = 0;
  tier_ = 1;
}

Sha256Digest RunWriter::voxel_digest() const {
  Sha256 hasher = planes_hasher_;
  return hasher.digest();
}

}  // namespace octavo
