// What a file says of itself, as JSON and as words.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "octavo/tasks/files/info.h"
#include "octavo/tasks/volume_facts.h"
#include "text/fact_json.h"

namespace octavo {
struct Window;
}

namespace octavo::cli {

/// The metadata for JSON output; an object with the text under "unreadable" when it is none.
nlohmann::ordered_json metadata_json(const Metadata& metadata);

/// What a verb prints of the metadata, at most.
inline constexpr std::size_t kMaxShownMetadataBytes = std::size_t{1} << 20;

/// [x, y, z].
nlohmann::ordered_json size_json(const Size3& size);

/// A half-open box: [[x0, x1], [y0, y1], [z0, z1]].
nlohmann::ordered_json box_json(const Box& box);

/// The number or list as it is, or null where the spacing is not known.
nlohmann::ordered_json if_in_mm(const VolumeDescription& volume,
                                const nlohmann::ordered_json& value_mm);

/// {"center", "width"}, or null.
nlohmann::ordered_json window_json(const std::optional<Window>& window);

/// The object that `info --json` prints.
nlohmann::ordered_json file_json(const InfoResult& info);

/// {"type", "scale", "offset"}, or null.
nlohmann::ordered_json coding_json(const std::optional<SampleCoding>& coding);

/// Errors of details that were left out, or null.
nlohmann::ordered_json detail_errors_json(const std::optional<DetailErrors>& errors);

}  // namespace octavo::cli
