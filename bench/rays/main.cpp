// Pictures by rays of voxels in memory.
//
// usage: bench_rays [--rounds N] [--threads N] VOLUME SPACING TRANSFER MODE AZIMUTH ELEVATION
//
// VOLUME    "NAME PATH nx,ny,nz,type", a headerless file
// SPACING   mm, "x,y,z"
// TRANSFER  points of colors and opacities of a layer of 1 mm: "value,r,g,b,opacity;..."
// MODE      volume, moving (volume with gradients of single cells), mip, or an isovalue in stored
//           values
//
// 1024 x 1024 pixels, parallel rays, samples one finest spacing apart. Prints a line for each
// picture: CPU seconds of the process, samples, bricks in memory. The first one has all that a new
// volume needs in it. Bits of vectors and of plain C++ are compared before.

#include <tbb/global_control.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "bench/common/measure.h"
#include "bench/common/raw_volume.h"
#include "bench/common/settings.h"
#include "octavo/core/error.h"
#include "octavo/render/rays/dense_samples.h"
#include "octavo/render/rays/ray_camera.h"
#include "octavo/render/rays/ray_caster.h"
#include "octavo/render/rays/transfer_function.h"

namespace octavo::bench {
namespace {

constexpr std::int64_t kPixels = 1024;

std::vector<double> numbers_of(const std::string& text) {
  std::vector<double> numbers;
  std::istringstream in(text);
  for (std::string one; std::getline(in, one, ',');) numbers.push_back(std::stod(one));
  return numbers;
}

TransferFunction transfer_of(const std::string& text) {
  TransferFunction transfer;
  transfer.layer_mm = 1;
  std::istringstream in(text);
  for (std::string one; std::getline(in, one, ';');) {
    const std::vector<double> n = numbers_of(one);
    const auto channel = [&](std::size_t i) { return static_cast<std::uint8_t>(n.at(i)); };
    transfer.points.push_back({n.at(0), {channel(1), channel(2), channel(3)}, n.at(4)});
  }
  return transfer;
}

/// A volume with all that its pictures need.
class Scene {
 public:
  Scene(const RawVolume& raw, const std::vector<std::string>& words)
      : source_(raw.voxels.data(), raw.type, raw.size), bricks_(source_, {6, kBrickBytes}) {
    Geometry geometry;
    const std::vector<double> spacing = numbers_of(words[1]);
    std::copy_n(spacing.begin(), 3, geometry.spacing_mm.begin());
    const double step = *std::min_element(spacing.begin(), spacing.end());
    const View view = make_view(geometry, raw.size, box_of(raw.size),
                                viewpoint_at(std::stod(words[4]), std::stod(words[5])),
                                {kPixels, kPixels, 1, {}});
    frame_.bricks = bricks_.tables();
    set_camera(frame_, {view, box_of(raw.size), 0, step});
    table_ = std::make_unique<TransferTable>(transfer_of(words[2]), Rescale{}, bricks_.scale(),
                                             bricks_.range(), step);
    frame_.table = table_->table();
    if (words[3] == "mip") frame_.mode = RayMode::extreme;
    else if (words[3] == "moving") frame_.has_cell_gradients = true;
    else if (words[3] != "volume") frame_.mode = RayMode::iso;
    if (frame_.mode == RayMode::iso) {
      frame_.isovalue = static_cast<float>(bricks_.scale().pooled(std::stod(words[3])));
    }
    const auto bound_of = [this](float lowest, float highest) {
      if (frame_.mode == RayMode::extreme) return highest;
      const bool is_seen = frame_.mode == RayMode::iso ? highest >= frame_.isovalue
                                                       : table_->is_seen(lowest, highest);
      return is_seen ? 1.0f : 0.0f;
    };
    bricks_.set_bounds(BoundOf(bound_of), frame_.mode != RayMode::extreme);
  }

  RayField draw(FollowRays follow) {
    NoProgress silent;
    return cast_rays(bricks_, frame_, kPixels, kPixels, follow, silent);
  }
  std::int64_t loaded() const { return bricks_.loaded_count(); }

 private:
  static constexpr std::uint64_t kBrickBytes = std::uint64_t{2} << 30;

  DenseSamples source_;
  RayBricks bricks_;
  std::unique_ptr<TransferTable> table_;
  RayFrame frame_;
};

void compare_fields(const RayField& a, const RayField& b) {
  for (std::size_t i = 0; i < a.tiles.size(); ++i) {
    const RayTile& x = a.tiles[i];
    const RayTile& y = b.tiles[i];
    if (x.red == y.red && x.green == y.green && x.blue == y.blue && x.gathered == y.gathered) {
      continue;
    }
    throw Error(ErrorKind::internal, "vectors and plain C++ give different pictures");
  }
}

void run_rays(int count, char** words) {
  Settings settings;
  const std::vector<std::string> rest = take_settings(count, words, settings);
  if (rest.size() != 6) {
    throw Error(ErrorKind::invalid_argument,
                "usage: bench_rays [--rounds N] [--threads N] VOLUME SPACING TRANSFER MODE "
                "AZIMUTH ELEVATION");
  }
  const RawVolume raw = load_raw_volume(rest[0]);
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(settings.threads));
  {
    Scene scene(raw, rest);
    compare_fields(scene.draw(follow_rays_portable), scene.draw(follow_rays_function()));
  }
  double began = cpu_seconds();
  Scene scene(raw, rest);
  for (int round = 0; round < settings.rounds; ++round) {
    const RayField field = scene.draw(follow_rays_function());
    const double seconds = cpu_seconds() - began;
    std::printf("%.6f %lld %lld\n", seconds, static_cast<long long>(field.samples),
                static_cast<long long>(scene.loaded()));
    began = cpu_seconds();
  }
}

}  // namespace
}  // namespace octavo::bench

int main(int count, char** words) {
  return octavo::bench::run_named("bench_rays", [&] { octavo::bench::run_rays(count, words); });
}
