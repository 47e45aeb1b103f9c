// Planes are the same from wherever they are sought.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/planes/plane_source.h"

namespace octavo::testing {

/// Planes first .. end of a source that was sought there.
inline std::vector<std::vector<std::byte>> planes_between(PlaneSource& source, std::int64_t first,
                                                          std::int64_t end) {
  source.seek(first, end);
  std::vector<std::vector<std::byte>> planes;
  for (std::int64_t z = first; z < end; ++z) {
    planes.emplace_back(static_cast<std::size_t>(plane_bytes(source.description())));
    source.read_plane(planes.back());
  }
  return planes;
}

/// Seeks forwards, backwards, to the same place and to the end; compares with the planes that come
/// one after the other, and proves that none comes behind those asked for.
inline void expect_same_from_anywhere(PlaneSource& source) {
  const std::int64_t count = source.description().size.z;
  const auto all = planes_between(source, 0, count);
  std::vector<std::pair<std::int64_t, std::int64_t>> runs = {
      {0, 0},         {count, count}, {count - 1, count}, {0, 1}, {count / 2, count},
      {count / 3, count / 2}, {0, count}};
  if (count <= 12) {
    for (std::int64_t first = 0; first < count; ++first) {
      for (std::int64_t end = count; end >= first; --end) runs.emplace_back(first, end);
    }
  }
  std::vector<std::byte> plane(static_cast<std::size_t>(plane_bytes(source.description())));
  for (const auto& [first, end] : runs) {
    const auto planes = planes_between(source, first, end);
    for (std::int64_t z = first; z < end; ++z) {
      ASSERT_EQ(planes[static_cast<std::size_t>(z - first)], all[static_cast<std::size_t>(z)])
          << "plane " << z << " of " << first << " to " << end;
    }
    EXPECT_THROW(source.read_plane(plane), Error) << end;
  }
  // Left in the middle
  source.seek(0, count);
  source.read_plane(plane);
  source.seek(count / 2, count);
  source.read_plane(plane);
  EXPECT_EQ(plane, all[static_cast<std::size_t>(count / 2)]);
  for (const auto& [first, end] : std::vector<std::pair<std::int64_t, std::int64_t>>{
           {-1, 1}, {1, 0}, {0, count + 1}, {count + 1, count + 1}}) {
    EXPECT_THROW(source.seek(first, end), Error) << first << " to " << end;
  }
}

}  // namespace octavo::testing
