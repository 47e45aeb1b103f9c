// octavo codes: the o-codes of what a file holds: label maps by their tree, other voxels condensed
// plane by plane.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/failure.h"
#include "common/inputs.h"
#include "common/label_trees.h"
#include "common/masks.h"
#include "common/options.h"
#include "common/progress_line.h"
#include "octavo/octree/condense.h"
#include "octavo/octree/neighbors.h"
#include "octavo/tasks/file_planes.h"
#include "text/made_by_words.h"
#include "text/quantities.h"
#include "text/volume_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kText = {
    "codes", "Show a mask or label map as the leaves of an octree: o-codes and counts.",
    "Background (0) gets no leaf. A grey file needs --range, which makes a mask of it, unless\n"
    "octavo condense made it: then every cube is a leaf, its value as it is stored. With\n"
    "--list every leaf is printed as CODE VALUE (mixed: in post-order) or LEVEL CODE VALUE\n"
    "(linear: level by level; the root has no digits and is shown as -). --neighbors says what\n"
    "one cube itself is, and prints what lies beside it in the 26 directions: the leaf of the\n"
    "same or a larger size, 'smaller' where there are only smaller leaves, 'background' or\n"
    "'outside'; - is the root in both notations.\n\n"
    "Examples:\n"
    "  octavo codes aal.8vo\n"
    "  octavo codes aal.8vo --label 37 --list --notation linear\n"
    "  octavo codes aal.8vo --neighbors 20465788\n"
    "  octavo codes head.8vo --range 300:3000"};

constexpr std::size_t kPrintBytes = std::size_t{1} << 16;

struct Arguments {
  std::string input;
  int level = 0;
  std::vector<std::int64_t> labels;
  std::string range;
  std::string notation = "mixed";
  std::string neighbors;
  bool list = false;
  bool counts = false;
};

/// Which voxels belong to the object.
struct Selection {
  std::vector<std::int64_t> labels;  // sorted; empty: all but 0
  std::optional<std::array<double, 2>> real_range;
  Rescale rescale;
  bool has_background = true;  // 0 gets no leaf

  bool makes_mask() const { return real_range.has_value(); }

  bool holds(double stored) const {
    if (real_range) {
      const double real = rescale.to_real(stored);
      return real >= (*real_range)[0] && real <= (*real_range)[1];
    }
    const auto label = static_cast<std::int64_t>(stored);
    return std::binary_search(labels.begin(), labels.end(), label);
  }
};

std::array<double, 2> parse_range(const std::string& text) {
  const std::vector<std::string> ends = split(text, ':');
  if (ends.size() != 2) {
    throw Error(ErrorKind::invalid_argument, "--range: '" + escaped(text) + "'; expected LO:HI");
  }
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const std::array<double, 2> range = {
      ends[0].empty() ? -kInfinity : parse_number(ends[0], "--range"),
      ends[1].empty() ? kInfinity : parse_number(ends[1], "--range")};
  if (range[0] > range[1]) {
    throw Error(ErrorKind::invalid_argument,
                "--range: '" + escaped(text) + "' is empty; expected LO <= HI");
  }
  return range;
}

Selection choose(const Arguments& arguments, const VolumeDescription& d) {
  Selection selection;
  selection.rescale = d.rescale;
  selection.labels = arguments.labels;
  std::sort(selection.labels.begin(), selection.labels.end());
  if (!arguments.range.empty()) selection.real_range = parse_range(arguments.range);
  if (std::binary_search(selection.labels.begin(), selection.labels.end(), 0)) {
    throw Error(ErrorKind::invalid_argument, "--label 0: 0 is the background and has no leaves");
  }
  const bool is_plain_grey = d.kind == VolumeKind::grey && arguments.range.empty();
  if (is_plain_grey && selection.labels.empty()) {
    selection.has_background = false;
    if (is_condensed(metadata_of(d))) return selection;
    throw Error(
        ErrorKind::invalid_argument,
        "holds grey values, which do not condense; give --range LO:HI (real units), or build it "
        "with --labels if its numbers are names, or make cubes of it with octavo condense",
        arguments.input);
  }
  if (!is_integer(d.type) && arguments.range.empty()) {
    throw Error(ErrorKind::invalid_argument, "holds float32 voxels, no labels; give --range LO:HI",
                arguments.input);
  }
  return selection;
}

/// Turns voxels outside the selection into background.
void apply(const Selection& selection, VoxelType type, std::span<std::byte> plane) {
  if (selection.labels.empty()) return;
  with_voxel_type(type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    for (std::size_t at = 0; at < plane.size(); at += sizeof(T)) {
      T voxel;
      std::memcpy(&voxel, plane.data() + at, sizeof(T));
      const T kept = selection.holds(static_cast<double>(voxel)) ? voxel : T{0};
      std::memcpy(plane.data() + at, &kept, sizeof(T));
    }
  });
}

/// A byte for each voxel: 1 inside the range, else 0.
void mark(const Selection& selection, VoxelType type, std::span<const std::byte> plane,
          std::span<std::byte> mask) {
  with_voxel_type(type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    for (std::size_t i = 0; i < mask.size(); ++i) {
      T voxel;
      std::memcpy(&voxel, plane.data() + i * sizeof(T), sizeof(T));
      mask[i] = std::byte{selection.holds(static_cast<double>(voxel))};
    }
  });
}

LinearOctree condense_planes(PlaneSource& planes, const Selection& selection, Progress& progress,
                             const Context& context) {
  const VolumeDescription& d = planes.description();
  CondenseOptions options;
  if (selection.has_background) options.background = 0;
  PlaneCondenser condenser(d.size, options);
  std::vector<std::byte> plane(
      static_cast<std::size_t>(d.size.x * d.size.y * bytes_per_voxel(d.type)));
  std::vector<std::byte> mask(static_cast<std::size_t>(d.size.x * d.size.y));
  progress.begin("condensing", d.size.z, "planes");
  for (std::int64_t z = 0; z < d.size.z; ++z) {
    if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped on request");
    planes.read_plane(plane);
    if (selection.makes_mask()) {
      mark(selection, d.type, plane, mask);
      condenser.add_plane(VoxelType::uint8, mask);
    } else {
      apply(selection, d.type, plane);
      condenser.add_plane(d.type, plane);
    }
    require_memory(planes.resident_bytes() + plane.size() + mask.size() + condenser.memory_bytes(),
                   "the octree", context);
    progress.advance(1);
  }
  progress.end();
  return condenser.finish();
}

LinearOctree voxel_leaves(PlaneSource& planes, const Selection& selection, const Context& context) {
  ProgressLine progress(context);
  return condense_planes(planes, selection, progress, context);
}

LinearOctree label_leaves(const FileReader& reader, const Arguments& arguments,
                          const Selection& selection, const Context& context) {
  const LabelTree tree =
      read_label_tree(reader, arguments.level, selection.labels, "condensing", context);
  std::uint64_t leaves = 0;
  for (const std::int64_t count : leaf_counts(tree)) leaves += static_cast<std::uint64_t>(count);
  constexpr std::uint64_t kLeafBytes = 16;
  require_memory(tree.memory_bytes() + kLeafBytes * leaves, "the octree", context);
  return to_linear_octree(tree);
}

/// Leaves of each label at each level.
std::map<std::int64_t, std::vector<std::int64_t>> counts_by_label(const LinearOctree& octree) {
  std::map<std::int64_t, std::vector<std::int64_t>> counts;
  for (std::size_t level = 0; level < octree.levels.size(); ++level) {
    for (const std::int64_t value : octree.levels[level].values) {
      auto& row = counts[value];
      row.resize(octree.levels.size());
      ++row[level];
    }
  }
  return counts;
}

std::uint64_t volume_of(const std::vector<std::int64_t>& leaves_by_level) {
  std::uint64_t voxels = 0;
  for (std::size_t level = 0; level < leaves_by_level.size(); ++level) {
    voxels +=
        static_cast<std::uint64_t>(leaves_by_level[level]) * cube_volume(static_cast<int>(level));
  }
  return voxels;
}

std::string summary_text(const LinearOctree& octree, const VolumeDescription& d,
                         const std::string& path) {
  std::string text =
      fmt::format("{}: {} voxels in a universe of side 2^{}\n\n  {:>5}  {:>8}  {:>13}  {:>16}\n",
                  path, size_text(d.size), octree.root_level, "level", "side", "leaves", "voxels");
  for (int level = 0; level <= octree.root_level; ++level) {
    const std::int64_t leaves = leaf_count(octree, level);
    if (leaves == 0) continue;
    const auto voxels =
        static_cast<std::int64_t>(static_cast<std::uint64_t>(leaves) * cube_volume(level));
    text += fmt::format("  {:>5}  {:>8}  {:>13}  {:>16}\n", level, cube_side(level),
                        count_text(leaves), count_text(voxels));
  }
  const std::int64_t leaves = leaf_count(octree);
  const auto voxels = static_cast<std::int64_t>(leaf_volume(octree));
  text += fmt::format("  {:>5}  {:>8}  {:>13}  {:>16}\n", "all", "", count_text(leaves),
                      count_text(voxels));
  if (leaves > 0) {
    text +=
        fmt::format("\n  {:.1f} % of the volume, {:.1f} voxels a leaf\n",
                    100 * static_cast<double>(voxels) / static_cast<double>(d.size.voxel_count()),
                    static_cast<double>(voxels) / static_cast<double>(leaves));
  }
  return text;
}

std::string counts_text(const LinearOctree& octree) {
  std::string text = fmt::format("  {:>10}  {:>13}  {:>16}  leaves of level 0, 1, ...\n", "label",
                                 "leaves", "voxels");
  for (const auto& [label, row] : counts_by_label(octree)) {
    std::int64_t leaves = 0;
    std::string levels;
    for (std::size_t level = 0; level < row.size(); ++level) {
      leaves += row[level];
      levels += (level == 0 ? "" : " ") + std::to_string(row[level]);
    }
    text += fmt::format("  {:>10}  {:>13}  {:>16}  {}\n", label, count_text(leaves),
                        count_text(static_cast<std::int64_t>(volume_of(row))), levels);
  }
  return text;
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

/// The cube that --neighbors names, in the notation of the list.
OCode asked_cube(const Arguments& arguments, const LinearOctree& octree) {
  const int n = octree.root_level;
  const std::string& text = arguments.neighbors;
  if (text == "-") return parse_hierarchical("", n);
  if (arguments.notation == "linear") return parse_hierarchical(text, n);
  const OCode cube = parse_mixed_octal(text);
  if (text.size() == static_cast<std::size_t>(n)) return cube;
  throw Error(ErrorKind::invalid_argument,
              fmt::format("--neighbors {}: has {} digits; the codes of this volume have {}", text,
                          text.size(), n));
}

std::string code_text(const OCode& cube, const LinearOctree& octree, const Arguments& arguments) {
  const std::string code = arguments.notation == "mixed" ? to_mixed_octal(cube, octree.root_level)
                                                         : to_hierarchical(cube, octree.root_level);
  return code.empty() ? "-" : code;
}

constexpr std::array<const char*, 4> kNeighborKinds = {"outside", "background", "smaller", "leaf"};

const char* kind_of(const Neighbor& found) {
  return kNeighborKinds[static_cast<std::size_t>(found.kind)];
}

/// What fills the cube itself.
std::string filling_text(const Neighbor& filling, const OCode& cube, const LinearOctree& octree,
                         const Arguments& arguments) {
  if (filling.kind == NeighborKind::background) return "background";
  if (filling.kind == NeighborKind::smaller) return "divided into smaller leaves";
  if (filling.leaf.cube == cube) return fmt::format("a leaf of value {}", filling.leaf.value);
  return fmt::format("part of the leaf {} of level {} and value {}",
                     code_text(filling.leaf.cube, octree, arguments), filling.leaf.cube.level,
                     filling.leaf.value);
}

nlohmann::ordered_json found_json(const Neighbor& found, const LinearOctree& octree,
                                  const Arguments& arguments) {
  nlohmann::ordered_json object = {{"kind", kind_of(found)}};
  if (found.kind != NeighborKind::leaf) return object;
  object["level"] = found.leaf.cube.level;
  object["code"] = code_text(found.leaf.cube, octree, arguments);
  object["value"] = found.leaf.value;
  return object;
}

void print_neighbors(const LinearOctree& octree, const Arguments& arguments,
                     const Context& context) {
  const OCode cube = asked_cube(arguments, octree);
  const std::array<Neighbor, 26> neighbors = neighbors_in(octree, cube);
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  const Neighbor filling = leaf_at(octree, cube);
  std::string text =
      fmt::format("{}: level {}, side {}; {}\n  {:>2} {:>2} {:>2}  {:<{}}  {:>5}  {}\n",
                  code_text(cube, octree, arguments), cube.level, cube_side(cube.level),
                  filling_text(filling, cube, octree, arguments), "x", "y", "z", "neighbor",
                  std::max(octree.root_level, 10), "level", "value");
  for (std::size_t i = 0; i < neighbors.size(); ++i) {
    const Direction& d = kDirections[i];
    const Neighbor& neighbor = neighbors[i];
    nlohmann::ordered_json row = {{"direction", {d.x, d.y, d.z}}};
    row.update(found_json(neighbor, octree, arguments));
    rows.push_back(row);
    text += fmt::format("  {:>2} {:>2} {:>2}  ", d.x, d.y, d.z);
    if (neighbor.kind != NeighborKind::leaf) {
      text += fmt::format("{}\n", kind_of(neighbor));
      continue;
    }
    const Leaf& leaf = neighbor.leaf;
    text += fmt::format("{:<{}}  {:>5}  {}\n", code_text(leaf.cube, octree, arguments),
                        std::max(octree.root_level, 10), leaf.cube.level, leaf.value);
  }
  if (context.json) {
    print_json({{"root_level", octree.root_level},
                {"notation", arguments.notation},
                {"code", code_text(cube, octree, arguments)},
                {"level", cube.level},
                {"cube", found_json(filling, octree, arguments)},
                {"neighbors", rows}});
  } else {
    print(text);
  }
}

nlohmann::ordered_json result_json(const LinearOctree& octree, const Arguments& arguments) {
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
  if (arguments.counts) {
    nlohmann::ordered_json labels = nlohmann::ordered_json::array();
    for (const auto& [label, row] : counts_by_label(octree)) {
      labels.push_back({{"label", label}, {"voxels", volume_of(row)}, {"leaves_by_level", row}});
    }
    object["labels"] = labels;
  }
  if (arguments.list) {
    nlohmann::ordered_json codes = nlohmann::ordered_json::array();
    for_each_leaf(
        octree, arguments.notation == "mixed", [&](const std::string& code, const Leaf& leaf) {
          codes.push_back({{"level", leaf.cube.level}, {"code", code}, {"value", leaf.value}});
        });
    object["notation"] = arguments.notation;
    object["codes"] = codes;
  }
  return object;
}

/// Throws Error{limit_exceeded} when the leaves and what is made of them to print a list are above
/// --max-memory.
void require_list_memory(const LinearOctree& octree, const Arguments& arguments,
                         const Context& context) {
  // Of a leaf: its code and value; in post-order as well; in JSON, as a tree and as text.
  constexpr std::uint64_t kLeafBytes = 16;
  constexpr std::uint64_t kOrderedBytes = 24;
  constexpr std::uint64_t kJsonBytes = 512;
  std::uint64_t bytes = kLeafBytes;
  if (arguments.list && arguments.notation == "mixed") bytes += kOrderedBytes;
  if (arguments.list && context.json) bytes += kJsonBytes;
  require_memory(bytes * static_cast<std::uint64_t>(leaf_count(octree)), "the list of leaves",
                 context);
}

int run_codes(const Arguments& arguments, const Context& context) {
  const std::shared_ptr<const FileReader> reader = open_octavo(arguments.input, context);
  check_level(reader->levels(), arguments.level);
  const Selection selection = choose(arguments, reader->description());
  FilePlanes planes(reader, arguments.level, context.thread_count());
  const bool is_label_map =
      reader->description().kind == VolumeKind::labels && !selection.makes_mask();
  const LinearOctree octree = is_label_map ? label_leaves(*reader, arguments, selection, context)
                                           : voxel_leaves(planes, selection, context);
  if (!arguments.neighbors.empty()) {
    print_neighbors(octree, arguments, context);
    return kExitDone;
  }
  require_list_memory(octree, arguments, context);
  if (context.json) {
    print_json(result_json(octree, arguments));
    return kExitDone;
  }
  if (arguments.list) print_list(octree, arguments.notation == "mixed");
  else if (arguments.counts) print(counts_text(octree));
  else print(summary_text(octree, planes.description(), arguments.input));
  return kExitDone;
}

}  // namespace

void add_codes(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<Arguments>();
  Verb verb = add_verb(app, context, kText,
                            [arguments, &context] { return run_codes(*arguments, context); });
  verb.add_option("file", arguments->input, "An .8vo file or a URL of one")
      ->type_name("FILE")
      ->required();
  Option label =
      verb.add_option("--label", arguments->labels, "Only this label (may be repeated)");
  label->type_name("N")->allow_extra_args(false);
  verb.add_option("--range", arguments->range, "A mask: real values from LO to HI, both included")
      ->type_name("LO:HI")
      ->excludes(label);
  verb.add_option("--level", arguments->level, "Level of detail whose samples are condensed")
      ->type_name("K")
      ->capture_default_str();
  Option list = verb.add_flag("--list", arguments->list, "Print every leaf");
  Option counts =
      verb.add_flag("--counts", arguments->counts, "Count leaves by label and level");
  verb.add_option("--neighbors", arguments->neighbors, "Print what lies beside this cube")
      ->type_name("CODE")
      ->excludes(list)
      ->excludes(counts);
  verb.add_option("--notation", arguments->notation, "Of codes: mixed (mixed-octal) or linear")
      ->type_name("NAME")
      ->check(one_of({"mixed", "linear"}))
      ->capture_default_str();
}

}  // namespace octavo::cli
