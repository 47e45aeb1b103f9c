#include "octavo/io/dicom/dicom_extent.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <string_view>
#include <vector>

#include "octavo/core/checked.h"
#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/io/dicom/dicom_coded.h"
#include "octavo/io/source/claimed_bytes.h"
#include "octavo/io/source/described_source.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

constexpr std::string_view kJpegs = "1.2.840.10008.1.2.4.";  // two digits more

[[noreturn]] void reject_more(const DicomLayout& layout, std::uint64_t pictures) {
  reject(layout, "the pixel data hold " + std::to_string(pictures) +
                     " pictures, Number of Frames (0028,0008) says " +
                     std::to_string(layout.frames) +
                     ": which of them belong to the volume is not known; correct the number in "
                     "the file, or export the series again");
}

/// Pictures of this size that fill the native pixel data to the last word; 0 when none do.
std::uint64_t pictures_in(const DicomLayout& layout) {
  const auto voxels = static_cast<std::uint64_t>(layout.stored_rows() *
                                                 layout.stored_columns() * layout.samples);
  const std::uint64_t length = layout.pixels.native.length;
  if (layout.bits_allocated != 1) {
    const std::uint64_t frame = layout.frame_bytes();
    return length % frame <= 1 ? length / frame : 0;
  }
  const std::uint64_t count = length * 8 / voxels;
  return length - (count * voxels + 7) / 8 <= 1 ? count : 0;
}

void check_native(const DicomLayout& layout) {
  const std::uint64_t length = layout.pixels.native.length;
  const std::uint64_t needed = layout.native_bytes();
  if (length < needed) {
    reject(layout, "the pixel data hold " + std::to_string(length) + " bytes, " +
                       std::to_string(needed) + " are needed for " +
                       size_text({layout.stored_columns(), layout.stored_rows(), layout.frames}) +
                       " voxels; the file is cut");
  }
  if (surplus_bytes(layout) == 0) return;
  const std::uint64_t pictures = pictures_in(layout);
  if (pictures > static_cast<std::uint64_t>(layout.frames)) reject_more(layout, pictures);
}

/// True for what JPEG, JPEG-LS and JPEG 2000 pictures start with, or those of run lengths: 1 to 15
/// segments, the first of them behind a header of 64 bytes (PS3.5, G.5). The first mark of JPEG
/// 2000 alone may stand in the midst of a picture.
bool starts_picture(const SourceFile& file, const ByteRun& fragment, bool is_run_lengths) {
  using namespace std::string_view_literals;
  std::array<std::byte, 8> head{};
  const std::size_t count = file.read_some(
      fragment.offset, std::span(head).first(std::min<std::size_t>(head.size(), fragment.length)));
  const std::string_view text(reinterpret_cast<const char*>(head.data()), count);
  if (!is_run_lengths) {
    return text.starts_with("\xff\xd8"sv) || text.starts_with("\xff\x4f\xff\x51"sv);
  }
  return count == head.size() && text[0] >= 1 && text[0] <= 15 &&
         text.substr(1) == "\0\0\0\x40\0\0\0"sv;
}

/// The fragments that start a compressed picture.
std::vector<ByteRun> picture_starts(const DicomLayout& layout) {
  const bool is_run_lengths = has_run_lengths(layout);
  const SourceFile file(layout.path);
  std::vector<ByteRun> starts;
  std::ranges::copy_if(layout.pixels.fragments, std::back_inserter(starts),
                       [&](const ByteRun& fragment) {
                         return starts_picture(file, fragment, is_run_lengths);
                       });
  return starts;
}

/// How many bytes of voxels a compressed byte can stand for, at most. JPEG 2000 has no such bound:
/// a byte can say that all voxels are alike, however many there are.
std::optional<std::uint64_t> widest_ratio(const DicomLayout& layout) {
  const std::string_view syntax = layout.transfer_syntax;
  if (has_run_lengths(layout)) return kPackBitsRatio;
  if (!syntax.starts_with(kJpegs) || syntax.size() != kJpegs.size() + 2) return std::nullopt;
  const auto sample_bytes = static_cast<std::uint64_t>((layout.bits_allocated + 7) / 8);
  switch (syntax[kJpegs.size()]) {
    case '5':
    case '6':
    case '7': return kJpegSamples * sample_bytes;
    case '8': {
      // A run ends with its row.
      const auto columns = static_cast<std::uint64_t>(layout.stored_columns());
      return 8 * std::min(columns, kJpegLsRun) * sample_bytes;
    }
    default: return std::nullopt;
  }
}

void check_holdable(const DicomLayout& layout) {
  const std::optional<std::uint64_t> ratio = widest_ratio(layout);
  if (!ratio) return;
  std::uint64_t bytes_there = 0;
  for (const ByteRun& fragment : layout.pixels.fragments) bytes_there += fragment.length;
  const std::uint64_t claimed = checked_mul(
      layout.frame_bytes(), static_cast<std::uint64_t>(layout.frames), "pixel data");
  require_holdable(layout.path, bytes_there, claimed, *ratio);
}

void check_compressed(const DicomLayout& layout) {
  const DicomPixels& pixels = layout.pixels;
  const auto frames = static_cast<std::uint64_t>(layout.frames);
  const bool one_each = pixels.fragments.size() == frames;
  const bool has_table = pixels.frame_offsets.size() == frames;
  if (pixels.fragments.size() > frames) {
    const std::uint64_t pictures =
        pixels.picture_count ? *pixels.picture_count : picture_starts(layout).size();
    if (pictures > frames) reject_more(layout, pictures);
  }
  if (pixels.fragments.empty() || (frames > 1 && !one_each && !has_table)) {
    reject(layout,
           std::to_string(layout.frames) + " frames, " + std::to_string(pixels.fragments.size()) +
               " compressed fragments, and neither a table nor the starts of as many pictures tell "
               "which is whose; the file is cut or damaged");
  }
  check_holdable(layout);
}

}  // namespace

void require_part_for_each_frame(const DicomLayout& layout) {
  const DicomPixels& pixels = layout.pixels;
  const auto frames = static_cast<std::uint64_t>(layout.frames);
  const std::uint64_t parts =
      pixels.is_encapsulated ? pixels.fragments.size() : pixels.native.length * 8;
  if (frames < 2 || frames <= parts) return;
  reject(layout, "Number of Frames (0028,0008) says " + std::to_string(frames) +
                     ", and the pixel data have " +
                     (pixels.is_encapsulated
                          ? counted_text(static_cast<std::int64_t>(parts), "compressed fragment")
                          : counted_text(static_cast<std::int64_t>(parts / 8), "byte")) +
                     "; the file is cut or damaged");
}

void check_dicom_pixels(const DicomLayout& layout) {
  if (layout.is_slide) {
    reject(layout, "its " + std::to_string(layout.frames) +
                       " frames are tiles of one picture, a slide (Total Pixel Matrix Columns "
                       "(0048,0006)), and no planes of a volume; join them into a picture first");
  }
  if (layout.pixels.is_encapsulated) {
    check_compressed(layout);
  } else {
    check_native(layout);
  }
}

void find_frame_starts(DicomLayout& layout) {
  DicomPixels& pixels = layout.pixels;
  const auto frames = static_cast<std::size_t>(layout.frames);
  if (frames < 2 || pixels.fragments.size() <= frames || pixels.frame_offsets.size() == frames)
    return;
  const std::vector<ByteRun> starts = picture_starts(layout);
  pixels.picture_count = starts.size();
  const std::uint64_t first = pixels.fragments.front().offset;
  if (starts.size() != frames || starts.front().offset != first) return;
  pixels.frame_offsets.clear();
  for (const ByteRun& start : starts) pixels.frame_offsets.push_back(start.offset - first);
}

std::uint64_t surplus_bytes(const DicomLayout& layout) {
  if (layout.pixels.is_encapsulated) return 0;
  const std::uint64_t needed = layout.native_bytes();
  // A value has an even length.
  return layout.pixels.native.length - needed > needed % 2 ? layout.pixels.native.length - needed
                                                           : 0;
}

}  // namespace octavo
