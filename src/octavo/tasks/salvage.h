// Reading around damage: bricks that are damaged are filled, and said to be.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "octavo/file/repair/salvage.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

/// What damaged bricks are filled with: their lowest value, unless another way is said.
struct SalvageFilling {
  bool is_from_coarser = false;      ///< from the next level that is whole
  std::optional<double> real_value;  ///< this one, in real units
};

/// `reader` itself, or with `filling` a SalvageReader over it. Where warnings are errors damage
/// stays one: what would come with a warning must not be written.
/// Throws Error{invalid_argument} when the value is no voxel of the file.
std::shared_ptr<const FileReader> salvaging(std::shared_ptr<const FileReader> reader,
                                            const std::optional<SalvageFilling>& filling,
                                            const TaskContext& context);

/// Runs `read`, which reads voxels of an opened file. Error{corrupt} is about the field "salvage"
/// where nothing was filled, or "is_strict" where that forbids it.
void read_salvaging(const std::optional<SalvageFilling>& filling, const TaskContext& context,
                    const std::function<void()>& read);

/// What was filled; nothing for a reader that fills nothing.
std::optional<SalvageReport> salvage_report(const FileReader& reader);

/// One warning for each damaged place that was filled, for ten at most, and a count of the others.
void warn_of_salvaged(const FileReader& reader, const TaskContext& context);

}  // namespace octavo
