// Finds what is brighter than a value in a scan, and measures its connected parts:
// threshold, components, measure. Three tasks, each from file to file, as `octavo` does them.
//
// usage: measure_mask SCAN.8vo VALUE MASK.8vo LABELS.8vo
#include <cstdlib>
#include <iostream>
#include <limits>
#include <string>

#include "octavo/core/error.h"
#include "octavo/tasks/components.h"
#include "octavo/tasks/measure.h"
#include "octavo/tasks/threshold.h"

namespace {

void measure_parts(const std::string& scan, double value, const std::string& mask,
                   const std::string& labels) {
  octavo::TaskContext context;
  context.on_warning = [](const octavo::Warning& warning) {
    std::cerr << "warning: " << warning.text << "\n";
  };

  octavo::ThresholdOptions brighter;
  brighter.input = scan;
  brighter.output = {mask, true};
  brighter.ranges = {{value, std::numeric_limits<double>::infinity()}};
  octavo::threshold(brighter, context);

  octavo::ComponentsOptions parts;
  parts.input = mask;
  parts.output = octavo::Output{labels, true};
  parts.keep_largest = 10;
  const octavo::ComponentsResult found = octavo::components(parts, context);
  std::cout << found.found << " parts, " << found.kept << " kept\n";

  octavo::MeasureOptions measured;
  measured.labels = labels;
  measured.grey = scan;
  for (const octavo::MeasuredRegion& one : octavo::measure(measured, context).regions) {
    std::cout << "label " << one.region.label << ": " << one.region.voxel_count << " voxels";
    if (one.in_mm) std::cout << ", " << one.in_mm->mm3 << " mm3";
    std::cout << "\n";
  }
}

}  // namespace

int main(int count, char** words) {
  if (count != 5) {
    std::cerr << "usage: measure_mask SCAN.8vo VALUE MASK.8vo LABELS.8vo\n";
    return 2;
  }
  try {
    measure_parts(words[1], std::atof(words[2]), words[3], words[4]);
    return 0;
  } catch (const octavo::Error& error) {
    std::cerr << "measure_mask: " << error.what() << "\n";
    return 1;
  }
}
