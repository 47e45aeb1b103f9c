#include "octavo/file/verify.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <mutex>
#include <utility>

#include "octavo/core/crc32c.h"
#include "octavo/core/sha256.h"
#include "octavo/file/byte_codec.h"
#include "octavo/file/layer_order.h"
#include "octavo/file/open_file.h"
#include "octavo/file/plane_digests.h"
#include "octavo/file/slab_trailer.h"
#include "octavo/file/thumbnail_check.h"

namespace octavo {

namespace {

constexpr std::size_t kBlockBytes = std::size_t{1} << 20;

void run_in_order(std::int64_t count, const std::function<void(std::int64_t)>& task) {
  for (std::int64_t i = 0; i < count; ++i) task(i);
}

VerifyOptions with_defaults(VerifyOptions options) {
  if (!options.for_each) options.for_each = run_in_order;
  if (!options.make_hasher) options.make_hasher = [] { return std::make_unique<Sha256>(); };
  return options;
}

// "brick o-code 0x1a3 level 5 at byte 81920", "index page 3 of tier 0 at byte 4711", ..
std::string place_text(const Damage& place) {
  if (place.what == "brick") {
    return describe(Piece{place.offset, place.length, 0, place.level, place.code});
  }
  const bool is_numbered = place.what != "metadata" && place.what != "file" &&
                           place.what != "index pages";
  std::string text = place.what;
  if (is_numbered) text += " " + std::to_string(place.code);
  if (place.what == "index page") text += " of tier " + std::to_string(place.tier);
  return text + " at byte " + std::to_string(place.offset);
}

// `place` with what is wrong there; parsers name the part themselves, which is said once.
Damage damaged(Damage place, const std::string& problem) {
  const std::string name = place.what + ": ";
  const bool has_name = problem.compare(0, name.size(), name) == 0;
  place.detail = place_text(place) + ": " + (has_name ? problem.substr(name.size()) : problem);
  return place;
}

// Compares two checksums; says what one flipped bit would explain.
std::optional<Damage> checksum_damage(Damage place, std::uint32_t found, std::uint32_t stored,
                                      const CheckedBytes& checked) {
  if (checksum_matches(found, stored)) return std::nullopt;
  place.found = found;
  place.stored = stored;
  if (const auto flip = locate_bit_flip(found, stored, checked)) {
    place.flipped_byte = flip->byte;
    place.flipped_bit = flip->bit;
  }
  return damaged(std::move(place), describe_checksums(found, stored, checked));
}

std::optional<Damage> checksum_damage(const Damage& place, std::uint32_t found,
                                      std::uint32_t stored) {
  return checksum_damage(place, found, stored, {place.offset, place.length});
}

// Whether the finite ones of `count` floats lie between the voxels that codes stand for.
bool are_bounded(const VolumeDescription& volume, const ValueRange& codes, const void* voxels,
                 std::int64_t count) {
  const double low = volume.voxel_of(codes.min);
  const double high = volume.voxel_of(codes.max);
  const float* const first = static_cast<const float*>(voxels);
  const auto is_bounded = [&](float v) { return !std::isfinite(v) || (v >= low && v <= high); };
  return std::all_of(first, first + count, is_bounded);
}

// Smallest and largest of `count` voxels.
ValueRange range_of(VoxelType type, const void* voxels, std::int64_t count) {
  return with_voxel_type(type, [&](auto tag) -> ValueRange {
    using T = typename decltype(tag)::type;
    const T* first = static_cast<const T*>(voxels);
    const auto [low, high] = std::minmax_element(first, first + count);
    return {static_cast<std::int64_t>(*low), static_cast<std::int64_t>(*high)};
  });
}

// What cannot be read because the disk fails is no damage; passes that on.
void require_damage(const Error& error) {
  if (error.kind() == ErrorKind::corrupt || error.kind() == ErrorKind::limit_exceeded) return;
  throw error;
}

class Verifier {
 public:
  Verifier(std::shared_ptr<const ByteSource> source, const VerifyOptions& options,
           Progress& progress)
      : file_(std::move(source), {}),
        options_(with_defaults(options)),
        progress_(progress),
        planes_(file_.description(), file_.levels(), options_.make_hasher) {
    report_.file_bytes = file_.header().file_bytes;
  }

  VerifyReport run() {
    std::uint64_t total = file_.header().file_bytes - kHeaderBytes - kTrailerBytes;
    for (const TierIndex& tier : file_.root().tiers) {
      for (const std::uint64_t bytes : tier.piece_bytes) total += bytes;
    }
    progress_.begin("verifying", static_cast<std::int64_t>(total), "bytes");
    check_stream();
    check_parts();
    check_metadata();
    check_models();
    check_slab_trailers();
    check_bricks();
    if (lying_slab_trailer_ && report_.damage_count == 0) add(*lying_slab_trailer_);
    if (report_.damage_count == 0) check_file_crc();
    if (report_.damage_count == 0) check_voxel_digest();
    const bool is_read = options_.decode && report_.is_sound();
    if (const auto odd = is_read ? thumbnail_damage(file_, progress_) : std::nullopt) add(*odd);
    progress_.end();
    return std::move(report_);
  }

 private:
  void add(Damage damage) {
    ++report_.damage_count;
    if (damage.is_repairable()) ++report_.repairable_count;
    if (report_.damages.size() < options_.max_listed) report_.damages.push_back(std::move(damage));
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
    for (std::uint64_t at = begin; at < end; at += block_.size()) {
      block_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kBlockBytes, end - at)));
      file_.source().read(at, block_);
      file_crc_ = crc32c(block_, file_crc_);
      crc = crc32c(block_, crc);
      step(block_.size());
    }
  }

  void check_stream();
  void check_file_crc();
  void check_voxel_digest();
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
  void report_layer(int tier, std::int64_t layer);
  void check_planes(std::int64_t slab, const std::vector<Sha256Digest>& found, bool is_whole);
  OtherProof proof_of(const BrickEntry& entry, std::size_t in_brick_level) const;
  std::vector<Damage> check_brick(const BrickEntry& entry, PlaneDigests* planes) const;
  std::optional<Damage> check_voxels(const BrickEntry& entry, Damage place,
                                     std::span<const Bytes> pieces, PlaneDigests* planes) const;

  OpenFile file_;
  VerifyOptions options_;
  Progress& progress_;
  PlaneDigests planes_;
  VerifyReport report_;
  Bytes block_;
  std::uint32_t file_crc_ = 0;
  std::uint32_t pages_crc_ = 0;
  std::vector<std::uint32_t> part_crcs_;
  std::vector<std::uint32_t> slab_crcs_;
  std::vector<bool> is_model_damaged_;
  std::vector<std::vector<Sha256Digest>> plane_digests_;  ///< of slabs whose trailer is whole
  // Of the layer that is being checked
  std::vector<bool> is_page_damaged_;
  std::mutex mutex_;
  std::map<std::int64_t, std::vector<Damage>> brick_damages_;  ///< by place; guarded by mutex_
  /// A slab whose checksum differs; reported only when none of its segments is found damaged.
  std::optional<Damage> lying_slab_trailer_;
};

// One pass over all bytes between header and trailer: the digest, and the checksum of every slab.
void Verifier::check_stream() {
  const IndexRoot& root = file_.root();
  std::uint64_t at = kHeaderBytes;
  std::uint32_t unused = 0;
  for (std::size_t slab = 0; slab < root.slab_trailer_bytes.size(); ++slab) {
    std::uint32_t crc = 0;
    const std::uint64_t trailer = root.slab_trailer_offset(static_cast<std::int64_t>(slab));
    stream(at, trailer, crc);
    slab_crcs_.push_back(crc);
    at = trailer + root.slab_trailer_bytes[slab];
    stream(trailer, at, unused);
  }
  const Section& pages = file_.header().pages;
  stream(at, pages.offset, unused);
  stream(pages.offset, pages.end(), pages_crc_);
  for (const PartEntry& part : file_.parts()) {
    std::uint32_t crc = 0;
    stream(part.bytes.offset, part.bytes.end(), crc);
    part_crcs_.push_back(crc);
  }
  stream(file_.header().directory.offset, file_.header().file_bytes - kTrailerBytes, unused);
}

// What no section of the file explains: bytes changed together with their own checksum.
void Verifier::check_file_crc() {
  const Section& pages = file_.header().pages;
  Damage place;
  place.what = "index pages";
  place.offset = pages.offset;
  place.length = pages.length;
  if (auto damage = checksum_damage(place, pages_crc_, pages.crc)) return add(*damage);
  place.what = "file";
  place.offset = kHeaderBytes;
  place.length = file_.header().file_bytes - kHeaderBytes - kTrailerBytes;
  if (auto damage = checksum_damage(place, file_crc_, file_.trailer().crc)) add(*damage);
}

// The digests of the planes are those of the voxels: what is left is their own.
void Verifier::check_voxel_digest() {
  std::vector<Sha256Digest> all;
  for (const auto& of_slab : plane_digests_) all.insert(all.end(), of_slab.begin(), of_slab.end());
  const Sha256Digest found = voxel_digest_of(all);
  if (digest_matches(found, file_.trailer().voxel_digest)) return;
  Damage place;
  place.what = "file";
  place.offset = file_.header().file_bytes - kTrailerBytes;
  place.length = kTrailerBytes;
  add(damaged(place, "voxel digest " + hex_text(file_.trailer().voxel_digest) +
                         ", but that of its planes is " + hex_text(found)));
}

void Verifier::check_parts() {
  for (std::size_t i = 0; i < part_crcs_.size(); ++i) {
    const PartEntry& part = file_.parts()[i];
    Damage place;
    place.what = "part";
    place.code = i;
    place.proof = OtherProof::none;  // nothing but the checksum proves them
    place.offset = part.bytes.offset;
    place.length = part.bytes.length;
    if (auto damage = checksum_damage(place, part_crcs_[i], part.bytes.crc)) {
      damage->detail += "; no voxel depends on it";
      add(*damage);
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
  add(damaged(place, "no JSON object: " + metadata.defect() + "; no voxel depends on it"));
}

void Verifier::check_models() {
  const auto& models = file_.root().models;
  is_model_damaged_.resize(models.size());
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
        const VolumeDescription& volume = file_.description();
        parse_model(volume.kind, volume.coded_type(), volume.coding, bytes,
                    file_.header().detail_level);
      } catch (const Error& error) {
        require_damage(error.with_path(file_.source().name()));
        damage = damaged(place, error.detail());
      }
    }
    is_model_damaged_[i] = damage.has_value();
    if (!damage) continue;
    damage->detail += "; the bricks coded with it cannot be read";
    add(*damage);
  }
}

void Verifier::check_slab_trailers() {
  const std::size_t count = file_.root().slab_trailer_bytes.size();
  plane_digests_.resize(count);
  for (std::size_t slab = 0; slab < count; ++slab) {
    check_slab_trailer(static_cast<std::int64_t>(slab));
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
  if (auto damage = slab_checksum_damage(place, bytes)) return add(*damage);
  try {
    SlabTrailer trailer = file_.parse_trailer_of(slab, bytes);
    check_slab_lengths(trailer, slab);
    const std::uint32_t found = slab_crcs_[static_cast<std::size_t>(slab)];
    if (found != trailer.slab_crc && !lying_slab_trailer_) {
      lying_slab_trailer_ = damaged(place, "states another checksum of its slab");
    }
    plane_digests_[static_cast<std::size_t>(slab)] = std::move(trailer.plane_digests);
  } catch (const Error& error) {
    require_damage(error);
    add(damaged(place, error.detail()));
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
    report_.brick_count += file_.levels().brick_count(static_cast<int>(tier));
    for (std::int64_t layer = 0; layer < tiers[tier].grid.z; ++layer) {
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
  const bool is_whole = unreachable == 0 && brick_damages_.empty();
  report_layer(tier, layer);
  if (has_planes) check_planes(layer, planes_.digests(), is_whole);
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
    std::vector<Damage> damages = check_brick(file_.entry_at(tier, brick), planes);
    if (damages.empty()) return;
    const std::lock_guard lock(mutex_);
    brick_damages_.emplace(place, std::move(damages));
  });
  throw_if_cancelled();
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
    for (const Damage& damage : damages) add(damage);
  }
  brick_damages_.clear();
}

// What the slab trailer says of the voxels of its planes, where all of them are known.
void Verifier::check_planes(std::int64_t slab, const std::vector<Sha256Digest>& found,
                            bool is_whole) {
  const auto& stored = plane_digests_[static_cast<std::size_t>(slab)];
  const bool is_known = is_whole && !is_model_damaged_[file_.root().model_of_slab(slab)];
  if (!is_known || stored.empty()) return;
  Damage place;
  place.what = "plane";
  place.offset = file_.root().slab_trailer_offset(slab);
  place.length = file_.root().slab_trailer_bytes[static_cast<std::size_t>(slab)];
  for (std::size_t z = 0; z < found.size(); ++z) {
    if (digest_matches(found[z], stored[z])) continue;
    place.code = static_cast<std::uint64_t>(slab * file_.levels().brick_side(0).z) + z;
    add(damaged(place, "its voxels have the SHA-256 " + hex_text(found[z]) +
                           ", the slab trailer says " + hex_text(stored[z])));
  }
}

// Proves a page. Returns the number of its bricks where they cannot be read.
std::int64_t Verifier::check_page(int tier, std::size_t number) {
  const PageRef& ref = file_.root().tiers[static_cast<std::size_t>(tier)].pages[number];
  Damage place;
  place.what = "index page";
  place.proof = OtherProof::content;
  place.tier = tier;
  place.code = number;
  place.offset = ref.offset;
  place.length = ref.length;
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
  add(*damage);
  return lost;
}

// Of a stored brick, and of the coarsest level of a grey one, a segment holds voxels as they are.
OtherProof Verifier::proof_of(const BrickEntry& entry, std::size_t piece) const {
  const std::size_t last = entry.pieces.size() - 1;
  const bool is_stored = last > 0 && entry.pieces.back().length == 0;
  const bool is_coarsest = piece == last &&
                           file_.levels().tier_level_count(entry.tier) <= kTierPieces &&
                           file_.description().kind == VolumeKind::grey;
  // Of exact floats most bits are plain, and decoding takes them for what they are.
  const bool has_places = entry.tier == 0 && piece == 0 &&
                          file_.description().codec_type() == VoxelType::float32;
  return is_stored || is_coarsest || has_places ? OtherProof::range : OtherProof::content;
}

// Checksums of all pieces of a brick; if they hold, its voxels, which `planes` gets, if any.
std::vector<Damage> Verifier::check_brick(const BrickEntry& entry, PlaneDigests* planes) const {
  std::vector<Damage> damages;
  if (entry.is_uniform()) {
    if (planes != nullptr) planes->put_uniform(entry.brick, entry.range.min);
    return damages;
  }
  std::array<Bytes, kTierPieces> pieces;
  Damage place;
  place.what = "brick";
  place.tier = entry.tier;
  place.brick = entry.brick;
  place.code = entry.code;
  for (std::size_t i = 0; i < entry.pieces.size(); ++i) {
    const BrickEntry::StoredPiece& piece = entry.pieces[i];
    if (piece.length == 0) continue;
    place.level = Levels::first_level(entry.tier) + static_cast<int>(i);
    place.offset = piece.offset;
    place.length = piece.length;
    place.proof = proof_of(entry, i);
    pieces[i] = read_arriving(file_.source(), piece.offset, piece.length);
    const std::uint32_t found =
        piece_crc(file_.header().build_id, place.level, entry.code, pieces[i]);
    if (auto damage = checksum_damage(place, found, piece.crc)) damages.push_back(*damage);
  }
  if (!damages.empty() || !options_.decode || is_model_damaged_[entry.model]) return damages;
  place.level = Levels::first_level(entry.tier);
  place.offset = entry.pieces.front().offset;
  place.length = entry.pieces.front().length;
  const auto all = std::span<const Bytes>(pieces).first(entry.pieces.size());
  if (auto damage = check_voxels(entry, place, all, planes)) damages.push_back(*damage);
  return damages;
}

std::optional<Damage> Verifier::check_voxels(const BrickEntry& entry, Damage place,
                                             std::span<const Bytes> pieces,
                                             PlaneDigests* planes) const {
  const BrickShape shape = brick_shape(file_.levels(), entry.tier, entry.brick);
  const VolumeDescription& volume = file_.description();
  const VoxelType type = volume.codec_type();
  const std::int64_t count = shape.size.front().voxel_count();
  Bytes voxels(static_cast<std::size_t>(count * bytes_per_voxel(type)));
  try {
    const auto segments = segments_of(pieces, shape.level_count);
    file_.codec(entry.model)->decode(
        shape, type, entry.range,
        std::span(segments).first(static_cast<std::size_t>(shape.level_count)), 0, voxels.data());
  } catch (const Error& error) {
    require_damage(error);
    return damaged(std::move(place), error.detail());
  }
  if (planes != nullptr) planes->put(entry.brick, voxels.data());
  if (!is_integer(type)) {
    if (are_bounded(volume, entry.range, voxels.data(), count)) return std::nullopt;
    return damaged(std::move(place), "its voxels lie outside the range in the index");
  }
  const ValueRange found = range_of(type, voxels.data(), count);
  const bool is_inside = found.min >= entry.range.min && found.max <= entry.range.max;
  // Of lossy files the index may hold bounds that are wider than the voxels.
  const bool may_differ = is_inside && has_errors(file_.header(), entry.tier);
  if (found == entry.range || may_differ) return std::nullopt;
  return damaged(std::move(place), "its voxels have another range than the index says");
}

}  // namespace

VerifyReport verify_file(std::shared_ptr<const ByteSource> source, const VerifyOptions& options,
                         Progress& progress) {
  return Verifier(std::move(source), options, progress).run();
}

}  // namespace octavo
