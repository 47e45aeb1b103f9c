// Volumes that a verb computes, as planes: what a build in parts makes of .8vo files.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "octavo/tasks/combine.h"
#include "octavo/tasks/components/components_in_parts.h"
#include "octavo/tasks/files/condense_volume.h"
#include "octavo/tasks/threshold.h"
#include "octavo/tasks/transform.h"

namespace octavo {

/// Outputs are not looked at.
using ComputedWork =
    std::variant<ThresholdOptions, CondenseVolumeOptions, TransformOptions, CombineOptions,
                 LabelComponentsOptions>;

/// Understands the words of a work, as whoever has planned it gave them.
using WorkParser = std::function<ComputedWork(const std::vector<std::string>& words)>;

/// Opens the planes that the task of the work would write.
/// Throws  as the tasks do before they write
ComputedVolume open_computed(const ComputedWork& work, const TaskContext& context);

/// The files that the work reads, in a fixed order.
std::vector<std::string> inputs_of(const ComputedWork& work);

/// The same work on other files, as many as inputs_of returns.
/// Throws Error{invalid_argument} for another number
ComputedWork with_inputs(ComputedWork work, const std::vector<std::string>& inputs);

}  // namespace octavo
