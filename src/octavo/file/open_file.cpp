#include "octavo/file/open_file.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "octavo/core/crc32c.h"
#include "octavo/file/bit_flip.h"
#include "octavo/file/layer_order.h"
#include "octavo/octree/o_code.h"

namespace octavo {

namespace {

constexpr std::uint64_t kPageCacheBytes = std::uint64_t{16} << 20;
constexpr std::uint64_t kCodecCacheCount = 64;

[[noreturn]] void fail_checksum(const std::string& what, std::uint32_t found, std::uint32_t stored,
                                std::uint64_t offset, std::uint64_t length) {
  const std::string checksums = describe_checksums(found, stored, {offset, length});
  throw Error(ErrorKind::corrupt, what + ": " + checksums, {}, offset);
}

void check_section(ByteSpan bytes, const Section& section, const char* what) {
  const std::uint32_t found = crc32c(bytes);
  if (checksum_matches(found, section.crc)) return;
  fail_checksum(what + std::string(" at byte ") + std::to_string(section.offset), found,
                section.crc, section.offset, section.length);
}

/// The bytes that are read behind the header.
/// Throws Error{limit_exceeded} for metadata that are too long.
ByteRange tail_of(const FileHeader& header, const ReaderOptions& options) {
  if (header.metadata.length > options.max_metadata_bytes) {
    throw Error(ErrorKind::limit_exceeded,
                "metadata of " + std::to_string(header.metadata.length) + " bytes; the limit is " +
                    std::to_string(options.max_metadata_bytes));
  }
  const bool has_pages = header.file_bytes - header.pages.offset <= options.max_tail_bytes;
  const std::uint64_t start = has_pages ? header.pages.offset : header.directory.offset;
  return {start, header.file_bytes - start};
}

/// What is missing of the tail, and of what stands before it.
std::vector<ByteRange> tail_to_fetch(const ByteSource& source, ByteRange tail,
                                     const ReaderOptions& options) {
  if (source.missing({&tail, 1}).empty()) return {};
  const std::uint64_t lead = std::min(options.lead_bytes, tail.offset);
  tail = {tail.offset - lead, tail.length + lead};
  return joined(source.missing({&tail, 1}), {});
}

std::string text_of(ByteSpan bytes) {
  std::string text(bytes.begin(), bytes.end());
  text.erase(text.find_last_not_of(' ') + 1);
  return text;
}

}  // namespace

std::string describe(const Piece& piece) {
  char text[96];
  const auto code = static_cast<unsigned long long>(piece.code);
  const auto offset = static_cast<unsigned long long>(piece.offset);
  if (piece.level == kModelLevel) {
    std::snprintf(text, sizeof text, "model %llu at byte %llu", code, offset);
  } else {
    std::snprintf(text, sizeof text, "brick o-code 0x%llx level %d at byte %llu", code, piece.level,
                  offset);
  }
  return text;
}

// What `read` returns; its failures name the file.
template <class F>
auto OpenFile::named(F read) const {
  try {
    return read();
  } catch (const Error& error) {
    throw error.with_path(source_->name());
  }
}

// The same as asked_again.
template <class F>
auto OpenFile::named_again(const ByteRange& range, F read) const {
  return named([&] { return asked_again(range, read); });
}

OpenFile::OpenFile(std::shared_ptr<const ByteSource> source, const ReaderOptions& options)
    : source_(std::move(source)),
      asks_again_(options.asks_again),
      page_cache_(kPageCacheBytes),
      codec_cache_(kCodecCacheCount) {
  const std::uint64_t source_bytes = source_->size();
  const ByteRange all{0, source_bytes};
  named_again(all, [&] {
    header_ = parse_header(read_bytes(0, std::min(kHeaderBytes, source_bytes)), source_bytes);
    levels_ = Levels(header_.description.size, header_.halvings);
    read_tail(options);
  });
}

void OpenFile::read_tail(const ReaderOptions& options) {
  const ByteRange range = tail_of(header_, options);
  const std::uint64_t start = range.offset;
  const bool has_pages = start == header_.pages.offset;
  // A tail that is not kept would be sent twice.
  const std::vector<ByteRange> ahead = tail_to_fetch(*source_, range, options);
  if (total_bytes(ahead) <= source_->fetched_bytes_kept()) source_->fetch(ahead);
  const Bytes tail = read_bytes(start, range.length);
  const auto part = [&](const Section& section) {
    return ByteSpan(tail).subspan(section.offset - start, section.length);
  };

  trailer_ = parse_trailer(ByteSpan(tail).last(kTrailerBytes), header_);
  check_section(part(header_.directory), header_.directory, "directory");
  parts_ = parse_directory(part(header_.directory), header_);
  check_section(part(header_.root), header_.root, "index root");
  root_ = parse_root(part(header_.root), levels_, header_);
  check_section(part(header_.metadata), header_.metadata, "metadata");
  header_.description.metadata = Metadata::read(text_of(part(header_.metadata)));
  if (has_pages) pages_.assign(tail.begin(), tail.begin() + static_cast<std::ptrdiff_t>(
                                                                header_.pages.length));
}

Bytes OpenFile::read_bytes(std::uint64_t offset, std::uint64_t length) const {
  return read_arriving(*source_, offset, length);
}

std::size_t OpenFile::page_of(int tier_number, const Index3& position) const {
  const TierIndex& tier = root_.tiers[static_cast<std::size_t>(tier_number)];
  return static_cast<std::size_t>(position.z * tier.layer_pages +
                                  place_in_layer(tier.grid, position) / kPageBricks);
}

ByteRange OpenFile::page_range(int tier, std::size_t number) const {
  const PageRef& ref = root_.tiers[static_cast<std::size_t>(tier)].pages[number];
  return {ref.offset, ref.length};
}

bool OpenFile::has_page(int tier, std::size_t number) const {
  if (!pages_.empty() || page_cache_.find({static_cast<std::uint64_t>(tier), number})) return true;
  const ByteRange range = page_range(tier, number);
  return source_->missing({&range, 1}).empty();
}

std::shared_ptr<const IndexPage> OpenFile::page(int tier, std::size_t number) const {
  const LruCache<IndexPage>::Key key{static_cast<std::uint64_t>(tier), number};
  if (auto kept = page_cache_.find(key)) return kept;
  const PageRef& ref = root_.tiers[static_cast<std::size_t>(tier)].pages[number];
  const Section section{ref.offset, ref.length, ref.crc};
  bool is_first = true;
  return named_again({ref.offset, ref.length}, [&] {
    const bool is_kept = std::exchange(is_first, false) && !pages_.empty();
    const Bytes read = is_kept ? Bytes{} : read_bytes(section.offset, section.length);
    const ByteSpan bytes = is_kept ? ByteSpan(pages_).subspan(section.offset - header_.pages.offset,
                                                              section.length)
                                   : ByteSpan(read);
    check_section(bytes, section, "index page");
    auto page = std::make_shared<const IndexPage>(
        parse_page(bytes, root_, levels_, tier, number, header_));
    page_cache_.insert(key, page, page->memory_bytes());
    return page;
  });
}

Piece OpenFile::model_piece(std::uint32_t model) const {
  const ModelRef& ref = root_.models[model];
  return {ref.offset, ref.length, ref.crc, kModelLevel, model};
}

Piece OpenFile::piece_of(const BrickEntry& entry, int piece) const {
  const BrickEntry::StoredPiece& stored = entry.pieces[static_cast<std::size_t>(piece)];
  return {stored.offset, stored.length, stored.crc, Levels::first_level(entry.tier) + piece,
          entry.code};
}

bool OpenFile::has_codec(std::uint32_t model) const {
  if (codec_cache_.find({0, model})) return true;
  const Piece piece = model_piece(model);
  const ByteRange range{piece.offset, piece.length};
  return source_->missing({&range, 1}).empty();
}

std::shared_ptr<const BrickCodec> OpenFile::codec(std::uint32_t model) const {
  const LruCache<BrickCodec>::Key key{0, model};
  if (auto kept = codec_cache_.find(key)) return kept;
  const std::lock_guard lock(codec_mutex_);
  if (auto kept = codec_cache_.find(key)) return kept;
  const Piece piece = model_piece(model);
  const Bytes bytes = read_piece(piece);
  try {
    const std::shared_ptr<const BrickCodec> codec = parse_model_in(model, bytes);
    codec_cache_.insert(key, codec, 1);
    return codec;
  } catch (const Error& error) {
    throw Error(error.kind(), describe(piece) + ": " + error.detail(), source_->name(),
                piece.offset);
  }
}

std::shared_ptr<const BrickCodec> OpenFile::parse_model_in(std::uint32_t model,
                                                           ByteSpan bytes) const {
  std::shared_ptr<const BrickCodec> codec =
      parse_model(description().kind, description().coded_type(), description().coding, bytes,
                  header_.detail_level);
  if (codec->is_lossless()) return codec;
  if (header_.max_error == 0) {
    throw Error(ErrorKind::corrupt, "leaves out precision in a file without a max error");
  }
  if (levels_.tier_count() > 1 && model == root_.coarse_model()) {
    throw Error(ErrorKind::corrupt, "leaves out precision of coarse levels");
  }
  return codec;
}

Bytes OpenFile::read_piece(const Piece& piece) const {
  Bytes bytes;
  read_piece(piece, bytes);
  return bytes;
}

void OpenFile::read_piece(const Piece& piece, Bytes& bytes) const {
  named_again({piece.offset, piece.length}, [&] {
    read_arriving(*source_, piece.offset, piece.length, bytes);
    const std::uint32_t found = piece_crc(header_.build_id, piece.level, piece.code, bytes);
    if (!checksum_matches(found, piece.crc)) {
      fail_checksum(describe(piece), found, piece.crc, piece.offset, piece.length);
    }
  });
}

void OpenFile::read_within(const Piece& piece, std::uint64_t offset, std::uint64_t length,
                           Bytes& bytes) const {
  named([&] { read_arriving(*source_, piece.offset + offset, length, bytes); });
}

// Pieces of a brick stand far apart: where each of them takes a wait, they are waited for together.
void OpenFile::fetch_pieces(const BrickEntry& entry, int first) const {
  if (source_->fetched_bytes_kept() == 0) return;
  std::vector<ByteRange> pieces;
  for (std::size_t i = static_cast<std::size_t>(first); i < entry.pieces.size(); ++i) {
    pieces.push_back({entry.pieces[i].offset, entry.pieces[i].length});
  }
  const std::vector<ByteRange> missing = source_->missing(pieces);
  if (missing.size() > 1) source_->fetch(joined(missing, {}));
}

BrickBytes OpenFile::read_segments(const BrickEntry& entry, int in_brick_level) const {
  BrickBytes bytes;
  for (Bytes& piece : *bytes.pieces) piece.clear();
  const auto count = static_cast<int>(entry.pieces.size());
  // A brick without coarsest samples holds all its voxels in the finest segment.
  const int first = entry.pieces.back().length == 0 ? 0 : piece_of_level(in_brick_level);
  fetch_pieces(entry, first);
  for (int i = first; i < count; ++i) {
    const Piece piece = piece_of(entry, i);
    if (piece.length > 0) read_piece(piece, (*bytes.pieces)[static_cast<std::size_t>(i)]);
  }
  try {
    bytes.segments =
        segments_of(std::span(std::as_const(*bytes.pieces)).first(entry.pieces.size()),
                    levels_.tier_level_count(entry.tier));
  } catch (const Error& error) {
    const Piece piece = piece_of(entry, count - 1);
    throw Error(error.kind(), describe(piece) + ": " + error.detail(), source_->name(),
                piece.offset);
  }
  return bytes;
}

SlabTrailer OpenFile::parse_trailer_of(std::int64_t slab, ByteSpan bytes) const {
  const Box layer = levels_.brick_box(0, {0, 0, slab});
  SlabTrailer trailer =
      parse_slab_trailer(bytes, root_.tiers.front().layer_bricks, layer.size().z);
  if (trailer.build_id != header_.build_id ||
      trailer.slab != static_cast<std::uint64_t>(slab) ||
      trailer.model != root_.model_of_slab(slab)) {
    throw Error(ErrorKind::corrupt, std::string(kSlabTrailer) + ": belongs to another slab");
  }
  return trailer;
}

SlabTrailer OpenFile::slab_trailer(std::int64_t slab) const {
  const std::uint64_t offset = root_.slab_trailer_offset(slab);
  const auto length = root_.slab_trailer_bytes[static_cast<std::size_t>(slab)];
  try {
    return named_again({offset, length},
                       [&] { return parse_trailer_of(slab, read_bytes(offset, length)); });
  } catch (const Error& error) {
    if (!error.detail().starts_with(kSlabTrailer)) throw;
    const std::string problem = error.detail().substr(std::string_view(kSlabTrailer).size());
    throw Error(error.kind(),
                std::string(kSlabTrailer) + " " + std::to_string(slab) + " at byte " +
                    std::to_string(offset) + problem,
                source_->name(), offset);
  }
}

std::vector<Sha256Digest> OpenFile::plane_digests() const {
  std::vector<Sha256Digest> all;
  for (std::int64_t slab = 0; slab < levels_.brick_grid(0).z; ++slab) {
    const std::vector<Sha256Digest> of_slab = slab_trailer(slab).plane_digests;
    all.insert(all.end(), of_slab.begin(), of_slab.end());
  }
  return all;
}

const PartEntry* OpenFile::find_part(const PartTag& tag) const {
  const auto found = std::find_if(parts_.begin(), parts_.end(),
                                  [&](const PartEntry& part) { return part.tag == tag; });
  return found == parts_.end() ? nullptr : &*found;
}

void OpenFile::copy_part(const PartEntry& part, const std::function<void(ByteSpan)>& sink) const {
  constexpr std::uint64_t kBlockBytes = std::uint64_t{1} << 20;
  std::uint32_t found = 0;
  for (std::uint64_t at = part.bytes.offset; at < part.bytes.end(); at += kBlockBytes) {
    const std::uint64_t length = std::min(kBlockBytes, part.bytes.end() - at);
    const Bytes block = named([&] { return read_bytes(at, length); });
    found = crc32c(block, found);
    sink(block);
  }
  if (checksum_matches(found, part.bytes.crc)) return;
  named([&] {
    fail_checksum(name_of(part.tag) + " at byte " + std::to_string(part.bytes.offset), found,
                  part.bytes.crc, part.bytes.offset, part.bytes.length);
  });
}

Bytes OpenFile::read_section(const Section& section, const char* what) const {
  return named_again({section.offset, section.length}, [&] {
    Bytes bytes = read_bytes(section.offset, section.length);
    check_section(bytes, section, what);
    return bytes;
  });
}

BrickEntry OpenFile::entry_in_page(const IndexPage& page, int tier_number, std::size_t number,
                                   std::int64_t place) const {
  const TierIndex& tier = root_.tiers[static_cast<std::size_t>(tier_number)];
  const auto at = static_cast<std::size_t>(place);
  BrickEntry entry;
  entry.tier = tier_number;
  entry.brick = position_in_layer(tier.grid, tier.first_place(number) + place);
  entry.brick.z = tier.layer_of(number);
  entry.code = interleave(entry.brick);
  entry.range = page.ranges[at];
  if (!page.error_steps.empty()) {
    entry.max_error = static_cast<double>(page.error_steps[at]) * error_step(header_);
  }
  entry.model = tier_number == 0 ? root_.model_of_slab(entry.brick.z) : root_.coarse_model();
  entry.pieces.resize(static_cast<std::size_t>(page.piece_count));
  if (entry.is_uniform()) return entry;
  const std::size_t first = page.slots[at] * entry.pieces.size();
  for (std::size_t i = 0; i < entry.pieces.size(); ++i) {
    const PieceRef& piece = page.pieces[first + i];
    entry.pieces[i] = {piece.offset, piece.length, piece.crc};
  }
  return entry;
}

BrickEntry OpenFile::entry_at(int tier_number, const Index3& position) const {
  if (tier_number < 0 || tier_number >= levels_.tier_count() ||
      !box_of(levels_.brick_grid(tier_number)).contains(position)) {
    throw Error(ErrorKind::invalid_argument,
                "no brick (" + std::to_string(position.x) + ", " + std::to_string(position.y) +
                    ", " + std::to_string(position.z) + ") in tier " + std::to_string(tier_number),
                source_->name());
  }
  const TierIndex& tier = root_.tiers[static_cast<std::size_t>(tier_number)];
  const std::int64_t place = place_in_layer(tier.grid, position);
  const std::size_t number = page_of(tier_number, position);
  return entry_in_page(*page(tier_number, number), tier_number, number, place % kPageBricks);
}

ReadPlan plan_of_opening(const ByteSource& source, const ReaderOptions& options) {
  const std::uint64_t source_bytes = source.size();
  ReadPlan plan;
  const ByteRange head{0, std::min(kHeaderBytes, source_bytes)};
  plan.ranges = source.missing({&head, 1});
  plan.is_complete = plan.ranges.empty();
  if (plan.is_complete) {
    const ByteRange tail = tail_of(
        parse_header(read_arriving(source, head.offset, head.length), source_bytes), options);
    plan.ranges = tail_to_fetch(source, tail, options);
  }
  plan.needed_bytes = total_bytes(plan.ranges);
  return plan;
}

}  // namespace octavo
