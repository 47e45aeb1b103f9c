// Label maps out of .8vo files, and how alike two of them are.
#pragma once

#include <string>
#include <vector>

#include "common/context.h"
#include "octavo/file/reader.h"
#include "octavo/octree/label_tree.h"

namespace octavo::cli {

/// The labels of a level with progress, on the threads of `context`.
/// chosen  labels that are kept, the others count as 0; empty: all of them
/// what    the work, for people
/// Throws as labels_of_file
LabelTree read_label_tree(const FileReader& reader, int level,
                          const std::vector<std::int64_t>& chosen, const char* what,
                          const Context& context);

/// Prints the voxels of each label in two label maps and in both at once. Gives whether the maps
/// are equal in all voxels.
/// Throws what opening and reading throw; Error{invalid_argument} for grey volumes and other grids
bool compare_labels(const std::string& a, const std::string& b, const Context& context);

}  // namespace octavo::cli
