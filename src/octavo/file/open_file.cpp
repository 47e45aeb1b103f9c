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

OpenFile::OpenFile(std::shared_ptr<const ByteSource> source, const ReaderOptions& options)
    : source_(std::move(source)), page_cache_(kPageCacheBytes), codec_cache_(kCodecCacheCount) {
  try {
    const std::uint64_t source_bytes = source_->size();
    header_ = parse_header(read_bytes(0, std::min(kHeaderBytes, source_bytes)), source_bytes);
    levels_ = Levels(header_.description.size, header_.halvings);
    read_tail(options.max_metadata_bytes);
  } catch (const Error& error) {
    throw error.with_path(source_->name());
  }
}

void OpenFile::read_tail(std::uint64_t max_metadata_bytes) {
  if (header_.metadata.length > max_metadata_bytes) {
    throw Error(ErrorKind::limit_exceeded,
                "metadata of " + std::to_string(header_.metadata.length) + " bytes; the limit is " +
                    std::to_string(max_metadata_bytes));
  }
  const bool has_pages = header_.file_bytes - header_.pages.offset <= kTailBytes;
  const std::uint64_t start = has_pages ? header_.pages.offset : header_.metadata.offset;
  const Bytes tail = read_bytes(start, header_.file_bytes - start);
  const auto part = [&](const Section& section) {
    return ByteSpan(tail).subspan(section.offset - start, section.length);
  };

  trailer_ = parse_trailer(ByteSpan(tail).last(kTrailerBytes), header_);
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

std::shared_ptr<const IndexPage> OpenFile::page(int tier, std::size_t number) const {
  const LruCache<IndexPage>::Key key{static_cast<std::uint64_t>(tier), number};
  if (auto kept = page_cache_.find(key)) return kept;
  const PageRef& ref = root_.tiers[static_cast<std::size_t>(tier)].pages[number];
  const Section section{ref.offset, ref.length, ref.crc};
  try {
    const Bytes read = pages_.empty() ? read_bytes(section.offset, section.length) : Bytes{};
    const ByteSpan bytes =
        pages_.empty() ? ByteSpan(read)
                       : ByteSpan(pages_).subspan(section.offset - header_.pages.offset,
                                                  section.length);
    check_section(bytes, section, "index page");
    auto page = std::make_shared<const IndexPage>(
        parse_page(bytes, root_, levels_, tier, number, header_));
    page_cache_.insert(key, page, page->memory_bytes());
    return page;
  } catch (const Error& error) {
    throw error.with_path(source_->name());
  }
}

Piece OpenFile::model_piece(std::uint32_t model) const {
  const ModelRef& ref = root_.models[model];
  return {ref.offset, ref.length, ref.crc, kModelLevel, model};
}

std::shared_ptr<const BrickCodec> OpenFile::codec(std::uint32_t model) const {
  const LruCache<BrickCodec>::Key key{0, model};
  if (auto kept = codec_cache_.find(key)) return kept;
  const std::lock_guard lock(codec_mutex_);
  if (auto kept = codec_cache_.find(key)) return kept;
  const Piece piece = model_piece(model);
  const Bytes bytes = read_piece(piece);
  try {
    const std::shared_ptr<const BrickCodec> codec =
        parse_model(description().kind, description().coded_type(), description().coding, bytes);
    codec_cache_.insert(key, codec, 1);
    return codec;
  } catch (const Error& error) {
    throw Error(error.kind(), describe(piece) + ": " + error.detail(), source_->name(),
                piece.offset);
  }
}

Bytes OpenFile::read_piece(const Piece& piece) const {
  try {
    Bytes bytes = read_bytes(piece.offset, piece.length);
    const std::uint32_t found = segment_crc(header_.file_id, piece.level, piece.code, bytes);
    if (!checksum_matches(found, piece.crc)) {
      fail_checksum(describe(piece), found, piece.crc, piece.offset, piece.length);
    }
    return bytes;
  } catch (const Error& error) {
    throw error.with_path(source_->name());
  }
}

Bytes OpenFile::read_within(const Piece& piece, std::uint64_t offset,
                            std::uint64_t length) const {
  try {
    return read_bytes(piece.offset + offset, length);
  } catch (const Error& error) {
    throw error.with_path(source_->name());
  }
}

Bytes OpenFile::read_section(const Section& section, const char* what) const {
  try {
    Bytes bytes = read_bytes(section.offset, section.length);
    check_section(bytes, section, what);
    return bytes;
  } catch (const Error& error) {
    throw error.with_path(source_->name());
  }
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
  entry.segments.resize(static_cast<std::size_t>(page.level_count));
  if (entry.is_uniform()) return entry;
  const std::size_t first = page.slots[at] * entry.segments.size();
  for (std::size_t i = 0; i < entry.segments.size(); ++i) {
    const SegmentRef& segment = page.segments[first + i];
    entry.segments[i] = {segment.offset, segment.length, segment.crc};
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
  const auto number =
      static_cast<std::size_t>(position.z * tier.layer_pages + place / kPageBricks);
  return entry_in_page(*page(tier_number, number), tier_number, number, place % kPageBricks);
}

}  // namespace octavo
