// Pictures whose values are numbers of colors: PALETTE COLOR.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "octavo/io/dicom/dicom_slice.h"
#include "octavo/io/source/component_choice.h"

namespace octavo {

/// One color of a palette: what is shown for each value.
struct DicomColorTable {
  std::vector<std::uint16_t> colors;
  std::int64_t first_value = 0;  ///< the value of the first color; those outside take the nearest
  std::int64_t bits = 8;         ///< of a color: 8 or 16

  bool operator==(const DicomColorTable&) const = default;
};

/// True for a picture of one sample, a number of a color.
bool has_palette(const DicomLayout& layout);

/// What can be taken of such a picture: "index", "red", "green", "blue".
SourceComponents palette_components();

/// The slices with the table of the color that `channel` counts among palette_components(); with
/// none for the index. Tables that are alike are held once.
/// Throws Error{source_rejected} where a table is missing, segmented or does not fit its
///        descriptor, or where colors of 8 and 16 bits are mixed; as read_dicom_file
/// Source  DICOM PS3.3, C.7.6.3.1.5 and C.7.6.3.1.6
std::vector<DicomSlice> choose_palette_color(std::vector<DicomSlice> slices, std::int64_t channel);

/// Replaces each value by its color. `values` are of `type`, `colors` uint8 or uint16 as
/// table.bits says.
void look_up_colors(const DicomColorTable& table, VoxelType type,
                    std::span<const std::byte> values, std::span<std::byte> colors);

}  // namespace octavo
