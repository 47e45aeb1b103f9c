#include "text/manual_pages.h"

#include <fmt/format.h>

#include <string_view>

namespace octavo::cli {

namespace {

/// Text as roff takes it: no line is mistaken for a request, hyphens stay hyphens.
std::string roff(std::string_view text) {
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

std::string bold(std::string_view text) { return "\\fB" + roff(text) + "\\fR"; }
std::string italic(std::string_view text) { return "\\fI" + roff(text) + "\\fR"; }

std::string upper(std::string text) {
  for (char& c : text) c = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  return text;
}

std::string title(const std::string& name, const std::string& version) {
  return fmt::format(".TH {} 1 \"\" \"octavo {}\"\n", roff(name), version);
}

/// Lines that begin with a space stay as they are; the others are filled, a blank line parts them.
std::string paragraphs(std::string_view text) {
  std::string out;
  bool is_literal = false;
  bool starts_paragraph = false;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.empty()) {
      starts_paragraph = !out.empty();
      continue;
    }
    if (line.starts_with(' ') != is_literal) {
      out += is_literal ? ".fi\n" : ".nf\n";
      is_literal = !is_literal;
    }
    if (starts_paragraph) out += ".PP\n";
    starts_paragraph = false;
    out += roff(line) + "\n";
  }
  return is_literal ? out + ".fi\n" : out;
}

/// What stands below the options of a verb, in two parts: words, and examples.
std::pair<std::string_view, std::string_view> parts_of(const std::string& text) {
  for (const char* heading : {"Examples:\n", "Example:\n"}) {
    const std::size_t at = text.rfind(heading);
    if (at == std::string::npos) continue;
    const std::string_view all = text;
    return {all.substr(0, at), all.substr(at + std::string_view(heading).size())};
  }
  return {text, {}};
}

std::string option_entry(const OptionEntry& option) {
  std::string head;
  for (const std::string& name : option.names) head += (head.empty() ? "" : ", ") + bold(name);
  if (option.names.empty()) head = italic(option.word);
  const bool shows_value = !option.value.empty() && !option.names.empty();
  if (shows_value && option.is_value_optional) head += " [" + italic(option.value) + "]";
  else if (shows_value) head += " " + italic(option.value);

  std::string notes;
  const auto note = [&](const std::string& text) { notes += (notes.empty() ? "" : "; ") + text; };
  if (!option.choices.empty()) note(fmt::format("one of {}", fmt::join(option.choices, ", ")));
  if (!option.limits.empty()) note(option.limits);
  if (option.is_repeatable) note("may be repeated");
  if (!option.default_text.empty()) note("default " + option.default_text);
  if (option.is_required && !option.names.empty()) note("required");
  return fmt::format(".TP\n{}\n{}{}\n", head, roff(option.help),
                     notes.empty() ? "" : "\n(" + roff(notes) + ")");
}

std::string option_list(const std::vector<OptionEntry>& options) {
  std::string text;
  for (const OptionEntry& option : options) text += option_entry(option);
  return text;
}

/// "octavo build INPUTS... -o FILE [OPTIONS]": what has to be given, then what may be.
std::string synopsis(const ProgramEntry& program, const VerbEntry& verb) {
  std::string text = bold(program.name + " " + verb.name);
  bool has_more = false;
  for (const OptionEntry& option : verb.options) {
    const std::string dots = option.is_repeatable ? "..." : "";
    if (option.names.empty() && option.is_required) text += " " + italic(option.word) + dots;
    else if (option.names.empty()) text += " [" + italic(option.word) + dots + "]";
    else if (!option.is_required) has_more = true;
  }
  for (const OptionEntry& option : verb.options) {
    if (option.names.empty() || !option.is_required) continue;
    text += " " + bold(option.names.front()) + " " + italic(option.value);
  }
  return text + (has_more ? " [" + italic("OPTIONS") + "]" : "") + "\n";
}

}  // namespace

std::string program_page(const ProgramEntry& program, const std::string& version) {
  std::string text = title(upper(program.name), version);
  text += ".SH NAME\n" + roff(program.name) + " \\- " + roff(program.summary) + "\n";
  text += ".SH SYNOPSIS\n" + bold(program.name) + " " + italic("VERB") + " " + italic("INPUT") +
          "... [" + bold("-o") + " " + italic("OUTPUT") + "] [" + italic("OPTIONS") + "]\n";
  text += ".SH VERBS\nEach has a page of its own: " + bold(program.name + "-build") + "(1).\n";
  for (const VerbEntry& verb : program.verbs) {
    text += ".TP\n" + bold(verb.name) + "\n" + roff(verb.summary) + "\n";
  }
  text += ".SH OPTIONS OF EVERY VERB\n" + option_list(program.options);
  return text + ".SH EXIT STATUS\n" + paragraphs(program.exit_codes);
}

std::string verb_page(const ProgramEntry& program, const VerbEntry& verb,
                      const std::string& version) {
  const auto [words, examples] = parts_of(verb.text);
  std::string text = title(upper(program.name) + "-" + verb.name, version);
  text += ".SH NAME\n" + roff(program.name + "-" + verb.name) + " \\- " + roff(verb.summary) + "\n";
  text += ".SH SYNOPSIS\n" + synopsis(program, verb);
  if (!words.empty()) text += ".SH DESCRIPTION\n" + paragraphs(words);
  if (!verb.options.empty()) text += ".SH OPTIONS\n" + option_list(verb.options);
  text += ".SH OPTIONS OF EVERY VERB\n" + option_list(program.options);
  if (!examples.empty()) text += ".SH EXAMPLES\n" + paragraphs(examples);
  text += ".SH EXIT STATUS\n" + paragraphs(program.exit_codes);
  return text + ".SH SEE ALSO\n" + bold(program.name) + "(1)\n";
}

}  // namespace octavo::cli
