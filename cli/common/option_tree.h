// The verbs and options of the program as plain data: what completion scripts and manual pages are
// made from, so that they cannot fall behind the options themselves.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace octavo::cli {

/// An option, a flag or a positional word of a verb.
struct OptionEntry {
  std::vector<std::string> names;    ///< "-o", "--output"; none for a positional word
  std::string word;                  ///< what a positional word is called, else ""
  std::string value;                 ///< "FILE", "LOW:HIGH"; "" for a flag
  std::string limits;                ///< "1 to 1024", or ""
  std::vector<std::string> choices;  ///< the only values there are, or none
  std::string default_text;          ///< or ""
  std::string help;
  bool is_value_optional = false;
  bool is_required = false;
  bool is_repeatable = false;
};

struct VerbEntry {
  std::string name;
  std::string summary;               ///< one sentence
  std::string text;                  ///< what help says below the options
  std::vector<OptionEntry> options;  ///< its own, in the order of the help
};

struct ProgramEntry {
  std::string name;                  ///< "octavo"
  std::string summary;
  std::string exit_codes;
  std::vector<OptionEntry> options;  ///< of every verb
  std::vector<VerbEntry> verbs;
};

/// The program as far as its verbs have been added.
ProgramEntry option_tree(const CLI::App& app);

std::vector<std::string> verb_names(const ProgramEntry& program);

/// The name of the program, and those of its verbs so far: for every start, which has no time for
/// the tree.
std::string program_name(const CLI::App& app);
std::vector<std::string> verb_names(const CLI::App& app);

}  // namespace octavo::cli
