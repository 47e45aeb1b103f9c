// The bricks of a grid that rays have come to: as many as fit into memory.
//
//     +---+----------------+----+      a brick of 64^3 samples with what its neighbors hold next to
//     | 2 |    64 samples  | 3  |      it, so that no ray looks into two bricks at once; beyond the
//     +---+----------------+----+      volume its outermost samples are repeated
//
// Bricks that are loaded together are read once each. What they hold of a neighbor comes out of
// that neighbor where it is in memory; one that is not is read once for all of them.
//
// Samples of up to 16 bits are kept as int16, others as floats between 0 and 1: pooled values. NaN
// is the lowest or the highest of them or, where it is empty space, lies below.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "octavo/core/box.h"
#include "octavo/render/rays/large_pages.h"
#include "octavo/render/rays/look_source.h"
#include "octavo/render/rays/ray_job.h"
#include "octavo/render/rays/sample_source.h"
#include "octavo/render/rays/seen_cells.h"

namespace octavo {

/// pooled = (stored - offset) * scale
struct PooledScale {
  double offset = 0;
  double scale = 1;
  double highest = 1;  ///< pooled value, where these are shares of a range
  double of_nan = 0;   ///< pooled value; below all others it is that of nothing

  double pooled(double stored) const { return (stored - offset) * scale; }
  double stored(double pooled) const { return pooled / scale + offset; }
};

/// What NaN is to rays: the lowest or the highest of all values, or empty space below them.
enum class NanPlace { lowest, highest, nothing };

/// The bound of a brick or cube whose pooled values are lowest .. highest: what gives nothing is
/// not above what a ray holds.
using BoundOf = std::function<float(float lowest, float highest)>;
/// The same where voxels have looks: all that may be there.
using LookBoundOf = std::function<float(float lowest, float highest, LookSet looks)>;

class RayBricks {
 public:
  struct Options {
    int brick_shift = 6;                                 ///< their side is 1 << it, at least 8
    std::uint64_t memory_bytes = std::uint64_t{1} << 30;  ///< for bricks, at most
    const LookSource* looks = nullptr;  ///< on the same grid; none: all voxels look alike
    NanPlace nan = NanPlace::lowest;
  };

  /// `source` and looks must outlive this.
  /// Throws  Error{limit_exceeded} when not even one brick fits
  RayBricks(const SampleSource& source, const Options& options);

  /// What the tables of all bricks and one of them need, as memory_bytes.
  static std::uint64_t fewest_bytes(const SampleSource& source, const Options& options);

  const PooledScale& scale() const { return scale_; }
  const Size3& size() const { return size_; }
  /// Bounds of all pooled values, that of NaN included where it lies below them.
  SampleRange range() const;

  /// Sets what can be skipped, of the bricks in memory and those to come.
  /// has_cells  single cells as well, where bounds are above 0 or not; of no use where they are
  ///            values
  void set_bounds(const BoundOf& bound_of, bool has_cells = true);
  void set_bounds(LookBoundOf bound_of, bool has_cells = true);

  /// Valid until bricks are loaded or bounds set.
  BrickTables tables() const;

  /// How many fit into memory.
  std::size_t capacity() const { return capacity_; }
  bool is_loaded(std::int32_t brick) const {
    return slots_[static_cast<std::size_t>(brick)] >= 0;
  }
  Index3 place_of(std::int32_t brick) const;

  /// Reads bricks that are not in memory, on the threads of the caller; those that no ray has come
  /// to for the longest time make room. Requires no more than the capacity.
  /// Throws what the source throws; then none of them is in memory
  void load(std::span<const std::int32_t> bricks);

  /// Memory of fields of the pictures of this volume, which follow each other.
  const std::shared_ptr<KeptPages>& field_pages() const { return field_pages_; }

  /// Bricks loaded so far; one that had to go and came back counts again.
  std::int64_t loaded_count() const { return loaded_count_; }

 private:
  struct Ends {
    float lowest = 0;
    float highest = 0;
  };

  /// What is taken of the memory.
  struct Bytes {
    std::uint64_t slot = 0;    ///< by the samples of a brick
    std::uint64_t brick = 0;   ///< by all of a brick in memory
    std::uint64_t tables = 0;  ///< by what is known of all bricks
  };
  static Bytes bytes_of(const SampleSource& source, const Options& options);

  /// A part of a brick in memory that one of its neighbors holds.
  struct Apron {
    std::int32_t neighbor = 0;
    std::int32_t brick = 0;
  };

  /// What was used since bricks were loaded before.
  void note_uses();
  /// Slots for so many bricks, without what was there.
  std::vector<std::int32_t> free_slots(std::size_t count);
  std::int32_t number_of(const Index3& place) const;
  /// Its own samples, as far as the volume goes.
  Box own_box(std::int32_t brick) const;
  /// With its aprons, beyond the volume as well.
  Box held_box(std::int32_t brick) const;
  std::vector<Apron> aprons_of(std::span<const std::int32_t> bricks) const;
  void load_samples(std::span<const std::int32_t> bricks);
  template <class Value, class Read>
  void load_layer(std::span<const std::int32_t> bricks, Value* layer, const Read& read);
  template <class Value, class Read>
  void fill_aprons(std::span<const Apron> aprons, Value* layer, const Read& read);
  template <class Value>
  void repeat_outermost(std::int32_t brick, Value* layer);
  template <class Pooled>
  void find_ends(std::int32_t slot);
  void find_sets(std::int32_t slot);
  void set_cube_bounds(std::int32_t slot);
  template <class Pooled>
  void mark_cells(std::int32_t slot);
  void set_seen_begin(std::int32_t brick);

  const SampleSource& source_;
  Size3 size_;
  Size3 grid_;
  int shift_;
  std::int64_t row_;    // samples of a brick with its aprons along an axis
  std::int64_t slot_samples_;
  std::size_t cubes_;   // of a brick
  std::size_t groups_;
  bool is_wide_;
  PooledScale scale_;
  std::size_t capacity_ = 0;
  LargePages samples_;
  std::vector<std::int32_t> slots_;      // by brick
  std::vector<float> brick_bounds_;      // by brick
  std::vector<std::int32_t> occupants_;  // by slot
  std::unique_ptr<std::uint8_t[]> used_;  // by slot
  std::vector<std::int64_t> last_uses_;   // by slot: twice the loads until then
  std::int64_t load_number_ = 0;
  std::vector<Ends> cube_ends_;          // by slot and cube
  std::vector<float> cube_bounds_;
  std::vector<float> group_bounds_;      // by slot and group of cubes
  bool has_cells_ = false;
  std::vector<UnseenRange> unseen_;
  std::vector<std::uint8_t> seen_cells_;  // by slot, as in BrickTables
  std::vector<std::int32_t> seen_begins_;
  const LookSource* look_source_;
  std::unique_ptr<std::uint16_t[]> looks_;
  std::vector<LookSet> cube_sets_;  // by slot and cube, where there are looks
  LookBoundOf bound_of_;
  std::int64_t loaded_count_ = 0;
  std::shared_ptr<KeptPages> field_pages_ = std::make_shared<KeptPages>();
};

}  // namespace octavo
