#include "octavo/io/dicom/dicom_real_values.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/text.h"

namespace octavo {

namespace {

bool holds_plain_pet(const DicomSlice& slice) {
  const DicomLayout& layout = *slice.layout;
  return layout.modality == "PT" && layout.samples == 1 && layout.tile_count == 1 &&
         !layout.pixels.is_float && !layout.is_segmentation() && !layout.padding_value &&
         layout.color_table == nullptr;
}

bool is_lost(double real, float made) { return !std::isfinite(made) || (made == 0 && real != 0); }

}  // namespace

std::vector<DicomSlice> take_real_values(std::vector<DicomSlice> slices,
                                         std::vector<Warning>& warnings) {
  const auto has_other_slope = [&](const DicomSlice& slice) {
    return slice.values.rescale != slices.front().values.rescale;
  };
  const auto other = std::ranges::find_if(slices, has_other_slope);
  if (other == slices.end() || !std::ranges::all_of(slices, holds_plain_pet)) return slices;
  const auto text = [](const DicomSlice& slice) {
    const Rescale& rescale = slice.values.rescale;
    return exact_text(rescale.slope) + " x + " + exact_text(rescale.intercept) + " in " +
           slice.name();
  };
  warnings.push_back("the slices have several rescales (" + text(slices.front()) + ", " +
                     text(*other) + "): voxels are real values, rounded to float32");
  std::map<std::shared_ptr<const DicomLayout>, std::shared_ptr<const DicomLayout>> changed;
  for (DicomSlice& slice : slices) {
    std::shared_ptr<const DicomLayout>& layout = changed[slice.layout];
    if (layout == nullptr) {
      auto real = std::make_shared<DicomLayout>(*slice.layout);
      real->has_real_values = true;
      layout = std::move(real);
    }
    slice.layout = layout;
    slice.made_real_by = std::exchange(slice.values.rescale, Rescale{});
  }
  return slices;
}

void make_real(const Rescale& rescale, VoxelType type, std::span<const std::byte> stored,
               std::span<std::byte> real) {
  with_voxel_type(type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    for (std::size_t i = 0; i < stored.size() / sizeof(T); ++i) {
      T value;
      std::memcpy(&value, stored.data() + i * sizeof(T), sizeof(T));
      const double exact = rescale.to_real(static_cast<double>(value));
      const auto made = static_cast<float>(exact);
      if (is_lost(exact, made)) {
        throw Error(ErrorKind::source_rejected,
                    "its rescale (" + exact_text(rescale.slope) + " x + " +
                        exact_text(rescale.intercept) + ") makes " + std::to_string(value) + " " +
                        exact_text(exact) + ", which float32 does not hold");
      }
      std::memcpy(real.data() + i * sizeof made, &made, sizeof made);
    }
  });
}

}  // namespace octavo
