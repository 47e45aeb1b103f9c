#include "common/options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "octavo/core/error.h"
#include "text/quantities.h"
#include "text/usage_words.h"

namespace octavo::cli {

namespace {

const std::map<std::string, ProgressMode> kProgressModes = {
    {"auto", ProgressMode::automatic}, {"bar", ProgressMode::bar},   {"plain", ProgressMode::plain},
    {"json", ProgressMode::json},      {"none", ProgressMode::none},
};

std::vector<std::string> names_of(const std::map<std::string, ProgressMode>& modes) {
  std::vector<std::string> names;
  for (const auto& [name, mode] : modes) names.push_back(name);
  return names;
}

/// A check of one number, of which `expected` says in words what it must be.
template <class Number, class Parse>
Check number_check(const std::string& expected, const std::string& shown, Parse parse,
                   std::function<bool(Number)> is_right) {
  return {[=](const std::string& text) -> std::string {
            try {
              if (is_right(parse(text, ""))) return "";
            } catch (const Error&) {
              // Not a number at all: the same is expected.
            }
            return fmt::format("{}; expected {}", escaped(text), expected);
          },
          shown};
}

Check real_check(const std::string& expected, const std::string& shown,
                 std::function<bool(double)> is_right) {
  return number_check<double>(expected, shown, parse_number, std::move(is_right));
}

}  // namespace

Check one_of(std::vector<std::string> words) {
  const std::string all = fmt::format("{{{}}}", fmt::join(words, ","));
  return {[words = std::move(words), all](const std::string& word) -> std::string {
            if (std::find(words.begin(), words.end(), word) != words.end()) return "";
            return word + " not in " + all;
          },
          all};
}

Check one_of(std::initializer_list<int> numbers) {
  std::vector<std::string> words;
  for (const int number : numbers) words.push_back(std::to_string(number));
  return one_of(std::move(words));
}

Check above_zero() {
  return real_check("a number above 0", "above 0", [](double value) { return value > 0; });
}

Check not_negative() {
  return real_check("a number of 0 or more", "0 or more", [](double value) { return value >= 0; });
}

Check number_within(double minimum, double maximum) {
  const std::string ends = number_text(minimum) + " to " + number_text(maximum);
  return real_check("a number, " + ends, ends,
                    [=](double value) { return value >= minimum && value <= maximum; });
}

Check whole_within(std::int64_t minimum, std::int64_t maximum) {
  const bool is_open = maximum == INT64_MAX;
  const std::string ends =
      is_open ? fmt::format("{} or more", minimum) : fmt::format("{} to {}", minimum, maximum);
  return number_check<std::int64_t>(
      "a whole number" + std::string(is_open ? " of " : ", ") + ends, ends, parse_integer,
      [=](std::int64_t value) { return value >= minimum && value <= maximum; });
}

Option Option::required() {
  option_->required();
  return *this;
}

Option Option::type_name(const std::string& name) {
  option_->type_name(name);
  return *this;
}

Option Option::group(const std::string& name) {
  option_->group(name);
  return *this;
}

Option Option::check(Check check) {
  option_->check(CLI::Validator([problem = std::move(check.problem)](
                                    std::string& word) { return problem(word); },
                                check.shown));
  return *this;
}

Option Option::excludes(const Option& other) {
  option_->excludes(other.option_);
  return *this;
}

Option Option::allow_extra_args(bool allow) {
  option_->allow_extra_args(allow);
  return *this;
}

Option Option::expected(int minimum, int maximum) {
  option_->expected(minimum, maximum);
  return *this;
}

Option Option::default_str(const std::string& text) {
  option_->default_str(text);
  return *this;
}

Option Option::capture_default_str() {
  option_->capture_default_str();
  return *this;
}

template <class T>
Option Verb::add_option(const std::string& names, T& variable, const std::string& help) {
  return Option(app_->add_option(names, variable, help));
}

template Option Verb::add_option(const std::string&, std::string&, const std::string&);
template Option Verb::add_option(const std::string&, int&, const std::string&);
template Option Verb::add_option(const std::string&, std::int64_t&, const std::string&);
template Option Verb::add_option(const std::string&, std::uint64_t&, const std::string&);
template Option Verb::add_option(const std::string&, double&, const std::string&);
template Option Verb::add_option(const std::string&, std::optional<std::string>&,
                                 const std::string&);
template Option Verb::add_option(const std::string&, std::optional<int>&, const std::string&);
template Option Verb::add_option(const std::string&, std::optional<std::int64_t>&,
                                 const std::string&);
template Option Verb::add_option(const std::string&, std::optional<double>&, const std::string&);
template Option Verb::add_option(const std::string&, std::vector<std::string>&,
                                 const std::string&);
template Option Verb::add_option(const std::string&, std::vector<std::int64_t>&,
                                 const std::string&);
template Option Verb::add_option(const std::string&, std::vector<double>&, const std::string&);

template <class T>
Option Verb::add_option_function(const std::string& names, std::function<void(const T&)> take,
                                 const std::string& help) {
  return Option(app_->add_option_function<T>(names, take, help));
}

template Option Verb::add_option_function(const std::string&,
                                          std::function<void(const std::string&)>,
                                          const std::string&);
template Option Verb::add_option_function(const std::string&, std::function<void(const int&)>,
                                          const std::string&);

Option Verb::add_option_in_order(const std::string& names,
                                 std::function<void(const std::string&)> take,
                                 const std::string& help) {
  return Option(app_->add_option_function<std::string>(names, std::move(take), help)
                    ->trigger_on_parse());
}

Option Verb::add_flag(const std::string& names, bool& variable, const std::string& help) {
  return Option(app_->add_flag(names, variable, help));
}

Option Verb::add_input(std::string& path) {
  return add_option("file", path, "An .8vo file or a URL of one").type_name("FILE").required();
}

Option Verb::add_output(std::string& path, const std::string& help) {
  return add_option("-o,--output", path, help).type_name("FILE").required();
}

Verb Verb::add_choice(const std::string& name) {
  CLI::Option_group* const group = app_->add_option_group(name, "One of");
  group->require_option(1);
  return Verb(*group);
}

Verb add_verb(CLI::App& app, Context& context, const VerbText& text, std::function<int()> run) {
  CLI::App& verb = *app.add_subcommand(text.name, text.summary);
  verb.footer(text.examples);
  verb.group("Verbs");
  verb.callback([&context, name = std::string(text.name), work = std::move(run)] {
    context.verb = name;
    context.run = work;
  });
  add_global_options(Verb(verb), context);
  return Verb(verb);
}

void parse_words(const std::vector<std::string>& words, const std::function<void(CLI::App&)>& add) {
  CLI::App app;
  app.require_subcommand(1);
  add(app);
  refuse_empty_texts(app);
  std::vector<std::string> reversed = settled_words(words);
  std::reverse(reversed.begin(), reversed.end());
  try {
    app.parse(reversed);
  } catch (const CLI::Success&) {
    throw Error(ErrorKind::invalid_argument, "see octavo " + words.front() + " --help");
  } catch (const CLI::ParseError& problem) {
    throw Error(ErrorKind::invalid_argument,
                std::string(problem.what()) + "; see octavo " + words.front() + " --help");
  }
}

void add_global_options(Verb verb, Context& context) {
  const std::string group = "Options of every verb";
  verb.add_flag("-q,--quiet", context.quiet, "Say nothing but warnings and errors")->group(group);
  verb.add_flag("-v,--verbose", context.verbose, "Say what is being done")->group(group);
  verb.add_flag("--json", context.json, "Print the result as one JSON object")->group(group);
  verb.add_option_function<std::string>(
          "--progress",
          [&context](const std::string& name) { context.progress = kProgressModes.at(name); },
          "auto, bar, plain, json or none, on standard error")
      ->type_name("MODE")
      ->check(one_of(names_of(kProgressModes)))
      ->default_str("auto")
      ->group(group);
  verb.add_option("-j,--threads", context.threads, "Worker threads (default: all cores)")
      ->type_name("N")
      ->check(whole_within(1, 1024))
      ->group(group);
  verb.add_option_function<std::string>(
          "--max-memory",
          [&context](const std::string& text) { context.max_memory_bytes = parse_bytes(text); },
          "Refuse work that needs more memory than this (500M, 2G)")
      ->type_name("BYTES")
      ->group(group);
  verb.add_option_function<std::string>(
          "--max-voxels",
          [&context](const std::string& text) { context.max_voxels = parse_voxel_count(text); },
          "Refuse to read or make a volume of more voxels than this (1e13)")
      ->type_name("N")
      ->default_str("2^40")
      ->group(group);
  verb.add_option("--timeout", context.timeout_s,
                  "Give up on the server of a URL after so many seconds of silence, or of less "
                  "than 10 kB a second")
      ->type_name("SECONDS")
      ->check(number_within(1, 86400))
      ->capture_default_str()
      ->group(group);
  verb.add_flag("-f,--force", context.force,
                "Replace output files that exist, or whose build was interrupted or still runs")
      ->group(group);
  verb.add_flag("--strict", context.strict, "Treat warnings as errors")->group(group);
}

void refuse_empty_texts(CLI::App& app) {
  for (CLI::Option* option : app.get_options()) {
    if (option->get_items_expected_max() == 0) continue;
    // A transformation that changes nothing: those run before all checks.
    option->transform(CLI::Validator(
        [type = option->get_type_name()](std::string& text) {
          return text.empty() ? "is empty; expected " + type : std::string();
        },
        ""));
  }
  for (CLI::App* verb : app.get_subcommands([](CLI::App*) { return true; })) {
    refuse_empty_texts(*verb);
  }
}

}  // namespace octavo::cli
