// Surfaces between the labels of a volume: nets, triangles, and a part of each label.
//
// usage: bench_nets [--commit ID] [--rounds N] VOLUME...
//
// VOLUME  NAME=PATH: a .8vo file of labels
//
// One thread; seconds are those of the processor. Bricks are decoded before and kept, so that
// labels come out of memory, as they do for the peer (bench/net_peers). Rows: "net" quads,
// "surface" quads and triangles, "smoothed surface" 20 steps, volumes kept within 1 %, "parts" the
// surfaces of all labels cut out. Every part is proven closed and manifold before anything is
// timed. Memory that was freed is kept, as the peer keeps it: page faults of a new mesh take as
// long as the mesh. Column bytes: those of the triangles that are made.

#include <malloc.h>
#include <tbb/global_control.h>

#include <ctime>
#include <iostream>

#include "bench/common/measure.h"
#include "bench/common/settings.h"
#include "octavo/core/error.h"
#include "octavo/file/reader.h"
#include "octavo/file/storage/storage.h"
#include "octavo/mesh/mesh_check.h"
#include "octavo/mesh/nets/net_extraction.h"
#include "octavo/mesh/nets/smoothed_interfaces.h"

namespace octavo::bench {
namespace {

double processor_seconds_of(const std::function<void()>& work) {
  const std::clock_t start = std::clock();
  work();
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

class NetBench {
 public:
  NetBench(const std::string& text, const Settings& settings) : settings_(settings) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) {
      throw Error(ErrorKind::invalid_argument, "expected NAME=PATH: " + text);
    }
    name_ = text.substr(0, equals);
    ReaderOptions options;
    options.cache_bytes = std::uint64_t{4} << 30;
    reader_ = FileReader::open(open_byte_source(local_storage(), text.substr(equals + 1)), options);
  }

  void run() {
    const SurfaceFrame frame(reader_->description().geometry, reader_->levels().size(0));
    const SurfaceNet decoded = net();
    const InterfaceMesh flat = interface_mesh(decoded, {}, frame);
    require_sound(flat);

    Row nets = row("net", flat);
    Row surfaces = row("surface", flat);
    Row smooth = row("smoothed surface", flat);
    Row parts = row("parts", flat);
    for (int round = 0; round < settings_.rounds; ++round) {
      SurfaceNet made;
      nets.seconds.push_back(processor_seconds_of([&] { made = net(); }));
      surfaces.seconds.push_back(nets.seconds.back() + processor_seconds_of([&] {
                                   interface_mesh(made, {}, frame);
                                 }));
      smooth.seconds.push_back(nets.seconds.back() + processor_seconds_of([&] {
                                 smoothed_interfaces(made, frame, 20, 0.01);
                               }));
      parts.seconds.push_back(processor_seconds_of([&] {
        LabelParts cutter(flat);
        for (const std::int64_t label : cutter.labels()) cutter.cut(label);
      }));
    }
    for (const Row& made : {nets, surfaces, smooth, parts}) {
      std::cout << csv_line(made, settings_.commit) << std::endl;
    }
  }

 private:
  SurfaceNet net() const {
    NetCollector collector;
    NoProgress silent;
    extract_net(*reader_, 0, collector, silent);
    return collector.take();
  }

  static void require_sound(const InterfaceMesh& made) {
    LabelParts cutter(made);
    for (const std::int64_t label : cutter.labels()) {
      const MeshCheck check = check_mesh(cutter.cut(label));
      if (check.is_closed() && check.repeated_sides == 0 && check.pinched_points == 0) continue;
      throw Error(ErrorKind::internal, "label " + std::to_string(label) + " is not closed");
    }
  }

  Row row(const std::string& operation, const InterfaceMesh& made) const {
    Row row;
    row.threads = settings_.threads;
    row.data_set = name_;
    row.operation = operation;
    row.bytes = made.mesh.triangles.size() * sizeof(MeshTriangle);
    row.voxel_count = static_cast<std::uint64_t>(reader_->levels().size(0).voxel_count());
    row.raw_bytes =
        row.voxel_count * static_cast<std::uint64_t>(bytes_per_voxel(reader_->description().type));
    return row;
  }

  const Settings& settings_;
  std::string name_;
  std::shared_ptr<const FileReader> reader_;
};

void run(int count, char** words) {
  Settings settings;
  const std::vector<std::string> volumes = take_settings(count, words, settings);
  if (volumes.empty() || settings.threads != 1) {
    throw Error(ErrorKind::invalid_argument,
                "usage: bench_nets [--commit ID] [--rounds N] VOLUME...");
  }
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, 1);
  mallopt(M_MMAP_THRESHOLD, 1'000'000'000);
  mallopt(M_TRIM_THRESHOLD, 2'000'000'000);
  std::cout << csv_header() << "\n";
  for (const std::string& text : volumes) NetBench(text, settings).run();
}

}  // namespace
}  // namespace octavo::bench

int main(int count, char** words) {
  return octavo::bench::run_named("bench_nets", [=] { octavo::bench::run(count, words); });
}
