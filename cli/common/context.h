// What every verb shares: the global options, and the two channels it may speak on.
//
// Standard output carries the result and nothing else: text for people, or one JSON object with
// --json. Standard error carries notes, warnings, progress and the one line of a failure.
#pragma once

#include <any>
#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace octavo::cli {

enum class ProgressMode { automatic, bar, plain, json, none };

/// The global options, and the work the chosen verb left to be done.
struct Context {
  bool quiet = false;
  bool verbose = false;
  bool json = false;
  bool force = false;
  bool strict = false;
  ProgressMode progress = ProgressMode::automatic;
  int threads = 0;                     ///< 0: all cores
  std::uint64_t max_memory_bytes = 0;  ///< 0: no limit
  double timeout_s = 60;               ///< of servers behind URLs
  std::uint64_t max_voxels = std::uint64_t{1} << 40;
  std::string verb;
  std::function<int()> run;            ///< set by the verb that was parsed; returns the exit code
  std::vector<std::string> planned;    ///< words of `plan -- VERB ...` from VERB on
  std::any* taken = nullptr;           ///< where the options of a task go instead of to the task
  std::vector<std::string> warnings;   ///< all that warn() was told, for the JSON result

  /// Writes "octavo: TEXT" to standard error unless --quiet.
  void note(const std::string& text) const;
  /// The same with --verbose only.
  void detail(const std::string& text) const;
  /// Writes "octavo: warning: TEXT" to standard error and remembers it.
  /// Throws Error{source_rejected} with --strict.
  void warn(const std::string& text);

  /// Threads to start: --threads, or the cores of this machine.
  int thread_count() const;
};

/// Writes `text` to standard output and proves that it got there.
/// Throws Error{io} on a full disk or a closed pipe.
void print(const std::string& text);

/// Prints one JSON object and a newline. Text that is not UTF-8 is replaced, never rejected.
void print_json(const nlohmann::ordered_json& object);

/// Prints what a verb found: with --json the object, its warnings behind it; otherwise the text,
/// unless --quiet. Of its control characters only ends of lines and tabs are printed as they are.
void print_result(const Context& context, nlohmann::ordered_json object, const std::string& text);

/// The same, but that --quiet leaves out a text alone that is of success.
void print_finding(const Context& context, bool is_success, nlohmann::ordered_json object,
                   const std::string& text);

/// `text` for one line of a message: control characters escaped, UTF-8 and length left alone.
std::string one_line(const std::string& text);

/// A file or a URL as text for people says it: on one line, and without what is secret in a URL.
std::string shown_path(const std::string& path);

}  // namespace octavo::cli
