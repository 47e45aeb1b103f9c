#include "octavo/tasks/threshold.h"

#include <array>
#include <cstring>
#include <memory>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/tasks/file_planes.h"
#include "octavo/tasks/inputs.h"

namespace octavo {

namespace {

constexpr const char* kThreshold = "threshold";

using LabelCounts = std::array<std::uint64_t, 256>;

struct StoredClass {
  std::int64_t label = 1;
  ValueWindow window;
};

/// All that was asked for as classes, in the order in which they count.
std::vector<ValueClass> asked_classes(const ThresholdOptions& options,
                                      const VolumeDescription& volume,
                                      const TaskContext& context) {
  check_tissues(options.tissues, volume, options.input, context);
  std::vector<ValueClass> classes;
  for (const AskedRange& range : options.ranges) classes.push_back({1, range});
  for (const std::string& name : options.tissues) {
    classes.push_back({1, tissue_range(name)});
  }
  if (!options.labels.is_empty() && volume.kind != VolumeKind::labels) {
    throw Error(ErrorKind::invalid_argument, "holds grey values, not labels", options.input)
        .with_field("labels.range");
  }
  for (const std::int64_t label :
       labels_of(options.labels, volume.metadata.facts().labels, options.input)) {
    const auto value = static_cast<double>(label);
    classes.push_back({1, {value, value}});
  }
  classes.insert(classes.end(), options.classes.begin(), options.classes.end());
  if (classes.empty()) {
    throw Error(ErrorKind::invalid_argument,
                "a threshold needs a range, a tissue, a label or a class");
  }
  for (const ValueClass& one : classes) {
    if (one.label >= 1 && one.label <= 255) continue;
    throw Error(ErrorKind::invalid_argument,
                "label " + std::to_string(one.label) + "; classes have labels of 1 to 255");
  }
  return classes;
}

MadeBy made_by(const ThresholdOptions& options, const std::vector<ValueClass>& classes) {
  std::vector<JsonObject> ranges;
  for (const auto& [label, range] : classes) {
    ranges.push_back(
        JsonObject().set("label", label).set("low", range.lowest).set("high", range.highest));
  }
  MadeBy made(kThreshold);
  return made.set("units", options.is_stored ? "stored" : "real").set("ranges", ranges);
}

/// Planes of class labels, from planes of values.
class ClassPlanes final : public PlaneSource {
 public:
  ClassPlanes(std::unique_ptr<PlaneSource> values, std::vector<StoredClass> classes,
              const MadeBy& made_by)
      : values_(std::move(values)),
        classes_(std::move(classes)),
        description_(label_description(values_->description(), VoxelType::uint8, made_by)) {}

  const VolumeDescription& description() const override { return description_; }
  const std::vector<Warning>& warnings() const override { return values_->warnings(); }
  const PlaneFiles& files() const override { return values_->files(); }
  /// Voxels of each label in the planes that were read.
  const LabelCounts& counts() const { return counts_; }

  void read_plane(std::span<std::byte> plane) override {
    const VoxelType type = values_->description().type;
    buffer_.resize(plane.size() * static_cast<std::size_t>(bytes_per_voxel(type)));
    values_->read_plane(buffer_);
    with_voxel_type(type, [&](auto id) {
      using T = typename decltype(id)::type;
      for (std::size_t i = 0; i < plane.size(); ++i) {
        T value;
        std::memcpy(&value, buffer_.data() + i * sizeof value, sizeof value);
        const std::uint8_t label = label_of(static_cast<double>(value));
        plane[i] = static_cast<std::byte>(label);
        ++counts_[label];
      }
    });
  }

  bool can_seek() const override { return values_->can_seek(); }
  void seek(std::int64_t first, std::int64_t end) override { values_->seek(first, end); }

 private:
  std::uint8_t label_of(double value) const {
    for (const StoredClass& c : classes_) {
      if (c.window.contains(value)) return static_cast<std::uint8_t>(c.label);
    }
    return 0;
  }

  std::unique_ptr<PlaneSource> values_;
  std::vector<StoredClass> classes_;
  VolumeDescription description_;
  std::vector<std::byte> buffer_;
  LabelCounts counts_{};
};

std::vector<StoredClass> stored_classes(const std::vector<ValueClass>& asked,
                                        const VolumeDescription& volume, bool is_stored) {
  std::vector<StoredClass> classes;
  for (const ValueClass& one : asked) {
    classes.push_back({one.label, stored_window(one.range, volume, is_stored)});
  }
  return classes;
}

/// One mask of all classes.
ComputedMask mask_of_classes(const FileReader& reader, const std::vector<ValueClass>& asked,
                     const ThresholdOptions& options, const TaskContext& context) {
  const VolumeDescription& volume = reader.description();
  std::vector<ValueWindow> windows;
  for (const StoredClass& one : stored_classes(asked, volume, options.is_stored)) {
    windows.push_back(one.window);
  }
  ComputedMask mask{read_mask(reader, 0, windows, context),
                    label_description(volume, VoxelType::uint8, made_by(options, asked))};
  if (mask.tree.is_empty()) {
    const std::string& name = options.output.path.empty() ? options.input : options.output.path;
    const bool is_of_labels = options.ranges.empty() && options.tissues.empty();
    const std::string none = is_of_labels ? "has such a label" : "lies in the range";
    context.warn(name + ": no voxel " + none + "; the mask is empty");
  }
  return mask;
}

}  // namespace

ComputedVolume threshold_planes(const ThresholdOptions& options, const TaskContext& context) {
  const std::shared_ptr<const FileReader> reader = open_volume(options.input, context);
  const VolumeDescription& volume = reader->description();
  const std::vector<ValueClass> asked = asked_classes(options, volume, context);
  std::vector<StoredClass> classes = stored_classes(asked, volume, options.is_stored);
  return {std::make_unique<ClassPlanes>(
              std::make_unique<FilePlanes>(reader, 0, context.thread_count()), std::move(classes),
              made_by(options, asked)),
          {.kind = VolumeKind::labels, .is_resumable = false}};
}

ComputedMask threshold_mask(const FileReader& reader, const ThresholdOptions& options,
                            const TaskContext& context) {
  if (!options.classes.empty()) {
    throw Error(ErrorKind::invalid_argument, "a mask has one class");
  }
  const std::vector<ValueClass> asked = asked_classes(options, reader.description(), context);
  return mask_of_classes(reader, asked, options, context);
}

ThresholdResult threshold(const ThresholdOptions& options, const TaskContext& context) {
  const std::shared_ptr<const FileReader> reader = open_volume(options.input, context);
  const VolumeDescription& volume = reader->description();
  const std::vector<ValueClass> asked = asked_classes(options, volume, context);
  require_computed(options.output, {options.input});

  ThresholdResult result{volume, {}, 0};
  if (options.classes.empty()) {
    const ComputedMask mask = mask_of_classes(*reader, asked, options, context);
    result.file_bytes =
        write_described_mask(mask.tree, mask.volume, options.output, kThreshold, context)
            .file_bytes;
    result.objects.push_back({1, mask.tree.voxel_count()});
    return result;
  }
  ClassPlanes planes(std::make_unique<FilePlanes>(reader, 0, context.thread_count()),
                     stored_classes(asked, volume, options.is_stored), made_by(options, asked));
  result.file_bytes = write_labels(planes, options.output, kThreshold, context).file_bytes;
  const LabelCounts& counts = planes.counts();
  for (std::size_t label = 1; label < counts.size(); ++label) {
    if (counts[label] == 0) continue;
    result.objects.push_back({static_cast<std::int64_t>(label), counts[label]});
  }
  return result;
}

}  // namespace octavo
