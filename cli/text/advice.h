// What to type so that a failure does not happen again: the one place where failures of the library
// meet the options of the command line.
#pragma once

#include <string>

#include "octavo/core/error.h"

namespace octavo::cli {

/// What to do about a failure, as the end of its line; empty where only the failure can say.
std::string advice_for(const Error& error);

/// The same for a note about an option.
std::string advice_for_note(const std::string& field);

}  // namespace octavo::cli
