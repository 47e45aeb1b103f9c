// Makes a sealed file of the bricks that stand in a growing one and in the streams beside it.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "octavo/core/hasher.h"
#include "octavo/core/levels.h"
#include "octavo/file/directory.h"
#include "octavo/file/index.h"
#include "octavo/file/layout.h"
#include "octavo/file/write/append_file.h"

namespace octavo {

/// Hands the bytes of a stream of a run (run_writer.h) to `sink`, a block at a time.
using CopyStream =
    std::function<void(std::size_t stream, const std::function<void(ByteSpan)>& sink)>;

/// Of a stream, what others have put in its place already: the first bytes of it.
struct PlacedBytes {
  std::uint64_t length = 0;
  std::uint32_t crc = 0;
};

class FileSealer {
 public:
  /// All outlive the sealer. `out` holds all of level 0; sections of `header` are filled in.
  FileSealer(AppendFile& out, FileHeader& header, const Levels& levels, const IndexRoot& root);

  /// Appends the levels above 0 and the index pages.
  /// placed  by stream; none: nothing stands there
  void append_streams(const CopyStream& copy, const std::vector<PlacedBytes>& placed = {});

  /// Appends parts, directory, metadata and root.
  /// has_thumbnail  whether one is made of what stands in the file, as the first part
  void append_sections(std::vector<Part> parts, bool has_thumbnail);

  /// Appends the trailer, syncs, and only then writes the header that says "sealed"; reads both
  /// back.
  void seal(const Sha256Digest& voxel_digest);

  /// What a part could not be copied from; or nothing.
  const std::string& failed_source() const { return failed_source_; }

 private:
  std::uint32_t append_stream(std::size_t stream, const CopyStream& copy,
                              const std::vector<PlacedBytes>& placed);
  void append_parts(const std::vector<Part>& parts);

  AppendFile& out_;
  FileHeader& header_;
  const Levels& levels_;
  const IndexRoot& root_;
  std::string failed_source_;
};

}  // namespace octavo
