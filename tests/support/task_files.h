// What the tests of tasks share: files of small masks and labels in a folder that vanishes, and a
// context that remembers its warnings.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/tasks/task_context.h"
#include "support/built_file.h"
#include "support/dense_labels.h"
#include "support/dense_mask.h"

namespace octavo::testing {

class TaskFiles : public ::testing::Test {
 protected:
  TaskFiles() {
    context_.threads = 2;
    context_.on_warning = [this](const Warning& warning) { warnings_.push_back(warning.text); };
  }

  /// Writes labels as they are on a grid of 0.5 x 0.5 x 2 mm, or on one of unknown spacing.
  std::string write(const std::string& name, const DenseLabels& labels,
                    bool is_spacing_known = true) {
    Volume volume = volume_of(labels, 2);
    volume.description.geometry = geometry_;
    if (!is_spacing_known) {
      volume.description.metadata = Metadata::read(R"({"spacing_known":false})");
    }
    build_volume(volume, folder_.file(name), 1);
    return folder_.file(name);
  }

  /// The same with names of its labels.
  std::string write_named(const std::string& name, const DenseLabels& labels,
                          const std::vector<std::pair<std::int64_t, std::string>>& names) {
    LabelNames all;
    for (const auto& [label, text] : names) all.set(label, {text, {}});
    Volume volume = volume_of(labels, 2);
    volume.description.geometry = geometry_;
    volume.description.metadata.set_labels(all);
    build_volume(volume, folder_.file(name), 1);
    return folder_.file(name);
  }

  std::string write(const std::string& name, const DenseMask& mask, bool is_spacing_known = true) {
    DenseLabels labels(mask.size);
    labels.voxels.assign(mask.voxels.begin(), mask.voxels.end());
    return write(name, labels, is_spacing_known);
  }

  /// The voxels of a file, whatever their type.
  static DenseLabels read(const std::string& path) {
    const auto reader = open_file(path);
    const VolumeDescription& volume = reader->description();
    const std::vector<std::byte> bytes = read_box(*reader, box_of(volume.size), 0);
    DenseLabels labels(volume.size);
    with_voxel_type(volume.type, [&](auto id) {
      using T = typename decltype(id)::type;
      for (std::size_t i = 0; i < labels.voxels.size(); ++i) {
        T value;
        std::memcpy(&value, bytes.data() + i * sizeof value, sizeof value);
        labels.voxels[i] = static_cast<std::int32_t>(value);
      }
    });
    return labels;
  }

  /// The labels that `label_of` gives.
  template <class F>
  static DenseLabels computed(const Size3& size, F&& label_of) {
    DenseLabels labels(size);
    for_each_voxel(size, [&](const Index3& p) {
      labels.at(p) = static_cast<std::int32_t>(label_of(p));
    });
    return labels;
  }

  struct Failure {
    ErrorKind kind = ErrorKind::internal;
    std::string field = "nothing failed";
    std::string detail = "nothing failed";
  };

  static Failure failure_of(const std::function<void()>& work) {
    try {
      work();
    } catch (const Error& error) {
      return {error.kind(), error.field(), error.detail()};
    }
    return {};
  }

  ScratchFolder folder_;
  Geometry geometry_{{-10, 20, 5}, {0.5, 0.5, 2}};
  std::vector<std::string> warnings_;
  TaskContext context_;
};

/// Steps to the voxels that touch one at the origin: 6, 18 or 26.
inline std::vector<Index3> neighbor_steps(int connectivity) {
  std::vector<Index3> steps;
  for_each_voxel({3, 3, 3}, [&](const Index3& p) {
    const Index3 step = {p.x - 1, p.y - 1, p.z - 1};
    const std::int64_t length = step.x * step.x + step.y * step.y + step.z * step.z;
    const std::int64_t longest = connectivity == 6 ? 1 : connectivity == 18 ? 2 : 3;
    if (length >= 1 && length <= longest) steps.push_back(step);
  });
  return steps;
}

inline Index3 moved(const Index3& p, const Index3& step) {
  return {p.x + step.x, p.y + step.y, p.z + step.z};
}

/// Numbers the connected parts of equal voxels; every voxel has one.
inline DenseLabels flooded(const DenseMask& mask, int connectivity) {
  DenseLabels parts(mask.size);
  const std::vector<Index3> steps = neighbor_steps(connectivity);
  std::int32_t count = 0;
  for_each_voxel(mask.size, [&](const Index3& seed) {
    if (parts.at(seed) != 0) return;
    parts.at(seed) = ++count;
    std::vector<Index3> open = {seed};
    while (!open.empty()) {
      const Index3 p = open.back();
      open.pop_back();
      for (const Index3& step : steps) {
        const Index3 q = moved(p, step);
        if (!box_of(mask.size).contains(q) || parts.at(q) != 0 || mask.at(q) != mask.at(p)) {
          continue;
        }
        parts.at(q) = count;
        open.push_back(q);
      }
    }
  });
  return parts;
}

}  // namespace octavo::testing
