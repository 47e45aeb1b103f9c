// Label maps out of .8vo files as octrees.
#pragma once

#include <cstdint>
#include <vector>

#include "octavo/file/reader.h"
#include "octavo/octree/label_tree.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

/// The labels of a level with progress, on the threads of `context`.
/// chosen  labels that are kept, the others count as 0; empty: all of them
/// work    names the progress
/// Throws as labels_of_file
LabelTree read_label_tree(const FileReader& reader, int level,
                          const std::vector<std::int64_t>& chosen, const char* work,
                          const TaskContext& context);

}  // namespace octavo
