#include "text/completion_scripts.h"

#include <fmt/format.h>

#include <vector>

#include "text/offered_words.h"

namespace octavo::cli {

namespace {

std::string joined(const std::vector<std::string>& words, const char* separator) {
  return fmt::format("{}", fmt::join(words, separator));
}

/// The options of a verb, those of every verb behind them.
std::vector<OptionEntry> all_options(const ProgramEntry& program, const VerbEntry& verb) {
  std::vector<OptionEntry> options = verb.options;
  options.insert(options.end(), program.options.begin(), program.options.end());
  return options;
}

/// `text` between single quotes of bash and zsh.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'') out += "'\\''";
    else out += c;
  }
  return out + "'";
}

/// Every one of `special` in `text` behind a backslash.
std::string escaped_with(const std::string& text, const std::string& special) {
  std::string out;
  for (const char c : text) {
    if (special.find(c) != std::string::npos) out += '\\';
    out += c;
  }
  return out;
}

/// Of the function that completes: "_octavo".
std::string function_name(const ProgramEntry& program) {
  std::string name = "_" + program.name;
  for (char& c : name) {
    if (c == '-') c = '_';
  }
  return name;
}

/// Sets `names`, `words`, `values` and `files` of one verb.
std::string bash_case(const ProgramEntry& program, const VerbEntry& verb) {
  std::vector<std::string> names;
  std::vector<std::string> positional_words;
  std::string values;
  for (const OptionEntry& option : all_options(program, verb)) {
    names.insert(names.end(), option.names.begin(), option.names.end());
    const OfferedWords offered = offered_words(option);
    if (offered.words.empty()) continue;
    if (option.names.empty()) positional_words = offered.words;
    else if (!option.is_value_optional) {
      values += fmt::format("        {}) values='{}'{} ;;\n", joined(option.names, "|"),
                            joined(offered.words, " "), offered.has_files ? " files=1" : "");
    }
  }
  std::string text = fmt::format("    {})\n      names='{}'\n", verb.name, joined(names, " "));
  if (!positional_words.empty()) {
    text += fmt::format("      words='{}'\n", joined(positional_words, " "));
  }
  if (!values.empty()) text += "      case $previous in\n" + values + "      esac\n";
  return text + "      ;;\n";
}

std::string zsh_action(const OfferedWords& offered) {
  if (offered.words.empty()) return "_files";
  const std::string words = "(" + joined(offered.words, " ") + ")";
  if (!offered.has_files) return words;
  return R"({_alternative "words\:word\:)" + words + R"(" "files\:file\:_files"})";
}

std::string zsh_spec(const OptionEntry& option, const std::string& name) {
  std::string value;
  if (!option.value.empty()) {
    const std::string what = escaped_with(option.value, ":\\");
    const std::string action = zsh_action(offered_words(option));
    value = fmt::format("{}{}:{}", option.is_value_optional ? "::" : ":", what, action);
  }
  if (option.names.empty()) return quoted((option.is_repeatable ? "*" : "") + value);
  const bool is_long = name.starts_with("--");
  const std::string before = option.is_repeatable ? "*" : "(" + joined(option.names, " ") + ")";
  const std::string equals = value.empty() ? "" : is_long ? "=" : "+";
  return quoted(
      fmt::format("{}{}{}[{}]{}", before, name, equals, escaped_with(option.help, "[]\\"), value));
}

std::string zsh_case(const ProgramEntry& program, const VerbEntry& verb) {
  std::string text = fmt::format("    {})\n      _arguments -s", verb.name);
  for (const OptionEntry& option : all_options(program, verb)) {
    if (option.names.empty()) text += " \\\n        " + zsh_spec(option, "");
    for (const std::string& name : option.names) text += " \\\n        " + zsh_spec(option, name);
  }
  return text + "\n      ;;\n";
}

/// `text` between single quotes of fish.
std::string fish_quoted(const std::string& text) { return "'" + escaped_with(text, "'\\") + "'"; }

std::string fish_line(const ProgramEntry& program, const std::string& condition,
                      const OptionEntry& option) {
  std::string text = "complete -c " + program.name + " -n " + fish_quoted(condition);
  for (const std::string& name : option.names) {
    const bool is_long = name.starts_with("--");
    text += is_long ? " -l " + name.substr(2) : " -s " + name.substr(1);
  }
  const bool needs_value = !option.value.empty() && !option.is_value_optional;
  const OfferedWords offered = offered_words(option);
  if (!offered.words.empty()) {
    const char* files = offered.has_files ? "-r -F" : needs_value ? "-x" : "-f";
    text += fmt::format(" {} -a {}", files, fish_quoted(joined(offered.words, " ")));
  } else if (needs_value) {
    text += option.names.empty() ? " -F" : " -r -F";
  }
  return text + " -d " + fish_quoted(option.help) + "\n";
}

}  // namespace

std::string bash_completion(const ProgramEntry& program) {
  std::string cases;
  for (const VerbEntry& verb : program.verbs) cases += bash_case(program, verb);
  const std::vector<std::string> verbs = verb_names(program);
  return fmt::format(R"(# bash completion for {0}
{1}() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD-1]}}
  local verb='' names='' words='' values='' files='' word
  COMPREPLY=()
  # bash takes "--option=value" apart at the sign.
  if [[ $current == '=' ]]; then current=''
  elif [[ $previous == '=' ]]; then previous=${{COMP_WORDS[COMP_CWORD-2]}}
  fi
  for word in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
    case $word in
      {2}) verb=$word; break ;;
    esac
  done
  case $verb in
    '') words='{3}' ;;
{4}  esac
  if [[ -n $values ]]; then words=$values
  elif [[ $current == -* ]]; then words=$names
  fi
  if [[ -n $words ]]; then
    COMPREPLY=($(compgen -W "$words" -- "$current"))
  fi
  if [[ -z $words || -n $files ]]; then
    compopt -o filenames 2>/dev/null
    mapfile -t -O ${{#COMPREPLY[@]}} COMPREPLY < <(compgen -f -- "$current")
  fi
}}
complete -F {1} {0}
)",
                     program.name, function_name(program), joined(verbs, "|"),
                     joined(verbs, " "), cases);
}

std::string zsh_completion(const ProgramEntry& program) {
  std::string verbs;
  std::string cases;
  for (const VerbEntry& verb : program.verbs) {
    verbs += "    " + quoted(verb.name + ":" + escaped_with(verb.summary, ":\\")) + "\n";
    cases += zsh_case(program, verb);
  }
  return fmt::format(R"(#compdef {0}
{1}() {{
  local -a verbs=(
{2}  )
  if (( CURRENT == 2 )); then
    _describe -t verbs verb verbs
    return
  fi
  # _arguments takes the verb for the command.
  shift words
  (( CURRENT-- ))
  case $words[1] in
{3}  esac
}}
{1} "$@"
)",
                     program.name, function_name(program), verbs, cases);
}

std::string fish_completion(const ProgramEntry& program) {
  std::string text = "# fish completion for " + program.name + "\n";
  for (const VerbEntry& verb : program.verbs) {
    text += fmt::format("complete -c {} -n __fish_use_subcommand -f -a {} -d {}\n", program.name,
                        verb.name, fish_quoted(verb.summary));
  }
  for (const VerbEntry& verb : program.verbs) {
    for (const OptionEntry& option : verb.options) {
      text += fish_line(program, "__fish_seen_subcommand_from " + verb.name, option);
    }
  }
  const std::string any_verb = "__fish_seen_subcommand_from " + joined(verb_names(program), " ");
  for (const OptionEntry& option : program.options) text += fish_line(program, any_verb, option);
  return text;
}

}  // namespace octavo::cli
