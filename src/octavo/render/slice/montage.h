// Many slices in one picture: which ones, and where each stands.
#pragma once

#include <cstdint>
#include <vector>

#include "octavo/render/stroke.h"

namespace octavo {

/// `count` of the slices 0 .. end - 1, spread evenly: the middles of equal parts.
/// Throws Error{invalid_argument} unless 1 <= count <= end
std::vector<std::int64_t> spread_slices(std::int64_t end, std::int64_t count);

/// `count` slices a step apart, as near to being centered at `middle` as 0 .. end - 1 has room.
/// Throws Error{invalid_argument} unless all have room
std::vector<std::int64_t> spaced_slices(std::int64_t end, std::int64_t count, std::int64_t step,
                                        std::int64_t middle);

/// The cells of a picture of many sections, row by row, with a gap between them.
struct MontageGrid {
  std::int64_t columns = 1;
  std::int64_t rows = 1;
  std::int64_t cell_width = 0;
  std::int64_t cell_height = 0;
  std::int64_t gap = 0;

  std::int64_t width() const { return columns * (cell_width + gap) - gap; }
  std::int64_t height() const { return rows * (cell_height + gap) - gap; }
  PixelArea cell(std::int64_t number) const {
    return {number % columns * (cell_width + gap), number / columns * (cell_height + gap),
            cell_width, cell_height};
  }
};

/// The number of columns with which `count` cells make a picture whose sides are nearest to 4 : 3.
std::int64_t montage_columns(std::int64_t count, std::int64_t cell_width, std::int64_t cell_height);

/// The grid of `count` cells in so many columns; one cell has no gap.
MontageGrid montage_grid(std::int64_t count, std::int64_t columns, std::int64_t cell_width,
                         std::int64_t cell_height);

}  // namespace octavo
