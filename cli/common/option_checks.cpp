#include "common/option_checks.h"

#include <fmt/format.h>

#include <functional>
#include <string>

#include "common/quantities.h"
#include "octavo/core/error.h"

namespace octavo::cli {

namespace {

/// A check of one number, of which `expected` says in words what it must be.
template <class Number, class Parse>
CLI::Validator number_check(const std::string& expected, const std::string& shown, Parse parse,
                            std::function<bool(Number)> is_right) {
  const auto problem = [=](const std::string& text) -> std::string {
    try {
      if (is_right(parse(text, ""))) return "";
    } catch (const Error&) {
      // Not a number at all: the same is expected.
    }
    return fmt::format("{}; expected {}", escaped(text), expected);
  };
  return {problem, shown};
}

CLI::Validator real_check(const std::string& expected, const std::string& shown,
                          std::function<bool(double)> is_right) {
  return number_check<double>(expected, shown, parse_number, std::move(is_right));
}

}  // namespace

CLI::Validator above_zero() {
  return real_check("a number above 0", "above 0", [](double value) { return value > 0; });
}

CLI::Validator not_negative() {
  return real_check("a number of 0 or more", "0 or more", [](double value) { return value >= 0; });
}

CLI::Validator number_within(double least, double greatest) {
  const std::string ends = number_text(least) + " to " + number_text(greatest);
  return real_check("a number, " + ends, ends,
                    [=](double value) { return value >= least && value <= greatest; });
}

CLI::Validator whole_within(std::int64_t least, std::int64_t greatest) {
  const bool is_open = greatest == INT64_MAX;
  const std::string ends =
      is_open ? fmt::format("{} or more", least) : fmt::format("{} to {}", least, greatest);
  return number_check<std::int64_t>(
      "a whole number" + std::string(is_open ? " of " : ", ") + ends, ends, parse_integer,
      [=](std::int64_t value) { return value >= least && value <= greatest; });
}

void refuse_empty_texts(CLI::App& app) {
  for (CLI::Option* option : app.get_options()) {
    if (option->get_items_expected_max() == 0) continue;
    // A transformation that changes nothing: those run before all checks.
    option->transform(CLI::Validator(
        [type = option->get_type_name()](std::string& text) {
          return text.empty() ? "is empty; expected " + type : std::string();
        },
        ""));
  }
  for (CLI::App* verb : app.get_subcommands([](CLI::App*) { return true; })) {
    refuse_empty_texts(*verb);
  }
}

}  // namespace octavo::cli
