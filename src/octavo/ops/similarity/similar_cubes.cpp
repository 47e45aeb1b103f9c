#include "octavo/ops/similarity/similar_cubes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <numeric>
#include <optional>
#include <unordered_map>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/octree/o_code.h"
#include "octavo/ops/similarity/cube_turns.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr int kCoarsestLevel = 4;
constexpr int kFinestLevel = 2;
constexpr std::size_t kBatch = 2048;            // cubes that are asked side by side
constexpr std::size_t kMostNeighbors = 1024;    // in the hash, of one cube
constexpr std::size_t kMostHashed = 6;          // numbers that make a key where T > 0
constexpr std::uint32_t kNobody = ~std::uint32_t{0};

/// A cube that is asked for, or referred to.
struct SeenCube {
  std::vector<std::int32_t> voxels;
  std::vector<std::int32_t> invariants;
  std::int32_t mean = 0;
  bool is_uniform = false;
};

struct CubeMatch {
  std::uint32_t entry = kNobody;
  int turn = 0;
  bool is_cut_short = false;
};

/// Cubes that references may point to, found by numbers that turns do not change.
class CubeHash {
 public:
  struct Entry {
    Index3 corner;
    bool is_coarser = false;
    std::int32_t mean = 0;
  };
  using Fetch = std::function<std::vector<std::int32_t>(const Entry&)>;

  /// fetch  gives the voxels of an entry, on any thread
  CubeHash(const CubeTurns& turns, std::int32_t most, Fetch fetch)
      : turns_(turns),
        fetch_(std::move(fetch)),
        most_(most),
        width_(4 * most + 1),
        hashed_(most == 0 ? turns.invariant_count()
                          : std::min(kMostHashed, turns.invariant_count())) {}

  std::uint32_t size() const { return static_cast<std::uint32_t>(entries_.size()); }
  const Entry& entry(std::uint32_t i) const { return entries_[i]; }

  void add(const Index3& corner, bool is_coarser, const SeenCube& cube) {
    std::vector<std::int32_t> cells(hashed_);
    for (std::size_t i = 0; i < hashed_; ++i) cells[i] = cell_of(cube.invariants[number(i)]);
    buckets_[key_of(cells)].push_back(size());
    invariants_.insert(invariants_.end(), cube.invariants.begin(), cube.invariants.end());
    entries_.push_back({corner, is_coarser, cube.mean});
  }

  /// The first entry from `first` on that a turn lays onto the cube.
  CubeMatch find(const SeenCube& cube, std::uint32_t first) const {
    CubeMatch match;
    std::size_t left = kMostNeighbors;
    std::vector<std::int32_t> low(hashed_);
    std::vector<std::int32_t> span(hashed_);
    for (std::size_t i = 0; i < hashed_; ++i) {
      low[i] = cell_of(cube.invariants[number(i)] - most_);
      span[i] = cell_of(cube.invariants[number(i)] + most_) - low[i];
    }
    std::vector<std::int32_t> cells = low;
    for (;;) {
      if (look_in(cells, cube, first, left, match)) return match;
      // The next of all cells that are within reach.
      std::size_t i = 0;
      while (i < hashed_ && cells[i] == low[i] + span[i]) cells[i] = low[i], ++i;
      if (i == hashed_) return match;
      ++cells[i];
    }
  }

 private:
  /// Which numbers make the key: the ends first, then some of each orbit.
  std::size_t number(std::size_t i) const {
    if (most_ == 0 || i < 2) return i;
    constexpr std::array<std::size_t, 4> kOfOrbits = {2, 9, 10, 17};
    return kOfOrbits[i - 2];
  }

  std::int32_t cell_of(std::int32_t value) const {
    return value >= 0 ? value / width_ : -((width_ - 1 - value) / width_);
  }

  static std::uint64_t key_of(const std::vector<std::int32_t>& cells) {
    std::uint64_t key = 0xcbf29ce484222325;
    for (const std::int32_t cell : cells) {
      key = (key ^ static_cast<std::uint32_t>(cell)) * 0x9e3779b97f4a7c15;
      key ^= key >> 29;
    }
    return key;
  }

  bool look_in(const std::vector<std::int32_t>& cells, const SeenCube& cube, std::uint32_t first,
               std::size_t& left, CubeMatch& match) const {
    const auto bucket = buckets_.find(key_of(cells));
    if (bucket == buckets_.end()) return false;
    const std::vector<std::uint32_t>& all = bucket->second;
    const std::size_t count = turns_.invariant_count();
    for (auto at = std::lower_bound(all.begin(), all.end(), first); at != all.end(); ++at) {
      if (left-- == 0) {
        match.is_cut_short = true;
        left = 0;
        return true;
      }
      const std::int32_t* const other = invariants_.data() + *at * count;
      bool is_near = true;
      for (std::size_t i = 0; is_near && i < count; ++i) {
        is_near = std::abs(cube.invariants[i] - other[i]) <= most_;
      }
      if (!is_near) continue;
      const Entry& entry = entries_[*at];
      const int turn =
          turns_.matching_turn(cube.voxels, cube.mean, fetch_(entry), entry.mean, most_);
      if (turn < 0) continue;
      match = {*at, turn, false};
      return true;
    }
    return false;
  }

  const CubeTurns& turns_;
  Fetch fetch_;
  std::int32_t most_;
  std::int32_t width_;
  std::size_t hashed_;
  std::vector<Entry> entries_;
  std::vector<std::int32_t> invariants_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> buckets_;
};

class SimilarWork {
 public:
  SimilarWork(std::span<const std::int32_t> voxels, const Size3& size,
              const SimilarityOptions& options, Progress& progress)
      : voxels_(voxels), size_(size), options_(options), progress_(progress) {
    for (int axis = 0; axis < 3; ++axis) {
      cells_[axis] = (size[axis] + cube_side(kFinestLevel) - 1) >> kFinestLevel;
    }
    states_.assign(static_cast<std::size_t>(cells_.voxel_count()), kPlain);
  }

  SimilarCubes of_level(int level) {
    const CubeTurns turns(static_cast<int>(cube_side(level)));
    turns_ = &turns;
    hash_.emplace(turns, options_.max_difference, [this](const CubeHash::Entry& entry) {
      return voxels_of(entry.corner, entry.is_coarser);
    });
    found_ = {};
    found_.level = level;
    const std::vector<std::uint64_t> codes = codes_of(level);
    found_.cubes = codes.size();
    for (std::size_t begin = 0; begin < codes.size(); begin += kBatch) {
      if (progress_.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
      const std::size_t end = std::min(codes.size(), begin + kBatch);
      take_batch(std::span(codes).subspan(begin, end - begin));
      progress_.advance(static_cast<std::int64_t>(end - begin));
    }
    add_flag_bits();
    return std::move(found_);
  }

  /// Cubes of a level that lie in the volume, in o-code order.
  std::vector<std::uint64_t> codes_of(int level) const {
    std::vector<std::uint64_t> codes;
    for (std::int64_t z = 0; z < size_.z >> level; ++z) {
      for (std::int64_t y = 0; y < size_.y >> level; ++y) {
        for (std::int64_t x = 0; x < size_.x >> level; ++x) codes.push_back(interleave({x, y, z}));
      }
    }
    std::sort(codes.begin(), codes.end());
    return codes;
  }

 private:
  enum State : std::uint8_t { kPlain, kReplaced, kInUse };

  template <class Visit>
  void visit_cells_of(const Box& box, Visit&& visit) const {
    for (std::int64_t z = box.lo.z >> kFinestLevel; z << kFinestLevel < box.hi.z; ++z) {
      for (std::int64_t y = box.lo.y >> kFinestLevel; y << kFinestLevel < box.hi.y; ++y) {
        for (std::int64_t x = box.lo.x >> kFinestLevel; x << kFinestLevel < box.hi.x; ++x) {
          visit(static_cast<std::size_t>((z * cells_.y + y) * cells_.x + x));
        }
      }
    }
  }

  bool has_state(const Box& box, State state) const {
    bool has = false;
    visit_cells_of(box, [&](std::size_t i) { has = has || states_[i] == state; });
    return has;
  }

  void set_state(const Box& box, State state) {
    visit_cells_of(box, [&](std::size_t i) { states_[i] = state; });
  }

  /// The voxels of a cube, or the means of the octants of one of twice the side.
  std::vector<std::int32_t> voxels_of(const Index3& corner, bool is_coarser) const {
    std::vector<std::int32_t> voxels;
    const int side = turns_->side();
    voxels.reserve(turns_->voxel_count());
    for (int z = 0; z < side; ++z) {
      for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) {
          voxels.push_back(is_coarser
                               ? octant_mean({corner.x + 2 * x, corner.y + 2 * y, corner.z + 2 * z})
                               : voxel({corner.x + x, corner.y + y, corner.z + z}));
        }
      }
    }
    return voxels;
  }

  SeenCube seen(const Index3& corner, bool is_coarser) const {
    SeenCube cube;
    cube.voxels = voxels_of(corner, is_coarser);
    const auto total = std::accumulate(cube.voxels.begin(), cube.voxels.end(), std::int64_t{0});
    const auto count = static_cast<std::int64_t>(cube.voxels.size());
    if (options_.is_up_to_mean) cube.mean = rounded_mean(total, count);
    cube.invariants.resize(turns_->invariant_count());
    turns_->invariants(cube.voxels, cube.mean, cube.invariants);
    cube.is_uniform = cube.invariants[0] == cube.invariants[1];
    return cube;
  }

  std::int32_t voxel(const Index3& p) const {
    return voxels_[static_cast<std::size_t>((p.z * size_.y + p.y) * size_.x + p.x)];
  }

  std::int32_t octant_mean(const Index3& lo) const {
    std::int64_t total = 0;
    for (int i = 0; i < 8; ++i) {
      total += voxel({lo.x + (i & 1), lo.y + (i >> 1 & 1), lo.z + (i >> 2)});
    }
    return rounded_mean(total, 8);
  }

  /// Halves rounded up.
  static std::int32_t rounded_mean(std::int64_t total, std::int64_t count) {
    const std::int64_t twice = 2 * total + count;
    const std::int64_t by = 2 * count;
    const std::int64_t floor = twice >= 0 ? twice / by : -((by - 1 - twice) / by);
    return static_cast<std::int32_t>(floor);
  }

  void take_batch(std::span<const std::uint64_t> codes) {
    // All against what was there before the batch.
    std::vector<SeenCube> cubes(codes.size());
    std::vector<CubeMatch> matches(codes.size());
    std::vector<std::uint8_t> is_asked(codes.size());
    parallel_for(std::size_t{0}, codes.size(), [&](std::size_t i) {
      const Box box = box_of(OCode{found_.level, codes[i]});
      cubes[i] = seen(box.lo, false);
      is_asked[i] = !cubes[i].is_uniform && !has_state(box, kReplaced) && !has_state(box, kInUse);
      if (is_asked[i] != 0) matches[i] = hash_->find(cubes[i], 0);
    });
    // One after the other against what the batch adds.
    const std::uint32_t before = hash_->size();
    for (std::size_t i = 0; i < codes.size(); ++i) {
      const Box box = box_of(OCode{found_.level, codes[i]});
      if (cubes[i].is_uniform) ++found_.uniform;
      CubeMatch match = matches[i];
      if (is_asked[i] != 0 && !has_state(box, kInUse)) {
        ++found_.asked;
        const bool was_cut_short = match.is_cut_short;
        if (match.entry == kNobody) match = hash_->find(cubes[i], before);
        if (match.entry != kNobody) {
          refer(box, match);
        } else if (was_cut_short || match.is_cut_short) {
          ++found_.cut_short;
        }
      }
      if (!cubes[i].is_uniform && !has_state(box, kReplaced)) {
        hash_->add(box.lo, false, cubes[i]);
      }
      if ((codes[i] & 7) == 7) add_parent(parent_of(OCode{found_.level, codes[i]}));
    }
  }

  /// The cube whose last child was taken, where it lies in the volume and is kept as it is.
  void add_parent(const OCode& parent) {
    const Box box = box_of(parent);
    for (int axis = 0; axis < 3; ++axis) {
      if (box.hi[axis] > size_[axis]) return;
    }
    if (has_state(box, kReplaced)) return;
    const SeenCube cube = seen(box.lo, true);
    if (!cube.is_uniform) hash_->add(box.lo, true, cube);
  }

  void refer(const Box& box, const CubeMatch& match) {
    const CubeHash::Entry& to = hash_->entry(match.entry);
    const std::int64_t side = (to.is_coarser ? 2 : 1) * cube_side(found_.level);
    set_state({to.corner, {to.corner.x + side, to.corner.y + side, to.corner.z + side}}, kInUse);
    set_state(box, kReplaced);
    found_.references.push_back({box.lo, to.is_coarser, match.turn != 0});
    found_.reference_bits += std::log2(static_cast<double>(hash_->size())) + std::log2(kCubeTurns);
  }

  void add_flag_bits() {
    const auto asked = static_cast<double>(found_.asked);
    const auto referring = static_cast<double>(found_.references.size());
    for (const double part : {referring, asked - referring}) {
      if (part > 0) found_.reference_bits += part * std::log2(asked / part);
    }
  }

  std::span<const std::int32_t> voxels_;
  Size3 size_;
  SimilarityOptions options_;
  Progress& progress_;
  Size3 cells_;
  std::vector<std::uint8_t> states_;  // of cubes of the finest level that is asked
  const CubeTurns* turns_ = nullptr;
  std::optional<CubeHash> hash_;
  SimilarCubes found_;
};

}  // namespace

std::vector<SimilarCubes> similar_cubes(std::span<const std::int32_t> voxels, const Size3& size,
                                        const SimilarityOptions& options, Progress& progress) {
  SimilarWork work(voxels, size, options, progress);
  std::vector<SimilarCubes> levels;
  for (int level = kCoarsestLevel; level >= kFinestLevel; --level) {
    levels.push_back(work.of_level(level));
  }
  return levels;
}

}  // namespace octavo
