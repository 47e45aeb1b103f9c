#include "common/option_tree.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string_view>

namespace octavo::cli {

namespace {

/// "{small,fast}" as its words; nothing for other texts.
std::vector<std::string> words_in_braces(std::string_view text) {
  std::vector<std::string> words;
  if (!text.starts_with('{') || !text.ends_with('}')) return words;
  text = text.substr(1, text.size() - 2);
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(','), text.size());
    words.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return words;
}

/// What the checks of an option say of its values, in the order in which help shows them.
std::vector<std::string> shown_checks(const CLI::Option& option) {
  // CLI11 counts its checks for nobody, and gives them to owners of the option alone.
  auto& owned = const_cast<CLI::Option&>(option);
  std::vector<std::string> shown;
  try {
    for (int i = 0;; ++i) shown.push_back(owned.get_validator(i)->get_description());
  } catch (const CLI::OptionNotFound&) {
    std::erase(shown, "");
  }
  return shown;
}

OptionEntry entry_of(const CLI::Option& option) {
  OptionEntry entry;
  for (const std::string& name : option.get_snames()) entry.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) entry.names.push_back("--" + name);
  if (entry.names.empty()) entry.word = option.get_name();
  entry.help = option.get_description();
  entry.is_required = option.get_required();
  if (option.get_items_expected_max() == 0) return entry;

  entry.value = option.get_type_name();
  const std::vector<std::string> checks = shown_checks(option);
  for (auto check = checks.rbegin(); check != checks.rend(); ++check) {
    // get_type_name puts ":CHECK" behind the name for each of them.
    entry.value.resize(entry.value.size() - check->size() - 1);
    const std::vector<std::string> words = words_in_braces(*check);
    if (words.empty()) entry.limits = *check;
    else entry.choices = words;
  }
  entry.is_value_optional = option.get_items_expected_min() == 0 || entry.value.starts_with('[');
  std::erase_if(entry.value, [](char c) { return c == '[' || c == ']'; });
  entry.default_text = option.get_default_str();
  entry.is_repeatable = option.get_items_expected_max() > 1;
  return entry;
}

std::vector<const CLI::App*> subcommands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

/// The options of an application and of the nameless groups in it.
void add_options(const CLI::App& app, std::vector<const CLI::Option*>& options) {
  for (const CLI::Option* option : app.get_options([](const CLI::Option*) { return true; })) {
    options.push_back(option);
  }
  for (const CLI::App* group : subcommands_of(app)) {
    if (group->get_name().empty()) add_options(*group, options);
  }
}

}  // namespace

std::string program_name(const CLI::App& app) { return app.get_name(); }

ProgramEntry option_tree(const CLI::App& app) {
  ProgramEntry program{program_name(app), app.get_description(), app.get_footer(), {}, {}};
  std::vector<const CLI::Option*> of_program;
  add_options(app, of_program);
  for (const CLI::Option* option : of_program) {
    // The version is asked of the program, never of a verb.
    if (option != app.get_version_ptr()) program.options.push_back(entry_of(*option));
  }

  for (const CLI::App* app_of_verb : subcommands_of(app)) {
    VerbEntry verb{
        app_of_verb->get_name(), app_of_verb->get_description(), app_of_verb->get_footer(), {}};
    std::vector<const CLI::Option*> of_verb;
    add_options(*app_of_verb, of_verb);
    for (const CLI::Option* option : of_verb) {
      if (app.get_option_no_throw(option->get_name()) != nullptr) continue;
      verb.options.push_back(entry_of(*option));
    }
    program.verbs.push_back(std::move(verb));
  }
  return program;
}

std::vector<std::string> verb_names(const ProgramEntry& program) {
  std::vector<std::string> names;
  for (const VerbEntry& verb : program.verbs) names.push_back(verb.name);
  return names;
}

std::vector<std::string> verb_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* verb : subcommands_of(app)) names.push_back(verb->get_name());
  return names;
}

}  // namespace octavo::cli
