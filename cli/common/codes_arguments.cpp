#include "common/codes_arguments.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>

#include "common/volume_options.h"
#include "octavo/core/url_text.h"
#include "text/label_words.h"
#include "text/quantities.h"
#include "text/table.h"
#include "text/value_range_words.h"

namespace octavo::cli {

namespace {

constexpr std::size_t kPrintBytes = std::size_t{1} << 16;

std::string summary_text(const LinearOctree& octree, const VolumeDescription& d,
                         const std::string& path) {
  TextTable table({{"level", 7}, {"side", 9}, {"leaves", 14}, {"voxels", 17}});
  for (int level = 0; level <= octree.root_level; ++level) {
    const std::int64_t leaves = leaf_count(octree, level);
    if (leaves == 0) continue;
    table.add({std::to_string(level), std::to_string(cube_side(level)), count_text(leaves),
               count_of(static_cast<std::uint64_t>(leaves) * cube_volume(level))});
  }
  const std::int64_t leaves = leaf_count(octree);
  const auto voxels = static_cast<std::int64_t>(leaf_volume(octree));
  table.add({"all", "", count_text(leaves), count_text(voxels)});
  const std::string text = fmt::format("{}: {} voxels in a universe of side 2^{}\n\n{}",
                                       shown_path(path), size_text(d.size), octree.root_level,
                                       table.text());
  if (leaves == 0) return text;
  return text +
         fmt::format("\n  {:.1f} % of the volume, {:.1f} voxels a leaf\n",
                     100 * static_cast<double>(voxels) / static_cast<double>(d.size.voxel_count()),
                     static_cast<double>(voxels) / static_cast<double>(leaves));
}

std::string counts_text(const LinearOctree& octree, const LabelNames& names) {
  TextTable table({{"label", 12},
                   name_column(),
                   {"leaves", 14},
                   {"voxels", 17},
                   {"leaves of level 0, 1, ...", 1, Align::left}});
  for (const auto& [label, row] : leaves_by_label(octree)) {
    table.add({std::to_string(label), names.name_of(label),
               count_text(std::accumulate(row.begin(), row.end(), std::int64_t{0})),
               count_text(static_cast<std::int64_t>(voxels_under(row))),
               fmt::format("{}", fmt::join(row, " "))});
  }
  return table.text();
}

bool is_mixed(const CodesArguments& arguments) {
  return arguments.options.notation == CodeNotation::mixed_octal;
}

/// Calls `take(code text, leaf)` for every leaf in the order of the notation.
template <class F>
void for_each_leaf(const LinearOctree& octree, bool is_mixed, const F& take) {
  if (is_mixed) {
    for (const Leaf& leaf : leaves_in_post_order(octree)) {
      take(to_mixed_octal(leaf.cube, octree.root_level), leaf);
    }
    return;
  }
  for (int level = 0; level <= octree.root_level; ++level) {
    const LinearOctree::Level& list = octree.levels[static_cast<std::size_t>(level)];
    for (std::size_t i = 0; i < list.codes.size(); ++i) {
      const Leaf leaf = {{level, list.codes[i]}, list.values[i]};
      take(to_hierarchical(leaf.cube, octree.root_level), leaf);
    }
  }
}

void print_list(const LinearOctree& octree, bool is_mixed) {
  std::string text;
  for_each_leaf(octree, is_mixed, [&](const std::string& code, const Leaf& leaf) {
    const std::string shown = code.empty() ? "-" : code;
    if (is_mixed) text += fmt::format("{} {}\n", shown, leaf.value);
    else text += fmt::format("{} {} {}\n", leaf.cube.level, shown, leaf.value);
    if (text.size() < kPrintBytes) return;
    print(text);
    text.clear();
  });
  print(text);
}

constexpr std::array<const char*, 4> kNeighborKinds = {"outside", "background", "smaller", "leaf"};

const char* kind_of(const Neighbor& found) {
  return kNeighborKinds[static_cast<std::size_t>(found.kind)];
}

/// What is said of one cube: in codes of the notation that was asked for.
struct CubeWords {
  int root_level;
  CodeNotation notation;
  const LabelNames& names;

  /// A value and its name.
  std::string value(std::int64_t value) const {
    return std::to_string(value) + name_suffix(names, value);
  }

  std::string code(const OCode& cube) const { return code_text(cube, root_level, notation); }

  /// What fills the cube itself.
  std::string filling(const Neighbor& filling, const OCode& cube) const {
    if (filling.kind == NeighborKind::background) return "background";
    if (filling.kind == NeighborKind::smaller) return "divided into smaller leaves";
    if (filling.leaf.cube == cube) return "a leaf of value " + value(filling.leaf.value);
    return fmt::format("part of the leaf {} of level {} and value {}", code(filling.leaf.cube),
                       filling.leaf.cube.level, value(filling.leaf.value));
  }

  nlohmann::ordered_json found(const Neighbor& found) const {
    nlohmann::ordered_json object = {{"kind", kind_of(found)}};
    if (found.kind != NeighborKind::leaf) return object;
    object["level"] = found.leaf.cube.level;
    object["code"] = code(found.leaf.cube);
    object["value"] = found.leaf.value;
    if (const std::string& name = names.name_of(found.leaf.value); !name.empty()) {
      object["name"] = name;
    }
    return object;
  }
};

std::string neighbors_text(const CubeSurroundings& around, const CubeWords& words) {
  const int width = std::max(words.root_level, 10);
  std::string text =
      fmt::format("{}: level {}, side {}; {}\n  {:>2} {:>2} {:>2}  {:<{}}  {:>5}  {}\n",
                  words.code(around.cube), around.cube.level, cube_side(around.cube.level),
                  words.filling(around.filling, around.cube), "x", "y", "z", "neighbor", width,
                  "level", "value");
  for (std::size_t i = 0; i < around.neighbors.size(); ++i) {
    const Direction& d = kDirections[i];
    const Neighbor& neighbor = around.neighbors[i];
    text += fmt::format("  {:>2} {:>2} {:>2}  ", d.x, d.y, d.z);
    if (neighbor.kind != NeighborKind::leaf) {
      text += fmt::format("{}\n", kind_of(neighbor));
      continue;
    }
    const Leaf& leaf = neighbor.leaf;
    text += fmt::format("{:<{}}  {:>5}  {}\n", words.code(leaf.cube), width, leaf.cube.level,
                        words.value(leaf.value));
  }
  return text;
}

nlohmann::ordered_json neighbors_json(const CubeSurroundings& around, const CubeWords& words,
                                      const CodesArguments& arguments) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < around.neighbors.size(); ++i) {
    const Direction& d = kDirections[i];
    nlohmann::ordered_json row = {{"direction", {d.x, d.y, d.z}}};
    row.update(words.found(around.neighbors[i]));
    rows.push_back(row);
  }
  return {{"root_level", words.root_level},      {"notation", word_of(arguments.options.notation)},
          {"code", words.code(around.cube)},     {"level", around.cube.level},
          {"cube", words.found(around.filling)}, {"neighbors", rows}};
}

nlohmann::ordered_json result_json(const LinearOctree& octree, const LabelNames& names,
                                   const CodesArguments& arguments) {
  nlohmann::ordered_json levels = nlohmann::ordered_json::array();
  for (int level = 0; level <= octree.root_level; ++level) {
    const auto leaves = static_cast<std::uint64_t>(leaf_count(octree, level));
    levels.push_back({{"level", level},
                      {"side", cube_side(level)},
                      {"leaves", leaves},
                      {"voxels", leaves * cube_volume(level)}});
  }
  nlohmann::ordered_json object = {{"root_level", octree.root_level},
                                   {"leaves", leaf_count(octree)},
                                   {"voxels", leaf_volume(octree)},
                                   {"levels", levels}};
  if (arguments.is_counts) {
    nlohmann::ordered_json labels = nlohmann::ordered_json::array();
    for (const auto& [label, row] : leaves_by_label(octree)) {
      labels.push_back({{"label", label},
                        {"name", name_json(names, label)},
                        {"voxels", voxels_under(row)},
                        {"leaves_by_level", row}});
    }
    object["labels"] = labels;
  }
  if (arguments.is_list) {
    nlohmann::ordered_json codes = nlohmann::ordered_json::array();
    for_each_leaf(octree, is_mixed(arguments), [&](const std::string& code, const Leaf& leaf) {
      codes.push_back({{"level", leaf.cube.level}, {"code", code}, {"value", leaf.value}});
    });
    object["notation"] = word_of(arguments.options.notation);
    object["codes"] = codes;
  }
  return object;
}

/// What printing takes for each leaf: in post-order; in JSON, as a tree and as text.
std::uint64_t printed_bytes_per_leaf(const CodesArguments& arguments, const Context& context) {
  constexpr std::uint64_t kOrderedBytes = 24;
  constexpr std::uint64_t kJsonBytes = 512;
  if (!arguments.is_list) return 0;
  return (is_mixed(arguments) ? kOrderedBytes : 0) + (context.json ? kJsonBytes : 0);
}

}  // namespace

void add_codes_options(Verb verb, CodesArguments& arguments) {
  CodesOptions& options = arguments.options;
  verb.add_input(options.input);
  const Option label = add_label_option(verb, options.labels, "Only this label");
  verb.add_parsed("--range LO:HI", options.range, parse_range,
                  "A mask: real values from LO to HI, both included")
      .excludes(label);
  add_level(verb, options.level, "Level of detail whose samples are condensed");
  Option list = verb.add_flag("--list", arguments.is_list, "Print every leaf");
  Option counts = verb.add_flag("--counts", arguments.is_counts, "Count leaves by label and level");
  verb.add_option("--neighbors CODE", options.neighbors_of, "Print what lies beside this cube")
      .excludes(list)
      .excludes(counts);
  verb.add_word("--notation NAME", options.notation,
                "Of codes: mixed (mixed-octal) or linear");
}

CodesOptions codes_options(const CodesArguments& arguments, const Context& context) {
  if (arguments.is_list && arguments.is_counts && !context.json) {
    throw Error(ErrorKind::invalid_argument, "--list goes with --counts under --json alone");
  }
  CodesOptions options = arguments.options;
  options.bytes_per_leaf = printed_bytes_per_leaf(arguments, context);
  return options;
}

void print_codes(const CodesResult& result, const CodesArguments& arguments,
                 const Context& context) {
  const LinearOctree& octree = result.octree;
  const LabelNames& names = result.volume.metadata.facts().labels;
  if (result.surroundings) {
    const CubeWords words = {octree.root_level, arguments.options.notation, names};
    if (context.json) print_json(neighbors_json(*result.surroundings, words, arguments));
    else print(neighbors_text(*result.surroundings, words));
  } else if (context.json) {
    print_json(result_json(octree, names, arguments));
  } else if (arguments.is_list) {
    print_list(octree, is_mixed(arguments));
  } else if (arguments.is_counts) {
    print(counts_text(octree, names));
  } else {
    print(summary_text(octree, result.volume, arguments.options.input));
  }
}

}  // namespace octavo::cli
