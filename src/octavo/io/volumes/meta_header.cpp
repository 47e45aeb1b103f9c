#include "octavo/io/volumes/meta_header.h"

#include <algorithm>
#include <cstddef>
#include <set>
#include <span>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

constexpr std::size_t kMaxMetaHeaderBytes = std::size_t{1} << 16;
constexpr std::size_t kMaxListBytes = std::size_t{1} << 20;

bool is_meta_field(const std::string& name) {
  static const std::set<std::string> kNames = {
      "AnatomicalOrientation", "BinaryData", "BinaryDataByteOrderMSB", "CenterOfRotation",
      "Color", "CompressedData", "CompressedDataSize", "CompressionLevel", "DimSize",
      "DistanceUnits", "ElementByteOrderMSB", "ElementDataFile", "ElementMax", "ElementMin",
      "ElementNBits", "ElementNumberOfChannels", "ElementSize", "ElementSpacing",
      "ElementToIntensityFunctionOffset", "ElementToIntensityFunctionSlope", "ElementType",
      "HeaderSize", "ID", "Modality", "NDims", "ObjectSubType", "ObjectType", "Offset",
      "Orientation", "Origin", "ParentID", "Position", "Rotation", "SequenceID",
      "TransformMatrix", "TransformType"};
  return kNames.contains(name);
}

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

[[noreturn]] void reject_contradiction(const FieldText& a, const FieldText& b) {
  reject(a.path, escaped(a.name) + " (" + escaped(a.value) + ") and " + escaped(b.name) + " (" +
                     escaped(b.value) + ") contradict each other; take out the wrong one");
}

}  // namespace

MetaHeader::MetaHeader(const std::string& path) : path_(path) {
  const std::vector<std::byte> head = file_head(path, kMaxMetaHeaderBytes);
  const std::string_view text = text_of(head);
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view line = text.substr(at, end - at);
    at = std::min(end + 1, text.size());
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos) {
      if (trimmed(line).empty()) continue;
      break;
    }
    const std::string name(trimmed(line.substr(0, equals)));
    take_field(name, trimmed(line.substr(equals + 1)));
    if (name == "ElementDataFile") {
      data_offset_ = at;
      return;
    }
  }
  reject(path, "not a MetaImage header: no ElementDataFile line found in its first 64 KiB");
}

void MetaHeader::take_field(const std::string& name, std::string_view value) {
  const auto [place, is_new] = fields_.emplace(name, value);
  if (is_new) return;
  const FieldText first{path_, name, place->second};
  const FieldText other{path_, name, value};
  if (is_meta_field(name) && !first.says_same(other)) reject_contradiction(first, other);
}

FieldText MetaHeader::field(std::initializer_list<const char*> names) const {
  for (const char* name : names) {
    const auto found = fields_.find(name);
    if (found != fields_.end()) return {path_, found->first, found->second};
  }
  return {path_, *names.begin(), {}};
}

FieldText MetaHeader::agreed_field(std::initializer_list<const char*> spellings) const {
  const FieldText first = field(spellings);
  for (const char* name : spellings) {
    if (has(name) && !first.says_same(field({name}))) reject_contradiction(first, field({name}));
  }
  return first;
}

bool MetaHeader::is_true(std::initializer_list<const char*> spellings) const {
  const FieldText first = field(spellings);
  if (!has(std::string(first.name))) return false;
  const bool is_first_true = says_true(first);
  for (const char* name : spellings) {
    if (!has(name) || says_true(field({name})) == is_first_true) continue;
    reject_contradiction(first, field({name}));
  }
  return is_first_true;
}

/// MetaIO takes all that begins with "T", "t" or "1" for true and the rest for false: what reads
/// otherwise is rejected.
bool MetaHeader::says_true(const FieldText& field) const {
  static const std::set<std::string> kTrue = {"true", "t", "1"};
  static const std::set<std::string> kFalse = {"false", "f", "0", "no", "n", "off"};
  const std::string word = lower_case(std::string(field.value));
  if (kTrue.contains(word)) return true;
  if (kFalse.contains(word)) return false;
  reject(path_, escaped(field.name) + " is \"" + escaped(field.value) +
                    "\", True or False expected; repair the header");
}

DataFileNames MetaHeader::file_list() const {
  const std::vector<std::byte> head = file_head(path_, kMaxListBytes + 1);
  if (head.size() > kMaxListBytes) reject(path_, "the list of data files exceeds 1 MiB");
  const std::string_view text = text_of(head);
  return DataFileNames::of_list(text.substr(std::min(data_offset_, text.size())));
}

SourceIdentity MetaHeader::identity() const {
  SourceIdentity identity;
  for (const auto& [name, value] : fields_) {
    if (name == "Comment" || name == "Name" || name == "AcquisitionDate") {
      identity.note(name, value);
    } else if (!is_meta_field(name)) {
      identity.note("other field", name + " = " + value);
    }
  }
  return identity;
}

}  // namespace octavo
