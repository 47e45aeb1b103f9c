#include "octavo/tasks/structure/morphometry.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <memory>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/memory_advice.h"
#include "octavo/core/memory_limit.h"
#include "octavo/core/text.h"
#include "octavo/ops/mask/set_operations.h"
#include "octavo/ops/measure/mask_moments.h"
#include "octavo/ops/morphometry/slab_sums.h"
#include "octavo/planes/computed_source.h"
#include "octavo/tasks/build_planes.h"
#include "octavo/tasks/file_planes.h"
#include "octavo/tasks/files/decoding_memory.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/masks.h"
#include "octavo/tasks/pictures/picture_files.h"
#include "octavo/tasks/structure/thickness_picture.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo {

namespace {

constexpr std::int64_t kMapPlanes = 16;
constexpr double kNarrowestEnd = 2.0 / 3;  // of a region along whose axis pores are measured

/// Sums of values plane by plane, each around the mean of its own: large values that differ little
/// keep their digits.
struct DensitySums {
  DensityMeasure measure;  ///< deviation: sum of squares around the mean

  void add(const std::vector<double>& values) {
    if (values.empty()) return;
    const auto here = static_cast<double>(values.size());
    double mean = 0;
    for (const double value : values) mean += value - values.front();
    mean = values.front() + mean / here;
    double squares = 0;
    for (const double value : values) squares += (value - mean) * (value - mean);
    const auto before = static_cast<double>(measure.voxels);
    const double apart = mean - measure.mean;
    const double share = here / (before + here);
    measure.mean += apart * share;
    measure.deviation += squares + apart * apart * before * share;
    measure.voxels += values.size();
  }

  DensityMeasure finished() const {
    DensityMeasure done = measure;
    if (done.voxels == 0) return done;
    done.deviation = std::sqrt(done.deviation / static_cast<double>(done.voxels));
    return done;
  }
};

class MorphometryWork {
 public:
  MorphometryWork(const MorphometryOptions& options, const TaskContext& context)
      : options_(options),
        context_(context),
        mask_(open_mask(options.input, context)),
        size_(mask_.volume().size),
        spacing_(mask_.volume().geometry.spacing_mm),
        thickness_spacing_(thickness_spacing(spacing_)) {
    require_known_spacing(mask_.volume(), mask_.path, "a measure in mm");
    if (!options.region.empty()) {
      OpenedMask region = open_mask(options.region, context);
      require_same_grid(mask_.volume(), mask_.path, region.volume(), region.path);
      region_ = std::move(region.tree);
      context.on_threads(
          [&] { inside_ = combine(mask_.tree, *region_, SetOperation::intersect); });
    }
    if (!options.grey.empty()) {
      grey_ = open_volume(options.grey, context);
      require_same_grid(mask_.volume(), mask_.path, grey_->description(), options.grey);
      if (grey_->description().kind != VolumeKind::grey) {
        throw Error(ErrorKind::invalid_argument, "holds labels, not grey values", options.grey)
            .with_field("grey.kind");
      }
    }
    require_surface_for_maps();
    context.require_memory(2 * mask_.tree.memory_bytes() + room_bytes(), "the measures");
    require_memory_for_surface();
  }

  MorphometryResult take() {
    measure_volumes();
    measure_form();
    result_.has_thickness = options_.has_thickness;
    if (options_.has_thickness) measure_thickness();
    if (options_.has_tortuosity || options_.has_diffusion) measure_pores();
    if (grey_) measure_densities();
    return std::move(result_);
  }

 private:
  const MaskTree& inside() const { return inside_ ? *inside_ : mask_.tree; }
  const MaskTree* region() const { return region_ ? &*region_ : nullptr; }

  void require_surface_for_maps() const {
    if (options_.thickness_map.path.empty() && options_.spacing_map.path.empty()) return;
    if (mask_.tree.voxel_count() < static_cast<std::uint64_t>(size_.voxel_count())) return;
    throw Error(ErrorKind::invalid_argument,
                "the mask fills the volume: without a surface no map of thickness is defined",
                mask_.path);
  }

  void require_memory_for_surface() const {
    const auto slabs = static_cast<std::uint64_t>(std::min<std::int64_t>(
        context_.thread_count(), sum_slab_count(size_.z)));
    require_memory_within(2 * mask_.tree.memory_bytes() + slabs * surface_shape_bytes(size_) +
                              decoding_bytes(mask_.volume(), context_),
                          context_.max_memory_bytes, "measuring the surface",
                          memory_advice(static_cast<int>(slabs)));
  }

  std::uint64_t room_bytes() const {
    return bytes_beside(2 * mask_.tree.memory_bytes(), context_);
  }

  void measure_volumes() {
    const double voxel = spacing_[0] * spacing_[1] * spacing_[2];
    result_.volume = mask_.volume();
    result_.voxels = inside().voxel_count();
    result_.region_voxels = region_ ? region_->voxel_count()
                                    : static_cast<std::uint64_t>(size_.voxel_count());
    if (result_.voxels == 0) {
      throw Error(ErrorKind::invalid_argument,
                  region_ ? "no voxel of the mask lies in the region" : "the mask is empty",
                  mask_.path);
    }
    result_.bone_mm3 = voxel * static_cast<double>(result_.voxels);
    result_.total_mm3 = voxel * static_cast<double>(result_.region_voxels);
    if (result_.voxels == result_.region_voxels) {
      context_.warn(mask_.path + ": fills all that is measured: there is no surface in it");
    }
    Box box;
    context_.on_threads([&] { box = mask_moments(inside()).box; });
    bool is_cut = false;
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(2 * axis);
      result_.touches[a] = box.lo[axis] == 0;
      result_.touches[a + 1] = box.hi[axis] == size_[axis];
      is_cut = is_cut || result_.touches[a] || result_.touches[a + 1];
    }
    if (is_cut) {
      context_.note(mask_.path + ": touches the border of the volume: faces there are no surface, "
                    "and what lies beyond is not known");
    }
  }

  template <class Work>
  void watched(const char* what, std::int64_t total, const char* unit, Work work) {
    const ProgressScope scope(context_.watcher(), what, total, unit);
    context_.on_threads(work);
  }

  void measure_form() {
    watched("surface", size_.z, "planes", [&] {
      result_.surface = surface_shape(mask_.tree, region(), spacing_, context_.watcher());
    });
    watched("connectivity", size_.z, "planes",
            [&] { result_.euler = euler_numbers(inside(), context_.watcher()); });
    watched("directions", 300, "directions", [&] {
      result_.anisotropy = anisotropy(mask_.tree, region(), spacing_, context_.watcher());
    });
    const double area = result_.surface.area_mm2;
    if (area > 0) {
      result_.smi = 6 * result_.bone_mm3 * result_.surface.growth_mm / (area * area);
    }
    result_.connectivity = 1 - result_.euler.share;
    result_.boxes = box_counts(inside());
    result_.fractal = fractal_dimension(result_.boxes, size_, false);
    result_.surface_fractal = fractal_dimension(result_.boxes, size_, true);
  }

  /// The folder of scratch files.
  std::string scratch_folder() const {
    for (const Output* output : {&options_.thickness_map, &options_.spacing_map}) {
      if (!output->path.empty()) return folder_of(output->path);
    }
    return std::filesystem::temp_directory_path().string();
  }

  void measure_thickness() {
    result_.slices.assign(static_cast<std::size_t>(size_.z), {});
    if (mask_.tree.voxel_count() == static_cast<std::uint64_t>(size_.voxel_count())) {
      for (std::int64_t z = 0; z < size_.z; ++z) {
        SliceMeasure& slice = result_.slices[static_cast<std::size_t>(z)];
        slice.region_voxels = region_voxels_in(z);
        slice.voxels = slice.region_voxels;
      }
      return;
    }
    std::unique_ptr<SiteField> sites;
    watched("distances", size_.z, "planes", [&] {
      sites = make_site_field(inside_of(mask_.tree), thickness_spacing_, room_bytes(),
                              local_storage(), scratch_folder(), context_.watcher());
    });
    result_.thickness = thickness_of(false, options_.thickness_map, *sites);
    result_.spacing = thickness_of(true, options_.spacing_map, *sites);
  }

  ThicknessSummary thickness_of(bool is_background, const Output& map, const SiteField& sites) {
    const ThicknessClass asked{mask_.tree, region(), is_background};
    std::vector<FittingBall> balls;
    const char* const what = is_background ? "spacing" : "thickness";
    watched(is_background ? "balls outside" : "balls inside", size_.z, "planes", [&] {
      balls = fitting_balls(asked, thickness_spacing_, sites, context_.watcher());
    });
    if (!is_background) {
      watched("ellipsoids", ellipsoid_count(balls), "ellipsoids", [&] {
        result_.ellipsoids =
            ellipsoid_factors(asked, thickness_spacing_, balls, context_.watcher());
      });
    }
    const LocalThickness thickness(asked, thickness_spacing_, balls);
    ThicknessSummary summary;
    // What is read of planes goes into the sums once, though a build may ask for it twice.
    std::int64_t added = 0;
    const auto read = [&](std::int64_t begin, std::int64_t end, float* mm) {
      context_.on_threads([&] { thickness.read(begin, end, mm); });
      context_.stop_if_cancelled();
      if (begin != added) return;
      const std::int64_t plane = size_.x * size_.y;
      thickness.add(mm, (end - begin) * plane, summary);
      if (!is_background) add_slices(begin, end, mm);
      added = end;
    };
    if (!map.path.empty()) {
      write_map(what, map, read);
    } else {
      const ProgressScope scope(context_.watcher(), what, size_.z, "planes");
      std::vector<float> mm(static_cast<std::size_t>(kMapPlanes * size_.x * size_.y));
      for (std::int64_t z = 0; z < size_.z; z += kMapPlanes) {
        const std::int64_t end = std::min(z + kMapPlanes, size_.z);
        read(z, end, mm.data());
        context_.watcher().advance(end - z);
      }
    }
    LocalThickness::finish(summary);
    return summary;
  }

  /// What is measured of a plane.
  std::uint64_t region_voxels_in(std::int64_t z) const {
    return region_ ? region_voxels_in({{0, 0, z}, {size_.x, size_.y, z + 1}})
                   : static_cast<std::uint64_t>(size_.x * size_.y);
  }
  std::uint64_t region_voxels_in(const Box& plane) const {
    std::vector<std::uint8_t> voxels(static_cast<std::size_t>(plane.size().voxel_count()));
    fill_voxels(*region_, plane, voxels.data());
    return static_cast<std::uint64_t>(std::count(voxels.begin(), voxels.end(), std::uint8_t{1}));
  }

  void add_slices(std::int64_t begin, std::int64_t end, const float* mm) {
    const std::int64_t plane = size_.x * size_.y;
    for (std::int64_t z = begin; z < end; ++z) {
      SliceMeasure& slice = result_.slices[static_cast<std::size_t>(z)];
      double sum = 0;
      for (std::int64_t i = 0; i < plane; ++i) {
        const float value = mm[(z - begin) * plane + i];
        slice.voxels += value > 0 ? 1 : 0;
        sum += static_cast<double>(value);
      }
      slice.region_voxels = region_voxels_in(z);
      if (slice.voxels > 0) slice.mean_thickness_mm = sum / static_cast<double>(slice.voxels);
    }
  }

  template <class Read>
  void write_map(const char* what, const Output& map, Read read) {
    const VolumeDescription volume =
        mm_description(mask_.volume(), VoxelType::float32, MadeBy("morphometry").set("map", what));
    const auto fill = [&](const Box& box, std::byte* voxels) {
      std::vector<float> mm(static_cast<std::size_t>(box.size().voxel_count()));
      read(box.lo.z, box.hi.z, mm.data());
      std::memcpy(voxels, mm.data(), mm.size() * sizeof(float));
    };
    const auto source = make_computed_source(volume, fill, kMapPlanes);
    build_planes(*source, {.kind = VolumeKind::grey, .is_resumable = false}, map, what, context_);
  }

  /// Whether what is measured is about as wide at both ends across an axis as on average: it is
  /// clear then where ways begin and end.
  bool has_ends(const Box& box, int axis) const {
    if (!region_) return true;
    const auto planes = static_cast<double>(box.size()[axis]);
    const double mean = static_cast<double>(result_.region_voxels) / planes;
    for (const std::int64_t at : {box.lo[axis], box.hi[axis] - 1}) {
      Box plane = box;
      plane.lo[axis] = at;
      plane.hi[axis] = at + 1;
      const auto wide = static_cast<double>(region_voxels_in(plane));
      if (wide < kNarrowestEnd * mean) return false;
    }
    return true;
  }

  /// A byte for each voxel of a box: 1 where it is in the region and not in the mask, else 0.
  std::vector<std::uint8_t> pores_in(const Box& box) const {
    std::vector<std::uint8_t> pores(static_cast<std::size_t>(box.size().voxel_count()));
    fill_voxels(mask_.tree, box, pores.data());
    for (std::uint8_t& voxel : pores) voxel = voxel == 0 ? 1 : 0;
    if (!region_) return pores;
    std::vector<std::uint8_t> plane(static_cast<std::size_t>(box.size().x * box.size().y));
    std::uint8_t* at = pores.data();
    for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
      fill_voxels(*region_, {{box.lo.x, box.lo.y, z}, {box.hi.x, box.hi.y, z + 1}}, plane.data());
      for (const std::uint8_t voxel : plane) *at++ &= voxel;
    }
    return pores;
  }

  void measure_pores() {
    Box box = box_of(size_);
    if (region_) context_.on_threads([&] { box = mask_moments(*region_).box; });
    const Size3 size = box.size();
    const auto voxels = static_cast<std::uint64_t>(size.voxel_count());
    const std::uint64_t others = std::min(
        voxels, static_cast<std::uint64_t>(size_.voxel_count()) - mask_.tree.voxel_count());
    const std::uint64_t bytes = std::max(
        8 * voxels, options_.has_diffusion ? voxels + pore_diffusion_bytes(voxels, others) : 0);
    context_.require_memory(2 * mask_.tree.memory_bytes() + bytes, "ways through pores");
    const std::vector<std::uint8_t> pores = pores_in(box);
    result_.has_diffusion = options_.has_diffusion;
    const auto pore_count = static_cast<std::int64_t>(
        std::count(pores.begin(), pores.end(), std::uint8_t{1}));
    std::string without_ends;
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      result_.has_ends[a] = has_ends(box, axis);
      if (!result_.has_ends[a]) {
        without_ends += without_ends.empty() ? "" : ", ";
        without_ends += "xyz"[axis];
        continue;
      }
      const std::string along = std::string(" along ") + "xyz"[axis];
      if (options_.has_tortuosity) {
        const ProgressScope scope(context_.watcher(), "ways" + along, pore_count, "voxels");
        result_.paths[a] = path_lengths(pores, size, spacing_, axis, context_.watcher());
      }
      if (options_.has_diffusion) {
        const auto counted = static_cast<double>(result_.region_voxels);
        watched(("diffusion" + along).c_str(), kDiffusionParts, "parts", [&] {
          result_.diffusions[a] =
              pore_diffusion(pores, size, spacing_, axis, counted, context_.watcher());
        });
        warn_if_unrestful(result_.diffusions[a], along);
      }
    }
    if (without_ends.empty()) return;
    context_.warn(options_.region + ": has less than two thirds of its mean cross-section at an " +
                  "end along " + without_ends + ": pores are not measured along there");
  }

  void warn_if_unrestful(const std::optional<PoreDiffusion>& found,
                         const std::string& along) const {
    if (!found || found->error <= kDiffusionError) return;
    context_.warn(mask_.path + ": diffusion" + along + " did not come to rest in " +
                  std::to_string(found->steps) + " steps: its diffusivity is known to " +
                  number_text(100 * found->error) + " % of itself alone");
  }

  void measure_densities() {
    const ProgressScope scope(context_.watcher(), "densities", size_.z, "planes");
    FilePlanes planes(grey_, 0, context_.thread_count());
    const VolumeDescription& volume = planes.description();
    const auto count = static_cast<std::size_t>(size_.x * size_.y);
    std::vector<std::byte> bytes(count * static_cast<std::size_t>(bytes_per_voxel(volume.type)));
    std::vector<std::uint8_t> in_mask(count);
    std::vector<std::uint8_t> in_region(count, 1);
    DensitySums tissue;
    DensitySums total;
    std::vector<double> tissue_values;
    std::vector<double> total_values;
    for (std::int64_t z = 0; z < size_.z; ++z) {
      planes.read_plane(bytes);
      const Box box = {{0, 0, z}, {size_.x, size_.y, z + 1}};
      fill_voxels(mask_.tree, box, in_mask.data());
      if (region_) fill_voxels(*region_, box, in_region.data());
      tissue_values.clear();
      total_values.clear();
      with_voxel_type(volume.type, [&](auto id) {
        using T = typename decltype(id)::type;
        for (std::size_t i = 0; i < count; ++i) {
          if (in_region[i] == 0) continue;
          T stored;
          std::memcpy(&stored, bytes.data() + i * sizeof stored, sizeof stored);
          const double real = volume.rescale.to_real(static_cast<double>(stored));
          if (!std::isfinite(real)) continue;
          const double value = options_.calibration.to_real(real);
          total_values.push_back(value);
          if (in_mask[i] != 0) tissue_values.push_back(value);
        }
      });
      total.add(total_values);
      tissue.add(tissue_values);
      context_.stop_if_cancelled();
      context_.watcher().advance(1);
    }
    result_.tissue = tissue.finished();
    result_.total = total.finished();
    const std::uint64_t counted = result_.total->voxels;
    if (counted == result_.region_voxels) return;
    context_.warn(options_.grey + ": " + std::to_string(result_.region_voxels - counted) + " of " +
                  std::to_string(result_.region_voxels) +
                  " voxels are not finite and left out of the densities");
  }

  const MorphometryOptions& options_;
  const TaskContext& context_;
  OpenedMask mask_;
  std::optional<MaskTree> region_;
  std::optional<MaskTree> inside_;  // of the mask, what lies in the region
  std::shared_ptr<const FileReader> grey_;
  Size3 size_;
  Point3 spacing_;
  Point3 thickness_spacing_;
  MorphometryResult result_;
};

}  // namespace

MorphometryResult morphometry(const MorphometryOptions& options, const TaskContext& context) {
  require_apart({options.thickness_map.path, options.spacing_map.path, options.histogram.path});
  for (const Output* map : {&options.thickness_map, &options.spacing_map}) {
    if (map->path.empty()) continue;
    require_computed(*map, {options.input, options.region, options.grey});
  }
  const Output& histogram = options.histogram;
  if (!histogram.path.empty()) {
    require_png(histogram.path);
    require_free(histogram);
    require_no_input(histogram.path, {options.input, options.region, options.grey});
  }
  MorphometryResult result = MorphometryWork(options, context).take();
  if (!histogram.path.empty()) {
    PictureFiles pictures(context);
    pictures.add(histogram.path,
                 thickness_picture(result.thickness.value_or(ThicknessSummary{}),
                                   result.spacing.value_or(ThicknessSummary{})));
    pictures.publish(histogram.overwrite);
  }
  return result;
}

}  // namespace octavo
