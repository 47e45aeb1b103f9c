#include "octavo/builder/tree_builder.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstring>
#include <deque>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include "octavo/builder/build_setup.h"
#include "octavo/builder/coarse_tiers.h"
#include "octavo/builder/group_reader.h"
#include "octavo/builder/tier_encoder.h"
#include "octavo/builder/training.h"
#include "octavo/builder/tree_bricks.h"
#include "octavo/codec/label_bricks.h"
#include "octavo/core/checked.h"
#include "octavo/core/error.h"
#include "octavo/file/layer_order.h"
#include "octavo/file/write/interrupted.h"
#include "octavo/file/write/writer.h"
#include "octavo/threads/ordered_pipeline.h"
#include "octavo/threads/per_thread.h"
#include "octavo/threads/started_work.h"

namespace octavo {

namespace {

constexpr std::size_t kTreeBricksPerThread = 4;  // encoded at a time
constexpr std::size_t kBricksPerLook = 4096;  // without asking whether to stop
// Samples to train on, the index, the file's own buffers.
constexpr std::uint64_t kTreeFixedBytes = std::uint64_t{64} << 20;

Error cancelled(const char* while_what) {
  return {ErrorKind::cancelled, std::string("stopped while ") + while_what};
}

// The brick layers that share a model.
struct Group {
  std::int64_t first_layer = 0;
  std::int64_t end_layer = 0;
  std::int64_t planes = 0;
  std::vector<std::vector<std::int64_t>> labels;  // [layer][y][x] of its bricks
  std::vector<Index3> mixed;                      // its bricks of several labels, in file order
  Model model;
  StartedWork training;
};

// The digests of the planes of a layer, made while its bricks are encoded.
struct LayerDigests {
  std::vector<Sha256Digest> digests;
  StartedWork work;
};

// What a thread works with.
struct BrickWorkspace {
  LabelWords words;
  LabelWords decoded;
};

// One build: the groups of tier 0, then the tiers made of parents.
class TreeBuild {
 public:
  TreeBuild(const TreeBricks& bricks, const VolumeDescription& description, const Levels& levels,
            int threads, Progress& progress)
      : bricks_(bricks),
        description_(description),
        levels_(levels),
        type_(description.type),
        grid_(levels.brick_grid(0)),
        workers_(threads),
        progress_(progress),
        order_(layer_order(grid_)),
        parents_(static_cast<std::size_t>(levels.brick_count(0) * bytes_per_voxel(type_))) {
    uniform_.segments.resize(static_cast<std::size_t>(levels.tier_level_count(0)));
  }

  /// Throws what the writer throws; Error{cancelled, internal}.
  std::uint64_t run(Storage& storage, const std::string& path, const WriterOptions& options) {
    workers_.run([&] { encode_groups(storage, path, options); });
    encode_coarse_tiers({description_, levels_, workers_, *writer_, progress_}, *first_model_, {},
                        std::move(parents_));
    writer_->finish();
    return writer_->bytes_written();
  }

 private:
  // While a group is encoded, threads that find nothing to do in it train for those behind it.
  void encode_groups(Storage& storage, const std::string& path, const WriterOptions& options) {
    const std::int64_t layers =
        (group_planes(levels_, type_) + levels_.brick_side(0).z - 1) / levels_.brick_side(0).z;
    std::deque<std::unique_ptr<Group>> groups;
    std::int64_t next_layer = 0;
    const auto begin_group = [&] {
      if (next_layer == grid_.z) return;
      groups.push_back(std::make_unique<Group>());
      Group& group = *groups.back();
      group.first_layer = next_layer;
      group.end_layer = next_layer = std::min(grid_.z, next_layer + layers);
      group.training.start([this, &group] { prepare(group); });
    };
    const AllTrained all_trained{groups};
    for (int i = 0; i <= workers_.count(); ++i) begin_group();

    const std::uint32_t content_hash = bricks_.checksum(group_planes(levels_, type_), type_);
    writer_ = FileWriter::create(storage, path, description_, levels_, content_hash, options);
    while (!groups.empty()) {
      Group& group = *groups.front();
      group.training.wait();
      if (!first_model_) first_model_ = group.model;
      encode(group);
      groups.pop_front();
      begin_group();
    }
  }

  // Waits for what was started, also where something else has failed.
  struct AllTrained {
    std::deque<std::unique_ptr<Group>>& groups;
    ~AllTrained() {
      for (const auto& group : groups) end(group->training);
    }
  };

  struct AllHashed {
    std::vector<std::unique_ptr<LayerDigests>>& layers;
    ~AllHashed() {
      for (const auto& layer : layers) end(layer->work);
    }
  };

  static void end(StartedWork& work) {
    work.cancel();
    try {
      work.wait();
    } catch (...) {
      // What failed first is on its way already.
    }
  }

  // Finds the bricks of several labels and trains a model on a choice of them.
  void prepare(Group& group) const {
    std::vector<std::int64_t> voxel_counts;
    for (std::int64_t layer = group.first_layer; layer < group.end_layer; ++layer) {
      if (progress_.is_cancelled()) throw cancelled("looking for bricks");
      const auto& labels = group.labels.emplace_back(bricks_.labels_of_layer(layer));
      for (const Index3& at : order_) {
        if (labels[place_of(at)] != kSeveralLabels) continue;
        const Index3 brick{at.x, at.y, layer};
        group.mixed.push_back(brick);
        voxel_counts.push_back(levels_.brick_box(0, brick).size().voxel_count());
      }
      group.planes += levels_.brick_box(0, {0, 0, layer}).size().z;
    }
    const auto chosen = training_choice(voxel_counts, levels_.brick_side(0).voxel_count());
    std::vector<BrickShape> shapes;
    for (const std::size_t i : chosen) shapes.push_back(brick_shape(levels_, 0, group.mixed[i]));
    const auto take = [&](std::size_t i, LabelWords& words) {
      if (progress_.is_cancelled()) throw cancelled("training");
      bricks_.words_of_brick(group.mixed[chosen[i]], words);
    };
    group.model = make_model(train_label_words(type_, shapes, take), type_);
  }

  void encode(const Group& group) {
    writer_->add_model(group.model.serialized);
    kept_ = 0;
    digests_.clear();
    const AllHashed all_hashed{digests_};
    for (std::int64_t layer = group.first_layer; layer < group.end_layer; ++layer) {
      LayerDigests& made = *digests_.emplace_back(std::make_unique<LayerDigests>());
      made.work.start(
          [this, &group, &made, layer] { made.digests = digests_of_layer(group, layer); });
    }
    std::size_t next = 0;
    ordered_pipeline(
        group.mixed.size(), kTreeBricksPerThread * static_cast<std::size_t>(workers_.count()),
        [&](std::size_t i) { return encode_checked(group.model, group.mixed[i]); },
        [&](const EncodedBrick& encoded) {
          keep_uniform(group);
          keep(group, group.mixed[next++], encoded);
        });
    keep_uniform(group);
  }

  EncodedBrick encode_checked(const Model& model, const Index3& brick) {
    if (progress_.is_cancelled()) throw cancelled("encoding bricks");
    const BrickShape shape = brick_shape(levels_, 0, brick);
    auto& [words, decoded] = workspaces_.local();
    bricks_.words_of_brick(brick, words);
    EncodedBrick encoded = as_label_codec(*model.encoder).encode_words(shape, words);
    const std::vector<ByteSpan> segments(encoded.segments.begin(), encoded.segments.end());
    try {
      as_label_codec(*model.decoder).decode_words(shape, encoded.range, segments, decoded);
    } catch (const Error& error) {
      fail_brick(0, brick, " (" + error.detail() + ")");
    }
    if (decoded != words) fail_brick(0, brick, "");
    return encoded;
  }

  // Hands on the bricks of one label up to the next one of several.
  void keep_uniform(const Group& group) {
    for (const std::size_t count = order_.size() * group.labels.size(); kept_ < count;) {
      const std::size_t layer = kept_ / order_.size();
      const Index3& at = order_[kept_ % order_.size()];
      const std::int64_t label = group.labels[layer][place_of(at)];
      if (label == kSeveralLabels) return;
      if (kept_ % kBricksPerLook == 0 && progress_.is_cancelled()) {
        throw cancelled("writing bricks");
      }
      uniform_.range = {label, label};
      uniform_.parent = label;
      keep(group, {at.x, at.y, group.first_layer + static_cast<std::int64_t>(layer)}, uniform_);
    }
  }

  // Planes of a layer whose bricks are each of one label are alike: one is hashed.
  std::vector<Sha256Digest> digests_of_layer(const Group& group, std::int64_t layer) const {
    const auto& labels = group.labels[static_cast<std::size_t>(layer - group.first_layer)];
    const std::int64_t planes = levels_.brick_box(0, {0, 0, layer}).size().z;
    if (std::ranges::count(labels, kSeveralLabels) > 0) {
      return bricks_.plane_digests(layer, planes, type_, progress_);
    }
    const bool is_uniform = std::ranges::count(labels, labels.front()) == std::ssize(labels);
    return {static_cast<std::size_t>(planes),
            is_uniform ? uniform_plane_digest(description_, labels.front())
                       : bricks_.plane_digests(layer, 1, type_, progress_).front()};
  }

  void keep(const Group& group, const Index3& brick, const EncodedBrick& encoded) {
    if ((kept_ + 1) % order_.size() == 0) {
      LayerDigests& layer = *digests_[kept_ / order_.size()];
      layer.work.wait();
      writer_->add_plane_digests(layer.digests);
    }
    writer_->add_brick(0, encoded);
    with_voxel_type(type_, [&](auto id) {
      const auto value = static_cast<typename decltype(id)::type>(encoded.parent);
      const auto at = static_cast<std::size_t>(brick.z * grid_.x * grid_.y) + place_of(brick);
      std::memcpy(parents_.data() + at * sizeof value, &value, sizeof value);
    });
    const auto count = static_cast<std::int64_t>(order_.size() * group.labels.size());
    const auto done = static_cast<std::int64_t>(kept_++);
    const std::int64_t planes =
        (done + 1) * group.planes / count - done * group.planes / count;
    if (planes > 0) progress_.advance(planes);
  }

  std::size_t place_of(const Index3& brick) const {
    return static_cast<std::size_t>(brick.y * grid_.x + brick.x);
  }

  const TreeBricks& bricks_;
  const VolumeDescription& description_;
  const Levels& levels_;
  VoxelType type_;
  Size3 grid_;  // of bricks
  Workers workers_;
  PerThread<BrickWorkspace> workspaces_;
  Progress& progress_;
  std::vector<Index3> order_;  // of the bricks of a layer
  std::unique_ptr<FileWriter> writer_;
  std::optional<Model> first_model_;
  EncodedBrick uniform_;
  std::size_t kept_ = 0;  // bricks of the group that the writer has
  std::vector<std::unique_ptr<LayerDigests>> digests_;  // of its layers
  std::vector<std::byte> parents_;
};

void check_request(const VolumeDescription& description, const Size3& tree_size,
                   const TreeBricks& bricks, const TreeBuildOptions& options) {
  const auto reject = [](const char* why) { throw Error(ErrorKind::invalid_argument, why); };
  if (!is_integer(description.type)) reject("labels are integers; these voxels are float32");
  if (description.size != tree_size) reject("a tree of another size than the volume");
  if (!bricks.fits(description.type)) reject("a label that the voxel type does not have");
  if (options.interrupted == Interrupted::resume) reject("a build of a tree cannot be resumed");
}

template <class Volume>
BuildResult build(const Volume& volume, Storage& storage, const std::string& path,
                  const TreeBuildOptions& options, Progress& progress) {
  const auto start = std::chrono::steady_clock::now();
  VolumeDescription description = volume.description;
  description.kind = VolumeKind::labels;
  description.coding.reset();
  description.metadata.set_written_by(this_writer());
  const Levels levels = levels_of(description);
  const auto bricks = bricks_of_tree(volume.tree, levels);
  check_request(description, volume.tree.size(), *bricks, options);

  BuildResult result;
  result.threads = build_threads(options.threads);
  result.raw_bytes =
      checked_mul(static_cast<std::uint64_t>(description.size.voxel_count()),
                  static_cast<std::uint64_t>(bytes_per_voxel(description.type)), "the volume");
  check_build_memory(tree_build_memory_bytes(description, result.threads),
                     options.max_memory_bytes, result.threads);
  check_target(storage, path, options.overwrite);
  if (options.interrupted == Interrupted::reject) {
    reject_running(storage, path);
    reject_interrupted(storage, path);
  }

  const ProgressScope scope(progress, options.progress_name, description.size.z, "planes");
  WriterOptions writing;
  writing.overwrite = options.overwrite;
  writing.discards_interrupted = options.interrupted == Interrupted::discard;
  writing.is_cancelled = [&progress] { return progress.is_cancelled(); };
  writing.has_thumbnail = options.has_thumbnail;
  TreeBuild work(*bricks, description, levels, result.threads, progress);
  result.file_bytes = work.run(storage, path, writing);
  result.total_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

template <class Volume>
BuildResult build_named(const Volume& volume, Storage& storage, const std::string& path,
                        const TreeBuildOptions& options, Progress& progress) {
  try {
    return build(volume, storage, path, options, progress);
  } catch (const std::bad_alloc&) {
    throw out_of_build_memory(path);
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::internal) throw error.with_path(path);
    throw;
  }
}

}  // namespace

BuildResult build_mask_file(const DescribedMask& mask, Storage& storage, const std::string& path,
                            const TreeBuildOptions& options, Progress& progress) {
  return build_named(mask, storage, path, options, progress);
}

BuildResult build_label_file(const DescribedLabels& labels, Storage& storage,
                             const std::string& path, const TreeBuildOptions& options,
                             Progress& progress) {
  return build_named(labels, storage, path, options, progress);
}

std::uint64_t tree_build_memory_bytes(const VolumeDescription& description, int threads) {
  const Levels levels = levels_of(description);
  const auto bricks = static_cast<std::uint64_t>(levels.brick_count(0));
  const Size3 grid = levels.brick_grid(0);
  const auto layers = static_cast<std::uint64_t>(
      (group_planes(levels, description.type) + levels.brick_side(0).z - 1) /
      levels.brick_side(0).z);
  const auto workers = static_cast<std::uint64_t>(build_threads(threads));
  // Parents; the order of bricks in a layer; labels of the bricks of each group that is prepared.
  const std::uint64_t parents =
      checked_mul(bricks, static_cast<std::uint64_t>(bytes_per_voxel(description.type)),
                  "the memory of parents");
  const std::uint64_t per_brick =
      sizeof(Index3) + (workers + 2) * layers * (sizeof(std::int64_t) + sizeof(Index3));
  const std::uint64_t lists =
      checked_mul(static_cast<std::uint64_t>(grid.x * grid.y), per_brick, "the memory of bricks");
  return checked_add(checked_add(parents, lists, "the memory of a build"),
                     workers * kThreadBytes + kTreeFixedBytes, "the memory of a build");
}

}  // namespace octavo
