// Two volumes side by side: in place and in every voxel, or label by label.
#pragma once

#include <string>
#include <vector>

#include "octavo/core/label_names.h"
#include "octavo/ops/label/label_overlaps.h"
#include "octavo/tasks/files/plane_compare.h"
#include "octavo/tasks/open_scan.h"

namespace octavo {

struct CompareOptions {
  std::string a;  ///< an .8vo file, a URL of one, or a scan
  std::string b;
  double max_error = 0;  ///< the largest difference, real units, that counts as equal
  bool voxels = false;   ///< read voxels even where the digests of two files are the same
  ScanOptions scan{};    ///< of those of the two that are scans
};

struct CompareResult {
  VolumeDescription a;
  VolumeDescription b;
  Comparison comparison;
};

/// Compares geometry and voxels. Two files whose digests are the same have the same voxels: none is
/// read, unless that is asked for.
/// Throws  as open_planes; Error{invalid_argument} for scan options where neither is a scan
/// Memory  two planes besides what the sources hold
CompareResult compare_volumes(const CompareOptions& options, const TaskContext& context);

struct CompareLabelsOptions {
  std::string a;
  std::string b;
};

struct CompareLabelsResult {
  bool is_equal = false;                   ///< in all voxels
  std::vector<LabelAgreement> agreements;  ///< one for each label of either
  LabelNames names_a;                      ///< what either calls its labels
  LabelNames names_b;
};

/// Counts the voxels of each label in two label maps and in both at once.
/// Throws what opening and reading throw; Error{invalid_argument} for grey volumes and other grids
CompareLabelsResult compare_labels(const CompareLabelsOptions& options, const TaskContext& context);

}  // namespace octavo
