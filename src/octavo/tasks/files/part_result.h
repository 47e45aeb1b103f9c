// What a part of a work found, kept in a file until all parts are there: lines of JSON objects, the
// last one the checksum of those before it.
//
// Invariants
//   A file takes its name only when it is complete; one that was changed in any byte is rejected.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/json_text.h"
#include "octavo/core/work_part.h"
#include "octavo/tasks/outputs.h"

namespace octavo {

/// Writes what `part` of a work on `kind` found; all lines are the caller's.
/// Throws Error{io} that names the file; Error{limit_exceeded} above 1 GiB
void write_part_result(const Output& output, std::string_view kind, const WorkPart& part,
                     const std::vector<JsonObject>& lines);

struct FoundPart {
  WorkPart part;
  std::vector<JsonObject> lines;
};

/// Reads what write_part_result wrote for that kind of work.
/// Throws Error{io}; Error{corrupt} where it is no such file, or was changed; Error{limit_exceeded}
///        above 1 GiB and above the memory limit
/// Memory twice the file
FoundPart read_part_result(const std::string& path, std::string_view kind,
                           const TaskContext& context);

/// What `read` makes of the lines of the result at `path`, which its errors then name.
template <class Read>
auto of_part_result(const std::string& path, Read read) -> decltype(read()) {
  try {
    return read();
  } catch (const Error& error) {
    throw error.path().empty() ? error.with_path(path) : error;
  }
}

/// A member of a line, of a list of integers or of texts, of which all have to be there.
/// Throws Error{corrupt}
std::vector<std::int64_t> integers_in(const JsonObject& line, std::string_view name,
                                      std::size_t count);
std::string text_in(const JsonObject& line, std::string_view name);

/// 64 bits as 16 digits, which JSON has no number for.
std::string hex_digits(std::uint64_t bits);
/// Throws Error{corrupt}
std::uint64_t bits_of_digits(std::string_view digits);

}  // namespace octavo
