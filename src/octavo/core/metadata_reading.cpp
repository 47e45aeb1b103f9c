#include <algorithm>
#include <charconv>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/json_reader.h"
#include "octavo/core/metadata.h"
#include "octavo/core/metadata_fields.h"

namespace octavo {

namespace {

// Each read_value starts at the first token of a value and ends at its last one. A value of another
// form than the field's leaves the field empty.

template <class Record>
void read_value(JsonReader& in, std::optional<Record>& record);

void read_value(JsonReader& in, std::optional<bool>& field) {
  if (in.token() == JsonToken::boolean) field = in.boolean();
  in.skip_value();
}

void read_value(JsonReader& in, std::optional<std::int64_t>& field) {
  field = in.integer();
  in.skip_value();
}

void read_value(JsonReader& in, std::optional<double>& field) {
  field = in.number();
  in.skip_value();
}

void read_value(JsonReader& in, std::optional<std::string>& field) {
  if (in.token() == JsonToken::string) field = in.string();
  in.skip_value();
}

/// Calls read(name) at the first token of the value of every member; read leaves it at the last.
template <class Read>
void read_members(JsonReader& in, const Read& read) {
  if (in.token() != JsonToken::begin_object) {
    in.skip_value();
    return;
  }
  while (in.next() != JsonToken::end_object) {
    const std::string name = in.string();
    in.next();
    read(name);
  }
}

/// Calls read() at the first token of every value of a list; returns how many there are.
template <class Read>
std::int64_t read_list(JsonReader& in, const Read& read) {
  std::int64_t count = 0;
  if (in.token() != JsonToken::begin_list) {
    in.skip_value();
    return count;
  }
  for (; in.next() != JsonToken::end_list; ++count) read();
  return count;
}

void read_value(JsonReader& in, std::optional<std::vector<std::int64_t>>& field) {
  if (in.token() == JsonToken::begin_list) field.emplace();
  read_list(in, [&] {
    std::optional<std::int64_t> value;
    read_value(in, value);
    if (!value) field.reset();
    else if (field) field->push_back(*value);
  });
}

void read_value(JsonReader& in, std::optional<PlaneRun>& field) {
  std::optional<std::vector<std::int64_t>> ends;
  read_value(in, ends);
  if (ends && ends->size() == 2) field = {(*ends)[0], (*ends)[1]};
}

void read_value(JsonReader& in, std::optional<std::vector<PlaneRun>>& field) {
  if (in.token() == JsonToken::begin_list) field.emplace();
  read_list(in, [&] {
    std::optional<PlaneRun> run;
    read_value(in, run);
    if (!run) field.reset();
    else if (field) field->push_back(*run);
  });
}

void read_value(JsonReader& in, std::optional<JsonObject>& field) {
  field.emplace();
  read_members(in, [&](const std::string& name) {
    field->append(name, std::string(in.skip_value()));
  });
}

void read_value(JsonReader& in, std::optional<std::map<std::string, std::string>>& field) {
  if (in.token() == JsonToken::begin_object) field.emplace();
  read_members(in, [&](const std::string& name) {
    const bool is_text = in.token() == JsonToken::string;
    const std::string text = in.string();
    const std::string_view written = in.skip_value();
    (*field)[name] = is_text ? text : std::string(written);
  });
}

void read_value(JsonReader& in, std::map<std::string, std::int64_t>& field) {
  read_members(in, [&](const std::string& name) {
    field[name] = in.integer().value_or(0);
    in.skip_value();
  });
}

void read_value(JsonReader& in, std::vector<SegmentNote>& field) {
  read_list(in, [&] {
    std::optional<SegmentNote> segment;
    read_value(in, segment);
    field.push_back(segment.value_or(SegmentNote{}));
  });
}

void read_value(JsonReader& in, std::optional<MadeBy>& field) {
  std::optional<std::string> operation;
  JsonObject settings;
  read_members(in, [&](const std::string& name) {
    if (name == kOperation) read_value(in, operation);
    else settings.append(name, std::string(in.skip_value()));
  });
  if (!operation || operation->empty()) return;
  field.emplace(*operation);
  for (const JsonMember& setting : settings.members()) {
    field->set_json(setting.name, setting.json);
  }
}

/// "#ff8000".
std::optional<LabelColor> color_of(const std::optional<std::string>& text) {
  LabelColor color{};
  if (!text || text->size() != 2 * color.size() + 1 || text->front() != '#') return std::nullopt;
  for (std::size_t i = 0; i < color.size(); ++i) {
    const char* digits = text->data() + 1 + 2 * i;
    const auto [end, failure] = std::from_chars(digits, digits + 2, color[i], 16);
    if (failure != std::errc() || end != digits + 2) return std::nullopt;
  }
  return color;
}

/// The labels that `name` stands for as a decimal number; no other form does.
std::optional<std::int64_t> label_of(const std::string& name) {
  std::int64_t label = 0;
  const auto end = name.data() + name.size();
  const auto [stopped, failure] = std::from_chars(name.data(), end, label);
  const bool is_label = failure == std::errc() && stopped == end && std::to_string(label) == name;
  return is_label ? std::optional(label) : std::nullopt;
}

void read_value(JsonReader& in, LabelNames& field) {
  read_members(in, [&](const std::string& key) {
    std::optional<std::string> name;
    std::optional<std::string> color;
    read_members(in, [&](const std::string& member) {
      if (member == kLabelName) read_value(in, name);
      else if (member == kLabelColor) read_value(in, color);
      else in.skip_value();
    });
    const std::optional<std::int64_t> label = label_of(key);
    if (!label || (!name && !color) || field.size() == LabelNames::kMaxLabels) return;
    field.set(*label, {name.value_or(""), color_of(color)});
  });
}

/// Takes the value of one member into the field of that name.
class FieldReader {
 public:
  FieldReader(JsonReader& in, const std::string& name) : in_(in), name_(name) {}

  template <class T>
  void operator()(const char* name, T& field) {
    if (is_taken_ || name_ != name) return;
    is_taken_ = true;
    field = T();
    read_value(in_, field);
  }
  template <class T>
  void always(const char* name, T& field) {
    (*this)(name, field);
  }
  void exact(const char* name, std::optional<double>& field) { (*this)(name, field); }
  /// A number, or a list for its length.
  void count(const char* name, std::optional<std::int64_t>& field) {
    const bool is_list = in_.token() == JsonToken::begin_list;
    if (is_taken_ || name_ != name || !is_list) return (*this)(name, field);
    is_taken_ = true;
    field = read_list(in_, [&] { in_.skip_value(); });
  }
  void others(JsonObject& members) {
    if (is_taken_) return;
    is_taken_ = true;
    members.append(name_, std::string(in_.skip_value()));
  }
  void skip_unknown() {
    if (!is_taken_) in_.skip_value();
  }

 private:
  JsonReader& in_;
  const std::string& name_;
  bool is_taken_ = false;
};

template <class Record>
void read_record(JsonReader& in, Record& record) {
  read_members(in, [&](const std::string& name) {
    FieldReader reader(in, name);
    visit_fields(reader, record);
    reader.skip_unknown();
  });
}

template <class Record>
void read_value(JsonReader& in, std::optional<Record>& record) {
  if (in.token() == JsonToken::begin_object) record.emplace();
  if (record) read_record(in, *record);
  else in.skip_value();
}

}  // namespace

Metadata Metadata::read(std::string text) {
  Metadata metadata;
  metadata.text_ = std::move(text);
  try {
    JsonReader in(metadata.text_);
    if (in.next() != JsonToken::begin_object) throw Error(ErrorKind::corrupt, "no object");
    read_record(in, metadata.facts_);
    in.next();
  } catch (const Error& error) {
    metadata.facts_ = {};
    metadata.defect_ = error.detail();
  }
  return metadata;
}

}  // namespace octavo
