#include "common/label_trees.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/failure.h"
#include "common/inputs.h"
#include "common/masks.h"
#include "common/progress_line.h"
#include "octavo/ops/label/label_build.h"
#include "octavo/ops/label/label_overlaps.h"
#include "text/quantities.h"

namespace octavo::cli {

namespace {

std::shared_ptr<const FileReader> open_label_map(const std::string& path, const Context& context) {
  std::shared_ptr<const FileReader> reader = open_octavo(path, context);
  if (reader->description().kind == VolumeKind::labels) return reader;
  throw Error(ErrorKind::invalid_argument,
              "holds grey values; --labels compares label maps: leave it out, or make labels with "
              "octavo threshold",
              path);
}

std::string agreement_table(const std::vector<LabelAgreement>& agreements) {
  std::string text = fmt::format("{:>10} {:>16} {:>16} {:>16} {:>8}\n", "label", "voxels in A",
                                 "voxels in B", "in both", "Dice");
  const auto count = [](std::uint64_t voxels) {
    return count_text(static_cast<std::int64_t>(voxels));
  };
  for (const LabelAgreement& one : agreements) {
    text +=
        fmt::format("{:>10} {:>16} {:>16} {:>16} {:>8.4f}\n", one.label, count(one.first_voxels),
                    count(one.second_voxels), count(one.both_voxels), one.dice());
  }
  return text;
}

nlohmann::ordered_json agreements_json(const std::vector<LabelAgreement>& agreements) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const LabelAgreement& one : agreements) {
    rows.push_back({{"label", one.label},
                    {"a_voxels", one.first_voxels},
                    {"b_voxels", one.second_voxels},
                    {"both_voxels", one.both_voxels},
                    {"dice", one.dice()}});
  }
  return rows;
}

}  // namespace

LabelTree read_label_tree(const FileReader& reader, int level,
                          const std::vector<std::int64_t>& chosen, const char* what,
                          const Context& context) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::vector<ValueWindow> windows;
  for (const std::int64_t label : chosen) {
    windows.push_back({static_cast<double>(label), static_cast<double>(label)});
  }
  if (windows.empty()) windows.push_back({-kInfinity, kInfinity});
  LabelTree tree;
  ProgressLine progress(context);
  const ProgressScope scope(progress, what, reader.levels().size(level).z, "planes");
  on_threads(context, [&] {
    tree = labels_of_file(reader, level, windows, progress, context.max_memory_bytes);
  });
  return tree;
}

bool compare_labels(const std::string& a, const std::string& b, const Context& context) {
  const auto reader_a = open_label_map(a, context);
  const auto reader_b = open_label_map(b, context);
  require_same_grid(reader_a->description(), a, reader_b->description(), b);
  const LabelTree tree_a = read_label_tree(*reader_a, 0, {}, "first labels", context);
  const LabelTree tree_b = read_label_tree(*reader_b, 0, {}, "second labels", context);
  std::vector<LabelAgreement> agreements;
  on_threads(context, [&] { agreements = label_agreements(label_overlaps(tree_a, tree_b)); });
  const bool is_equal = tree_a == tree_b;
  if (context.json) {
    print_json({{"equal", is_equal}, {"labels", agreements_json(agreements)}});
    return is_equal;
  }
  const auto alike = std::count_if(agreements.begin(), agreements.end(),
                                   [](const LabelAgreement& one) { return one.dice() == 1; });
  std::string text =
      fmt::format("A = {}, B = {}: {} label{}, {} of them the same in both\n", escaped(a),
                  escaped(b), agreements.size(), agreements.size() == 1 ? "" : "s", alike);
  if (!agreements.empty()) text += agreement_table(agreements);
  if (!context.quiet || !is_equal) print(text);
  return is_equal;
}

}  // namespace octavo::cli
