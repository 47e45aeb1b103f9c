// The planes of one level of an .8vo file, in order.
#pragma once

#include <memory>
#include <vector>

#include "octavo/file/reader.h"
#include "octavo/planes/slab_planes.h"

namespace octavo {

/// Decodes one brick layer at a time with `threads` threads and hands out its planes.
/// Memory  one layer of bricks of the level (64 planes or fewer), besides the reader's cache
class FilePlanes final : public SlabPlanes {
 public:
  FilePlanes(std::shared_ptr<const FileReader> reader, int level, int threads,
             bool keep_identity = false);

  /// Size and geometry are those of the level; the metadata are for a file built from this one:
  /// without what it kept of the identity of its source, unless keep_identity.
  const VolumeDescription& description() const override { return description_; }
  const std::vector<Warning>& warnings() const override { return warnings_; }
  /// A layer of bricks.
  std::uint64_t resident_bytes() const override { return slab_bytes(); }
  /// The .8vo file, unless it stands behind a URL.
  const PlaneFiles& files() const override { return files_; }

 private:
  void fill_slab(std::int64_t begin, std::int64_t end, std::span<std::byte> slab) override;

  std::shared_ptr<const FileReader> reader_;
  int level_;
  int threads_;
  VolumeDescription description_;
  std::vector<Warning> warnings_;
  PlaneFiles files_;
};

}  // namespace octavo
