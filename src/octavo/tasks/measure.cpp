#include "octavo/tasks/measure.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/sha256.h"
#include "octavo/core/text.h"
#include "octavo/tasks/files/part_result.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/masks.h"
#include "octavo/tasks/region_lines.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo {

namespace {

constexpr const char* kMeasureKind = "measure";

/// The percentiles from low to high, each once.
std::vector<double> sorted_percentiles(std::vector<double> percentiles) {
  for (double& percent : percentiles) {
    if (!(percent >= 0 && percent <= 100)) {
      throw Error(ErrorKind::invalid_argument,
                  "percentile " + exact_text(percent) + ": must be 0 to 100");
    }
    if (percent == 0) percent = 0;  // -0 has another text
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

/// The files of a measurement, and what is asked of them.
struct Measurement {
  std::shared_ptr<const FileReader> labels;
  std::shared_ptr<const FileReader> grey;  // null where there is none
  LabelNames names;
  RegionMeasureOptions asked;
};

Measurement opened_to_measure(const MeasureOptions& options, const TaskContext& context) {
  Measurement work;
  work.labels = open_regions(options, context);
  const VolumeDescription& volume = work.labels->description();
  if (!options.grey.empty()) work.grey = open_grey(options, volume, context);
  work.names = volume.metadata.facts().labels;
  work.asked = {sorted_percentiles(options.percentiles),
                work.grey && work.grey->description().rescale.slope < 0,
                labels_of(options.asked, work.names, options.labels)};
  return work;
}

void require_memory_to_measure(const TaskContext& context) {
  // A brick with its labels widened per thread, and the sums of 64 bricks.
  constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
  context.require_memory((64 + 12 * static_cast<std::uint64_t>(context.thread_count())) * kMiB,
                         "measurements");
}

void warn_of_spacing(const Measurement& work, const std::string& path,
                     const TaskContext& context) {
  if (is_spacing_known(work.labels->description())) return;
  context.warn(path + ": its spacing is not known, so nothing is given in mm; give it when the "
                      "volume is built");
}

MeasureResult result_of(const Measurement& work, std::vector<RegionMeasure> regions,
                        const MeasureOptions& options, const TaskContext& context) {
  MeasureResult result;
  result.percentiles = work.asked.percentiles;
  result.names = work.names;
  for (RegionMeasure& region : regions) {
    result.regions.push_back(
        measured(std::move(region), work.labels->description(), work.grey.get()));
  }
  warn_of_absent(work.asked.labels, result, options.labels, context);
  warn_of_not_finite(result, options.grey, context);
  if (work.grey) result.unit = unit_of(work.grey->description());
  return result;
}

/// What all parts of one measurement have in common: voxels, labels and percentiles.
JsonObject question_of(const Measurement& work) {
  JsonObject question;
  question.set("label_digest", hex_text(work.labels->voxel_digest()));
  question.set("grey_digest", work.grey ? hex_text(work.grey->voxel_digest()) : "");
  question.set("asked", work.asked.labels);
  std::vector<std::string> percentiles;
  for (const double percent : work.asked.percentiles) percentiles.push_back(exact_text(percent));
  question.set("percentiles", percentiles);
  question.set("falls", work.asked.falls);
  return question;
}

}  // namespace

MeasureResult measure(const MeasureOptions& options, const TaskContext& context) {
  const Measurement work = opened_to_measure(options, context);
  warn_of_spacing(work, options.labels, context);
  require_memory_to_measure(context);
  std::vector<RegionMeasure> regions;
  context.on_threads([&] {
    regions = measure_regions(*work.labels, work.grey.get(), work.asked, context.watcher());
  });
  return result_of(work, std::move(regions), options, context);
}

std::size_t measure_volume_part(const MeasurePartOptions& options, const TaskContext& context) {
  require_free(options.output);
  require_no_input(options.output.path, {options.measure.labels, options.measure.grey});
  const Measurement work = opened_to_measure(options.measure, context);
  require_memory_to_measure(context);
  PartOfRegions regions;
  context.on_threads([&] {
    regions = measure_part(*work.labels, work.grey.get(), work.asked, options.part,
                           context.watcher());
  });
  std::vector<JsonObject> lines = lines_of_regions(regions);
  lines.insert(lines.begin(), question_of(work));
  write_part_result(options.output, kMeasureKind, options.part, lines);
  return regions.size();
}

MeasureResult join_measured(const JoinMeasuredOptions& options, const TaskContext& context) {
  const Measurement work = opened_to_measure(options.measure, context);
  warn_of_spacing(work, options.measure.labels, context);
  const std::string question = question_of(work).text();
  std::vector<WorkPart> parts;
  std::vector<PartOfRegions> found;
  for (const std::string& path : options.parts) {
    FoundPart file = read_part_result(path, kMeasureKind, context);
    if (file.lines.empty() || file.lines.front().text() != question) {
      throw Error(ErrorKind::invalid_argument,
                  "is part of another measurement: of other files, labels or percentiles", path);
    }
    file.lines.erase(file.lines.begin());
    parts.push_back(file.part);
    found.push_back(of_part_result(path, [&] { return regions_of_lines(file.lines); }));
  }
  PartOfRegions all;
  for (const std::size_t place : order_of_all_parts(parts)) add_part(found[place], all);
  return result_of(work, joined_regions(all, work.grey.get(), work.asked), options.measure,
                   context);
}

}  // namespace octavo
