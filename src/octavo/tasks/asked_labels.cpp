#include "octavo/tasks/asked_labels.h"

#include <algorithm>

#include "octavo/core/error.h"

namespace octavo {

std::vector<std::int64_t> labels_of(const AskedLabels& asked, const LabelNames& names,
                                    const std::string& path) {
  std::vector<std::int64_t> labels = asked.numbers;
  for (const std::string& name : asked.names) {
    const std::size_t before = labels.size();
    for (const auto& [label, entry] : names.all()) {
      if (entry.name == name) labels.push_back(label);
    }
    if (labels.size() > before) continue;
    throw Error(ErrorKind::invalid_argument, "no label has the name '" + escaped(name) + "'", path)
        .with_field("labels.names");
  }
  std::sort(labels.begin(), labels.end());
  labels.erase(std::unique(labels.begin(), labels.end()), labels.end());
  if (std::binary_search(labels.begin(), labels.end(), 0)) {
    throw Error(ErrorKind::invalid_argument, "label 0 is the background, which is no region", path)
        .with_field("labels.numbers");
  }
  return labels;
}

void require_no_missing(const std::vector<std::int64_t>& missing, int level,
                        const LabelNames& names, const std::string& path) {
  if (missing.empty()) return;
  std::string words;
  for (const std::int64_t label : missing) {
    words += (words.empty() ? "" : " or ") + label_words(names, label);
  }
  throw Error(ErrorKind::invalid_argument,
              "no voxel of level " + std::to_string(level) + " has " + words, path)
      .with_field("labels.numbers");
}

std::string label_words(const LabelNames& names, std::int64_t label) {
  const std::string& name = names.name_of(label);
  return "label " + std::to_string(label) + (name.empty() ? "" : " (" + escaped(name) + ")");
}

}  // namespace octavo
