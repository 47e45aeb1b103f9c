#include "octavo/io/source/value_unit.h"

#include <algorithm>
#include <iterator>

#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

struct ValueUnit {
  std::string_view written;  // in small letters
  std::string_view code;     // empty where UCUM has none
};

constexpr ValueUnit kUnits[] = {
    // The defined terms of DICOM's Rescale Type, and what scanners write there
    {"hu", "[hnsf'U]"},
    {"hu_mod", ""},
    {"od", ""},
    {"mgml", "mg/mL"},
    {"z_eff", ""},
    {"ed", ""},
    {"edw", ""},
    {"pct", "%"},
    {"normalized", ""},
    // Density and attenuation
    {"g/cm3", "g/cm3"},
    {"g/cm^3", "g/cm3"},
    {"g/ml", "g/mL"},
    {"mg/cm3", "mg/cm3"},
    {"mg/cm^3", "mg/cm3"},
    {"mg/ml", "mg/mL"},
    {"mg ha/ccm", ""},
    {"mgha/ccm", ""},
    {"mgha/cm3", ""},
    {"1/cm", "cm-1"},
    {"cm-1", "cm-1"},
    {"cm^-1", "cm-1"},
    {"1/mm", "mm-1"},
    {"mm-1", "mm-1"},
    {"mm^-1", "mm-1"},
    // Dose, activity, uptake, diffusion, times
    {"gy", "Gy"},
    {"bq/ml", "Bq/mL"},
    {"bqml", "Bq/mL"},
    {"kbq/ml", "kBq/mL"},
    {"suv", ""},
    {"counts", ""},
    {"cps", ""},
    {"mm2/s", "mm2/s"},
    {"mm^2/s", "mm2/s"},
    {"um2/s", "um2/s"},
    {"um^2/s", "um2/s"},
    {"ms", "ms"},
    {"s", "s"},
    {"hz", "Hz"},
    {"ppm", "[ppm]"},
    {"t", "T"},
    {"mt", "mT"},
    {"optical density", ""},
    {"uncalibrated od", ""},
    {"%", "%"},
    {"percent", "%"},
    {"v", "V"},
    {"mv", "mV"},
    {"pa", "Pa"},
    {"kpa", "kPa"},
    {"k", "K"},
};

const ValueUnit* find_unit(const std::string& written) {
  const auto* const found =
      std::find_if(std::begin(kUnits), std::end(kUnits),
                   [&](const ValueUnit& unit) { return unit.written == written; });
  return found == std::end(kUnits) ? nullptr : found;
}

}  // namespace

std::string known_value_unit(const std::string& unit) {
  const std::string lower = lower_case(unit);
  if (lower == "hu" || lower == "hounsfield units") return "HU";
  return find_unit(lower) != nullptr ? unit : "";
}

std::string unit_code(std::string_view unit) {
  if (unit.empty()) return {};
  const ValueUnit* const known = find_unit(lower_case(std::string(unit)));
  if (known != nullptr && !known->code.empty()) return std::string(known->code);
  return "{" + std::string(unit) + "}";
}

std::string shown_unit(std::string_view code) {
  if (code == "[hnsf'U]") return "HU";
  if (code == "[ppm]") return "ppm";
  const bool is_annotation = code.size() > 2 && code.front() == '{' && code.back() == '}';
  return std::string(is_annotation ? code.substr(1, code.size() - 2) : code);
}

}  // namespace octavo
