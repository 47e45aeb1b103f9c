#include "octavo/tasks/measure.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/masks.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo {

namespace {

/// The percentiles from low to high, each once.
std::vector<double> sorted_percentiles(std::vector<double> percentiles) {
  for (const double percent : percentiles) {
    if (percent >= 0 && percent <= 100) continue;
    throw Error(ErrorKind::invalid_argument,
                "percentile " + number_text(percent) + ": must be 0 to 100");
  }
  std::sort(percentiles.begin(), percentiles.end());
  percentiles.erase(std::unique(percentiles.begin(), percentiles.end()), percentiles.end());
  return percentiles;
}

std::shared_ptr<const FileReader> open_grey(const MeasureOptions& options,
                                            const VolumeDescription& labels,
                                            const TaskContext& context) {
  std::shared_ptr<const FileReader> grey = open_volume(options.grey, context);
  require_same_grid(labels, options.labels, grey->description(), options.grey);
  if (grey->description().kind == VolumeKind::grey) return grey;
  throw Error(ErrorKind::invalid_argument, "holds labels, not grey values", options.grey)
      .with_field("grey.kind");
}

std::shared_ptr<const FileReader> open_regions(const MeasureOptions& options,
                                               const TaskContext& context) {
  try {
    return open_labels(options.labels, context, kAsLabels);
  } catch (const Error& error) {
    if (error.field() != kAsLabels.field || options.grey.empty() ||
        open_volume(options.grey, context)->description().kind != VolumeKind::labels) {
      throw;
    }
    throw Error(ErrorKind::invalid_argument,
                "holds grey values, and " + options.grey +
                    " holds labels: they stand in each other's place",
                options.labels);
  }
}

/// Grey statistics in real units.
GreyStatistics real_statistics(const GreyStatistics& stored, const Rescale& rescale,
                               std::uint64_t voxels) {
  GreyStatistics real;
  real.not_finite = stored.not_finite;
  real.mean = rescale.to_real(stored.mean);
  real.deviation = std::abs(rescale.slope) * stored.deviation;
  real.minimum = rescale.to_real(stored.minimum);
  real.maximum = rescale.to_real(stored.maximum);
  if (rescale.slope < 0) std::swap(real.minimum, real.maximum);
  real.sum = rescale.slope * stored.sum +
             rescale.intercept * static_cast<double>(voxels - stored.not_finite);
  for (const double value : stored.percentiles) real.percentiles.push_back(rescale.to_real(value));
  return real;
}

MeasuredRegion measured(RegionMeasure region, const VolumeDescription& labels,
                        const FileReader* grey) {
  MeasuredRegion one;
  if (region.grey) {
    region.grey =
        real_statistics(*region.grey, grey->description().rescale, region.voxel_count);
  }
  if (const auto mm3 = mm3_of(region.voxel_count, labels)) {
    one.in_mm = {*mm3, labels.geometry.to_world(region.centroid),
                 principal_axes(region, labels.geometry), {}};
    if (region.grey) {
      const auto values = static_cast<double>(region.voxel_count - region.grey->not_finite);
      one.in_mm->integrated =
          region.grey->mean * (*mm3 * (values / static_cast<double>(region.voxel_count)));
    }
  }
  one.region = std::move(region);
  return one;
}

void warn_of_absent(const std::vector<std::int64_t>& labels, const MeasureResult& result,
                    const std::string& path, const TaskContext& context) {
  for (const std::int64_t label : labels) {
    const bool is_there = std::any_of(
        result.regions.begin(), result.regions.end(),
        [&](const MeasuredRegion& one) { return one.region.label == label; });
    if (!is_there) context.warn(path + ": no voxel has " + label_words(result.names, label));
  }
}

void warn_of_not_finite(const MeasureResult& result, const std::string& path,
                        const TaskContext& context) {
  std::uint64_t count = 0;
  for (const MeasuredRegion& one : result.regions) {
    if (one.region.grey) count += one.region.grey->not_finite;
  }
  if (count == 0) return;
  context.warn(path + ": " + std::to_string(count) +
               " of the voxels measured are NaN or infinite and left out of grey values");
}

}  // namespace

MeasureResult measure(const MeasureOptions& options, const TaskContext& context) {
  const std::shared_ptr<const FileReader> labels = open_regions(options, context);
  const VolumeDescription& volume = labels->description();
  std::shared_ptr<const FileReader> grey;
  if (!options.grey.empty()) grey = open_grey(options, volume, context);
  MeasureResult result;
  result.percentiles = sorted_percentiles(options.percentiles);
  if (!is_spacing_known(volume)) {
    context.warn(options.labels + ": its spacing is not known, so nothing is given in mm; give it "
                                  "when the volume is built");
  }
  // A brick with its labels widened per thread, and the sums of 64 bricks.
  constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
  context.require_memory((64 + 12 * static_cast<std::uint64_t>(context.thread_count())) * kMiB,
                         "measurements");

  result.names = volume.metadata.facts().labels;
  const RegionMeasureOptions asked =
      {result.percentiles, grey && grey->description().rescale.slope < 0,
       labels_of(options.asked, result.names, options.labels)};
  std::vector<RegionMeasure> regions;
  context.on_threads(
      [&] { regions = measure_regions(*labels, grey.get(), asked, context.watcher()); });
  for (RegionMeasure& region : regions) {
    result.regions.push_back(measured(std::move(region), volume, grey.get()));
  }
  warn_of_absent(asked.labels, result, options.labels, context);
  warn_of_not_finite(result, options.grey, context);
  if (grey) result.unit = unit_of(grey->description());
  return result;
}

}  // namespace octavo
