#include "octavo/render/rays/ray_bricks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr std::size_t kReadBeyond = 16;  // bytes that vectors read behind the last sample
constexpr std::uint64_t kMaxOffset = std::numeric_limits<std::int32_t>::max();  // of gathers

/// How far values between samples are rounded beyond them.
constexpr float kShortMargin = 1 / 16.0f;
constexpr float kWideMargin = 1e-6f;

constexpr LookSet kAllLooks = std::numeric_limits<LookSet>::max();

/// The first cube along an axis that reaches a sample of a brick with its aprons.
std::int64_t first_cube(std::int64_t sample) {
  constexpr std::int64_t kReach = kSkipSide + kApronBelow + kApronAbove;
  return std::max<std::int64_t>(0, (sample - kReach + kSkipSide) / kSkipSide);
}

bool is_pooled_wide(VoxelType type) { return bytes_per_voxel(type) > 2; }

/// So far below the values that of the way from NaN to one of them at least half shows nothing.
constexpr double kNanPooled = -1;

PooledScale scale_of(VoxelType type, const SampleRange& range, NanPlace nan) {
  if (type == VoxelType::uint16) return {range.highest > 32767 ? 32768.0 : 0.0, 1};
  if (!is_pooled_wide(type)) return {};
  const double width = range.highest - range.lowest;
  PooledScale scale{range.lowest, width > 0 ? 1 / width : 1, width > 0 ? 1.0 : 0.0};
  if (nan == NanPlace::highest) scale.of_nan = scale.highest;
  if (nan == NanPlace::nothing && !is_integer(type)) scale.of_nan = kNanPooled;
  return scale;
}

/// Bounds as rays find values between samples: as far off as roundings go.
float widened(float value, float by) { return value + by * (std::abs(value) * 1e-6f + 1e-30f); }

template <class Pooled, class T>
Pooled pooled_value(T value, const PooledScale& scale) {
  if constexpr (std::is_same_v<Pooled, std::int16_t>) {
    return static_cast<std::int16_t>(static_cast<std::int32_t>(value) -
                                     static_cast<std::int32_t>(scale.offset));
  } else {
    // Infinities count as the highest or lowest finite value, NaN by itself.
    const double share = scale.pooled(static_cast<double>(value));
    if (std::isnan(share)) return static_cast<float>(scale.of_nan);
    return share >= 0 ? static_cast<float>(std::min(share, scale.highest)) : 0.0f;
  }
}

/// Samples of a box, x fastest, one after the other.
template <class Pooled>
struct SampleBlock {
  Pooled* samples = nullptr;
  Box box;

  Pooled* row(std::int64_t y, std::int64_t z) const {
    const Size3 size = box.size();
    return samples + ((z - box.lo.z) * size.y + (y - box.lo.y)) * size.x;
  }
};

/// Copies a box that lies in both.
template <class Pooled>
void copy_box(const SampleBlock<Pooled>& from, const Box& box, const SampleBlock<Pooled>& to) {
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
      std::copy_n(from.row(y, z) + (box.lo.x - from.box.lo.x), box.size().x,
                  to.row(y, z) + (box.lo.x - to.box.lo.x));
    }
  }
}

/// Joins the samples of a row with those above it.
template <class Pooled>
void add_ends(const Pooled* row, std::size_t count, Pooled* low, Pooled* high) {
  for (std::size_t x = 0; x < count; ++x) {
    low[x] = std::min(low[x], row[x]);
    high[x] = std::max(high[x], row[x]);
  }
}

Size3 grid_of(const Size3& size, int shift) {
  Size3 grid{};
  for (int axis = 0; axis < 3; ++axis) {
    grid[axis] = (size[axis] + (std::int64_t{1} << shift) - 1) >> shift;
  }
  return grid;
}

constexpr std::int64_t row_of(int shift) {
  return (std::int64_t{1} << shift) + kApronBelow + kApronAbove;
}

}  // namespace

RayBricks::Bytes RayBricks::bytes_of(const SampleSource& source, const Options& options) {
  const int shift = options.brick_shift;
  const std::int64_t row = row_of(shift);
  const auto samples = static_cast<std::uint64_t>(row * row * row);
  const std::uint64_t cubes = std::uint64_t{1} << 3 * (shift - kSkipShift);
  const std::uint64_t groups = std::uint64_t{1} << 3 * (shift - kGroupShift);
  const std::uint64_t of_looks =
      options.looks == nullptr ? 0 : samples * sizeof(std::uint16_t) + cubes * sizeof(LookSet);
  const auto bricks = static_cast<std::uint64_t>(grid_of(source.size(), shift).voxel_count());
  Bytes bytes;
  bytes.slot = samples * (is_pooled_wide(source.type()) ? 4 : 2);
  bytes.brick = bytes.slot + of_looks + cubes * (sizeof(Ends) + sizeof(float)) +
                groups * sizeof(float) + seen_bytes(shift);
  bytes.tables = bricks * (sizeof(float) + 2 * sizeof(std::int32_t));
  return bytes;
}

std::uint64_t RayBricks::fewest_bytes(const SampleSource& source, const Options& options) {
  const Bytes bytes = bytes_of(source, options);
  return bytes.tables + bytes.brick;
}

RayBricks::RayBricks(const SampleSource& source, const Options& options)
    : source_(source),
      size_(source.size()),
      grid_(grid_of(size_, options.brick_shift)),
      shift_(options.brick_shift),
      row_(row_of(options.brick_shift)),
      slot_samples_(row_ * row_ * row_),
      cubes_(std::size_t{1} << 3 * (options.brick_shift - kSkipShift)),
      groups_(std::size_t{1} << 3 * (options.brick_shift - kGroupShift)),
      is_wide_(is_pooled_wide(source.type())),
      scale_(scale_of(source.type(), source.range(), options.nan)),
      look_source_(options.looks) {
  const Bytes bytes = bytes_of(source, options);
  const auto bricks = static_cast<std::uint64_t>(grid_.voxel_count());
  if (bricks > kMaxOffset || bytes.tables + bytes.brick > options.memory_bytes) {
    throw Error(ErrorKind::limit_exceeded,
                "memory for bricks is " + std::to_string(options.memory_bytes) +
                    " bytes, and one with what is known of the others needs " +
                    std::to_string(bytes.tables + bytes.brick))
        .with_field("max_memory_bytes");
  }
  const bool is_counted = is_wide_ && look_source_ == nullptr;  // not bytes, but samples
  const std::uint64_t addressed =
      kMaxOffset / (is_counted ? bytes.slot / 4 : bytes.slot);
  capacity_ = static_cast<std::size_t>(
      std::min({bricks, addressed, (options.memory_bytes - bytes.tables) / bytes.brick}));
  // Pages that no brick comes to are never touched.
  samples_ = make_large_pages(capacity_ * bytes.slot + kReadBeyond);
  if (look_source_ != nullptr) {
    looks_.reset(new std::uint16_t[capacity_ * static_cast<std::size_t>(slot_samples_) +
                                   kReadBeyond]);
  }
  used_ = std::make_unique<std::uint8_t[]>(capacity_);
  slots_.assign(bricks, -1);
  brick_bounds_.assign(bricks, 1);
  cube_bounds_.assign(1, 0);  // what rays look at that look at nothing
  seen_cells_.assign(kReadBeyond, 0);
  seen_begins_.assign(bricks, kAnythingSeen);
  bound_of_ = [](float, float, LookSet) { return 1.0f; };
}

SampleRange RayBricks::range() const {
  const SampleRange range = source_.range();
  return {scale_.of_nan < 0 ? scale_.of_nan : scale_.pooled(range.lowest),
          scale_.pooled(range.highest)};
}

Index3 RayBricks::place_of(std::int32_t brick) const {
  const std::int64_t number = brick;
  return {number % grid_.x, number / grid_.x % grid_.y, number / (grid_.x * grid_.y)};
}

std::int32_t RayBricks::number_of(const Index3& place) const {
  return static_cast<std::int32_t>((place.z * grid_.y + place.y) * grid_.x + place.x);
}

Box RayBricks::own_box(std::int32_t brick) const {
  const std::int64_t side = std::int64_t{1} << shift_;
  const Index3 place = place_of(brick);
  const Index3 lo{place.x * side, place.y * side, place.z * side};
  return intersection(box_of(size_), {lo, {lo.x + side, lo.y + side, lo.z + side}});
}

Box RayBricks::held_box(std::int32_t brick) const {
  const Index3 lo = own_box(brick).lo;
  const Index3 first{lo.x - kApronBelow, lo.y - kApronBelow, lo.z - kApronBelow};
  return {first, {first.x + row_, first.y + row_, first.z + row_}};
}

void RayBricks::set_bounds(const BoundOf& bound_of, bool has_cells) {
  set_bounds(
      [bound_of](float lowest, float highest, LookSet) { return bound_of(lowest, highest); },
      has_cells);
}

void RayBricks::set_bounds(LookBoundOf bound_of, bool has_cells) {
  bound_of_ = std::move(bound_of);
  has_cells_ = has_cells;
  unseen_.clear();
  if (has_cells) {
    unseen_ = unseen_ranges(range(), is_wide_ ? kWideMargin : kShortMargin,
                            [this](float lowest, float highest) {
                              return bound_of_(lowest, highest, kAllLooks) > 0;
                            });
  }
  for (std::size_t brick = 0; brick < slots_.size(); ++brick) {
    // Between its last sample and the next of its neighbors as well.
    Box box = own_box(static_cast<std::int32_t>(brick));
    box.hi = {box.hi.x + 1, box.hi.y + 1, box.hi.z + 1};
    const SampleRange range = source_.range(intersection(box_of(size_), box));
    LookSet looks = kAllLooks;
    if (look_source_ != nullptr) {
      // A part's middle lies up to a step from its ends.
      looks = look_source_->within(
          intersection(box_of(size_), held_box(static_cast<std::int32_t>(brick))));
    }
    brick_bounds_[brick] =
        bound_of_(widened(static_cast<float>(scale_.pooled(range.lowest)), -1),
                  widened(static_cast<float>(scale_.pooled(range.highest)), 1), looks);
  }
  parallel_for(std::size_t{0}, occupants_.size(), [&](std::size_t slot) {
    set_cube_bounds(static_cast<std::int32_t>(slot));
  });
  for (std::size_t brick = 0; brick < slots_.size(); ++brick) {
    set_seen_begin(static_cast<std::int32_t>(brick));
  }
}

BrickTables RayBricks::tables() const {
  BrickTables tables;
  tables.samples = samples_.get();
  tables.looks = looks_.get();
  tables.used = used_.get();
  tables.is_wide = is_wide_;
  const SampleRange all = source_.range();
  tables.has_short_differences =
      !is_wide_ && all.highest - all.lowest <= std::numeric_limits<std::int16_t>::max();
  tables.row = static_cast<std::int32_t>(row_);
  tables.plane = static_cast<std::int32_t>(row_ * row_);
  tables.slot = static_cast<std::int32_t>(slot_samples_);
  tables.shift = shift_;
  for (int axis = 0; axis < 3; ++axis) {
    tables.size[static_cast<std::size_t>(axis)] = static_cast<std::int32_t>(size_[axis]);
    tables.grid[static_cast<std::size_t>(axis)] = static_cast<std::int32_t>(grid_[axis]);
  }
  tables.brick_bounds = brick_bounds_.data();
  tables.slots = slots_.data();
  tables.cube_bounds = cube_bounds_.data();
  tables.group_bounds = group_bounds_.data();
  tables.seen_begins = seen_begins_.data();
  tables.seen_cells = seen_cells_.data();
  return tables;
}

void RayBricks::note_uses() {
  load_number_ += 2;
  for (std::size_t slot = 0; slot < occupants_.size(); ++slot) {
    if (used_[slot] != 0) last_uses_[slot] = load_number_;
    used_[slot] = 0;
  }
}

std::vector<std::int32_t> RayBricks::free_slots(std::size_t count) {
  // Those that were never taken, then those that were not used for the longest time.
  std::vector<std::int32_t> free;
  std::vector<std::int32_t> taken(occupants_.size());
  while (free.size() < count && occupants_.size() < capacity_) {
    free.push_back(static_cast<std::int32_t>(occupants_.size()));
    occupants_.push_back(-1);
  }
  last_uses_.resize(occupants_.size());
  cube_ends_.resize(occupants_.size() * cubes_);
  cube_bounds_.resize(occupants_.size() * cubes_);
  group_bounds_.resize(occupants_.size() * groups_);
  seen_cells_.resize(occupants_.size() * seen_bytes(shift_) + kReadBeyond);
  if (look_source_ != nullptr) cube_sets_.resize(occupants_.size() * cubes_);
  if (free.size() == count) return free;
  std::iota(taken.begin(), taken.end(), 0);
  std::stable_sort(taken.begin(), taken.end(), [&](std::int32_t a, std::int32_t b) {
    return last_uses_[static_cast<std::size_t>(a)] < last_uses_[static_cast<std::size_t>(b)];
  });
  for (std::size_t i = 0; free.size() < count; ++i) {
    const std::int32_t occupant = occupants_[static_cast<std::size_t>(taken[i])];
    if (occupant >= 0) {
      slots_[static_cast<std::size_t>(occupant)] = -1;
      set_seen_begin(occupant);
    }
    free.push_back(taken[i]);
  }
  return free;
}

void RayBricks::load(std::span<const std::int32_t> bricks) {
  note_uses();
  const std::vector<std::int32_t> free = free_slots(bricks.size());
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    occupants_[static_cast<std::size_t>(free[i])] = bricks[i];
    last_uses_[static_cast<std::size_t>(free[i])] = load_number_ + 1;
    slots_[static_cast<std::size_t>(bricks[i])] = free[i];
  }
  try {
    load_samples(bricks);
    for (const std::int32_t brick : bricks) set_seen_begin(brick);
  } catch (...) {
    for (const std::int32_t brick : bricks) {
      std::int32_t& slot = slots_[static_cast<std::size_t>(brick)];
      occupants_[static_cast<std::size_t>(slot)] = -1;
      last_uses_[static_cast<std::size_t>(slot)] = 0;
      slot = -1;
      set_seen_begin(brick);
    }
    throw;
  }
  loaded_count_ += static_cast<std::int64_t>(bricks.size());
}

void RayBricks::load_samples(std::span<const std::int32_t> bricks) {
  const auto slot_of = [&](std::size_t i) { return slots_[static_cast<std::size_t>(bricks[i])]; };
  if (look_source_ != nullptr) {
    load_layer(bricks, looks_.get(),
               [&](const Box& box, std::uint16_t* out) { look_source_->read(box, out); });
    parallel_for(std::size_t{0}, bricks.size(), [&](std::size_t i) { find_sets(slot_of(i)); });
  }
  with_voxel_type(source_.type(), [&](auto id) {
    using T = typename decltype(id)::type;
    using Pooled = std::conditional_t<(sizeof(T) > 2), float, std::int16_t>;
    load_layer(bricks, reinterpret_cast<Pooled*>(samples_.get()), [&](const Box& box, Pooled* out) {
      std::vector<T> read(static_cast<std::size_t>(box.size().voxel_count()));
      source_.read(box, read.data());
      for (std::size_t i = 0; i < read.size(); ++i) out[i] = pooled_value<Pooled>(read[i], scale_);
    });
    parallel_for(std::size_t{0}, bricks.size(), [&](std::size_t i) {
      find_ends<Pooled>(slot_of(i));
      set_cube_bounds(slot_of(i));
    });
  });
}

/// Fills a value for each sample of bricks; those of one brick after the other stand in `layer`.
/// read  (box, out) reads a box, dense
template <class Value, class Read>
void RayBricks::load_layer(std::span<const std::int32_t> bricks, Value* layer, const Read& read) {
  parallel_for(std::size_t{0}, bricks.size(), [&](std::size_t i) {
    const Box own = own_box(bricks[i]);
    std::vector<Value> values(static_cast<std::size_t>(own.size().voxel_count()));
    read(own, values.data());
    const std::int32_t slot = slots_[static_cast<std::size_t>(bricks[i])];
    const SampleBlock<Value> to{layer + slot * slot_samples_, held_box(bricks[i])};
    copy_box(SampleBlock<Value>{values.data(), own}, own, to);
  });

  // One task a neighbor: no two write to one place.
  const std::vector<Apron> aprons = aprons_of(bricks);
  std::vector<std::size_t> begins;
  for (std::size_t i = 0; i < aprons.size(); ++i) {
    if (i == 0 || aprons[i].neighbor != aprons[i - 1].neighbor) begins.push_back(i);
  }
  begins.push_back(aprons.size());
  parallel_for(std::size_t{1}, begins.size(), [&](std::size_t i) {
    fill_aprons(std::span(aprons).subspan(begins[i - 1], begins[i] - begins[i - 1]), layer, read);
  });
  parallel_for(std::size_t{0}, bricks.size(),
                    [&](std::size_t i) { repeat_outermost(bricks[i], layer); });
}

std::vector<RayBricks::Apron> RayBricks::aprons_of(std::span<const std::int32_t> bricks) const {
  std::vector<Apron> aprons;
  for (const std::int32_t brick : bricks) {
    const Index3 place = place_of(brick);
    const Box around = intersection(box_of(grid_), {{place.x - 1, place.y - 1, place.z - 1},
                                                    {place.x + 2, place.y + 2, place.z + 2}});
    visit_cells(around, {1, 1, 1}, [&](const Index3& neighbor) {
      if (neighbor != place) aprons.push_back({number_of(neighbor), brick});
      return true;
    });
  }
  std::stable_sort(aprons.begin(), aprons.end(),
                   [](const Apron& a, const Apron& b) { return a.neighbor < b.neighbor; });
  return aprons;
}

/// aprons  of one neighbor
template <class Value, class Read>
void RayBricks::fill_aprons(std::span<const Apron> aprons, Value* layer, const Read& read) {
  const std::int32_t neighbor = aprons.front().neighbor;
  const std::int32_t slot = slots_[static_cast<std::size_t>(neighbor)];
  const Box own = own_box(neighbor);
  SampleBlock<Value> from;
  std::vector<Value> values;
  if (slot >= 0) {
    from = {layer + slot * slot_samples_, held_box(neighbor)};
  } else {
    // All of one that rays may come to: then the source has it at hand. Of others what is needed.
    Box needed;
    for (const Apron& apron : aprons) {
      needed = united(needed, intersection(own, held_box(apron.brick)));
    }
    if (brick_bounds_[static_cast<std::size_t>(neighbor)] > 0) needed = own;
    values.resize(static_cast<std::size_t>(needed.size().voxel_count()));
    read(needed, values.data());
    from = {values.data(), needed};
  }
  for (const Apron& apron : aprons) {
    const Box held = held_box(apron.brick);
    const std::int32_t to = slots_[static_cast<std::size_t>(apron.brick)];
    copy_box(from, intersection(own, held), {layer + to * slot_samples_, held});
  }
}

/// Beyond the volume.
template <class Value>
void RayBricks::repeat_outermost(std::int32_t brick, Value* layer) {
  const Box held = held_box(brick);
  const Box part = intersection(box_of(size_), held);
  if (part == held) return;
  const Box in{{part.lo.x - held.lo.x, part.lo.y - held.lo.y, part.lo.z - held.lo.z},
               {part.hi.x - held.lo.x, part.hi.y - held.lo.y, part.hi.z - held.lo.z}};
  Value* const samples = layer + slots_[static_cast<std::size_t>(brick)] * slot_samples_;
  const auto row_at = [&](std::int64_t y, std::int64_t z) {
    return samples + (z * row_ + y) * row_;
  };
  for (std::int64_t z = 0; z < row_; ++z) {
    const std::int64_t from_z = std::clamp(z, in.lo.z, in.hi.z - 1);
    for (std::int64_t y = 0; y < row_; ++y) {
      const std::int64_t from_y = std::clamp(y, in.lo.y, in.hi.y - 1);
      const Value* const from = row_at(from_y, from_z);
      Value* const to = row_at(y, z);
      if (from != to) std::copy(from + in.lo.x, from + in.hi.x, to + in.lo.x);
      std::fill(to, to + in.lo.x, to[in.lo.x]);
      std::fill(to + in.hi.x, to + row_, to[in.hi.x - 1]);
    }
  }
}

template <class Pooled>
void RayBricks::find_ends(std::int32_t slot) {
  const auto* const samples =
      reinterpret_cast<const Pooled*>(samples_.get()) + slot * slot_samples_;
  const std::int64_t cubes = std::int64_t{1} << (shift_ - kSkipShift);
  const auto length = static_cast<std::size_t>(cubes * kSkipSide + 1);
  std::vector<Pooled> low(length);
  std::vector<Pooled> high(length);
  Ends* ends = cube_ends_.data() + static_cast<std::size_t>(slot) * cubes_;
  for (std::int64_t cz = 0; cz < cubes; ++cz) {
    for (std::int64_t cy = 0; cy < cubes; ++cy) {
      // A row of cubes: their samples and the next ones, row under row.
      std::fill(low.begin(), low.end(), std::numeric_limits<Pooled>::max());
      std::fill(high.begin(), high.end(), std::numeric_limits<Pooled>::lowest());
      for (std::int64_t z = 0; z <= kSkipSide; ++z) {
        for (std::int64_t y = 0; y <= kSkipSide; ++y) {
          add_ends(samples + ((cz * kSkipSide + z + kApronBelow) * row_ +
                              (cy * kSkipSide + y + kApronBelow)) * row_ + kApronBelow,
                   length, low.data(), high.data());
        }
      }
      for (std::int64_t cx = 0; cx < cubes; ++cx) {
        const auto first = static_cast<std::ptrdiff_t>(cx * kSkipSide);
        const auto end = first + kSkipSide + 1;
        *ends++ = {static_cast<float>(*std::min_element(low.begin() + first, low.begin() + end)),
                   static_cast<float>(*std::max_element(high.begin() + first, high.begin() + end))};
      }
    }
  }
}

/// Of each cube with what lies up to an apron around it.
void RayBricks::find_sets(std::int32_t slot) {
  const std::span<const LookSet> sets = look_source_->sets();
  const std::uint16_t* const looks = looks_.get() + slot * slot_samples_;
  const std::int64_t cubes = std::int64_t{1} << (shift_ - kSkipShift);
  constexpr std::int64_t kReach = kSkipSide + kApronBelow + kApronAbove;
  LookSet* const found = cube_sets_.data() + static_cast<std::size_t>(slot) * cubes_;
  std::fill_n(found, cubes_, 0);
  for (std::int64_t z = 0; z < row_; ++z) {
    for (std::int64_t y = 0; y < row_; ++y) {
      const std::uint16_t* const row = looks + (z * row_ + y) * row_;
      for (std::int64_t cx = 0; cx < cubes; ++cx) {
        LookSet in_row = 0;
        for (std::int64_t x = 0; x < kReach; ++x) in_row |= sets[row[cx * kSkipSide + x]];
        if (in_row == 0) continue;
        // The cubes that reach as far as this row.
        for (std::int64_t cz = first_cube(z); cz < cubes && cz * kSkipSide <= z; ++cz) {
          for (std::int64_t cy = first_cube(y); cy < cubes && cy * kSkipSide <= y; ++cy) {
            found[(cz * cubes + cy) * cubes + cx] |= in_row;
          }
        }
      }
    }
  }
}

void RayBricks::set_cube_bounds(std::int32_t slot) {
  const std::size_t first = static_cast<std::size_t>(slot) * cubes_;
  float* const groups = group_bounds_.data() + static_cast<std::size_t>(slot) * groups_;
  std::fill_n(groups, groups_, -std::numeric_limits<float>::infinity());
  const int bits = shift_ - kSkipShift;
  constexpr int kBetween = kGroupShift - kSkipShift;
  for (std::size_t i = first; i < first + cubes_; ++i) {
    cube_bounds_[i] =
        bound_of_(widened(cube_ends_[i].lowest, -1), widened(cube_ends_[i].highest, 1),
                  look_source_ != nullptr ? cube_sets_[i] : kAllLooks);
    const std::size_t cube = i - first;
    const std::size_t x = cube & ((std::size_t{1} << bits) - 1);
    const std::size_t y = cube >> bits & ((std::size_t{1} << bits) - 1);
    const std::size_t z = cube >> 2 * bits;
    const int group_bits = bits - kBetween;
    const std::size_t row = ((z >> kBetween) << group_bits) + (y >> kBetween);
    float& group = groups[(row << group_bits) + (x >> kBetween)];
    group = std::max(group, cube_bounds_[i]);
  }
  if (!has_cells_) return;
  if (is_wide_) mark_cells<float>(slot);
  else mark_cells<std::int16_t>(slot);
}

template <class Pooled>
void RayBricks::mark_cells(std::int32_t slot) {
  SeenBrick<Pooled> brick;
  brick.samples = reinterpret_cast<const Pooled*>(samples_.get()) + slot * slot_samples_ +
                  kApronBelow * (row_ * row_ + row_ + 1);
  brick.row = row_;
  brick.plane = row_ * row_;
  brick.shift = shift_;
  const auto number = static_cast<std::size_t>(slot);
  if (look_source_ != nullptr) brick.cube_bounds = cube_bounds_.data() + number * cubes_;
  mark_seen_cells(brick, unseen_, seen_cells_.data() + number * seen_bytes(shift_));
}

void RayBricks::set_seen_begin(std::int32_t brick) {
  const auto number = static_cast<std::size_t>(brick);
  const std::int32_t slot = slots_[number];
  seen_begins_[number] = !(brick_bounds_[number] > 0)   ? kNothingSeen
                         : slot < 0 || !has_cells_ ? kAnythingSeen
                                                   : slot * static_cast<std::int32_t>(
                                                                seen_bytes(shift_));
}

}  // namespace octavo
