#include "octavo/ops/measure/percentiles.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "octavo/core/error.h"

namespace octavo {

namespace {

// Which voxel is the percentile, from 1 by rising values.
std::uint64_t rank_of(double percent, std::uint64_t voxels, bool falls) {
  // In this order whole percents give whole ranks: 55 / 100 * 100 is above 55.
  const double wanted = std::ceil(percent * static_cast<double>(voxels) / 100);
  const std::uint64_t rank =
      std::clamp<std::uint64_t>(static_cast<std::uint64_t>(wanted), 1, voxels);
  return falls ? voxels - rank + 1 : rank;
}

}  // namespace

void Histogram::add(const Histogram& other) {
  if (other.counts_.empty()) {
    for (const std::uint16_t bin : other.few_) add(bin);
    return;
  }
  spread();
  for (std::size_t bin = 0; bin < counts_.size(); ++bin) counts_[bin] += other.counts_[bin];
}

std::vector<std::uint64_t> Histogram::counts() const {
  Histogram all = *this;
  all.spread();
  return all.counts_;
}

void Histogram::spread() {
  if (!counts_.empty()) return;
  counts_.resize(kPercentileBins);
  for (const std::uint16_t bin : std::exchange(few_, {})) ++counts_[bin];
}

ValueKeys::ValueKeys(const FileReader& grey) : is_whole_(is_integer(grey.description().type)) {
  const double a = grey.description().voxel_of(grey.range().min);
  const double b = grey.description().voxel_of(grey.range().max);
  const auto place = [&](double value) {
    return is_whole_ ? static_cast<std::int64_t>(value) : place_of(static_cast<float>(value));
  };
  first_ = place(std::min(a, b));
  last_ = static_cast<std::uint64_t>(place(std::max(a, b)) - first_);
}

double ValueKeys::value_of(std::uint64_t key) const {
  const std::int64_t place = first_ + static_cast<std::int64_t>(key);
  if (is_whole_) return static_cast<double>(place);
  const auto magnitude = std::bit_cast<float>(static_cast<std::int32_t>(std::abs(place)));
  return static_cast<double>(place < 0 ? -magnitude : magnitude);
}

PercentileSearch::PercentileSearch(const ValueKeys& keys, std::vector<double> percentiles,
                                   bool falls)
    : keys_(keys), percentiles_(std::move(percentiles)), falls_(falls) {
  rest_ = std::max(0, keys.bit_count() - kPercentileBits);
}

void PercentileSearch::descend(Place& place, const std::vector<std::uint64_t>& counts,
                               std::uint64_t first_prefix) {
  std::size_t bin = 0;
  while (bin + 1 < counts.size() && counts[bin] < place.rank) place.rank -= counts[bin++];
  place.prefix = first_prefix + bin;
}

void PercentileSearch::begin(std::int64_t region, std::uint64_t voxels, const Histogram& counted) {
  const std::vector<std::uint64_t> counts = counted.counts();
  Places& places = places_[region];
  for (const double percent : percentiles_) {
    places.push_back({0, rank_of(percent, voxels, falls_)});
    descend(places.back(), counts, 0);
  }
}

void PercentileSearch::count(const Places& places, std::uint64_t key, Counted& counted) const {
  const std::uint64_t prefix = key >> rest_;
  const bool is_wanted = std::any_of(places.begin(), places.end(), [&](const Place& place) {
    return place.prefix == prefix;
  });
  if (!is_wanted) return;
  const int next = next_rest();
  counted[prefix].add(static_cast<std::size_t>((key >> next) - (prefix << (rest_ - next))));
}

bool PercentileSearch::may_count(std::uint64_t first, std::uint64_t last) const {
  return std::any_of(places_.begin(), places_.end(), [&](const auto& region) {
    return std::any_of(region.second.begin(), region.second.end(), [&](const Place& place) {
      return place.prefix >= first >> rest_ && place.prefix <= last >> rest_;
    });
  });
}

void PercentileSearch::take(const Found& found) {
  const int next = next_rest();
  for (auto& [region, places] : places_) {
    const auto counted = found.find(region);
    for (Place& place : places) {
      if (counted == found.end() || !counted->second.contains(place.prefix)) {
        throw Error(ErrorKind::corrupt,
                    "a voxel lies outside the range that the index declares; run verify");
      }
      descend(place, counted->second.at(place.prefix).counts(), place.prefix << (rest_ - next));
    }
  }
  rest_ = next;
}

std::vector<double> PercentileSearch::values_of(std::int64_t region) const {
  if (!places_.contains(region)) return std::vector<double>(percentiles_.size(), std::nan(""));
  std::vector<double> values;
  for (const Place& place : places_of(region)) values.push_back(keys_.value_of(place.prefix));
  return values;
}

std::vector<double> percentiles_of(const std::map<std::uint64_t, std::uint64_t>& counts,
                                   const ValueKeys& keys, const std::vector<double>& percentiles,
                                   bool falls) {
  std::uint64_t voxels = 0;
  for (const auto& [key, count] : counts) voxels += count;
  std::vector<double> values;
  for (const double percent : percentiles) {
    if (voxels == 0) {
      values.push_back(std::nan(""));
      continue;
    }
    std::uint64_t left = rank_of(percent, voxels, falls);
    auto at = counts.begin();
    for (; at->second < left; ++at) left -= at->second;
    values.push_back(keys.value_of(at->first));
  }
  return values;
}

}  // namespace octavo
