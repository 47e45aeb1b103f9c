// What the user should know although the work goes on.
#pragma once

#include <concepts>
#include <string>
#include <utility>

namespace octavo {

/// Something that does not stop the work, and the option that would change it.
struct Warning {
  std::string text;   ///< one line
  std::string field;  ///< name of a field of an options struct, as in OptionHint; or empty

  /// A text alone is a warning about no option.
  template <std::convertible_to<std::string> Text>
  Warning(Text&& words, std::string option_field = {})
      : text(std::forward<Text>(words)), field(std::move(option_field)) {}

  bool operator==(const Warning&) const = default;
};

}  // namespace octavo
