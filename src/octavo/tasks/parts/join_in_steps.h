// A join that many machines or the server of an object store share.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "octavo/core/option_words.h"
#include "octavo/tasks/parts/join_scan.h"
#include "octavo/tasks/parts/part_numbers.h"

namespace octavo {

/// As dist/join_steps.h has them.
enum class JoinStep { layout, copy, seal };

constexpr auto option_words(JoinStep) { return in_order<JoinStep>("layout", "copy", "seal"); }

struct JoinStepOptions {
  JoinOptions join;
  JoinStep step = JoinStep::layout;
  /// Of the step copy: numbers of parts, "3,17-19"; empty: those that a scheduler gives, or all
  /// that were not copied.
  std::string numbers;
  Variables variables;
};

struct JoinStepResult {
  std::uint64_t file_bytes = 0;
  std::int64_t part_count = 0;
  std::vector<std::int64_t> copied;    ///< by this step
  std::vector<std::int64_t> uncopied;  ///< that are still to be copied
  bool is_done = false;  ///< the file had its name before this step, which did nothing
};

/// One step. Done again it changes nothing.
/// Throws as join_scan, require_no_part, lay_out_join, copy_part, seal_join, parse_part_list and
///        scheduled_parts
JoinStepResult join_step(const JoinStepOptions& options, const TaskContext& context);

/// Bytes of a file that is joined elsewhere: by the server of an object store.
struct FileRun {
  std::string path;
  std::uint64_t offset = 0;  ///< in the file at that path
  std::uint64_t length = 0;
};

struct JoinRuns {
  std::string own_file;  ///< that was laid out: bytes that are no part's stand in it
  std::uint64_t file_bytes = 0;
  std::vector<FileRun> runs;  ///< one behind the other they are the joined file
};

/// Lays out the file and says which bytes it consists of. The parts are not proven.
/// Throws as the step layout
JoinRuns join_runs(const JoinOptions& options, const TaskContext& context);

}  // namespace octavo
