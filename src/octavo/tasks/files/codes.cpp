#include "octavo/tasks/files/codes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <memory>

#include "octavo/core/error.h"
#include "octavo/core/metadata.h"
#include "octavo/dist/rank_codes.h"
#include "octavo/octree/condense.h"
#include "octavo/tasks/file_planes.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/label_trees.h"
#include "octavo/tasks/volume_parts.h"

namespace octavo {

namespace {

/// A code and a value.
constexpr std::uint64_t kLeafBytes = 16;

/// Which voxels belong to the object.
struct Selection {
  std::vector<std::int64_t> labels;  // sorted; empty: all but 0
  std::optional<ValueWindow> window;  // of stored values
  bool has_background = true;  // 0 gets no leaf

  bool makes_mask() const { return window.has_value(); }

  bool holds(double stored) const {
    if (window) return window->contains(stored);
    const auto label = static_cast<std::int64_t>(stored);
    return std::binary_search(labels.begin(), labels.end(), label);
  }
};

/// True for a volume whose cubes hold means.
bool is_condensed(const VolumeDescription& volume) {
  const std::optional<MadeBy>& made_by = volume.metadata.facts().made_by;
  return made_by && made_by->operation() == "condense";
}

Selection choose(const CodesOptions& options, const VolumeDescription& d) {
  Selection selection;
  selection.labels = labels_of(options.labels, d.metadata.facts().labels, options.input);
  if (options.range) selection.window = stored_window(*options.range, d, false);
  if (selection.makes_mask()) return selection;
  if (d.kind == VolumeKind::grey && selection.labels.empty()) {
    selection.has_background = false;
    if (is_condensed(d)) return selection;
    throw Error(ErrorKind::invalid_argument, "holds grey values, which do not condense",
                options.input)
        .with_field("codes.range");
  }
  if (!is_integer(d.type)) {
    throw Error(ErrorKind::invalid_argument, "holds float32 voxels, no labels", options.input)
        .with_field("labels.range");
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

/// The planes of the object: other voxels are background.
class ObjectPlanes {
 public:
  /// Throws Error{limit_exceeded} where the memory limit leaves no room for a layer of bricks.
  ObjectPlanes(PlaneSource& planes, const Selection& selection, const TaskContext& context)
      : planes_(planes), selection_(selection), context_(context) {
    const VolumeDescription& d = planes.description();
    const auto plane_voxels = static_cast<std::uint64_t>(d.size.x * d.size.y);
    context.require_memory(planes.resident_bytes() + plane_bytes(d) + plane_voxels,
                           "a layer of bricks");
    plane_.resize(static_cast<std::size_t>(plane_bytes(d)));
    mask_.resize(static_cast<std::size_t>(plane_voxels));
  }

  CondenseOptions options() const {
    CondenseOptions options;
    if (selection_.has_background) options.background = 0;
    return options;
  }

  /// Gives the next plane to a condenser. Throws Error{limit_exceeded} where its leaves take more
  /// than the memory limit.
  void add_next(PlaneCondenser& condenser) {
    const VoxelType type = planes_.description().type;
    planes_.read_plane(plane_);
    if (selection_.makes_mask()) {
      mark(selection_, type, plane_, mask_);
      condenser.add_plane(VoxelType::uint8, mask_);
    } else {
      apply(selection_, type, plane_);
      condenser.add_plane(type, plane_);
    }
    context_.require_memory(
        planes_.resident_bytes() + plane_.size() + mask_.size() + condenser.memory_bytes(),
        "the octree");
  }

 private:
  PlaneSource& planes_;
  const Selection& selection_;
  const TaskContext& context_;
  std::vector<std::byte> plane_;
  std::vector<std::byte> mask_;
};

LinearOctree voxel_leaves(PlaneSource& planes, const Selection& selection,
                          const TaskContext& context) {
  ObjectPlanes object(planes, selection, context);
  const Size3& size = planes.description().size;
  PlaneCondenser condenser(size, object.options());
  Progress& progress = context.watcher();
  const ProgressScope scope(progress, "condensing", size.z, "planes");
  for (std::int64_t z = 0; z < size.z; ++z) {
    if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped on request");
    object.add_next(condenser);
    progress.advance(1);
  }
  return condenser.finish();
}

LinearOctree label_leaves(const FileReader& reader, int level, const Selection& selection,
                          const TaskContext& context) {
  const LabelTree tree = read_label_tree(reader, level, selection.labels, "condensing", context);
  std::uint64_t leaves = 0;
  for (const std::int64_t count : leaf_counts(tree)) leaves += static_cast<std::uint64_t>(count);
  context.require_memory(tree.memory_bytes() + kLeafBytes * leaves, "the octree");
  return to_linear_octree(tree);
}

OCode asked_cube(const CodesOptions& options, int root_level) {
  const std::string& text = *options.neighbors_of;
  if (text == "-") return parse_hierarchical("", root_level);
  if (options.notation == CodeNotation::hierarchical) return parse_hierarchical(text, root_level);
  const OCode cube = parse_mixed_octal(text);
  if (text.size() == static_cast<std::size_t>(root_level)) return cube;
  throw Error(ErrorKind::invalid_argument,
              fmt::format("o-code {} has {} digits; the codes of this volume have {}",
                          escaped(text), text.size(), root_level));
}

bool is_label_map(const FileReader& reader, const Selection& selection) {
  return reader.description().kind == VolumeKind::labels && !selection.makes_mask();
}

/// What is asked for besides the octree.
void complete(CodesResult& result, const CodesOptions& options, const TaskContext& context) {
  if (options.neighbors_of) {
    const OCode cube = asked_cube(options, result.octree.root_level);
    result.surroundings = {cube, leaf_at(result.octree, cube), neighbors_in(result.octree, cube)};
  } else {
    const auto leaves = static_cast<std::uint64_t>(leaf_count(result.octree));
    context.require_memory((kLeafBytes + options.bytes_per_leaf) * leaves, "the list of leaves");
  }
}

}  // namespace

CodesResult codes(const CodesOptions& options, const TaskContext& context) {
  const std::shared_ptr<const FileReader> reader = open_volume(options.input, context);
  require_level(reader->levels(), options.level);
  const Selection selection = choose(options, reader->description());
  FilePlanes planes(reader, options.level, context.thread_count());
  const bool has_labels = is_label_map(*reader, selection);
  CodesResult result{planes.description(), {}, {}};
  if (!has_labels) result.volume.metadata.drop_labels();
  result.octree = has_labels ? label_leaves(*reader, options.level, selection, context)
                             : voxel_leaves(planes, selection, context);
  complete(result, options, context);
  return result;
}

CodesResult codes_by_ranks(const CodesOptions& options, Communicator& ranks, GatherPlan plan,
                           const TaskContext& context, RankReport* report) {
  const std::shared_ptr<const FileReader> reader = open_volume(options.input, context);
  require_level(reader->levels(), options.level);
  const Selection selection = choose(options, reader->description());
  FilePlanes planes(reader, options.level, context.thread_count());
  CodesResult result{planes.description(), {}, {}};
  if (!is_label_map(*reader, selection)) result.volume.metadata.drop_labels();
  ObjectPlanes object(planes, selection, context);
  const CondensedPlanes own = {
      planes.description().size,
      [&](std::int64_t first, std::int64_t end) { planes.seek(first, end); },
      [&](PlaneCondenser& condenser) { object.add_next(condenser); }};
  result.octree = condense_by_ranks(own, object.options().background, ranks, plan,
                                    context.watcher(), report);
  if (ranks.is_first()) complete(result, options, context);
  return result;
}

std::map<std::int64_t, std::vector<std::int64_t>> leaves_by_label(const LinearOctree& octree) {
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

std::uint64_t voxels_under(const std::vector<std::int64_t>& leaves_by_level) {
  std::uint64_t voxels = 0;
  for (std::size_t level = 0; level < leaves_by_level.size(); ++level) {
    voxels +=
        static_cast<std::uint64_t>(leaves_by_level[level]) * cube_volume(static_cast<int>(level));
  }
  return voxels;
}

std::string code_text(const OCode& cube, int root_level, CodeNotation notation) {
  const std::string code = notation == CodeNotation::mixed_octal
                               ? to_mixed_octal(cube, root_level)
                               : to_hierarchical(cube, root_level);
  return code.empty() ? "-" : code;
}

}  // namespace octavo
