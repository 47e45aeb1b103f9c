// Voxels out, in the formats other programs read: a volume, or a level or box of it.
#pragma once

#include <optional>
#include <string>

#include "octavo/io/export/export.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/salvage.h"
#include "octavo/tasks/volume_parts.h"

namespace octavo {

struct ExportPartOptions {
  std::string input;  ///< an .8vo file or a URL of one
  Output output;      ///< its name says the format, as export_format_of
  int level = 0;
  std::optional<AskedBox> box;  ///< in samples of the level; default the whole level
  std::optional<BoxMm> box_mm;  ///< the same in mm
  ExportValues values = ExportValues::exact;
  std::optional<SalvageFilling> salvage;
};

struct ExportPartResult {
  ExportResult written;
  Box box;  ///< in samples of the level
  std::optional<SalvageReport> salvaged;
};

/// Warns of what the format claims though nobody knows it, of what it cannot keep, and of damaged
/// bricks that were filled.
/// Throws  as open_volume, export_volume and salvaging; Error{invalid_argument} for a level or a
///         box that is not there; Error{corrupt} as read_salvaging
ExportPartResult export_part(const ExportPartOptions& options, const TaskContext& context);

}  // namespace octavo
