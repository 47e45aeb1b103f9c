#include "label_maps.h"

#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "asked.h"
#include "facts.h"
#include "octavo/core/error.h"
#include "octavo/ops/label/label_build.h"
#include "octavo/ops/label/label_masks.h"
#include "octavo/ops/label/label_overlaps.h"
#include "octavo/tasks/combine.h"
#include "octavo/tasks/components.h"
#include "octavo/tasks/fill_holes.h"
#include "octavo/tasks/label_trees.h"
#include "octavo/tasks/morph.h"
#include "octavo/tasks/structure/region_rows.h"
#include "octavo/tasks/threshold.h"
#include "octavo/threads/parallel_for.h"
#include "work.h"

namespace octavo::python {

namespace nb = nanobind;
using namespace nb::literals;

namespace {

using LabelVoxels = nb::ndarray<nb::c_contig, nb::device::cpu>;
using Label = std::int64_t;

std::vector<Label> labels_but_0(const LabelTree& tree) {
  std::vector<Label> labels(tree.labels().begin(), tree.labels().end());
  std::erase(labels, 0);
  return labels;
}

ComputedMask mask_of_labels_in(const LabelMap& map, const std::vector<Label>& labels,
                               const TaskContext& context) {
  MadeBy made("threshold");
  ComputedMask mask{MaskTree(), label_description(map.volume(), VoxelType::uint8,
                                                  made.set("labels", labels))};
  context.on_threads([&] {
    if (map.labels() != nullptr) {
      mask.tree = mask_of(*map.labels(), labels);
    } else if (std::find(labels.begin(), labels.end(), 1) != labels.end()) {
      mask.tree = *map.tree();
    } else {
      mask.tree = MaskTree(map.volume().size);
    }
  });
  return mask;
}

LabelMap threshold_map(const OpenFile& file, const std::string& name,
                       const std::vector<std::pair<double, double>>& ranges,
                       const std::vector<std::string>& tissues, bool is_stored,
                       const nb::dict& given) {
  ThresholdOptions options{.input = name, .tissues = tissues, .is_stored = is_stored};
  for (const auto& [low, high] : ranges) options.ranges.push_back({low, high});
  Work work(given);
  return work.run({{name, &file}}, [&] {
    return LabelMap(threshold_mask(file.reader(), options, work.context()));
  });
}

/// The labels of a file, all of them or those asked for by number or name.
LabelMap label_map_of(const OpenFile& file, const std::string& name,
                      const std::vector<Label>& numbers, const std::vector<std::string>& names,
                      const nb::dict& given) {
  Work work(given);
  return work.run({{name, &file}}, [&] {
    const FileReader& reader = file.reader();
    VolumeDescription volume = reader.description();
    if (volume.kind != VolumeKind::labels) {
      throw Error(ErrorKind::invalid_argument, "holds grey values, not labels", name)
          .with_field("labels.kind");
    }
    const std::vector<Label> chosen =
        labels_of({numbers, names}, volume.metadata.facts().labels, name);
    volume.metadata = volume.metadata.for_copy(0, false);
    return LabelMap(read_label_tree(reader, 0, chosen, "labels", work.context()),
                    std::move(volume));
  });
}

/// What `save_map` wrote, as the map that it was.
LabelMap saved_map(const OpenFile& file, const std::string& name, bool is_mask,
                   const nb::dict& given) {
  LabelMap made = label_map_of(file, name, {}, {}, given);
  if (!is_mask) return made;
  Work work(given);
  return work.run([&] {
    return LabelMap(ComputedMask{made.mask(work.context())->tree, made.volume()});
  });
}

LabelMap labels_selected(const LabelMap& map, const std::vector<Label>& labels,
                         const nb::dict& given) {
  Work work(given);
  return work.run([&] { return LabelMap(mask_of_labels_in(map, labels, work.context())); });
}

LabelMap combine_maps(const LabelMap& a, const LabelMap* b, const std::string& name,
                      const nb::dict& given) {
  const auto combination = value_of_given<Combination>(nb::cast(name), "operation");
  Work work(given);
  return work.run([&] {
    const TaskContext& context = work.context();
    if (b != nullptr) {
      require_same_grid(a.volume(), "the first mask", b->volume(), "the second mask", "grid");
    }
    const auto first = a.mask(context);
    const auto second = b == nullptr ? nullptr : b->mask(context);
    return LabelMap(combined_mask(*first, second.get(), combination, context));
  });
}

LabelMap filled_map(const LabelMap& map, int connectivity, std::optional<double> max_mm3,
                    const nb::dict& given) {
  FillHolesOptions options{.input = "the mask", .output = {}};
  options.connectivity = static_cast<Connectivity>(connectivity);
  options.max_mm3 = max_mm3;
  Work work(given);
  return work.run([&] {
    const auto mask = map.mask(work.context());
    FilledMask made = filled_mask(mask->tree, mask->volume, options, work.context());
    return LabelMap(ComputedMask{
        std::move(made.filled.mask),
        label_description(mask->volume, VoxelType::uint8, made.made_by)});
  });
}

LabelMap morphed_map(const LabelMap& map, const std::string& name, std::optional<double> mm,
                     std::int64_t steps, int connectivity, const nb::dict& given) {
  MorphOptions options{.input = "the mask", .output = {}};
  options.morphology = value_of_given<Morphology>(nb::cast(name), "operation");
  options.mm = mm;
  options.steps = steps;
  options.connectivity = static_cast<Connectivity>(connectivity);
  Work work(given);
  return work.run([&] {
    const auto mask = map.mask(work.context());
    MaskTree made = morphed_mask(mask->tree, mask->volume, options, work.context());
    return LabelMap(ComputedMask{
        std::move(made),
        label_description(mask->volume, VoxelType::uint8, made_by_morph(options))});
  });
}

/// (label map, rows of its labels, components that were found)
nb::tuple components_of(const LabelMap& map, int connectivity, std::int64_t keep_largest,
                        double min_mm3, const nb::dict& given) {
  ComponentsOptions options{.input = "the mask"};
  options.connectivity = static_cast<Connectivity>(connectivity);
  options.keep_largest = keep_largest;
  options.min_mm3 = min_mm3;
  options.bytes_per_row = 1024;
  Work work(given);
  LabeledMask made = work.run([&] {
    const auto mask = map.mask(work.context());
    return labeled_components(mask->tree, mask->volume, options, work.context());
  });
  const nb::list rows = list_of(made.table.rows, [](const ComponentRow& row) {
    return dict_of(columns_of(region_row(row)));
  });
  return nb::make_tuple(LabelMap(std::move(made.labels), std::move(made.volume)), rows,
                        made.table.found);
}

/// Voxels of each label but 0.
nb::dict counts_of(const LabelMap& map) {
  nb::dict counts;
  if (map.tree() != nullptr) {
    if (!map.tree()->is_empty()) counts[nb::int_(1)] = map.tree()->voxel_count();
    return counts;
  }
  const std::vector<std::uint64_t> voxels = voxel_counts(*map.labels());
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    const Label label = map.labels()->labels()[i];
    if (label != 0 && voxels[i] != 0) counts[nb::int_(label)] = voxels[i];
  }
  return counts;
}

template <class T>
void fill_box(const LabelMap& map, const Box& box, T* out) {
  if (map.tree() != nullptr) fill_voxels(*map.tree(), box, out);
  else fill_voxels(*map.labels(), box, out);
}

void fill_map(const LabelMap& map, const Zyx& start, const Zyx& stop, const LabelVoxels& out,
              const nb::dict& given) {
  const Box box{index_of(start), index_of(stop)};
  const VoxelType type = map.volume().type;
  const auto voxel_bytes = static_cast<std::int64_t>(bytes_per_voxel(type));
  if (box.is_empty() || intersection(box, box_of(map.volume().size)) != box ||
      static_cast<std::int64_t>(out.nbytes()) != voxel_bytes * box.size().voxel_count()) {
    throw Error(ErrorKind::invalid_argument, "out does not hold what the box has");
  }
  void* const voxels = out.data();
  Work work(given);
  work.run([&] {
    work.context().on_threads([&] {
      constexpr std::int64_t kPlanes = 16;
      const std::int64_t shares = (box.size().z + kPlanes - 1) / kPlanes;
      parallel_for(std::int64_t{0}, shares, [&](std::int64_t share) {
        Box part = box;
        part.lo.z += share * kPlanes;
        part.hi.z = std::min(part.lo.z + kPlanes, box.hi.z);
        with_voxel_type(type, [&](auto id) {
          using T = typename decltype(id)::type;
          if constexpr (std::is_integral_v<T>) {
            T* const first = static_cast<T*>(voxels) +
                             (part.lo.z - box.lo.z) * box.size().y * box.size().x;
            fill_box(map, part, first);
          }
        });
      });
    });
  });
}

void save_map(const LabelMap& map, const std::string& path, bool overwrite, bool thumbnail,
              const nb::dict& given) {
  const Output output{path, overwrite, thumbnail};
  Work work(given);
  work.run([&] {
    require_computed(output, {});
    if (map.tree() != nullptr) {
      write_described_mask(*map.tree(), map.volume(), output, "save", work.context());
    } else {
      write_label_tree(*map.labels(), map.volume(), output, "save", work.context());
    }
  });
}

/// For each label but 0 of either: voxels in both maps and in both at once.
nb::list agreements_of(const LabelMap& a, const LabelMap& b, const nb::dict& given) {
  Work work(given);
  const std::vector<LabelAgreement> found = work.run([&] {
    const TaskContext& context = work.context();
    require_same_grid(a.volume(), "the first label map", b.volume(), "the second label map",
                      "grid");
    const auto first = a.label_tree(context);
    const auto second = b.label_tree(context);
    std::vector<LabelAgreement> agreements;
    context.on_threads([&] { agreements = label_agreements(label_overlaps(*first, *second)); });
    return agreements;
  });
  return list_of(found, [](const LabelAgreement& one) {
    return dict_of({{"label", one.label},
                    {"voxels_a", one.first_voxels},
                    {"voxels_b", one.second_voxels},
                    {"voxels_both", one.both_voxels},
                    {"dice", one.dice()}});
  });
}

nb::dict facts_of_map(const LabelMap& map) {
  const VolumeDescription& volume = map.volume();
  nb::dict facts = volume_facts(volume);
  facts["shape"] = nb::make_tuple(volume.size.z, volume.size.y, volume.size.x);
  facts["spacing"] = zyx_of(volume.geometry.spacing_mm);
  facts["origin"] = zyx_of(volume.geometry.origin_mm);
  facts["is_mask"] = map.tree() != nullptr;
  facts["memory_bytes"] =
      map.tree() != nullptr ? map.tree()->memory_bytes() : map.labels()->memory_bytes();
  return facts;
}

}  // namespace

std::shared_ptr<const ComputedMask> LabelMap::mask(const TaskContext& context) const {
  if (mask_) return mask_;
  ComputedMask mask{MaskTree(), volume_};
  context.on_threads([&] { mask.tree = mask_of(*labels_, labels_but_0(*labels_)); });
  return std::make_shared<const ComputedMask>(std::move(mask));
}

std::shared_ptr<const LabelTree> LabelMap::label_tree(const TaskContext& context) const {
  if (labels_) return labels_;
  const LabelMask only{1, mask_->tree};
  LabelTree labels;
  context.on_threads([&] { labels = labels_of_masks(mask_->volume.size, std::span(&only, 1)); });
  return std::make_shared<const LabelTree>(std::move(labels));
}

void bind_label_maps(nb::module_& module) {
  nb::class_<LabelMap>(module, "LabelTree")
      .def("facts", &facts_of_map)
      .def("counts", &counts_of)
      .def("read", &fill_map, "start"_a, "stop"_a, "out"_a, "work"_a)
      .def("save", &save_map, "path"_a, "overwrite"_a, "thumbnail"_a, "work"_a)
      .def("select", &labels_selected, "labels"_a, "work"_a)
      .def("combine", &combine_maps, "other"_a.none(), "operation"_a, "work"_a)
      .def("fill_holes", &filled_map, "connectivity"_a, "max_mm3"_a.none(), "work"_a)
      .def("morph", &morphed_map, "operation"_a, "mm"_a.none(), "steps"_a, "connectivity"_a,
           "work"_a)
      .def("components", &components_of, "connectivity"_a, "keep_largest"_a, "min_mm3"_a, "work"_a)
      .def("agreements", &agreements_of, "other"_a, "work"_a);
  module.def("threshold", &threshold_map, "file"_a, "name"_a, "ranges"_a, "tissues"_a,
             "is_stored"_a, "work"_a);
  module.def("label_tree", &label_map_of, "file"_a, "name"_a, "labels"_a, "names"_a, "work"_a);
  module.def("saved_tree", &saved_map, "file"_a, "name"_a, "is_mask"_a, "work"_a);
}

}  // namespace octavo::python
