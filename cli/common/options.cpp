#include "common/options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/tasks/outputs.h"
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

/// "-o,--output" and "FILE" of "-o,--output FILE".
std::pair<std::string, std::string> names_and_value(const std::string& names) {
  const std::size_t blank = names.find(' ');
  if (blank == std::string::npos) return {names, ""};
  return {names.substr(0, blank), names.substr(blank + 1)};
}

/// "--output" of "-o,--output FILE": what messages call an option.
std::string long_name(const std::string& names) {
  const std::vector<std::string> all = split(names_and_value(names).first, ',');
  const auto is_long = [](const std::string& name) { return name.starts_with("--"); };
  const auto found = std::find_if(all.begin(), all.end(), is_long);
  return found == all.end() ? all.back() : *found;
}

/// The option with the name of its value, where it has one.
Option named(CLI::Option* option, const std::string& value) {
  if (!value.empty()) option->type_name(value);
  return Option(option);
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

Verb::Verb(CLI::App& app, Context& context)
    : app_(&app),
      context_(&context),
      steps_(std::make_shared<std::vector<std::function<void()>>>()) {}

template <class T>
Option Verb::add_option(const std::string& names, T& variable, const std::string& help) {
  const auto [words, value] = names_and_value(names);
  return named(app_->add_option(words, variable, help), value);
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

Option Verb::add_option_function(const std::string& names,
                                 std::function<void(const std::string&)> take,
                                 const std::string& help) {
  const auto [words, value] = names_and_value(names);
  return named(app_->add_option_function<std::string>(words, take, help), value);
}

Option Verb::add_option_in_order(const std::string& names, const std::string& help, TakeText take) {
  const auto [words, value] = names_and_value(names);
  CLI::Option* const option = app_->add_option_function<std::string>(
      words,
      [name = long_name(names), take = std::move(take)](const std::string& text) {
        take(text, name);
      },
      help);
  return named(option->trigger_on_parse(), value);
}

Option Verb::add_text(const std::string& names, const std::string& help, TakeText take) {
  const auto text = std::make_shared<std::string>();
  before_run([text, name = long_name(names), take = std::move(take)] {
    if (!text->empty()) take(*text, name);
  });
  return add_option(names, *text, help);
}

Option Verb::add_texts(const std::string& names, const std::string& help, TakeText take) {
  const auto texts = std::make_shared<std::vector<std::string>>();
  before_run([texts, name = long_name(names), take = std::move(take)] {
    for (const std::string& text : *texts) take(text, name);
  });
  return add_list(names, *texts, help);
}

Option Verb::add_flag(const std::string& names, bool& variable, const std::string& help) {
  return Option(app_->add_flag(names, variable, help));
}

Option Verb::add_switch(const std::string& names, const std::string& help,
                        std::function<void()> take) {
  const auto is_on = std::make_shared<bool>(false);
  before_run([is_on, take = std::move(take)] {
    if (*is_on) take();
  });
  return add_flag(names, *is_on, help);
}

Option Verb::add_off_flag(const std::string& names, bool& variable, const std::string& help) {
  return add_flag_of(names, variable, false, help);
}

Option Verb::add_input(std::string& path) {
  return add_option("file FILE", path, "An .8vo file or a URL of one").required();
}

Option Verb::add_output(Output& output, const std::string& help) {
  return add_output_option("-o,--output FILE", output, help).required();
}

Option Verb::add_output(std::string& path, const std::string& help) {
  return add_option("-o,--output FILE", path, help).required();
}

Option Verb::add_output_option(const std::string& names, Output& output, const std::string& help) {
  before_run([&output, this_context = context_] { output.overwrite = this_context->force; });
  return add_option(names, output.path, help);
}

Option Verb::add_output_option(const std::string& names, std::optional<Output>& output,
                               const std::string& help) {
  return add_parsed(
      names, output,
      [this_context = context_](const std::string& path) {
        return Output{path, this_context->force};
      },
      help);
}

std::function<bool()> Verb::add_together(const std::function<void()>& add) {
  const std::size_t before = app_->get_options().size();
  add();
  std::vector<const CLI::Option*> added;
  for (const CLI::Option* option : app_->get_options()) added.push_back(option);
  added.erase(added.begin(), added.begin() + static_cast<std::ptrdiff_t>(before));
  return [added] {
    return std::ranges::any_of(added, [](const auto* option) { return option->count() > 0; });
  };
}

std::function<void()> Verb::all_before_run() const {
  return [steps = steps_] {
    for (const auto& step : *steps) step();
  };
}

Verb Verb::add_choice(const std::string& name) {
  CLI::Option_group* const group = app_->add_option_group(name, "One of");
  group->require_option(1);
  Verb choice = *this;
  choice.app_ = group;
  return choice;
}

Verb add_verb(CLI::App& app, Context& context, const VerbText& text, std::function<int()> run) {
  CLI::App& verb = *app.add_subcommand(text.name, text.summary);
  verb.footer(text.examples);
  verb.group("Verbs");
  Verb added(verb, context);
  add_global_options(added, context);
  verb.callback([&context, name = std::string(text.name), work = std::move(run),
                 prepare = added.all_before_run()] {
    context.verb = name;
    context.run = [work, prepare] {
      prepare();
      return work();
    };
  });
  return added;
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
                usage_fault(problem.what()) + "; see octavo " + words.front() + " --help");
  }
}

void add_global_options(Verb verb, Context& context) {
  const std::string group = "Options of every verb";
  verb.add_flag("-q,--quiet", context.quiet, "Say nothing but warnings and errors").group(group);
  verb.add_flag("-v,--verbose", context.verbose, "Say what is being done").group(group);
  verb.add_flag("--json", context.json, "Print the result as one JSON object").group(group);
  verb.add_option_function(
          "--progress MODE",
          [&context](const std::string& name) { context.progress = kProgressModes.at(name); },
          "auto, bar, plain, json or none, on standard error")
      .check(one_of(names_of(kProgressModes)))
      .default_str("auto")
      .group(group);
  verb.add_option("-j,--threads N", context.threads, "Worker threads (default: all cores)")
      .check(whole_within(1, 1024))
      .group(group);
  verb.add_option_function(
          "--max-memory BYTES",
          [&context](const std::string& text) { context.max_memory_bytes = parse_bytes(text); },
          "Refuse work that needs more memory than this (500M, 2G)")
      .group(group);
  verb.add_option_function(
          "--max-voxels N",
          [&context](const std::string& text) { context.max_voxels = parse_voxel_count(text); },
          "Refuse to read or make a volume of more voxels than this (1e13)")
      .default_str("2^40")
      .group(group);
  verb.add_option("--timeout SECONDS", context.timeout_s,
                  "Give up on the server of a URL after so many seconds of silence, or of less "
                  "than 10 kB a second")
      .check(number_within(1, 86400))
      .capture_default_str()
      .group(group);
  verb.add_flag("-f,--force", context.force,
                "Replace output files that exist, or whose build was interrupted or still runs")
      .group(group);
  verb.add_flag("--strict", context.strict, "Treat warnings as errors").group(group);
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
