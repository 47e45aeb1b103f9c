#include "octavo/file/write/journal.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "octavo/core/crc32c.h"
#include "octavo/file/byte_codec.h"

namespace octavo {

namespace {

constexpr std::uint32_t kMagic = 0x6e726a38;  // "8jrn"
constexpr std::uint32_t kJournalVersion = 3;

constexpr std::uint32_t kHeadRecord = 1;
constexpr std::uint32_t kBlockRecord = 2;
constexpr std::uint32_t kGroupRecord = 3;

constexpr std::size_t kFrameBytes = 20;
constexpr std::size_t kCrcAt = 16;
constexpr std::size_t kRecordReadBytes = std::size_t{1} << 20;

using Frame = std::array<std::uint8_t, kFrameBytes>;

struct Record {
  std::uint32_t type = 0;
  std::uint32_t stream = 0;
  std::uint64_t payload = 0;  ///< offset
  std::uint64_t length = 0;
  std::uint64_t end() const { return payload + length; }
};

std::uint32_t frame_crc(const Frame& frame, std::uint64_t offset) {
  std::array<std::uint8_t, 8> place{};
  store_little_endian(offset, place.data());
  return crc32c(ByteSpan(frame).first(kCrcAt), crc32c(place));
}

// The record at `offset` after proving all of it; nothing where no whole one stands.
std::optional<Record> record_at(const StorageFile& file, std::uint64_t offset) {
  const std::uint64_t size = file.size();
  if (offset > size || size - offset < kFrameBytes) return std::nullopt;
  Frame frame{};
  file.read(offset, frame);
  Record record;
  record.type = load_little_endian<std::uint32_t>(frame.data());
  record.stream = load_little_endian<std::uint32_t>(frame.data() + 4);
  record.length = load_little_endian<std::uint64_t>(frame.data() + 8);
  record.payload = offset + kFrameBytes;
  if (record.length > size - record.payload) return std::nullopt;

  std::uint32_t crc = frame_crc(frame, offset);
  Bytes buffer(static_cast<std::size_t>(std::min<std::uint64_t>(record.length, kRecordReadBytes)));
  for (std::uint64_t at = 0; at < record.length; at += buffer.size()) {
    const auto count = std::min<std::uint64_t>(buffer.size(), record.length - at);
    const auto part = std::span(buffer).first(static_cast<std::size_t>(count));
    file.read(record.payload + at, part);
    crc = crc32c(part, crc);
  }
  if (crc != load_little_endian<std::uint32_t>(frame.data() + kCrcAt)) return std::nullopt;
  return record;
}

Bytes payload_of(const StorageFile& file, const Record& record) {
  Bytes bytes(static_cast<std::size_t>(record.length));
  file.read(record.payload, bytes);
  return bytes;
}

void put_bytes(Bytes& out, ByteSpan bytes) { out.insert(out.end(), bytes.begin(), bytes.end()); }

Bytes head_payload(const JournalHead& head) {
  Bytes bytes;
  ByteWriter out(bytes);
  out.put_u32(kMagic);
  out.put_u32(kJournalVersion);
  out.put_varint(head.settings.size());
  bytes.insert(bytes.end(), head.settings.begin(), head.settings.end());
  put_bytes(bytes, head.header);
  bytes.insert(bytes.end(), head.metadata.begin(), head.metadata.end());
  return bytes;
}

std::string text_of(ByteSpan bytes) { return {bytes.begin(), bytes.end()}; }

JournalHead parse_head(ByteSpan bytes) {
  ByteReader in(bytes, "the journal's head");
  if (in.u32() != kMagic || in.u32() != kJournalVersion) in.fail("of another version");
  JournalHead head;
  head.settings = text_of(in.take(static_cast<std::size_t>(in.varint())));
  std::ranges::copy(in.take(kHeaderBytes), head.header.begin());
  head.metadata = text_of(in.take(in.left()));
  return head;
}

void put_page(ByteWriter& out, const PageRef& page) {
  out.put_u32(page.length);
  out.put_u32(page.crc);
  out.put_signed(page.range.min);
  out.put_signed(page.range.max);
  out.put_varint(page.error_steps);
  out.put_varint(page.uniform_count);
  for (const std::uint64_t total : page.piece_start) out.put_varint(total);
}

PageRef take_page(ByteReader& in) {
  PageRef page;
  page.length = in.u32();
  page.crc = in.u32();
  page.range.min = in.signed_varint();
  page.range.max = in.signed_varint();
  page.error_steps = in.varint();
  page.uniform_count = static_cast<std::uint32_t>(in.varint());
  for (std::uint64_t& total : page.piece_start) total = in.varint();
  return page;
}

// How many things follow, each of which takes at least one byte.
std::uint64_t take_count(ByteReader& in) {
  const std::uint64_t count = in.varint();
  if (count > in.left()) in.fail("ends early");
  return count;
}

// The record of the head, when it is one.
std::optional<Record> head_record(const StorageFile& file) {
  constexpr std::uint64_t kMaxHeadBytes = kMaxMetadataBytes + (std::uint64_t{1} << 20);
  const auto record = record_at(file, 0);
  if (!record || record->type != kHeadRecord || record->length > kMaxHeadBytes) return std::nullopt;
  return record;
}

}  // namespace

Bytes encode_group(const JournalGroup& group) {
  Bytes bytes;
  ByteWriter out(bytes);
  out.put_varint(static_cast<std::uint64_t>(group.end_layer));
  out.put_u32(group.voxels_crc);
  out.put_varint(group.file_bytes);
  out.put_u32(group.digest);
  out.put_u64(std::bit_cast<std::uint64_t>(group.squared_error));
  out.put_varint(group.models.size());
  for (const ModelRef& model : group.models) {
    out.put_varint(model.offset);
    out.put_u32(model.length);
    out.put_u32(model.crc);
    out.put_u32(model.first_slab);
  }
  out.put_varint(group.slab_trailer_bytes.size());
  for (const std::uint32_t length : group.slab_trailer_bytes) out.put_varint(length);
  out.put_varint(group.pages.size());
  for (const PageRef& page : group.pages) put_page(out, page);
  out.put_varint(group.parents.size());
  for (const std::int64_t parent : group.parents) out.put_signed(parent);
  out.put_varint(group.plane_digests.size());
  for (const Sha256Digest& digest : group.plane_digests) put_bytes(bytes, digest);
  return bytes;
}

JournalGroup parse_group(ByteSpan bytes) {
  ByteReader in(bytes, "a group of the journal");
  JournalGroup group;
  group.end_layer = static_cast<std::int64_t>(in.varint());
  group.voxels_crc = in.u32();
  group.file_bytes = in.varint();
  group.digest = in.u32();
  group.squared_error = std::bit_cast<double>(in.u64());
  for (std::uint64_t left = take_count(in); left > 0; --left) {
    ModelRef model;
    model.offset = in.varint();
    model.length = in.u32();
    model.crc = in.u32();
    model.first_slab = in.u32();
    group.models.push_back(model);
  }
  for (std::uint64_t left = take_count(in); left > 0; --left) {
    group.slab_trailer_bytes.push_back(static_cast<std::uint32_t>(in.varint()));
  }
  for (std::uint64_t left = take_count(in); left > 0; --left) group.pages.push_back(take_page(in));
  for (std::uint64_t left = take_count(in); left > 0; --left) {
    group.parents.push_back(in.signed_varint());
  }
  for (std::uint64_t left = take_count(in); left > 0; --left) {
    std::ranges::copy(in.take(sizeof(Sha256Digest)), group.plane_digests.emplace_back().begin());
  }
  in.expect_end();
  return group;
}

Journal::Journal(std::unique_ptr<StorageFile> file, const JournalHead& head)
    : file_(std::move(file)) {
  append(kHeadRecord, 0, head_payload(head));
}

Journal::Journal(std::unique_ptr<StorageFile> file, std::uint64_t end)
    : file_(std::move(file)), bytes_(end) {
  file_->truncate(end);
}

std::uint64_t Journal::append(std::uint32_t type, std::size_t stream, ByteSpan payload) {
  Frame frame{};
  store_little_endian(type, frame.data());
  store_little_endian(static_cast<std::uint32_t>(stream), frame.data() + 4);
  store_little_endian(std::uint64_t{payload.size()}, frame.data() + 8);
  store_little_endian(crc32c(payload, frame_crc(frame, bytes_)), frame.data() + kCrcAt);
  Bytes record(frame.begin(), frame.end());
  put_bytes(record, payload);
  file_->write(bytes_, record);
  const std::uint64_t at = bytes_ + kFrameBytes;
  bytes_ += record.size();
  return at;
}

std::uint64_t Journal::append_block(std::size_t stream, ByteSpan bytes) {
  return append(kBlockRecord, stream, bytes);
}

void Journal::append_group(const JournalGroup& group) {
  append(kGroupRecord, 0, encode_group(group));
}

std::optional<JournalHead> read_journal_head(const StorageFile& file) {
  const auto record = head_record(file);
  if (!record) return std::nullopt;
  try {
    return parse_head(payload_of(file, *record));
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::corrupt) return std::nullopt;
    throw;
  }
}

std::vector<WholeGroup> read_journal_groups(const StorageFile& file) {
  std::vector<WholeGroup> groups;
  std::vector<JournalBlock> blocks;
  auto record = head_record(file);
  while (record) {
    record = record_at(file, record->end());
    if (!record) break;
    if (record->type == kBlockRecord && record->length <= UINT32_MAX) {
      blocks.push_back(
          {record->stream, record->payload, static_cast<std::uint32_t>(record->length)});
    } else if (record->type == kGroupRecord) {
      try {
        groups.push_back({parse_group(payload_of(file, *record)), std::exchange(blocks, {}),
                          record->end()});
      } catch (const Error& error) {
        if (error.kind() == ErrorKind::corrupt) break;
        throw;
      }
    } else {
      break;
    }
  }
  return groups;
}

}  // namespace octavo
