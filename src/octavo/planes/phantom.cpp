#include "octavo/planes/phantom.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/levels.h"
#include "octavo/core/text.h"
#include "octavo/planes/plane_cursor.h"

namespace octavo {

namespace {

constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15u;

std::uint64_t mix(std::uint64_t v) noexcept {
  v = (v ^ v >> 30) * 0xbf58476d1ce4e5b9u;
  v = (v ^ v >> 27) * 0x94d049bb133111ebu;
  return v ^ v >> 31;
}

// Twelve uniform numbers from three hashes, four in each; their mean is 32767.5 and the variance of
// their sum is 65536^2 (to 2^-32).
double unit_noise(std::uint64_t key, std::uint64_t counter) noexcept {
  constexpr std::uint64_t kEvenLanes = 0x0000ffff0000ffffu;
  std::uint64_t lanes = 0;
  for (std::uint64_t i = 0; i < 3; ++i) {
    const std::uint64_t hash = mix(key + (3 * counter + i) * kGolden);
    lanes += (hash & kEvenLanes) + (hash >> 16 & kEvenLanes);
  }
  const auto sum = static_cast<std::int32_t>((lanes & 0xffffffffu) + (lanes >> 32));
  return (sum - 12 * 32767.5) * (1.0 / 65536);
}

std::uint64_t counter_of(const Index3& voxel) noexcept {
  return static_cast<std::uint64_t>(voxel.z) << 42 | static_cast<std::uint64_t>(voxel.y) << 21 |
         static_cast<std::uint64_t>(voxel.x);
}

Metadata metadata_of(const PhantomOptions& o) {
  const std::pair<const char*, double> numbers[] = {{"outer_radius", o.outer_radius},
                                                    {"inner_radius", o.inner_radius},
                                                    {"background", o.background},
                                                    {"shell", o.shell},
                                                    {"inside", o.inside},
                                                    {"first_cylinder", o.first_cylinder},
                                                    {"second_cylinder", o.second_cylinder},
                                                    {"noise_sigma", o.noise_sigma}};
  MetadataFacts facts;
  facts.source.emplace().format = "phantom";
  JsonObject& settings = facts.source->settings;
  for (const auto& [name, value] : numbers) settings.set_json(name, exact_text(value));
  // As text: JSON readers keep 53 bits of a number.
  settings.set("seed", std::to_string(o.seed));
  facts.spacing_known = true;
  return Metadata::of(facts);
}

void require(bool condition, const std::string& what) {
  if (!condition) throw Error(ErrorKind::invalid_argument, "phantom: " + what);
}

void check(const PhantomOptions& o) {
  checked_voxel_count(o.size);
  std::string types;
  for (const VoxelType type : phantom_types()) {
    types += (types.empty() ? "" : ", ") + std::string(voxel_type_name(type));
  }
  require(std::ranges::find(phantom_types(), o.type) != phantom_types().end(),
          "voxel type " + std::string(voxel_type_name(o.type)) + "; use one of " + types);
  for (const double spacing : o.spacing_mm) {
    require(std::isfinite(spacing) && spacing > 0,
            "spacing " + exact_text(spacing) + "; it must be above 0");
  }
  require(o.inner_radius >= 0 && o.inner_radius < o.outer_radius && o.outer_radius <= 1,
          "radii " + exact_text(o.inner_radius) + " and " + exact_text(o.outer_radius) +
              "; 0 <= inner < outer <= 1 must hold");
  require(o.noise_sigma >= 0 && o.noise_sigma <= 1e6,
          "noise sigma " + exact_text(o.noise_sigma) + "; it must be between 0 and 1e6");
  for (const double density :
       {o.background, o.shell, o.inside, o.first_cylinder, o.second_cylinder}) {
    require(std::abs(density) <= 1e6,
            "density " + exact_text(density) + "; it must be within 1e6 of 0");
  }
}

double square(double v) { return v * v; }

// A cylinder along z through (x, across), or along y with `across` on the z axis; mm from the
// center.
struct Cylinder {
  double x, across;
  double radius, half_length;
};

class Phantom final : public PlaneSource {
 public:
  explicit Phantom(const PhantomOptions& options);

  const VolumeDescription& description() const override { return description_; }
  const std::vector<Warning>& warnings() const override { return warnings_; }
  void read_plane(std::span<std::byte> plane) override;
  void seek(std::int64_t first, std::int64_t end) override { cursor_.seek(first, end); }

 private:
  double centered(int axis, std::int64_t index) const;
  void fill_densities(std::int64_t y, std::int64_t z);
  template <class T>
  void write_row(std::int64_t y, std::int64_t z, T* row) const;

  PhantomOptions options_;
  VolumeDescription description_;
  std::vector<Warning> warnings_;
  double outer_ = 0;
  double inner_ = 0;
  Cylinder first_{};
  Cylinder second_{};
  std::vector<double> x_mm_;       // of every voxel of a row, from the center
  std::vector<double> densities_;  // of the row at hand
  PlaneCursor cursor_;
};

Phantom::Phantom(const PhantomOptions& options) : options_(options), cursor_(options.size.z) {
  check(options);
  description_.type = options.type;
  description_.size = options.size;
  description_.geometry.spacing_mm = options.spacing_mm;
  description_.metadata = metadata_of(options);
  double half = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double spacing = options.spacing_mm[static_cast<std::size_t>(axis)];
    half = std::min(half, static_cast<double>(options.size[axis]) * spacing / 2);
  }
  outer_ = options.outer_radius * half;
  inner_ = options.inner_radius * half;
  first_ = {-0.4 * inner_, -0.15 * inner_, 0.22 * inner_, 0.45 * inner_};
  second_ = {0.4 * inner_, 0, 0.16 * inner_, 0.5 * inner_};
  for (std::int64_t x = 0; x < options.size.x; ++x) x_mm_.push_back(centered(0, x));
  densities_.resize(x_mm_.size());
}

void Phantom::read_plane(std::span<std::byte> plane) {
  const Size3& size = options_.size;
  const std::int64_t row_bytes = size.x * bytes_per_voxel(options_.type);
  if (cursor_.is_done() || plane.size() != static_cast<std::size_t>(row_bytes * size.y)) {
    throw Error(ErrorKind::invalid_argument, "phantom: plane " + std::to_string(cursor_.next()) +
                                                 " of " + std::to_string(size.z) +
                                                 " asked for with " +
                                                 std::to_string(plane.size()) + " bytes");
  }
  const std::int64_t z = cursor_.take();
  for (std::int64_t y = 0; y < size.y; ++y) {
    fill_densities(y, z);
    with_voxel_type(options_.type, [&](auto id) {
      using T = typename decltype(id)::type;
      if constexpr (sizeof(T) <= 2) {
        write_row(y, z, reinterpret_cast<T*>(plane.data() + y * row_bytes));
      }
    });
  }
}

// The position of a voxel's center, mm from the center of the volume.
double Phantom::centered(int axis, std::int64_t index) const {
  return static_cast<double>(2 * index + 1 - options_.size[axis]) / 2 *
         options_.spacing_mm[static_cast<std::size_t>(axis)];
}

void Phantom::fill_densities(std::int64_t y, std::int64_t z) {
  const double y_mm = centered(1, y);
  const double z_mm = centered(2, z);
  const double outside_plane = square(y_mm) + square(z_mm);
  const double outer = square(outer_) - outside_plane;
  const double inner = square(inner_) - outside_plane;
  // Cylinder 1 is a run of x in the planes it crosses, cylinder 2 in the rows.
  const bool crosses_first = std::abs(z_mm) <= first_.half_length;
  const bool crosses_second = std::abs(y_mm) <= second_.half_length;
  const double first = crosses_first ? square(first_.radius) - square(y_mm - first_.across) : -1;
  const double second =
      crosses_second ? square(second_.radius) - square(z_mm - second_.across) : -1;
  for (std::size_t x = 0; x < x_mm_.size(); ++x) {
    const double from_center = square(x_mm_[x]);
    double density = options_.background;
    density = from_center <= outer ? options_.shell : density;
    density = from_center <= inner ? options_.inside : density;
    density = square(x_mm_[x] - first_.x) <= first ? options_.first_cylinder : density;
    density = square(x_mm_[x] - second_.x) <= second ? options_.second_cylinder : density;
    densities_[x] = density;
  }
}

template <class T>
void Phantom::write_row(std::int64_t y, std::int64_t z, T* row) const {
  constexpr double kMin = std::numeric_limits<T>::min();
  constexpr double kMax = std::numeric_limits<T>::max();
  const std::uint64_t key = mix(options_.seed + kGolden);
  const std::uint64_t counter = counter_of({0, y, z});
  const double sigma = options_.noise_sigma;
  for (std::size_t x = 0; x < densities_.size(); ++x) {
    const double noise = sigma > 0 ? sigma * unit_noise(key, counter + x) : 0;
    const double value = std::clamp(densities_[x] + noise, kMin, kMax);
    row[x] = static_cast<T>(static_cast<std::int32_t>(value + (value < 0 ? -0.5 : 0.5)));
  }
}

}  // namespace

std::span<const VoxelType> phantom_types() {
  static constexpr VoxelType kTypes[] = {VoxelType::int8, VoxelType::uint8, VoxelType::int16,
                                         VoxelType::uint16};
  return kTypes;
}

PhantomOptions phantom_options_for(VoxelType type) {
  PhantomOptions o;
  o.type = type;
  double* const densities[] = {&o.background, &o.shell, &o.inside, &o.first_cylinder,
                               &o.second_cylinder};
  if (type == VoxelType::uint16) {
    for (double* density : densities) *density += 1024;
  } else if (bytes_per_voxel(type) == 1) {
    const double of_bytes[] = {20, 200, 100, 150, 60};
    for (int i = 0; i < 5; ++i)
      *densities[i] = type == VoxelType::int8 ? of_bytes[i] / 2 : of_bytes[i];
  }
  return o;
}

std::unique_ptr<PlaneSource> make_phantom(const PhantomOptions& options) {
  return std::make_unique<Phantom>(options);
}

double phantom_noise(std::uint64_t seed, const Index3& voxel) noexcept {
  return unit_noise(mix(seed + kGolden), counter_of(voxel));
}

}  // namespace octavo
