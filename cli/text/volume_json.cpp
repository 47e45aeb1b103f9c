#include "text/volume_json.h"

#include <fmt/format.h>

#include <cmath>

#include "octavo/core/error.h"
#include "octavo/core/sha256.h"
#include "octavo/tasks/pictures/slice.h"
#include "text/identity_words.h"
#include "text/quantities.h"

namespace octavo::cli {

namespace {

nlohmann::ordered_json level_json(const InfoResult& info, std::size_t level) {
  const LevelInfo& one = info.levels[level];
  nlohmann::ordered_json bytes = one.summary.bytes;
  if (one.summary.is_in_finer) bytes = nullptr;
  return {{"level", level},
          {"size", size_json(one.size)},
          {"spacing_mm", one.spacing_mm},
          {"bricks", one.summary.bricks},
          {"uniform_bricks", one.summary.uniform_bricks},
          {"bytes", bytes}};
}

nlohmann::ordered_json parts_json(const std::vector<PartInfo>& parts) {
  return json_list(parts, [](const PartInfo& part) -> nlohmann::ordered_json {
    return {{"tag", part.tag},
            {"bytes", part.bytes},
            {"known", part.is_known},
            {"required", part.is_required},
            {"follows_from_voxels", part.follows_from_voxels},
            {"follows_from_rest", part.follows_from_rest}};
  });
}

nlohmann::ordered_json extensions_json(const std::vector<ExtensionInfo>& extensions) {
  return json_list(extensions, [](const ExtensionInfo& extension) -> nlohmann::ordered_json {
    return {{"tag", fmt::format("0x{:04x}", extension.tag)}, {"bytes", extension.bytes}};
  });
}

/// {"name", "revision"}, or null.
nlohmann::ordered_json writer_json(const Metadata& metadata) {
  const std::optional<WriterNote>& writer = metadata.facts().written_by;
  if (!writer) return nullptr;
  return {{"name", json_of(writer->name)}, {"revision", json_of(writer->revision)}};
}

/// The voxel that a number of the index stands for.
nlohmann::ordered_json voxel_json(const VolumeDescription& d, std::int64_t code) {
  if (is_integer(d.type)) return code;
  return d.voxel_of(code);
}

/// The metadata; of long ones only their place in the file.
nlohmann::ordered_json shown_metadata_json(const InfoResult& info) {
  const Metadata& metadata = info.volume.metadata;
  nlohmann::ordered_json shown = metadata_json(metadata);
  const nlohmann::ordered_json printed = {{"metadata", shown}};
  constexpr auto kReplace = nlohmann::ordered_json::error_handler_t::replace;
  if (printed.dump(2, ' ', false, kReplace).size() <= kMaxShownMetadataBytes) return shown;
  return {{"left_out", {{"offset", info.metadata_offset}, {"bytes", metadata.text().size()}}}};
}

}  // namespace

nlohmann::ordered_json metadata_json(const Metadata& metadata) {
  if (!metadata.is_readable()) return {{"unreadable", metadata.text()}};
  auto object = nlohmann::ordered_json::parse(metadata.text(), nullptr, false);
  if (object.is_discarded()) object = {{"unreadable", metadata.text()}};  // numbers beyond doubles
  return object;
}

nlohmann::ordered_json size_json(const Size3& size) { return {size.x, size.y, size.z}; }

nlohmann::ordered_json box_json(const Box& box) {
  return {{box.lo.x, box.hi.x}, {box.lo.y, box.hi.y}, {box.lo.z, box.hi.z}};
}

nlohmann::ordered_json if_in_mm(const VolumeDescription& volume,
                                const nlohmann::ordered_json& value_mm) {
  return is_spacing_known(volume) ? value_mm : nlohmann::ordered_json(nullptr);
}

nlohmann::ordered_json window_json(const std::optional<Window>& window) {
  if (!window) return nullptr;
  return {{"center", window->center}, {"width", window->width}};
}

nlohmann::ordered_json coding_json(const std::optional<SampleCoding>& coding) {
  if (!coding) return nullptr;
  return {{"type", voxel_type_name(coding->type)},
          {"scale", coding->scale},
          {"offset", coding->offset},
          {"exact", coding->is_exact}};
}

nlohmann::ordered_json detail_errors_json(const std::optional<DetailErrors>& errors) {
  if (!errors) return nullptr;
  return {{"max", json_of(errors->max)},
          {"rms", json_of(errors->rms)},
          {"psnr_db", json_of(errors->psnr_db)}};
}

nlohmann::ordered_json file_json(const InfoResult& info) {
  const VolumeDescription& d = info.volume;
  nlohmann::ordered_json levels = nlohmann::ordered_json::array();
  for (std::size_t level = 0; level < info.levels.size(); ++level) {
    levels.push_back(level_json(info, level));
  }
  const Metadata& metadata = d.metadata;
  const double slope = std::abs(d.rescale.slope);
  return {{"file", info.name},
          {"format_version", info.format_version},
          {"kind", word_of(d.kind)},
          {"type", voxel_type_name(d.type)},
          {"size", size_json(d.size)},
          {"spacing_mm", d.geometry.spacing_mm},
          {"spacing_known", is_spacing_known(d)},
          {"origin_mm", d.geometry.origin_mm},
          {"direction", d.geometry.direction},
          {"rescale", {{"slope", d.rescale.slope}, {"intercept", d.rescale.intercept}}},
          {"levels", levels},
          {"file_bytes", info.file_bytes},
          {"raw_bytes", info.raw_bytes},
          {"ratio", info.compression_ratio()},
          {"bits_per_voxel", info.bits_per_voxel()},
          {"max_error", info.max_error},
          {"achieved_error", info.achieved_error},
          {"max_error_real", info.max_error * slope},
          {"achieved_error_real", info.achieved_error * slope},
          {"lossless", info.max_error == 0},
          {"detail_level", info.detail_level},
          {"detail_errors", detail_errors_json(info.detail_errors)},
          {"voxels_sha256", hex_text(info.voxel_digest)},
          {"thumbnail_bytes", info.thumbnail_bytes},
          {"parts", parts_json(info.parts)},
          {"unknown_extensions", extensions_json(info.unknown_extensions)},
          {"written_by", writer_json(metadata)},
          {"source_lossy", metadata.was_source_lossy()},
          {"coding", coding_json(d.coding)},
          {"min", info.has_values ? voxel_json(d, info.range.min) : nullptr},
          {"max", info.has_values ? voxel_json(d, info.range.max) : nullptr},
          {"range_exact", info.is_range_exact()},
          {"identity", identity_state(metadata)},
          {"metadata", shown_metadata_json(info)}};
}

}  // namespace octavo::cli
