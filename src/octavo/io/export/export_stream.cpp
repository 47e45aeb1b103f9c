#include "octavo/io/export/export_stream.h"

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "octavo/core/checked.h"
#include "octavo/file/parallel_read.h"
#include "octavo/io/source/byte_order.h"

namespace octavo {

namespace {

/// The first layer boundary behind plane z.
std::int64_t layer_end(std::int64_t z, std::int64_t planes) { return (z / planes + 1) * planes; }

template <class From, class To>
bool map_one(const std::byte* from, std::byte* to, const IntegerMap& map) {
  From stored;
  std::memcpy(&stored, from, sizeof stored);
  const std::int64_t value = static_cast<std::int64_t>(stored) * map.factor + map.offset;
  const To mapped = static_cast<To>(value);
  std::memcpy(to, &mapped, sizeof mapped);
  return static_cast<std::int64_t>(mapped) == value;
}

/// Maps `count` voxels where they stand; a wider target is filled from the back.
template <class From, class To>
bool map_in_place(std::byte* voxels, std::size_t count, const IntegerMap& map) {
  bool fits = true;
  if constexpr (sizeof(To) > sizeof(From)) {
    for (std::size_t i = count; i-- > 0;) {
      fits &= map_one<From, To>(voxels + i * sizeof(From), voxels + i * sizeof(To), map);
    }
  } else {
    for (std::size_t i = 0; i < count; ++i) {
      fits &= map_one<From, To>(voxels + i * sizeof(From), voxels + i * sizeof(To), map);
    }
  }
  return fits;
}

/// Makes float32 of `count` voxels where they stand.
template <class From>
void make_real(std::byte* voxels, std::size_t count, const Rescale& rescale) {
  const auto make_one = [&](std::size_t i) {
    From stored;
    std::memcpy(&stored, voxels + i * sizeof(From), sizeof stored);
    const auto real = static_cast<float>(rescale.to_real(static_cast<double>(stored)));
    std::memcpy(voxels + i * sizeof(float), &real, sizeof real);
  };
  if constexpr (sizeof(float) > sizeof(From)) {
    for (std::size_t i = count; i-- > 0;) make_one(i);
  } else {
    for (std::size_t i = 0; i < count; ++i) make_one(i);
  }
}

void map_voxels(const ExportPlan& plan, std::byte* voxels, std::size_t count) {
  if (plan.map.is_identity() && plan.applied.is_identity() && plan.type == plan.stored_type) return;
  if (!is_integer(plan.type)) {
    with_voxel_type(plan.stored_type, [&](auto from) {
      make_real<typename decltype(from)::type>(voxels, count, plan.applied);
    });
    return;
  }
  const bool fits = with_voxel_type(plan.stored_type, [&](auto from) {
    return with_voxel_type(plan.type, [&](auto to) -> bool {
      using From = typename decltype(from)::type;
      using To = typename decltype(to)::type;
      if constexpr (std::is_integral_v<From> && std::is_integral_v<To>) {
        return map_in_place<From, To>(voxels, count, plan.map);
      } else {
        throw Error(ErrorKind::internal, "floats become no integers");
      }
    });
  });
  if (!fits) {
    throw Error(ErrorKind::corrupt,
                "a voxel lies outside the range that the index declares; run verify");
  }
}

void stop_if_cancelled(const Progress& progress) {
  if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
}

/// Hands planes on, some at a time: a target may take long over them.
void write_layer(std::span<const std::byte> planes, std::size_t plane_bytes, ExportTarget& target,
                 const Progress& progress) {
  constexpr std::size_t kBytesAtOnce = std::size_t{32} << 20;
  const std::size_t step = std::max(kBytesAtOnce / plane_bytes, std::size_t{1}) * plane_bytes;
  while (!planes.empty()) {
    stop_if_cancelled(progress);
    const auto some = planes.first(std::min(step, planes.size()));
    target.write_planes({reinterpret_cast<const std::uint8_t*>(some.data()), some.size()});
    planes = planes.subspan(some.size());
  }
}

}  // namespace

void stream_planes(const FileReader& reader, const ExportPlan& plan, int threads,
                   ExportTarget& target, Progress& progress) {
  const std::int64_t step = brick_side_at(reader.levels(), plan.level).z;
  const auto type_bytes = static_cast<std::size_t>(bytes_per_voxel(plan.type));
  const auto voxel_room = static_cast<std::uint64_t>(
      std::max(bytes_per_voxel(plan.type), bytes_per_voxel(plan.stored_type)));
  // Where all of it can be kept, its layers share their requests.
  reader.fetch({&plan.box, 1}, plan.level);
  std::vector<std::byte> voxels;
  Box layer = plan.box;
  for (layer.lo.z = plan.box.lo.z; layer.lo.z < plan.box.hi.z; layer.lo.z = layer.hi.z) {
    stop_if_cancelled(progress);
    layer.hi.z = std::min(layer_end(layer.lo.z, step), plan.box.hi.z);
    const auto count = static_cast<std::uint64_t>(layer.size().voxel_count());
    voxels.resize(checked_mul(count, voxel_room, "bytes of a brick layer"));
    read_parallel(reader, layer, plan.level, voxels.data(), threads);
    map_voxels(plan, voxels.data(), count);
    const std::span<std::byte> written(voxels.data(), count * type_bytes);
    if (needs_swap(false)) swap_values(written, type_bytes);
    const std::int64_t plane_count = layer.hi.z - layer.lo.z;
    write_layer(written, written.size() / static_cast<std::size_t>(plane_count), target, progress);
    progress.advance(plane_count);
  }
}

}  // namespace octavo
