// Words that shells offer for the value of an option.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/option_tree.h"

namespace octavo::cli {

/// Words that stand in the place of numbers, for parsers as well.
inline constexpr std::string_view kAutomatic = "auto";  ///< of windows
inline constexpr std::string_view kOff = "off";
inline constexpr std::string_view kLowest = "lowest";   ///< of what damaged bricks are filled with
inline constexpr std::string_view kCoarse = "coarse";

/// The words that a window can be.
std::vector<std::string> window_words();
/// Those that the type of a phantom can be.
std::vector<std::string> phantom_type_words();

struct OfferedWords {
  std::vector<std::string> words;  ///< none: only files can be offered
  bool has_files = false;          ///< a name of a file does as well
};

/// The only values that there are, or those of all that a value of such a name ("WINDOW", "COLOR")
/// can be. The sets are those that the parsers look into; of viewpoints one name each.
OfferedWords offered_words(const OptionEntry& option);

}  // namespace octavo::cli
