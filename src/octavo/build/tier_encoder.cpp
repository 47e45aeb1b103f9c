#include "octavo/build/tier_encoder.h"

#include <tbb/parallel_pipeline.h>

#include <cstring>
#include <string>

#include "octavo/core/error.h"

namespace octavo {

namespace {

constexpr std::size_t kBricksPerThread = 4;

template <class T>
bool all_equal(const BrickView& brick, std::int64_t value) {
  const auto* const voxels = static_cast<const T*>(brick.voxels);
  return is_uniform(brick) && static_cast<std::int64_t>(*voxels) == value;
}

bool holds_only(const BrickView& brick, std::int64_t value) {
  return with_voxel_type(
      brick.type, [&](auto id) { return all_equal<typename decltype(id)::type>(brick, value); });
}

bool equals_dense(const BrickView& brick, const std::vector<std::byte>& dense) {
  const std::int64_t width = bytes_per_voxel(brick.type);
  const auto* const voxels = static_cast<const std::byte*>(brick.voxels);
  const std::int64_t row_bytes = brick.size.x * width;
  const std::byte* row = dense.data();
  for (std::int64_t z = 0; z < brick.size.z; ++z) {
    for (std::int64_t y = 0; y < brick.size.y; ++y, row += row_bytes) {
      const std::byte* const source =
          voxels + (z * brick.plane_stride + y * brick.row_stride) * width;
      if (std::memcmp(source, row, static_cast<std::size_t>(row_bytes)) != 0) return false;
    }
  }
  return true;
}

// True when the reader's codec makes exactly the brick's voxels of what was encoded.
bool decodes_to(const BrickCodec& decoder, const BrickShape& shape, const EncodedBrick& encoded,
                const BrickView& brick) {
  if (encoded.range.min == encoded.range.max) return holds_only(brick, encoded.range.min);
  const std::vector<ByteSpan> segments(encoded.segments.begin(), encoded.segments.end());
  std::vector<std::byte> dense(
      static_cast<std::size_t>(brick.size.voxel_count() * bytes_per_voxel(brick.type)));
  decoder.decode(shape, brick.type, encoded.range, segments, 0, dense.data());
  return equals_dense(brick, dense);
}

std::string name_of(int tier, const Index3& brick) {
  return "brick (" + std::to_string(brick.x) + ", " + std::to_string(brick.y) + ", " +
         std::to_string(brick.z) + ") of tier " + std::to_string(tier);
}

[[noreturn]] void fail_brick(int tier, const Index3& brick, const std::string& why) {
  throw Error(ErrorKind::internal, name_of(tier, brick) + " does not decode to its voxels" + why +
                                       "; please report it with the source");
}

}  // namespace

Model make_model(std::unique_ptr<BrickCodec> codec, VoxelType type) {
  Model model;
  model.serialized = codec->serialized();
  try {
    model.decoder = parse_model(codec->kind(), type, model.serialized);
  } catch (const Error& error) {
    throw Error(ErrorKind::internal, "a model does not parse: " + error.detail());
  }
  model.encoder = std::move(codec);
  return model;
}

TierEncoder::TierEncoder(const Levels& levels, int tier, VoxelType type, Workers& workers,
                         FileWriter& writer, Progress& progress)
    : levels_(levels),
      tier_(tier),
      type_(type),
      workers_(workers),
      writer_(writer),
      progress_(progress),
      parents_(static_cast<std::size_t>(levels.brick_count(tier) * bytes_per_voxel(type))) {}

void TierEncoder::encode(const Model& model, const VoxelBlock& block) {
  const std::vector<Index3> bricks = bricks_of(levels_, tier_, block);
  // Planes of tier 0 count as work done; the tiers above it are too small to count.
  const std::int64_t planes = tier_ == 0 ? block.size.z : 0;
  const auto count = static_cast<std::int64_t>(bricks.size());
  std::int64_t kept = 0;
  // Bricks between their worker and the writer. As many numbers are under way as there are slots,
  // and they end in order, so no two of them share one.
  std::vector<EncodedBrick> slots(kBricksPerThread * static_cast<std::size_t>(workers_.count()));
  std::size_t next = 0;

  const auto give = [&](tbb::flow_control& flow) -> std::size_t {
    if (next == bricks.size()) flow.stop();
    return next < bricks.size() ? next++ : next;
  };
  const auto encode_one = [&](std::size_t number) {
    if (progress_.is_cancelled()) {
      throw Error(ErrorKind::cancelled, "stopped while encoding bricks");
    }
    slots[number % slots.size()] = encode_checked(model, block, bricks[number]);
    return number;
  };
  const auto keep_one = [&](std::size_t number) {
    keep(bricks[number], std::exchange(slots[number % slots.size()], {}));
    ++kept;
    const std::int64_t units = kept * planes / count - (kept - 1) * planes / count;
    if (units > 0) progress_.advance(units);
  };
  workers_.run([&] {
    using tbb::filter_mode;
    tbb::parallel_pipeline(
        slots.size(),
        tbb::make_filter<void, std::size_t>(filter_mode::serial_in_order, give) &
            tbb::make_filter<std::size_t, std::size_t>(filter_mode::parallel, encode_one) &
            tbb::make_filter<std::size_t, void>(filter_mode::serial_in_order, keep_one));
  });
}

EncodedBrick TierEncoder::encode_checked(const Model& model, const VoxelBlock& block,
                                         const Index3& brick) const {
  const BrickShape shape = brick_shape(levels_, tier_, brick);
  const BrickView view = view_of(block, levels_.brick_box(tier_, brick));
  EncodedBrick encoded = model.encoder->encode(shape, view);
  bool is_same = false;
  try {
    is_same = decodes_to(*model.decoder, shape, encoded, view);
  } catch (const Error& error) {
    fail_brick(tier_, brick, " (" + error.detail() + ")");
  }
  if (!is_same) fail_brick(tier_, brick, "");
  return encoded;
}

void TierEncoder::keep(const Index3& brick, const EncodedBrick& encoded) {
  writer_.add_brick(tier_, encoded);
  const Size3 grid = levels_.brick_grid(tier_);
  const std::int64_t at = (brick.z * grid.y + brick.y) * grid.x + brick.x;
  with_voxel_type(type_, [&](auto id) {
    const auto value = static_cast<typename decltype(id)::type>(encoded.parent);
    std::memcpy(parents_.data() + at * static_cast<std::int64_t>(sizeof value), &value,
                sizeof value);
  });
}

}  // namespace octavo
