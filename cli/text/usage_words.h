// What is wrong with a command line, and what may have been meant.
#pragma once

#include <string>
#include <vector>

#include "common/option_tree.h"

namespace octavo::cli {

/// The words as they are parsed: "help" and "help VERB" ask for help as --help does, and three
/// numbers behind `probe --at` or `--mm` are one place; further places belong to the same option.
std::vector<std::string> settled_words(std::vector<std::string> words);

/// The first word that names no verb, option or value of this program, with the nearest that does:
/// "no option --azimut; did you mean --azimuth?". Empty where every word is known.
std::string unknown_word(const ProgramEntry& program, const std::vector<std::string>& words);

/// What the parser of options says is wrong, in the words of the program.
std::string usage_fault(const std::string& said);

/// The nearest of `known`, when it is near enough to have been meant; or nothing. Case does not
/// count.
/// Source  distance of Damerau and Levenshtein, neighbors exchanged at a cost of 1
std::string nearest_word(const std::string& word, const std::vector<std::string>& known);

}  // namespace octavo::cli
