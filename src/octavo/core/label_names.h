// What the labels of a volume are called, and in which colors they are drawn.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

namespace octavo {

using LabelColor = std::array<std::uint8_t, 3>;  ///< red, green, blue

struct LabelName {
  std::string name;  ///< UTF-8; may come from any file: to be escaped before it is shown
  std::optional<LabelColor> color;
  bool operator==(const LabelName&) const = default;
};

/// Names and colors by label. What is within the limits fits into the metadata of a file.
class LabelNames {
 public:
  static constexpr std::size_t kMaxLabels = 16384;
  static constexpr std::size_t kMaxNameBytes = 512;

  /// Names a label, anew where it had a name. A longer name than kMaxNameBytes is cut behind a
  /// character.
  /// Throws  Error{limit_exceeded} for more labels than kMaxLabels
  void set(std::int64_t label, LabelName name);

  bool is_empty() const { return names_.empty(); }
  std::size_t size() const { return names_.size(); }
  const std::map<std::int64_t, LabelName>& all() const { return names_; }

  /// The name of a label; empty where it has none.
  const std::string& name_of(std::int64_t label) const;
  /// Its name, or its number where it has none.
  std::string text_of(std::int64_t label) const;
  /// Its color, or `otherwise` where none is given.
  LabelColor color_of(std::int64_t label, const LabelColor& otherwise) const;

  bool operator==(const LabelNames&) const = default;

 private:
  std::map<std::int64_t, LabelName> names_;
};

}  // namespace octavo
