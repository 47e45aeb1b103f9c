#include "octavo/file/layout.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>

#include "octavo/core/checked.h"
#include "octavo/core/crc32c.h"
#include "octavo/file/bit_flip.h"
#include "octavo/file/byte_codec.h"
#include "octavo/file/directory.h"
#include "octavo/file/index_lengths.h"

namespace octavo {

namespace {

// A high byte catches 7-bit transfers, CR LF and LF catch newline conversion, 0x1a stops a text
// listing.
constexpr std::array<std::uint8_t, 8> kMagic = {0x8f, '8', 'v', 'o', 0x0d, 0x0a, 0x1a, 0x0a};
constexpr std::array<std::uint8_t, 8> kTrailerMagic = {0x8f, '8', 'v', 'o', 'e', 'n', 'd', 0x0a};
// Of trial versions of the format.
constexpr std::array<std::uint8_t, 8> kTrialMagic = {0x8f, '8', 'V', 'O', 0x0d, 0x0a, 0x1a, 0x0a};

// Where the fields of the header stand.
constexpr std::size_t kMajorAt = 8;
constexpr std::size_t kMinorAt = 10;
constexpr std::size_t kKindAt = 12;
constexpr std::size_t kTypeAt = 13;
constexpr std::size_t kHalvingCountAt = 14;
constexpr std::size_t kSealedAt = 15;
constexpr std::size_t kHalvingsAt = 16;
constexpr std::size_t kSizeAt = 48;
constexpr std::size_t kOriginAt = 72;
constexpr std::size_t kSpacingAt = 96;
constexpr std::size_t kDirectionAt = 120;
constexpr std::size_t kSlopeAt = 192;
constexpr std::size_t kInterceptAt = 200;
constexpr std::size_t kMaxErrorAt = 208;
constexpr std::size_t kBuildIdAt = 216;
constexpr std::size_t kFileBytesAt = 224;
constexpr std::size_t kMetadataAt = 232;
constexpr std::size_t kPagesAt = 256;
constexpr std::size_t kRootAt = 280;
constexpr std::size_t kDirectoryAt = 304;
constexpr std::size_t kChannelsAt = 328;
constexpr std::size_t kTimesAt = 329;
constexpr std::size_t kExtensionCountAt = 330;
constexpr std::size_t kExtensionsAt = 332;
constexpr std::size_t kHeaderCrcAt = 508;

// Where the fields of the trailer stand.
constexpr std::size_t kPreviousAt = 32;
constexpr std::size_t kDigestAt = 40;
constexpr std::size_t kTrailerZerosAt = 72;
constexpr std::size_t kTrailerCrcAt = 92;

constexpr std::uint32_t kCriticalExtension = 0x8000;

// The coding of float32 voxels: u8 type, u8 flags, f64 scale, f64 offset.
constexpr std::uint16_t kCodingTag = 0x8001;
constexpr std::uint16_t kCodingBytes = 18;
constexpr std::uint8_t kExactCoding = 1;

// The finest level that has details: u8.
constexpr std::uint16_t kDetailTag = 0x8002;
constexpr std::uint16_t kDetailBytes = 1;

constexpr double kLargestIntegerError = 4294967295.0;

[[noreturn]] void fail(ErrorKind kind, const std::string& detail, std::size_t offset) {
  throw Error(kind, detail, {}, offset);
}

// A number that was not given out when this was written: of a later version.
[[noreturn]] void fail_newer(const std::string& what, std::size_t offset) {
  fail(ErrorKind::unsupported_version, what + ", which this program does not know", offset);
}

[[noreturn]] void fail_checksum(const std::string& what, std::uint32_t found, std::uint32_t stored,
                                const CheckedBytes& place) {
  fail(ErrorKind::corrupt, what + ": " + describe_checksums(found, stored, place), place.offset);
}

void put_double(double value, std::uint8_t* out) {
  std::uint64_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  store_little_endian(bits, out);
}

double get_double(const std::uint8_t* in, const char* what, std::size_t offset) {
  const auto bits = load_little_endian<std::uint64_t>(in);
  double value;
  std::memcpy(&value, &bits, sizeof value);
  if (!std::isfinite(value)) {
    fail(ErrorKind::corrupt, std::string("header: ") + what + " is not a finite number", offset);
  }
  return value;
}

template <std::size_t N>
void put_doubles(const std::array<double, N>& values, std::uint8_t* out) {
  for (std::size_t i = 0; i < N; ++i) put_double(values[i], out + 8 * i);
}

template <std::size_t N>
std::array<double, N> get_doubles(ByteSpan bytes, std::size_t at, const char* what) {
  std::array<double, N> values{};
  for (std::size_t i = 0; i < N; ++i) {
    values[i] = get_double(bytes.data() + at + 8 * i, what, at + 8 * i);
  }
  return values;
}

void put_section(const Section& section, std::uint8_t* out) {
  store_little_endian(section.offset, out);
  store_little_endian(section.length, out + 8);
  store_little_endian(section.crc, out + 16);
}

bool is_zero(ByteSpan bytes) {
  return std::all_of(bytes.begin(), bytes.end(), [](std::uint8_t byte) { return byte == 0; });
}

// Bytes that are set aside for later versions.
void require_zero(ByteSpan bytes, const char* what, std::size_t at) {
  if (!is_zero(bytes)) fail_newer(std::string(what) + ": holds something at byte " +
                                  std::to_string(at), at);
}

Section get_section(ByteSpan bytes, std::size_t at) {
  Section section;
  section.offset = load_little_endian<std::uint64_t>(bytes.data() + at);
  section.length = load_little_endian<std::uint64_t>(bytes.data() + at + 8);
  section.crc = load_little_endian<std::uint32_t>(bytes.data() + at + 16);
  return section;
}

// What must hold before any field can be believed: magic, length, version, checksum.
void check_envelope(ByteSpan bytes) {
  const auto present = static_cast<std::ptrdiff_t>(std::min(bytes.size(), kMagic.size()));
  const auto begins_as = [&](const std::array<std::uint8_t, 8>& magic) {
    return std::equal(magic.begin(), magic.begin() + present, bytes.begin());
  };
  const bool is_ours = begins_as(kMagic);
  if (present == 0) fail(ErrorKind::not_octavo, "not an 8vo file: the file is empty", 0);
  if (!is_ours && begins_as(kTrialMagic)) {
    fail(ErrorKind::unsupported_version,
         "of a trial version of the format, before 1.0; build it again from its source", 0);
  }
  if (!is_ours) {
    fail(ErrorKind::not_octavo, "not an 8vo file: it starts with other bytes", 0);
  }
  if (bytes.size() < kHeaderBytes) {
    fail(ErrorKind::truncated,
         "cut short: " + std::to_string(bytes.size()) + " bytes of a 512-byte header",
         bytes.size());
  }
  const auto major = load_little_endian<std::uint16_t>(bytes.data() + kMajorAt);
  const auto minor = load_little_endian<std::uint16_t>(bytes.data() + kMinorAt);
  if (major != kFormatMajor) {
    fail(ErrorKind::unsupported_version,
         "format version " + std::to_string(major) + "." + std::to_string(minor) +
             "; this program reads up to " + std::to_string(kFormatMajor) + "." +
             std::to_string(kFormatMinor),
         kMajorAt);
  }
  const auto stored = load_little_endian<std::uint32_t>(bytes.data() + kHeaderCrcAt);
  const std::uint32_t found = crc32c(bytes.first(kHeaderCrcAt));
  if (!checksum_matches(found, stored)) {
    fail_checksum("header", found, stored, {0, kHeaderCrcAt, kHeaderCrcAt});
  }
}

// An extension: (u16 tag, u16 length, bytes). Those whose tag has the high bit set must be
// understood.
struct Extension {
  std::uint16_t tag = 0;
  std::size_t at = 0;  // of its bytes
  std::size_t length = 0;
};

// The extensions as far as they stand in the header; the last one may pass its end.
struct ExtensionList {
  std::vector<Extension> all;
  std::size_t end = kExtensionsAt;
  bool is_whole = true;
};

ExtensionList list_extensions(ByteSpan bytes) {
  ExtensionList list;
  const auto count = load_little_endian<std::uint16_t>(bytes.data() + kExtensionCountAt);
  for (std::uint16_t i = 0; i < count && list.is_whole; ++i) {
    list.is_whole = kHeaderCrcAt - list.end >= 4;
    if (!list.is_whole) break;
    const std::uint8_t* const head = bytes.data() + list.end;
    list.all.push_back({load_little_endian<std::uint16_t>(head), list.end + 4,
                        load_little_endian<std::uint16_t>(head + 2)});
    list.is_whole = kHeaderCrcAt - list.all.back().at >= list.all.back().length;
    if (list.is_whole) list.end = list.all.back().at + list.all.back().length;
  }
  return list;
}

void require_known_extension(ByteSpan bytes, const Extension& extension) {
  const auto [tag, at, length] = extension;
  if (tag & kCriticalExtension && tag != kCodingTag && tag != kDetailTag) {
    char text[96];
    std::snprintf(text, sizeof text, "needs extension 0x%04x, which this program does not know",
                  static_cast<unsigned>(tag));
    fail(ErrorKind::unsupported_version, text, at - 4);
  }
  if (length > kHeaderCrcAt - at) return;
  if (tag == kCodingTag && length == kCodingBytes) {
    const auto type = static_cast<VoxelType>(bytes[at]);
    if (!is_valid(type) || !is_integer(type)) {
      fail_newer("header: codes of type " + std::to_string(bytes[at]), at);
    }
    if (bytes[at + 1] > kExactCoding) {
      fail_newer("header: coding flags " + std::to_string(bytes[at + 1]), at + 1);
    }
  }
  if (tag == kDetailTag && length == kDetailBytes && bytes[at] >= kTierLevels) {
    fail_newer("header: details left out below level " + std::to_string(bytes[at]), at);
  }
}

void require_known_masks(ByteSpan bytes) {
  const std::size_t count = std::min<std::size_t>(bytes[kHalvingCountAt], kMaxLevels);
  const ByteSpan masks = bytes.subspan(kHalvingsAt, kMaxLevels);
  for (std::size_t i = 0; i < count; ++i) {
    if (masks[i] > kHalveAll) {
      fail_newer("header: halved axes " + std::to_string(masks[i]), kHalvingsAt + i);
    }
  }
  require_zero(masks.subspan(count), "header", kHalvingsAt + count);
}

// Numbers that were not given out when this was written, and bytes that were set aside: all of them
// before any other rule, which a later version may have changed.
void require_known(ByteSpan bytes, const ExtensionList& extensions) {
  if (bytes[kSealedAt] > 1) {
    fail_newer("header: seal " + std::to_string(bytes[kSealedAt]), kSealedAt);
  }
  const auto kind = static_cast<VolumeKind>(bytes[kKindAt]);
  if (kind != VolumeKind::grey && kind != VolumeKind::labels) {
    fail_newer("header: kind " + std::to_string(bytes[kKindAt]), kKindAt);
  }
  if (!is_valid(static_cast<VoxelType>(bytes[kTypeAt]))) {
    fail_newer("header: voxel type " + std::to_string(bytes[kTypeAt]), kTypeAt);
  }
  for (const std::size_t at : {kChannelsAt, kTimesAt}) {
    if (bytes[at] == 1) continue;
    fail_newer(std::string("header: ") + (at == kChannelsAt ? "channels " : "times ") +
                   std::to_string(bytes[at]), at);
  }
  require_known_masks(bytes);
  for (const std::size_t at : {kMetadataAt, kPagesAt, kRootAt, kDirectoryAt}) {
    require_zero(bytes.subspan(at + 20, 4), "header", at + 20);
  }
  for (const Extension& extension : extensions.all) require_known_extension(bytes, extension);
  if (!extensions.is_whole) return;
  require_zero(bytes.subspan(extensions.end, kHeaderCrcAt - extensions.end), "header",
               extensions.end);
}

SampleCoding get_coding(ByteSpan bytes, std::size_t at, std::size_t length) {
  if (length != kCodingBytes) fail(ErrorKind::corrupt, "header: coding of another length", at);
  SampleCoding coding;
  coding.type = static_cast<VoxelType>(bytes[at]);
  coding.is_exact = bytes[at + 1] == kExactCoding;
  coding.scale = get_double(bytes.data() + at + 2, "scale", at + 2);
  coding.offset = get_double(bytes.data() + at + 10, "offset", at + 10);
  if (!is_valid(coding)) fail(ErrorKind::corrupt, "header: unusable coding of float32", at);
  return coding;
}

int get_detail_level(ByteSpan bytes, std::size_t at, std::size_t length) {
  if (length == kDetailBytes && bytes[at] > 0) return bytes[at];
  fail(ErrorKind::corrupt, "header: unusable level of details", at);
}

void parse_extensions(ByteSpan bytes, const ExtensionList& extensions, FileHeader& header) {
  std::optional<SampleCoding>& coding = header.description.coding;
  const std::size_t end = extensions.end;
  if (!extensions.is_whole) fail(ErrorKind::corrupt, "header: extensions end early", end);
  for (const auto& [tag, at, length] : extensions.all) {
    if ((tag == kCodingTag && coding) || (tag == kDetailTag && header.detail_level > 0)) {
      fail(ErrorKind::corrupt, "header: two extensions of a kind that stands once", at);
    }
    if (tag == kCodingTag) coding = get_coding(bytes, at, length);
    else if (tag == kDetailTag) header.detail_level = get_detail_level(bytes, at, length);
    else header.unknown_extensions.push_back({tag, length});
  }
}

void check_max_error(const FileHeader& header) {
  const double e = header.max_error;
  if (e < 0) fail(ErrorKind::corrupt, "header: negative max error", kMaxErrorAt);
  if (e > 0 && header.description.kind == VolumeKind::labels) {
    fail(ErrorKind::corrupt, "header: labels with a max error", kMaxErrorAt);
  }
  if (is_integer(header.description.type) && (e != std::floor(e) || e > kLargestIntegerError)) {
    fail(ErrorKind::corrupt, "header: a max error that integers cannot have", kMaxErrorAt);
  }
}

void parse_volume(ByteSpan bytes, FileHeader& header) {
  // Kind and type
  VolumeDescription& volume = header.description;
  volume.kind = static_cast<VolumeKind>(bytes[kKindAt]);
  volume.type = static_cast<VoxelType>(bytes[kTypeAt]);
  if (volume.kind == VolumeKind::labels && !is_integer(volume.type)) {
    fail(ErrorKind::corrupt, "header: labels of type float32", kTypeAt);
  }

  // Size
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t at = kSizeAt + 8 * static_cast<std::size_t>(axis);
    const auto size = load_little_endian<std::uint64_t>(bytes.data() + at);
    if (size == 0) fail(ErrorKind::corrupt, "header: an axis without voxels", at);
    if (size > static_cast<std::uint64_t>(kMaxAxis)) {
      fail(ErrorKind::limit_exceeded,
           "header: axis of " + std::to_string(size) + " voxels; at most " +
               std::to_string(kMaxAxis) + " are possible",
           at);
    }
    volume.size[axis] = static_cast<std::int64_t>(size);
  }

  // Geometry and values
  volume.geometry.origin_mm = get_doubles<3>(bytes, kOriginAt, "origin");
  volume.geometry.spacing_mm = get_doubles<3>(bytes, kSpacingAt, "spacing");
  volume.geometry.direction = get_doubles<9>(bytes, kDirectionAt, "direction");
  if (!is_valid(volume.geometry) || !has_unit_axes(volume.geometry, kStoredAxisTolerance)) {
    fail(ErrorKind::corrupt, "header: spacing, origin or direction out of its limits", kOriginAt);
  }
  volume.rescale.slope = get_doubles<1>(bytes, kSlopeAt, "slope")[0];
  volume.rescale.intercept = get_doubles<1>(bytes, kInterceptAt, "intercept")[0];
  if (!is_valid(volume.rescale, volume.type)) {
    fail(ErrorKind::corrupt, "header: a slope of 0 or real values beyond all numbers", kSlopeAt);
  }
  header.max_error = get_doubles<1>(bytes, kMaxErrorAt, "max error")[0];
  check_max_error(header);
}

// The one extension that a file has: a coding is of float32, the other one of integers.
void put_extension(std::uint16_t tag, std::uint16_t length, std::uint8_t* block) {
  store_little_endian(std::uint16_t{1}, block + kExtensionCountAt);
  store_little_endian(tag, block + kExtensionsAt);
  store_little_endian(length, block + kExtensionsAt + 2);
}

void put_detail_level(int level, std::uint8_t* block) {
  put_extension(kDetailTag, kDetailBytes, block);
  block[kExtensionsAt + 4] = static_cast<std::uint8_t>(level);
}

void put_coding(const SampleCoding& coding, std::uint8_t* block) {
  put_extension(kCodingTag, kCodingBytes, block);
  std::uint8_t* out = block + kExtensionsAt;
  out[4] = static_cast<std::uint8_t>(coding.type);
  out[5] = coding.is_exact ? kExactCoding : 0;
  put_double(coding.scale, out + 6);
  put_double(coding.offset, out + 14);
}

void parse_halvings(ByteSpan bytes, FileHeader& header) {
  const std::size_t count = bytes[kHalvingCountAt];
  if (count >= kMaxLevels) {
    fail(ErrorKind::limit_exceeded, "header: " + std::to_string(count + 1) + " levels; at most 32",
         kHalvingCountAt);
  }
  const ByteSpan masks = bytes.subspan(kHalvingsAt, kMaxLevels);
  header.halvings.assign(masks.begin(), masks.begin() + static_cast<std::ptrdiff_t>(count));
  const Levels levels(header.description.size, header.halvings);
  if (header.detail_level > 0 &&
      (header.max_error > 0 ||
       !can_leave_details_out(header.description, levels, header.detail_level))) {
    fail(ErrorKind::corrupt, "header: details left out of a volume that cannot be without them",
         kExtensionsAt);
  }
}

// What is known of a file before it is sealed.
FileHeader parse_description(ByteSpan bytes, bool is_sealed) {
  const ExtensionList extensions = list_extensions(bytes);
  require_known(bytes, extensions);
  if (is_sealed && bytes[kSealedAt] != 1) {
    throw Error(ErrorKind::corrupt, "not sealed: its build was interrupted", {}, kSealedAt)
        .with_field("interrupted");
  }
  FileHeader header;
  header.major = load_little_endian<std::uint16_t>(bytes.data() + kMajorAt);
  header.minor = load_little_endian<std::uint16_t>(bytes.data() + kMinorAt);
  parse_extensions(bytes, extensions, header);
  parse_volume(bytes, header);
  if (header.description.coding.has_value() == is_integer(header.description.type)) {
    fail(ErrorKind::corrupt, "header: float32 and its coding do not go together", kTypeAt);
  }
  if (header.description.coding && header.description.coding->is_exact != (header.max_error == 0)) {
    fail(ErrorKind::corrupt, "header: float32 is exact without a max error, and only then",
         kMaxErrorAt);
  }
  parse_halvings(bytes, header);
  header.build_id = load_little_endian<std::uint64_t>(bytes.data() + kBuildIdAt);
  header.crc = load_little_endian<std::uint32_t>(bytes.data() + kHeaderCrcAt);
  return header;
}

// Pages, parts, directory, metadata, root and trailer stand one after the other up to the end of
// the file. How long the parts are, their directory says.
void check_tiling(const FileHeader& header, std::uint64_t source_bytes) {
  if (header.file_bytes != source_bytes) {
    const bool is_short = source_bytes < header.file_bytes;
    fail(is_short ? ErrorKind::truncated : ErrorKind::corrupt,
         (is_short ? "cut short: " : "bytes follow its end: ") + std::to_string(source_bytes) +
             " bytes present, " + std::to_string(header.file_bytes) + " when it was sealed",
         kFileBytesAt);
  }
  std::uint64_t at = header.pages.offset;
  for (const Section* section :
       {&header.pages, &header.directory, &header.metadata, &header.root}) {
    const bool follows_parts = section == &header.directory && section->offset > at;
    if (follows_parts) at = section->offset;
    if (section->offset != at || at < kHeaderBytes || at > source_bytes ||
        section->length > source_bytes - at) {
      fail(ErrorKind::corrupt, "header: sections do not follow each other inside the file",
           kMetadataAt);
    }
    at += section->length;
  }
  if (source_bytes - at != kTrailerBytes) {
    fail(ErrorKind::corrupt, "header: sections do not end at the trailer", kRootAt);
  }
  if (header.metadata.length > kMaxMetadataBytes) {
    fail(ErrorKind::limit_exceeded,
         "metadata of " + std::to_string(header.metadata.length) + " bytes; at most 16 MiB",
         kMetadataAt);
  }
  if (header.directory.length > kMaxDirectoryBytes) {
    fail(ErrorKind::limit_exceeded,
         "directory of " + std::to_string(header.directory.length) + " bytes; at most " +
             std::to_string(kMaxDirectoryBytes),
         kDirectoryAt);
  }
}

void check_length(const char* what, const Section& section, const LengthBounds& bounds,
                  std::size_t at) {
  if (bounds.holds(section.length)) return;
  fail(ErrorKind::corrupt,
       std::string("header: ") + what + " of " + std::to_string(section.length) +
           " bytes; such a volume takes " + std::to_string(bounds.min) + " to " +
           std::to_string(bounds.max),
       at);
}

}  // namespace

HeaderBlock encode_header(const FileHeader& header) {
  HeaderBlock block{};
  std::uint8_t* out = block.data();
  const VolumeDescription& volume = header.description;
  std::copy(kMagic.begin(), kMagic.end(), out);
  store_little_endian(header.major, out + kMajorAt);
  store_little_endian(header.minor, out + kMinorAt);
  out[kKindAt] = static_cast<std::uint8_t>(volume.kind);
  out[kTypeAt] = static_cast<std::uint8_t>(volume.type);
  out[kHalvingCountAt] = static_cast<std::uint8_t>(header.halvings.size());
  out[kSealedAt] = header.is_sealed ? 1 : 0;
  std::copy(header.halvings.begin(), header.halvings.end(), out + kHalvingsAt);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto size = static_cast<std::uint64_t>(volume.size[static_cast<int>(axis)]);
    store_little_endian(size, out + kSizeAt + 8 * axis);
  }
  put_doubles(volume.geometry.origin_mm, out + kOriginAt);
  put_doubles(volume.geometry.spacing_mm, out + kSpacingAt);
  put_doubles(volume.geometry.direction, out + kDirectionAt);
  put_double(volume.rescale.slope, out + kSlopeAt);
  put_double(volume.rescale.intercept, out + kInterceptAt);
  put_double(header.max_error, out + kMaxErrorAt);
  store_little_endian(header.build_id, out + kBuildIdAt);
  store_little_endian(header.file_bytes, out + kFileBytesAt);
  put_section(header.metadata, out + kMetadataAt);
  put_section(header.pages, out + kPagesAt);
  put_section(header.root, out + kRootAt);
  put_section(header.directory, out + kDirectoryAt);
  out[kChannelsAt] = 1;
  out[kTimesAt] = 1;
  if (volume.coding) put_coding(*volume.coding, out);
  if (header.detail_level > 0) put_detail_level(header.detail_level, out);
  store_little_endian(crc32c({out, kHeaderCrcAt}), out + kHeaderCrcAt);
  return block;
}

std::uint32_t load_header_crc(const HeaderBlock& block) {
  return load_little_endian<std::uint32_t>(block.data() + kHeaderCrcAt);
}

std::uint64_t load_file_bytes(const HeaderBlock& block) {
  return load_little_endian<std::uint64_t>(block.data() + kFileBytesAt);
}

FileHeader parse_header(ByteSpan bytes, std::uint64_t source_bytes) {
  check_envelope(bytes);
  FileHeader header = parse_description(bytes, true);
  header.is_sealed = true;
  header.file_bytes = load_little_endian<std::uint64_t>(bytes.data() + kFileBytesAt);
  header.metadata = get_section(bytes, kMetadataAt);
  header.pages = get_section(bytes, kPagesAt);
  header.root = get_section(bytes, kRootAt);
  header.directory = get_section(bytes, kDirectoryAt);
  check_tiling(header, source_bytes);
  const Levels levels(header.description.size, header.halvings);
  check_length("index pages", header.pages, pages_lengths(levels), kPagesAt);
  check_length("an index root", header.root, root_lengths(levels), kRootAt);
  return header;
}

FileHeader parse_unsealed_header(const HeaderBlock& block) {
  check_envelope(block);
  return parse_description(block, false);
}

bool can_leave_details_out(const VolumeDescription& volume, const Levels& levels,
                           int detail_level) {
  return volume.kind == VolumeKind::grey && is_integer(volume.type) &&
         detail_level < levels.tier_level_count(0);
}

std::uint64_t make_build_id(const FileHeader& header, std::uint32_t content_hash) {
  const HeaderBlock block = encode_header(header);
  std::uint32_t crc = crc32c(ByteSpan(block).subspan(kHalvingsAt, kBuildIdAt - kHalvingsAt));
  crc = crc32c(ByteSpan(block).subspan(kKindAt, kSealedAt - kKindAt), crc);
  const std::string& text = header.description.metadata.text();
  crc = crc32c({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, crc);
  return std::uint64_t{crc} << 32 | content_hash;
}

TrailerBlock encode_trailer(const FileTrailer& trailer) {
  TrailerBlock block{};
  std::uint8_t* out = block.data();
  std::copy(kTrailerMagic.begin(), kTrailerMagic.end(), out);
  store_little_endian(trailer.build_id, out + 8);
  store_little_endian(trailer.file_bytes, out + 16);
  store_little_endian(trailer.header_crc, out + 24);
  store_little_endian(trailer.crc, out + 28);
  std::copy(trailer.voxel_digest.begin(), trailer.voxel_digest.end(), out + kDigestAt);
  store_little_endian(crc32c({out, kTrailerCrcAt}), out + kTrailerCrcAt);
  return block;
}

FileTrailer parse_trailer(ByteSpan bytes, const FileHeader& header) {
  const std::uint64_t offset = header.file_bytes - kTrailerBytes;
  const auto stored = load_little_endian<std::uint32_t>(bytes.data() + kTrailerCrcAt);
  const std::uint32_t found = crc32c(bytes.first(kTrailerCrcAt));
  if (!checksum_matches(found, stored)) {
    fail_checksum("trailer at byte " + std::to_string(offset), found, stored,
                  {offset, kTrailerCrcAt, offset + kTrailerCrcAt});
  }
  const auto require_trailer = [&](bool holds) {
    if (!holds) fail(ErrorKind::corrupt, "trailer does not belong to the header", offset);
  };
  require_trailer(std::equal(kTrailerMagic.begin(), kTrailerMagic.end(), bytes.begin()));
  require_zero(bytes.subspan(kPreviousAt, kDigestAt - kPreviousAt), "trailer",
               offset + kPreviousAt);
  require_zero(bytes.subspan(kTrailerZerosAt, kTrailerCrcAt - kTrailerZerosAt), "trailer",
               offset + kTrailerZerosAt);
  FileTrailer trailer;
  trailer.build_id = load_little_endian<std::uint64_t>(bytes.data() + 8);
  trailer.file_bytes = load_little_endian<std::uint64_t>(bytes.data() + 16);
  trailer.header_crc = load_little_endian<std::uint32_t>(bytes.data() + 24);
  trailer.crc = load_little_endian<std::uint32_t>(bytes.data() + 28);
  std::copy_n(bytes.begin() + kDigestAt, trailer.voxel_digest.size(), trailer.voxel_digest.begin());
  require_trailer(trailer.build_id == header.build_id &&
                  trailer.file_bytes == header.file_bytes &&
                  checksum_matches(trailer.header_crc, header.crc));
  return trailer;
}

std::uint32_t piece_crc(std::uint64_t build_id, int level, std::uint64_t code, ByteSpan bytes) {
  std::array<std::uint8_t, 17> prefix{};
  store_little_endian(build_id, prefix.data());
  prefix[8] = static_cast<std::uint8_t>(level);
  store_little_endian(code, prefix.data() + 9);
  return crc32c(bytes, crc32c(prefix));
}

}  // namespace octavo
