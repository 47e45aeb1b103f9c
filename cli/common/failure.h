// How a failure leaves the program: one line on standard error, one exit code.
#pragma once

#include <exception>
#include <nlohmann/json_fwd.hpp>

#include "common/context.h"
#include "octavo/core/error.h"

namespace octavo::cli {

inline constexpr int kExitDone = 0;
inline constexpr int kExitDifferent = 1;  ///< compare or verify --against found a difference
inline constexpr int kExitUsage = 2;
inline constexpr int kExitInternal = 8;

/// 2 usage, 3 not an 8vo file or a newer version, 4 damaged, 5 input/output, 6 limit or memory,
/// 7 source rejected or a warning under --strict, 8 our bug, 128 + signal when stopped.
int exit_code_of(ErrorKind kind);

/// Kind, path, offset, what happened with what to do, and the exit code.
nlohmann::ordered_json error_json(const Error& error);

/// Writes the line (and with --json the object {"error": ...} after it) and returns the exit code.
int report_failure(const Context& context, std::exception_ptr failure);

/// The same for a command line that could not be understood.
int report_usage(const Context& context, const std::string& problem);

}  // namespace octavo::cli
