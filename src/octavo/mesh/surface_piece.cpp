#include "octavo/mesh/surface_piece.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/memory_limit.h"
#include "octavo/mesh/block_maker.h"
#include "octavo/mesh/cancellation.h"
#include "octavo/mesh/piece_sets.h"
#include "octavo/mesh/point_distance.h"
#include "octavo/threads/parallel_for.h"
#include "octavo/threads/per_thread.h"

namespace octavo {

namespace {

/// Blocks in the order in which extract_surface has them.
struct BlockOrder {
  bool operator()(const Index3& a, const Index3& b) const {
    return std::tie(a.z, a.y, a.x) < std::tie(b.z, b.y, b.x);
  }
};
using BlockPlaces = std::set<Index3, BlockOrder>;

bool is_made(std::uint32_t point) { return point < kUnmadePoint; }

template <class T>
class PieceTracker {
 public:
  PieceTracker(const FileReader& reader, int level, const SurfaceField& field,
               std::uint64_t max_bytes, Progress& progress)
      : maker_(reader, level, field), max_bytes_(max_bytes), progress_(progress) {
    const Size3& size = maker_.frame().size();
    grid_ = {size.x / kSurfaceSide + 1, size.y / kSurfaceSide + 1, size.z / kSurfaceSide + 1};
  }

  std::optional<SurfacePiece> run(const Point3& seed, const Geometry& geometry) {
    const std::int64_t block_count = grid_.voxel_count();
    const ProgressScope scope(progress_, "surface", block_count, "blocks");
    const double reach_mm = std::sqrt(dot(geometry.spacing_mm, geometry.spacing_mm));
    BlockPlaces wave = blocks_around(seed, geometry, reach_mm);
    make(wave);
    join(wave);
    const auto start = nearest_point(wave, geometry.to_world(seed), reach_mm);
    if (!start) return std::nullopt;
    for (wave = next_wave(*start); !wave.empty(); wave = next_wave(*start)) {
      make(wave);
      join(with_those_after(wave));
    }
    // The rest is not passed.
    progress_.advance(block_count - static_cast<std::int64_t>(blocks_.size()));
    return SurfacePiece{piece_of(*start), maker_.decoded_bricks()};
  }

 private:
  /// Those that hold all points of triangles within reach of the seed.
  BlockPlaces blocks_around(const Point3& seed, const Geometry& geometry, double reach_mm) const {
    Index3 first;
    Index3 last;
    for (int axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<std::size_t>(axis);
      const double reach = reach_mm / geometry.spacing_mm[i] + 2;
      const double most = static_cast<double>(grid_[axis] * kSurfaceSide - 1);
      const auto block_at = [&](double at) {
        return static_cast<std::int64_t>(std::clamp(at, 0.0, most)) / kSurfaceSide;
      };
      first[axis] = block_at(seed[i] - reach);
      last[axis] = block_at(seed[i] + reach);
    }
    BlockPlaces places;
    for (std::int64_t z = first.z; z <= last.z; ++z) {
      for (std::int64_t y = first.y; y <= last.y; ++y) {
        for (std::int64_t x = first.x; x <= last.x; ++x) places.insert({x, y, z});
      }
    }
    return places;
  }

  /// Makes blocks; those that the surface does not cut are null. Bricks that begin in them are
  /// decoded first, so that no two threads decode the same one.
  void make(const BlockPlaces& wave) {
    const std::vector<Index3> places(wave.begin(), wave.end());
    std::vector<std::unique_ptr<SurfaceBlock>> made(places.size());
    const auto for_each = [&](auto work) {
      parallel_for(std::size_t{0}, places.size(), [&](std::size_t i) {
        stop_if_cancelled(progress_);
        work(i);
      });
    };
    if (places.size() > 1) {
      for_each([&](std::size_t i) { maker_.fetch(places[i], spaces_.local()); });
    }
    for_each([&](std::size_t i) { made[i] = maker_.make(places[i], spaces_.local()); });
    progress_.advance(static_cast<std::int64_t>(places.size()));
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (made[i]) number(*made[i]);
      blocks_[places[i]] = std::move(made[i]);
    }
    sets_.grow_to(points_.size());
  }

  void number(SurfaceBlock& block) {
    if (points_.size() + block.points.size() > kUnmadePoint) {
      throw Error(ErrorKind::limit_exceeded,
                  "the surface has more than " + std::to_string(kUnmadePoint) + " points")
          .with_field("level");
    }
    block.first_point = static_cast<std::uint32_t>(points_.size());
    points_.insert(points_.end(), block.points.begin(), block.points.end());
    std::vector<MeshPoint>().swap(block.points);
    require_memory_within(points_.size() * sizeof(MeshPoint), max_bytes_, "the surface",
                          "raise the limit, or take a coarser level");
  }

  const SurfaceBlock* block_at(const Index3& place) const {
    const auto found = blocks_.find(place);
    return found == blocks_.end() ? nullptr : found->second.get();
  }

  std::vector<MeshTriangle> triangles_of(const Index3& place) {
    BlocksBefore before{};
    for (std::int64_t i = 0; i < 8; ++i) {
      const Index3 d = {i & 1, i >> 1 & 1, i >> 2};
      before[static_cast<std::size_t>(d.z)][static_cast<std::size_t>(d.y)]
            [static_cast<std::size_t>(d.x)] =
                block_at({place.x - d.x, place.y - d.y, place.z - d.z});
    }
    if (before[0][0][0] == nullptr) return {};
    MeshRoom<MeshTriangle>& room = rooms_.local();
    room.clear();
    join_triangles(before, maker_.frame().is_mirrored(), room);
    return {room.all().begin(), room.all().end()};
  }

  /// Of each block its triangles, as far as the blocks that their points belong to are made.
  std::vector<std::vector<MeshTriangle>> triangles_of_all(const std::vector<Index3>& places) {
    std::vector<std::vector<MeshTriangle>> all(places.size());
    parallel_for(std::size_t{0}, places.size(),
                      [&](std::size_t i) { all[i] = triangles_of(places[i]); });
    return all;
  }

  BlockPlaces with_those_after(const BlockPlaces& wave) const {
    BlockPlaces all;
    for (const Index3& place : wave) {
      for (std::int64_t i = 0; i < 8; ++i) {
        const Index3 after = {place.x + (i & 1), place.y + (i >> 1 & 1), place.z + (i >> 2)};
        if (block_at(after) != nullptr) all.insert(after);
      }
    }
    return all;
  }

  /// Joins the points of triangles, and notes what blocks a piece goes on in.
  void join(const BlockPlaces& blocks) {
    const std::vector<Index3> places(blocks.begin(), blocks.end());
    const auto triangles = triangles_of_all(places);
    for (std::size_t i = 0; i < places.size(); ++i) {
      for (const MeshTriangle& t : triangles[i]) join(t, places[i]);
      if (const SurfaceBlock* const block = block_at(places[i])) {
        note_blocks_after(*block, places[i]);
      }
    }
  }

  void join(const MeshTriangle& t, const Index3& place) {
    const auto made = std::find_if(t.begin(), t.end(), is_made);
    if (made == t.end()) return;
    for (const std::uint32_t point : t) {
      if (is_made(point)) {
        sets_.join(*made, point);
        continue;
      }
      const auto before = static_cast<std::int64_t>((point - kUnmadePoint) / kUnmadeBlock);
      note({place.x - (before & 1), place.y - (before >> 1 & 1), place.z - (before >> 2)}, *made);
    }
  }

  /// A block that the piece of a point passes.
  void note(const Index3& place, std::uint32_t point) {
    for (int axis = 0; axis < 3; ++axis) {
      if (place[axis] < 0 || place[axis] >= grid_[axis]) return;
    }
    if (blocks_.contains(place)) return;
    const auto next = static_cast<std::uint32_t>(waiting_.size());
    const auto [number, is_new] = waiting_numbers_.try_emplace(place, next);
    if (is_new) waiting_.push_back(place);
    sets_.note(point, number->second);
  }

  /// Edges that end at the last voxels of a block belong to cubes of the blocks behind it as well.
  void note_blocks_after(const SurfaceBlock& block, const Index3& place) {
    constexpr int kLast = kSurfaceSide - 1;
    constexpr std::uint64_t kLastBit = std::uint64_t{1} << kLast;
    for (int z = 0; z < kSurfaceSide; ++z) {
      for (int y = 0; y < kSurfaceSide; ++y) {
        const RowStarts& starts = block.starts.at(y, z);
        if (starts.x == starts.end) continue;
        const CutEdges cut = cut_edges(block.bits, y, z);
        const bool is_last_y = y == kLast;
        const bool is_last_z = z == kLast;
        // Along each axis: cut edges, the number of the first, and where the cubes around go on.
        note_row(cut.x, 0, starts.x, {0, is_last_y, is_last_z}, block, place);
        note_row(cut.y, kLastBit, starts.y, {1, 0, is_last_z}, block, place);
        note_row(cut.z, kLastBit, starts.z, {1, is_last_y, 0}, block, place);
      }
    }
  }

  /// ends  bits of the edges whose cubes go on along x
  void note_row(std::uint64_t cut, std::uint64_t ends, std::uint32_t number, const Index3& on,
                const SurfaceBlock& block, const Index3& place) {
    if (on.y == 0 && on.z == 0 && (cut & ends) == 0) return;
    for (; cut != 0; cut &= cut - 1, ++number) {
      const std::int64_t on_x = (cut & (~cut + 1) & ends) != 0 ? 1 : 0;
      for (std::int64_t i = 1; i < 8; ++i) {
        const Index3 d = {i & 1, i >> 1 & 1, i >> 2};
        if (d.x > on_x || d.y > on.y || d.z > on.z) continue;
        note({place.x + d.x, place.y + d.y, place.z + d.z}, block.first_point + number);
      }
    }
  }

  /// A point of the triangle nearest to a place.
  std::optional<std::uint32_t> nearest_point(const BlockPlaces& blocks, const Point3& place_mm,
                                             double reach_mm) {
    const std::vector<Index3> places(blocks.begin(), blocks.end());
    std::optional<std::uint32_t> nearest;
    double best = reach_mm * reach_mm;
    for (const auto& triangles : triangles_of_all(places)) {
      for (const MeshTriangle& t : triangles) {
        if (!std::all_of(t.begin(), t.end(), is_made)) continue;
        const double squared = squared_distance(
            place_mm, {place_of_point(points_[t[0]]), place_of_point(points_[t[1]]),
                       place_of_point(points_[t[2]])});
        if (nearest ? squared >= best : squared > best) continue;
        best = squared;
        nearest = t[0];
      }
    }
    return nearest;
  }

  /// The blocks that wait for the piece of a point.
  BlockPlaces next_wave(std::uint32_t start) {
    BlockPlaces wave;
    for (const std::uint32_t number : sets_.take(start)) {
      if (!blocks_.contains(waiting_[number])) wave.insert(waiting_[number]);
    }
    return wave;
  }

  TriangleMesh piece_of(std::uint32_t start) {
    const std::uint32_t piece = sets_.first_of(start);
    TriangleMesh mesh;
    std::vector<std::uint32_t> numbers(points_.size());
    std::vector<Index3> places;
    for (const auto& [place, block] : blocks_) {
      if (!block) continue;
      places.push_back(place);
      const std::uint32_t count = block->starts.at(kSurfaceSide - 1, kSurfaceSide - 1).end;
      for (std::uint32_t i = block->first_point; i < block->first_point + count; ++i) {
        if (sets_.first_of(i) != piece) continue;
        numbers[i] = static_cast<std::uint32_t>(mesh.points.size());
        mesh.points.push_back(points_[i]);
      }
    }
    for (const auto& triangles : triangles_of_all(places)) {
      for (const MeshTriangle& t : triangles) {
        if (!is_made(t[0]) || sets_.first_of(t[0]) != piece) continue;
        mesh.triangles.push_back({numbers[t[0]], numbers[t[1]], numbers[t[2]]});
      }
      require_memory_within(mesh.memory_bytes(), max_bytes_, "the surface",
                            "raise the limit, or take a coarser level");
    }
    return mesh;
  }

  BlockMaker<T> maker_;
  std::uint64_t max_bytes_;
  Progress& progress_;
  Size3 grid_;  // of blocks
  std::map<Index3, std::unique_ptr<SurfaceBlock>, BlockOrder> blocks_;
  /// Blocks that were not made when a piece was found to pass them, and their numbers.
  std::vector<Index3> waiting_;
  std::map<Index3, std::uint32_t, BlockOrder> waiting_numbers_;
  std::vector<MeshPoint> points_;  // in the order in which they were found
  PieceSets sets_;
  PerThread<BlockSpace<T>> spaces_;
  PerThread<MeshRoom<MeshTriangle>> rooms_;
};

}  // namespace

std::optional<SurfacePiece> surface_piece(const FileReader& reader, int level,
                                          const SurfaceField& field, const Point3& seed,
                                          std::uint64_t max_bytes, Progress& progress) {
  const Geometry geometry = reader.levels().geometry(reader.description().geometry, level);
  std::optional<SurfacePiece> piece;
  with_voxel_type(reader.description().type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    piece = PieceTracker<T>(reader, level, field, max_bytes, progress).run(seed, geometry);
  });
  return piece;
}

}  // namespace octavo
