#include "octavo/builder/band_reader.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <numeric>
#include <utility>

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

ByteSpan bytes_of_floats(std::span<const float> floats) {
  const auto bytes = std::as_bytes(floats);
  return {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
}

// Copies the voxels of a box that lie in a plane.
// plane  [y][x], `row_voxels` in a row
// box    of the brick that starts at `to`, dense [z][y][x]
void copy_box_plane(const std::byte* plane, std::int64_t row_voxels, std::int64_t width,
                    const Box& box, std::int64_t z, std::byte* to) {
  const auto row_bytes = static_cast<std::size_t>(box.size().x * width);
  to += static_cast<std::size_t>((z - box.lo.z) * box.size().y) * row_bytes;
  for (std::int64_t y = box.lo.y; y < box.hi.y; ++y, to += row_bytes) {
    std::memcpy(to, plane + (y * row_voxels + box.lo.x) * width, row_bytes);
  }
}

}  // namespace

BandReader::BandReader(PlaneSource& source, const Levels& levels, std::int64_t first,
                       std::int64_t end, const BandCut& cut, Progress& progress)
    : source_(source),
      levels_(levels),
      progress_(progress),
      cut_(cut),
      width_(bytes_per_voxel(source.description().type)) {
  const Size3& size = levels.size(0);
  group_.type = source.description().type;
  group_.size = {size.x, size.y, end - first};
  group_.first_plane = first;
  bricks_ = bricks_of(levels, 0, group_);
  order_.resize(bricks_.size());
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  if (cut.is_rows) {
    std::ranges::sort(order_, {}, [this](std::size_t i) {
      return std::array{bricks_[i].z, bricks_[i].y, bricks_[i].x};
    });
  }
  is_uniform_.assign(bricks_.size(), 1);
  values_.resize(bricks_.size() * static_cast<std::size_t>(width_));
  plane_.resize(static_cast<std::size_t>(size.x * size.y * width_));
  end_ = order_.size();
  if (cut.share) make_room_ahead();
  const auto hasher = make_crypto_hasher();
  if (cut.floats != nullptr) group_.codes_crc = 0;
  source.seek(first, end);
  for (std::int64_t z = first; z < end; ++z) {
    read_plane();
    const ByteSpan bytes(reinterpret_cast<const std::uint8_t*>(plane_.data()), plane_.size());
    if (cut.floats != nullptr) {
      group_.crc = crc32c(bytes_of_floats(cut.floats->voxels()), group_.crc);
      group_.codes_crc = crc32c(bytes, *group_.codes_crc);
    } else {
      group_.crc = crc32c(bytes, group_.crc);
    }
    hash_plane(*hasher, z, bytes);
    look_at(z);
    if (z == first) guess_training_bricks();
    keep_ahead(z);
    progress.advance(1);
  }
  if (cut.share) end_ahead();
}

void BandReader::hash_plane(Hasher& hasher, std::int64_t z, ByteSpan bytes) {
  const std::int64_t plane = z - group_.first_plane;
  if (cut_.is_rows) return;
  if (cut_.share && (plane < cut_.share->first_plane || plane >= cut_.share->end_plane)) return;
  hasher.add(bytes);
  digests_.push_back(hasher.digest());
}

// --- What is picked up while the planes of a share are read first: then it is not known yet which
// bricks are uniform, and all have room for each voxel.

void BandReader::make_room_ahead() {
  next_ = cut_.share->first;
  end_ = cut_.share->end;
  std::uint64_t bytes = 0;
  for (std::size_t i = next_; i < end_; ++i) bytes += whole_bytes_of(i);
  has_band_ahead_ = bytes <= cut_.bytes;
  for (std::size_t i = next_; has_band_ahead_ && i < end_; ++i) {
    bands_[0].numbers.push_back(i);
    bands_[0].voxels.emplace_back(static_cast<std::size_t>(whole_bytes_of(i)));
  }
}

// By the first plane.
void BandReader::guess_training_bricks() {
  if (!cut_.share || !cut_.share->is_trained_on) return;
  BrickBand& guessed = bands_[1];
  guessed.numbers = training_numbers();
  for (const std::size_t brick : guessed.numbers) {
    guessed.voxels.emplace_back(static_cast<std::size_t>(whole_bytes_of(brick)));
  }
}

void BandReader::keep_ahead(std::int64_t z) {
  for (BrickBand& band : bands_) {
    for (std::size_t i = 0; i < band.numbers.size(); ++i) {
      const Box box = levels_.brick_box(0, bricks_[band.numbers[i]]);
      if (z < box.lo.z || z >= box.hi.z) continue;
      copy_box_plane(plane_.data(), group_.size.x, width_, box, z, band.voxels[i].data());
    }
  }
}

void BandReader::end_ahead() {
  has_training_ahead_ = cut_.share->is_trained_on && take_training_ahead();
  if (!has_band_ahead_) return;
  BrickBand& band = bands_[0];
  for (std::size_t i = 0; i < band.numbers.size(); ++i) {
    const std::size_t brick = band.numbers[i];
    band.bricks.push_back(bricks_[brick]);
    if (is_a_row(brick)) band.voxels[i] = room_for(brick);
    band.views.push_back(view_of_brick(brick, band.voxels[i]));
  }
}

// Puts the bricks that training chooses in place of those that were guessed. False where one of
// them was not picked up.
bool BandReader::take_training_ahead() {
  BrickBand& guessed = bands_[1];
  BrickBand chosen;
  chosen.numbers = training_numbers();
  for (const std::size_t brick : chosen.numbers) {
    const auto at = std::ranges::lower_bound(guessed.numbers, brick);
    if (at != guessed.numbers.end() && *at == brick) {
      chosen.voxels.push_back(
          guessed.voxels[static_cast<std::size_t>(at - guessed.numbers.begin())]);
    } else if (has_band_ahead_ && brick >= next_ && brick < end_) {
      chosen.voxels.push_back(bands_[0].voxels[brick - next_]);
    } else {
      return false;
    }
  }
  guessed = std::move(chosen);
  for (std::size_t i = 0; i < guessed.numbers.size(); ++i) {
    guessed.views.push_back(view_of_brick(guessed.numbers[i], guessed.voxels[i]));
  }
  return true;
}

// --- Planes and bricks

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

// Whether a brick takes a single row, as all others are like it. Encoding must not change it then.
bool BandReader::is_a_row(std::size_t brick) const {
  return is_uniform_[brick] != 0 && !cut_.is_rows;
}

std::vector<std::byte> BandReader::room_for(std::size_t brick) const {
  const Size3 size = levels_.brick_box(0, bricks_[brick]).size();
  const auto width = static_cast<std::size_t>(width_);
  if (!is_a_row(brick)) {
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
  view.row_stride = is_a_row(brick) ? 0 : view.size.x;
  view.plane_stride = is_a_row(brick) ? 0 : view.size.x * view.size.y;
  return view;
}

// Fills in the bricks of a band, whose numbers it has.
void BandReader::read_bricks(BrickBand& band) {
  band.voxels.clear();
  band.views.clear();
  band.floats.clear();
  band.float_views.clear();
  for (const std::size_t brick : band.numbers) {
    band.voxels.push_back(room_for(brick));
    band.views.push_back(view_of_brick(brick, band.voxels.back()));
    if (cut_.floats == nullptr) continue;
    BrickView view = band.views.back();
    band.floats.emplace_back(static_cast<std::size_t>(view.size.voxel_count()));
    view.voxels = band.floats.back().data();
    view.type = VoxelType::float32;
    band.float_views.push_back(view);
  }
  read_planes_of(band);
}

void BandReader::read_planes_of(BrickBand& band) {
  std::int64_t first = group_.first_plane + group_.size.z;
  std::int64_t end = group_.first_plane;
  for (const std::size_t brick : band.numbers) {
    if (is_a_row(brick)) continue;
    const Box box = levels_.brick_box(0, bricks_[brick]);
    first = std::min(first, box.lo.z);
    end = std::max(end, box.hi.z);
  }
  if (first >= end) return;
  source_.seek(first, end);
  for (std::int64_t z = first; z < end; ++z) {
    read_plane();
    copy_plane(z, band);
  }
}

// What the bricks of a band hold of the plane that was read last.
void BandReader::copy_plane(std::int64_t z, BrickBand& band) {
  for (std::size_t i = 0; i < band.numbers.size(); ++i) {
    const Box box = levels_.brick_box(0, bricks_[band.numbers[i]]);
    if (is_a_row(band.numbers[i]) || z < box.lo.z || z >= box.hi.z) continue;
    copy_box_plane(plane_.data(), group_.size.x, width_, box, z, band.voxels[i].data());
    if (cut_.floats == nullptr) continue;
    const auto floats = std::as_bytes(cut_.floats->voxels());
    copy_box_plane(floats.data(), group_.size.x, sizeof(float), box, z,
                   reinterpret_cast<std::byte*>(band.floats[i].data()));
  }
}

// Those that training chooses, by what is known of the bricks.
std::vector<std::size_t> BandReader::training_numbers() const {
  std::vector<std::size_t> candidates;
  std::vector<std::int64_t> voxel_counts;
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    if (is_uniform_[i] != 0) continue;
    candidates.push_back(i);
    voxel_counts.push_back(levels_.brick_box(0, bricks_[i]).size().voxel_count());
  }
  std::vector<std::size_t> numbers;
  for (const std::size_t i : training_choice(voxel_counts, levels_.brick_side(0).voxel_count())) {
    numbers.push_back(candidates[i]);
  }
  return numbers;
}

std::vector<TrainingBrick> BandReader::training_bricks() {
  BrickBand& band = training_band();
  if (!has_training_ahead_) {
    band.numbers = training_numbers();
    read_bricks(band);
  }
  std::vector<TrainingBrick> chosen;
  for (std::size_t i = 0; i < band.numbers.size(); ++i) {
    chosen.push_back({brick_shape(levels_, 0, bricks_[band.numbers[i]]), band.views[i]});
  }
  return chosen;
}

// Behind the bricks that come into a band together: one, or a row of them.
std::size_t BandReader::end_of_step(std::size_t first) const {
  const Size3 grid = levels_.brick_grid(0);
  return first + (cut_.is_rows ? static_cast<std::size_t>(grid.x) : 1);
}

std::uint64_t BandReader::bytes_of(std::size_t brick) const {
  return is_a_row(brick) ? 0 : whole_bytes_of(brick);
}

std::uint64_t BandReader::whole_bytes_of(std::size_t brick) const {
  const std::int64_t width =
      width_ + (cut_.floats != nullptr ? static_cast<std::int64_t>(sizeof(float)) : 0);
  return static_cast<std::uint64_t>(
      levels_.brick_box(0, bricks_[brick]).size().voxel_count() * width);
}

BrickBand& BandReader::next() {
  BrickBand& band = bands_[turn_++ % bands_.size()];
  band.first = next_;
  if (std::exchange(has_band_ahead_, false)) {
    next_ = end_;
    return band;
  }
  band.numbers.clear();
  band.bricks.clear();
  if (!cut_.share) band.digests = digests_;
  std::uint64_t bytes = 0;
  while (next_ < end_) {
    const std::size_t end = end_of_step(next_);
    for (std::size_t i = next_; i < end; ++i) bytes += bytes_of(order_[i]);
    const bool is_of_next_layer = cut_.is_rows && !band.bricks.empty() &&
                                  bricks_[order_[next_]].z != band.bricks.front().z;
    if (!band.numbers.empty() && (bytes > cut_.bytes || is_of_next_layer)) break;
    for (; next_ < end; ++next_) {
      band.numbers.push_back(order_[next_]);
      band.bricks.push_back(bricks_[order_[next_]]);
    }
  }
  read_bricks(band);
  return band;
}

}  // namespace octavo
