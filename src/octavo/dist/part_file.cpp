#include "octavo/dist/part_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"
#include "octavo/core/unset_bytes.h"
#include "octavo/dist/clipped_bytes.h"
#include "octavo/file/byte_codec.h"
#include "octavo/file/storage/temporary.h"
#include "octavo/file/write/interrupted.h"

namespace octavo {

namespace {

constexpr std::array<std::uint8_t, 8> kPartMagic = {0x8f, '8', 'p', 'r', 't', 0x0d, 0x0a, 0x1a};
constexpr std::size_t kHeadCrcAt = kHeaderBytes - 4;
constexpr std::uint64_t kCopyBytes = std::uint64_t{1} << 20;  // that caches of processors hold
constexpr const char* kTail = "the tail of the part";

/// Where the tail stands.
HeaderBlock encode_head(const PartPlace& place, const Section& tail) {
  Bytes bytes(kPartMagic.begin(), kPartMagic.end());
  ByteWriter out(bytes);
  out.put_u32(place.is_band() ? kBandVersion : kPartVersion);
  out.put_u64(place.plan);
  out.put_u64(static_cast<std::uint64_t>(place.first_group));
  out.put_u64(static_cast<std::uint64_t>(place.end_group));
  out.put_u64(tail.offset);
  out.put_u64(tail.length);
  out.put_u32(tail.crc);
  out.put_u64(static_cast<std::uint64_t>(place.first_brick));
  out.put_u64(static_cast<std::uint64_t>(place.end_brick));
  HeaderBlock block{};
  std::ranges::copy(bytes, block.begin());
  store_little_endian(crc32c(ByteSpan(block).first(kHeadCrcAt)), block.data() + kHeadCrcAt);
  return block;
}

// How many things follow, each of which takes at least one byte.
std::size_t take_count(ByteReader& in) {
  const std::uint64_t count = in.varint();
  if (count > in.left()) in.fail("ends early");
  return static_cast<std::size_t>(count);
}

/// Whether bytes are what is left of the head of a part: its start, be it empty, or all of it with
/// bits of the magic flipped.
bool is_begun_head(ByteSpan bytes) {
  const std::size_t count = std::min(bytes.size(), kPartMagic.size());
  if (std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(count),
                 kPartMagic.begin())) {
    return true;
  }
  if (bytes.size() < kHeaderBytes) return false;
  HeaderBlock head{};
  std::ranges::copy(bytes.first(kHeaderBytes), head.begin());
  std::ranges::copy(kPartMagic, head.begin());
  return crc32c(ByteSpan(head).first(kHeadCrcAt)) ==
         load_little_endian<std::uint32_t>(head.data() + kHeadCrcAt);
}

}  // namespace

PartWriter::PartWriter(Storage& storage, std::string path, const FileHeader& header,
                       const Levels& levels, const PartPlace& place, const RunStart& start)
    : storage_(storage),
      path_(std::move(path)),
      header_(header),
      levels_(levels),
      place_(place),
      spool_(storage, folder_of(path_), run_streams(levels)),
      errors_(1) {
  TemporaryFile temporary = create_temporary(storage_, path_);
  temporary_ = std::move(temporary.path);
  out_ = std::make_unique<AppendFile>(std::move(temporary.file));
  run_ = std::make_unique<RunWriter>(header_, levels_, *out_, spool_, true, start);
}

PartWriter::~PartWriter() {
  if (temporary_.empty()) return;
  try {
    storage_.remove(temporary_);
  } catch (const std::exception&) {
    // What stays is removed by who makes the part next.
  }
}

void PartWriter::add_brick(int tier, const EncodedBrick& brick) {
  run_->add_brick(tier, brick);
  if (header_.detail_level > 0) errors_.back().push_back(brick.squared_error);
}

void PartWriter::end_group(std::uint32_t voxels_crc) {
  JournalGroup group = run_->take_group(voxels_crc);
  for (ModelRef& model : group.models) model.offset -= kHeaderBytes;
  groups_.push_back(std::move(group));
  errors_.emplace_back();
}

void PartWriter::end_band(std::uint32_t voxels_crc, std::vector<Sha256Digest> digests) {
  JournalGroup band = run_->take_band(voxels_crc, std::move(digests));
  for (ModelRef& model : band.models) model.offset = 0;
  groups_.push_back(std::move(band));
}

Bytes PartWriter::tail() const {
  Bytes bytes;
  ByteWriter out(bytes);
  out.put_varint(streams_.size());
  for (const Section& stream : streams_) {
    out.put_varint(stream.length);
    out.put_u32(stream.crc);
  }
  out.put_varint(groups_.size());
  for (std::size_t i = 0; i < groups_.size(); ++i) {
    const Bytes group = encode_group(groups_[i]);
    out.put_varint(group.size());
    bytes.insert(bytes.end(), group.begin(), group.end());
    out.put_varint(errors_[i].size());
    for (const double squared : errors_[i]) out.put_u64(std::bit_cast<std::uint64_t>(squared));
  }
  const Bytes clipped = clipped_bytes(clipped_);
  bytes.insert(bytes.end(), clipped.begin(), clipped.end());
  return bytes;
}

void PartWriter::finish() {
  streams_ = {{kHeaderBytes, out_->size() - kHeaderBytes, out_->digest()}};
  for (std::size_t stream = 1; stream < run_streams(levels_); ++stream) {
    Section section{out_->size(), 0, 0};
    spool_.copy(stream, [&](ByteSpan bytes) {
      section.crc = crc32c(bytes, section.crc);
      out_->append(bytes);
    });
    section.length = out_->size() - section.offset;
    streams_.push_back(section);
  }
  const Section tail_section = out_->append_section(tail());
  out_->flush();
  out_->file().sync();
  out_->write_header(encode_head(place_, tail_section));
  out_->file().sync();
  out_->file().close();
  storage_.rename(temporary_, path_);
  temporary_.clear();
  storage_.sync_folder(folder_of(path_));
}

void PartFile::fail(const std::string& what) const {
  throw Error(ErrorKind::corrupt, what + "; make the part anew", path());
}

std::unique_ptr<PartFile> PartFile::open(Storage& storage, const std::string& path) {
  std::unique_ptr<PartFile> part(new PartFile(storage, path));
  const std::unique_ptr<StorageFile> file = storage.open_read(path);
  const std::uint64_t size = file->size();
  HeaderBlock head{};
  const auto head_bytes = static_cast<std::size_t>(std::min<std::uint64_t>(size, kHeaderBytes));
  file->read(0, std::span(head).first(head_bytes));
  if (!is_begun_head(ByteSpan(head).first(head_bytes))) {
    throw Error(ErrorKind::not_octavo, "is no part of a build", path);
  }
  if (head_bytes < kHeaderBytes) {
    throw Error(ErrorKind::truncated, "the part ends within its head", path, size);
  }
  ByteReader in(ByteSpan(head).subspan(kPartMagic.size()), "the head of the part");
  const std::uint32_t version = in.u32();
  const auto head_crc = load_little_endian<std::uint32_t>(head.data() + kHeadCrcAt);
  if (!checksum_matches(crc32c(ByteSpan(head).first(kHeadCrcAt)), head_crc)) {
    part->fail("the head of the part fails its checksum");
  }
  if (version != kPartVersion && version != kBandVersion) {
    throw Error(ErrorKind::unsupported_version,
                "a part of version " + std::to_string(version) + "; this program knows " +
                    std::to_string(kPartVersion) + " and " + std::to_string(kBandVersion),
                path);
  }
  part->place_.plan = in.u64();
  part->place_.first_group = static_cast<std::int64_t>(in.u64());
  part->place_.end_group = static_cast<std::int64_t>(in.u64());
  Section tail{in.u64(), 0, 0};
  tail.length = in.u64();
  tail.crc = in.u32();
  part->place_.first_brick = static_cast<std::int64_t>(in.u64());
  part->place_.end_brick = static_cast<std::int64_t>(in.u64());
  if (part->place_.is_band() != (version == kBandVersion)) {
    part->fail("the head of the part has no bricks of a band");
  }
  if (tail.offset < kHeaderBytes || tail.offset > size || tail.length != size - tail.offset) {
    throw Error(ErrorKind::truncated,
                "the part has " + std::to_string(size) + " bytes, " +
                    std::to_string(tail.end()) + " expected; make the part anew",
                path, size);
  }
  Bytes bytes(static_cast<std::size_t>(tail.length));
  file->read(tail.offset, bytes);
  if (!checksum_matches(crc32c(bytes), tail.crc)) {
    part->fail("the tail of the part fails its checksum");
  }
  try {
    part->read_tail(bytes, tail.offset);
  } catch (const Error& error) {
    throw error.path().empty() ? error.with_path(path) : error;
  }
  return part;
}

void PartFile::read_tail(ByteSpan bytes, std::uint64_t tail_offset) {
  ByteReader in(bytes, kTail);
  std::uint64_t at = kHeaderBytes;
  for (std::size_t left = take_count(in); left > 0; --left) {
    Section stream{at, in.varint(), 0};
    stream.crc = in.u32();
    if (stream.length > tail_offset - at) in.fail("a stream beyond its end");
    at = stream.end();
    streams_.push_back(stream);
  }
  if (at != tail_offset) in.fail("bytes that belong to no stream");
  for (std::size_t left = take_count(in); left > 0; --left) {
    groups_.push_back(parse_group(in.take(take_count(in))));
    std::vector<double>& squares = errors_.emplace_back();
    for (std::size_t bricks = take_count(in); bricks > 0; --bricks) {
      squares.push_back(std::bit_cast<double>(in.u64()));
    }
  }
  ByteSpan rest = in.take(in.left());
  clipped_ = take_clipped(rest, kTail);
  if (!rest.empty()) in.fail("bytes behind its end");
  if (place_.first_brick < 0 || place_.end_brick < 0 ||
      place_.first_brick > place_.end_brick ||
      (place_.is_band() && place_.first_brick == place_.end_brick)) {
    in.fail("bricks other than those of a band");
  }
  if (place_.first_group < 0 || place_.end_group < place_.first_group ||
      static_cast<std::int64_t>(groups_.size()) != place_.end_group - place_.first_group) {
    in.fail("groups other than those of its head");
  }
}

// A band of the layer, which is all of its group.
bool PartFile::is_band_of(const Levels& levels, std::int64_t layer) const {
  const Size3 grid = levels.brick_grid(0);
  if (groups_.size() != 1 || layer >= grid.z || place_.end_brick > grid.x * grid.y) return false;
  const JournalGroup& band = groups_.front();
  const std::int64_t first_page = place_.first_brick / kPageBricks;
  const std::int64_t end_page = (place_.end_brick - 1) / kPageBricks + 1;
  const auto [first_plane, end_plane] = hashed_planes(
      place_, levels.brick_box(0, {0, 0, layer}).size().z, grid.x * grid.y);
  const auto is = [](std::size_t count, std::int64_t expected) {
    return static_cast<std::int64_t>(count) == expected;
  };
  return band.end_layer == layer + 1 && band.slab_trailer_bytes.empty() &&
         errors_.front().empty() && is(band.models.size(), 1) &&
         band.models.front().first_slab == static_cast<std::uint32_t>(layer) &&
         band.models.front().length <= kMaxModelBytes && band.models.front().offset == 0 &&
         is(band.pages.size(), end_page - first_page) &&
         is(band.parents.size(), place_.end_brick - place_.first_brick) &&
         is(band.plane_digests.size(), end_plane - first_plane);
}

void PartFile::require_groups(const Levels& levels, std::int64_t first_layer) const {
  JournalGroup before;
  before.end_layer = first_layer;
  before.file_bytes = kHeaderBytes;
  if (streams_.size() != run_streams(levels)) fail("the part has other levels than the plan");
  if (place_.is_band()) {
    if (!is_band_of(levels, first_layer)) fail("the part has other bricks than the plan");
    return;
  }
  for (std::size_t i = 0; i < groups_.size(); ++i) {
    const JournalGroup& group = groups_[i];
    const bool has_errors = errors_[i].empty() || errors_[i].size() == group.parents.size();
    const bool begins = !group.models.empty() &&
                        group.models.front().first_slab ==
                            static_cast<std::uint32_t>(before.end_layer);
    if (!begins || !has_errors || !follows(group, before, levels)) {
      fail("the part has other layers than the plan");
    }
    before.end_layer = group.end_layer;
    before.file_bytes = group.file_bytes;
    before.squared_error = group.squared_error;
  }
}

double PartFile::add_errors(double before) {
  for (std::size_t i = 0; i < groups_.size(); ++i) {
    for (const double squared : errors_[i]) before += squared;
    groups_[i].squared_error = before;
  }
  return before;
}

std::uint64_t PartFile::stream_bytes() const {
  std::uint64_t bytes = 0;
  for (const Section& stream : streams_) bytes += stream.length;
  return bytes;
}

std::uint64_t PartFile::joined_bytes() const {
  std::uint64_t bytes = 0;
  for (std::size_t stream = 0; stream < streams_.size(); ++stream) {
    if (is_joined(stream)) bytes += streams_[stream].length;
  }
  return bytes;
}

void PartFile::read(std::size_t stream, std::uint64_t offset, std::span<std::uint8_t> out) const {
  storage_.open_read(path_)->read(streams_.at(stream).offset + offset, out);
}

void PartFile::copy(std::size_t stream, const std::function<void(ByteSpan)>& sink) const {
  const Section& section = streams_.at(stream);
  if (section.length == 0) return;
  const std::unique_ptr<StorageFile> file = storage_.open_read(path_);
  std::uint32_t crc = 0;
  UnsetBytes buffer;
  buffer.resize(static_cast<std::size_t>(std::min(section.length, kCopyBytes)));
  const std::span all(reinterpret_cast<std::uint8_t*>(buffer.bytes().data()), buffer.size());
  for (std::uint64_t at = 0; at < section.length; at += kCopyBytes) {
    if (progress_ != nullptr && progress_->is_cancelled()) {
      throw Error(ErrorKind::cancelled, "stopped while parts were copied");
    }
    const auto count = std::min(kCopyBytes, section.length - at);
    const auto bytes = all.first(static_cast<std::size_t>(count));
    file->read(section.offset + at, bytes);
    crc = crc32c(bytes, crc);
    sink(bytes);
    if (progress_ != nullptr) progress_->advance(static_cast<std::int64_t>(count));
  }
  if (!checksum_matches(crc, section.crc)) {
    fail("stream " + std::to_string(stream) + " of the part fails its checksum");
  }
}

void PartFile::prove() const {
  for (std::size_t stream = 0; stream < streams_.size(); ++stream) {
    copy(stream, [](ByteSpan) {});
  }
}

}  // namespace octavo
