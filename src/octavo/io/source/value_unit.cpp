#include "octavo/io/source/value_unit.h"

#include <set>

#include "octavo/io/source/source_file.h"

namespace octavo {

std::string known_value_unit(const std::string& unit) {
  static const std::set<std::string> kUnits = {
      // The defined terms of DICOM's Rescale Type, and what scanners write there.
      "hu_mod", "od", "mgml", "z_eff", "ed", "edw", "pct", "normalized",
      // Density and attenuation.
      "g/cm3", "g/cm^3", "g/ml", "mg/cm3", "mg/cm^3", "mg/ml", "mg ha/ccm", "mgha/ccm",
      "mgha/cm3", "1/cm", "1/mm", "cm-1", "mm-1", "cm^-1", "mm^-1",
      // Dose, activity, uptake, diffusion, times.
      "gy", "bq/ml", "bqml", "kbq/ml", "suv", "counts", "cps", "mm2/s", "mm^2/s", "um2/s", "um^2/s",
      "ms", "s", "hz", "ppm", "t", "mt",
      "optical density", "uncalibrated od", "%", "percent", "v", "mv", "pa", "kpa", "k"};
  const std::string lower = lower_case(unit);
  if (lower == "hu" || lower == "hounsfield units") return "HU";
  return kUnits.contains(lower) ? unit : "";
}

}  // namespace octavo
