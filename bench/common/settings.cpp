#include "bench/common/settings.h"

#include <charconv>
#include <cstdio>
#include <exception>

#include "octavo/core/error.h"

namespace octavo::bench {
namespace {

int count_of(const std::string& option, const std::string& text) {
  int count = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, problem] = std::from_chars(text.data(), end, count);
  if (problem != std::errc() || stop != end || count < 1) {
    throw Error(ErrorKind::invalid_argument,
                option + ": '" + text + "'; expected a whole number of 1 or more");
  }
  return count;
}

}  // namespace

std::vector<std::string> take_settings(int count, char** words, Settings& settings) {
  std::vector<std::string> others;
  for (int i = 1; i < count; ++i) {
    const std::string word = words[i];
    if (word != "--commit" && word != "--rounds" && word != "--threads") {
      others.push_back(word);
      continue;
    }
    if (++i == count) throw Error(ErrorKind::invalid_argument, word + " has no value");
    if (word == "--commit") settings.commit = words[i];
    else (word == "--rounds" ? settings.rounds : settings.threads) = count_of(word, words[i]);
  }
  return others;
}

int run_named(const char* name, const std::function<void()>& work) {
  try {
    work();
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", name, error.what());
    return 1;
  }
}

}  // namespace octavo::bench
