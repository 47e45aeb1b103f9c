// The options of `codes` and what it prints, for every program that has the verb.
#pragma once

#include "common/context.h"
#include "common/options.h"
#include "octavo/tasks/files/codes.h"

namespace octavo::cli {

struct CodesArguments {
  CodesOptions options;
  bool is_list = false;
  bool is_counts = false;
};

void add_codes_options(Verb verb, CodesArguments& arguments);

/// Throws Error{invalid_argument} where options do not go together
CodesOptions codes_options(const CodesArguments& arguments, const Context& context);

void print_codes(const CodesResult& result, const CodesArguments& arguments,
                 const Context& context);

}  // namespace octavo::cli
