// Checks of what options are given, with messages that say what is expected.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>

namespace octavo::cli {

/// A number above 0.
CLI::Validator above_zero();

/// A number of 0 or more.
CLI::Validator not_negative();

/// A number from `least` to `greatest`, both included.
CLI::Validator number_within(double least, double greatest);

/// A whole number from `least` to `greatest`, both included; without `greatest` it is open.
CLI::Validator whole_within(std::int64_t least, std::int64_t greatest = INT64_MAX);

/// Lets every option of `app` and of its verbs refuse an empty text, which would else count as an
/// option that was not given.
void refuse_empty_texts(CLI::App& app);

}  // namespace octavo::cli
