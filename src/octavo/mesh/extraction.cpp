#include "octavo/mesh/extraction.h"

#include <memory>
#include <string>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/memory_limit.h"
#include "octavo/mesh/block_layers.h"
#include "octavo/mesh/block_maker.h"
#include "octavo/threads/per_thread.h"

namespace octavo {

namespace {

/// What BlockLayers does with blocks; those that are not cut are null.
template <class T>
class Extraction {
 public:
  using Layer = BlockLayers<SurfaceBlock>::Layer;

  Extraction(const FileReader& reader, int level, const SurfaceField& field, SurfaceSink& sink)
      : maker_(reader, level, field), sink_(sink) {}

  void run(Progress& progress) {
    BlockLayers<SurfaceBlock> layers(maker_.frame().size(), progress);
    triangles_.resize(layers.layer_blocks());
    layers.visit(*this);
  }

  void fetch(const Index3& place) { maker_.fetch(place, spaces_.local()); }

  std::unique_ptr<SurfaceBlock> make(const Index3& place) {
    return maker_.make(place, spaces_.local());
  }

  void number(const SurfaceBlock& block) { sink_.add_points(block.points); }

  void join(std::size_t i, const SurfaceBlock& /*block*/, const BlocksBefore& blocks) {
    MeshRoom<MeshTriangle>& room = rooms_.local();
    room.clear();
    join_triangles(blocks, maker_.frame().is_mirrored(), room);
    triangles_[i].assign(room.all().begin(), room.all().end());
  }

  void finish(const Layer& layer) {
    for (auto& some : triangles_) {
      if (!some.empty()) sink_.add_triangles(some);
      std::vector<MeshTriangle>().swap(some);
    }
    sink_.finish_layer();
    for (const auto& block : layer) {
      if (block) std::vector<MeshPoint>().swap(block->points);
    }
  }

 private:
  BlockMaker<T> maker_;
  SurfaceSink& sink_;
  std::vector<std::vector<MeshTriangle>> triangles_;  // of the blocks of a layer
  PerThread<BlockSpace<T>> spaces_;
  PerThread<MeshRoom<MeshTriangle>> rooms_;
};

}  // namespace

void MeshCollector::add_points(std::span<const MeshPoint> points) {
  mesh_.points.insert(mesh_.points.end(), points.begin(), points.end());
}

void MeshCollector::add_triangles(std::span<const MeshTriangle> triangles) {
  mesh_.triangles.insert(mesh_.triangles.end(), triangles.begin(), triangles.end());
}

void MeshCollector::finish_layer() {
  require_memory_within(mesh_.memory_bytes(), max_bytes_, "the surface",
                        "raise the limit, or take a coarser level");
}

void extract_surface(const FileReader& reader, int level, const SurfaceField& field,
                     SurfaceSink& sink, Progress& progress) {
  if (level < 0 || level >= reader.levels().count()) {
    throw Error(ErrorKind::invalid_argument, "there is no level " + std::to_string(level));
  }
  with_voxel_type(reader.description().type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    Extraction<T>(reader, level, field, sink).run(progress);
  });
}

}  // namespace octavo
