// octavo completion and manual: made from the option tree, so that they cannot fall behind it.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include <memory>

#include "common/failure.h"
#include "common/options.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kCompletionText = {
    "completion", "Print a completion script for a shell.",
    "Examples:\n"
    "  octavo completion bash > /etc/bash_completion.d/octavo\n"
    "  eval \"$(octavo completion bash)\""};

constexpr VerbText kManualText = {"manual", "Print the manual page (roff).",
                                  "Example:\n"
                                  "  octavo manual | man -l -"};

std::vector<const CLI::App*> verbs_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

std::vector<const CLI::Option*> options_of(const CLI::App& verb) {
  return verb.get_options([](const CLI::Option*) { return true; });
}

/// "--level", "-o", "--output": what can be typed for an option; nothing for a positional.
std::vector<std::string> names_of(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back(fmt::format("-{}", name));
  for (const std::string& name : option.get_lnames()) names.push_back(fmt::format("--{}", name));
  return names;
}

std::string joined(const std::vector<std::string>& words, const std::string& separator) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : separator) + word;
  return text;
}

std::string bash_script(const CLI::App& app) {
  std::string cases;
  std::vector<std::string> verb_names;
  for (const CLI::App* verb : verbs_of(app)) {
    verb_names.push_back(verb->get_name());
    std::vector<std::string> words;
    for (const CLI::Option* option : options_of(*verb)) {
      for (const std::string& name : names_of(*option)) words.push_back(name);
    }
    cases += fmt::format("    {}) words='{}' ;;\n", verb->get_name(), joined(words, " "));
  }
  return fmt::format(R"(# bash completion for octavo
_octavo() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} words=''
  case ${{COMP_WORDS[1]}} in
{}  esac
  if [ "$COMP_CWORD" -eq 1 ]; then
    COMPREPLY=($(compgen -W '{}' -- "$current"))
  elif [[ $current == -* ]]; then
    COMPREPLY=($(compgen -W "$words" -- "$current"))
  else
    compopt -o filenames
    COMPREPLY=($(compgen -f -- "$current"))
  fi
}}
complete -F _octavo octavo
)",
                     cases, joined(verb_names, " "));
}

/// Text as roff takes it: no line is mistaken for a request, hyphens stay hyphens.
std::string roff(const std::string& text) {
  std::string out;
  bool at_line_start = true;
  for (const char c : text) {
    if (at_line_start && (c == '.' || c == '\'')) out += "\\&";
    if (c == '\\') out += "\\e";
    else if (c == '-') out += "\\-";
    else out += c;
    at_line_start = c == '\n';
  }
  return out;
}

std::string manual_entry(const CLI::Option& option) {
  std::string name = joined(names_of(option), ", ");
  if (name.empty()) name = option.get_name();
  const bool takes_value = option.get_items_expected_max() > 0;
  const std::string value = takes_value ? " \\fI" + roff(option.get_type_name()) + "\\fR" : "";
  return fmt::format(".TP\n\\fB{}\\fR{}\n{}\n", roff(name), value, roff(option.get_description()));
}

std::string manual_page(const CLI::App& app) {
  std::string text = ".TH OCTAVO 1 \"\" \"octavo " OCTAVO_VERSION "\"\n.SH NAME\noctavo \\- ";
  text += roff(app.get_description());
  text += "\n.SH SYNOPSIS\n\\fBoctavo\\fR \\fIVERB\\fR [\\fIOPTIONS\\fR] \\fIINPUT\\fR... "
          "[\\fB\\-o\\fR \\fIOUTPUT\\fR]\n.SH OPTIONS OF EVERY VERB\n";
  for (const CLI::Option* option : options_of(app)) text += manual_entry(*option);
  for (const CLI::App* verb : verbs_of(app)) {
    text += fmt::format(".SH {}\n{}\n", roff(verb->get_name()), roff(verb->get_description()));
    for (const CLI::Option* option : options_of(*verb)) {
      const bool is_of_every_verb = app.get_option_no_throw(option->get_name()) != nullptr;
      if (!is_of_every_verb) text += manual_entry(*option);
    }
    text += ".PP\n.nf\n" + roff(verb->get_footer()) + "\n.fi\n";
  }
  return text + ".SH EXIT STATUS\n.nf\n" + roff(app.get_footer()) + "\n.fi\n";
}

}  // namespace

void add_completion(CLI::App& app, Context& context) {
  const auto shell = std::make_shared<std::string>();
  Verb verb = add_verb(app, context, kCompletionText, [&app, shell] {
    print(bash_script(app));
    return kExitDone;
  });
  verb.add_option("shell", *shell, "bash")->required()->check(one_of({"bash"}));
}

void add_manual(CLI::App& app, Context& context) {
  add_verb(app, context, kManualText, [&app] {
    print(manual_page(app));
    return kExitDone;
  });
}

}  // namespace octavo::cli
