// Components of a mask that is too large for one machine: each part finds those of its planes, a
// join says what is connected across them and gives all their numbers, and each part then knows the
// labels of its voxels.
#pragma once

#include <string>
#include <vector>

#include "octavo/core/work_part.h"
#include "octavo/tasks/build_planes.h"
#include "octavo/tasks/components.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

struct ComponentsPartOptions {
  std::string input;  ///< as ComponentsOptions
  Connectivity connectivity = Connectivity::faces;
  WorkPart part;
  Output output;  ///< what the part found
};

/// Finds the components of the planes of one part, and writes what a join needs of them. Returns
/// how many there are.
/// Throws  as open_labels, mask_of_file, Components and write_part_result
/// Memory  that of the mask of the part, of its Components, and of the file, twice
std::size_t components_of_part(const ComponentsPartOptions& options, const TaskContext& context);

struct JoinComponentsOptions {
  /// Those of the parts, and what is kept. The output is the file of numbers that
  /// label_components reads.
  ComponentsOptions components;
  std::vector<std::string> parts;  ///< what components_of_part wrote
};

/// The table that `components` gives, to every digit, of the parts of one mask.
/// Throws  as components and read_part_result; Error{invalid_argument} for parts that are missing,
///         there twice, of another mask or connectivity, and for an output that ends in .8vo
/// Memory  about 500 bytes for each component of a part, and three times the largest part file
ComponentsResult join_components(const JoinComponentsOptions& options, const TaskContext& context);

struct LabelComponentsOptions {
  std::string input;    ///< the mask
  std::string numbers;  ///< what join_components wrote
  Output output;        ///< the label map
};

struct LabeledComponents {
  std::size_t found = 0;
  std::size_t kept = 0;
  std::uint64_t file_bytes = 0;
};

/// The planes of the label map that `components` writes with the options of the join. The mask is
/// read part by part, as it was when the components were found.
/// Throws  as open_labels and read_part_result; Error{invalid_argument} for numbers of another mask
/// Memory  four bytes for each component of a part, four planes; the mask and the Components of one
///         part, which end with Error{limit_exceeded} above what the build leaves of the limit
ComputedVolume labeled_planes(const LabelComponentsOptions& options, const TaskContext& context);

/// Writes that label map.
/// Throws  as labeled_planes, require_computed and build_file
LabeledComponents label_components(const LabelComponentsOptions& options,
                                   const TaskContext& context);

}  // namespace octavo
