// Pictures of a mask a second: its cubes, and its surface alone.
//
// usage: bench_frames [--commit ID] [--rounds N] [--threads N] VOLUME...
//
// VOLUME  NAME=PATH,LOWEST: a grey .8vo file, the mask is what is not below LOWEST (real units)
//
// 1024 x 1024 pixels from five sides, the octree in memory, the picture not written. One row for
// each display and side: "cubes front" draws all leaves over each other, "surface front" the leaves
// of the shell, the nearest first; both must give the same pixels. "shell" is made once per mask.
// Column bytes: those of the octree that is drawn.

#include <tbb/global_control.h>

#include <iostream>

#include "bench/common/measure.h"
#include "bench/common/settings.h"
#include "octavo/core/error.h"
#include "octavo/file/reader.h"
#include "octavo/file/storage/storage.h"
#include "octavo/ops/mask/file_mask.h"
#include "octavo/ops/mask/shell.h"
#include "octavo/render/cubes/cube_picture.h"

namespace octavo::bench {
namespace {

constexpr std::int64_t kPictureSide = 1024;

struct Side {
  const char* name;
  Viewpoint viewpoint;
};

std::vector<Side> sides(const Geometry& geometry) {
  return {{"front", *find_viewpoint("front")},
          {"left", *find_viewpoint("left")},
          {"top", *find_viewpoint("top")},
          {"corner", viewpoint_along(geometry, {1, 1, 1})},
          {"oblique", viewpoint_at(30, 20)}};
}

class FrameBench {
 public:
  FrameBench(const std::string& text, const Settings& settings) : settings_(settings) {
    const std::size_t equals = text.find('=');
    const std::size_t comma = text.rfind(',');
    if (equals == std::string::npos || comma == std::string::npos || comma < equals) {
      throw Error(ErrorKind::invalid_argument, "expected NAME=PATH,LOWEST: " + text);
    }
    name_ = text.substr(0, equals);
    const std::string path = text.substr(equals + 1, comma - equals - 1);
    reader_ = FileReader::open(open_byte_source(local_storage(), path));
    const VolumeDescription& volume = reader_->description();
    const double lowest =
        (std::stod(text.substr(comma + 1)) - volume.rescale.intercept) / volume.rescale.slope;
    NoProgress silent;
    const ValueWindow window{lowest, 1e300};
    mask_ = mask_of_file(*reader_, 0, {&window, 1}, silent);
  }

  void run() {
    MaskTree surface;
    Row making = row("shell", mask_);
    for (int round = 0; round < settings_.rounds; ++round) {
      making.seconds.push_back(seconds_of([&] { surface = shell(mask_); }));
    }
    std::cout << csv_line(making, settings_.commit) << std::endl;
    const Geometry& geometry = reader_->description().geometry;
    for (const Side& side : sides(geometry)) draw_from(side, geometry, surface);
  }

 private:
  Row row(const std::string& operation, const MaskTree& drawn) const {
    Row row;
    row.threads = settings_.threads;
    row.data_set = name_;
    row.operation = operation;
    row.bytes = drawn.memory_bytes();
    row.voxel_count = static_cast<std::uint64_t>(mask_.size().voxel_count());
    row.raw_bytes =
        row.voxel_count * static_cast<std::uint64_t>(bytes_per_voxel(reader_->description().type));
    return row;
  }

  void draw_from(const Side& side, const Geometry& geometry, const MaskTree& surface) const {
    const Box shown = bounding_box(mask_);
    ViewFrame frame;
    frame.width = kPictureSide;
    frame.height = kPictureSide;
    const View view = make_view(geometry, mask_.size(), shown, side.viewpoint, frame);
    const CubeStyle style{{0, 0, 0}, 0.5, shown};
    constexpr Color kIvory = {244, 232, 206};
    const PaintedMask all{&mask_, kIvory};
    const PaintedMask outer{&surface, kIvory};
    Row cubes = row(std::string("cubes ") + side.name, mask_);
    Row nearest = row(std::string("surface ") + side.name, surface);
    Picture one;
    Picture other;
    for (int round = 0; round < settings_.rounds; ++round) {
      cubes.seconds.push_back(seconds_of([&] { one = draw_cubes({&all, 1}, view, style); }));
      nearest.seconds.push_back(seconds_of([&] {
        other = draw_nearest_cubes({&outer, 1}, view, style);
      }));
    }
    if (one.pixels != other.pixels) throw Error(ErrorKind::internal, "the pictures differ");
    std::cout << csv_line(cubes, settings_.commit) << std::endl;
    std::cout << csv_line(nearest, settings_.commit) << std::endl;
  }

  const Settings& settings_;
  std::string name_;
  std::shared_ptr<const FileReader> reader_;
  MaskTree mask_;
};

void run(int count, char** words) {
  Settings settings;
  const std::vector<std::string> volumes = take_settings(count, words, settings);
  if (volumes.empty()) {
    throw Error(ErrorKind::invalid_argument,
                "usage: bench_frames [--commit ID] [--rounds N] [--threads N] VOLUME...");
  }
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(settings.threads));
  std::cout << csv_header() << "\n";
  for (const std::string& text : volumes) FrameBench(text, settings).run();
}

}  // namespace
}  // namespace octavo::bench

int main(int count, char** words) {
  return octavo::bench::run_named("bench_frames", [=] { octavo::bench::run(count, words); });
}
