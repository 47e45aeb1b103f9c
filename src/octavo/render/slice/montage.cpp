#include "octavo/render/slice/montage.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "octavo/core/error.h"

namespace octavo {

std::vector<std::int64_t> spread_slices(std::int64_t end, std::int64_t count) {
  if (count < 1 || count > end) {
    throw Error(ErrorKind::invalid_argument, std::to_string(count) + " slices of " +
                                                 std::to_string(end) + "; there are not so many");
  }
  std::vector<std::int64_t> slices;
  for (std::int64_t i = 0; i < count; ++i) slices.push_back((2 * i + 1) * end / (2 * count));
  return slices;
}

std::vector<std::int64_t> spaced_slices(std::int64_t end, std::int64_t count, std::int64_t step,
                                        std::int64_t middle) {
  if (count < 1 || step < 1 || count > end || (count - 1) > (end - 1) / step) {
    throw Error(ErrorKind::invalid_argument,
                std::to_string(count) + " slices " + std::to_string(step) +
                    " apart have no room among " + std::to_string(end));
  }
  const std::int64_t reach = (count - 1) * step;
  const std::int64_t first = std::clamp<std::int64_t>(middle - reach / 2, 0, end - 1 - reach);
  std::vector<std::int64_t> slices;
  for (std::int64_t i = 0; i < count; ++i) slices.push_back(first + i * step);
  return slices;
}

std::int64_t montage_columns(std::int64_t count, std::int64_t cell_width,
                             std::int64_t cell_height) {
  constexpr double kSides = 4.0 / 3;
  std::int64_t best = 1;
  double best_miss = 0;
  for (std::int64_t columns = 1; columns <= count; ++columns) {
    const std::int64_t rows = (count + columns - 1) / columns;
    const double sides =
        static_cast<double>(columns * cell_width) / static_cast<double>(rows * cell_height);
    // Empty cells count as well as bad sides.
    const double empty = static_cast<double>(rows * columns) / static_cast<double>(count);
    const double miss = std::abs(std::log(sides / kSides)) + std::log(empty);
    if (columns > 1 && miss >= best_miss) continue;
    best = columns;
    best_miss = miss;
  }
  return best;
}

MontageGrid montage_grid(std::int64_t count, std::int64_t columns, std::int64_t cell_width,
                         std::int64_t cell_height) {
  MontageGrid grid;
  grid.columns = columns;
  grid.rows = (count + columns - 1) / columns;
  grid.cell_width = cell_width;
  grid.cell_height = cell_height;
  grid.gap = count == 1 ? 0 : std::max<std::int64_t>(2, std::min(cell_width, cell_height) / 96);
  return grid;
}

}  // namespace octavo
