// What `align` lays onto a mask: a mask, a mesh, points or lines of sight, out of a file.
//
// | ending | what is in it |
// |---|---|
// | .8vo | a label map; every voxel but 0 is in the mask |
// | .stl, .ply, .obj | a mesh; of a PLY without triangles its points |
// | .csv, .txt, .xyz | rows of three numbers: points; of six: lines of sight, each through two |
//
// Rows hold mm, LPS, separated by commas, semicolons or white space; # begins a comment, and a
// first row of words is passed over.
#pragma once

#include <string>
#include <vector>

#include "octavo/ops/align/sight_lines.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

/// Either points or lines.
struct MovingFeatures {
  std::vector<Point3> points;
  std::vector<SightLine> lines;
  double spacing_mm = 0;  ///< from one point to the next
};

/// Whether a path names a mask rather than one of the other files.
bool is_moving_mask(const std::string& path);

/// At most `count` points or lines of a file that is no mask, any first part of them spread over
/// all.
/// Throws  Error{invalid_argument} for an ending that is none of these, too few points or lines,
///         and lines that run nearly alike; Error{source_rejected} for rows that are none;
///         Error{limit_exceeded}; what read_mesh throws
MovingFeatures read_features(const std::string& path, std::int64_t count,
                             const TaskContext& context);

}  // namespace octavo
