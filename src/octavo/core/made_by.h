// How a computed volume came about: the name of an operation and its settings.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "octavo/core/json_text.h"

namespace octavo {

/// Whoever computes a volume makes one of these:
///     MadeBy made_by("components");
///     made_by.set("connectivity", 26).set("min_mm3", 0.5);
/// Settings are written in the order in which they were set. Whole numbers stay whole ("26"),
/// doubles keep a point ("0.5", "2.0"); infinities are written as null.
class MadeBy {
 public:
  explicit MadeBy(std::string operation) : operation_(std::move(operation)) {}

  /// Sets a bool, a number, a text, a JsonObject or a list of such; again, in its old place.
  template <class T>
  MadeBy& set(std::string_view name, const T& value) {
    settings_.set(name, value);
    return *this;
  }
  MadeBy& set_json(std::string_view name, std::string json) {
    settings_.set_json(name, std::move(json));
    return *this;
  }

  const std::string& operation() const { return operation_; }
  const JsonObject& settings() const { return settings_; }
  /// A setting that is a number.
  std::optional<double> number(std::string_view name) const;

 private:
  std::string operation_;
  JsonObject settings_;
};

}  // namespace octavo
