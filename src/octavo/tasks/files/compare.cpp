#include "octavo/tasks/files/compare.h"

#include <algorithm>
#include <array>
#include <optional>

#include "octavo/core/error.h"
#include "octavo/tasks/files/decoding_memory.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/label_trees.h"
#include "octavo/tasks/masks.h"

namespace octavo {

namespace {

std::shared_ptr<const FileReader> open_label_map(const std::string& path,
                                                 const TaskContext& context) {
  std::shared_ptr<const FileReader> reader = open_volume(path, context);
  if (reader->description().kind == VolumeKind::labels) return reader;
  throw Error(ErrorKind::invalid_argument, "holds grey values, no labels to compare", path)
      .with_field("compare.labels");
}

// What the digests of two files tell, where they tell that all voxels are the same.
std::optional<CompareResult> compared_by_digest(const CompareOptions& options,
                                                const TaskContext& context) {
  if (options.voxels || !is_octavo_path(options.a) || !is_octavo_path(options.b)) return {};
  TaskContext any_size = context;
  any_size.max_voxels = 0;  // no voxel is read
  const auto a = open_volume(options.a, any_size);
  const auto b = open_volume(options.b, any_size);
  const std::optional<Comparison> comparison = compare_digests(*a, *b);
  if (!comparison) return {};
  return CompareResult{a->description(), b->description(), *comparison};
}

// What threads decode the bricks of those sources in that are .8vo files, one after the other.
std::uint64_t decoding_bytes_of_files(const CompareOptions& options,
                                      std::array<const PlaneSource*, 2> sources,
                                      const TaskContext& context) {
  std::uint64_t most = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    if (!is_octavo_path(i == 0 ? options.a : options.b)) continue;
    most = std::max(most, decoding_bytes(sources[i]->description(), context));
  }
  return most;
}

}  // namespace

CompareResult compare_volumes(const CompareOptions& options, const TaskContext& context) {
  if (!(options.max_error >= 0)) {
    throw Error(ErrorKind::invalid_argument, "the max error must not be negative")
        .with_field("max_error");
  }
  require_scan_for_options({options.a, options.b}, options.scan);
  if (const auto result = compared_by_digest(options, context)) return *result;
  const auto a = open_planes({options.a}, options.scan, context, OptionsOf::any_source);
  const auto b = open_planes({options.b}, options.scan, context, OptionsOf::any_source);
  const std::uint64_t decoding = decoding_bytes_of_files(options, {a.get(), b.get()}, context);
  return CompareResult{a->description(), b->description(),
                       compare_sources(*a, *b, options.max_error, decoding, context)};
}

CompareLabelsResult compare_labels(const CompareLabelsOptions& options,
                                   const TaskContext& context) {
  const auto a = open_label_map(options.a, context);
  const auto b = open_label_map(options.b, context);
  require_same_grid(a->description(), options.a, b->description(), options.b);
  const LabelTree tree_a = read_label_tree(*a, 0, {}, "first labels", context);
  const LabelTree tree_b = read_label_tree(*b, 0, {}, "second labels", context);
  CompareLabelsResult result;
  context.on_threads([&] { result.agreements = label_agreements(label_overlaps(tree_a, tree_b)); });
  result.is_equal = tree_a == tree_b;
  result.names_a = a->description().metadata.facts().labels;
  result.names_b = b->description().metadata.facts().labels;
  return result;
}

}  // namespace octavo
