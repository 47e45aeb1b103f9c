#include "octavo/tasks/label_trees.h"

#include <limits>

#include "octavo/ops/label/label_build.h"

namespace octavo {

LabelTree read_label_tree(const FileReader& reader, int level,
                          const std::vector<std::int64_t>& chosen, const char* work,
                          const TaskContext& context) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::vector<ValueWindow> windows;
  for (const std::int64_t label : chosen) {
    windows.push_back({static_cast<double>(label), static_cast<double>(label)});
  }
  if (windows.empty()) windows.push_back({-kInfinity, kInfinity});
  LabelTree tree;
  const ProgressScope scope(context.watcher(), work, reader.levels().size(level).z, "planes");
  context.on_threads([&] {
    tree = labels_of_file(reader, level, windows, context.watcher(), context.max_memory_bytes);
  });
  return tree;
}

}  // namespace octavo
