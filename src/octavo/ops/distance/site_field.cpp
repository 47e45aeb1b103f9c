#include "octavo/ops/distance/site_field.h"

#include <algorithm>

#include "octavo/core/error.h"
#include "octavo/ops/distance/scratch_planes.h"
#include "octavo/ops/distance/site_shares.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr std::int64_t kSiteBytes = sizeof(NearestSite);
constexpr std::int64_t kSiteColumns = 8;   // side by side: a line of the cache
constexpr std::int64_t kSitePlanes = 16;   // that shares are measured of at once
constexpr std::int64_t kLongestAxis = 32767;

/// Columns side by side, of which neighbors stand `stride` apart.
class SiteColumns {
 public:
  SiteColumns(std::int64_t length, const Point3& weights, int axis)
      : length_(static_cast<std::size_t>(length)),
        line_(length, weights, axis),
        columns_(static_cast<std::size_t>(kSiteColumns) * length_) {}

  void run(NearestSite* sites, std::int64_t width, std::int64_t stride) {
    for (std::int64_t x = 0; x < width; x += kSiteColumns) {
      const auto columns = static_cast<std::size_t>(std::min(kSiteColumns, width - x));
      for (std::size_t i = 0; i < length_; ++i) {
        const NearestSite* const from = sites + x + static_cast<std::int64_t>(i) * stride;
        for (std::size_t c = 0; c < columns; ++c) columns_[c * length_ + i] = from[c];
      }
      for (std::size_t c = 0; c < columns; ++c) {
        line_.improve({columns_.data() + c * length_, length_});
      }
      for (std::size_t i = 0; i < length_; ++i) {
        NearestSite* const to = sites + x + static_cast<std::int64_t>(i) * stride;
        for (std::size_t c = 0; c < columns; ++c) to[c] = columns_[c * length_ + i];
      }
    }
  }

 private:
  std::size_t length_;
  SiteLine line_;
  std::vector<NearestSite> columns_;
};

/// The squared distances of steps, in that of the smallest.
Point3 site_weights(const Point3& spacing) {
  const double unit = std::min({spacing[0], spacing[1], spacing[2]});
  Point3 weights{};
  for (std::size_t a = 0; a < 3; ++a) weights[a] = spacing[a] * spacing[a] / (unit * unit);
  return weights;
}

/// Classes, shares and the passes along x and y of planes [begin, end).
void sites_in_planes(const InsideVoxels& voxels, const Point3& weights, std::int64_t begin,
                     std::int64_t end, Progress& progress, NearestSite* sites) {
  const Size3 size = voxels.size;
  const std::int64_t plane = size.x * size.y;
  const std::int64_t blocks = (end - begin + kSitePlanes - 1) / kSitePlanes;
  parallel_for(std::int64_t{0}, blocks, [&](std::int64_t block) {
    if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
    const std::int64_t lo = begin + block * kSitePlanes;
    const std::int64_t hi = std::min(lo + kSitePlanes, end);
    NearestSite* const out = sites + (lo - begin) * plane;
    fill_shares(voxels, lo, hi, out);
    SiteColumns columns(size.y, weights, 1);
    for (std::int64_t z = 0; z < hi - lo; ++z) {
      for (std::int64_t y = 0; y < size.y; ++y) {
        SiteLine::begin({out + z * plane + y * size.x, static_cast<std::size_t>(size.x)});
      }
      columns.run(out + z * plane, size.x, size.x);
    }
    progress.advance(hi - lo);
  });
}

/// The pass along z, of a block [z][y][x].
void sites_through_planes(const Size3& block, const Point3& weights, NearestSite* sites) {
  parallel_parts(std::int64_t{0}, block.y, 1, [&](std::int64_t begin, std::int64_t end) {
    SiteColumns columns(block.z, weights, 2);
    for (std::int64_t y = begin; y != end; ++y) {
      columns.run(sites + y * block.x, block.x, block.x * block.y);
    }
  });
}

class SitesInMemory final : public SiteField {
 public:
  SitesInMemory(const InsideVoxels& voxels, const Point3& weights, Progress& progress)
      : plane_(voxels.size.x * voxels.size.y),
        sites_(static_cast<std::size_t>(voxels.size.voxel_count())) {
    sites_in_planes(voxels, weights, 0, voxels.size.z, progress, sites_.data());
    sites_through_planes(voxels.size, weights, sites_.data());
  }

  void read(std::int64_t begin, std::int64_t end, NearestSite* sites) const override {
    std::copy_n(sites_.data() + begin * plane_, (end - begin) * plane_, sites);
  }

 private:
  std::int64_t plane_;
  std::vector<NearestSite> sites_;
};

class SitesOnDisk final : public SiteField {
 public:
  SitesOnDisk(const InsideVoxels& voxels, const Point3& weights, std::uint64_t max_bytes,
              Storage& storage, const std::string& folder, Progress& progress)
      : planes_(voxels.size, storage, folder) {
    const Size3& size = voxels.size;
    const auto held = static_cast<std::int64_t>(max_bytes) / kSiteBytes;
    std::vector<NearestSite> room(
        static_cast<std::size_t>(std::max({held, size.x * size.y, size.x * size.z})));
    planes_.write_planes(room, [&](std::int64_t begin, std::int64_t end, NearestSite* sites) {
      sites_in_planes(voxels, weights, begin, end, progress, sites);
    });
    planes_.change_rows(room, progress, [&](const Size3& block, NearestSite* sites) {
      sites_through_planes(block, weights, sites);
    });
  }

  void read(std::int64_t begin, std::int64_t end, NearestSite* sites) const override {
    planes_.read(begin, end, sites);
  }

 private:
  ScratchPlanes<NearestSite> planes_;
};

}  // namespace

std::unique_ptr<SiteField> make_site_field(const InsideVoxels& voxels, const Point3& spacing_mm,
                                           std::uint64_t max_bytes, Storage& storage,
                                           const std::string& folder, Progress& progress) {
  const Size3& size = voxels.size;
  if (std::max({size.x, size.y, size.z}) > kLongestAxis) {
    throw Error(ErrorKind::limit_exceeded, "an axis has more than 32767 voxels");
  }
  const Point3 weights = site_weights(spacing_mm);
  if (static_cast<std::uint64_t>(size.voxel_count() * kSiteBytes) <= max_bytes) {
    return std::make_unique<SitesInMemory>(voxels, weights, progress);
  }
  return std::make_unique<SitesOnDisk>(voxels, weights, max_bytes, storage, folder, progress);
}

}  // namespace octavo
