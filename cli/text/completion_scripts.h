// Completion scripts for shells: verbs, options, the values of an option that has a list of them,
// and files elsewhere.
#pragma once

#include <string>

#include "common/option_tree.h"

namespace octavo::cli {

/// For bash 4 or later.
std::string bash_completion(const ProgramEntry& program);
/// A function _octavo, named after the program, for a folder of zsh's fpath.
std::string zsh_completion(const ProgramEntry& program);
std::string fish_completion(const ProgramEntry& program);

}  // namespace octavo::cli
