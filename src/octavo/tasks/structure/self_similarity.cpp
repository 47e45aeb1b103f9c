#include "octavo/tasks/structure/self_similarity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>

#include "octavo/builder/float_grid.h"
#include "octavo/core/error.h"
#include "octavo/ops/similarity/similar_cubes.h"
#include "octavo/tasks/file_planes.h"
#include "octavo/tasks/inputs.h"

namespace octavo {

namespace {

constexpr std::int64_t kWidestRange = std::int64_t{1} << 30;

void check_similarity(const SelfSimilarityOptions& options, const FileReader& input,
                      const FileReader& coded) {
  if (!(options.max_difference >= 0)) {
    throw Error(ErrorKind::invalid_argument, "the difference must not be negative")
        .with_field("self_similarity.max_difference");
  }
  for (const auto& [reader, path] : {std::pair{&input, options.input}, {&coded, options.coded}}) {
    if (reader->description().kind == VolumeKind::grey) continue;
    throw Error(ErrorKind::invalid_argument,
                "holds labels, whose cubes are condensed as they are; only grey volumes are asked "
                "for similar ones",
                path);
  }
  if (input.levels().size(0) != coded.levels().size(0)) {
    throw Error(ErrorKind::invalid_argument, "is no file of the same scan: its size is another",
                options.coded);
  }
}

/// The voxels of a file as whole numbers, counted from the smallest.
std::vector<std::int32_t> whole_voxels(const std::shared_ptr<const FileReader>& reader,
                                       const std::string& path, const TaskContext& context) {
  const ValueRange range = reader->range();
  const std::int64_t lowest = reader->description().code_near(range.min);
  if (reader->description().code_near(range.max) - lowest >= kWidestRange) {
    throw Error(ErrorKind::invalid_argument, "its values span 2^30 steps or more", path);
  }
  FilePlanes planes(reader, 0, context.thread_count());
  const VolumeDescription& volume = planes.description();
  const SampleCoding coding = reader->description().coding.value_or(SampleCoding{});
  const ProgressScope scope(context.watcher(), "read", volume.size.z, "planes");
  const auto count = static_cast<std::size_t>(volume.size.x * volume.size.y);
  std::vector<std::byte> plane(count * static_cast<std::size_t>(bytes_per_voxel(volume.type)));
  std::vector<std::int32_t> voxels;
  voxels.reserve(count * static_cast<std::size_t>(volume.size.z));
  for (std::int64_t z = 0; z < volume.size.z; ++z) {
    planes.read_plane(plane);
    with_voxel_type(volume.type, [&](auto id) {
      using T = typename decltype(id)::type;
      for (std::size_t i = 0; i < count; ++i) {
        T value;
        std::memcpy(&value, plane.data() + i * sizeof value, sizeof value);
        if constexpr (std::is_floating_point_v<T>) {
          const auto code = exact_code(coding, value);
          if (!code) {
            throw Error(ErrorKind::invalid_argument,
                        "holds floats that are no multiples of one number; only a copy within a "
                        "max error is compared with itself",
                        path);
          }
          voxels.push_back(static_cast<std::int32_t>(*code - lowest));
        } else {
          voxels.push_back(static_cast<std::int32_t>(static_cast<std::int64_t>(value) - lowest));
        }
      }
    });
    context.stop_if_cancelled();
    context.watcher().advance(1);
  }
  return voxels;
}

/// What the codec spends on cubes.
class CubeBytes {
 public:
  CubeBytes(const FileReader& coded, std::span<const std::int32_t> voxels)
      : coded_(coded), voxels_(voxels), size_(coded.levels().size(0)) {
    side_ = coded.levels().brick_side(0);
    grid_ = coded.levels().brick_grid(0);
    weights_.assign(static_cast<std::size_t>(grid_.voxel_count()), -1);
    const auto& coding = coded.description().coding;
    step_ = 1 + 2 * coded.max_error() / (coding ? coding->scale : 1);
  }

  /// Of the levels below that of a cube of side 2^level.
  double of(const Index3& corner, int level) {
    const Index3 brick = {corner.x / side_.x, corner.y / side_.y, corner.z / side_.z};
    const BrickEntry entry = coded_.brick(0, brick);
    double bytes = 0;
    for (std::size_t piece = 0; piece < entry.pieces.size(); ++piece) {
      if (is_below(static_cast<int>(piece), level)) {
        bytes += static_cast<double>(entry.pieces[piece].length);
      }
    }
    const std::int64_t side = std::int64_t{1} << level;
    const double own =
        weight_of({corner, {corner.x + side, corner.y + side, corner.z + side}});
    const double all = brick_weight(brick);
    return all > 0 ? bytes * own / all : 0;
  }

 private:
  /// Whether a level of the file is finer than cubes of side 2^level.
  bool is_below(int file_level, int level) const {
    if (file_level + 1 >= coded_.levels().count()) return false;
    int most = 0;
    for (int axis = 0; axis < 3; ++axis) {
      most = std::max(most, coded_.levels().halving_count(file_level + 1, axis));
    }
    return most <= level;
  }

  double brick_weight(const Index3& brick) {
    double& weight =
        weights_[static_cast<std::size_t>((brick.z * grid_.y + brick.y) * grid_.x + brick.x)];
    if (weight < 0) weight = weight_of(coded_.levels().brick_box(0, brick));
    return weight;
  }

  /// Sum of log2(1 + |voxel - mean of its octant| / step), the step that the max error allows;
  /// boxes begin at even places.
  double weight_of(const Box& box) const {
    double weight = 0;
    for (std::int64_t z = box.lo.z; z < box.hi.z; z += 2) {
      for (std::int64_t y = box.lo.y; y < box.hi.y; y += 2) {
        for (std::int64_t x = box.lo.x; x < box.hi.x; x += 2) {
          const Box octant =
              intersection(Box{{x, y, z}, {x + 2, y + 2, z + 2}}, box_of(size_));
          weight += octant_weight(octant);
        }
      }
    }
    return weight;
  }

  double octant_weight(const Box& octant) const {
    std::array<double, 8> values{};
    std::size_t count = 0;
    double mean = 0;
    for (std::int64_t z = octant.lo.z; z < octant.hi.z; ++z) {
      for (std::int64_t y = octant.lo.y; y < octant.hi.y; ++y) {
        for (std::int64_t x = octant.lo.x; x < octant.hi.x; ++x) {
          values[count] = voxels_[static_cast<std::size_t>((z * size_.y + y) * size_.x + x)];
          mean += values[count++];
        }
      }
    }
    mean /= static_cast<double>(count);
    double product = 1;  // one logarithm in place of eight
    for (std::size_t i = 0; i < count; ++i) product *= 1 + std::abs(values[i] - mean) / step_;
    return std::log2(product);
  }

  const FileReader& coded_;
  std::span<const std::int32_t> voxels_;
  Size3 size_;
  Size3 side_;
  Size3 grid_;
  std::vector<double> weights_;
  double step_ = 1;
};

SimilarityLevel level_of(const SimilarCubes& cubes, CubeBytes& bytes) {
  SimilarityLevel level;
  level.side = std::int64_t{1} << cubes.level;
  level.cubes = cubes.cubes;
  level.uniform = cubes.uniform;
  level.asked = cubes.asked;
  level.cut_short = cubes.cut_short;
  level.reference_bytes = cubes.reference_bits / 8;
  for (const CubeReference& reference : cubes.references) {
    ++(reference.is_coarser ? level.next_level : level.same_level);
    if (reference.is_turned) ++level.turned;
    level.coded_bytes += bytes.of(reference.corner, cubes.level);
  }
  return level;
}

/// The asked difference in whole numbers of those that bricks hold.
std::int32_t whole_steps(double difference, const VolumeDescription& volume) {
  constexpr double kRounding = 1e-9;  // of a quotient that should be whole
  double step = volume.rescale.slope == 0 ? 1 : std::abs(volume.rescale.slope);
  if (volume.coding) step *= volume.coding->scale;
  const double steps = std::floor(difference / step * (1 + kRounding));
  return static_cast<std::int32_t>(std::min(static_cast<double>(kWidestRange / 8), steps));
}

}  // namespace

double SelfSimilarityResult::saved_bytes() const {
  double saved = 0;
  for (const SimilarityLevel& level : levels) saved += std::max(0.0, level.saved_bytes());
  return saved;
}

Facts similarity_facts(const SimilarityLevel& level) {
  return {{"side", level.side},
          {"cubes", level.cubes},
          {"uniform", level.uniform},
          {"asked", level.asked},
          {"same_level", level.same_level},
          {"next_level", level.next_level},
          {"turned", level.turned},
          {"cut_short", level.cut_short},
          {"coded_bytes", level.coded_bytes},
          {"reference_bytes", level.reference_bytes},
          {"saved_bytes", level.saved_bytes()}};
}

SelfSimilarityResult self_similarity(const SelfSimilarityOptions& options,
                                     const TaskContext& context) {
  const std::shared_ptr<const FileReader> input = open_volume(options.input, context);
  const std::shared_ptr<const FileReader> coded =
      options.coded.empty() ? input : open_volume(options.coded, context);
  check_similarity(options, *input, *coded);
  SelfSimilarityResult result;
  result.volume = input->description();
  result.file_bytes = coded->file_bytes();
  const Size3& size = result.volume.size;
  context.require_memory(8 * static_cast<std::uint64_t>(size.voxel_count()), "the voxels");

  const std::vector<std::int32_t> voxels = whole_voxels(input, options.input, context);
  const SimilarityOptions asked = {whole_steps(options.max_difference, result.volume),
                                   options.is_up_to_mean};
  std::vector<SimilarCubes> found;
  {
    const std::int64_t cubes = size.voxel_count() / 64 * 73 / 64;
    const ProgressScope scope(context.watcher(), "similar cubes", cubes, "cubes");
    context.on_threads([&] { found = similar_cubes(voxels, size, asked, context.watcher()); });
  }
  CubeBytes bytes(*coded, voxels);
  for (const SimilarCubes& cubes : found) result.levels.push_back(level_of(cubes, bytes));
  return result;
}

}  // namespace octavo
