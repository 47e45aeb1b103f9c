// What ranks did, in words and JSON, beside the model of the thesis.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "octavo/dist/rank_report.h"

namespace octavo::cli {

/// What RankReport::held and RankShare::units count.
struct ReportUnits {
  std::string held;   ///< "bytes" or "codes"
  std::string units;  ///< "groups" or "planes"
  double whole = 0;   ///< of what is held: bytes of the file, or codes of the octree
};

std::string report_text(const RankReport& report, const ReportUnits& units);
nlohmann::ordered_json report_json(const RankReport& report, const ReportUnits& units);

}  // namespace octavo::cli
