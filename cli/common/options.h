// The options of verbs: a thin layer over CLI11, whose headers are read by options.cpp,
// option_tree.cpp and the main.cpp of programs alone, because every file that reads them pays
// seconds for it.
//
// Verb and Option are handles; copies speak of the same option. They live as long as the program's
// CLI::App.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/context.h"
#include "octavo/core/option_words.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace octavo {
struct Output;
}

namespace octavo::cli {

/// A test of one word of the command line.
struct Check {
  std::function<std::string(const std::string&)> problem;  ///< "" where the word is right
  std::string shown;                                       ///< what help says of it, or ""
};

/// One of these words.
Check one_of(std::vector<std::string> words);
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

  Option required();
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

/// What a text of the command line stands for: parse(text, "--option") or parse(text).
template <class Parse>
auto parsed(const Parse& parse, const std::string& text, const std::string& option) {
  if constexpr (std::is_invocable_v<Parse, const std::string&, const std::string&>) {
    return parse(text, option);
  } else {
    return parse(text);
  }
}

/// The words that an option takes, and what each means.
template <class T>
using NamedValues = std::vector<NamedValue<T>>;

/// Those that an enumeration has.
template <class T>
NamedValues<T> all_words() {
  const auto words = option_words(T());
  return {words.begin(), words.end()};
}

/// One of them.
template <class T>
Check one_word_of(const NamedValues<T>& words) {
  std::vector<std::string> all;
  for (const auto& [word, meaning] : words) all.emplace_back(word);
  return one_of(std::move(all));
}

struct VerbText {
  const char* name;
  const char* summary;   ///< one sentence
  const char* examples;  ///< shown below the options
};

/// A verb, or the program itself, to which options are added.
///
/// Options are named as they are typed: "-o,--output FILE", "--csv" for a flag, "mask FILE" for a
/// word without dashes. Variables outlive the parsing. What parse functions and outputs make of
/// texts is there when the verb runs, and what is wrong with them is said then.
class Verb {
 public:
  using TakeText = std::function<void(const std::string& text, const std::string& name)>;

  Verb(CLI::App& app, Context& context);

  /// variable  std::string, int, std::int64_t, std::uint64_t, std::size_t or double, an optional of
  ///           std::string, int, std::int64_t or double, or a vector of std::string, std::int64_t
  ///           or double
  template <class T>
  Option add_option(const std::string& names, T& variable, const std::string& help);
  /// `take` gets the text as it is read.
  Option add_option_function(const std::string& names,
                             std::function<void(const std::string&)> take,
                             const std::string& help);
  /// An option that may be repeated, in any order with others of its kind: `take` gets each value
  /// as it is read.
  Option add_option_in_order(const std::string& names, const std::string& help, TakeText take);
  /// Of which `value` becomes what `parse` makes, where it is given.
  template <class T, class Parse>
  Option add_parsed(const std::string& names, T& value, Parse parse, const std::string& help) {
    return add_text(names, help, [&value, parse](const std::string& text, const std::string& name) {
      value = parsed(parse, text, name);
    });
  }
  /// An option that may be repeated, with one value each time.
  template <class T>
  Option add_list(const std::string& names, std::vector<T>& values, const std::string& help) {
    return add_option(names, values, help).allow_extra_args(false);
  }
  template <class T, class Parse>
  Option add_list(const std::string& names, std::vector<T>& values, Parse parse,
                  const std::string& help) {
    return add_texts(names, help,
                     [&values, parse](const std::string& text, const std::string& name) {
                       values.push_back(parsed(parse, text, name));
                     });
  }
  /// One of some words. The help shows which of them is the value now, of an optional none.
  template <class T>
  Option add_word(const std::string& names, T& value,
                  const NamedValues<std::type_identity_t<T>>& words, const std::string& help) {
    Option option = add_word_of(names, value, words, help);
    for (const auto& [word, meaning] : words) {
      if (meaning == value) option.default_str(word);
    }
    return option;
  }
  template <class T>
  Option add_word(const std::string& names, std::optional<T>& value,
                  const NamedValues<std::type_identity_t<T>>& words, const std::string& help) {
    return add_word_of(names, value, words, help);
  }
  /// One of the words that an enumeration has: core/option_words.h.
  template <class T>
  Option add_word(const std::string& names, T& value, const std::string& help) {
    return add_word(names, value, all_words<T>(), help);
  }
  template <class T>
  Option add_word(const std::string& names, std::optional<T>& value, const std::string& help) {
    return add_word(names, value, all_words<T>(), help);
  }
  /// `take` gets the text that is given, or each of them.
  Option add_text(const std::string& names, const std::string& help, TakeText take);
  Option add_texts(const std::string& names, const std::string& help, TakeText take);
  Option add_flag(const std::string& names, bool& variable, const std::string& help);
  /// A flag that makes `value` what it means.
  template <class T>
  Option add_flag_of(const std::string& names, T& value, std::type_identity_t<T> meaning,
                     const std::string& help) {
    return add_switch(names, help, [&value, meaning] { value = meaning; });
  }
  /// A flag that makes `variable` false.
  Option add_off_flag(const std::string& names, bool& variable, const std::string& help);

  /// The positional "file": an .8vo file or a URL of one.
  Option add_input(std::string& path);
  /// "-o,--output", which has to be given. --force lets it be replaced.
  Option add_output(Output& output, const std::string& help);
  Option add_output(std::string& path, const std::string& help);
  /// A file that is written besides, or instead of nothing.
  Option add_output_option(const std::string& names, Output& output, const std::string& help);
  Option add_output_option(const std::string& names, std::optional<Output>& output,
                           const std::string& help);

  /// Whether one of the options is given that `add` adds; to be asked when the verb runs.
  std::function<bool()> add_together(const std::function<void()>& add);

  /// A group of flags of which exactly one has to be given.
  Verb add_choice(const std::string& name);

  /// Has `step` done before the verb runs, after the steps that were added before.
  void before_run(std::function<void()> step) { steps_->push_back(std::move(step)); }
  /// Does them all, those that are added later as well.
  std::function<void()> all_before_run() const;

 private:
  Option add_switch(const std::string& names, const std::string& help, std::function<void()> take);
  template <class T, class Value>
  Option add_word_of(const std::string& names, T& value, const NamedValues<Value>& words,
                     const std::string& help) {
    return add_text(names, help,
                    [&value, words](const std::string& text, const std::string&) {
                      for (const auto& [word, meaning] : words) {
                        if (text == word) value = meaning;
                      }
                    })
        .check(one_word_of(words));
  }

  CLI::App* app_;
  Context* context_;
  std::shared_ptr<std::vector<std::function<void()>>> steps_;
};

/// Adds a verb whose work is `run`, with the global options; the caller adds its own. `run` returns
/// the exit code.
Verb add_verb(CLI::App& app, Context& context, const VerbText& text, std::function<int()> run);

template <class Arguments>
struct VerbWith {
  Verb verb;
  Arguments& arguments;  ///< of the work: options are added to them
};

/// Adds a verb whose work is run(arguments, context).
template <class Arguments>
VerbWith<Arguments> add_verb(CLI::App& app, Context& context, const VerbText& text,
                             int (*run)(const Arguments&, Context&)) {
  const auto arguments = std::make_shared<Arguments>();
  return {
      add_verb(app, context, text, [run, arguments, &context] { return run(*arguments, context); }),
      *arguments};
}

/// Parses words of a verb that `add` declares, apart from those of the program.
/// Throws Error{invalid_argument} where they are not understood
void parse_words(const std::vector<std::string>& words, const std::function<void(CLI::App&)>& add);

/// The global options, which the program and every verb have.
void add_global_options(Verb verb, Context& context);

/// Has every option that takes a value refuse an empty one. Options first.
void refuse_empty_texts(CLI::App& app);

}  // namespace octavo::cli
