// What the functions that follow rays are given, and what they leave: plain arrays, the same for
// the portable functions and those on vectors.
//
// A picture is cut into tiles of 32 x 32 rays. Ray and sample lie at
//
//     place(k) = origin + k * step        k = 0, 1, 2 ...; in samples of the grid
//
// origin  on the image plane, or in the eye
// step    one spacing along the ray; of extremes from one plane of the grid to the next, along the
//         axis that the ray crosses most of; from an eye the first is the one behind it
//
// A ray has a sample where it enters and one where it leaves besides: what is thinner than a step
// has no gaps. Colors and means are of the parts of a ray between one sample and the next, by their
// lengths; a part is skipped where nothing is seen at both its ends, since the cubes of these touch
// and hold all values between.
//
// Invariants
//   Where a sample lies depends on the ray alone, and what is taken there on the volume alone.
//   What is skipped gives nothing: a brick, a group of 8^3 or a cube of 4^3 samples whose bound is
//   not above what the ray holds already, or cells between whose samples nothing is seen.
// Consequences
//   Pictures depend neither on bricks, their order or how many fit into memory, nor on threads, nor
//   on what is skipped. A ray waits at a brick that is not in memory and goes on later.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <type_traits>

namespace octavo {

class MeshShadow;
class RayMeshes;
struct TileLayers;

enum class RayMode {
  volume,   ///< colors and opacities of a transfer function, front to back
  extreme,  ///< the highest value on planes of the grid; of values times -1 the lowest
  mean,     ///< along the ray
  iso,      ///< where a value is reached first, in light
};

/// Side of the cubes that are skipped, in samples.
inline constexpr int kSkipSide = 4;
inline constexpr int kSkipShift = 2;
/// That of groups of 2^3 cubes, which are skipped together.
inline constexpr int kGroupSide = 8;
inline constexpr int kGroupShift = 3;

/// Cells along y and along z that one bit stands for.
inline constexpr int kSeenSide = 2;
/// Of bricks in which nothing is seen, and of those of which it is not known.
inline constexpr std::int32_t kNothingSeen = -1;
inline constexpr std::int32_t kAnythingSeen = -2;

/// Samples that a brick holds beyond its own, at its low and at its high sides: what the two
/// neighbors of a hit between two samples need for their gradients.
inline constexpr int kApronBelow = 2;
inline constexpr int kApronAbove = 3;

/// The bricks of a grid, those in memory and the others.
struct BrickTables {
  /// What each sample looks like besides its value, in the order of the samples; or none.
  const std::uint16_t* looks = nullptr;
  /// int16, or float where is_wide; one after the other, x fastest, aprons included.
  const void* samples = nullptr;
  bool is_wide = false;
  bool has_short_differences = false;  ///< differences of any two fit into 16 bits
  std::int32_t row = 0;    ///< samples from a row to the next
  std::int32_t plane = 0;  ///< from a plane to the next
  std::int32_t slot = 0;   ///< from a brick to the next
  int shift = 6;           ///< the side of a brick is 1 << shift samples
  std::array<std::int32_t, 3> size{};  ///< samples
  std::array<std::int32_t, 3> grid{};  ///< bricks
  const float* brick_bounds = nullptr;  ///< by brick, x fastest
  const std::int32_t* slots = nullptr;  ///< by brick; below 0: not in memory
  const float* cube_bounds = nullptr;   ///< by slot and cube
  const float* group_bounds = nullptr;  ///< by slot and group, the highest of its cubes
  /// By brick, the byte at which its seen cells begin; or kNothingSeen or kAnythingSeen.
  const std::int32_t* seen_begins = nullptr;
  /// Bit x + (y + z * side) * side of a brick, the lowest of a byte first: whether anything may be
  /// seen between the samples of the cell or the next ones along y, z and both, as far as they lie
  /// in the brick.
  const std::uint8_t* seen_cells = nullptr;
  std::uint8_t* used = nullptr;         ///< by slot: 1 where a ray came to it
};

/// Marks a brick in memory that a ray comes to; threads may do so at once.
inline void mark_used(const BrickTables& bricks, std::int32_t slot) {
  const std::atomic_ref<std::uint8_t> used(bricks.used[slot]);
  if (used.load(std::memory_order_relaxed) == 0) used.store(1, std::memory_order_relaxed);
}

/// What voxels look like, by the numbers beside the samples; the voxel nearest to a place counts.
struct LookTable {
  /// Where its colors and opacities begin in a ColorTable; below 0: it is not seen.
  const std::int32_t* begins = nullptr;
  const std::uint32_t* colors = nullptr;  ///< 0xffbbggrr in place of those of the table, or 0
};

/// A table of colors and opacities by the values at both ends of a step, between which values run
/// straight: what lies between them is seen, however steep the step.
///
///     entry of a value = sum over pieces of clamp((value - begin) * entries_per_value, 0, entries)
struct ColorTable {
  static constexpr std::int32_t kSide = 256;

  struct Piece {
    float begin = 0;
    float entries_per_value = 0;
    float entries = 0;
  };

  const float* opacities = nullptr;       ///< of one step; [front][back]
  const std::uint32_t* colors = nullptr;  ///< 0xbbggrr; [front][back]
  std::array<Piece, 3> pieces;
  /// Opacity rises from nothing at a gradient, in values a spacing, with the gradient; 0: it is
  /// that of the table.
  float gradient_begin = 0;
  float gradient_rise = 0;
};

/// The light of a picture, in its axes: to the right, up, towards the viewer.
struct RayLight {
  std::array<float, 3> toward_light{};
  std::array<float, 3> halfway{};  ///< between light and viewer
  float ambient = 0;
  float diffuse = 0;
  float specular = 0;
  /// Gradients much smaller than this, in values a spacing, have no side that light falls on.
  float soft_gradient = 0;
};

/// Which share of the light comes to places in a grid, by cells of a coarser one; between their
/// middles it runs straight.
struct ShadeTable {
  const std::uint8_t* pairs = nullptr;  ///< of the light all around and of the lamp's; or none
  std::int32_t row = 0;    ///< pairs from a row to the next
  std::int32_t plane = 0;  ///< from a plane to the next
  /// cell = place * scale + offset, 0 .. highest; the next one is read besides
  std::array<float, 3> scale{};
  std::array<float, 3> offset{};
  std::array<float, 3> highest{};
  std::array<std::int32_t, 3> last_cell{};
  const MeshShadow* meshes = nullptr;  ///< that the lamp's light has to pass besides; or none
};

/// What cuts take away, which gives no values: where those between samples would come out of it,
/// the nearest sample that is kept counts as far as its voxel goes. Gradients are of the whole.
struct RayCuts {
  /// The samples on both sides of a box, between which none is kept; far away where the box ends
  /// with the volume.
  struct Hole {
    std::array<float, 3> before{};
    std::array<float, 3> behind{};
  };

  std::array<float, 3> first{};  ///< that are kept, along each axis
  std::array<float, 3> last{};
  const Hole* holes = nullptr;
  std::size_t hole_count = 0;
};

/// One picture.
struct RayFrame {
  RayMode mode = RayMode::volume;
  BrickTables bricks;
  ColorTable table;
  LookTable looks;  ///< where bricks have looks
  RayLight light;
  ShadeTable shade;
  /// origin = corner + u * across + v * down, (u, v) being the place of a pixel's middle from the
  /// middle of the picture; direction in the same way, to be divided by its length in pixels where
  /// there is an eye.
  std::array<float, 3> origin{};
  std::array<float, 3> origin_across{};
  std::array<float, 3> origin_down{};
  std::array<float, 3> direction{};
  std::array<float, 3> direction_across{};
  std::array<float, 3> direction_down{};
  float eye_pixels = 0;   ///< from the eye to the middle of the picture; 0: rays are parallel
  float step_pixels = 1;
  std::array<float, 3> low{};   ///< what rays cross, in samples
  std::array<float, 3> high{};
  /// The box that it is a part of. Behind faces that it does not share with it others go on with
  /// the ray: a step begins or ends there as if there were no face, and belongs to where it begins.
  std::array<float, 3> whole_low{};
  std::array<float, 3> whole_high{};
  /// gradient in the axes of the picture = matrix * gradient in samples; rows one after the other
  std::array<float, 9> gradient{};
  float sign = 1;        ///< extreme, iso: of values
  float isovalue = 0;    ///< times the sign
  float enough = 0.995f; ///< opacity at which a ray ends
  float unlit_weight = 1.0f / 512;  ///< of volume: steps that give less have flat light
  bool has_cell_gradients = false;  ///< of volume: coarser light, out of a fourth of the samples
  /// By tile, bit i: rays 16 i to 16 i + 15 of it, 4 x 4 pixels, are cast; none: all are.
  const std::uint64_t* chosen = nullptr;
  const RayMeshes* meshes = nullptr;  ///< in the same picture; or none
  const TileLayers* layers = nullptr;  ///< in their place, of each tile of the picture; or none
  bool is_last_region = true;  ///< what lies behind what rays cross is nothing but layers
  const RayCuts* cuts = nullptr;  ///< or none
  float margin = 0;      ///< that a ray stays before the end of what it skips, in samples
};

inline constexpr int kRayTileSide = 32;
inline constexpr std::size_t kTileRays = kRayTileSide * kRayTileSide;

/// How many tiles so many pixels of a row or column lie in.
constexpr std::int64_t tiles_along(std::int64_t pixels) {
  return (pixels + kRayTileSide - 1) / kRayTileSide;
}

/// Where a ray stands that has nothing before it.
inline constexpr float kRayDone = 4e9f;
/// Rays that look for a surface look no farther behind a stop, in steps.
inline constexpr float kBehindStop = 0.5f;

/// Shorter steps along an axis count as this.
inline constexpr float kSmallestStep = 1e-9f;
/// Light where no side of a surface is known.
inline constexpr float kFlatLight = 0.75f;
/// What part of it comes from all around.
inline constexpr float kFlatAmbient = 0.25f;
/// What is left of the lamp's light where nothing of it comes.
inline constexpr float kDeepestShadow = 0.15f;
/// A smaller share of light is none.
inline constexpr float kNoLight = 1 / 400.0f;
/// A highlight is the cosine squared so many times.
inline constexpr int kShineSquares = 5;
/// Parts of a step in which its length counts: 1 << it.
inline constexpr int kStepParts = 6;
/// Halvings of the step in which the voxels of an isosurface that are seen begin: 1/4096 of it
/// remains.
inline constexpr int kHitHalvings = 12;
/// Straight lines between values by which an isosurface is found within a step; what remains is
/// less than a thousandth of it where values bend as between samples of a ball.
inline constexpr int kHitLines = 3;
/// Below an isovalue by no less, in pooled values.
inline constexpr float kSmallestExcess = 1e-20f;
/// The gradient of a cut, far above all that is soft.
inline constexpr float kCutGradient = 1e6f;

/// Where the rays of a tile stop for something that is no sample, as polygons are: parts between
/// samples end there and begin there.
struct RayStops {
  alignas(64) std::array<float, kTileRays> stop{};  ///< in steps; kRayDone: nowhere
  alignas(64) std::array<float, kTileRays> from{};  ///< what lies before it is taken
  std::array<std::uint32_t, kTileRays> next{};      ///< what it stops for
  bool has_started = false;
};

/// Rays of a tile that share a span, one after the other: 4 x 4 pixels.
inline constexpr std::size_t kSpanRays = 16;

/// Between which steps there may be anything; nothing where the first lies behind the last.
struct OccupiedSpan {
  float first = kRayDone;  ///< a whole number, as the last
  float last = -1;
};

/// The rays of a tile in Z order: 4, 8 or 16 of them in a row are a small rectangle.
struct RayTile {
  float u = 0;  ///< of the middle of its first pixel
  float v = 0;
  /// Next sample; below 0, and then times -1, where all before it is composited.
  alignas(64) std::array<float, kTileRays> k{};
  /// Colors times opacity. Where they are averaged `red` is the integral of values. Of an
  /// isosurface the light on it, its highlight, and where it was hit as a fraction of k.
  alignas(64) std::array<float, kTileRays> red{};
  alignas(64) std::array<float, kTileRays> green{};
  alignas(64) std::array<float, kTileRays> blue{};
  /// Opacity, of an isosurface 0 or 1 + its look; length of what is averaged, in steps; the highest
  /// value.
  alignas(64) std::array<float, kTileRays> gathered{};
  alignas(64) std::array<std::int32_t, kTileRays> waits_for{};  ///< a brick, or below 0
  const RayStops* stops = nullptr;  ///< of modes volume and iso; none where no ray stops
  /// Of each 16 rays in a row, modes volume and iso; none where they are not known.
  const OccupiedSpan* spans = nullptr;
};

/// That of a ray; or none.
inline const OccupiedSpan* occupied_span_of(const RayTile& tile, std::size_t ray) {
  return tile.spans == nullptr ? nullptr : tile.spans + ray / kSpanRays;
}

/// Column and row of each ray in its tile.
struct TileOrder {
  alignas(64) std::array<float, kTileRays> column{};
  alignas(64) std::array<float, kTileRays> row{};
};

constexpr TileOrder make_tile_order() {
  TileOrder order;
  for (std::size_t i = 0; i < kTileRays; ++i) {
    std::size_t column = 0;
    std::size_t row = 0;
    for (std::size_t bit = 0; bit < 5; ++bit) {
      column |= (i >> (2 * bit) & 1) << bit;
      row |= (i >> (2 * bit + 1) & 1) << bit;
    }
    order.column[i] = static_cast<float>(column);
    order.row[i] = static_cast<float>(row);
  }
  return order;
}

inline constexpr TileOrder kTileOrder = make_tile_order();

/// Calls follow(mode, is_wide) with the two as types.
template <class Follow>
std::int64_t with_ray_mode(const RayFrame& frame, Follow&& follow) {
  const auto of_type = [&](auto mode) {
    return frame.bricks.is_wide ? follow(mode, std::true_type{}) : follow(mode, std::false_type{});
  };
  switch (frame.mode) {
    case RayMode::extreme: return of_type(std::integral_constant<RayMode, RayMode::extreme>{});
    case RayMode::mean: return of_type(std::integral_constant<RayMode, RayMode::mean>{});
    case RayMode::iso: return of_type(std::integral_constant<RayMode, RayMode::iso>{});
    default: return of_type(std::integral_constant<RayMode, RayMode::volume>{});
  }
}

/// Follows the rays of a tile until each is done, waits for a brick or has come to its stop.
/// Returns the samples taken.
using FollowRays = std::int64_t (*)(const RayFrame& frame, RayTile& tile);

/// That of plain C++.
std::int64_t follow_rays_portable(const RayFrame& frame, RayTile& tile);

/// The best this machine has; all give the same bits.
FollowRays follow_rays_function();

/// That of a level of simd_level.h, or nothing where this machine has none.
std::optional<FollowRays> follow_rays_function_of(std::string_view level);

}  // namespace octavo
