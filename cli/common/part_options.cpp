#include "common/part_options.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "octavo/core/error.h"
#include "text/quantities.h"

namespace octavo::cli {

void add_part_options(Verb verb, PartArguments& arguments) {
  add_part_and_join(verb, arguments);
  verb.add_option("-o,--output", arguments.output, "Where --part puts what it found")
      ->type_name("FILE")
      ->group(kPartGroup);
}

std::pair<Option, Option> add_part_and_join(Verb verb, PartArguments& arguments) {
  Option part = verb.add_option("--part", arguments.part, "Do part I of N alone, from 0");
  part->type_name("I/N")->group(kPartGroup);
  Option join = verb.add_option("--join", arguments.join, "Say what these parts found together");
  join->type_name("FILE")->group(kPartGroup)->excludes(part);
  return {part, join};
}

WorkPart part_of(const PartArguments& arguments) {
  const std::vector<std::string> numbers = split(arguments.part, '/');
  if (numbers.size() != 2) {
    throw Error(ErrorKind::invalid_argument,
                "--part: '" + escaped(arguments.part) + "'; expected I/N, as in 0/8");
  }
  const WorkPart part = {parse_integer(numbers[0], "--part"), parse_integer(numbers[1], "--part")};
  require_part(part);
  return part;
}

Output part_output(const PartArguments& arguments, const Context& context) {
  if (arguments.output.empty()) {
    throw Error(ErrorKind::invalid_argument, "--part needs -o FILE for what it finds");
  }
  return {arguments.output, context.force};
}

void check_part_options(const PartArguments& arguments) {
  if (arguments.output.empty() || !arguments.part.empty()) return;
  throw Error(ErrorKind::invalid_argument, "-o goes with --part");
}

void print_part_result(const Context& context, const Output& output, const WorkPart& part,
                       const nlohmann::ordered_json& found, const std::string& found_text) {
  nlohmann::ordered_json object = {{"output", output.path}, {"part", {part.number, part.count}}};
  object.update(found);
  print_result(context, std::move(object),
               fmt::format("{}: part {} of {}: {}\n", output.path, part.number, part.count,
                           found_text));
}

}  // namespace octavo::cli
