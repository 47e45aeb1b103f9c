// Headers that name several data files: in a list, or by a pattern with a number.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "octavo/io/source/streamed_source.h"

namespace octavo {

/// Names that differ in a number: "slice%03d.raw" from `first` to `last`.
struct NumberedNames {
  std::string pattern;
  std::int64_t first = 1;
  std::int64_t last = 1;
  std::int64_t step = 1;
};

/// True of a name that has one number of printf in it and no other '%': %d, %i or %u, of a width
/// of at most two digits.
bool has_number_pattern(std::string_view name);

/// A pattern with the numbers behind it, as in "a%03d.raw 1 20 1".
struct PatternLine {
  std::string pattern;
  std::vector<std::int64_t> numbers;
};

/// Up to `most` whole numbers at the end of a line, and the pattern in front of them, which may
/// hold blanks; nothing where that has no number of printf.
std::optional<PatternLine> pattern_line(std::string_view line, std::size_t most);

/// "2" of "2D", which some programs write for the dimension of a file.
std::string_view dimension_digits(std::string_view word);

/// Names in their order. Those of a pattern are made when they are asked for: it may claim any
/// number of them.
class DataFileNames {
 public:
  /// One name a line; blank lines are none.
  static DataFileNames of_list(std::string_view lines);
  /// Those of a pattern, `last` being the last one at most. Requires has_number_pattern
  static DataFileNames of_pattern(NumberedNames names);

  std::uint64_t count() const;
  /// Requires number < count()
  std::string name(std::uint64_t number) const;

 private:
  std::vector<std::string> listed_;
  std::optional<NumberedNames> numbered_;
};

/// The files that hold an array, in the order of its axes.
/// sizes      of the axes, the fastest first
/// dimension  of the array in each file: below that of all, a file holds one index of each other
///            axis, else it holds a run of indices of the last axis
/// Throws     Error{source_rejected} where the names are not so many, and as sibling_path
std::vector<std::string> find_data_files(const std::string& header, const DataFileNames& names,
                                         std::span<const std::int64_t> sizes,
                                         std::int64_t dimension);

/// Where the last `bytes` of a file start, for headers that say no more of its voxels.
/// Throws Error{source_rejected} with both lengths where the file is shorter, Error{io}
std::uint64_t start_of_last(const std::string& path, std::uint64_t bytes);

/// Points `run` at files that hold `total_bytes` in equal pieces, one after the other.
/// start   where the voxels start in each of them; nothing: a plain file ends with its voxels
/// Throws  Error{source_rejected} where the bytes do not divide into so many files, and where one
///         that is to end with its voxels is shorter than these
void take_files(const std::string& header, const std::vector<std::string>& files,
                std::uint64_t total_bytes, const std::optional<PieceStart>& start, VoxelRun& run);

}  // namespace octavo
