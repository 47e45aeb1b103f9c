// The options of verbs: a thin layer over CLI11, whose headers are read by options.cpp and two
// other files alone, because every file that reads them pays seconds for it.
//
// Verb and Option are handles; copies speak of the same option. They live as long as the program's
// CLI::App.
#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <string>
#include <vector>

#include "common/context.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace octavo::cli {

/// A test of one word of the command line.
struct Check {
  std::function<std::string(const std::string&)> problem;  ///< "" where the word is right
  std::string shown;                                       ///< what help says of it, or ""
};

/// One of these words, or of these numbers.
Check one_of(std::vector<std::string> words);
Check one_of(std::initializer_list<int> numbers);
/// A number above 0.
Check above_zero();
/// A number of 0 or more.
Check not_negative();
/// A number in [minimum, maximum].
Check number_within(double minimum, double maximum);
/// A whole number in [minimum, maximum].
Check whole_within(std::int64_t minimum, std::int64_t maximum = INT64_MAX);

/// One option of a verb. Every member gives the option itself, so that calls can be chained.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}
  Option* operator->() { return this; }

  Option required();
  Option type_name(const std::string& name);
  Option group(const std::string& name);
  Option check(Check check);
  /// Not together with `other`.
  Option excludes(const Option& other);
  /// Whether one occurrence may be followed by several values (false: each value needs its own).
  Option allow_extra_args(bool allow);
  /// How many values one occurrence takes.
  Option expected(int minimum, int maximum);
  /// The default in the help: this text, or the value that the variable has now.
  Option default_str(const std::string& text);
  Option capture_default_str();

 private:
  CLI::Option* option_;
};

/// A verb, or the program itself, to which options are added.
class Verb {
 public:
  explicit Verb(CLI::App& app) : app_(&app) {}

  /// names     "-o,--output", or a name without dashes for a positional
  /// variable  std::string, int, std::int64_t, std::uint64_t or double, an optional of the first
  ///           three or double, or a vector of std::string, std::int64_t or double. It outlives the
  ///           parsing
  template <class T>
  Option add_option(const std::string& names, T& variable, const std::string& help);
  /// T is std::string or int.
  template <class T>
  Option add_option_function(const std::string& names, std::function<void(const T&)> take,
                             const std::string& help);
  /// An option that may be repeated, in any order with others of its kind: `take` gets each value
  /// as it is read.
  Option add_option_in_order(const std::string& names,
                             std::function<void(const std::string&)> take, const std::string& help);
  Option add_flag(const std::string& names, bool& variable, const std::string& help);

  /// The positional "file": an .8vo file or a URL of one.
  Option add_input(std::string& path);
  /// "-o,--output", which has to be given.
  Option add_output(std::string& path, const std::string& help);

  /// A group of flags of which exactly one has to be given.
  Verb add_choice(const std::string& name);

 private:
  CLI::App* app_;
};

struct VerbText {
  const char* name;
  const char* summary;   ///< one sentence
  const char* examples;  ///< shown below the options
};

/// Adds a verb whose work is `run`, with the global options; the caller adds its own. `run` returns
/// the exit code.
Verb add_verb(CLI::App& app, Context& context, const VerbText& text, std::function<int()> run);

/// Parses words of a verb that `add` declares, apart from those of the program.
/// Throws Error{invalid_argument} where they are not understood
void parse_words(const std::vector<std::string>& words, const std::function<void(CLI::App&)>& add);

/// The global options, which the program and every verb have.
void add_global_options(Verb verb, Context& context);

/// Has every option that takes a value refuse an empty one. Options first.
void refuse_empty_texts(CLI::App& app);

}  // namespace octavo::cli
