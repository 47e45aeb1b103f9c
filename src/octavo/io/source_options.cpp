#include "octavo/io/source_options.h"

#include <charconv>
#include <string_view>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/levels.h"

namespace octavo {

namespace {

std::int64_t parse_count(std::string_view text, const std::string& whole) {
  std::int64_t value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure == std::errc() && end == text.data() + text.size() && value >= 1 &&
      value <= kMaxAxis) {
    return value;
  }
  throw Error(ErrorKind::invalid_argument,
              "raw layout \"" + escaped(whole) + "\": \"" + escaped(text) +
                  "\" is not a size; write nx,ny,nz,type, for example 512,512,300,int16");
}

}  // namespace

RawLayout parse_raw_layout(const std::string& text) {
  std::vector<std::string_view> parts;
  for (std::string_view rest = text;;) {
    const std::size_t comma = rest.find(',');
    parts.push_back(rest.substr(0, comma));
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  if (parts.size() != 4) {
    throw Error(ErrorKind::invalid_argument,
                "raw layout \"" + escaped(text) + "\": 4 parts expected, " +
                    std::to_string(parts.size()) + " found; write nx,ny,nz,type");
  }
  RawLayout layout;
  layout.size = {parse_count(parts[0], text), parse_count(parts[1], text),
                 parse_count(parts[2], text)};
  std::string_view type = parts[3];
  if (type.ends_with(":be") || type.ends_with(":le")) {
    layout.big_endian = type.ends_with(":be");
    type.remove_suffix(3);
  }
  const std::optional<StoredType> known = parse_stored_type(type);
  if (!known) {
    throw Error(ErrorKind::invalid_argument,
                "raw layout \"" + escaped(text) + "\": unknown type \"" + escaped(type) +
                    "\"; int8, uint8 and so on to int64, uint64, float32 or float64");
  }
  layout.type = *known;
  return layout;
}

std::string SourceOptions::dicom_option() const {
  if (on_gap == GapPolicy::fill || on_gap == GapPolicy::resample) return "on_gap";
  if (drop_duplicates) return "drop_duplicates";
  if (!segment.empty()) return "segment";
  return untilt ? "untilt" : "";
}

}  // namespace octavo
