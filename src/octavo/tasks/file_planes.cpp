#include "octavo/tasks/file_planes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "octavo/file/parallel_read.h"

namespace octavo {

namespace {

/// The planes of a brick at a level inside its tier.
std::int64_t layer_planes(const Levels& levels, int level) {
  const int tier = Levels::tier_of(level);
  const int halvings =
      levels.halving_count(level, 2) - levels.halving_count(Levels::first_level(tier), 2);
  return std::max<std::int64_t>(levels.brick_side(tier).z >> halvings, 1);
}

}  // namespace

FilePlanes::FilePlanes(std::shared_ptr<const FileReader> reader, int level, int threads,
                       bool keep_identity)
    : SlabPlanes(layer_planes(reader->levels(), level), reader->levels().size(level).z,
                 reader->source().name()),
      reader_(std::move(reader)),
      level_(level),
      threads_(threads),
      description_(reader_->description()),
      files_(files_of_volume({reader_->source().name()})) {
  const double slope = std::abs(description_.rescale.slope);
  description_.metadata =
      description_.metadata.for_copy(reader_->achieved_error() * slope, keep_identity);
  description_.size = reader_->levels().size(level);
  description_.geometry = reader_->levels().geometry(reader_->description().geometry, level);
}

void FilePlanes::fill_slab(std::int64_t begin, std::int64_t end, std::span<std::byte> slab) {
  const Box layer = {{0, 0, begin}, {description_.size.x, description_.size.y, end}};
  read_parallel(*reader_, layer, level_, slab.data(), threads_);
}

}  // namespace octavo
