#include "octavo/io/dicom/dicom_pixels.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/unset_bytes.h"
#include "octavo/io/dicom/dicom_coded.h"
#include "octavo/io/dicom/dicom_palette.h"
#include "octavo/io/dicom/dicom_real_values.h"
#include "octavo/io/source/alternating_values.h"
#include "octavo/io/source/byte_order.h"
#include "octavo/io/source/described_source.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

std::string segment_text(const DicomLayout& layout, std::int64_t number) {
  for (const DicomSegment& segment : layout.segments) {
    if (segment.number == number) return std::to_string(number) + " " + escaped(segment.label);
  }
  return std::to_string(number);
}

/// Words of the file hold two voxels of 8 bits, or 16 of 1 bit, in the order of their high bytes.
bool has_swapped_words(const DicomLayout& layout) {
  return layout.big_endian && layout.pixels.is_words && layout.bits_allocated <= 8;
}

/// Bytes of the pixel data's value.
void read_value(const DicomPixels& pixels, const std::string& path, std::uint64_t at,
                std::span<std::byte> bytes) {
  if (pixels.inflated) pixels.inflated->read_exactly(pixels.native.offset + at, bytes);
  else SourceFile(path).read_exactly(pixels.native.offset + at, bytes);
}

/// Bytes of the native pixel data from `at` on, those of swapped words in the order of voxels.
void read_native_bytes(const DicomLayout& layout, std::uint64_t at, std::span<std::byte> bytes) {
  const ByteRun& native = layout.pixels.native;
  if (!has_swapped_words(layout)) return read_value(layout.pixels, layout.path, at, bytes);
  // A run may start and end in the middle of a word.
  const std::uint64_t first = at - at % 2;
  const std::uint64_t end = at + bytes.size();
  std::vector<std::byte> words(
      static_cast<std::size_t>(std::min(end + end % 2, native.length) - first));
  read_value(layout.pixels, layout.path, first, words);
  swap_values(words, 2);
  std::copy_n(words.begin() + static_cast<std::ptrdiff_t>(at - first), bytes.size(),
              bytes.begin());
}

/// Voxels of 1 bit, the lowest bit of a byte first; frames follow one another without a gap.
void read_native_bits(const DicomSlice& slice, std::int64_t frame, std::span<std::byte> plane) {
  const std::uint64_t first_bit = static_cast<std::uint64_t>(frame) * plane.size();
  const std::uint64_t first_byte = first_bit / 8;
  std::vector<std::byte> packed(
      static_cast<std::size_t>((first_bit + plane.size() + 7) / 8 - first_byte));
  read_native_bytes(*slice.layout, first_byte, packed);
  for (std::size_t i = 0; i < plane.size(); ++i) {
    const std::size_t bit = static_cast<std::size_t>(first_bit % 8) + i;
    plane[i] = packed[bit / 8] >> (bit % 8) & std::byte{1};
  }
}

/// One sample of each pixel of a color picture that starts at `at` in the pixel data.
void read_native_sample(const DicomSlice& slice, std::uint64_t at, std::span<std::byte> plane) {
  const DicomLayout& layout = *slice.layout;
  if (layout.is_planar) {
    read_native_bytes(layout, at + static_cast<std::uint64_t>(slice.channel) * plane.size(), plane);
    return;
  }
  const auto value_bytes = static_cast<std::size_t>(layout.bits_allocated / 8);
  std::vector<std::byte> all(static_cast<std::size_t>(layout.frame_bytes()));
  read_native_bytes(layout, at, all);
  take_alternating({value_bytes, layout.samples, slice.channel}, all, plane);
}

/// The frames of several segments as one plane of labels.
void read_labels(const DicomSlice& slice, std::span<std::byte> plane) {
  const DicomLayout& layout = *slice.layout;
  std::fill(plane.begin(), plane.end(), std::byte{0});
  std::vector<std::byte> bits(plane.size());
  for (const LabelFrame& part : slice.label_frames) {
    read_native_bits(slice, part.frame, bits);
    for (std::size_t i = 0; i < plane.size(); ++i) {
      if (bits[i] == std::byte{0}) continue;
      if (plane[i] != std::byte{0}) {
        throw Error(ErrorKind::source_rejected,
                    "segments " +
                        segment_text(layout, std::to_integer<std::int64_t>(plane[i])) + " and " +
                        segment_text(layout, part.label) + " overlap in frame " +
                        std::to_string(part.frame + 1) + ", and a voxel has one label",
                    layout.path)
            .with_field("segment", "a number or label");
      }
      plane[i] = static_cast<std::byte>(part.label);
    }
  }
}

void read_native(const DicomSlice& slice, std::span<std::byte> plane) {
  const DicomLayout& layout = *slice.layout;
  const std::uint64_t at = static_cast<std::uint64_t>(slice.frame) * layout.frame_bytes();
  if (layout.samples > 1) {
    read_native_sample(slice, at, plane);
  } else {
    read_native_bytes(layout, at, plane);
  }
  if (needs_swap(layout.big_endian)) {
    swap_values(plane, static_cast<std::size_t>(layout.bits_allocated / 8));
  }
}

/// Moves the stored bits of every value down to bit 0 and fills the others with the sign, or 0.
template <class T>
void keep_stored_bits(std::span<std::byte> plane, int shift_up, int shift_down) {
  using Unsigned = std::make_unsigned_t<T>;
  for (std::size_t at = 0; at + sizeof(T) <= plane.size(); at += sizeof(T)) {
    Unsigned raw;
    std::memcpy(&raw, plane.data() + at, sizeof raw);
    const auto lifted = static_cast<T>(static_cast<Unsigned>(raw << shift_up));
    const auto value = static_cast<T>(lifted >> shift_down);
    std::memcpy(plane.data() + at, &value, sizeof value);
  }
}

/// The type that holds the bits of a voxel; rejects bits that do not fit together.
VoxelType integer_type(const DicomLayout& layout) {
  const std::int64_t bits = layout.bits_allocated;
  if (bits != 8 && bits != 16 && bits != 32) {
    reject(layout,
           std::to_string(bits) + " bits allocated per voxel are not read; 8, 16 and 32 are");
  }
  if (layout.bits_stored < 1 || layout.high_bit >= bits ||
      layout.high_bit + 1 < layout.bits_stored) {
    reject(layout, std::to_string(layout.bits_stored) + " bits stored up to bit " +
                       std::to_string(layout.high_bit) + " do not fit the " + std::to_string(bits) +
                       " bits allocated");
  }
  if (bits == 8) return layout.is_signed ? VoxelType::int8 : VoxelType::uint8;
  if (bits == 16) return layout.is_signed ? VoxelType::int16 : VoxelType::uint16;
  return layout.is_signed ? VoxelType::int32 : VoxelType::uint32;
}

void clean_unused_bits(const DicomLayout& layout, std::span<std::byte> plane) {
  // Decoders put the stored bits at the bottom; native values keep them below the high bit, also
  // in run lengths.
  const bool is_decoded = layout.pixels.is_encapsulated && !has_run_lengths(layout);
  const std::int64_t high = is_decoded ? layout.bits_stored - 1 : layout.high_bit;
  const int shift_up = static_cast<int>(layout.bits_allocated - 1 - high);
  const int shift_down = static_cast<int>(layout.bits_allocated - layout.bits_stored);
  if (shift_up == 0 && shift_down == 0) return;
  with_voxel_type(integer_type(layout), [&](auto tag) {
    using T = typename decltype(tag)::type;
    if constexpr (std::is_integral_v<T>) keep_stored_bits<T>(plane, shift_up, shift_down);
  });
}

/// Double Float Pixel Data as float32.
void read_doubles(const DicomSlice& slice, std::span<std::byte> plane) {
  constexpr Narrowing kRounded = {WideType::float64, VoxelType::float32, true};
  std::vector<std::byte> wide(plane.size() / sizeof(float) * sizeof(double));
  read_native(slice, wide);
  narrow(kRounded, wide, plane,
         {slice.layout->path, slice.layout->stored_columns(), slice.frame, 0});
}

/// The values of a whole frame as they are stored.
void read_stored(const DicomSlice& slice, std::span<std::byte> plane) {
  const DicomLayout& layout = *slice.layout;
  if (layout.pixels.is_float && layout.bits_allocated == 64) return read_doubles(slice, plane);
  bool are_clean = layout.pixels.is_float;
  if (layout.pixels.is_encapsulated) {
    are_clean = read_coded_frame(slice, plane);
  } else {
    read_native(slice, plane);
  }
  if (!are_clean) clean_unused_bits(layout, plane);
}

/// One tile out of a mosaic.
void read_tile(const DicomSlice& slice, std::span<std::byte> plane) {
  const DicomLayout& layout = *slice.layout;
  const auto row_bytes = plane.size() / static_cast<std::size_t>(layout.rows);
  const auto across = static_cast<std::size_t>(layout.tiles_across);
  UnsetBytes whole(plane.size() * across * across);
  read_stored(slice, whole.bytes());
  const auto tile = static_cast<std::size_t>(slice.tile);
  const auto rows = static_cast<std::size_t>(layout.rows);
  for (std::size_t y = 0; y < rows; ++y) {
    const std::size_t from = ((tile / across * rows + y) * across + tile % across) * row_bytes;
    std::copy_n(whole.data() + from, row_bytes,
                plane.begin() + static_cast<std::ptrdiff_t>(y * row_bytes));
  }
}

/// A frame of a label map: 0 is no segment; of one that is taken alone, voxels are 1.
void read_label_map(const DicomSlice& slice, std::span<std::byte> plane) {
  const DicomLayout& layout = *slice.layout;
  read_stored(slice, plane);
  const std::int64_t background = layout.padding_value.value_or(0);
  if (!slice.taken_label && background == 0) return;
  with_voxel_type(integer_type(layout), [&](auto tag) {
    using T = typename decltype(tag)::type;
    for (std::size_t at = 0; at + sizeof(T) <= plane.size(); at += sizeof(T)) {
      T value;
      std::memcpy(&value, plane.data() + at, sizeof value);
      const auto label = static_cast<std::int64_t>(value);
      if (slice.taken_label) value = static_cast<T>(label == *slice.taken_label ? 1 : 0);
      else if (label == background) value = 0;
      std::memcpy(plane.data() + at, &value, sizeof value);
    }
  });
}

/// Rejects segmentations but label maps and plain BINARY and FRACTIONAL ones.
void require_readable_segmentation(const DicomLayout& layout) {
  const bool is_plain = layout.samples == 1 && !layout.pixels.is_float;
  const bool is_binary = is_plain && layout.segmentation_type == "BINARY" &&
                         layout.bits_allocated == 1 && !layout.pixels.is_encapsulated;
  const bool is_fractional = is_plain && layout.segmentation_type == "FRACTIONAL" &&
                             layout.bits_allocated == 8 && !layout.is_signed;
  const bool is_label_map = is_plain && layout.is_label_map() && !layout.is_signed &&
                            (layout.bits_allocated == 8 || layout.bits_allocated == 16);
  if (is_binary || is_fractional || is_label_map) return;
  const std::string type = layout.segmentation_type.empty() ? "unknown" : layout.segmentation_type;
  reject(layout, "a DICOM segmentation (SEG) of type " + escaped(type) + " with " +
                     std::to_string(layout.bits_allocated) + " bits per voxel" +
                     (layout.pixels.is_encapsulated ? ", compressed," : "") +
                     " is not read; plain BINARY ones of 1 bit, FRACTIONAL ones of 8 bits and "
                     "LABELMAP ones of 8 or 16 bits are. Convert it to NIfTI or NRRD labels first");
}

/// Rejects pictures but grey ones, those with a palette and uncompressed RGB ones.
void require_readable_colors(const DicomLayout& layout) {
  if (has_palette(layout)) return;
  const bool is_grey = layout.samples == 1 && layout.photometric.starts_with("MONOCHROME");
  const bool is_rgb = layout.samples == 3 && layout.photometric == "RGB";
  if (is_grey || (is_rgb && !layout.pixels.is_encapsulated)) return;
  reject(layout, std::string("a ") + (layout.pixels.is_encapsulated ? "compressed " : "") +
                     "color picture (" + escaped(layout.photometric) + ", " +
                     std::to_string(layout.samples) + " samples per pixel) is not read; grey, "
                     "palette color and uncompressed RGB (of which one channel is taken) are. "
                     "Convert it first, as gdcmconv does by its option raw");
}

void require_readable_floats(const DicomLayout& layout) {
  const bool has_width = layout.bits_allocated == 32 || layout.bits_allocated == 64;
  if (has_width && layout.samples == 1 && !layout.pixels.is_encapsulated) return;
  reject(layout, std::string(layout.pixels.is_encapsulated ? "compressed " : "") +
                     "float pixel data of " + std::to_string(layout.bits_allocated) +
                     " bits and " + std::to_string(layout.samples) +
                     " samples are not read; plain ones of 32 or 64 bits and 1 sample are");
}

}  // namespace

VoxelType dicom_voxel_type(const DicomLayout& layout) {
  if (layout.is_segmentation()) {
    require_readable_segmentation(layout);
    return layout.is_label_map() ? integer_type(layout) : VoxelType::uint8;
  }
  if (layout.pixels.is_float) {
    require_readable_floats(layout);
    return VoxelType::float32;
  }
  require_readable_colors(layout);
  const VoxelType stored = integer_type(layout);
  if (layout.has_real_values) return VoxelType::float32;
  if (layout.color_table == nullptr) return stored;
  return layout.color_table->bits == 8 ? VoxelType::uint8 : VoxelType::uint16;
}

void read_dicom_frame(const DicomSlice& slice, std::span<std::byte> plane) {
  if (slice.is_blank) {
    std::ranges::fill(plane, std::byte{0});
    return;
  }
  if (slice.layout->bits_allocated == 1) {
    if (slice.label_frames.empty()) {
      read_native_bits(slice, slice.frame, plane);
    } else {
      read_labels(slice, plane);
    }
    return;
  }
  const DicomLayout& layout = *slice.layout;
  if (layout.is_label_map()) return read_label_map(slice, plane);
  if (layout.tile_count > 1) return read_tile(slice, plane);
  if (layout.color_table == nullptr && !slice.made_real_by) return read_stored(slice, plane);
  const VoxelType type = integer_type(layout);
  UnsetBytes values(static_cast<std::size_t>(layout.columns * layout.rows) *
                    bytes_per_value(type));
  read_stored(slice, values.bytes());
  if (slice.made_real_by) {
    try {
      return make_real(*slice.made_real_by, type, values.bytes(), plane);
    } catch (const Error& failure) {
      throw failure.with_path(layout.path);
    }
  }
  look_up_colors(*layout.color_table, type, values.bytes(), plane);
}

}  // namespace octavo
