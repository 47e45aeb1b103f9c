#include "octavo/tasks/components/component_planes.h"

#include <algorithm>
#include <utility>

#include "octavo/builder/build_memory.h"
#include "octavo/core/error.h"
#include "octavo/ops/mask/file_mask.h"
#include "octavo/tasks/components/component_rows.h"
#include "octavo/tasks/components/components_in_parts.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/masks.h"
#include "octavo/threads/parallel_for.h"
#include "octavo/threads/per_thread.h"

namespace octavo {

namespace {

// Planes and rows that are filled at once: whole words of the mask.
constexpr std::int64_t kSlabPlanes = 4;
constexpr std::int64_t kBandRows = 64;

/// Passes on the wish to stop, and no progress: a build counts its planes itself.
class CancelledWith final : public Progress {
 public:
  explicit CancelledWith(const Progress& other) : other_(other) {}
  void begin(std::string_view, std::int64_t, std::string_view) override {}
  void advance(std::int64_t) override {}
  void end() override {}
  bool is_cancelled() const override { return other_.is_cancelled(); }

 private:
  const Progress& other_;
};

/// What a build leaves of the memory limit for the mask of a part. Where that is less than a
/// quarter of the limit it is up to half of it, and the build does with less, in bands; it is never
/// 0, which would be no limit.
/// held  by the planes besides that mask
std::uint64_t left_of_limit(const VolumeDescription& description, std::uint64_t held,
                            const TaskContext& context) {
  constexpr std::uint64_t kBandBytes = std::uint64_t{16} << 20;
  const std::uint64_t limit = context.max_memory_bytes;
  if (limit == 0) return 0;
  const auto left = [&](std::uint64_t build) { return limit - std::min(limit, build + held); };
  const int threads = context.thread_count();
  const std::uint64_t beside_whole = left(build_memory_bytes(description, threads));
  if (beside_whole >= limit / 4) return beside_whole;
  const std::uint64_t beside_bands =
      std::min(limit / 2, left(band_memory_bytes(description, threads, kBandBytes)));
  return std::max({beside_bands, beside_whole, std::uint64_t{1}});
}

template <class T>
void copy_labels(const std::vector<std::uint32_t>& found, std::span<const std::uint32_t> numbers,
                 const Box& rows, const Size3& size, T* slab) {
  const auto columns = static_cast<std::size_t>(size.x);
  const auto band = static_cast<std::size_t>(rows.size().y) * columns;
  const auto plane = static_cast<std::size_t>(size.y) * columns;
  for (std::size_t z = 0; z < static_cast<std::size_t>(rows.size().z); ++z) {
    const std::uint32_t* const from = found.data() + z * band;
    T* const to = slab + z * plane + static_cast<std::size_t>(rows.lo.y) * columns;
    for (std::size_t i = 0; i < band; ++i) {
      to[i] = from[i] == 0 ? T{0} : static_cast<T>(numbers[from[i] - 1]);
    }
  }
}

}  // namespace

MaskOfPart::MaskOfPart(const FileReader& reader, const WorkPart& part, Connectivity connectivity,
                       std::uint64_t max_bytes, const TaskContext& context) {
  CancelledWith progress(context.watcher());
  context.on_threads([&] {
    mask_ = mask_of_file(reader, 0, any_label(), progress, max_bytes, part);
    components_.emplace(mask_, connectivity, max_bytes);
  });
}

std::uint64_t MaskOfPart::memory_bytes() const {
  return mask_.memory_bytes() + components_->memory_bytes();
}

ComponentPlanes::ComponentPlanes(std::shared_ptr<const FileReader> reader,
                                 VolumeDescription description, ComponentNumbers numbers,
                                 std::string path, const TaskContext& context)
    : SlabPlanes(kSlabPlanes, description.size.z, reader->source().name()),
      reader_(std::move(reader)),
      description_(std::move(description)),
      numbers_(std::move(numbers)),
      path_(std::move(path)),
      context_(context),
      max_bytes_(left_of_limit(description_, held_bytes(), context)),
      files_(files_of_volume({reader_->source().name(), path_})) {}

std::uint64_t ComponentPlanes::held_bytes() const {
  const Size3& size = description_.size;
  auto bytes = static_cast<std::uint64_t>(size.x * size.y * kSlabPlanes *
                                          bytes_per_voxel(description_.type));
  for (const auto& labels : numbers_.labels) bytes += labels.capacity() * sizeof(std::uint32_t);
  return bytes;
}

std::uint64_t ComponentPlanes::resident_bytes() const {
  return held_bytes() + std::max(max_bytes_, open_ ? open_->memory_bytes() : 0);
}

void ComponentPlanes::open_part_of(std::int64_t z) {
  std::swap(open_, kept_);
  const std::int64_t kept_before = std::exchange(kept_part_, part_);
  const auto count = static_cast<std::int64_t>(numbers_.labels.size());
  for (part_ = 0; part_ < count; ++part_) {
    const PlanesOfPart planes = planes_of_part(description_.size.z, {part_, count});
    part_begin_ = planes.first;
    part_end_ = planes.end;
    if (z >= part_begin_ && z < part_end_) break;
  }
  if (open_ && part_ == kept_before) return;
  open_.reset();
  open_ = opened({part_, count});
  const std::size_t found = open_->components().components().size();
  const std::size_t numbered = numbers_.labels[static_cast<std::size_t>(part_)].size();
  if (found == numbered) return;
  throw Error(ErrorKind::corrupt,
              "numbers " + std::to_string(numbered) + " components of part " +
                  std::to_string(part_) + " of the mask, which has " + std::to_string(found) +
                  "; join the parts anew",
              path_);
}

std::unique_ptr<const MaskOfPart> ComponentPlanes::opened(const WorkPart& part) {
  const auto within = [&](std::uint64_t most) {
    ++opened_parts_;
    return std::make_unique<const MaskOfPart>(*reader_, part, numbers_.options.connectivity, most,
                                              context_);
  };
  const std::uint64_t kept = kept_ ? kept_->memory_bytes() : 0;
  do_two_fit_ = do_two_fit_ && kept < max_bytes_;
  if (kept_ && do_two_fit_) {
    try {
      return within(max_bytes_ - kept);
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::limit_exceeded) throw;
      do_two_fit_ = false;
    }
  }
  kept_.reset();
  return within(max_bytes_);
}

void ComponentPlanes::fill_slab(std::int64_t begin, std::int64_t end, std::span<std::byte> slab) {
  if (begin < part_begin_ || begin >= part_end_) open_part_of(begin);
  const Size3& size = description_.size;
  PerThread<std::vector<std::uint32_t>> labels_of_threads;
  context_.on_threads([&] {
    parallel_for(std::int64_t{0}, (size.y + kBandRows - 1) / kBandRows, [&](std::int64_t i) {
      const Box rows{{0, i * kBandRows, begin},
                     {size.x, std::min((i + 1) * kBandRows, size.y), end}};
      std::vector<std::uint32_t>& labels = labels_of_threads.local();
      labels.resize(static_cast<std::size_t>(rows.size().voxel_count()));
      open_->components().fill_labels(rows, labels.data());
      fill_rows(rows, labels, slab.data());
    });
  });
}

void ComponentPlanes::fill_rows(const Box& rows, const std::vector<std::uint32_t>& labels,
                                std::byte* slab) const {
  const std::vector<std::uint32_t>& numbers = numbers_.labels[static_cast<std::size_t>(part_)];
  const Size3& size = description_.size;
  switch (description_.type) {
    case VoxelType::uint8:
      copy_labels(labels, numbers, rows, size, reinterpret_cast<std::uint8_t*>(slab));
      break;
    case VoxelType::uint16:
      copy_labels(labels, numbers, rows, size, reinterpret_cast<std::uint16_t*>(slab));
      break;
    default: copy_labels(labels, numbers, rows, size, reinterpret_cast<std::uint32_t*>(slab));
  }
}

ComputedVolume labeled_planes(const LabelComponentsOptions& options, const TaskContext& context) {
  auto mask = open_labels(options.input, context, kAsMask);
  ComponentNumbers numbers = read_component_numbers(options.numbers, *mask, context);
  VolumeDescription description =
      description_of_components(numbers.kept, mask->description(), numbers.options);
  return {std::make_unique<ComponentPlanes>(std::move(mask), std::move(description),
                                            std::move(numbers), options.numbers, context),
          {.kind = VolumeKind::labels, .is_resumable = false}};
}

LabeledComponents label_components(const LabelComponentsOptions& options,
                                   const TaskContext& context) {
  const ComputedVolume labeled = labeled_planes(options, context);
  require_computed(options.output, {options.input, options.numbers});
  const auto& planes = static_cast<const ComponentPlanes&>(*labeled.planes);
  LabeledComponents result{planes.numbers().found, planes.numbers().kept};
  result.file_bytes = write_labels(*labeled.planes, options.output, "components", context)
                          .file_bytes;
  return result;
}

}  // namespace octavo
