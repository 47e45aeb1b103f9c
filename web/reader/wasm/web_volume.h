// One .8vo file as JavaScript reads it: bytes are put in, what is missing is a list of ranges.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "octavo/file/open_file.h"
#include "octavo/file/reader.h"
#include "octavo/file/storage/sparse_source.h"

namespace octavo::web {

/// What JavaScript makes room for: everything is a double, offsets among them (below 2^53).
using Numbers = std::vector<double>;

class WebVolume {
 public:
  /// size  of the whole file, in bytes
  WebVolume(std::uint64_t size, std::string name);

  SparseSource& source() { return *source_; }

  /// [bytes needed, 1 where nothing else will be missing, count, then offset and length of each]
  Numbers plan_opening() const;

  /// Requires that nothing is missing to open the file.
  /// cache_bytes  decoded bricks kept, at most
  void open(std::uint64_t cache_bytes);

  /// What the file says of itself, as JSON: api.ts has the meanings.
  std::string description() const;
  /// The metadata, byte for byte.
  const std::string& metadata() const { return reader_->description().metadata.text(); }

  /// As plan_opening(), of the pages of the index that describe the bricks of a box.
  Numbers plan_pages(const Box& box, int level) const;

  /// As plan_opening(), of what a box needs of the file and has not here; behind the ranges the
  /// number of bricks and of uniform ones among them.
  Numbers plan_box(const Box& box, int level) const;

  /// Dense [z][y][x]. Requires that nothing is missing.
  void read(const Box& box, int level, void* out) const { reader_->read(box, level, out); }

  /// The smallest and the largest voxel of each brick, [z][y][x]. Requires their pages.
  /// bricks  in bricks of the level
  void brick_ranges(const Box& bricks, int level, double* min, double* max) const;

  /// As plan_opening().
  Numbers plan_thumbnail() const;
  std::uint64_t thumbnail_bytes() const { return reader_->thumbnail_bytes(); }
  Bytes thumbnail() const { return reader_->thumbnail(); }

 private:
  Numbers missing(const ByteRange& range) const;

  std::shared_ptr<SparseSource> source_;
  std::shared_ptr<FileReader> reader_;
  std::unique_ptr<OpenFile> file_;  ///< the index, for plans
};

}  // namespace octavo::web
