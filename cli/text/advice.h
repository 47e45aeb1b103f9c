// What to type: the one place where failures and warnings of the library meet the options of the
// command line.
#pragma once

#include <string>

#include "octavo/core/error.h"
#include "octavo/core/warning.h"

namespace octavo::cli {

/// What to do about a failure, as the end of its line; empty where only its text can say.
std::string advice_for(const Error& error);

/// The same for a note about an option.
std::string advice_for_note(const std::string& field);

/// The line of a warning, with what to do about it.
std::string with_advice(const Warning& warning);

}  // namespace octavo::cli
