#include "octavo/file/repair/salvage.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <map>
#include <mutex>
#include <set>
#include <utility>

#include "octavo/octree/o_code.h"

namespace octavo {

namespace {

constexpr std::size_t kMaxListed = 1000;

// What a failing disk or a lack of memory hides is not damaged.
bool is_damage(const Error& error) {
  return error.kind() == ErrorKind::corrupt || error.kind() == ErrorKind::limit_exceeded;
}

bool is_voxel(double value, VoxelType type) {
  if (!is_integer(type)) {
    return std::isfinite(value) && std::abs(value) <= std::numeric_limits<float>::max();
  }
  const ValueRange range = value_range(type);
  return value == std::floor(value) && value >= static_cast<double>(range.min) &&
         value <= static_cast<double>(range.max);
}

}  // namespace

// The voxels of one brick that are to be filled, and where they go.
struct SalvageReader::Part {
  int level;
  Index3 brick;
  Box box;  ///< in samples of the level, inside the brick
  std::uint8_t* out;
  std::int64_t row_stride;
  std::int64_t plane_stride;
  std::size_t voxel_bytes;

  std::uint8_t* row(std::int64_t y, std::int64_t z) const {
    const std::int64_t at = (z - box.lo.z) * plane_stride + (y - box.lo.y) * row_stride;
    return out + static_cast<std::size_t>(at) * voxel_bytes;
  }

  void fill_with(VoxelType type, double value) const {
    with_voxel_type(type, [&](auto tag) {
      using T = typename decltype(tag)::type;
      const T voxel = static_cast<T>(value);
      for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
        for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
          std::uint8_t* to = row(y, z);
          for (std::int64_t x = box.lo.x; x < box.hi.x; ++x, to += sizeof(T)) {
            std::memcpy(to, &voxel, sizeof(T));
          }
        }
      }
    });
  }
};

struct SalvageReader::Ledger {
  std::mutex mutex;
  std::set<std::pair<int, std::uint64_t>> bricks;  ///< level and o-code of each brick filled
  std::set<std::uint64_t> offsets;                 ///< of the damages met
  std::map<std::uint64_t, SalvagedDamage> damages;

  // A level of a brick that is filled piece by piece counts once. Of several bricks behind one
  // damage the one that comes first is reported, so that threads do not matter.
  void enter(const SalvagedDamage& salvaged, int level, std::uint64_t code) {
    const std::lock_guard lock(mutex);
    if (!bricks.emplace(level, code).second) return;
    offsets.insert(salvaged.offset);
    const auto [place, is_new] = damages.emplace(salvaged.offset, salvaged);
    SalvagedDamage& kept = place->second;
    if (!is_new && code < interleave(kept.brick)) {
      const std::int64_t count = kept.brick_count;
      kept = salvaged;
      kept.brick_count = count;
    }
    ++kept.brick_count;
    if (damages.size() > kMaxListed) damages.erase(std::prev(damages.end()));
  }
};

SalvageReader::SalvageReader(std::shared_ptr<const FileReader> inner,
                             const SalvageOptions& options)
    : inner_(std::move(inner)), options_(options), ledger_(std::make_unique<Ledger>()) {
  const VoxelType type = description().type;
  if (!options_.value || is_voxel(*options_.value, type)) return;
  throw Error(ErrorKind::invalid_argument,
              "a fill of stored value " + std::to_string(*options_.value) + "; voxels are " +
                  std::string(voxel_type_name(type)),
              source().name());
}

SalvageReader::~SalvageReader() = default;

SalvageReport SalvageReader::report() const {
  const std::lock_guard lock(ledger_->mutex);
  SalvageReport report;
  report.brick_count = static_cast<std::int64_t>(ledger_->bricks.size());
  report.damage_count = static_cast<std::int64_t>(ledger_->offsets.size());
  for (const auto& [offset, damage] : ledger_->damages) report.damages.push_back(damage);
  return report;
}

ValueRange SalvageReader::range() const {
  ValueRange range = inner_->range();
  if (!options_.value || !is_integer(description().type)) return range;
  const auto value = static_cast<std::int64_t>(*options_.value);
  return {std::min(range.min, value), std::max(range.max, value)};
}

void SalvageReader::read_brick(const BrickEntry& entry, int in_brick_level, void* out) const {
  try {
    inner_->read_brick(entry, in_brick_level, out);
  } catch (const Error& error) {
    if (!is_damage(error)) throw;
    const int level = Levels::first_level(entry.tier) + in_brick_level;
    const Box box = brick_box_at(levels(), level, entry.brick);
    const Size3 size = box.size();
    fill({level, entry.brick, box, static_cast<std::uint8_t*>(out), size.x, size.x * size.y,
          static_cast<std::size_t>(bytes_per_voxel(description().type))},
         error);
  }
}

void SalvageReader::read(const Box& box, int level, void* out) const {
  const Size3 size = box.size();
  read_strided(box, level, out, size.x, size.x * size.y);
}

void SalvageReader::read_strided(const Box& box, int level, void* out, std::int64_t row_stride,
                                 std::int64_t plane_stride) const {
  const bool is_inside = level >= 0 && level < levels().count() && !box.is_empty() &&
                         box_of(levels().size(level)).contains(box);
  if (!is_inside) return inner_->read_strided(box, level, out, row_stride, plane_stride);
  const auto voxel_bytes = static_cast<std::size_t>(bytes_per_voxel(description().type));
  const Size3 side = brick_side_at(levels(), level);
  Index3 brick;
  for (brick.z = box.lo.z / side.z; brick.z * side.z < box.hi.z; ++brick.z) {
    for (brick.y = box.lo.y / side.y; brick.y * side.y < box.hi.y; ++brick.y) {
      for (brick.x = box.lo.x / side.x; brick.x * side.x < box.hi.x; ++brick.x) {
        const Box inside = intersection(box, brick_box_at(levels(), level, brick));
        const std::int64_t at = (inside.lo.z - box.lo.z) * plane_stride +
                                (inside.lo.y - box.lo.y) * row_stride + inside.lo.x - box.lo.x;
        std::uint8_t* to =
            static_cast<std::uint8_t*>(out) + static_cast<std::size_t>(at) * voxel_bytes;
        try {
          inner_->read_strided(inside, level, to, row_stride, plane_stride);
        } catch (const Error& error) {
          if (!is_damage(error)) throw;
          fill({level, brick, inside, to, row_stride, plane_stride, voxel_bytes}, error);
        }
      }
    }
  }
}

void SalvageReader::fill(const Part& part, const Error& damage) const {
  SalvagedDamage salvaged = fill_part(part);
  salvaged.detail = damage.detail();
  salvaged.offset = damage.offset().value_or(0);
  salvaged.brick = part.brick;
  salvaged.tier = Levels::tier_of(part.level);
  ledger_->enter(salvaged, part.level, interleave(part.brick));
}

SalvagedDamage SalvageReader::fill_part(const Part& part) const {
  SalvagedDamage salvaged;
  if (options_.from_coarser && fill_from_coarser(part, salvaged)) return salvaged;
  if (options_.value) {
    salvaged.value = *options_.value;
    part.fill_with(description().type, salvaged.value);
  } else {
    fill_with_lowest(part, salvaged);
  }
  return salvaged;
}

// Samples of a coarser level, each repeated over the voxels it stands for.
bool SalvageReader::fill_from_coarser(const Part& part, SalvagedDamage& salvaged) const {
  for (int level = part.level + 1; level < levels().count(); ++level) {
    Box box;
    Index3 shift;
    for (int axis = 0; axis < 3; ++axis) {
      shift[axis] = levels().halving_count(level, axis) - levels().halving_count(part.level, axis);
      box.lo[axis] = part.box.lo[axis] >> shift[axis];
      box.hi[axis] = ((part.box.hi[axis] - 1) >> shift[axis]) + 1;
    }
    const Size3 size = box.size();
    Bytes samples(static_cast<std::size_t>(size.voxel_count()) * part.voxel_bytes);
    try {
      inner_->read(box, level, samples.data());
    } catch (const Error& error) {
      if (!is_damage(error)) throw;
      continue;
    }
    for (std::int64_t z = part.box.lo.z; z < part.box.hi.z; ++z) {
      for (std::int64_t y = part.box.lo.y; y < part.box.hi.y; ++y) {
        std::uint8_t* to = part.row(y, z);
        const std::int64_t row =
            (((z >> shift.z) - box.lo.z) * size.y + (y >> shift.y) - box.lo.y) * size.x;
        for (std::int64_t x = part.box.lo.x; x < part.box.hi.x; ++x, to += part.voxel_bytes) {
          const auto at = static_cast<std::size_t>(row + (x >> shift.x) - box.lo.x);
          std::memcpy(to, samples.data() + at * part.voxel_bytes, part.voxel_bytes);
        }
      }
    }
    salvaged.fill = SalvageFill::coarser_level;
    salvaged.level = level;
    return true;
  }
  return false;
}

void SalvageReader::fill_with_lowest(const Part& part, SalvagedDamage& salvaged) const {
  ValueRange range;
  try {
    range = inner_->brick(Levels::tier_of(part.level), part.brick).range;
    salvaged.fill = SalvageFill::brick_lowest;
  } catch (const Error& error) {
    if (!is_damage(error)) throw;
    range = inner_->range();
    salvaged.fill = SalvageFill::volume_lowest;
  }
  const bool falls = description().rescale.slope < 0;
  salvaged.value = description().voxel_of(description().code_near(falls ? range.max : range.min));
  part.fill_with(description().type, salvaged.value);
}

}  // namespace octavo
