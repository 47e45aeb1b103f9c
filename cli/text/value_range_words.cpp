#include "text/value_range_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "octavo/core/error.h"
#include "text/quantities.h"

namespace octavo::cli {

namespace {

/// "; as a tissue it is 226: in HU, ..." where a tissue is called so.
std::string tissue_hint(const std::string& name) {
  const std::vector<std::string> names = tissue_names();
  if (std::ranges::find(names, name) == names.end()) return "";
  const AskedRange range = tissue_range(name);
  const auto end = [](double value) { return std::isfinite(value) ? number_text(value) : ""; };
  return fmt::format("; as a tissue it is {}:{} in HU, and octavo threshold and render take it by "
                     "its name: --tissue {}",
                     end(range.lowest), end(range.highest), name);
}

}  // namespace

AskedRange parse_range(const std::string& text, const std::string& option) {
  const std::vector<std::string> ends = split(text, ':');
  if (ends.size() != 2 || (ends[0].empty() && ends[1].empty())) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("{}: '{}'; expected LOW:HIGH, one of which may be left out{}", option,
                            escaped(text), tissue_hint(text)));
  }
  AskedRange range;
  if (!ends[0].empty()) range.lowest = parse_number(ends[0], option);
  if (!ends[1].empty()) range.highest = parse_number(ends[1], option);
  if (range.lowest > range.highest) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("{}: '{}'; the lower end comes first", option, escaped(text)));
  }
  return range;
}

nlohmann::ordered_json range_end_json(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

}  // namespace octavo::cli
