// Masks and label maps as octrees in memory.
#pragma once

#include <nanobind/nanobind.h>

#include <memory>
#include <string>

#include "octavo/octree/label_tree.h"
#include "octavo/tasks/masks.h"

namespace octavo::python {

/// A mask, or a map of several labels; one of both trees is there.
class LabelMap {
 public:
  explicit LabelMap(ComputedMask mask)
      : mask_(std::make_shared<const ComputedMask>(std::move(mask))) {}
  LabelMap(LabelTree labels, VolumeDescription volume)
      : labels_(std::make_shared<const LabelTree>(std::move(labels))),
        volume_(std::move(volume)) {}

  const VolumeDescription& volume() const { return mask_ ? mask_->volume : volume_; }
  /// Null where it is a mask.
  const LabelTree* labels() const { return labels_.get(); }
  /// Null where it is no mask.
  const MaskTree* tree() const { return mask_ ? &mask_->tree : nullptr; }
  /// Every voxel that is not 0. Runs on the threads of the context
  std::shared_ptr<const ComputedMask> mask(const TaskContext& context) const;
  /// All labels; of a mask 1. Runs on the threads of the context
  std::shared_ptr<const LabelTree> label_tree(const TaskContext& context) const;

 private:
  std::shared_ptr<const ComputedMask> mask_;
  std::shared_ptr<const LabelTree> labels_;
  VolumeDescription volume_;
};

void bind_label_maps(nanobind::module_& module);

}  // namespace octavo::python
