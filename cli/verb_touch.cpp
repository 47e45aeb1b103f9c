// octavo touch: do two objects overlap or touch, and which labels of a label map lie side by side.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "common/volume_options.h"
#include "octavo/core/text.h"
#include "octavo/core/url_text.h"
#include "octavo/tasks/geometry_words.h"
#include "octavo/tasks/touch.h"
#include "octavo/tasks/volume_facts.h"
#include "text/label_words.h"
#include "text/quantities.h"
#include "text/table.h"
#include "text/volume_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kTouchText = {
    "touch", "Tell whether two masks overlap or touch, or which labels of one file do.",
    "A mask is every voxel of a label map that is not 0. With two files, A and B: how many voxels\n"
    "are in both and where; and how many voxels of A alone are neighbors of voxels of B alone,\n"
    "and the other way round, with the faces between them and their area. With one file: every\n"
    "pair of its labels but 0 that are neighbors, with the faces they share.\n"
    "--connectivity says which voxels are neighbors; faces and areas do not depend on it.\n"
    "Boxes are half-open in voxels; in mm (LPS) they enclose the voxels, not their centers.\n"
    "The exit code is 0 whatever is found; programs read \"relation\" with --json.\n\n"
    "Examples:\n"
    "  octavo touch implant.8vo nerve.8vo\n"
    "  octavo touch implant.8vo nerve.8vo --connectivity 26 --json\n"
    "  octavo touch atlas.8vo"};

struct TouchArguments {
  std::vector<std::string> inputs;
  Connectivity connectivity = Connectivity::faces;

  int neighbors() const { return static_cast<int>(connectivity); }
};

std::uint64_t face_count(const std::array<std::uint64_t, 3>& faces) {
  return faces[0] + faces[1] + faces[2];
}

std::string faces_text(const std::array<std::uint64_t, 3>& faces,
                       const VolumeDescription& volume) {
  const std::string text = count_of(face_count(faces), "face");
  const auto mm2 = area_mm2(faces, volume);
  return mm2 ? text + fmt::format(", {} mm2", number_text(*mm2)) : text;
}

nlohmann::ordered_json extent_json(const VoxelExtent& extent, const VolumeDescription& volume) {
  nlohmann::ordered_json object = {{"voxels", extent.voxel_count},
                                   {"mm3", json_of(mm3_of(extent.voxel_count, volume))},
                                   {"box", nullptr},
                                   {"box_mm", nullptr}};
  if (extent.voxel_count == 0) return object;
  object["box"] = box_json(extent.box);
  if (!is_spacing_known(volume)) return object;
  const BoxMm world = world_box(extent.box, volume.geometry);
  object["box_mm"] = {{world.lo[0], world.hi[0]}, {world.lo[1], world.hi[1]},
                      {world.lo[2], world.hi[2]}};
  return object;
}

/// "box 4:24,4:24,4:24, 2:12,2:12,8:48 mm"
std::string where_text(const Box& box, const VolumeDescription& volume) {
  std::string text = "box " + box_text(box);
  if (!is_spacing_known(volume)) return text;
  const BoxMm world = world_box(box, volume.geometry);
  text += "; ";
  for (std::size_t axis = 0; axis < 3; ++axis) {
    text += fmt::format("{}{:.2f}:{:.2f}", axis == 0 ? "" : ",", world.lo[axis], world.hi[axis]);
  }
  return text + " mm";
}

const char* relation_of(const Interference& found) {
  return found.is_overlap() ? "overlap" : found.is_contact() ? "touch" : "apart";
}

std::string masks_text(const TouchArguments& arguments, const TouchMasksResult& result) {
  const Interference& found = result.found;
  const VolumeDescription& volume = result.volume;
  const std::string a = shown_path(arguments.inputs[0]);
  const std::string b = shown_path(arguments.inputs[1]);
  std::string text = fmt::format("{} and {} {}\n", a, b,
                                 found.is_overlap()   ? "overlap"
                                 : found.is_contact() ? "touch"
                                                      : "do not touch");
  if (found.is_overlap()) {
    text += fmt::format("  in both:    {}; {}\n", volume_text(found.overlap.voxel_count, volume),
                        where_text(found.overlap.box, volume));
  }
  if (!found.is_contact()) return text;
  for (const auto& [name, extent] : {std::pair{&a, &found.contact_a}, {&b, &found.contact_b}}) {
    text += fmt::format("  touching:   {} of {} alone; {}\n",
                        count_of(extent->voxel_count, "voxel"), *name,
                        where_text(extent->box, volume));
  }
  return text + fmt::format("  in between: {}\n", faces_text(found.face_pairs, volume));
}

nlohmann::ordered_json masks_json(const TouchArguments& arguments,
                                  const TouchMasksResult& result) {
  const Interference& found = result.found;
  return {{"masks", {public_name(arguments.inputs[0]), public_name(arguments.inputs[1])}},
          {"relation", relation_of(found)},
          {"connectivity", arguments.neighbors()},
          {"overlap", extent_json(found.overlap, result.volume)},
          {"contact_a", extent_json(found.contact_a, result.volume)},
          {"contact_b", extent_json(found.contact_b, result.volume)},
          {"faces", face_count(found.face_pairs)},
          {"area_mm2", json_of(area_mm2(found.face_pairs, result.volume))}};
}

std::string labels_text(const TouchArguments& arguments, const TouchLabelsResult& result) {
  std::string text = fmt::format(
      "{}: {}\n", shown_path(arguments.inputs[0]),
      counted_text(static_cast<std::int64_t>(result.contacts.size()), "pair of labels touches",
                   "pairs of labels touch"));
  if (result.contacts.empty()) return text;
  const bool is_faces = arguments.connectivity == Connectivity::faces;
  std::vector<TextColumn> columns = {{"label", 10}, name_column(), {"label", 10},
                                     name_column(), {"faces", 14}, {"mm2", 14}};
  if (!is_faces) columns.push_back({"voxel pairs", 14});
  TextTable table(columns);
  const LabelNames& names = result.volume.metadata.facts().labels;
  for (const LabelContact& contact : result.contacts) {
    const auto mm2 = area_mm2(contact.face_pairs, result.volume);
    table.add({std::to_string(contact.first), names.name_of(contact.first),
               std::to_string(contact.second), names.name_of(contact.second),
               count_of(face_count(contact.face_pairs)), mm2 ? fmt::format("{:.2f}", *mm2) : "-",
               count_of(contact.voxel_pairs)});
  }
  return text + table.text();
}

nlohmann::ordered_json labels_json(const TouchArguments& arguments,
                                   const TouchLabelsResult& result) {
  const LabelNames& names = result.volume.metadata.facts().labels;
  const auto pair_json = [&](const LabelContact& contact) -> nlohmann::ordered_json {
    return {{"labels", {contact.first, contact.second}},
            {"names", {name_json(names, contact.first), name_json(names, contact.second)}},
            {"faces", face_count(contact.face_pairs)},
            {"area_mm2", json_of(area_mm2(contact.face_pairs, result.volume))},
            {"voxel_pairs", contact.voxel_pairs}};
  };
  return {{"labels", public_name(arguments.inputs[0])},
          {"connectivity", arguments.neighbors()},
          {"pairs", json_list(result.contacts, pair_json)}};
}

int run_touch(const TouchArguments& arguments, Context& context) {
  if (arguments.inputs.size() == 1) {
    const TouchLabelsOptions options = {arguments.inputs[0], arguments.connectivity};
    const TouchLabelsResult result = run_task(touch_labels, options, context);
    print_result(context, labels_json(arguments, result), labels_text(arguments, result));
  } else {
    const TouchMasksOptions options = {arguments.inputs[0], arguments.inputs[1],
                                       arguments.connectivity};
    const TouchMasksResult result = run_task(touch_masks, options, context);
    print_result(context, masks_json(arguments, result), masks_text(arguments, result));
  }
  return kExitDone;
}

}  // namespace

void add_touch(CLI::App& app, Context& context) {
  auto [verb, arguments] = add_verb(app, context, kTouchText, run_touch);
  verb.add_option("inputs FILE", arguments.inputs, "Two masks, or one label map, .8vo")
      .required()
      .expected(1, 2);
  add_connectivity(verb, arguments.connectivity,
                   "Neighbors share a face (6), a face or an edge (18), a corner as well (26)");
}

}  // namespace octavo::cli
