#include "octavo/core/unit_code.h"

#include <algorithm>
#include <iterator>

namespace octavo {

namespace {

struct UnitCode {
  std::string_view written;  // in small letters
  std::string_view code;
};

constexpr UnitCode kUnitCodes[] = {
    {"hu", "[hnsf'U]"},    {"g/cm3", "g/cm3"},    {"g/cm^3", "g/cm3"},   {"g/ml", "g/mL"},
    {"mg/cm3", "mg/cm3"},  {"mg/cm^3", "mg/cm3"}, {"mg/ml", "mg/mL"},    {"mgml", "mg/mL"},
    {"1/cm", "cm-1"},      {"cm-1", "cm-1"},      {"cm^-1", "cm-1"},     {"1/mm", "mm-1"},
    {"mm-1", "mm-1"},      {"mm^-1", "mm-1"},     {"gy", "Gy"},          {"bq/ml", "Bq/mL"},
    {"bqml", "Bq/mL"},     {"kbq/ml", "kBq/mL"},  {"mm2/s", "mm2/s"},    {"mm^2/s", "mm2/s"},
    {"um2/s", "um2/s"},    {"um^2/s", "um2/s"},   {"ms", "ms"},          {"s", "s"},
    {"hz", "Hz"},          {"ppm", "[ppm]"},      {"t", "T"},            {"mt", "mT"},
    {"%", "%"},            {"percent", "%"},      {"pct", "%"},          {"v", "V"},
    {"mv", "mV"},          {"pa", "Pa"},          {"kpa", "kPa"},        {"k", "K"},
};

std::string in_small_letters(std::string_view text) {
  std::string small(text);
  for (char& c : small) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return small;
}

}  // namespace

std::string unit_code(std::string_view unit) {
  if (unit.empty()) return {};
  const std::string small = in_small_letters(unit);
  const auto* const known =
      std::find_if(std::begin(kUnitCodes), std::end(kUnitCodes),
                   [&](const UnitCode& one) { return one.written == small; });
  if (known != std::end(kUnitCodes)) return std::string(known->code);
  return "{" + std::string(unit) + "}";
}

std::string shown_unit(std::string_view code) {
  if (code == "[hnsf'U]") return "HU";
  if (code == "[ppm]") return "ppm";
  const bool is_annotation = code.size() > 2 && code.front() == '{' && code.back() == '}';
  return std::string(is_annotation ? code.substr(1, code.size() - 2) : code);
}

}  // namespace octavo
