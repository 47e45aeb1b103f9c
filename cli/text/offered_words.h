// Words that shells offer for the value of an option.
#pragma once

#include <string>
#include <vector>

#include "common/option_tree.h"

namespace octavo::cli {

struct OfferedWords {
  std::vector<std::string> words;  ///< none: only files can be offered
  bool has_files = false;          ///< a name of a file does as well
};

/// The only values that there are, or those of all that a value of such a name ("WINDOW", "COLOR")
/// can be. The sets are those that the parsers look into.
OfferedWords offered_words(const OptionEntry& option);

}  // namespace octavo::cli
