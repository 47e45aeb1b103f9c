#include "octavo/tasks/files/two_values.h"

#include <algorithm>
#include <cstring>
#include <vector>

namespace octavo {

namespace {

class WatchedValues final : public PlaneSource {
 public:
  WatchedValues(std::unique_ptr<PlaneSource> source, std::shared_ptr<TwoValues> found)
      : source_(std::move(source)), found_(std::move(found)) {
    is_over_ = !is_integer(source_->description().type);
  }

  const VolumeDescription& description() const override { return source_->description(); }
  const std::vector<Warning>& warnings() const override { return source_->warnings(); }
  std::uint64_t resident_bytes() const override { return source_->resident_bytes(); }
  const PlaneFiles& files() const override { return source_->files(); }

  void read_plane(std::span<std::byte> plane) override {
    source_->read_plane(plane);
    if (is_over_) return;
    with_voxel_type(description().type, [&](auto tag) {
      using T = typename decltype(tag)::type;
      if constexpr (std::is_integral_v<T>) look_at<T>(plane);
    });
    const bool has_two = !is_over_ && values_.size() == 2;
    *found_ = has_two ? TwoValues(std::minmax(values_[0], values_[1])) : std::nullopt;
  }

  bool can_seek() const override { return source_->can_seek(); }

  // Some planes do not say what all of them hold.
  void seek(std::int64_t first, std::int64_t end) override {
    source_->seek(first, end);
    is_over_ = true;
    found_->reset();
  }

 private:
  static constexpr std::size_t kVoxelsAtOnce = 4096;

  template <class T>
  void look_at(std::span<const std::byte> plane) {
    std::vector<T> voxels(kVoxelsAtOnce);
    for (std::size_t at = 0; at < plane.size() && !is_over_; at += kVoxelsAtOnce * sizeof(T)) {
      const std::size_t bytes = std::min(plane.size() - at, kVoxelsAtOnce * sizeof(T));
      std::memcpy(voxels.data(), plane.data() + at, bytes);
      take(std::span<const T>(voxels.data(), bytes / sizeof(T)));
    }
  }

  template <class T>
  void take(std::span<const T> voxels) {
    if (values_.empty()) values_.push_back(static_cast<std::int64_t>(voxels[0]));
    const auto first = static_cast<T>(values_[0]);
    if (values_.size() == 1) {
      const auto other = std::find_if(voxels.begin(), voxels.end(),
                                      [&](T voxel) { return voxel != first; });
      if (other == voxels.end()) return;
      values_.push_back(static_cast<std::int64_t>(*other));
    }
    const auto second = static_cast<T>(values_[1]);
    bool is_third = false;  // without a branch in the loop
    for (const T voxel : voxels) is_third |= (voxel != first) & (voxel != second);
    is_over_ = is_third;
  }

  std::unique_ptr<PlaneSource> source_;
  std::shared_ptr<TwoValues> found_;
  std::vector<std::int64_t> values_;  // that have come, up to two
  bool is_over_ = false;              // a third one came, or the voxels are floats
};

}  // namespace

std::unique_ptr<PlaneSource> watch_values(std::unique_ptr<PlaneSource> source,
                                          std::shared_ptr<TwoValues> found) {
  return std::make_unique<WatchedValues>(std::move(source), std::move(found));
}

}  // namespace octavo
