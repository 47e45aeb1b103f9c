#include "octavo/tasks/files/named_labels.h"

#include <utility>

#include "octavo/core/error.h"

namespace octavo {

namespace {

class NamedLabels final : public PlaneSource {
 public:
  NamedLabels(std::unique_ptr<PlaneSource> source, const LabelNames& names)
      : source_(std::move(source)), description_(source_->description()) {
    set_label_names(description_.metadata, names);
  }

  const VolumeDescription& description() const override { return description_; }
  const std::vector<Warning>& warnings() const override { return source_->warnings(); }
  std::uint64_t resident_bytes() const override { return source_->resident_bytes(); }
  const PlaneFiles& files() const override { return source_->files(); }
  void read_plane(std::span<std::byte> plane) override { source_->read_plane(plane); }
  bool can_seek() const override { return source_->can_seek(); }
  void seek(std::int64_t first, std::int64_t end) override { source_->seek(first, end); }

 private:
  std::unique_ptr<PlaneSource> source_;
  VolumeDescription description_;
};

}  // namespace

void require_labels_to_name(VolumeKind kind, const std::string& path) {
  if (kind == VolumeKind::labels) return;
  throw Error(ErrorKind::invalid_argument, "holds grey values, no labels to be named", path)
      .with_field("label_names");
}

void set_label_names(Metadata& metadata, const LabelNames& names) {
  if (!metadata.is_readable()) {
    throw Error(ErrorKind::corrupt,
                "the metadata cannot be read, so that no names can be put into them: " +
                    metadata.defect());
  }
  if (names.is_empty()) metadata.drop_labels();
  else metadata.set_labels(names);
  if (metadata.facts().labels == names) return;
  throw Error(ErrorKind::limit_exceeded,
              "the metadata have no room for the names of " + std::to_string(names.size()) +
                  " labels: " + metadata.defect());
}

std::unique_ptr<PlaneSource> with_label_names(std::unique_ptr<PlaneSource> source,
                                              const LabelNames& names) {
  return std::make_unique<NamedLabels>(std::move(source), names);
}

}  // namespace octavo
