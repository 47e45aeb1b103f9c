#include "octavo/tasks/combine.h"

#include <memory>
#include <span>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/ops/mask/set_operations.h"
#include "octavo/tasks/file_planes.h"
#include "octavo/tasks/inputs.h"

namespace octavo {

namespace {

SetOperation operation_of(Combination combination) {
  switch (combination) {
    case Combination::unite: return SetOperation::unite;
    case Combination::intersect: return SetOperation::intersect;
    case Combination::subtract: return SetOperation::subtract;
    default: return SetOperation::exclusive_or;
  }
}

void require_masks(const CombineOptions& options) {
  const std::string name = word_of(options.combination);
  const std::size_t count = options.inputs.size();
  const bool is_complement = options.combination == Combination::complement;
  if (is_complement ? count == 1 : count >= 2) return;
  throw Error(ErrorKind::invalid_argument,
              name + (is_complement ? " takes one mask, got " : " takes two masks or more, got ") +
                  std::to_string(count));
}

/// A further mask on the grid of the first.
MaskTree further_mask(const std::string& path, const OpenedMask& first,
                      const CombineOptions& options, CombineResult& result,
                      const TaskContext& context) {
  if (!options.is_resampling) {
    OpenedMask next = open_mask(path, context);
    require_same_grid(first.volume(), first.path, next.volume(), next.path, "is_resampling");
    return std::move(next.tree);
  }
  MaskOnGrid next = open_mask_on(first.volume(), first.path, path, context);
  if (next.is_resampled) {
    result.resampled.push_back(path);
    context.note(path + ": brought onto the grid of " + first.path + " by nearest voxels");
  }
  return std::move(next.tree);
}

MadeBy made_by(const CombineOptions& options, const CombineResult& result) {
  MadeBy made(word_of(options.combination));
  made.set("masks", options.inputs.size());
  if (!result.resampled.empty()) made.set("resampled", result.resampled.size());
  return made;
}

/// Planes of 0 and 1, from those of masks.
class CombinedPlanes final : public PlaneSource {
 public:
  CombinedPlanes(std::vector<std::unique_ptr<PlaneSource>> masks, Combination combination,
                 VolumeDescription description)
      : masks_(std::move(masks)),
        combination_(combination),
        description_(std::move(description)) {}

  const VolumeDescription& description() const override { return description_; }
  const std::vector<Warning>& warnings() const override { return masks_.front()->warnings(); }
  std::uint64_t resident_bytes() const override {
    std::uint64_t bytes = 0;
    for (const auto& mask : masks_) bytes += mask->resident_bytes();
    return bytes;
  }

  void read_plane(std::span<std::byte> plane) override {
    read_mask_plane(*masks_.front(), plane);
    if (combination_ == Combination::complement) {
      for (std::byte& voxel : plane) voxel ^= std::byte{1};
    }
    next_.resize(plane.size());
    for (std::size_t i = 1; i < masks_.size(); ++i) {
      read_mask_plane(*masks_[i], next_);
      for (std::size_t at = 0; at < plane.size(); ++at) plane[at] = taken(plane[at], next_[at]);
    }
  }

  void seek(std::int64_t first, std::int64_t end) override {
    for (const auto& mask : masks_) mask->seek(first, end);
  }

 private:
  void read_mask_plane(PlaneSource& mask, std::span<std::byte> plane) {
    const auto size = static_cast<std::size_t>(bytes_per_voxel(mask.description().type));
    values_.resize(plane.size() * size);
    mask.read_plane(values_);
    for (std::size_t at = 0; at < plane.size(); ++at) {
      std::byte any{0};
      for (std::size_t i = 0; i < size; ++i) any |= values_[at * size + i];
      plane[at] = any == std::byte{0} ? std::byte{0} : std::byte{1};
    }
  }

  std::byte taken(std::byte a, std::byte b) const {
    switch (combination_) {
      case Combination::unite: return a | b;
      case Combination::intersect: return a & b;
      case Combination::subtract: return a & (b ^ std::byte{1});
      default: return a ^ b;
    }
  }

  std::vector<std::unique_ptr<PlaneSource>> masks_;
  Combination combination_;
  VolumeDescription description_;
  std::vector<std::byte> values_;
  std::vector<std::byte> next_;
};

}  // namespace

ComputedVolume combined_planes(const CombineOptions& options, const TaskContext& context) {
  require_masks(options);
  if (options.is_resampling) {
    throw Error(ErrorKind::invalid_argument,
                "masks that are resampled are combined as octrees, at once: transform brings each "
                "onto the grid of another first");
  }
  std::vector<std::unique_ptr<PlaneSource>> masks;
  const std::string& first_path = options.inputs.front();
  const auto first = open_labels(first_path, context, kAsMask);
  for (const std::string& path : options.inputs) {
    const auto reader = path == first_path ? first : open_labels(path, context, kAsMask);
    require_same_grid(first->description(), first_path, reader->description(), path,
                      "is_resampling");
    masks.push_back(std::make_unique<FilePlanes>(reader, 0, context.thread_count()));
  }
  return {std::make_unique<CombinedPlanes>(
              std::move(masks), options.combination,
              label_description(first->description(), VoxelType::uint8, made_by(options, {}))),
          {.kind = VolumeKind::labels, .is_resumable = false}};
}

ComputedMask combined_mask(const ComputedMask& a, const ComputedMask* b, Combination combination,
                           const TaskContext& context) {
  CombineOptions options{.inputs = std::vector<std::string>(b == nullptr ? 1 : 2),
                         .combination = combination};
  require_masks(options);
  ComputedMask made{MaskTree(), label_description(a.volume, VoxelType::uint8,
                                                  made_by(options, {}))};
  context.on_threads([&] {
    made.tree = b == nullptr ? complement(a.tree)
                             : combine(a.tree, b->tree, operation_of(combination));
  });
  return made;
}

CombineResult combine(const CombineOptions& options, const TaskContext& context) {
  require_masks(options);
  require_computed(options.output, options.inputs);
  OpenedMask first = open_mask(options.inputs.front(), context);
  CombineResult result{.volume = first.volume()};

  MaskTree mask = std::move(first.tree);
  if (options.combination == Combination::complement) {
    context.on_threads([&] { mask = complement(mask); });
  }
  for (std::size_t i = 1; i < options.inputs.size(); ++i) {
    const MaskTree next = further_mask(options.inputs[i], first, options, result, context);
    const SetOperation operation = operation_of(options.combination);
    context.on_threads([&] { mask = combine(mask, next, operation); });
  }

  result.voxels = mask.voxel_count();
  result.file_bytes = write_mask(mask, result.volume, made_by(options, result), options.output,
                                 "combine", context)
                          .file_bytes;
  return result;
}

}  // namespace octavo
