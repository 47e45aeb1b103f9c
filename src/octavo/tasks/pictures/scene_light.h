// The light that comes through a volume, out of a coarse level of its file.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "octavo/file/reader.h"
#include "octavo/render/rays/look_source.h"
#include "octavo/render/rays/ray_shade.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

/// What light has to come through.
struct SceneMatter {
  /// A cell of a side, with its value, its gradient in values per mm, and its look.
  struct Cell {
    double value = 0;
    double gradient = 0;
    double side_mm = 1;
    std::uint16_t look = 1;
  };
  /// Extinction per mm.
  std::function<double(const Cell& cell)> extinction;
  /// The looks of a level; none: all look alike.
  std::function<std::unique_ptr<LookSource>(int level)> looks;
  bool has_gradient = false;   ///< otherwise gradients are 0
  bool is_nan_empty = false;   ///< otherwise NaN is the lowest value stored
  Box kept;                    ///< voxels of level 0; what lies around them lets all light through
  std::vector<Box> removed;    ///< and what lies in these
};

/// The coarsest level from `level` on that has at most 2^20 samples looks at itself.
/// Throws  what the reader throws, Error{cancelled}, Error{limit_exceeded}
/// Memory  20 bytes per sample of that level
std::unique_ptr<RayShade> scene_light(const FileReader& reader, int level,
                                      const SceneMatter& matter, const TaskContext& context);

/// A box of voxels of level 0 in samples of another one.
Box box_at_level(const Box& box, const Levels& levels, int level);

}  // namespace octavo
