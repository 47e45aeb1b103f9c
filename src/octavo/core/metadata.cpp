#include "octavo/core/metadata.h"

#include <cstdio>
#include <utility>

#include "octavo/core/json_members.h"
#include "octavo/core/metadata_fields.h"
#include "octavo/core/text.h"

namespace octavo {

namespace {

class FieldWriter;

/// The fields that are there as members.
template <class Record>
JsonObject object_of(Record record);

template <class T>
std::string written(const T& value) {
  if constexpr (requires(FieldWriter& writer, T& record) { visit_fields(writer, record); }) {
    return object_of(value).text();
  } else {
    return json_text(value);
  }
}

std::string written(const MadeBy& made_by) {
  JsonObject object;
  object.set(kOperation, made_by.operation());
  for (const JsonMember& setting : made_by.settings().members()) {
    object.append(setting.name, setting.json);
  }
  return object.text();
}

std::string written(const LabelNames& labels) {
  JsonObject object;
  for (const auto& [label, entry] : labels.all()) {
    JsonObject one;
    if (!entry.name.empty()) one.set(kLabelName, entry.name);
    if (entry.color) {
      char text[8];
      const auto& [red, green, blue] = *entry.color;
      std::snprintf(text, sizeof text, "#%02x%02x%02x", red, green, blue);
      one.set(kLabelColor, text);
    }
    object.append(std::to_string(label), one.text());
  }
  return object.text();
}

template <class T>
std::string written(const std::map<std::string, T>& members) {
  JsonObject object;
  for (const auto& [name, value] : members) object.append(name, json_text(value));
  return object.text();
}

class FieldWriter {
 public:
  JsonObject take() { return std::move(members_); }

  template <class T>
  void operator()(const char* name, const std::optional<T>& field) {
    if (field) always(name, *field);
  }
  void operator()(const char* name, const LabelNames& labels) {
    if (!labels.is_empty()) always(name, labels);
  }
  void operator()(const char* name, const std::vector<SegmentNote>& segments) {
    std::vector<JsonObject> list;
    for (const SegmentNote& segment : segments) list.push_back(object_of(segment));
    if (!list.empty()) always(name, list);
  }
  template <class T>
  void always(const char* name, const T& field) {
    members_.append(name, written(field));
  }
  /// As the fewest characters that read back as the same number: "20", not "20.0".
  void exact(const char* name, const std::optional<double>& field) {
    if (field) members_.append(name, exact_text(*field));
  }
  void count(const char* name, const std::optional<std::int64_t>& field) { (*this)(name, field); }
  void others(const JsonObject& settings) {
    for (const JsonMember& setting : settings.members()) {
      members_.append(setting.name, setting.json);
    }
  }

 private:
  JsonObject members_;
};

template <class Record>
JsonObject object_of(Record record) {
  FieldWriter writer;
  visit_fields(writer, record);
  return writer.take();
}

/// A member that is an object, taken apart; nothing where it is none.
std::optional<JsonObject> object_in(const JsonObject& members, const char* name) {
  const std::string_view json = members.json_of(name);
  return json.starts_with('{') ? std::optional(json_members(json)) : std::nullopt;
}

bool has(const JsonObject& members, const char* name) { return !members.json_of(name).empty(); }

/// What stays of an identity: the names of its texts, as what was dropped. Nothing else that may
/// stand there does.
IdentityNote without_texts(const IdentityNote& identity) {
  IdentityNote left;
  left.dropped = identity.dropped;
  left.kept = identity.kept;
  if (!identity.attributes) return left;
  for (const auto& [name, text] : *identity.attributes) left.dropped[name] = 1;
  left.kept = false;
  return left;
}

}  // namespace

Metadata Metadata::of(MetadataFacts facts) { return read(object_of(std::move(facts)).text()); }

void Metadata::put_behind(MetadataFacts facts) {
  if (!is_readable()) return;
  JsonObject members = json_members(text_);
  const JsonObject added = object_of(std::move(facts));
  for (const JsonMember& member : added.members()) {
    members.erase(member.name);
    members.append(member.name, member.json);
  }
  *this = read(members.text());
}

void Metadata::set_coding(const CodingNote& coding) {
  MetadataFacts facts;
  facts.coding = coding;
  put_behind(std::move(facts));
}

void Metadata::set_labels(const LabelNames& labels) {
  MetadataFacts facts;
  facts.labels = labels;
  put_behind(std::move(facts));
}

void Metadata::set_made_by(const MadeBy& made_by) {
  MetadataFacts facts;
  facts.made_by = made_by;
  put_behind(std::move(facts));
}

void Metadata::set_place_known(bool is_known) {
  MetadataFacts facts;
  facts.place_known = is_known;
  put_behind(std::move(facts));
}

void Metadata::set_repaired(const RepairNote& repaired) {
  MetadataFacts facts;
  facts.repaired = repaired;
  put_behind(std::move(facts));
}

void Metadata::set_spacing(bool is_known, const std::string& source) {
  MetadataFacts facts;
  facts.spacing_known = is_known;
  facts.spacing_source = source;
  put_behind(std::move(facts));
}

void Metadata::set_written_by(const WriterNote& writer) {
  MetadataFacts facts;
  facts.written_by = writer;
  Metadata with_writer = *this;
  with_writer.put_behind(std::move(facts));
  if (with_writer.is_readable()) *this = std::move(with_writer);
}

void Metadata::drop_labels() {
  if (facts_.labels.is_empty()) return;
  JsonObject members = json_members(text_);
  members.erase(kLabels);
  *this = read(members.text());
}

JsonObject Metadata::normal_members() const {
  if (is_readable()) return json_members(normal_json(text_, MemberOrder::as_written));
  return JsonObject().set(kUnreadable, text_);
}

void Metadata::set_isotropic(const IsotropicNote& isotropic,
                             const std::optional<std::vector<PlaneRun>>& made_planes,
                             const std::optional<PlaneRun>& missing) {
  JsonObject members =
      is_readable() ? json_members(normal_json(text_, MemberOrder::by_name)) : JsonObject();
  JsonObject prepared = object_in(members, kPrepared).value_or(JsonObject());
  if (auto gaps = object_in(prepared, kGaps); gaps && has(*gaps, kGapsMadePlanes)) {
    if (made_planes) gaps->set(kGapsMadePlanes, *made_planes);
    else gaps->erase(kGapsMadePlanes);
    prepared.set(kGaps, *gaps);
  }
  prepared.set(kIsotropic, object_of(isotropic));
  prepared.sort_by_name();
  members.set(kPrepared, prepared);
  if (auto repaired = object_in(members, kRepaired); repaired && missing) {
    members.set(kRepaired, repaired->set(kMissingPlanes, *missing));
  } else {
    members.erase(kRepaired);
  }
  members.sort_by_name();
  *this = read(members.text());
}

JsonObject Metadata::members_without_identity() const {
  JsonObject members = normal_members();
  members.erase(kUnreadable);
  if (!has(members, kIdentity)) return members;
  if (facts_.identity) members.set_json(kIdentity, written(without_texts(*facts_.identity)));
  else members.erase(kIdentity);
  return members;
}

Metadata Metadata::without_identity() const {
  const JsonObject members = normal_members();
  if (!has(members, kIdentity) && !has(members, kUnreadable)) return *this;
  return read(members_without_identity().text());
}

Metadata Metadata::for_labels(const MadeBy& made_by) const {
  JsonObject members = members_without_identity();
  for (const char* name : {kUnit, kCoding, kSourceMaxError, kLossySource, kIdentity, kSegments,
                           kSegment, kChosen, kLabels, kWrittenBy}) {
    members.erase(name);
  }
  members.set_json(kMadeBy, written(made_by));
  return read(members.text());
}

Metadata Metadata::for_copy(double lost, bool keep_identity) const {
  lost += source_max_error();
  const Metadata passed_on = keep_identity ? *this : without_identity();
  JsonObject members = passed_on.normal_members();
  if (lost == 0 && !has(members, kCoding) && !has(members, kWrittenBy)) return passed_on;
  members.erase(kCoding);
  members.erase(kWrittenBy);
  if (lost > 0) members.set(kSourceMaxError, lost);
  return read(members.text());
}

}  // namespace octavo
