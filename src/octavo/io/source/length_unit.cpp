#include "octavo/io/source/length_unit.h"

#include <map>
#include <string>

#include "octavo/io/source/source_file.h"

namespace octavo {

std::optional<double> unit_in_mm(std::string_view unit) {
  static const std::map<std::string, double, std::less<>> kUnits = {
      {"mm", 1},         {"millimeter", 1},  {"millimetre", 1},  {"millimeters", 1},
      {"cm", 10},        {"centimeter", 10}, {"centimetre", 10}, {"m", 1000},
      {"meter", 1000},   {"metre", 1000},    {"meters", 1000},   {"nm", 1e-6},
      {"nanometer", 1e-6}, {"nanometre", 1e-6}, {"um", 1e-3},    {"micron", 1e-3},
      {"microns", 1e-3}, {"micrometer", 1e-3}, {"micrometre", 1e-3},
      // The micro sign and the Greek letter in UTF-8, escaped, and in Latin-1.
      {"\\u00b5m", 1e-3}, {"\xc2\xb5m", 1e-3}, {"\xce\xbcm", 1e-3}, {"\xb5m", 1e-3},
      {"inch", 25.4},    {"in", 25.4},       {"inches", 25.4},
      {"ft", 304.8},     {"foot", 304.8},   {"yd", 914.4},      {"yard", 914.4},
      {"mile", 1609344}, {"mi", 1609344},
      {"km", 1e6},       {"kilometer", 1e6}, {"kilometre", 1e6},
      {"dm", 100},       {"decimeter", 100}, {"decimetre", 100}, {"angstrom", 1e-7},
      // The letter with a ring in UTF-8, the sign, and the letter in Latin-1.
      {"\xc3\x85", 1e-7}, {"\xe2\x84\xab", 1e-7}, {"\xc5", 1e-7},
      {"pm", 1e-9},      {"picometer", 1e-9}, {"picometre", 1e-9}, {"fm", 1e-12},
      {"femtometer", 1e-12}, {"femtometre", 1e-12}};
  const auto found = kUnits.find(lower_case(std::string(unit)));
  return found == kUnits.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace octavo
