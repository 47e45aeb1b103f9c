// The options of `codes` and what it prints, for every program that has the verb.
#pragma once

#include <string>
#include <vector>

#include "common/context.h"
#include "common/options.h"
#include "octavo/tasks/files/codes.h"

namespace octavo::cli {

struct CodesArguments {
  std::string input;
  int level = 0;
  std::vector<std::string> labels;
  std::string range;
  std::string notation = "mixed";
  std::string neighbors;
  bool list = false;
  bool counts = false;
};

void add_codes_options(Verb verb, CodesArguments& arguments);

/// Throws Error{invalid_argument} naming the option that cannot be understood
CodesOptions codes_options(const CodesArguments& arguments, const Context& context);

void print_codes(const CodesResult& result, const CodesArguments& arguments,
                 const Context& context);

}  // namespace octavo::cli
