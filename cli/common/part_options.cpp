#include "common/part_options.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "octavo/core/error.h"
#include "text/quantities.h"

namespace octavo::cli {

namespace {

WorkPart parse_part(const std::string& text, const std::string& option) {
  const std::vector<std::string> numbers = split(text, '/');
  if (numbers.size() != 2) {
    throw Error(ErrorKind::invalid_argument,
                option + ": '" + escaped(text) + "'; expected I/N, as in 0/8");
  }
  const WorkPart part = {parse_integer(numbers[0], option), parse_integer(numbers[1], option)};
  require_part(part);
  return part;
}

}  // namespace

void add_part_options(Verb verb, PartArguments& arguments) {
  add_part_and_join(verb, arguments);
  verb.add_output_option("-o,--output FILE", arguments.output, "Where --part puts what it found")
      .group(kPartGroup);
}

std::pair<Option, Option> add_part_and_join(Verb verb, PartArguments& arguments) {
  Option part =
      verb.add_parsed("--part I/N", arguments.part, parse_part, "Do part I of N alone, from 0")
          .group(kPartGroup);
  Option join =
      verb.add_option("--join FILE", arguments.join, "Say what these parts found together")
          .group(kPartGroup)
          .excludes(part);
  return {part, join};
}

const Output& PartArguments::output_of_part() const {
  if (output) return *output;
  throw Error(ErrorKind::invalid_argument, "--part needs -o FILE for what it finds");
}

void check_part_options(const PartArguments& arguments) {
  if (!arguments.output || arguments.part) return;
  throw Error(ErrorKind::invalid_argument, "-o goes with --part");
}

void print_part_result(const Context& context, const Output& output, const WorkPart& part,
                       const nlohmann::ordered_json& found, const std::string& found_text) {
  nlohmann::ordered_json object = {{"output", output.path}, {"part", {part.number, part.count}}};
  object.update(found);
  print_result(context, std::move(object),
               fmt::format("{}: part {} of {}: {}\n", shown_path(output.path), part.number,
                           part.count, found_text));
}

}  // namespace octavo::cli
