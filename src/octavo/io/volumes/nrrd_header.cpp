#include "octavo/io/volumes/nrrd_header.h"

#include <algorithm>
#include <cstddef>
#include <set>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

constexpr std::size_t kMaxNrrdHeaderBytes = std::size_t{1} << 20;

bool is_of_the_format(const std::string& name) {
  static const std::set<std::string> kNames = {
      "axis maxs",   "axis mins",   "axismaxs",     "centers",         "block size",
      "blocksize",   "byte skip",   "data file",
      "dimension",   "encoding",    "endian",       "kinds",           "line skip",
      "max",         "min",         "number",       "measurement frame", "old max",
      "old min",     "oldmax",      "oldmin",       "sample units",    "sampleunits",
      "sizes",       "space",       "space dimension", "space directions", "space origin",
      "space units", "spacings",    "thicknesses",  "type",            "units"};
  return kNames.contains(name);
}

/// The versions that programs write.
bool is_magic(std::string_view line) {
  return line.size() == 8 && line.starts_with("NRRD000") && line.back() >= '1' &&
         line.back() <= '6';
}

/// The one spelling under which a field is kept.
std::string kept_name(const std::string& name) {
  static const std::map<std::string, std::string> kOthers = {
      {"datafile", "data file"}, {"lineskip", "line skip"},  {"byteskip", "byte skip"},
      {"axismins", "axis mins"}, {"centerings", "centers"}};
  const auto found = kOthers.find(name);
  return found == kOthers.end() ? name : found->second;
}

}  // namespace

NrrdHeader::NrrdHeader(const std::string& path) : path_(path) {
  const std::vector<std::byte> head = file_head(path, kMaxNrrdHeaderBytes + 1);
  const bool is_longer = head.size() > kMaxNrrdHeaderBytes;
  const std::string_view text(reinterpret_cast<const char*>(head.data()), head.size());
  if (!is_magic(trimmed(text.substr(0, text.find('\n'))))) {
    reject(path, "not a NRRD header that is read: it does not start with NRRD0001 to NRRD0006");
  }
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view line = trimmed(text.substr(at, end - at));
    at = std::min(end + 1, text.size());
    if (line.empty()) {
      data_offset_ = at;
      return;
    }
    take_line(line);
    if (names_list()) {
      if (is_longer) reject(path, "the list of data files exceeds 1 MiB");
      file_list_ = text.substr(at);
      return;
    }
  }
  if (is_longer) reject(path, "the NRRD header exceeds 1 MiB");
  data_offset_ = text.size();
  if (!has("data file")) reject(path, "the NRRD header has no end: the file is cut");
}

FieldText NrrdHeader::field(const std::string& name) const {
  const auto found = fields_.find(name);
  if (found == fields_.end()) return {path_, "", {}};
  return {path_, found->first, found->second};
}

bool NrrdHeader::names_list() const {
  const std::vector<std::string> data = words(field("data file").value);
  return !data.empty() && data.size() <= 2 && data.front() == "LIST";
}

void NrrdHeader::take_line(std::string_view line) {
  if (line.starts_with('#')) {
    identity_.note("comment", std::string(trimmed(line.substr(1))));
    return;
  }
  const std::size_t colon = line.find(": ");
  const std::size_t key_end = line.find(":=");
  if (key_end < colon) {
    identity_.note("key/value pair", std::string(line));
    fields_[std::string(line.substr(0, key_end + 2))] = trimmed(line.substr(key_end + 2));
    return;
  }
  if (colon == std::string_view::npos) return;
  const std::string name = kept_name(lower_case(std::string(line.substr(0, colon))));
  const bool is_new = fields_.emplace(name, trimmed(line.substr(colon + 2))).second;
  if (!is_new) {
    reject(path_, "the header has the field \"" + escaped(name) +
                      "\" twice; take out the wrong one");
  }
  if (name == "content" || name == "labels") {
    identity_.note(name, fields_[name]);
  } else if (!is_of_the_format(name)) {
    identity_.note("other field", std::string(line));
  }
}

}  // namespace octavo
