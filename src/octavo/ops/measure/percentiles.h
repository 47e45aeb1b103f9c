// Percentiles of the grey voxels of regions, exact for every type.
//
// Values are told apart by whole numbers in their order, their keys. A first pass over the voxels
// counts the leading digits of the keys; where keys have more digits, further passes count the next
// ones of those keys alone among which a percentile lies.
//
// Invariants
//   A pass counts into histograms of kPercentileBins bins at most.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <map>
#include <type_traits>
#include <vector>

#include "octavo/file/reader.h"

namespace octavo {

inline constexpr int kPercentileBits = 13;
inline constexpr std::size_t kPercentileBins = std::size_t{1} << kPercentileBits;

/// How many voxels fell into each bin. A few are kept one by one: most regions of a brick, and many
/// of a volume, have fewer voxels than there are bins.
class Histogram {
 public:
  void add(std::size_t bin) {
    if (counts_.empty() && few_.size() < kFew) {
      few_.push_back(static_cast<std::uint16_t>(bin));
    } else {
      spread();
      ++counts_[bin];
    }
  }
  void add(const Histogram& other);
  /// The count of every bin.
  std::vector<std::uint64_t> counts() const;

 private:
  static constexpr std::size_t kFew = 4 * kPercentileBins;

  void spread();

  std::vector<std::uint16_t> few_;
  std::vector<std::uint64_t> counts_;
};

/// Numbers the values of a volume in their order, from 0.
class ValueKeys {
 public:
  explicit ValueKeys(const FileReader& grey);

  /// 0 for what lies below the volume's range.
  template <class T>
  std::uint64_t key_of(T value) const {
    const std::int64_t place = place_of(value) - first_;
    return std::min(static_cast<std::uint64_t>(std::max<std::int64_t>(place, 0)), last_);
  }
  double value_of(std::uint64_t key) const;
  /// Binary digits of the largest key.
  int bit_count() const { return static_cast<int>(std::bit_width(last_)); }

 private:
  template <class T>
  static std::int64_t place_of(T value) {
    if constexpr (std::is_integral_v<T>) {
      return static_cast<std::int64_t>(value);
    } else {
      const auto bits = std::bit_cast<std::int32_t>(value);
      constexpr std::int32_t kWithoutSign = 0x7fffffff;
      return bits < 0 ? -static_cast<std::int64_t>(bits & kWithoutSign) : bits;
    }
  }

  bool is_whole_;
  std::int64_t first_ = 0;  ///< place of the smallest value
  std::uint64_t last_ = 0;  ///< key of the largest one
};

/// The percentiles of many regions of one volume.
class PercentileSearch {
 public:
  /// Where a percentile lies: among the keys that begin with `prefix`, the `rank`-th from 1.
  struct Place {
    std::uint64_t prefix = 0;
    std::uint64_t rank = 1;
  };
  using Places = std::vector<Place>;
  /// Histograms of the keys that begin with the same digits.
  using Counted = std::map<std::uint64_t, Histogram>;
  using Found = std::map<std::int64_t, Counted>;  ///< by region

  /// percentiles  of 0 .. 100: the smallest value that this share of the voxels does not exceed
  /// falls        the largest stored value counts as the smallest
  PercentileSearch(const ValueKeys& keys, std::vector<double> percentiles, bool falls);

  /// The bin of a key in the first pass.
  std::size_t first_bin(std::uint64_t key) const { return static_cast<std::size_t>(key >> rest_); }

  /// Takes what the first pass counted of a region of `voxels`.
  void begin(std::int64_t region, std::uint64_t voxels, const Histogram& counted);

  /// Whether the percentiles of all regions are settled; otherwise one more pass is needed.
  bool is_settled() const { return rest_ == 0; }

  /// What a pass looks for in a region; nothing where it has not begun.
  const Places& places_of(std::int64_t region) const {
    static const Places kNone;
    const auto found = places_.find(region);
    return found == places_.end() ? kNone : found->second;
  }
  /// Counts a voxel of a region in a pass, where a percentile may be it.
  void count(const Places& places, std::uint64_t key, Counted& counted) const;
  /// Whether a pass would count any voxel with a key of `first` to `last`.
  bool may_count(std::uint64_t first, std::uint64_t last) const;
  /// Ends a pass. Throws Error{corrupt} where voxels are not in the range that the index declares.
  void take(const Found& found);

  /// As many as were asked for, NaN of a region that has not begun. Requires is_settled().
  std::vector<double> values_of(std::int64_t region) const;

 private:
  int next_rest() const { return rest_ > kPercentileBits ? rest_ - kPercentileBits : 0; }
  static void descend(Place& place, const std::vector<std::uint64_t>& counts,
                      std::uint64_t first_prefix);

  ValueKeys keys_;
  std::vector<double> percentiles_;
  bool falls_;
  int rest_ = 0;  ///< binary digits of keys that no pass has looked at
  std::map<std::int64_t, Places> places_;  ///< by region, one per percentile
};

/// The values that a search finds, by how many voxels have which key; NaN where there are none.
/// percentiles, falls  as in PercentileSearch
std::vector<double> percentiles_of(const std::map<std::uint64_t, std::uint64_t>& counts,
                                   const ValueKeys& keys, const std::vector<double>& percentiles,
                                   bool falls);

}  // namespace octavo
