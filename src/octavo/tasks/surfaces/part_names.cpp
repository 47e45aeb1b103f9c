#include "octavo/tasks/surfaces/part_names.h"

#include <cstddef>
#include <map>
#include <string_view>

#include "octavo/core/utf8.h"

namespace octavo {

namespace {

constexpr std::size_t kMaxPartNameBytes = 200;

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool is_safe(char c) {
  const char small = lower(c);
  return (small >= 'a' && small <= 'z') || (c >= '0' && c <= '9') || c == '.' || c == '_' ||
         c == '-' || static_cast<unsigned char>(c) >= 0x80;
}

std::string numbered(std::int64_t label) { return "label_" + std::to_string(label); }

/// What Windows takes for a device, whatever stands behind a dot.
bool is_device(std::string_view name) {
  std::string stem(name.substr(0, name.find('.')));
  for (char& c : stem) c = lower(c);
  for (const char* const device : {"con", "prn", "aux", "nul"}) {
    if (stem == device) return true;
  }
  const bool has_port = stem.starts_with("com") || stem.starts_with("lpt");
  return has_port && stem.size() == 4 && stem[3] >= '0' && stem[3] <= '9';
}

std::string name_of_part(std::int64_t label, const LabelNames& names) {
  const std::string text = as_utf8(names.name_of(label));
  std::string name(cut_utf8(text, kMaxPartNameBytes));
  for (char& c : name) {
    if (!is_safe(c)) c = '_';
  }
  // A dot would hide the file, a dash make it an option.
  if (!name.empty() && (name.front() == '.' || name.front() == '-')) name.front() = '_';
  // Windows drops dots at the end of a name.
  if (!name.empty() && name.back() == '.') name.back() = '_';
  if (is_device(name)) name.insert(0, "_");
  return name.find_first_not_of("_.-") == std::string::npos ? numbered(label) : name;
}

std::string folded(const std::string& name) {
  std::string small = name;
  for (char& c : small) c = lower(c);
  return small;
}

}  // namespace

std::vector<std::string> part_names(const std::vector<std::int64_t>& labels,
                                    const LabelNames& names) {
  std::vector<std::string> result;
  std::map<std::string, int> counts;
  for (const std::int64_t label : labels) {
    result.push_back(name_of_part(label, names));
    ++counts[folded(result.back())];
  }
  // What a name with a number is equal to gets one as well.
  for (bool is_changed = true; is_changed;) {
    is_changed = false;
    for (std::size_t i = 0; i < result.size(); ++i) {
      if (counts[folded(result[i])] < 2) continue;
      result[i] += "_" + std::to_string(labels[i]);
      ++counts[folded(result[i])];
      is_changed = true;
    }
  }
  return result;
}

}  // namespace octavo
