// Parts of small volumes that hold whole groups or bands of one.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "octavo/dist/band_part.h"
#include "octavo/dist/parts.h"
#include "support/small_parts.h"

namespace octavo::testing {

using Places = std::vector<PartPlace>;

inline std::string name_of(const PartPlace& place) { return "part of " + place_text(place); }

/// A part of either kind. Of its place the plan does not count.
inline void make_placed(const SmallVolume& volume, const BuildPlan& plan, const PartPlace& place,
                        Storage& storage, const PartWork& work = {.threads = 1}) {
  NoProgress progress;
  const auto source = volume.open();
  if (place.is_band()) {
    build_band(plan, *source, place, storage, name_of(place), work, progress);
  } else {
    build_part(plan, *source, place.first_group, place.end_group, storage, name_of(place), work,
               progress);
  }
}

inline BuildResult joined_places(const BuildPlan& plan, Storage& storage, const Places& places,
                                 const std::string& path = "a.8vo") {
  NoProgress progress;
  std::vector<std::shared_ptr<PartFile>> parts;
  for (const PartPlace& place : places) {
    parts.push_back(PartFile::open(storage, name_of(place)));
  }
  return join_parts(plan, std::move(parts), storage, path, false, {.threads = 1}, progress);
}

}  // namespace octavo::testing
