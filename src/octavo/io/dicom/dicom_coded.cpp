#include "octavo/io/dicom/dicom_coded.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <limits>
#include <new>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/unset_bytes.h"
#include "octavo/io/dicom/dicom_library.h"
#include "octavo/io/dicom/run_length_frame.h"
#include "octavo/io/source/jpeg_completeness.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

constexpr const char* kRunLengthSyntax = "1.2.840.10008.1.2.5";
/// The fewest that GDCM decodes of JPEG.
constexpr std::uint8_t kDecodedBits = 8;
constexpr std::int64_t kMostJpegBits = 16;
/// Of the first picture: a head may stand behind a profile of colors.
constexpr std::size_t kPictureHeadBytes = std::size_t{1} << 16;

/// The fragments of one frame: all of a single frame, one each, or those between two table entries.
std::vector<ByteRun> fragments_of(const DicomLayout& layout, std::int64_t frame) {
  const std::vector<ByteRun>& all = layout.pixels.fragments;
  const auto index = static_cast<std::size_t>(frame);
  if (layout.frames == 1) return all;
  if (all.size() == static_cast<std::size_t>(layout.frames)) return {all[index]};
  const std::vector<std::uint64_t>& table = layout.pixels.frame_offsets;
  // Table entries count from the item tag of the first fragment, 8 bytes before its value.
  const std::uint64_t base = all.front().offset - 8;
  const std::uint64_t from = base + table[index];
  const std::uint64_t to = index + 1 < table.size() ? base + table[index + 1]
                                                    : std::numeric_limits<std::uint64_t>::max();
  // They rise, as they were found one behind the other.
  const auto item_offset = [](const ByteRun& run) { return run.offset - 8; };
  const auto first = std::ranges::lower_bound(all, from, {}, item_offset);
  return {first, std::ranges::lower_bound(first, all.end(), to, {}, item_offset)};
}

/// The first `count` bytes of a picture, over the ends of fragments.
std::vector<std::byte> start_of(const SourceFile& file, const std::vector<ByteRun>& fragments,
                                std::size_t count) {
  std::vector<std::byte> start;
  for (const ByteRun& run : fragments) {
    const std::size_t had = start.size();
    if (had == count) break;
    start.resize(had +
                 static_cast<std::size_t>(std::min<std::uint64_t>(run.length, count - had)));
    file.read_exactly(run.offset, std::span(start).subspan(had));
  }
  return start;
}

/// Heads nearly always stand at the very front; tables and notes may come before them.
std::optional<PictureHead> early_head(const SourceFile& file,
                                      const std::vector<ByteRun>& fragments) {
  constexpr std::size_t kUsualHeadBytes = 1024;
  const auto head = picture_head(start_of(file, fragments, kUsualHeadBytes));
  return head ? head : picture_head(start_of(file, fragments, kPictureHeadBytes));
}

std::string size_of(std::int64_t columns, std::int64_t rows) {
  return std::to_string(columns) + " x " + std::to_string(rows);
}

/// Rejects a picture that does not fit the header: the decoder would fill too few voxels.
void require_claimed(const DicomLayout& layout, const PictureHead& head) {
  if (head.columns != layout.stored_columns() || head.rows != layout.stored_rows()) {
    reject(layout, "the compressed picture has " + size_of(head.columns, head.rows) +
                       " voxels, the header says " +
                       size_of(layout.stored_columns(), layout.stored_rows()));
  }
  if (head.samples != layout.samples) {
    reject(layout, "the compressed picture has " + std::to_string(head.samples) +
                       " samples per pixel, the header says " + std::to_string(layout.samples));
  }
  if (head.bits < 1) {
    reject(layout, "the numbers of the compressed picture have 0 bits: it is damaged");
  }
  if (head.bits > layout.bits_allocated) {
    reject(layout, "the numbers of the compressed picture have " + std::to_string(head.bits) +
                       " bits, Bits Allocated (0028,0100) says " +
                       std::to_string(layout.bits_allocated) +
                       "; correct it in the file, or export the series again");
  }
}

/// Bits that a decoder takes for a number.
std::int64_t width_of(std::int64_t bits) { return bits <= 8 ? 8 : bits <= 16 ? 16 : 32; }

CodedPicture coded_picture(const DicomLayout& layout, const std::optional<PictureHead>& head) {
  CodedPicture picture;
  picture.columns = layout.stored_columns();
  picture.rows = layout.stored_rows();
  picture.bits_allocated = head ? width_of(head->bits) : layout.bits_allocated;
  picture.bits_stored = head ? head->bits : layout.bits_stored;
  if (has_run_lengths(layout)) picture.bits_stored = layout.bits_allocated;
  picture.high_bit = picture.bits_stored - 1;
  picture.is_signed = layout.is_signed;
  picture.transfer_syntax = layout.transfer_syntax;
  return picture;
}

void decode(const DicomLayout& layout, const CodedPicture& picture, std::span<std::byte> plane) {
  std::size_t found = 0;
  const bool is_decoded = dicom_library().decode(picture, plane, found);
  if (found != plane.size()) {
    reject(layout, "the compressed picture holds " + std::to_string(found) +
                       " bytes, the header says " + std::to_string(plane.size()));
  }
  if (is_decoded) return;
  reject(layout, "its compressed picture (transfer syntax " + escaped(layout.transfer_syntax) +
                     ") cannot be decoded: it is damaged, or of a kind that GDCM does not read");
}

/// Decodes a lossless JPEG picture of fewer than 8 bits, which GDCM does not, as one that says it
/// has 8. Each value is coded as its distance from what those before it predict, the first from the
/// middle of what the bits hold, so all come out higher by as much as the middles differ.
/// Source: ITU-T T.81, H.1.2.1 (Prediction)
void decode_few_bits(const DicomLayout& layout, const PictureHead& head, CodedPicture& picture,
                     std::span<std::byte> plane) {
  std::vector<std::byte> whole;
  for (const std::vector<std::byte>& part : picture.fragments) {
    whole.insert(whole.end(), part.begin(), part.end());
  }
  const std::optional<std::size_t> place = lossless_bits_place(whole);
  if (!place) {
    reject(layout, "the numbers of the compressed picture have " + std::to_string(head.bits) +
                       (head.bits == 1 ? " bit" : " bits") +
                       ", which JPEG has in lossless pictures alone: it is damaged; copy the file "
                       "again from its origin");
  }
  whole[*place] = std::byte{kDecodedBits};
  picture.fragments = {std::move(whole)};
  picture.bits_stored = kDecodedBits;
  picture.high_bit = kDecodedBits - 1;
  decode(layout, picture, plane);
  const unsigned surplus = (1U << (kDecodedBits - 1)) - (1U << (head.bits - 1));
  for (std::byte& value : plane) {
    value = static_cast<std::byte>(std::to_integer<unsigned>(value) - surplus);
  }
}

/// The coding of a transfer syntax that has no decoder here; null of any other.
const char* coding_without_decoder(std::string_view uid) {
  constexpr std::string_view kCodings = "1.2.840.10008.1.2.4.";
  if (!uid.starts_with(kCodings)) return nullptr;
  const std::string_view number = uid.substr(kCodings.size(), 3);
  if (number == "201" || number == "202" || number == "203") return "HTJ2K";
  if (number == "110" || number == "111" || number == "112") return "JPEG XL";
  if (number == "100" || number == "101") return "MPEG-2";
  if (number >= "102" && number <= "106" && number.size() == 3) return "MPEG-4";
  if (number == "107" || number == "108") return "HEVC";
  return nullptr;
}

void require_decoder(const DicomLayout& layout) {
  const char* const coding = coding_without_decoder(layout.transfer_syntax);
  if (coding == nullptr) return;
  reject(layout, "transfer syntax " + escaped(layout.transfer_syntax) + " (" + coding +
                     ") is not read; export the series again uncompressed or as JPEG 2000");
}

bool is_plain_jpeg(const DicomLayout& layout) {
  const std::string& uid = layout.transfer_syntax;
  return uid.starts_with("1.2.840.10008.1.2.4.5") || uid.starts_with("1.2.840.10008.1.2.4.6") ||
         uid.starts_with("1.2.840.10008.1.2.4.7");
}

bool is_jpeg_ls(const DicomLayout& layout) {
  return layout.transfer_syntax.starts_with("1.2.840.10008.1.2.4.8");
}

[[noreturn]] void reject_damaged(const DicomLayout& layout, std::int64_t frame,
                                 const std::string& damage) {
  const std::string of = layout.frames > 1 ? " of frame " + std::to_string(frame + 1) : "";
  reject(layout, "the compressed picture" + of + " " + damage + "; copy the file again from its "
                     "origin");
}

/// Rejects a picture that is seen to lack values before it is decoded: of JPEG and of run lengths
/// the decoder fills them up without a word, and behind the last byte of JPEG-LS it may count zeros
/// for minutes before it gives up. Its values cannot hold the mark of the end.
void require_whole(const DicomLayout& layout, std::int64_t frame,
                   std::span<const std::byte> picture) {
  constexpr std::array kEnd = {std::byte{0xff}, std::byte{0xd9}};
  if (is_plain_jpeg(layout) && !is_whole_jpeg({}, picture)) {
    reject_damaged(layout, frame, "ends before its last value: it is damaged");
  }
  if (is_jpeg_ls(layout) && std::ranges::find_end(picture, kEnd).empty()) {
    reject_damaged(layout, frame, "ends before its mark of the end");
  }
  if (!has_run_lengths(layout)) return;
  const auto pixels = static_cast<std::size_t>(layout.stored_columns() * layout.stored_rows());
  const auto bytes = static_cast<std::size_t>(layout.bits_allocated / 8 * layout.samples);
  const std::string damage = run_length_damage(picture, bytes, pixels);
  if (!damage.empty()) reject_damaged(layout, frame, "is damaged (" + damage + ")");
}

/// The head of a picture that is whole and fits the header; run lengths have none.
std::optional<PictureHead> proven_head(const DicomLayout& layout, std::int64_t frame,
                                       const std::vector<std::vector<std::byte>>& fragments) {
  std::vector<std::byte> joined;
  for (const std::vector<std::byte>& part : fragments) {
    if (fragments.size() > 1) joined.insert(joined.end(), part.begin(), part.end());
  }
  const std::span<const std::byte> picture = fragments.size() == 1 ? fragments.front() : joined;
  std::optional<PictureHead> head;
  if (!has_run_lengths(layout)) head = picture_head(picture);
  if (head) require_claimed(layout, *head);
  if (head && is_plain_jpeg(layout) && head->bits > kMostJpegBits) {
    reject(layout, "the numbers of the compressed picture have " + std::to_string(head->bits) +
                       " bits, JPEG has " + std::to_string(kMostJpegBits) +
                       " at most: it is damaged; copy the file again from its origin");
  }
  require_whole(layout, frame, picture);
  return head;
}

/// True of plain JPEG that codes voxels with all bits allocated: those beside the stored ones may
/// hold anything, as in uncompressed pictures.
bool has_whole_voxels(const DicomLayout& layout, const PictureHead& head) {
  return is_plain_jpeg(layout) && head.bits == layout.bits_allocated;
}

/// What the bits of a decoded number mean.
class DecodedBits {
 public:
  DecodedBits(const DicomLayout& layout, const PictureHead& head)
      : stored_(layout.bits_stored),
        whole_(whole_bits(layout, head)),
        mask_((std::uint64_t{1} << whole_) - 1),
        is_signed_(layout.is_signed),
        is_sure_(head.is_signed) {
    if (has_whole_voxels(layout, head)) shift_ = layout.high_bit + 1 - layout.bits_stored;
  }

  std::int64_t value(std::uint64_t raw) const {
    const std::uint64_t bits = raw >> shift_ & mask_;
    if (!is_signed_) return static_cast<std::int64_t>(bits);
    // Without a sign of its own a number may have its sign where the header puts it, and nothing
    // above it.
    const bool is_short = !is_sure_ && stored_ < whole_ && bits >> stored_ == 0;
    const std::uint64_t sign = std::uint64_t{1} << ((is_short ? stored_ : whole_) - 1);
    return static_cast<std::int64_t>((bits ^ sign) - sign);
  }

 private:
  static std::int64_t whole_bits(const DicomLayout& layout, const PictureHead& head) {
    if (has_whole_voxels(layout, head)) return layout.bits_stored;
    return is_plain_jpeg(layout) ? std::max(layout.bits_stored, head.bits) : head.bits;
  }

  std::int64_t stored_;
  std::int64_t whole_;
  std::uint64_t mask_;
  std::int64_t shift_ = 0;
  bool is_signed_;
  bool is_sure_;
};

template <class From, class To>
void settle_values(const DecodedBits& meaning, std::span<const std::byte> decoded,
                   std::span<std::byte> plane) {
  const std::size_t count = plane.size() / sizeof(To);
  for (std::size_t i = 0; i < count; ++i) {
    From raw;
    std::memcpy(&raw, decoded.data() + i * sizeof raw, sizeof raw);
    const auto value = static_cast<To>(meaning.value(raw));
    std::memcpy(plane.data() + i * sizeof value, &value, sizeof value);
  }
}

template <class From>
void settle_from(const DicomLayout& layout, const PictureHead& head,
                 std::span<const std::byte> decoded, std::span<std::byte> plane) {
  const DecodedBits meaning(layout, head);
  switch (layout.bits_allocated) {
    case 8: return settle_values<From, std::uint8_t>(meaning, decoded, plane);
    case 16: return settle_values<From, std::uint16_t>(meaning, decoded, plane);
    default: return settle_values<From, std::uint32_t>(meaning, decoded, plane);
  }
}

template <class T>
bool exceeds(std::span<const std::byte> plane, std::int64_t lowest, std::int64_t highest) {
  for (std::size_t at = 0; at + sizeof(T) <= plane.size(); at += sizeof(T)) {
    T value;
    std::memcpy(&value, plane.data() + at, sizeof value);
    if (static_cast<std::int64_t>(value) < lowest || static_cast<std::int64_t>(value) > highest) {
      return true;
    }
  }
  return false;
}

}  // namespace

bool has_run_lengths(const DicomLayout& layout) {
  return layout.transfer_syntax == kRunLengthSyntax;
}

std::optional<PictureHead> first_picture_head(const DicomLayout& layout) {
  if (!layout.pixels.is_encapsulated || layout.pixels.fragments.empty() ||
      has_run_lengths(layout)) {
    return std::nullopt;
  }
  return early_head(SourceFile(layout.path), fragments_of(layout, 0));
}

bool has_more_bits(const DicomLayout& layout, const PictureHead& head) {
  return head.bits > layout.bits_stored && head.bits <= layout.bits_allocated &&
         !has_whole_voxels(layout, head);
}

bool has_wide_number(const DicomSlice& slice) {
  const DicomLayout& layout = *slice.layout;
  const std::int64_t span = std::int64_t{1} << layout.bits_stored;
  UnsetBytes plane;
  try {
    plane = UnsetBytes(static_cast<std::size_t>(layout.frame_bytes()));
    if (!read_coded_frame(slice, plane.bytes())) return false;
  } catch (const Error&) {
    return false;  // reading it tells why
  } catch (const std::bad_alloc&) {
    return false;
  }
  const std::span<const std::byte> bytes = plane.bytes();
  if (layout.is_signed) {
    return layout.bits_allocated == 8    ? exceeds<std::int8_t>(bytes, -span / 2, span / 2 - 1)
           : layout.bits_allocated == 16 ? exceeds<std::int16_t>(bytes, -span / 2, span / 2 - 1)
                                         : exceeds<std::int32_t>(bytes, -span / 2, span / 2 - 1);
  }
  return layout.bits_allocated == 8    ? exceeds<std::uint8_t>(bytes, 0, span - 1)
         : layout.bits_allocated == 16 ? exceeds<std::uint16_t>(bytes, 0, span - 1)
                                       : exceeds<std::uint32_t>(bytes, 0, span - 1);
}

bool read_coded_frame(const DicomSlice& slice, std::span<std::byte> plane) {
  const DicomLayout& layout = *slice.layout;
  require_decoder(layout);
  constexpr std::size_t kMostBytes = std::numeric_limits<std::uint32_t>::max();
  if (plane.size() > kMostBytes) {
    reject(layout, "a compressed picture of " + std::to_string(plane.size()) +
                       " bytes is not read; GDCM reads " + std::to_string(kMostBytes) +
                       " at most");
  }
  const SourceFile file(layout.path);
  std::vector<std::vector<std::byte>> fragments;
  for (const ByteRun& run : fragments_of(layout, slice.frame)) {
    fragments.emplace_back(static_cast<std::size_t>(run.length));
    file.read_exactly(run.offset, fragments.back());
  }
  const std::optional<PictureHead> head = proven_head(layout, slice.frame, fragments);
  CodedPicture picture = coded_picture(layout, head);
  picture.fragments = std::move(fragments);
  if (!head) {
    decode(layout, picture, plane);
    return false;
  }
  picture.is_signed = head->is_signed || (layout.is_signed && !picture.transfer_syntax.starts_with(
                                                                  "1.2.840.10008.1.2.4.9"));
  const auto ratio = static_cast<std::size_t>(layout.bits_allocated / picture.bits_allocated);
  UnsetBytes narrow;
  std::span<std::byte> decoded = plane;
  if (ratio > 1) {
    narrow = UnsetBytes(plane.size() / ratio);
    decoded = narrow.bytes();
  }
  const bool has_few_bits = is_plain_jpeg(layout) && head->bits < kDecodedBits;
  if (has_few_bits) decode_few_bits(layout, *head, picture, decoded);
  else decode(layout, picture, decoded);
  if (head->bits == layout.bits_allocated && layout.bits_stored == head->bits) return true;
  switch (picture.bits_allocated) {
    case 8: settle_from<std::uint8_t>(layout, *head, decoded, plane); break;
    case 16: settle_from<std::uint16_t>(layout, *head, decoded, plane); break;
    default: settle_from<std::uint32_t>(layout, *head, decoded, plane); break;
  }
  return true;
}

}  // namespace octavo
