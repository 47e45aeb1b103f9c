// What is asked of an index root once it is parsed, or while it is made.
#include <algorithm>

#include "octavo/file/index.h"

namespace octavo {

namespace {

// The errors of float32 bricks are counted in this part of the max error.
constexpr std::uint64_t kFloatErrorSteps = 1024;

}  // namespace

double error_step(const FileHeader& header) {
  if (is_integer(header.description.type)) return 1;
  return header.max_error / static_cast<double>(kFloatErrorSteps);
}

std::uint64_t max_error_steps(const FileHeader& header) {
  if (header.detail_level > 0) {
    const ValueRange all = value_range(header.description.type);
    return static_cast<std::uint64_t>(all.max - all.min);
  }
  if (header.max_error == 0) return 0;
  if (is_integer(header.description.type)) return static_cast<std::uint64_t>(header.max_error);
  return kFloatErrorSteps;
}

bool has_errors(const FileHeader& header, int tier) {
  return tier == 0 && (header.max_error > 0 || header.detail_level > 0);
}

TierIndex make_tier_index(const Levels& levels, int tier) {
  TierIndex index;
  index.grid = levels.brick_grid(tier);
  index.layer_bricks = index.grid.x * index.grid.y;
  index.layer_pages = (index.layer_bricks + kPageBricks - 1) / kPageBricks;
  return index;
}

std::uint32_t IndexRoot::model_of_slab(std::int64_t slab) const {
  const auto after = std::upper_bound(
      models.begin(), models.end(), slab,
      [](std::int64_t s, const ModelRef& model) { return s < std::int64_t{model.first_slab}; });
  return static_cast<std::uint32_t>(after - models.begin() - 1);
}

std::uint32_t IndexRoot::coarse_model() const {
  const bool is_behind_slabs = std::int64_t{models.back().first_slab} == tiers.front().grid.z;
  return is_behind_slabs ? static_cast<std::uint32_t>(models.size() - 1) : 0;
}

std::uint64_t IndexRoot::slab_trailer_offset(std::int64_t slab) const {
  const TierIndex& tier = tiers.front();
  if (slab + 1 == tier.grid.z) return tier.piece_end[0];
  const std::uint32_t next_model = model_of_slab(slab + 1);
  const auto next_page = static_cast<std::size_t>((slab + 1) * tier.layer_pages);
  const std::uint64_t slab_end = next_model != model_of_slab(slab)
                                     ? models[next_model].offset
                                     : tier.pages[next_page].piece_start[0];
  return slab_end - slab_trailer_bytes[static_cast<std::size_t>(slab)];
}

std::uint64_t IndexRoot::piece_end(int tier_number, std::size_t page, int piece) const {
  const TierIndex& tier = tiers[static_cast<std::size_t>(tier_number)];
  const auto p = static_cast<std::size_t>(piece);
  const bool ends_layer = tier.first_place(page) + tier.brick_count(page) == tier.layer_bricks;
  if (tier_number == 0 && piece == 0 && ends_layer) return slab_trailer_offset(tier.layer_of(page));
  return page + 1 < tier.pages.size() ? tier.pages[page + 1].piece_start[p] : tier.piece_end[p];
}

ValueRange IndexRoot::range() const {
  ValueRange all = tiers.front().pages.front().range;
  for (const PageRef& page : tiers.front().pages) {
    all = {std::min(all.min, page.range.min), std::max(all.max, page.range.max)};
  }
  return all;
}

std::uint64_t IndexRoot::error_steps() const {
  std::uint64_t largest = 0;
  for (const PageRef& page : tiers.front().pages) largest = std::max(largest, page.error_steps);
  return largest;
}

}  // namespace octavo
