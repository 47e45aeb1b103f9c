// One exception type for the whole library; the command line maps its kind to an exit code.
#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace octavo {

enum class ErrorKind {
  invalid_argument,
  not_octavo,
  unsupported_version,
  corrupt,
  truncated,
  limit_exceeded,
  source_rejected,
  io,
  out_of_memory,
  cancelled,
  internal,
};

/// The name of a kind as it stands in JSON output: "corrupt", "source_rejected", ...
std::string_view error_kind_name(ErrorKind kind) noexcept;

/// `text` cut at 200 bytes, with bytes escaped as `\xNN` that are no UTF-8, control characters, or
/// characters that end lines or turn the direction of writing.
/// For every string that comes out of a file or a path before it enters a message.
std::string escaped(std::string_view text);

/// An option that would change an outcome.
struct OptionHint {
  std::string field;  ///< its name in an options struct: "spacing_mm", "output.overwrite"
  std::string value;  ///< that would help: "fill", "0 to 3"; empty where that is not known
  bool operator==(const OptionHint&) const = default;
};

/// A failure: what went wrong, in which file, where in it, and which options it is about.
/// what() is one line: "PATH: DETAIL", or the detail alone when no path is known. What to type or
/// to call is no business of the library: whoever reports the failure finds it by kind and field.
class Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, std::string detail, std::string path = {},
        std::optional<std::uint64_t> offset = {});

  ErrorKind kind() const noexcept { return kind_; }
  const std::string& detail() const noexcept { return detail_; }
  const std::string& path() const noexcept { return path_; }
  std::optional<std::uint64_t> offset() const noexcept { return offset_; }

  /// The options that would change the outcome, what helps most first; mostly one or none.
  const std::vector<OptionHint>& hints() const noexcept { return hints_; }
  /// The field of the first of them; empty where there is none.
  const std::string& field() const noexcept;

  /// The same failure with `path` set, when it has none yet.
  Error with_path(const std::string& path) const;
  /// The same failure in other words.
  Error with_detail(const std::string& detail) const;
  /// The same failure, about one more option.
  Error with_field(std::string field, std::string value = {}) const;

 private:
  ErrorKind kind_;
  std::string detail_;
  std::string path_;
  std::optional<std::uint64_t> offset_;
  std::vector<OptionHint> hints_;
};

}  // namespace octavo
