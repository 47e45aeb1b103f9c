// What the command lines of all benchmarks share.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace octavo::bench {

struct Settings {
  std::string commit = "unknown";
  int rounds = 5;
  int threads = 1;
};

/// Takes --commit ID, --rounds N and --threads N out of the words of a command line; gives the
/// others, in order.
/// Throws Error{invalid_argument} on a number below 1 or none, and on an option without its value.
std::vector<std::string> take_settings(int count, char** words, Settings& settings);

/// Runs a benchmark; what it throws is printed after its name. Gives the exit status.
int run_named(const char* name, const std::function<void()>& work);

}  // namespace octavo::bench
