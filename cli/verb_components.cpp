// octavo components: what is connected in a mask, as a label map and a table.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/failure.h"
#include "common/inputs.h"
#include "common/masks.h"
#include "common/options.h"
#include "octavo/ops/mask/components.h"
#include "octavo/planes/computed_source.h"
#include "text/quantities.h"
#include "text/volume_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kText = {
    "components", "Find the connected parts of a mask.",
    "A mask is every voxel of a label map that is not 0. Parts are numbered from 1, the largest\n"
    "first. The label map written with -o is a mask for other verbs as well.\n\n"
    "Examples:\n"
    "  octavo components bone.8vo\n"
    "  octavo components bone.8vo --keep-largest 1 -o skull.8vo\n"
    "  octavo components pores.8vo --connectivity 26 --min-mm3 0.5 -o pores-labels.8vo --json"};

struct Arguments {
  std::string input;
  std::string output;
  int connectivity = 6;
  std::int64_t keep_largest = 0;
  double min_mm3 = 0;
  std::size_t rows = 20;
};

/// Bytes that a component takes while it is printed: in JSON, as a tree and as text, and as a row.
constexpr std::uint64_t kJsonBytes = 2048;
constexpr std::uint64_t kRowBytes = 256;

/// How many components, the largest first, are kept.
std::size_t kept_count(const Components& found, const Arguments& arguments,
                       const VolumeDescription& volume) {
  const auto& all = found.components();
  const auto mm3 = voxel_mm3(volume);
  if (arguments.min_mm3 > 0) require_known_spacing(volume, arguments.input, "--min-mm3");
  const auto end = std::find_if(all.begin(), all.end(), [&](const Component& component) {
    return mm3 && static_cast<double>(component.voxel_count) * *mm3 < arguments.min_mm3;
  });
  const auto large = static_cast<std::size_t>(end - all.begin());
  if (arguments.keep_largest == 0) return large;
  return std::min(large, static_cast<std::size_t>(arguments.keep_largest));
}

VoxelType label_type(std::size_t count) {
  return count <= 0xff ? VoxelType::uint8 : count <= 0xffff ? VoxelType::uint16 : VoxelType::uint32;
}

BuildResult write_components(const Components& found, std::size_t kept,
                             const VolumeDescription& volume, const Arguments& arguments,
                             const Context& context) {
  nlohmann::ordered_json made_by = {{"operation", "components"},
                                    {"connectivity", arguments.connectivity}};
  if (arguments.keep_largest > 0) made_by["keep_largest"] = arguments.keep_largest;
  if (arguments.min_mm3 > 0) made_by["min_mm3"] = arguments.min_mm3;
  const VoxelType type = label_type(kept);
  std::vector<std::uint32_t> labels;
  const auto source = make_computed_source(
      label_description(volume, type, made_by), [&](const Box& box, std::byte* voxels) {
        labels.resize(static_cast<std::size_t>(box.size().voxel_count()));
        found.fill_labels(box, labels.data());
        with_voxel_type(type, [&](auto id) {
          using T = typename decltype(id)::type;
          for (std::size_t i = 0; i < labels.size(); ++i) {
            const T label = labels[i] <= kept ? static_cast<T>(labels[i]) : T{0};
            std::memcpy(voxels + i * sizeof label, &label, sizeof label);
          }
        });
      });
  return write_labels(*source, arguments.output, context);
}

nlohmann::ordered_json objects_json(const Components& found, std::size_t kept,
                                    const VolumeDescription& volume) {
  const bool is_placed = voxel_mm3(volume).has_value();
  nlohmann::ordered_json objects = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < kept; ++i) {
    const Component& c = found.components()[i];
    objects.push_back({{"label", i + 1},
                       {"voxels", c.voxel_count},
                       {"mm3", mm3_json(c.voxel_count, volume)},
                       {"centroid_mm", nullptr},
                       {"box",
                        {{c.box.lo.x, c.box.hi.x}, {c.box.lo.y, c.box.hi.y},
                         {c.box.lo.z, c.box.hi.z}}}});
    if (is_placed) objects.back()["centroid_mm"] = volume.geometry.to_world(c.centroid);
  }
  return objects;
}

std::string table_text(const Components& found, std::size_t kept, const Arguments& arguments,
                       const VolumeDescription& volume) {
  const auto mm3 = voxel_mm3(volume);
  const std::size_t count = found.components().size();
  std::string text = fmt::format("{}: {}, {} kept\n", arguments.input,
                                 counted_text(static_cast<std::int64_t>(count), "component"),
                                 count_text(static_cast<std::int64_t>(kept)));
  const std::size_t rows = std::min(kept, arguments.rows);
  if (rows > 0) {
    text += fmt::format("{:>7} {:>14} {:>14}  {:<26} {}\n", "label", "voxels", "mm3",
                        mm3 ? "centroid mm (x, y, z)" : "centroid voxels", "box");
  }
  for (std::size_t i = 0; i < rows; ++i) {
    const Component& c = found.components()[i];
    const Point3 center = mm3 ? volume.geometry.to_world(c.centroid) : c.centroid;
    text += fmt::format(
        "{:>7} {:>14} {:>14}  {:<26} {}:{},{}:{},{}:{}\n", i + 1,
        count_text(static_cast<std::int64_t>(c.voxel_count)),
        mm3 ? fmt::format("{:.2f}", static_cast<double>(c.voxel_count) * *mm3) : "-",
        fmt::format("{:.1f}, {:.1f}, {:.1f}", center[0], center[1], center[2]), c.box.lo.x,
        c.box.hi.x, c.box.lo.y, c.box.hi.y, c.box.lo.z, c.box.hi.z);
  }
  if (rows < kept) {
    text += fmt::format("... {} more; --rows {} shows all\n",
                        count_text(static_cast<std::int64_t>(kept - rows)), kept);
  }
  return text;
}

int run_components(const Arguments& arguments, Context& context) {
  if (!arguments.output.empty())
    require_computed_output(arguments.output, {arguments.input}, context);
  const OpenedMask mask = open_mask(arguments.input, context);
  const VolumeDescription& volume = mask.volume();
  std::optional<Components> found;
  on_threads(context, [&] {
    found.emplace(mask.tree, static_cast<Connectivity>(arguments.connectivity),
                  context.max_memory_bytes);
  });
  const std::size_t kept = kept_count(*found, arguments, volume);
  const std::size_t rows = context.json ? kept : std::min(kept, arguments.rows);
  require_memory(found->memory_bytes() + rows * (context.json ? kJsonBytes : kRowBytes),
                 "the table of components", context);
  nlohmann::ordered_json result = {{"components", found->components().size()}, {"kept", kept}};
  if (context.json) result["objects"] = objects_json(*found, kept, volume);
  if (!arguments.output.empty()) {
    const BuildResult built = write_components(*found, kept, volume, arguments, context);
    result["output"] = arguments.output;
    result["file_bytes"] = built.file_bytes;
  }
  result["warnings"] = context.warnings;
  if (context.json) {
    print_json(result);
  } else if (!context.quiet) {
    print(table_text(*found, kept, arguments, volume));
  }
  return kExitDone;
}

}  // namespace

void add_components(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<Arguments>();
  Verb verb = add_verb(app, context, kText,
                            [arguments, &context] { return run_components(*arguments, context); });
  verb.add_option("mask", arguments->input, "A label map, .8vo")->type_name("FILE")->required();
  verb.add_option("-o,--output", arguments->output, "The .8vo label map to write")
      ->type_name("FILE");
  verb.add_option("--connectivity", arguments->connectivity,
                  "Voxels are connected by faces (6), edges (18) or corners (26)")
      ->type_name("N")
      ->check(one_of({6, 18, 26}))
      ->capture_default_str();
  verb.add_option("--keep-largest", arguments->keep_largest, "Keep only the N largest")
      ->type_name("N")
      ->check(whole_within(1));
  verb.add_option("--min-mm3", arguments->min_mm3, "Keep only those of this volume or more")
      ->type_name("V")
      ->check(not_negative());
  verb.add_option("--rows", arguments->rows, "Rows of the table, at most")
      ->type_name("N")
      ->check(whole_within(0))
      ->capture_default_str();
}

}  // namespace octavo::cli
