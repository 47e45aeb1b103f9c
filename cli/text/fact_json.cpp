#include "text/fact_json.h"

#include <type_traits>
#include <variant>

namespace octavo::cli {

nlohmann::ordered_json json_of(const JsonObject& object) {
  return nlohmann::ordered_json::parse(object.text());
}

nlohmann::ordered_json json_of(const FactValue& value) {
  return std::visit(
      []<class Held>(const Held& held) -> nlohmann::ordered_json {
        if constexpr (std::is_same_v<Held, std::monostate>) {
          return nullptr;
        } else if constexpr (std::is_same_v<Held, Facts>) {
          nlohmann::ordered_json object = nlohmann::ordered_json::object();
          for (const Fact& fact : held) object[fact.name] = json_of(fact.value);
          return object;
        } else if constexpr (std::is_same_v<Held, FactValue::List>) {
          nlohmann::ordered_json list = nlohmann::ordered_json::array();
          for (const FactValue& one : held) list.push_back(json_of(one));
          return list;
        } else {
          return held;
        }
      },
      value.held());
}

nlohmann::ordered_json text_json(const std::string& text) {
  return text.empty() ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(text);
}

}  // namespace octavo::cli
