#include "common/failure.h"

#include <cstdio>
#include <filesystem>
#include <new>
#include <nlohmann/json.hpp>

#include "common/cancel.h"
#include "text/advice.h"

namespace octavo::cli {

namespace {

/// What to do, behind what happened.
std::string ending_of(const Error& error) {
  const std::string advice = advice_for(error);
  return advice.empty() ? "" : "; " + advice;
}

int report(const Context& context, const Error& error) {
  const int code = exit_code_of(error.kind());
  std::string text = "octavo: " + one_line(error.what() + ending_of(error)) + "\n";
  if (context.json) {
    const nlohmann::ordered_json line = {{"error", error_json(error)}};
    text += line.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
  }
  std::fwrite(text.data(), 1, text.size(), stderr);
  return code;
}

}  // namespace

int exit_code_of(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::invalid_argument: return kExitUsage;
    case ErrorKind::not_octavo:
    case ErrorKind::unsupported_version: return 3;
    case ErrorKind::corrupt:
    case ErrorKind::truncated: return 4;
    case ErrorKind::io: return 5;
    case ErrorKind::limit_exceeded:
    case ErrorKind::out_of_memory: return 6;
    case ErrorKind::source_rejected: return 7;
    case ErrorKind::cancelled: return 128 + cancelling_signal();
    case ErrorKind::internal: return kExitInternal;
  }
  return kExitInternal;
}

nlohmann::ordered_json error_json(const Error& error) {
  nlohmann::ordered_json object = {{"kind", error_kind_name(error.kind())},
                                   {"path", error.path()},
                                   {"offset", nullptr},
                                   {"detail", error.detail() + ending_of(error)},
                                   {"exit_code", exit_code_of(error.kind())}};
  if (error.offset()) object["offset"] = *error.offset();
  return object;
}

int report_failure(const Context& context, std::exception_ptr failure) {
  try {
    std::rethrow_exception(failure);
  } catch (const Error& error) {
    return report(context, error);
  } catch (const std::bad_alloc&) {
    return report(context, Error(ErrorKind::out_of_memory,
                                 "out of memory; use --max-memory or fewer --threads"));
  } catch (const std::filesystem::filesystem_error& error) {
    return report(context, Error(ErrorKind::io, error.code().message(), error.path1().string()));
  } catch (const std::exception& error) {
    return report(context,
                  Error(ErrorKind::internal, std::string("internal error: ") + error.what() +
                                                 "; please report this line"));
  }
}

int report_usage(const Context& context, const std::string& problem) {
  const std::string help =
      context.verb.empty() ? "octavo --help" : "octavo " + context.verb + " --help";
  return report(context, Error(ErrorKind::invalid_argument, problem + "; see " + help));
}

}  // namespace octavo::cli
