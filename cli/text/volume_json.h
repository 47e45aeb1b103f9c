// What a file says of itself, as JSON and as words.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "octavo/builder/float_planes.h"
#include "octavo/file/reader.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo::cli {

/// The metadata object; an object with the raw text under "unreadable" when it is no JSON object.
nlohmann::ordered_json metadata_of(const VolumeDescription& description);

/// "HU" and the like; empty when the metadata names none.
std::string unit_of(const nlohmann::ordered_json& metadata);

/// False when the source carried no spacing and 1 mm was assumed.
bool is_spacing_known(const nlohmann::ordered_json& metadata);

/// The number or list as it is, or null where the spacing is not known.
nlohmann::ordered_json if_in_mm(const VolumeDescription& volume,
                                const nlohmann::ordered_json& value_mm);

/// The object that `info --json` prints.
nlohmann::ordered_json file_json(const FileReader& reader);

/// "grey" or "labels".
const char* kind_name(VolumeKind kind);

/// "0.5 HU": a difference of stored voxels in real units.
std::string distance_text(const VolumeDescription& description, const std::string& unit,
                          double stored);

/// {"type", "scale", "offset"}, or null.
nlohmann::ordered_json coding_json(const std::optional<SampleCoding>& coding);

/// How far the source of a file lay from its own source, real units; 0 when nothing is known.
double source_max_error(const nlohmann::ordered_json& metadata);

/// True when the source had lost something before it came here.
bool was_source_lossy(const nlohmann::ordered_json& metadata);

/// What took the place of NaN and infinities when the file was built.
FloatRepair repair_of(const nlohmann::ordered_json& metadata);

/// "-1000 HU", or "3" for labels and where no unit is known.
std::string real_text(const VolumeDescription& description, const std::string& unit, double stored);

}  // namespace octavo::cli
