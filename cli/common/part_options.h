// Work in parts: --part I/N -o FILE does one of them, --join FILE... says what all of them found.
#pragma once

#include <optional>
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
  std::optional<WorkPart> part;  ///< that is asked for
  std::optional<Output> output;  ///< where to put what it finds
  std::vector<std::string> join;

  /// Throws Error{invalid_argument} without one.
  const Output& output_of_part() const;
};

/// Adds --part, -o and --join.
void add_part_options(Verb verb, PartArguments& arguments);

/// Adds --part and --join to a verb that has an -o of its own, and returns them in this order.
std::pair<Option, Option> add_part_and_join(Verb verb, PartArguments& arguments);

/// Throws Error{invalid_argument} for -o without --part.
void check_part_options(const PartArguments& arguments);

/// Says that a part was done. Takes the kind of things found and their number as JSON, and as text.
void print_part_result(const Context& context, const Output& output, const WorkPart& part,
                       const nlohmann::ordered_json& found, const std::string& found_text);

}  // namespace octavo::cli
