#include "octavo/mesh/nets/net_extraction.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/mesh/nets/net_block.h"

namespace octavo {

namespace {

/// The part of a block that one brick of the file covers, in voxels of the volume.
template <class T>
struct LabelPart {
  Box box;
  bool is_uniform = false;
  T label{};  ///< of uniform ones
};

/// What a thread works with.
template <class T>
struct NetSpace {
  NetBlockMaker<T> maker;
  std::vector<LabelPart<T>> parts;
};

/// Fills the labels of blocks out of one file and level.
template <class T>
class LabelFiller {
 public:
  LabelFiller(const FileReader& reader, int level)
      : reader_(reader),
        level_(level),
        size_(reader.levels().size(level)),
        brick_side_(brick_side_at(reader.levels(), level)) {}

  static Index3 corner_of(const Index3& place) {
    return {place.x * kSurfaceSide, place.y * kSurfaceSide, place.z * kSurfaceSide};
  }

  /// Has the reader decode and keep the bricks that begin in a block.
  void fetch(const Index3& place, NetSpace<T>& space) const {
    const Index3 corner = corner_of(place);
    find_parts(corner, space.parts);
    for (const LabelPart<T>& part : space.parts) {
      const Index3& lo = part.box.lo;
      if (!part.is_uniform && lo.x >= corner.x && lo.y >= corner.y && lo.z >= corner.z) {
        read(part.box, corner, space.maker.labels);
      }
    }
  }

  /// False where all labels are one.
  bool fill(const Index3& place, NetSpace<T>& space) const {
    const Index3 corner = corner_of(place);
    find_parts(corner, space.parts);
    const bool is_within = box_of(size_).contains(block_box(corner));
    const T first = is_within && !space.parts.empty() ? space.parts.front().label : T{};
    const auto is_first = [&](const LabelPart<T>& part) {
      return part.is_uniform && part.label == first;
    };
    if (std::all_of(space.parts.begin(), space.parts.end(), is_first)) return false;

    SurfaceValues<T>& labels = space.maker.labels;
    if (!is_within) std::fill(labels.values.begin(), labels.values.end(), T{});
    for (const LabelPart<T>& part : space.parts) {
      if (part.is_uniform) set(part, corner, labels);
      else read(part.box, corner, labels);
    }
    return true;
  }

 private:
  static Box block_box(const Index3& corner) {
    return {{corner.x - 1, corner.y - 1, corner.z - 1},
            {corner.x + kSurfaceSide, corner.y + kSurfaceSide, corner.z + kSurfaceSide}};
  }

  void find_parts(const Index3& corner, std::vector<LabelPart<T>>& parts) const {
    const Box block = block_box(corner);
    parts.clear();
    visit_cells(intersection(block, box_of(size_)), brick_side_, [&](const Index3& brick) {
      const ValueRange range = reader_.brick(Levels::tier_of(level_), brick).range;
      parts.push_back({intersection(brick_box_at(reader_.levels(), level_, brick), block),
                       range.min == range.max,
                       static_cast<T>(reader_.description().voxel_of(range.min))});
      return true;
    });
  }

  static T* place_of(const Index3& voxel, const Index3& corner, SurfaceValues<T>& labels) {
    return labels.at(static_cast<int>(voxel.x - corner.x), static_cast<int>(voxel.y - corner.y),
                     static_cast<int>(voxel.z - corner.z));
  }

  void read(const Box& box, const Index3& corner, SurfaceValues<T>& labels) const {
    reader_.read_strided(box, level_, place_of(box.lo, corner, labels), SurfaceValues<T>::kRow,
                         SurfaceValues<T>::kPlane);
  }

  static void set(const LabelPart<T>& part, const Index3& corner, SurfaceValues<T>& labels) {
    const Box& box = part.box;
    for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
      for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
        std::fill_n(place_of({box.lo.x, y, z}, corner, labels), box.hi.x - box.lo.x, part.label);
      }
    }
  }

  const FileReader& reader_;
  int level_;
  Size3 size_;
  Size3 brick_side_;
};

template <class T>
class NetExtraction {
 public:
  NetExtraction(const FileReader& reader, int level, NetSink& sink, Progress& progress)
      : filler_(reader, level),
        size_(reader.levels().size(level)),
        is_mirrored_(SurfaceFrame(reader.levels().geometry(reader.description().geometry, level),
                                  size_)
                         .is_mirrored()),
        sink_(sink),
        progress_(progress) {
    // One block more than the voxels fill: the last corners lie behind them.
    grid_ = {size_.x / kSurfaceSide + 1, size_.y / kSurfaceSide + 1, size_.z / kSurfaceSide + 1};
  }

  void extract() {
    NetLayer before(layer_blocks());
    for (std::int64_t z = 0; z < grid_.z; ++z) {
      NetLayer layer = make_layer(z);
      number(layer);
      join(before, layer);
      sink_.finish_layer();
      before = std::move(layer);
      const std::int64_t planes = size_.z - z * kSurfaceSide;
      progress_.advance(std::clamp<std::int64_t>(planes, 0, kSurfaceSide));
    }
  }

 private:
  /// The blocks of one layer, [y][x]; those of one label are null.
  using NetLayer = std::vector<std::unique_ptr<NetBlock>>;

  static constexpr std::size_t kFetchedBlocks = 128;

  std::size_t layer_blocks() const { return static_cast<std::size_t>(grid_.x * grid_.y); }

  template <class Work>
  void for_each_block(std::size_t first, std::size_t end, Work work) {
    tbb::parallel_for(first, end, [&](std::size_t i) {
      if (progress_.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
      const auto at = static_cast<std::int64_t>(i);
      work(i, at % grid_.x, at / grid_.x);
    });
  }

  /// Blocks overlap in the bricks that they read. So that no two threads decode the same one, those
  /// of some blocks are all fetched before these are made.
  NetLayer make_layer(std::int64_t z) {
    NetLayer layer(layer_blocks());
    for (std::size_t first = 0; first < layer.size(); first += kFetchedBlocks) {
      const std::size_t end = std::min(first + kFetchedBlocks, layer.size());
      if (tbb::this_task_arena::max_concurrency() > 1) {
        for_each_block(first, end, [&](std::size_t, std::int64_t x, std::int64_t y) {
          filler_.fetch({x, y, z}, spaces_.local());
        });
      }
      for_each_block(first, end, [&](std::size_t i, std::int64_t x, std::int64_t y) {
        NetSpace<T>& space = spaces_.local();
        if (!filler_.fill({x, y, z}, space)) return;
        layer[i] = space.maker.make(LabelFiller<T>::corner_of({x, y, z}));
      });
    }
    return layer;
  }

  /// Gives the points of a layer their numbers, and hands them out.
  void number(const NetLayer& layer) {
    for (const auto& block : layer) {
      if (!block) continue;
      constexpr std::uint64_t kMost = std::numeric_limits<std::uint32_t>::max();
      if (point_count_ + block->points.size() > kMost) {
        throw Error(ErrorKind::limit_exceeded,
                    "the surface has more than " + std::to_string(kMost) + " points")
            .with_field("level");
      }
      block->first_point = static_cast<std::uint32_t>(point_count_);
      point_count_ += block->points.size();
      sink_.add_points(block->points);
      std::vector<NetPoint>().swap(block->points);
      number_pairs(*block);
    }
  }

  /// Gives the pairs of a block their numbers, and hands out those that are new.
  void number_pairs(NetBlock& block) {
    std::vector<LabelPair> added;
    for (const LabelPair& pair : block.pairs) {
      const auto next = static_cast<std::uint32_t>(pair_numbers_.size());
      const auto [place, is_new] = pair_numbers_.emplace(pair, next);
      if (is_new) added.push_back(pair);
      block.pair_numbers.push_back(place->second);
    }
    if (!added.empty()) sink_.add_pairs(added);
  }

  void join(const NetLayer& before, const NetLayer& layer) {
    std::vector<std::vector<NetQuad>> quads(layer.size());
    for_each_block(0, layer.size(), [&](std::size_t i, std::int64_t x, std::int64_t y) {
      if (!layer[i]) return;
      NetBlocksBefore blocks{};
      for (std::size_t dz = 0; dz < 2; ++dz) {
        for (std::size_t dy = 0; dy < 2; ++dy) {
          for (std::size_t dx = 0; dx < 2; ++dx) {
            if ((dx == 1 && x == 0) || (dy == 1 && y == 0)) continue;
            const std::size_t at = i - dx - dy * static_cast<std::size_t>(grid_.x);
            blocks[dz][dy][dx] = (dz == 0 ? layer : before)[at].get();
          }
        }
      }
      quads[i] = joined_quads(blocks, is_mirrored_);
      std::vector<NetFace>().swap(layer[i]->faces);
    });
    for (const auto& some : quads) {
      if (!some.empty()) sink_.add_quads(some);
    }
  }

  LabelFiller<T> filler_;
  Size3 size_;
  bool is_mirrored_;
  NetSink& sink_;
  Progress& progress_;
  Size3 grid_;  // of blocks
  std::uint64_t point_count_ = 0;
  std::map<LabelPair, std::uint32_t> pair_numbers_;
  tbb::enumerable_thread_specific<NetSpace<T>> spaces_;
};

void require_net(const FileReader& reader, int level) {
  if (level < 0 || level >= reader.levels().count()) {
    throw Error(ErrorKind::invalid_argument, "there is no level " + std::to_string(level));
  }
  const VolumeDescription& volume = reader.description();
  if (volume.kind != VolumeKind::labels || volume.type == VoxelType::float32) {
    throw Error(ErrorKind::invalid_argument, "surfaces between labels need labels");
  }
  constexpr std::int64_t kMost = std::numeric_limits<std::int32_t>::max() - kSurfaceSide;
  const Size3 size = reader.levels().size(level);
  if (std::max({size.x, size.y, size.z}) > kMost) {
    throw Error(ErrorKind::limit_exceeded,
                "a side has more than " + std::to_string(kMost) + " voxels")
        .with_field("level");
  }
}

}  // namespace

void extract_net(const FileReader& reader, int level, NetSink& sink, Progress& progress) {
  require_net(reader, level);
  with_voxel_type(reader.description().type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    if constexpr (std::is_integral_v<T>) {
      NetExtraction<T>(reader, level, sink, progress).extract();
    }
  });
}

}  // namespace octavo
