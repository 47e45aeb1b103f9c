// Planes of which a source makes a few at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "octavo/planes/plane_cursor.h"
#include "octavo/planes/plane_source.h"

namespace octavo {

/// Hands out planes of a slab that it keeps. Slabs begin at multiples of their planes.
class SlabPlanes : public PlaneSource {
 public:
  void read_plane(std::span<std::byte> plane) final;
  void seek(std::int64_t first, std::int64_t end) final { cursor_.seek(first, end); }

 protected:
  /// planes      of a slab
  /// count       of the volume
  /// name        of the source, for errors
  SlabPlanes(std::int64_t planes, std::int64_t count, std::string name);

  /// Fills the planes [begin, end): those of a slab, the last one cut where the volume ends.
  virtual void fill_slab(std::int64_t begin, std::int64_t end, std::span<std::byte> slab) = 0;

  /// Of a whole slab, or all planes where there are fewer.
  std::uint64_t slab_bytes() const;

 private:
  std::int64_t planes_;
  std::int64_t count_;
  std::string name_;
  PlaneCursor cursor_;
  std::vector<std::byte> slab_;
  std::int64_t begin_ = 0;
  std::int64_t end_ = 0;
};

}  // namespace octavo
