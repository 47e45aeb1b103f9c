#include "octavo/io/isolation/worker_protocol.h"

#include <bit>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <utility>

#include "octavo/core/crc32c.h"
#include "octavo/core/levels.h"
#include "octavo/file/byte_codec.h"
#include "octavo/planes/slice_stack.h"

namespace octavo {

namespace {

constexpr std::uint32_t kMessageMark = 0x386f7667;
constexpr std::uint64_t kRequestMark = 0x8876386f72657131;

std::uint32_t crc_of_head(const MessageHead& head) noexcept {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(&head);
  return crc32c({bytes, offsetof(MessageHead, head_crc)});
}

/// Composite values on top of numbers.
class Writer : public ByteWriter {
 public:
  explicit Writer(Payload& out) : ByteWriter(out), bytes_(out) {}

  void put_double(double value) { put_u64(std::bit_cast<std::uint64_t>(value)); }
  void put_text(std::string_view text) {
    put_varint(text.size());
    bytes_.insert(bytes_.end(), text.begin(), text.end());
  }
  void put_stored_type(StoredType type) {
    put_u8(type.wide() ? 1 : 0);
    put_u8(type.wide() ? static_cast<std::uint8_t>(*type.wide())
                       : static_cast<std::uint8_t>(type.voxel()));
  }
  void put_texts(const std::vector<std::string>& texts) {
    put_varint(texts.size());
    for (const std::string& text : texts) put_text(text);
  }
  void put_warnings(const std::vector<Warning>& warnings) {
    put_varint(warnings.size());
    for (const auto& [text, field] : warnings) {
      put_text(text);
      put_text(field);
    }
  }
  void put_size(const Size3& size) {
    for (const std::int64_t axis : {size.x, size.y, size.z}) put_signed(axis);
  }

 private:
  Payload& bytes_;
};

class Reader : public ByteReader {
 public:
  using ByteReader::ByteReader;

  double number() { return std::bit_cast<double>(u64()); }
  bool flag() {
    const std::uint8_t value = u8();
    if (value > 1) fail("a flag is neither 0 nor 1");
    return value == 1;
  }
  std::string text() {
    const std::uint64_t length = varint();
    if (length > left()) fail("a text ends early");
    const auto bytes = take(static_cast<std::size_t>(length));
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  std::vector<std::string> texts() {
    const std::uint64_t count = varint();
    if (count > left()) fail("a list ends early");
    std::vector<std::string> all;
    for (std::uint64_t i = 0; i < count; ++i) all.push_back(text());
    return all;
  }
  std::vector<Warning> warnings() {
    const std::uint64_t count = varint();
    if (count > left()) fail("a list ends early");
    std::vector<Warning> all;
    for (std::uint64_t i = 0; i < count; ++i) {
      std::string words = text();
      all.emplace_back(std::move(words), text());
    }
    return all;
  }
  Size3 size() {
    const std::int64_t x = signed_varint();
    const std::int64_t y = signed_varint();
    return {x, y, signed_varint()};
  }
  StoredType stored_type() {
    if (!flag()) return voxel_type();
    const auto type = static_cast<WideType>(u8());
    if (type < WideType::int64 || type > WideType::float64) fail("no such wide type");
    return type;
  }
  VoxelType voxel_type() {
    const auto type = static_cast<VoxelType>(u8());
    if (!is_valid(type)) fail("no such voxel type");
    return type;
  }
};

void put_outline(Writer& out, const std::optional<SliceOutline>& outline) {
  out.put_u8(outline ? 1 : 0);
  if (!outline) return;
  const auto& [planes, tilt, padding] = *outline;
  out.put_varint(planes.size());
  for (const auto& [below, weight_above, is_background] : planes) {
    out.put_varint(below);
    out.put_double(weight_above);
    out.put_u8(is_background ? 1 : 0);
  }
  out.put_u8(tilt ? 1 : 0);
  if (tilt) {
    const auto& [angle_degrees, shift, columns, rows, outside] = *tilt;
    out.put_double(angle_degrees);
    out.put_varint(shift.size());
    for (const auto& [x, y] : shift) {
      out.put_double(x);
      out.put_double(y);
    }
    out.put_signed(columns);
    out.put_signed(rows);
    out.put_double(outside);
  }
  out.put_u8(padding ? 1 : 0);
  if (padding) out.put_signed(*padding);
}

std::optional<SliceOutline> take_outline(Reader& in) {
  if (!in.flag()) return std::nullopt;
  SliceOutline outline;
  const auto take_count = [&in] {
    const std::uint64_t count = in.varint();
    if (count > in.left()) in.fail("a list ends early");
    return count;
  };
  for (std::uint64_t left = take_count(); left > 0; --left) {
    PlaneOrigin& plane = outline.planes.emplace_back();
    plane.below = static_cast<std::size_t>(in.varint());
    plane.weight_above = in.number();
    plane.is_background = in.flag();
  }
  if (in.flag()) {
    TiltRemoval& tilt = outline.tilt.emplace();
    tilt.angle_degrees = in.number();
    for (std::uint64_t left = take_count(); left > 0; --left) {
      for (double& voxels : tilt.shift.emplace_back()) voxels = in.number();
    }
    tilt.columns = in.signed_varint();
    tilt.rows = in.signed_varint();
    tilt.outside = in.number();
  }
  if (in.flag()) outline.padding = in.signed_varint();
  return outline;
}

// Naming all members at once lets the compiler reject a member that is not sent. `is_cancelled`
// stays here: who waits for a worker asks it, and ends the worker.

void put_options(Writer& out, const SourceOptions& options) {
  const auto& [raw, spacing_mm, series, on_gap, drop_duplicates, untilt, segment, channel,
               time, keep_identity, max_memory_bytes, threads, excerpt, is_cancelled] = options;
  out.put_u8(raw ? 1 : 0);
  if (raw) {
    const auto& [size, type, big_endian, header_bytes] = *raw;
    out.put_size(size);
    out.put_stored_type(type);
    out.put_u8(big_endian ? 1 : 0);
    out.put_u64(header_bytes);
  }
  out.put_u8(spacing_mm ? 1 : 0);
  if (spacing_mm) {
    for (const double mm : *spacing_mm) out.put_double(mm);
  }
  out.put_text(series);
  out.put_u8(static_cast<std::uint8_t>(on_gap));
  out.put_u8(drop_duplicates ? 1 : 0);
  out.put_u8(untilt ? 1 : 0);
  out.put_text(segment);
  out.put_text(channel);
  out.put_u8(time ? 1 : 0);
  if (time) out.put_signed(*time);
  out.put_u8(keep_identity ? 1 : 0);
  out.put_u64(max_memory_bytes);
  out.put_signed(threads);
  put_outline(out, excerpt);
}

SourceOptions take_options(Reader& in) {
  SourceOptions options;
  if (in.flag()) {
    RawLayout& raw = options.raw.emplace();
    raw.size = in.size();
    raw.type = in.stored_type();
    raw.big_endian = in.flag();
    raw.header_bytes = in.u64();
  }
  if (in.flag()) {
    for (double& mm : options.spacing_mm.emplace()) mm = in.number();
  }
  options.series = in.text();
  options.on_gap = static_cast<GapPolicy>(in.u8());
  if (options.on_gap > GapPolicy::resample) in.fail("no such way to treat gaps");
  options.drop_duplicates = in.flag();
  options.untilt = in.flag();
  options.segment = in.text();
  options.channel = in.text();
  if (in.flag()) options.time = in.signed_varint();
  options.keep_identity = in.flag();
  options.max_memory_bytes = in.u64();
  options.threads = static_cast<int>(in.signed_varint());
  options.excerpt = take_outline(in);
  return options;
}

void put_description(Writer& out, const VolumeDescription& description) {
  const auto& [kind, type, size, geometry, rescale, metadata, coding, padding] = description;
  const auto& [origin_mm, spacing_mm, direction] = geometry;
  out.put_u8(static_cast<std::uint8_t>(kind));
  out.put_u8(static_cast<std::uint8_t>(type));
  out.put_size(size);
  for (const double mm : origin_mm) out.put_double(mm);
  for (const double mm : spacing_mm) out.put_double(mm);
  for (const double part : direction) out.put_double(part);
  out.put_double(rescale.slope);
  out.put_double(rescale.intercept);
  out.put_text(metadata.text());
  out.put_u8(coding ? 1 : 0);
  if (coding) {
    out.put_u8(static_cast<std::uint8_t>(coding->type));
    out.put_double(coding->scale);
    out.put_double(coding->offset);
  }
  out.put_u8(padding ? 1 : 0);
  if (padding) out.put_signed(*padding);
}

void prove(const VolumeDescription& description, const Reader& in) {
  checked_voxel_count(description.size);
  const Rescale& rescale = description.rescale;
  const bool is_scaled = std::isfinite(rescale.slope) && rescale.slope != 0 &&
                         std::isfinite(rescale.intercept);
  if (!is_valid(description.geometry) || !is_scaled) in.fail("its geometry or rescale is unusable");
  if (description.coding && !is_valid(*description.coding)) in.fail("its coding is unusable");
  const Metadata& metadata = description.metadata;
  if (!metadata.is_readable()) in.fail("its metadata are no JSON: " + metadata.defect());
}

VolumeDescription take_description(Reader& in) {
  VolumeDescription description;
  description.kind = static_cast<VolumeKind>(in.u8());
  if (description.kind != VolumeKind::grey && description.kind != VolumeKind::labels) {
    in.fail("no such kind of volume");
  }
  description.type = in.voxel_type();
  description.size = in.size();
  for (double& mm : description.geometry.origin_mm) mm = in.number();
  for (double& mm : description.geometry.spacing_mm) mm = in.number();
  for (double& part : description.geometry.direction) part = in.number();
  description.rescale.slope = in.number();
  description.rescale.intercept = in.number();
  description.metadata = Metadata::read(in.text());
  if (in.flag()) {
    SampleCoding& coding = description.coding.emplace();
    coding.type = in.voxel_type();
    coding.scale = in.number();
    coding.offset = in.number();
  }
  if (in.flag()) description.padding = in.signed_varint();
  prove(description, in);
  return description;
}

void put_files(Writer& out, const PlaneFiles& files) {
  const auto& [paths, of_plane, outline, voxels_sha256] = files;
  out.put_texts(paths);
  out.put_varint(of_plane.size());
  for (const auto& [first, end] : of_plane) {
    out.put_signed(first);
    out.put_signed(end - first);
  }
  put_outline(out, outline);
  out.put_text(voxels_sha256);
}

PlaneFiles take_files(Reader& in, std::int64_t planes) {
  PlaneFiles files;
  files.paths = in.texts();
  const auto file_count = static_cast<std::int64_t>(files.paths.size());
  const std::uint64_t count = in.varint();
  if (count > in.left()) in.fail("a list ends early");
  if (count != 0 && count != static_cast<std::uint64_t>(planes)) {
    in.fail("it names the files of other planes than there are");
  }
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::int64_t first = in.signed_varint();
    const std::int64_t length = in.signed_varint();
    if (first < 0 || first > file_count || length < 0 || length > file_count - first) {
      in.fail("a plane is in files that are not there");
    }
    files.of_plane.push_back({first, first + length});
  }
  files.outline = take_outline(in);
  files.voxels_sha256 = in.text();
  return files;
}

}  // namespace

MessageHead head_for(MessageKind kind, std::uint64_t index, std::span<const std::uint8_t> payload) {
  MessageHead head{kMessageMark, kind, index, payload.size(), crc32c(payload), 0};
  head.head_crc = crc_of_head(head);
  return head;
}

bool is_sound(const MessageHead& head) noexcept {
  return head.mark == kMessageMark && checksum_matches(crc_of_head(head), head.head_crc);
}

bool starts_a_request(std::span<const std::uint8_t> bytes) noexcept {
  return bytes.size() >= 8 && load_little_endian<std::uint64_t>(bytes.data()) == kRequestMark;
}

Payload encode(const ImportRequest& request) {
  Payload payload;
  Writer out(payload);
  out.put_u64(kRequestMark);
  out.put_texts(request.paths);
  put_options(out, request.options);
  out.put_signed(request.threads);
  out.put_u64(request.memory_bytes);
  out.put_u64(request.limit_ms);
  out.put_signed(request.first_plane);
  out.put_signed(request.end_plane);
  return payload;
}

Payload encode(const SourceReport& report) {
  Payload payload;
  Writer out(payload);
  put_description(out, report.description);
  out.put_warnings(report.warnings);
  out.put_u64(report.resident_bytes);
  put_files(out, report.files);
  return payload;
}

Payload encode(const std::vector<Warning>& warnings) {
  Payload payload;
  Writer(payload).put_warnings(warnings);
  return payload;
}

Payload encode(const Error& failure) {
  Payload payload;
  Writer out(payload);
  out.put_u8(static_cast<std::uint8_t>(failure.kind()));
  out.put_text(failure.detail());
  out.put_text(failure.path());
  out.put_u8(failure.offset() ? 1 : 0);
  out.put_u64(failure.offset().value_or(0));
  out.put_varint(failure.hints().size());
  for (const auto& [field, value] : failure.hints()) {
    out.put_text(field);
    out.put_text(value);
  }
  return payload;
}

ImportRequest decode_request(std::span<const std::uint8_t> payload) {
  Reader in(payload, "the request to the reader");
  if (in.u64() != kRequestMark) in.fail("its mark is missing");
  ImportRequest request;
  request.paths = in.texts();
  request.options = take_options(in);
  request.threads = static_cast<int>(in.signed_varint());
  request.memory_bytes = in.u64();
  request.limit_ms = in.u64();
  request.first_plane = in.signed_varint();
  request.end_plane = in.signed_varint();
  in.expect_end();
  return request;
}

SourceReport decode_report(std::span<const std::uint8_t> payload) {
  Reader in(payload, "the description");
  SourceReport report;
  report.description = take_description(in);
  report.warnings = in.warnings();
  report.resident_bytes = in.u64();
  report.files = take_files(in, report.description.size.z);
  in.expect_end();
  if (!report.files.outline) return report;
  const std::string fault = fault_of(SliceStack{report.description, report.files});
  if (!fault.empty()) in.fail(fault);
  return report;
}

std::vector<Warning> decode_warnings(std::span<const std::uint8_t> payload) {
  Reader in(payload, "the warnings");
  std::vector<Warning> warnings = in.warnings();
  in.expect_end();
  return warnings;
}

Error decode_failure(std::span<const std::uint8_t> payload) {
  Reader in(payload, "the failure");
  const std::uint8_t kind = in.u8();
  if (kind > static_cast<std::uint8_t>(ErrorKind::internal)) in.fail("no such kind of error");
  std::string detail = in.text();
  std::string path = in.text();
  const bool has_offset = in.flag();
  const std::uint64_t offset = in.u64();
  Error failure(static_cast<ErrorKind>(kind), std::move(detail), std::move(path),
                has_offset ? std::optional(offset) : std::nullopt);
  const std::uint64_t hint_count = in.varint();
  if (hint_count > in.left()) in.fail("a list ends early");
  for (std::uint64_t i = 0; i < hint_count; ++i) {
    std::string field = in.text();
    failure = failure.with_field(std::move(field), in.text());
  }
  in.expect_end();
  return failure;
}

}  // namespace octavo
