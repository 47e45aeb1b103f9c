// Small volumes of many groups, built in one piece and in parts. Their groups are those of a
// SmallGroups that lives meanwhile.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "octavo/dist/parts.h"
#include "octavo/planes/between/isotropic_source.h"
#include "octavo/planes/memory_source.h"
#include "support/memory_storage.h"

namespace octavo::testing {

/// Groups first .. end.
using GroupRun = std::pair<std::int64_t, std::int64_t>;

struct SmallVolume {
  std::string name;
  VolumeDescription description;
  std::vector<std::byte> voxels;
  BuildOptions options;
  std::optional<PlaneInterpolation> isotropic = {};

  std::unique_ptr<PlaneSource> open() const {
    auto slices = make_memory_source(description, voxels);
    if (!isotropic) return slices;
    const IsotropicPlan plan = plan_isotropic(slices->description(), *isotropic);
    if (!plan.is_needed) return slices;
    return make_isotropic_source(std::move(slices), plan);
  }
};

/// A slope with noise in a part of it; where `is_plain`, runs of planes of one value in between. Of
/// labels regions.
inline SmallVolume small_volume(const std::string& name, VoxelType type, Size3 size,
                                VolumeKind kind = VolumeKind::grey, std::uint32_t seed = 1,
                                bool is_plain = false) {
  SmallVolume volume;
  volume.name = name;
  volume.description.type = type;
  volume.description.kind = kind;
  volume.description.size = size;
  volume.options.kind = kind;
  volume.options.preset = Preset::fast;
  volume.options.threads = 1;
  volume.voxels.reserve(static_cast<std::size_t>(plane_bytes(volume.description)) *
                        static_cast<std::size_t>(size.z));
  std::uint32_t state = seed;
  with_voxel_type(type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    for (std::int64_t z = 0; z < size.z; ++z) {
      for (std::int64_t y = 0; y < size.y; ++y) {
        for (std::int64_t x = 0; x < size.x; ++x) {
          state = state * 1664525u + 1013904223u;
          const bool is_quiet = (is_plain && z / 70 % 2 == 1) || x > 40 || y > 50;
          const std::int64_t smooth = kind == VolumeKind::labels ? x / 11 + 3 * ((y + z / 9) / 17)
                                                                 : (x + 2 * y + z) / 3;
          const std::int64_t noise = kind == VolumeKind::labels ? 0 : state >> 29;
          const std::int64_t whole = is_plain && z / 70 % 2 == 1 ? 5
                                     : is_quiet                  ? smooth
                                                                 : smooth + noise;
          T value = static_cast<T>(whole);
          if constexpr (!std::is_integral_v<T>) value = static_cast<T>(whole) / 8;
          const auto* const bytes = reinterpret_cast<const std::byte*>(&value);
          volume.voxels.insert(volume.voxels.end(), bytes, bytes + sizeof value);
        }
      }
    }
  });
  return volume;
}

inline std::vector<std::uint8_t> built(const SmallVolume& volume) {
  MemoryStorage storage;
  NoProgress progress;
  build_file(*volume.open(), storage, "a.8vo", volume.options, progress);
  return *storage.files.at("a.8vo");
}

inline BuildPlan planned(const SmallVolume& volume) {
  NoProgress progress;
  return plan_build(*volume.open(), volume.options, progress);
}

inline std::string part_name(const GroupRun& run) {
  return "part-" + std::to_string(run.first) + "-" + std::to_string(run.second);
}

inline void make_part(const SmallVolume& volume, const BuildPlan& plan, const GroupRun& run,
                      Storage& storage, const std::string& folder = "", int threads = 1,
                      std::uint64_t band_bytes = 0) {
  NoProgress progress;
  build_part(plan, *volume.open(), run.first, run.second, storage, folder + part_name(run),
             {.threads = threads, .band_bytes = band_bytes}, progress);
}

inline std::vector<std::shared_ptr<PartFile>> open_parts(Storage& storage,
                                                         const std::vector<GroupRun>& runs,
                                                         const std::string& folder = "") {
  std::vector<std::shared_ptr<PartFile>> parts;
  for (const GroupRun& run : runs) {
    parts.push_back(PartFile::open(storage, folder + part_name(run)));
  }
  return parts;
}

inline BuildResult joined(const BuildPlan& plan, Storage& storage,
                          const std::vector<GroupRun>& runs, const std::string& path = "a.8vo",
                          const std::string& folder = "") {
  NoProgress progress;
  return join_parts(plan, open_parts(storage, runs, folder), storage, path, false, {.threads = 1},
                    progress);
}

}  // namespace octavo::testing
