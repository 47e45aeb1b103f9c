#include "octavo/builder/band_reader.h"

#include <algorithm>
#include <chrono>
#include <cstring>

#include "octavo/builder/crypto_hasher.h"
#include "octavo/builder/training.h"
#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"

namespace octavo {

namespace {

// Whether all voxels of a row are `value`.
bool is_row_of(const std::byte* row, std::size_t row_bytes, const std::byte* value,
               std::size_t width) {
  return std::memcmp(row, value, width) == 0 &&
         std::memcmp(row, row + width, row_bytes - width) == 0;
}

}  // namespace

BandReader::BandReader(PlaneSource& source, const Levels& levels, std::int64_t first,
                       std::int64_t end, std::uint64_t band_bytes, Progress& progress)
    : source_(source),
      levels_(levels),
      progress_(progress),
      band_bytes_(band_bytes),
      width_(bytes_per_voxel(source.description().type)) {
  const Size3& size = levels.size(0);
  group_.type = source.description().type;
  group_.size = {size.x, size.y, end - first};
  group_.first_plane = first;
  bricks_ = bricks_of(levels, 0, group_);
  is_uniform_.assign(bricks_.size(), 1);
  values_.resize(bricks_.size() * static_cast<std::size_t>(width_));
  plane_.resize(static_cast<std::size_t>(size.x * size.y * width_));
  const auto hasher = make_crypto_hasher();
  source.seek(first, end);
  for (std::int64_t z = first; z < end; ++z) {
    read_plane();
    const ByteSpan bytes(reinterpret_cast<const std::uint8_t*>(plane_.data()), plane_.size());
    group_.crc = crc32c(bytes, group_.crc);
    hasher->add(bytes);
    digests_.push_back(hasher->digest());
    look_at(z);
    progress.advance(1);
  }
}

void BandReader::read_plane() {
  if (progress_.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped while reading planes");
  const auto start = std::chrono::steady_clock::now();
  source_.read_plane(plane_.bytes());
  read_seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// The voxel of a column and row in the plane that was read last.
const std::byte* BandReader::row_at(const Index3& at) const {
  return plane_.data() + (at.y * group_.size.x + at.x) * width_;
}

// Notes which bricks are not uniform, by the plane that was read last.
void BandReader::look_at(std::int64_t z) {
  const auto width = static_cast<std::size_t>(width_);
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    if (is_uniform_[i] == 0) continue;
    const Box box = levels_.brick_box(0, bricks_[i]);
    if (z < box.lo.z || z >= box.hi.z) continue;
    std::byte* const value = values_.data() + i * width;
    if (z == box.lo.z) std::memcpy(value, row_at(box.lo), width);
    const auto row_bytes = static_cast<std::size_t>(box.size().x) * width;
    for (std::int64_t y = box.lo.y; y < box.hi.y && is_uniform_[i] != 0; ++y) {
      is_uniform_[i] = is_row_of(row_at({box.lo.x, y, z}), row_bytes, value, width) ? 1 : 0;
    }
  }
}

// The voxels of a brick; of a uniform one a single row.
std::vector<std::byte> BandReader::room_for(std::size_t brick) const {
  const Size3 size = levels_.brick_box(0, bricks_[brick]).size();
  const auto width = static_cast<std::size_t>(width_);
  if (is_uniform_[brick] == 0) {
    return std::vector<std::byte>(static_cast<std::size_t>(size.voxel_count()) * width);
  }
  std::vector<std::byte> row(static_cast<std::size_t>(size.x) * width);
  for (std::size_t at = 0; at < row.size(); at += width) {
    std::memcpy(row.data() + at, values_.data() + brick * width, width);
  }
  return row;
}

BrickView BandReader::view_of_brick(std::size_t brick, const std::vector<std::byte>& voxels) const {
  BrickView view;
  view.voxels = voxels.data();
  view.type = group_.type;
  view.size = levels_.brick_box(0, bricks_[brick]).size();
  const bool is_uniform = is_uniform_[brick] != 0;
  view.row_stride = is_uniform ? 0 : view.size.x;
  view.plane_stride = is_uniform ? 0 : view.size.x * view.size.y;
  return view;
}

// Fills in the bricks of a band, whose numbers it has.
void BandReader::read_bricks(BrickBand& band) {
  band.voxels.clear();
  band.views.clear();
  std::int64_t first = group_.first_plane + group_.size.z;
  std::int64_t end = group_.first_plane;
  for (const std::size_t brick : band.numbers) {
    band.voxels.push_back(room_for(brick));
    band.views.push_back(view_of_brick(brick, band.voxels.back()));
    if (is_uniform_[brick] != 0) continue;
    const Box box = levels_.brick_box(0, bricks_[brick]);
    first = std::min(first, box.lo.z);
    end = std::max(end, box.hi.z);
  }
  if (first >= end) return;
  source_.seek(first, end);
  for (std::int64_t z = first; z < end; ++z) {
    read_plane();
    for (std::size_t i = 0; i < band.numbers.size(); ++i) {
      const Box box = levels_.brick_box(0, bricks_[band.numbers[i]]);
      if (is_uniform_[band.numbers[i]] != 0 || z < box.lo.z || z >= box.hi.z) continue;
      const auto row_bytes = static_cast<std::size_t>(box.size().x * width_);
      std::byte* to = band.voxels[i].data() +
                      static_cast<std::size_t>((z - box.lo.z) * box.size().y) * row_bytes;
      for (std::int64_t y = box.lo.y; y < box.hi.y; ++y, to += row_bytes) {
        std::memcpy(to, row_at({box.lo.x, y, z}), row_bytes);
      }
    }
  }
}

std::vector<TrainingBrick> BandReader::training_bricks() {
  std::vector<std::size_t> candidates;
  std::vector<std::int64_t> voxel_counts;
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    if (is_uniform_[i] != 0) continue;
    candidates.push_back(i);
    voxel_counts.push_back(levels_.brick_box(0, bricks_[i]).size().voxel_count());
  }
  BrickBand& band = bands_[0];
  band.numbers.clear();
  for (const std::size_t i : training_choice(voxel_counts, levels_.brick_side(0).voxel_count())) {
    band.numbers.push_back(candidates[i]);
  }
  read_bricks(band);
  std::vector<TrainingBrick> chosen;
  for (std::size_t i = 0; i < band.numbers.size(); ++i) {
    chosen.push_back({brick_shape(levels_, 0, bricks_[band.numbers[i]]), band.views[i]});
  }
  return chosen;
}

const BrickBand& BandReader::next() {
  BrickBand& band = bands_[turn_++ % bands_.size()];
  band.first = next_;
  band.numbers.clear();
  band.bricks.clear();
  band.digests = digests_;
  std::uint64_t bytes = 0;
  for (; next_ < bricks_.size(); ++next_) {
    if (is_uniform_[next_] == 0) {
      bytes += static_cast<std::uint64_t>(
          levels_.brick_box(0, bricks_[next_]).size().voxel_count() * width_);
    }
    if (bytes > band_bytes_ && !band.numbers.empty()) break;
    band.numbers.push_back(next_);
    band.bricks.push_back(bricks_[next_]);
  }
  read_bricks(band);
  return band;
}

}  // namespace octavo
