#include "octavo/io/source/slice_source.h"

#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/planes/plane_cursor.h"

namespace octavo {

namespace {

/// "2 x + 100".
std::string rescale_text(const Rescale& rescale) {
  return number_text(rescale.slope) + " x + " + number_text(rescale.intercept);
}

class SliceSource final : public PlaneSource {
 public:
  SliceSource(SliceStack stack, const SourceOptions& options, SliceOpener open)
      : stack_(std::move(stack)),
        options_(options),
        open_(std::move(open)),
        cursor_(stack_.description.size.z) {
    if (const std::string fault = fault_of(stack_); !fault.empty()) {
      throw Error(ErrorKind::invalid_argument, "a stack has " + fault);
    }
  }

  const VolumeDescription& description() const override { return stack_.description; }
  const std::vector<Warning>& warnings() const override { return warnings_; }
  const PlaneFiles& files() const override { return stack_.files; }

  void read_plane(std::span<std::byte> plane) override {
    if (!slices_) open_slices();
    cursor_.take();
    slices_->read_plane(plane);
    const std::vector<Warning>& all = slices_->warnings();
    for (; passed_ < all.size(); ++passed_) warnings_.push_back(all[passed_]);
  }

  void seek(std::int64_t first, std::int64_t end) override {
    cursor_.seek(first, end);
    slices_.reset();
  }

 private:
  void open_slices() {
    if (cursor_.is_done()) return;
    auto [paths, outline] = excerpt_of(stack_.files, cursor_.next(), cursor_.end());
    SourceOptions options = options_;
    options.excerpt = std::move(outline);
    std::unique_ptr<PlaneSource> slices = open_(paths, options);
    require_alike(slices->description(), paths.front());
    passed_ = slices->warnings().size();
    slices_ = std::move(slices);
  }

  void require_alike(const VolumeDescription& found, const std::string& path) const {
    const VolumeDescription& stack = stack_.description;
    const Size3 expected = {stack.size.x, stack.size.y, cursor_.end() - cursor_.next()};
    const bool is_alike = found.size == expected && found.type == stack.type;
    if (is_alike && found.rescale == stack.rescale) return;
    if (is_alike) {
      throw Error(ErrorKind::source_rejected,
                  "the slices from here on have the rescale " + rescale_text(found.rescale) +
                      ", those of the stack had " + rescale_text(stack.rescale),
                  path);
    }
    throw Error(ErrorKind::source_rejected,
                "the slices from here on hold " + size_text(found.size) + " voxels of " +
                    std::string(voxel_type_name(found.type)) + ", those of the stack were " +
                    size_text(expected) + " of " + std::string(voxel_type_name(stack.type)),
                path);
  }

  SliceStack stack_;
  SourceOptions options_;
  SliceOpener open_;
  PlaneCursor cursor_;
  std::unique_ptr<PlaneSource> slices_;  ///< of the planes from the one sought on
  std::vector<Warning> warnings_;
  std::size_t passed_ = 0;
};

}  // namespace

std::unique_ptr<PlaneSource> make_slice_source(SliceStack stack, const SourceOptions& options,
                                               SliceOpener open) {
  return std::make_unique<SliceSource>(std::move(stack), options, std::move(open));
}

}  // namespace octavo
