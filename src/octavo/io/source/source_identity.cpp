#include "octavo/io/source/source_identity.h"

#include <nlohmann/json.hpp>
#include <utility>

namespace octavo {

namespace {

using nlohmann::json;

constexpr std::size_t kMaxValueBytes = std::size_t{1} << 16;

std::string text_of(const json& object) {
  return object.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace

void SourceIdentity::note(const std::string& name, std::string value) {
  if (value.empty()) return;
  ++counts_[name];
  std::string& text = values_[name];
  if (text.size() + value.size() >= kMaxValueBytes) {
    if (text.empty()) values_.erase(name);
    return;
  }
  if (text.empty()) {
    text = std::move(value);
  } else if (("\n" + text + "\n").find("\n" + value + "\n") == std::string::npos) {
    text += "\n" + value;
  }
}

void SourceIdentity::note_lost(const std::string& name, std::int64_t count) {
  if (count > 0) counts_[name] += count;
}

std::string SourceIdentity::json_text(bool keep) const {
  json identity = {{"kept", keep}, {"dropped", json::object()}};
  for (const auto& [name, count] : counts_) {
    if (!keep || !values_.contains(name)) identity["dropped"][name] = count;
  }
  if (keep) identity["attributes"] = values_;
  return text_of(identity);
}

std::string without_identity(const std::string& identity_json) {
  json identity = json::parse(identity_json, nullptr, false);
  if (!identity.is_object() || !identity.contains("attributes")) return identity_json;
  const json attributes = std::move(identity["attributes"]);
  identity.erase("attributes");
  identity["kept"] = false;
  if (!identity["dropped"].is_object()) identity["dropped"] = json::object();
  for (const auto& [name, value] : attributes.items()) identity["dropped"][name] = 1;
  return text_of(identity);
}

}  // namespace octavo
