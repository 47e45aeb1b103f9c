// Work in parts: --part I/N -o FILE does one of them, --join FILE... says what all of them found.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "common/options.h"
#include "octavo/core/work_part.h"
#include "octavo/tasks/outputs.h"

namespace octavo::cli {

/// What such options stand under in the help.
inline constexpr const char* kPartGroup = "Parts, done on many machines or one after another";

struct PartArguments {
  std::string part;
  std::string output;
  std::vector<std::string> join;
};

/// Adds --part, -o and --join.
void add_part_options(Verb verb, PartArguments& arguments);

/// Adds --part and --join to a verb that has an -o of its own, and returns them in this order.
std::pair<Option, Option> add_part_and_join(Verb verb, PartArguments& arguments);

/// The part that is asked for, and where to put what it finds. Requires a --part.
/// Throws Error{invalid_argument}
WorkPart part_of(const PartArguments& arguments);
Output part_output(const PartArguments& arguments, const Context& context);

/// Throws Error{invalid_argument} for -o without --part.
void check_part_options(const PartArguments& arguments);

/// Says that a part was done. Takes the kind of things found and their number as JSON, and as text.
void print_part_result(const Context& context, const Output& output, const WorkPart& part,
                       const nlohmann::ordered_json& found, const std::string& found_text);

}  // namespace octavo::cli
