#include "octavo/codec/grey/value_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include "octavo/codec/grey/voxel_walk.h"

namespace octavo::grey {

namespace {

/// With fewer steps between the smallest and the largest value, means take parts of a step.
constexpr std::int64_t kFewSteps = 32;
/// These parts are so many: as many as the values of a byte, which gaps can be among; where a step
/// has no such parts, more, or at least as many as kFewSteps.
constexpr std::int64_t kMeanParts = 128;
constexpr std::int64_t kMostParts = 255;
constexpr std::int64_t kManyParts = 1 << 16;
/// Gaps between values are left out of account when they save fewer bits per voxel.
constexpr double kWorthwhileBits = 0.05;
/// Voxels per value that tell a rule from chance: that values lie a step apart, and that some do
/// not occur.
constexpr std::int64_t kEnoughForLattice = 8;
constexpr std::int64_t kEnoughForGaps = 64;
/// Values this far away tell how many of its neighbors a value has.
constexpr std::int64_t kNeighborhood = 4;
/// A brick with more values of its own does without gaps.
constexpr std::size_t kMaxExtras = 16;

constexpr std::uint8_t kLatticeFlag = 1;
constexpr std::uint8_t kGapsFlag = 2;

/// Smallest and largest value of some bricks and the step all their values lie apart.
struct ValueStep {
  std::int64_t min = 0;
  std::int64_t max = 0;
  std::int64_t step = 0;

  /// Whether nothing more can come of it: too many values for gaps, too close for a lattice.
  bool is_hopeless() const {
    return step == 1 && max - min >= static_cast<std::int64_t>(kMaxMappedCodes);
  }
};

ValueStep step_of(std::span<const TrainingBrick> bricks) {
  std::optional<ValueStep> found;
  for (const TrainingBrick& brick : bricks) {
    for_each_row(brick.view, [&](const auto* row) {
      if (!found) found = {std::int64_t{row[0]}, std::int64_t{row[0]}, 0};
      if (found->is_hopeless()) return;
      const std::int64_t origin = found->min;
      for (std::int64_t x = 0; x < brick.view.size.x; ++x) {
        const std::int64_t voxel = row[x];
        found->min = std::min(found->min, voxel);
        found->max = std::max(found->max, voxel);
        if (found->step == 1) continue;
        if (found->step == 0 || (voxel - origin) % found->step != 0) {
          found->step = std::gcd(found->step, voxel - origin);
        }
      }
    });
  }
  return found.value_or(ValueStep{});
}

/// How often each code from `first` on occurs.
std::vector<std::int64_t> count_codes(std::span<const TrainingBrick> bricks, const CodeScale& scale,
                                      std::int64_t first, std::size_t count) {
  std::vector<std::int64_t> counts(count);
  for (const TrainingBrick& brick : bricks) {
    for_each_voxel(brick.view, [&](std::int64_t voxel) {
      ++counts[static_cast<std::size_t>(scale.code_of(voxel) - first)];
    });
  }
  return counts;
}

/// Bits per voxel that gaps save: a voxel is one of fewer where its neighbors do not occur.
double predicted_saving(const std::vector<std::int64_t>& counts) {
  const auto last = static_cast<std::int64_t>(counts.size()) - 1;
  double bits = 0;
  double voxels = 0;
  for (std::int64_t code = 0; code <= last; ++code) {
    const std::int64_t from = std::max<std::int64_t>(code - kNeighborhood, 0);
    const std::int64_t to = std::min(code + kNeighborhood, last);
    std::int64_t used = 0;
    for (std::int64_t near = from; near <= to; ++near) {
      used += counts[static_cast<std::size_t>(near)] > 0;
    }
    const auto count = static_cast<double>(counts[static_cast<std::size_t>(code)]);
    if (count == 0) continue;
    bits += count * std::log2(static_cast<double>(to - from + 1) / static_cast<double>(used));
    voxels += count;
  }
  return bits / voxels;
}

/// The step of a lattice for values that lie `step` apart, so many of them: that one, or a part of
/// it where means need finer ones.
std::int64_t lattice_step(std::int64_t step, std::int64_t steps) {
  if (steps >= kFewSteps) return step;
  const auto parts_for = [&](std::int64_t all) { return (all + steps - 1) / steps; };
  const std::int64_t most = kMostParts / steps;
  for (std::int64_t parts = most; parts >= parts_for(kMeanParts); --parts) {
    if (step % parts == 0) return step / parts;
  }
  for (std::int64_t parts = most + 1; parts <= std::min(step, kManyParts); ++parts) {
    if (step % parts == 0) return step / parts;
  }
  for (std::int64_t parts = parts_for(kMeanParts); parts >= parts_for(kFewSteps); --parts) {
    if (step % parts == 0) return step / parts;
  }
  return 1;
}

}  // namespace

ValueMap learn_value_map(std::span<const TrainingBrick> bricks, bool finds_gaps) {
  ValueMap map;
  const ValueStep values = step_of(bricks);
  if (values.min == values.max || values.is_hopeless()) return map;
  std::int64_t voxels = 0;
  for (const TrainingBrick& brick : bricks) voxels += brick.view.size.voxel_count();
  const std::int64_t steps = (values.max - values.min) / values.step;
  const std::int64_t step = lattice_step(values.step, steps);
  if (step > 1 && step <= kMaxLatticeStep && voxels >= kEnoughForLattice * steps) {
    const std::int64_t offset = values.min % step;
    map.lattice = {step, offset < 0 ? offset + step : offset};
  }
  const std::int64_t first = map.lattice.code_of(values.min);
  const std::int64_t codes = map.lattice.code_of(values.max) - first + 1;
  if (!finds_gaps || codes > static_cast<std::int64_t>(kMaxMappedCodes)) return map;
  const auto counts = count_codes(bricks, map.lattice, first, static_cast<std::size_t>(codes));
  if (voxels < kEnoughForGaps * codes || predicted_saving(counts) < kWorthwhileBits) return map;
  map.first = first;
  for (const std::int64_t count : counts) map.used.push_back(count > 0 ? 1 : 0);
  return map;
}

bool has_few_values(std::span<const TrainingBrick> bricks) {
  constexpr std::size_t kFew = 16;
  std::vector<std::int64_t> values;
  for (const TrainingBrick& brick : bricks) {
    for_each_row(brick.view, [&](const auto* row) {
      if (values.size() > kFew) return;
      for (std::int64_t x = 0; x < brick.view.size.x; ++x) {
        const bool is_known = (x > 0 && row[x] == row[x - 1]) ||
                              std::find(values.begin(), values.end(), std::int64_t{row[x]}) !=
                                  values.end();
        if (!is_known) values.push_back(row[x]);
        if (values.size() > kFew) return;
      }
    });
    if (values.size() > kFew) return false;
  }
  return true;
}

void put_value_map(Bytes& out, const ValueMap& map) {
  put_varint(out, static_cast<std::uint64_t>(map.lattice.step));
  put_varint(out, static_cast<std::uint64_t>(map.lattice.offset));
  put_varint(out, map.used.size());
  if (map.used.empty()) return;
  put_varint(out, zigzag(map.first));
  BitWriter bits(out);
  for (const std::uint8_t is_used : map.used) bits.put(is_used, 1);
  bits.finish();
}

ValueMap take_value_map(ByteSpan& bytes) {
  ValueMap map;
  const std::uint64_t step = take_varint(bytes);
  const std::uint64_t offset = take_varint(bytes);
  const std::uint64_t count = take_varint(bytes);
  if (step < 1 || step > kMaxLatticeStep || offset >= step || count > kMaxMappedCodes) {
    throw Error(ErrorKind::corrupt, "model: bad value map");
  }
  map.lattice = {static_cast<std::int64_t>(step), static_cast<std::int64_t>(offset)};
  if (count == 0) return map;
  map.first = unzigzag(take_varint(bytes));
  if (map.first < -kMaxLatticeStep || map.first > kMaxLatticeStep) {
    throw Error(ErrorKind::corrupt, "model: a code out of range");
  }
  BitReader bits(take_bytes(bytes, (count + 7) / 8));
  for (std::uint64_t i = 0; i < count; ++i) {
    map.used.push_back(static_cast<std::uint8_t>(bits.get(1)));
  }
  if (map.used.front() == 0 || map.used.back() == 0) {
    throw Error(ErrorKind::corrupt, "model: a value map that begins or ends with a gap");
  }
  return map;
}

BrickMap map_brick(const ValueMap& map, const BrickView& brick, const ValueRange& range,
                   bool wants_gaps) {
  BrickMap result;
  if (map.lattice.step > 1) {
    bool is_on_lattice = true;
    for_each_voxel(brick, [&](std::int64_t voxel) {
      is_on_lattice = is_on_lattice && (voxel - map.lattice.offset) % map.lattice.step == 0;
    });
    result.is_on_lattice = is_on_lattice;
  }
  const CodeScale scale = result.scale(map);
  const std::int64_t lowest = scale.code_of(range.min);
  const std::int64_t codes = scale.code_of(range.max) - lowest + 1;
  if (!wants_gaps || map.used.empty() || codes > static_cast<std::int64_t>(kMaxMappedCodes) ||
      result.is_on_lattice != (map.lattice.step > 1)) {
    return result;
  }
  std::array<bool, kMaxMappedCodes> occurs{};
  for_each_voxel(brick, [&](std::int64_t voxel) {
    occurs[static_cast<std::size_t>(scale.code_of(voxel) - lowest)] = true;
  });
  for (std::int64_t code = 0; code < codes; ++code) {
    const std::int64_t place = lowest + code - map.first;
    const bool is_known = place >= 0 && place < static_cast<std::int64_t>(map.used.size()) &&
                          map.used[static_cast<std::size_t>(place)] != 0;
    if (occurs[static_cast<std::size_t>(code)] && !is_known) {
      result.extras.push_back(static_cast<std::uint8_t>(code));
    }
  }
  result.has_gaps = result.extras.size() <= kMaxExtras;
  if (!result.has_gaps) result.extras.clear();
  return result;
}

void put_brick_map(Bytes& out, const BrickMap& brick) {
  out.push_back(static_cast<std::uint8_t>((brick.is_on_lattice ? kLatticeFlag : 0) |
                                          (brick.has_gaps ? kGapsFlag : 0)));
  if (!brick.has_gaps) return;
  out.push_back(static_cast<std::uint8_t>(brick.extras.size()));
  out.insert(out.end(), brick.extras.begin(), brick.extras.end());
}

BrickMap take_brick_map(const ValueMap& map, const ValueRange& range, ByteSpan& bytes) {
  BrickMap brick;
  const std::uint8_t flags = take_bytes(bytes, 1).front();
  brick.is_on_lattice = (flags & kLatticeFlag) != 0;
  brick.has_gaps = (flags & kGapsFlag) != 0;
  if (flags > (kLatticeFlag | kGapsFlag)) {
    throw Error(ErrorKind::unsupported_version,
                "a brick whose map of values is of a later version of the format");
  }
  if (brick.has_gaps && map.used.empty()) {
    throw Error(ErrorKind::corrupt, "a brick has gaps that its model does not know");
  }
  if (!brick.has_gaps) return brick;
  const ByteSpan extras = take_bytes(bytes, take_bytes(bytes, 1).front());
  brick.extras.assign(extras.begin(), extras.end());
  const CodeScale scale = brick.scale(map);
  if (scale.code_of(range.max) - scale.code_of(range.min) >=
      static_cast<std::int64_t>(kMaxMappedCodes)) {
    throw Error(ErrorKind::corrupt, "a brick with gaps has too many values");
  }
  return brick;
}

ValueGaps::ValueGaps(std::int64_t lowest, std::span<const std::uint8_t> used, int rounding)
    : lowest_(lowest),
      last_(static_cast<std::int64_t>(used.size()) - 1),
      used_(used.begin(), used.end()),
      details_(new Details[used.size()]) {  // not cleared: most of it is never looked at
  // One more at either end, which no value takes
  const auto count = static_cast<int>(used.size());
  std::vector<std::uint8_t> around(used.size() + 2);
  std::transform(used.begin(), used.end(), around.begin() + 1,
                 [](std::uint8_t flag) { return static_cast<std::uint8_t>(flag != 0 ? 1 : 0); });
  const std::uint8_t* const occurs = around.data() + 1;
  for (int mean = 0; mean < count; ++mean) {
    Details& row = details_[static_cast<std::size_t>(mean)];
    // The two samples add up to `sum` or to one more. Details rise with the first sample, without
    // a branch: whether two values occur is anyone's guess.
    const int sum = 2 * mean - rounding;
    const int last_first = std::min(count - 1, sum + 1);
    int number = 0;
    for (int a = std::max(0, sum - count + 1); a <= last_first; ++a) {
      const int detail = 2 * a - sum;
      row.values[number] = static_cast<std::int16_t>(detail - 1);
      number += occurs[a] & occurs[sum + 1 - a];
      row.values[number] = static_cast<std::int16_t>(detail);
      number += occurs[a] & occurs[sum - a];
    }
    if (number == 0) row.values[number++] = 0;
    row.last = number - 1;
    // A number stands up to the middle between its detail and the next one.
    int next = 0;
    for (int k = 0; k < number; ++k) {
      const int end = k == row.last ? 2 * kReach + 1
                                    : ((row.values[k] + row.values[k + 1]) >> 1) + kReach + 1;
      // Most have few places: what is written too far the next one overwrites.
      std::uint16_t together[kTogether];
      std::fill_n(together, kTogether, static_cast<std::uint16_t>(k));
      for (; next < end; next += kTogether) {
        std::copy_n(together, kTogether, row.numbers + next);
      }
      next = end;
    }
  }
}

ValueGaps make_gaps(const ValueMap& map, const BrickMap& brick, const ValueRange& codes,
                    std::int64_t lowest_sample, int rounding) {
  std::vector<std::uint8_t> used(static_cast<std::size_t>(codes.max - codes.min + 1));
  for (std::size_t i = 0; i < used.size(); ++i) {
    const std::int64_t place = codes.min + static_cast<std::int64_t>(i) - map.first;
    if (place >= 0 && place < static_cast<std::int64_t>(map.used.size())) {
      used[i] = map.used[static_cast<std::size_t>(place)];
    }
  }
  for (const std::uint8_t extra : brick.extras) {
    if (extra < used.size()) used[extra] = 1;
  }
  return {lowest_sample, used, rounding};
}

}  // namespace octavo::grey
