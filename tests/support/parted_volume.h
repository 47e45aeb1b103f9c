// A volume that is built in parts of any kind, which join into the bytes of its file.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

#include "octavo/dist/plan_text.h"
#include "support/placed_parts.h"

namespace octavo::testing {

/// With its file and its plan. Parts are made once, and some of them again: by one to three
/// threads, in one run or in bands.
class PartedVolume {
 public:
  /// most_band_bytes  of the bands that a part is made in
  PartedVolume(SmallVolume volume, std::uint64_t most_band_bytes)
      : volume_(std::move(volume)),
        plan_(parse_plan(plan_text(planned(volume_)))),
        whole_(built(volume_)),
        most_band_bytes_(most_band_bytes) {}

  const BuildPlan& plan() const { return plan_; }

  /// Proves that parts at these places join into the bytes of the file.
  void expect_same(const Places& places, std::mt19937& random) {
    MemoryStorage storage;
    for (const PartPlace& place : places) storage.files[name_of(place)] = part(place, random);
    joined_places(plan_, storage, places);
    ASSERT_TRUE(*storage.files.at("a.8vo") == whole_)
        << volume_.name << " in " << places.size() << " parts";
    ASSERT_EQ(storage.files.size(), places.size() + 1);
  }

 private:
  using Key = std::tuple<BrickAt, std::int64_t, std::int64_t>;

  FileBytes part(const PartPlace& place, std::mt19937& random) {
    const Key key = {begin_of(place), place.end_group, place.end_brick};
    const auto known = parts_.find(key);
    const bool is_made_again = random() % 48 == 0;
    if (known != parts_.end() && !is_made_again) return known->second;
    MemoryStorage storage;
    PartWork work;
    work.threads = 1 + static_cast<int>(random() % 3);
    if (random() % 2 == 0) work.band_bytes = 1 + random() % most_band_bytes_;
    make_placed(volume_, plan_, place, storage, work);
    const FileBytes bytes = storage.files.at(name_of(place));
    if (known != parts_.end()) {
      EXPECT_TRUE(*bytes == *known->second) << volume_.name;
    }
    parts_[key] = bytes;
    return bytes;
  }

  SmallVolume volume_;
  BuildPlan plan_;
  std::vector<std::uint8_t> whole_;
  std::uint64_t most_band_bytes_;
  std::map<Key, FileBytes> parts_;
};

}  // namespace octavo::testing
