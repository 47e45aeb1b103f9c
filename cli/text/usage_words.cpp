#include "text/usage_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <optional>
#include <string_view>

#include "octavo/core/error.h"
#include "text/quantities.h"

namespace octavo::cli {

namespace {

std::string lower(std::string word) {
  std::transform(word.begin(), word.end(), word.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return word;
}

/// Letters to insert, drop, replace or exchange with their neighbor until `a` is `b`.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> before_last, last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({replaced, last[j] + 1, row[j - 1] + 1});
      const bool is_exchanged = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (is_exchanged) row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
    before_last = last;
    last = row;
  }
  return last[b.size()];
}

bool is_number(const std::string& word) {
  const bool has_sign = !word.empty() && (word[0] == '-' || word[0] == '+');
  const std::string digits = word.substr(has_sign ? 1 : 0);
  return !digits.empty() && digits.find_first_not_of("0123456789.") == std::string::npos;
}

/// "1,2,3"
bool is_place(const std::string& word) {
  const std::size_t first = word.find(',');
  const std::size_t second = word.find(',', first + 1);
  return first != std::string::npos && second != std::string::npos &&
         is_number(word.substr(0, first)) &&
         is_number(word.substr(first + 1, second - first - 1)) &&
         is_number(word.substr(second + 1));
}

bool is_option(const std::string& word) {
  return word.size() > 1 && word[0] == '-' && !is_number(word) && word != "--" &&
         std::isalpha(static_cast<unsigned char>(word[word[1] == '-' ? 2 : 1])) != 0;
}

const VerbEntry* verb_named(const ProgramEntry& program, const std::string& name) {
  const auto found = std::find_if(program.verbs.begin(), program.verbs.end(),
                                  [&](const VerbEntry& verb) { return verb.name == name; });
  return found == program.verbs.end() ? nullptr : &*found;
}

/// The names of the options of a verb and of the program, and the option that a name is of.
struct OptionNames {
  std::vector<std::string> all = {"-h", "--help"};
  std::vector<const OptionEntry*> of = {nullptr, nullptr};

  void add(const std::vector<OptionEntry>& options) {
    for (const OptionEntry& option : options) {
      for (const std::string& name : option.names) {
        all.push_back(name);
        of.push_back(&option);
      }
    }
  }

  std::optional<std::size_t> place_of(const std::string& name) const {
    const auto found = std::find(all.begin(), all.end(), name);
    if (found == all.end()) return std::nullopt;
    return static_cast<std::size_t>(found - all.begin());
  }
};

std::string with_nearest(const std::string& problem, const std::string& word,
                         const std::vector<std::string>& known) {
  const std::string nearest = nearest_word(word, known);
  return nearest.empty() ? problem : problem + "; did you mean " + nearest + "?";
}

/// "--at" of "--at=1,2,3"; "-o" of "-ofile" where there is such an option.
std::string option_name(const std::string& word, const OptionNames& names) {
  if (word.starts_with("--")) return word.substr(0, word.find('='));
  const std::string letter = word.substr(0, 2);
  return names.place_of(letter) ? letter : word;
}

/// Makes three numbers from `i` on one word; whether a place stands there then.
bool join_place(std::vector<std::string>& words, std::size_t i) {
  if (i < words.size() && is_place(words[i])) return true;
  if (i + 2 >= words.size()) return false;
  if (!is_number(words[i]) || !is_number(words[i + 1]) || !is_number(words[i + 2])) return false;
  words[i] += "," + words[i + 1] + "," + words[i + 2];
  const auto place = words.begin() + static_cast<std::ptrdiff_t>(i);
  words.erase(place + 1, place + 3);
  return true;
}

}  // namespace

std::vector<std::string> settled_words(std::vector<std::string> words) {
  if (!words.empty() && words.front() == "help") {
    words.erase(words.begin());
    words.push_back("--help");
  }
  if (words.empty() || words.front() != "probe") return words;
  for (std::size_t i = 1; i < words.size(); ++i) {
    if (words[i] != "--at" && words[i] != "--mm") continue;
    if (!join_place(words, i + 1) || !join_place(words, i + 2)) continue;
    const std::string option = words[i];
    words.insert(words.begin() + static_cast<std::ptrdiff_t>(i) + 2, option);
  }
  return words;
}

std::string nearest_word(const std::string& word, const std::vector<std::string>& known) {
  std::string nearest;
  std::size_t smallest = std::max<std::size_t>(1, word.size() / 3) + 1;
  for (const std::string& other : known) {
    const std::size_t distance = edit_distance(lower(word), lower(other));
    if (distance >= smallest) continue;
    smallest = distance;
    nearest = other;
  }
  return nearest;
}

std::string unknown_word(const ProgramEntry& program, const std::vector<std::string>& words) {
  OptionNames names;
  names.add(program.options);
  const VerbEntry* verb = nullptr;
  for (auto word = words.begin(); word != words.end() && *word != "--"; ++word) {
    // The verb comes first, behind options of the program at most
    if (!is_option(*word) && verb != nullptr) continue;
    if (!is_option(*word)) {
      verb = verb_named(program, *word);
      if (verb == nullptr) {
        return with_nearest("no verb '" + escaped(*word) + "'", *word, verb_names(program));
      }
      names.add(verb->options);
      continue;
    }
    // An option; what follows one that takes a value is that value
    const std::string name = option_name(*word, names);
    const std::optional<std::size_t> place = names.place_of(name);
    if (!place) return with_nearest("no option " + escaped(name), name, names.all);
    const OptionEntry* const option = names.of[*place];
    const bool has_value = option != nullptr && !option->value.empty() &&
                           !option->is_value_optional && name == *word;
    if (has_value && std::next(word) != words.end()) ++word;
  }
  return "";
}

std::string usage_fault(const std::string& said) {
  // "--size: At Most 1 required but received 2"
  constexpr std::string_view kTwice = ": At Most 1 required but received ";
  if (const std::size_t at = said.find(kTwice); at != std::string::npos) {
    return fmt::format("{} is given {} times; give it once", said.substr(0, at),
                       said.substr(at + kTwice.size()));
  }
  // "Exactly 1 option from [--union,--xor] is required", " and 2 were given" where there are more
  constexpr std::string_view kNoneOf = "Exactly 1 option from [";
  constexpr std::string_view kRequired = "] is required";
  const std::size_t end = said.rfind(kRequired);
  if (!said.starts_with(kNoneOf) || end == std::string::npos) return said;
  std::string names;
  for (const std::string& name : split(said.substr(kNoneOf.size(), end - kNoneOf.size()), ',')) {
    names += (names.empty() ? "" : ", ") + name;
  }
  const bool are_several = end + kRequired.size() < said.size();
  return "give one of " + names + (are_several ? ", no more" : "");
}

}  // namespace octavo::cli
