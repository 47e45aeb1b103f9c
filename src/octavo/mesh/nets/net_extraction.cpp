#include "octavo/mesh/nets/net_extraction.h"

#include <algorithm>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/mesh/block_layers.h"
#include "octavo/mesh/nets/net_block.h"
#include "octavo/threads/per_thread.h"

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

/// What BlockLayers does with blocks; those of one label are null.
template <class T>
class NetExtraction {
 public:
  using Layer = BlockLayers<NetBlock>::Layer;

  NetExtraction(const FileReader& reader, int level, NetSink& sink)
      : filler_(reader, level),
        size_(reader.levels().size(level)),
        is_mirrored_(SurfaceFrame(reader.levels().geometry(reader.description().geometry, level),
                                  size_)
                         .is_mirrored()),
        sink_(sink) {}

  void extract(Progress& progress) {
    BlockLayers<NetBlock> layers(size_, progress);
    quads_.resize(layers.layer_blocks());
    layers.visit(*this);
  }

  void fetch(const Index3& place) { filler_.fetch(place, spaces_.local()); }

  std::unique_ptr<NetBlock> make(const Index3& place) {
    NetSpace<T>& space = spaces_.local();
    if (!filler_.fill(place, space)) return nullptr;
    return space.maker.make(LabelFiller<T>::corner_of(place));
  }

  void number(NetBlock& block) {
    sink_.add_points(block.points);
    std::vector<NetPoint>().swap(block.points);
    number_pairs(block);
  }

  void join(std::size_t i, NetBlock& block, const NetBlocksBefore& blocks) {
    quads_[i] = joined_quads(blocks, is_mirrored_);
    std::vector<NetFace>().swap(block.faces);
  }

  void finish(const Layer& /*layer*/) {
    for (auto& some : quads_) {
      if (!some.empty()) sink_.add_quads(some);
      std::vector<NetQuad>().swap(some);
    }
    sink_.finish_layer();
  }

 private:
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

  LabelFiller<T> filler_;
  Size3 size_;
  bool is_mirrored_;
  NetSink& sink_;
  std::vector<std::vector<NetQuad>> quads_;  // of the blocks of a layer
  std::map<LabelPair, std::uint32_t> pair_numbers_;
  PerThread<NetSpace<T>> spaces_;
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
      NetExtraction<T>(reader, level, sink).extract(progress);
    }
  });
}

}  // namespace octavo
