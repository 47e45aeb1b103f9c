#include "octavo/file/verify.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "octavo/core/crc32c.h"
#include "octavo/core/sha256.h"
#include "octavo/file/brick_check.h"
#include "octavo/file/byte_codec.h"
#include "octavo/file/layer_order.h"
#include "octavo/file/open_file.h"
#include "octavo/file/plane_digests.h"
#include "octavo/file/slab_trailer.h"
#include "octavo/file/storage/read_twice.h"
#include "octavo/file/thumbnail_check.h"

namespace octavo {

namespace {

// The steps in whose order damages are reported.
enum class Step { parts, metadata, models, slab_trailers, bricks };

// Bricks are found tier by tier.
int step_of(int tier) { return static_cast<int>(Step::bricks) + tier; }

constexpr std::size_t kBlockBytes = std::size_t{1} << 20;
constexpr const char* kOtherOrder =
    "its axis order is another one than that of the first model: coarse levels are not of a piece";

void run_in_order(std::int64_t count, const std::function<void(std::int64_t)>& task) {
  for (std::int64_t i = 0; i < count; ++i) task(i);
}

VerifyOptions with_defaults(VerifyOptions options) {
  if (!options.for_each) options.for_each = run_in_order;
  if (!options.make_hasher) options.make_hasher = [] { return std::make_unique<Sha256>(); };
  return options;
}

class Verifier {
 public:
  Verifier(std::shared_ptr<const ByteSource> source, const WorkPart& part,
           const VerifyOptions& options, Progress& progress)
      : file_(std::move(source), {.asks_again = false}),
        options_(with_defaults(options)),
        progress_(progress),
        planes_(file_.description(), file_.levels(), options_.make_hasher) {
    const FileHeader& header = file_.header();
    found_.part = part;
    found_.file = {header.build_id, header.file_bytes, file_.trailer().crc,
                   file_.trailer().voxel_digest};
    found_.is_decoded = options_.decode;
    report_.file_bytes = header.file_bytes;
  }

  VerifiedPart run() {
    const WorkPart& part = found_.part;
    const auto slabs = static_cast<std::int64_t>(file_.root().slab_trailer_bytes.size());
    std::uint64_t total = start_of_part(part.end_of(slabs)) - start_of_part(part.begin_of(slabs));
    for (const TierIndex& tier : file_.root().tiers) {
      for (const std::uint64_t bytes : tier.piece_bytes) {
        total += bytes / static_cast<std::uint64_t>(part.count);
      }
    }
    progress_.begin("verifying", static_cast<std::int64_t>(total), "bytes");
    check_stream();
    if (part.is_last()) {
      check_parts();
      check_metadata();
    }
    check_models();
    check_slab_trailers();
    check_bricks();
    if (part.is_last()) look_at_whole_file();
    progress_.end();
    found_.crc = file_crc_;
    return std::move(found_);
  }

 private:
  void add(Step step, Damage damage) { add(static_cast<int>(step), std::move(damage)); }

  void add(int step, Damage damage) {
    ++report_.damage_count;
    if (damage.is_repairable()) ++report_.repairable_count;
    if (report_.damages.size() >= options_.max_listed) return;
    report_.damages.push_back(std::move(damage));
    found_.steps.push_back(step);
  }

  // Where the bytes start that are read with a slab: those behind the slabs belong to the last one.
  std::uint64_t start_of_part(std::int64_t slab) const {
    const auto& trailers = file_.root().slab_trailer_bytes;
    if (slab == 0) return kHeaderBytes;
    if (slab == std::ssize(trailers)) return file_.header().file_bytes - kTrailerBytes;
    return file_.root().slab_trailer_offset(slab - 1) +
           trailers[static_cast<std::size_t>(slab - 1)];
  }

  void step(std::uint64_t bytes) {
    progress_.advance(static_cast<std::int64_t>(bytes));
    throw_if_cancelled();
  }

  void throw_if_cancelled() const {
    if (progress_.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
  }

  // Reads [begin, end) once, feeding the checksum of the file and `crc`.
  void stream(std::uint64_t begin, std::uint64_t end, std::uint32_t& crc) {
    found_.bytes_read += end - begin;
    for (std::uint64_t at = begin; at < end; at += block_.size()) {
      block_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kBlockBytes, end - at)));
      file_.source().read(at, block_);
      file_crc_ = crc32c(block_, file_crc_);
      crc = crc32c(block_, crc);
      step(block_.size());
    }
  }

  void check_stream();
  void look_at_whole_file();
  std::optional<Damage> pages_damage() const;
  std::optional<Damage> voxel_digest_damage() const;
  void check_parts();
  void check_metadata();
  void check_models();
  void check_slab_trailers();
  void check_slab_trailer(std::int64_t slab);
  static std::optional<Damage> slab_checksum_damage(const Damage& place, ByteSpan bytes);
  void check_slab_lengths(const SlabTrailer& trailer, std::int64_t slab) const;
  std::shared_ptr<const IndexPage> sound_page(int tier, std::size_t number) const;
  void check_bricks();
  std::int64_t check_page(int tier, std::size_t number);
  void check_layer(int tier, std::int64_t layer);
  void check_rows(int tier, const Box& rows, PlaneDigests* planes);
  void check_parents(int tier, const Box& bricks);
  void check_parents_in(const Index3& above, int tier, const Box& bricks);
  Damage sample_place(int tier, const Index3& sample) const;
  Damage page_place(int tier, std::size_t number) const;
  void add_other_parent(int tier, const Index3& brick, std::int64_t parent, std::int64_t sample);
  void report_layer(int tier, std::int64_t layer);
  void check_planes(std::int64_t slab, const std::vector<Sha256Digest>& found);

  OpenFile file_;
  VerifyOptions options_;
  Progress& progress_;
  PlaneDigests planes_;
  VerifiedPart found_;
  VerifyReport& report_ = found_.report;
  Bytes block_;
  std::uint32_t file_crc_ = 0;
  std::uint32_t pages_crc_ = 0;
  std::vector<std::uint32_t> part_crcs_;
  std::vector<std::uint32_t> slab_crcs_;  ///< 0 for those of other parts
  std::vector<bool> is_model_damaged_;
  std::vector<std::vector<Sha256Digest>> plane_digests_;  ///< of slabs whose trailer is whole
  // Of the layer that is being checked
  std::vector<bool> is_page_damaged_;
  std::mutex mutex_;
  std::map<std::int64_t, std::vector<Damage>> brick_damages_;  ///< by place; guarded by mutex_
  bool has_lost_voxels_ = false;                               ///< guarded by mutex_
  /// What its bricks determine of the next tier, [y][x]; each written by one thread.
  std::vector<std::optional<std::int64_t>> parents_;
};

// One pass over the bytes of this part: their checksum, and that of every slab.
void Verifier::check_stream() {
  const IndexRoot& root = file_.root();
  const auto slabs = static_cast<std::int64_t>(root.slab_trailer_bytes.size());
  slab_crcs_.resize(root.slab_trailer_bytes.size());
  std::uint32_t unused = 0;
  const std::int64_t end = found_.part.end_of(slabs);
  for (std::int64_t slab = found_.part.begin_of(slabs); slab < end; ++slab) {
    const std::uint64_t at = start_of_part(slab);
    const std::uint64_t trailer = root.slab_trailer_offset(slab);
    stream(at, trailer, slab_crcs_[static_cast<std::size_t>(slab)]);
    stream(trailer, trailer + root.slab_trailer_bytes[static_cast<std::size_t>(slab)], unused);
  }
  if (!found_.part.is_last()) return;
  const Section& pages = file_.header().pages;
  const std::uint64_t behind_slabs =
      root.slab_trailer_offset(slabs - 1) + root.slab_trailer_bytes.back();
  stream(behind_slabs, pages.offset, unused);
  stream(pages.offset, pages.end(), pages_crc_);
  for (const PartEntry& part : file_.parts()) {
    std::uint32_t crc = 0;
    stream(part.bytes.offset, part.bytes.end(), crc);
    part_crcs_.push_back(crc);
  }
  stream(file_.header().directory.offset, file_.header().file_bytes - kTrailerBytes, unused);
}

// What can only be damaged where nothing else is. Other parts may find that something is: what
// cannot be read then is theirs to report.
void Verifier::look_at_whole_file() {
  if (report_.damage_count > 0) return;
  found_.pages = pages_damage();
  try {
    found_.voxel_digest = voxel_digest_damage();
    if (options_.decode) found_.thumbnail = thumbnail_damage(file_, progress_);
  } catch (const Error& error) {
    require_damage(error);
  }
}

// Index pages that were changed together with their own checksums.
std::optional<Damage> Verifier::pages_damage() const {
  const Section& pages = file_.header().pages;
  Damage place;
  place.what = "index pages";
  place.offset = pages.offset;
  place.length = pages.length;
  return checksum_damage(place, pages_crc_, pages.crc);
}

// The digests of the planes are those of the voxels: what is left is their own.
std::optional<Damage> Verifier::voxel_digest_damage() const {
  const Sha256Digest found = voxel_digest_of(file_.plane_digests());
  if (digest_matches(found, file_.trailer().voxel_digest)) return std::nullopt;
  Damage place;
  place.what = "file";
  place.offset = file_.header().file_bytes - kTrailerBytes;
  place.length = kTrailerBytes;
  return damaged(place, "voxel digest " + hex_text(file_.trailer().voxel_digest) +
                            ", but that of its planes is " + hex_text(found));
}

void Verifier::check_parts() {
  for (std::size_t i = 0; i < part_crcs_.size(); ++i) {
    const PartEntry& part = file_.parts()[i];
    Damage place;
    place.what = name_of(part.tag);
    place.code = i;
    // A thumbnail is proven to be a picture of the voxels; nothing is known of other parts.
    place.proof = part.tag == kThumbnailTag ? OtherProof::content : OtherProof::none;
    place.offset = part.bytes.offset;
    place.length = part.bytes.length;
    if (auto damage = checksum_damage(place, part_crcs_[i], part.bytes.crc)) {
      damage->detail += "; no voxel depends on it";
      add(Step::parts, *damage);
    }
  }
}

// Their checksum was proven when the file was opened; what they say was not.
void Verifier::check_metadata() {
  const Metadata& metadata = file_.description().metadata;
  if (metadata.is_readable()) return;
  Damage place;
  place.what = "metadata";
  place.offset = file_.header().metadata.offset;
  place.length = file_.header().metadata.length;
  add(Step::metadata,
      damaged(place, "no JSON object: " + metadata.defect() + "; no voxel depends on it"));
}

// Every part has to know which are damaged; the last one reports them.
void Verifier::check_models() {
  const auto& models = file_.root().models;
  is_model_damaged_.resize(models.size());
  std::optional<AxisOrder> first_order;
  const bool is_last = found_.part.is_last();
  for (std::size_t i = 0; i < models.size(); ++i) {
    const Piece piece = file_.model_piece(static_cast<std::uint32_t>(i));
    const Bytes bytes = read_arriving(file_.source(), piece.offset, piece.length);
    Damage place;
    place.what = "model";
    place.proof = OtherProof::content;
    place.code = i;
    place.offset = piece.offset;
    place.length = piece.length;
    const std::uint32_t found =
        piece_crc(file_.header().build_id, piece.level, piece.code, bytes);
    std::optional<Damage> damage = checksum_damage(place, found, piece.crc);
    if (!damage) {
      try {
        const AxisOrder order = file_.parse_model_in(static_cast<std::uint32_t>(i), bytes)
                                    ->axis_order();
        if (!first_order) first_order = order;
        if (order != *first_order && is_last) add(Step::models, damaged(place, kOtherOrder));
      } catch (const Error& error) {
        require_damage(error.with_path(file_.source().name()));
        damage = damaged(place, error.detail());
      }
    }
    is_model_damaged_[i] = damage.has_value();
    if (!damage || !is_last) continue;
    damage->detail += "; the bricks coded with it cannot be read";
    add(Step::models, *damage);
  }
}

void Verifier::check_slab_trailers() {
  const auto count = static_cast<std::int64_t>(file_.root().slab_trailer_bytes.size());
  plane_digests_.resize(static_cast<std::size_t>(count));
  const std::int64_t end = found_.part.end_of(count);
  for (std::int64_t slab = found_.part.begin_of(count); slab < end; ++slab) {
    check_slab_trailer(slab);
  }
}

// A slab trailer ends in its own checksum.
std::optional<Damage> Verifier::slab_checksum_damage(const Damage& place, ByteSpan bytes) {
  constexpr std::size_t kChecksumBytes = 4;
  if (bytes.size() < kChecksumBytes) return std::nullopt;
  const ByteSpan checked = bytes.first(bytes.size() - kChecksumBytes);
  const auto stored = load_little_endian<std::uint32_t>(bytes.data() + checked.size());
  auto damage = checksum_damage(place, crc32c(checked), stored,
                                {place.offset, checked.size(), place.offset + checked.size()});
  if (damage) damage->detail += "; no voxel depends on it";
  return damage;
}

void Verifier::check_slab_trailer(std::int64_t slab) {
  const IndexRoot& root = file_.root();
  Damage place;
  place.what = kSlabTrailer;
  place.proof = OtherProof::checksums;
  place.code = static_cast<std::uint64_t>(slab);
  place.offset = root.slab_trailer_offset(slab);
  place.length = root.slab_trailer_bytes[static_cast<std::size_t>(slab)];
  const Bytes bytes = read_arriving(file_.source(), place.offset, place.length);
  if (auto damage = slab_checksum_damage(place, bytes)) return add(Step::slab_trailers, *damage);
  try {
    SlabTrailer trailer = file_.parse_trailer_of(slab, bytes);
    check_slab_lengths(trailer, slab);
    const std::uint32_t found = slab_crcs_[static_cast<std::size_t>(slab)];
    if (found != trailer.slab_crc && !found_.lying_slab_trailer) {
      found_.lying_slab_trailer = damaged(place, "states another checksum of its slab");
    }
    plane_digests_[static_cast<std::size_t>(slab)] = std::move(trailer.plane_digests);
  } catch (const Error& error) {
    require_damage(error);
    add(Step::slab_trailers, damaged(place, error.detail()));
  }
}

// The page, or nothing where it is damaged: check_page reports that.
std::shared_ptr<const IndexPage> Verifier::sound_page(int tier, std::size_t number) const {
  try {
    return file_.page(tier, number);
  } catch (const Error& error) {
    require_damage(error);
    return nullptr;
  }
}

void Verifier::check_slab_lengths(const SlabTrailer& trailer, std::int64_t slab) const {
  const TierIndex& tier = file_.root().tiers.front();
  for (std::int64_t p = 0; p < tier.layer_pages; ++p) {
    const auto number = static_cast<std::size_t>(slab * tier.layer_pages + p);
    const auto page = sound_page(0, number);
    if (!page) continue;
    for (std::size_t i = 0; i < page->ranges.size(); ++i) {
      const auto place = static_cast<std::int64_t>(i);
      const BrickEntry entry = file_.entry_in_page(*page, 0, number, place);
      const auto at = static_cast<std::size_t>(tier.first_place(number) + place);
      if (trailer.lengths[at] != entry.pieces.front().length) {
        throw Error(ErrorKind::corrupt, "slab trailer: contradicts the index");
      }
    }
  }
}

void Verifier::check_bricks() {
  const auto& tiers = file_.root().tiers;
  for (std::size_t tier = 0; tier < tiers.size(); ++tier) {
    const Size3& grid = tiers[tier].grid;
    const std::int64_t end = found_.part.end_of(grid.z);
    for (std::int64_t layer = found_.part.begin_of(grid.z); layer < end; ++layer) {
      report_.brick_count += grid.x * grid.y;
      check_layer(static_cast<int>(tier), layer);
    }
  }
}

// The pages of a layer, then its bricks: by rows, so that whole planes come together.
void Verifier::check_layer(int tier, std::int64_t layer) {
  const TierIndex& index = file_.root().tiers[static_cast<std::size_t>(tier)];
  std::int64_t unreachable = 0;
  is_page_damaged_.assign(static_cast<std::size_t>(index.layer_pages), false);
  for (std::int64_t p = 0; p < index.layer_pages; ++p) {
    const std::int64_t lost =
        check_page(tier, static_cast<std::size_t>(layer * index.layer_pages + p));
    is_page_damaged_[static_cast<std::size_t>(p)] = lost > 0;
    unreachable += lost;
  }
  has_lost_voxels_ = unreachable > 0;
  parents_.assign(static_cast<std::size_t>(index.grid.x * index.grid.y), std::nullopt);
  const bool has_planes = tier == 0 && options_.decode;
  if (has_planes) {
    planes_.begin_layer(layer);
    for (Box rows = planes_.next_bricks(); !rows.is_empty(); rows = planes_.next_bricks()) {
      check_rows(tier, rows, &planes_);
      planes_.add_rows(options_.for_each);
    }
  } else {
    check_rows(tier, {{0, 0, layer}, {index.grid.x, index.grid.y, layer + 1}}, nullptr);
  }
  check_parents(tier, {{0, 0, layer}, {index.grid.x, index.grid.y, layer + 1}});
  report_layer(tier, layer);
  if (has_planes) check_planes(layer, planes_.digests());
}

// Bricks [rows.lo, rows.hi), on all threads.
void Verifier::check_rows(int tier, const Box& rows, PlaneDigests* planes) {
  const Size3 count = rows.size();
  const TierIndex& index = file_.root().tiers[static_cast<std::size_t>(tier)];
  options_.for_each(count.x * count.y, [&](std::int64_t i) {
    if (progress_.is_cancelled()) return;
    const Index3 brick{rows.lo.x + i % count.x, rows.lo.y + i / count.x, rows.lo.z};
    const std::int64_t place = place_in_layer(index.grid, brick);
    if (is_page_damaged_[static_cast<std::size_t>(place / kPageBricks)]) return;
    const BrickEntry entry = file_.entry_at(tier, brick);
    CheckedBrick checked =
        check_brick(file_, entry, {options_.decode && !is_model_damaged_[entry.model], planes});
    parents_[static_cast<std::size_t>(brick.y * index.grid.x + brick.x)] = checked.parent;
    if (checked.damages.empty()) return;
    const std::lock_guard lock(mutex_);
    has_lost_voxels_ = true;
    brick_damages_.emplace(place, std::move(checked.damages));
  });
  throw_if_cancelled();
}

// What the bricks of a layer determine of the next tier, against what that holds.
void Verifier::check_parents(int tier, const Box& bricks) {
  if (!options_.decode || tier + 1 == file_.levels().tier_count()) return;
  const Size3 side = file_.levels().brick_side(tier + 1);
  const Index3 first{bricks.lo.x / side.x, bricks.lo.y / side.y, bricks.lo.z / side.z};
  const std::int64_t count_x = (bricks.hi.x - 1) / side.x - first.x + 1;
  const std::int64_t count_y = (bricks.hi.y - 1) / side.y - first.y + 1;
  options_.for_each(count_x * count_y, [&](std::int64_t i) {
    if (progress_.is_cancelled()) return;
    check_parents_in({first.x + i % count_x, first.y + i / count_x, first.z}, tier, bricks);
  });
  throw_if_cancelled();
}

// The same for what one brick of the next tier holds of it.
void Verifier::check_parents_in(const Index3& above, int tier, const Box& bricks) {
  const Box held = file_.levels().brick_box(tier + 1, above);
  std::vector<std::int64_t> samples;
  try {
    samples = parents_in(file_, file_.entry_at(tier + 1, above));
  } catch (const Error& error) {
    require_damage(error);  // reported with the tier that it stands in
    return;
  }
  const Box shared = intersection(held, bricks);
  for (Index3 at = shared.lo; at.y < shared.hi.y; ++at.y) {
    for (at.x = shared.lo.x; at.x < shared.hi.x; ++at.x) {
      const std::int64_t row = (at.z - held.lo.z) * held.size().y + at.y - held.lo.y;
      const std::int64_t sample =
          samples[static_cast<std::size_t>(row * held.size().x + at.x - held.lo.x)];
      const std::int64_t place = (at.y - bricks.lo.y) * bricks.size().x + at.x - bricks.lo.x;
      const auto& parent = parents_[static_cast<std::size_t>(place)];
      if (!parent || are_read_alike(file_.description(), *parent, sample)) continue;
      add_other_parent(tier, at, *parent, sample);
    }
  }
}

// Where a sample of the finest level of a tier stands: the piece of its brick that holds it, or the
// index page where that says all of the brick.
Damage Verifier::sample_place(int tier, const Index3& sample) const {
  const Size3 side = file_.levels().brick_side(tier);
  const Index3 brick{sample.x / side.x, sample.y / side.y, sample.z / side.z};
  const BrickEntry entry = file_.entry_at(tier, brick);
  for (std::size_t piece = 0; piece < entry.pieces.size() && !entry.is_uniform(); ++piece) {
    if (entry.pieces[piece].length > 0) return brick_place(entry, static_cast<int>(piece));
  }
  const TierIndex& index = file_.root().tiers[static_cast<std::size_t>(tier)];
  const std::int64_t number =
      brick.z * index.layer_pages + place_in_layer(index.grid, brick) / kPageBricks;
  return page_place(tier, static_cast<std::size_t>(number));
}

void Verifier::add_other_parent(int tier, const Index3& brick, std::int64_t parent,
                                std::int64_t sample) {
  const VolumeDescription& volume = file_.description();
  const std::string name = std::to_string(brick.x) + "," + std::to_string(brick.y) + "," +
                           std::to_string(brick.z);
  Damage damage = damaged(
      sample_place(tier + 1, brick),
      "sample " + name + " of level " + std::to_string(Levels::first_level(tier + 1)) + " is " +
          sample_text(volume, sample) + ", but the brick below makes it " +
          sample_text(volume, parent));
  const TierIndex& index = file_.root().tiers[static_cast<std::size_t>(tier)];
  const std::lock_guard lock(mutex_);
  brick_damages_[place_in_layer(index.grid, brick)] = {std::move(damage)};
}

// What was checked and found, in the order of the file; whole bricks of a damaged model are lost.
void Verifier::report_layer(int tier, std::int64_t layer) {
  const TierIndex& index = file_.root().tiers[static_cast<std::size_t>(tier)];
  const std::uint32_t model =
      tier == 0 ? file_.root().model_of_slab(layer) : file_.root().coarse_model();
  for (std::int64_t p = 0; p < index.layer_pages; ++p) {
    if (is_page_damaged_[static_cast<std::size_t>(p)]) continue;
    const auto number = static_cast<std::size_t>(layer * index.layer_pages + p);
    const auto page = file_.page(tier, number);
    for (const PieceRef& piece : page->pieces) {
      if (piece.length > 0) ++report_.piece_count;
      step(piece.length);
    }
    if (!is_model_damaged_[model]) continue;
    for (std::size_t i = 0; i < page->ranges.size(); ++i) {
      const bool is_uniform = page->ranges[i].min == page->ranges[i].max;
      const std::int64_t place = p * kPageBricks + static_cast<std::int64_t>(i);
      if (!is_uniform && !brick_damages_.contains(place)) ++report_.unreachable_brick_count;
    }
  }
  for (const auto& [place, damages] : brick_damages_) {
    ++report_.damaged_brick_count;
    for (const Damage& damage : damages) add(step_of(tier), damage);
  }
  brick_damages_.clear();
}

// What the slab trailer says of the voxels of its planes, where all of them are known.
void Verifier::check_planes(std::int64_t slab, const std::vector<Sha256Digest>& found) {
  const auto& stored = plane_digests_[static_cast<std::size_t>(slab)];
  const bool is_known =
      !has_lost_voxels_ && !is_model_damaged_[file_.root().model_of_slab(slab)];
  if (!is_known || stored.empty()) return;
  Damage place;
  place.what = "plane";
  place.offset = file_.root().slab_trailer_offset(slab);
  place.length = file_.root().slab_trailer_bytes[static_cast<std::size_t>(slab)];
  for (std::size_t z = 0; z < found.size(); ++z) {
    if (digest_matches(found[z], stored[z])) continue;
    place.code = static_cast<std::uint64_t>(slab * file_.levels().brick_side(0).z) + z;
    add(step_of(0), damaged(place, "its voxels have the SHA-256 " + hex_text(found[z]) +
                           ", the slab trailer says " + hex_text(stored[z])));
  }
}

Damage Verifier::page_place(int tier, std::size_t number) const {
  const PageRef& ref = file_.root().tiers[static_cast<std::size_t>(tier)].pages[number];
  Damage place;
  place.what = "index page";
  place.proof = OtherProof::content;
  place.tier = tier;
  place.code = number;
  place.offset = ref.offset;
  place.length = ref.length;
  return place;
}

// Proves a page. Returns the number of its bricks where they cannot be read.
std::int64_t Verifier::check_page(int tier, std::size_t number) {
  const PageRef& ref = file_.root().tiers[static_cast<std::size_t>(tier)].pages[number];
  const Damage place = page_place(tier, number);
  const Bytes bytes = read_arriving(file_.source(), ref.offset, ref.length);
  auto damage = checksum_damage(place, crc32c(bytes), ref.crc);
  if (!damage) {
    try {
      file_.page(tier, number);
    } catch (const Error& error) {
      require_damage(error);
      damage = damaged(place, error.detail());
    }
  }
  if (!damage) return 0;
  const std::int64_t lost = file_.root().tiers[static_cast<std::size_t>(tier)].brick_count(number);
  report_.unreachable_brick_count += lost;
  damage->detail += "; the bricks it lists cannot be read: " + std::to_string(lost);
  add(step_of(tier), *damage);
  return lost;
}

}  // namespace

VerifyReport verify_file(std::shared_ptr<const ByteSource> source, const VerifyOptions& options,
                         Progress& progress) {
  const auto verify = [&] {
    const VerifiedPart whole = Verifier(source, {}, options, progress).run();
    return joined_report({&whole, 1}, options.max_listed);
  };
  const ByteRange all{0, source->size()};
  return read_twice(*source, {&all, 1}, verify,
                    [](const VerifyReport& report) { return report.is_sound(); });
}

VerifiedPart verify_part(std::shared_ptr<const ByteSource> source, const WorkPart& part,
                         const VerifyOptions& options, Progress& progress) {
  require_part(part);
  const auto verify = [&] { return Verifier(source, part, options, progress).run(); };
  const ByteRange all{0, source->size()};
  return read_twice(*source, {&all, 1}, verify,
                    [](const VerifiedPart& own) { return own.report.is_sound(); });
}

}  // namespace octavo
