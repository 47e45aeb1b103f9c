#include "octavo/tasks/components/component_numbers.h"

#include <charconv>
#include <limits>

#include "octavo/core/error.h"
#include "octavo/core/sha256.h"
#include "octavo/core/text.h"
#include "octavo/core/url_text.h"
#include "octavo/tasks/files/part_result.h"

namespace octavo {

namespace {

constexpr const char* kNumbersKind = "numbers of components";

[[noreturn]] void fail_numbers(const std::string& path, const std::string& why) {
  throw Error(ErrorKind::corrupt, "no numbers of components, or damaged: " + why, path);
}

double number_of_text(const std::string& text, const std::string& path) {
  double number = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (failure == std::errc() && end == text.data() + text.size() && number >= 0) return number;
  fail_numbers(path, "its smallest volume is none");
}

/// What the lines of the file at `path` say.
ComponentNumbers numbers_of(const FoundPart& file, const FileReader& mask,
                            const std::string& path) {
  if (file.lines.empty()) fail_numbers(path, "it is empty");
  const JsonObject& head = file.lines.front();
  ComponentNumbers numbers;
  const std::int64_t connectivity = integers_in(head, "connectivity", 1).front();
  if (connectivity != 6 && connectivity != 18 && connectivity != 26) {
    fail_numbers(path, "its connectivity is none");
  }
  numbers.options.connectivity = static_cast<Connectivity>(connectivity);
  if (head.json_of("mask_digest") !=
      question_of(mask, numbers.options.connectivity).json_of("mask_digest")) {
    throw Error(ErrorKind::invalid_argument,
                "numbers the components of another mask than " +
                    public_name(mask.source().name()),
                path);
  }
  numbers.options.keep_largest = integers_in(head, "keep_largest", 1).front();
  numbers.options.min_mm3 = number_of_text(text_in(head, "min_mm3"), path);
  const auto counts = integers_in(head, "counts", 3);
  const bool is_usable = numbers.options.keep_largest >= 0 && counts[1] >= 0 &&
                         counts[1] <= counts[0] &&
                         counts[0] <= std::numeric_limits<std::uint32_t>::max() &&
                         counts[2] >= 1 && counts[2] <= WorkPart::kMostParts;
  if (!is_usable) fail_numbers(path, "its counts are none");
  numbers.found = static_cast<std::size_t>(counts[0]);
  numbers.kept = static_cast<std::size_t>(counts[1]);
  numbers.labels = labels_of_lines(std::span(file.lines).subspan(1), counts[2], numbers.kept);
  return numbers;
}

}  // namespace

JsonObject question_of(const FileReader& mask, Connectivity connectivity) {
  JsonObject question;
  question.set("mask_digest", hex_text(mask.voxel_digest()));
  question.set("connectivity", std::vector<int>{static_cast<int>(connectivity)});
  return question;
}

void write_component_numbers(const ComponentNumbers& numbers, const FileReader& mask,
                             const Output& output) {
  JsonObject head = question_of(mask, numbers.options.connectivity);
  head.set("keep_largest", std::vector<std::int64_t>{numbers.options.keep_largest});
  head.set("min_mm3", exact_text(numbers.options.min_mm3));
  head.set("counts",
           std::vector<std::size_t>{numbers.found, numbers.kept, numbers.labels.size()});
  std::vector<JsonObject> lines = lines_of_labels(numbers.labels);
  lines.insert(lines.begin(), std::move(head));
  write_part_result(output, kNumbersKind, {}, lines);
}

ComponentNumbers read_component_numbers(const std::string& path, const FileReader& mask,
                                        const TaskContext& context) {
  const FoundPart file = read_part_result(path, kNumbersKind, context);
  return of_part_result(path, [&] { return numbers_of(file, mask, path); });
}

}  // namespace octavo
