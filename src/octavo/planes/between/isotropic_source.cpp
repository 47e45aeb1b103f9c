#include "octavo/planes/between/isotropic_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/levels.h"
#include "octavo/core/text.h"
#include "octavo/core/unset_bytes.h"
#include "octavo/planes/between/plane_mixing.h"
#include "octavo/planes/between/shape_between.h"
#include "octavo/planes/plane_cursor.h"

namespace octavo {

namespace {

/// Lengths that agree so well are one length.
constexpr double kTolerance = 1e-3;
constexpr double kMostSteps = 256;
constexpr std::size_t kMostListedRuns = 1000;  // of planes, in the metadata

std::string count_text(std::int64_t count, const char* noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

std::string spacing_text(const Point3& mm) {
  return precise_text(mm[0]) + " x " + precise_text(mm[1]) + " x " + precise_text(mm[2]) + " mm";
}

/// Where a plane lies: between slice `below` and the next one; 0 of the way is the slice itself.
struct PlanePlace {
  std::int64_t below = 0;
  WayUp way;
};

PlanePlace place_of(const IsotropicPlan& plan, std::int64_t z) {
  if (plan.steps > 0) {
    return {z / plan.steps,
            {static_cast<double>(z % plan.steps), static_cast<double>(plan.steps)}};
  }
  const double height = static_cast<double>(z) * plan.plane_mm / plan.slice_mm;
  const auto last = static_cast<double>(plan.slices - 1);
  if (height >= last) return {plan.slices - 1, {0, 1}};
  const double nearest = std::round(height);
  if (std::abs(height - nearest) <= kTolerance) return {static_cast<std::int64_t>(nearest), {0, 1}};
  const double below = std::floor(height);
  return {static_cast<std::int64_t>(below), {height - below, 1}};
}

/// The slices that plane z is made of.
PlaneRun slices_of(const IsotropicPlan& plan, std::int64_t z) {
  const PlanePlace place = place_of(plan, z);
  if (place.way.part == 0) return {place.below, place.below};
  if (plan.method != PlaneInterpolation::cubic) return {place.below, place.below + 1};
  return {std::max<std::int64_t>(place.below - 1, 0),
          std::min(place.below + 2, plan.slices - 1)};
}

/// The slices that planes first .. end are made of, up to the last of all where the last plane is
/// among them; an empty run for no planes.
PlaneRun slices_of(const IsotropicPlan& plan, std::int64_t first, std::int64_t end) {
  if (first == end) return {0, -1};
  PlaneRun slices = slices_of(plan, first);
  // A plane at a slice takes part in none of its neighbors, which the plane beside it may.
  for (const std::int64_t z : {first + 1, end - 2, end - 1}) {
    if (z < first || z >= end) continue;
    const PlaneRun of_plane = slices_of(plan, z);
    slices = {std::min(slices[0], of_plane[0]), std::max(slices[1], of_plane[1])};
  }
  if (end == plan.planes) slices[1] = plan.slices - 1;
  return slices;
}

/// The files of the planes, of those of the slices.
PlaneFiles files_between(const PlaneFiles& slices, const IsotropicPlan& plan) {
  PlaneFiles files = {slices.paths, {}, {}};
  if (slices.of_plane.empty()) return files;
  for (std::int64_t z = 0; z < plan.planes; ++z) {
    const PlaneRun run = slices_of(plan, z);
    files.of_plane.push_back(files_of_planes(slices, run[0], run[1] + 1));
  }
  return files;
}

/// Runs that the metadata tell of, where they rise and lie within the slices.
std::optional<std::vector<PlaneRun>> proven(const std::optional<std::vector<PlaneRun>>& runs,
                                            std::int64_t slices) {
  std::int64_t lowest = 0;
  for (const auto& [first, last] : runs.value_or(std::vector<PlaneRun>())) {
    if (first < lowest || last < first || last >= slices) return std::nullopt;
    lowest = last + 1;
  }
  return runs;
}

/// The planes that are made of one of these slices, wholly or in part.
std::vector<PlaneRun> planes_made_of(const IsotropicPlan& plan,
                                     const std::vector<PlaneRun>& slices) {
  std::vector<PlaneRun> planes;
  for (std::int64_t z = 0; z < plan.planes; ++z) {
    const PlaneRun used = slices_of(plan, z);
    const auto run = std::lower_bound(
        slices.begin(), slices.end(), used[0],
        [](const PlaneRun& some, std::int64_t slice) { return some[1] < slice; });
    if (run == slices.end() || (*run)[0] > used[1]) continue;
    if (!planes.empty() && planes.back()[1] == z - 1) {
      planes.back()[1] = z;
    } else {
      planes.push_back({z, z});
    }
  }
  return planes;
}

/// Where the metadata tell of slices that no source has, the planes that are made of them. What
/// cannot be said so is left out.
std::optional<std::vector<PlaneRun>> made_planes_of(const IsotropicPlan& plan,
                                                    const MetadataFacts& facts) {
  if (!facts.prepared || !facts.prepared->gaps) return std::nullopt;
  const auto made = proven(facts.prepared->gaps->made_planes, plan.slices);
  if (!made) return std::nullopt;
  std::vector<PlaneRun> planes = planes_made_of(plan, *made);
  return planes.size() <= kMostListedRuns ? std::optional(std::move(planes)) : std::nullopt;
}

/// The planes made of slices that an interrupted build lacked, from the first to the last.
std::optional<PlaneRun> missing_planes_of(const IsotropicPlan& plan, const MetadataFacts& facts) {
  if (!facts.repaired || !facts.repaired->missing_planes) return std::nullopt;
  const auto missing =
      proven(std::vector<PlaneRun>{*facts.repaired->missing_planes}, plan.slices);
  const auto planes = missing ? planes_made_of(plan, *missing) : std::vector<PlaneRun>{};
  if (planes.empty()) return std::nullopt;
  return PlaneRun{planes.front()[0], planes.back()[1]};
}

/// Weights of the slices below - 1 to below + 2. With `part` and `whole` whole numbers all are.
struct CubicWeights {
  std::array<double, 4> weights{};
  double divisor = 1;
};

/// is_first, is_last  there is no slice below - 1, below + 2: the line through the other two of
/// that end takes its place
CubicWeights cubic_weights(const WayUp& way, bool is_first, bool is_last) {
  const double t = way.part;
  const double n = way.whole;
  CubicWeights cubic;
  cubic.weights = {-t * t * t + 2 * t * t * n - t * n * n,
                   3 * t * t * t - 5 * t * t * n + 2 * n * n * n,
                   -3 * t * t * t + 4 * t * t * n + t * n * n,
                   t * t * t - t * t * n};
  cubic.divisor = 2 * n * n * n;
  auto& [before, below, above, behind] = cubic.weights;
  if (is_first) {
    below += 2 * before;
    above -= before;
    before = 0;
  }
  if (is_last) {
    above += 2 * behind;
    below -= behind;
    behind = 0;
  }
  return cubic;
}

class IsotropicSource final : public PlaneSource {
 public:
  IsotropicSource(std::unique_ptr<PlaneSource> source, const IsotropicPlan& plan)
      : source_(std::move(source)),
        plan_(plan),
        description_(source_->description()),
        cursor_(plan.planes) {
    slice_bytes_ = plane_bytes(description_);
    if (plan_.method == PlaneInterpolation::shape) {
      shapes_ = make_shape_between(description_.size.x, description_.size.y, description_.type);
    }
    description_.size.z = plan_.planes;
    description_.geometry.spacing_mm[2] = plan_.plane_mm;
    const MetadataFacts& facts = source_->description().metadata.facts();
    files_ = files_between(source_->files(), plan_);
    description_.metadata.set_isotropic(note(), made_planes_of(plan_, facts),
                                        missing_planes_of(plan_, facts));
  }

  const VolumeDescription& description() const override { return description_; }
  const std::vector<Warning>& warnings() const override { return source_->warnings(); }
  const PlaneFiles& files() const override { return files_; }

  std::uint64_t resident_bytes() const override {
    const Size3& size = description_.size;
    const std::uint64_t shapes =
        shapes_ ? ShapeBetween::memory_bytes(size.x, size.y, description_.type) : 0;
    return source_->resident_bytes() + held_slices() * slice_bytes_ + shapes;
  }

  void read_plane(std::span<std::byte> plane) override {
    if (plane.size() != slice_bytes_) {
      throw Error(ErrorKind::invalid_argument, "a buffer of another size than that of a plane");
    }
    const std::int64_t z = cursor_.take();
    const PlanePlace place = place_of(plan_, z);
    if (place.way.part == 0) {
      hold(place.below, place.below);
      copy(slice(place.below), plane);
    } else if (shapes_) {
      make_shapes(z, place, plane);
    } else {
      mix(place, plane);
    }
    // What comes late is reported by the source itself: a stream is proven at its end.
    if (cursor_.is_behind_last()) read_until(plan_.slices - 1);
  }

  bool can_seek() const override { return source_->can_seek(); }

  void seek(std::int64_t first, std::int64_t end) override {
    cursor_.seek(first, end);
    const PlaneRun slices = slices_of(plan_, first, end);
    read_ = slices[0];
    source_->seek(slices[0], slices[1] + 1);
    held_.clear();
    pair_below_ = -1;
    decided_ = 0;
  }

 private:
  std::size_t held_slices() const {
    return plan_.method == PlaneInterpolation::cubic ? 4 : 2;
  }

  IsotropicNote note() const {
    IsotropicNote note;
    note.method = interpolation_name(plan_.method);
    note.slices = plan_.slices;
    note.slice_mm = plan_.slice_mm;
    note.step_mm = plan_.plane_mm;
    note.made_plane_count = plan_.made_planes;
    if (plan_.left_out_mm > 0) note.left_out_mm = plan_.left_out_mm;
    return note;
  }

  // --- Slices of the source, the last few of those read

  void read_until(std::int64_t index) {
    while (read_ <= index) {
      UnsetBytes voxels;
      if (held_.size() == held_slices()) {
        voxels = std::move(held_.front());
        held_.pop_front();
      }
      voxels.resize(static_cast<std::size_t>(slice_bytes_));
      source_->read_plane(voxels.bytes());
      held_.push_back(std::move(voxels));
      ++read_;
    }
  }

  /// Requires that `first` was not dropped: last - first < held_slices(), and never back.
  void hold(std::int64_t first, std::int64_t last) {
    read_until(last);
    if (first < read_ - static_cast<std::int64_t>(held_.size())) {
      throw Error(ErrorKind::internal, "a slice was dropped before its planes were made");
    }
  }

  std::span<const std::byte> slice(std::int64_t index) const {
    const auto held = static_cast<std::int64_t>(held_.size());
    return held_[static_cast<std::size_t>(index + held - read_)].bytes();
  }

  static void copy(std::span<const std::byte> from, std::span<std::byte> to) {
    std::memcpy(to.data(), from.data(), to.size());
  }

  // --- Grey

  void mix(const PlanePlace& place, std::span<std::byte> plane) {
    PlaneWeights mix;
    if (plan_.method == PlaneInterpolation::linear) {
      hold(place.below, place.below + 1);
      mix.planes = {slice(place.below), slice(place.below + 1)};
      mix.weights = {place.way.whole - place.way.part, place.way.part};
      mix.divisor = place.way.whole;
    } else {
      const bool is_first = place.below == 0;
      const bool is_last = place.below + 2 == plan_.slices;
      hold(place.below - (is_first ? 0 : 1), place.below + (is_last ? 1 : 2));
      const CubicWeights cubic = cubic_weights(place.way, is_first, is_last);
      mix.weights = cubic.weights;
      mix.divisor = cubic.divisor;
      for (std::size_t i = 0; i < mix.planes.size(); ++i) {
        const bool is_there = (i > 0 || !is_first) && (i < 3 || !is_last);
        if (is_there) mix.planes[i] = slice(place.below + static_cast<std::int64_t>(i) - 1);
      }
    }
    mix_planes(description_.type, mix, {.padding = description_.padding}, plane);
  }

  // --- Labels

  void make_shapes(std::int64_t z, const PlanePlace& place, std::span<std::byte> plane) {
    if (decided_ == 0 || z >= decided_from_ + decided_) decide_from(z, place);
    shapes_->fill(static_cast<std::size_t>(z - decided_from_), plane);
  }

  /// Decides plane z and those after it between the same slices.
  void decide_from(std::int64_t z, const PlanePlace& place) {
    if (pair_below_ != place.below) {
      hold(place.below, place.below + 1);
      shapes_->set_pair(slice(place.below), slice(place.below + 1));
      pair_below_ = place.below;
    }
    std::vector<WayUp> ways;
    const auto most = static_cast<std::int64_t>(shapes_->max_ways());
    for (std::int64_t next = z; next < plan_.planes && next < z + most; ++next) {
      const PlanePlace there = place_of(plan_, next);
      if (there.below != place.below) break;
      ways.push_back(there.way);
    }
    shapes_->decide(ways);
    decided_from_ = z;
    decided_ = static_cast<std::int64_t>(ways.size());
  }

  std::unique_ptr<PlaneSource> source_;
  IsotropicPlan plan_;
  VolumeDescription description_;
  PlaneFiles files_;
  std::uint64_t slice_bytes_ = 0;
  std::deque<UnsetBytes> held_;
  std::int64_t read_ = 0;  ///< the slice that the source gives next
  PlaneCursor cursor_;
  std::unique_ptr<ShapeBetween> shapes_;
  std::int64_t pair_below_ = -1;
  std::int64_t decided_from_ = 0;
  std::int64_t decided_ = 0;
};

/// Rejects what cannot be made of cubes by planes alone.
void require_square_pixels(const Geometry& geometry) {
  const auto& [x, y, z] = geometry.spacing_mm;
  if (std::abs(x - y) <= kTolerance * std::min(x, y)) return;
  throw Error(ErrorKind::source_rejected,
              "its pixels are not square (voxels of " + spacing_text(geometry.spacing_mm) +
                  "): planes in between are made along z, which changes nothing within a plane; "
                  "resample it in the program it comes from, or build it as it is");
}

void report(IsotropicPlan& plan) {
  const char* how = plan.method == PlaneInterpolation::shape ? " by the shapes of the labels"
                    : plan.method == PlaneInterpolation::cubic ? ", cubic"
                                                               : ", linear";
  plan.notice = "isotropic: " + count_text(plan.slices, "slice") + " " +
                precise_text(plan.slice_mm) + " mm apart become " +
                count_text(plan.planes, "plane") + " " + precise_text(plan.plane_mm) +
                " mm apart; " + std::to_string(plan.made_planes) + " of them interpolated" + how;
  if (plan.left_out_mm > 0) {
    plan.notice += "; the last " + precise_text(plan.left_out_mm) +
                   " mm, less than a plane distance, hold no plane";
  }
}

}  // namespace

const char* interpolation_name(PlaneInterpolation method) {
  switch (method) {
    case PlaneInterpolation::linear: return "linear";
    case PlaneInterpolation::cubic: return "cubic";
    case PlaneInterpolation::shape: return "shape";
  }
  return "";
}

IsotropicPlan plan_isotropic(const VolumeDescription& description, PlaneInterpolation method) {
  if (!description.metadata.is_spacing_known()) {
    throw Error(ErrorKind::invalid_argument,
                "isotropic voxels are made by their distances, and the source gives none")
        .with_field("spacing_mm");
  }
  if (method == PlaneInterpolation::shape && !is_integer(description.type)) {
    throw Error(ErrorKind::invalid_argument, "labels are integers; these voxels are float32");
  }
  // What needs no planes in between
  const Point3& spacing_mm = description.geometry.spacing_mm;
  IsotropicPlan plan;
  plan.method = method;
  plan.slices = plan.planes = description.size.z;
  plan.slice_mm = plan.plane_mm = spacing_mm[2];
  const double pixel_mm = std::min(spacing_mm[0], spacing_mm[1]);
  const double ratio = plan.slice_mm / pixel_mm;
  if (plan.slices < 2) {
    plan.notice = "isotropic: a single slice has no planes in between; nothing done";
    return plan;
  }
  require_square_pixels(description.geometry);
  if (std::abs(ratio - 1) <= kTolerance) {
    plan.notice = "isotropic: the voxels are cubes already; nothing done";
    return plan;
  }
  if (ratio < 1) {
    plan.notice = "isotropic: the slices lie closer than the pixels (voxels of " +
                  spacing_text(spacing_mm) + "): no planes to make in between; nothing done";
    return plan;
  }
  if (ratio > kMostSteps) {
    throw Error(ErrorKind::source_rejected,
                "its slices lie " + precise_text(ratio) + " pixels apart (voxels of " +
                    spacing_text(spacing_mm) +
                    "): at most 256 planes are made of one slice; check the spacing")
        .with_field("spacing_mm");
  }
  // A whole number of planes between slices, or planes at the distance of the pixels
  plan.is_needed = true;
  const double whole = std::round(ratio);
  const double top = static_cast<double>(plan.slices - 1);
  if (std::abs(ratio - whole) <= kTolerance * ratio) {
    plan.steps = static_cast<std::int64_t>(whole);
    plan.plane_mm = plan.slice_mm / whole;
    plan.planes = (plan.slices - 1) * plan.steps + 1;
    plan.made_planes = plan.planes - plan.slices;
  } else {
    plan.plane_mm = pixel_mm;
    plan.planes = static_cast<std::int64_t>(std::floor((top + kTolerance) * ratio)) + 1;
    const double rest = top - static_cast<double>(plan.planes - 1) / ratio;
    if (rest > kTolerance) plan.left_out_mm = rest * plan.slice_mm;
    for (std::int64_t z = 0; z < plan.planes; ++z) {
      if (place_of(plan, z).way.part != 0) ++plan.made_planes;
    }
  }
  checked_voxel_count({description.size.x, description.size.y, plan.planes});
  report(plan);
  return plan;
}

std::unique_ptr<PlaneSource> make_isotropic_source(std::unique_ptr<PlaneSource> source,
                                                   const IsotropicPlan& plan) {
  return std::make_unique<IsotropicSource>(std::move(source), plan);
}

}  // namespace octavo
