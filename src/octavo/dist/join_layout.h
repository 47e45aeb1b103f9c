// Where the streams of parts stand in a file that is joined in steps, as a text beside it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "octavo/builder/exact_coding.h"
#include "octavo/dist/part_place.h"
#include "octavo/file/layout.h"

namespace octavo {

/// Bytes of a part and their place in the file.
struct CopiedRun {
  PartPlace part;
  std::uint64_t part_offset = 0;
  std::uint64_t file_offset = 0;
  std::uint64_t length = 0;      ///< above 0
  std::uint32_t crc = 0;

  bool operator==(const CopiedRun&) const = default;
};

struct JoinLayout {
  std::uint64_t plan = 0;        ///< BuildPlan::id
  std::uint64_t id = 0;          ///< drawn anew for each laying out
  std::uint64_t file_bytes = 0;
  std::uint32_t own_crc = 0;     ///< of the bytes that are no part's
  std::vector<CopiedRun> runs;   ///< in the order of the file
  ClippedVoxels clipped;         ///< of all parts
};

/// The parts of a layout in their order.
std::vector<PartPlace> parts_of(const JoinLayout& layout);

/// The bytes of the file that are no part's.
std::vector<Section> own_bytes_of(const JoinLayout& layout);

/// Lines of JSON: an object of the plan, the id, the length, the clipped voxels, and checksums of
/// the bytes that are no part's and of all lines; then for each run
/// [A,B,C,D,PART OFFSET,FILE OFFSET,LENGTH,CRC] of groups A .. B, of a band bricks C .. D.
std::string layout_text(const JoinLayout& layout);

/// What the first line of a layout says, without runs and unproven. Throws as parse_layout
JoinLayout parse_layout_head(std::string_view text);

/// Throws Error{corrupt} for what is no layout, Error{unsupported_version}
JoinLayout parse_layout(std::string_view text);

}  // namespace octavo
