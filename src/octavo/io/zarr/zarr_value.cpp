#include "octavo/io/zarr/zarr_value.h"

#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/json_members.h"
#include "octavo/core/json_reader.h"

namespace octavo {

namespace {

/// What `read` returns; what it says of JSON is a fact of the file.
template <class Read>
auto of_file(const std::string& path, const Read& read) {
  try {
    return read();
  } catch (const Error& failure) {
    throw Error(ErrorKind::source_rejected, failure.detail(), path, failure.offset());
  }
}

/// A list of what `read` takes each value for.
template <class T, class Read>
std::optional<std::vector<T>> list_of(const ZarrValue& value, const Read& read) {
  if (!value.json().starts_with('[')) return std::nullopt;
  std::vector<T> list;
  for (const ZarrValue& item : value.items()) {
    const std::optional<T> one = read(item);
    if (!one) return std::nullopt;
    list.push_back(*one);
  }
  return list;
}

}  // namespace

ZarrValue::ZarrValue(std::string json, std::string path)
    : json_(std::move(json)), path_(std::move(path)) {
  of_file(path_, [&] {
    JsonReader in(json_);
    in.next();
    json_ = std::string(in.skip_value());
    return in.next();
  });
}

ZarrValue ZarrValue::at(std::string_view name) const {
  ZarrValue value;
  value.path_ = path_;
  if (!json_.starts_with('{')) return value;
  value.json_ = of_file(path_, [&] { return std::string(json_members(json_).json_of(name)); });
  return value;
}

std::vector<std::string> ZarrValue::names() const {
  std::vector<std::string> names;
  if (!json_.starts_with('{')) return names;
  const JsonObject object = of_file(path_, [&] { return json_members(json_); });
  for (const JsonMember& member : object.members()) names.push_back(member.name);
  return names;
}

std::vector<ZarrValue> ZarrValue::items() const {
  std::vector<ZarrValue> items;
  if (!json_.starts_with('[')) return items;
  for (const std::string_view item : of_file(path_, [&] { return json_items(json_); })) {
    items.emplace_back();
    items.back().json_ = item;
    items.back().path_ = path_;
  }
  return items;
}

std::optional<std::string> ZarrValue::text() const {
  if (!json_.starts_with('"')) return std::nullopt;
  return of_file(path_, [&] {
    JsonReader in(json_);
    in.next();
    return std::optional(in.string());
  });
}

std::optional<std::int64_t> ZarrValue::whole() const {
  const std::optional<double> value = number();
  if (!value) return std::nullopt;
  JsonReader in(json_);
  in.next();
  // 64.0, as some writers spell 64.
  constexpr double kMostExact = 9007199254740992.0;
  const bool is_whole = *value >= -kMostExact && *value <= kMostExact &&
                        static_cast<double>(static_cast<std::int64_t>(*value)) == *value;
  if (in.token() == JsonToken::integer) return in.integer();
  return is_whole ? std::optional(static_cast<std::int64_t>(*value)) : std::nullopt;
}

std::optional<double> ZarrValue::number() const {
  if (!is_there()) return std::nullopt;
  return of_file(path_, [&]() -> std::optional<double> {
    JsonReader in(json_);
    const JsonToken token = in.next();
    if (token != JsonToken::integer && token != JsonToken::number) return std::nullopt;
    return in.number();
  });
}

std::optional<bool> ZarrValue::boolean() const {
  if (json_ != "true" && json_ != "false") return std::nullopt;
  return json_ == "true";
}

std::optional<std::vector<std::int64_t>> ZarrValue::wholes() const {
  return list_of<std::int64_t>(*this, [](const ZarrValue& item) { return item.whole(); });
}

std::optional<std::vector<double>> ZarrValue::numbers() const {
  return list_of<double>(*this, [](const ZarrValue& item) { return item.number(); });
}

void ZarrValue::reject(const std::string& why) const {
  throw Error(ErrorKind::source_rejected, why, path_);
}

}  // namespace octavo
