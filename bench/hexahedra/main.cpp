// Leaves of a mask balanced 2:1 and their corners numbered, beside p4est on the same leaves.
//
// usage: bench_hexahedra [--commit ID] [--rounds N] VOLUME...
//
// VOLUME  NAME=PATH,LOWEST: a grey .8vo file, the mask is what is not below LOWEST (real units)
//
// One thread each, taking turns; seconds are those of the processor. "octavo leaves": those of the
// tree, taken one by one; "octavo balance": these balanced; "octavo nodes": their corners, those
// that hang, and the corners of each. "p4est balance": the same leaves as a forest that is refined
// to them, balanced over faces, edges and corners (p8est_balance); "p4est nodes": its trilinear
// nodes (p8est_lnodes of degree 1, and the ghost layer that they need). The forest fills the whole
// cube, so that it has elements outside the mask as well: column bytes are the elements of each,
// and seconds are compared per element. Refining is in no time. p4est runs in
// bench_hexahedra_p4est beside this program.

#include <tbb/global_control.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "bench/common/measure.h"
#include "bench/common/settings.h"
#include "octavo/core/error.h"
#include "octavo/file/reader.h"
#include "octavo/file/storage/storage.h"
#include "octavo/mesh/hexahedra/hex_nodes.h"
#include "octavo/mesh/hexahedra/leaf_balance.h"
#include "octavo/ops/mask/file_mask.h"

namespace octavo::bench {
namespace {

constexpr const char* kPeer = "bench_hexahedra_p4est";

/// What bench_hexahedra_p4est prints: seconds of its two steps, and its elements.
struct PeerRun {
  double balance_s = 0;
  double nodes_s = 0;
  unsigned long long elements = 0;
};

PeerRun run_peer(const std::string& program, const std::string& leaves) {
  std::FILE* const pipe = ::popen((program + " " + leaves).c_str(), "r");
  PeerRun run;
  const bool is_read = pipe != nullptr && std::fscanf(pipe, "%lf %lf %llu", &run.balance_s,
                                                      &run.nodes_s, &run.elements) == 3;
  if (pipe == nullptr || ::pclose(pipe) != 0 || !is_read) {
    throw Error(ErrorKind::io, "the program of p4est fails", program);
  }
  return run;
}

double processor_seconds_of(const std::function<void()>& work) {
  const double began = cpu_seconds();
  work();
  return cpu_seconds() - began;
}

class HexahedraBench {
 public:
  HexahedraBench(const std::string& text, std::string peer, const Settings& settings)
      : settings_(settings), peer_(std::move(peer)) {
    const std::size_t equals = text.find('=');
    const std::size_t comma = text.rfind(',');
    if (equals == std::string::npos || comma == std::string::npos || comma < equals) {
      throw Error(ErrorKind::invalid_argument, "expected NAME=PATH,LOWEST: " + text);
    }
    name_ = text.substr(0, equals);
    const auto reader = FileReader::open(
        open_byte_source(local_storage(), text.substr(equals + 1, comma - equals - 1)));
    const Rescale& rescale = reader->description().rescale;
    const ValueWindow window{
        (std::stod(text.substr(comma + 1)) - rescale.intercept) / rescale.slope, 1e300};
    NoProgress silent;
    mask_ = mask_of_file(*reader, 0, {&window, 1}, silent);
  }

  void run() {
    const std::string leaves =
        (std::filesystem::temp_directory_path() / ("octavo-leaves-" + name_)).string();
    write_leaves(leaves);
    std::vector<Row> rows = {row("octavo leaves"), row("octavo balance"), row("octavo nodes"),
                             row("p4est balance"), row("p4est nodes")};
    for (int round = 0; round < settings_.rounds; ++round) {
      LeafBalance balance;
      std::vector<OCode> balanced;
      rows[0].seconds.push_back(processor_seconds_of([&] {
        for_each_leaf(mask_, [&](const OCode& leaf) { balance.add(leaf); });
      }));
      rows[1].seconds.push_back(processor_seconds_of([&] { balanced = balance.finish(); }));
      rows[2].seconds.push_back(processor_seconds_of([&] { number_own(balanced); }));
      const PeerRun peer = run_peer(peer_, leaves);
      rows[3].seconds.push_back(peer.balance_s);
      rows[4].seconds.push_back(peer.nodes_s);
      rows[0].bytes = rows[1].bytes = rows[2].bytes = balanced.size();
      rows[3].bytes = rows[4].bytes = peer.elements;
    }
    std::filesystem::remove(leaves);
    for (const Row& one : rows) std::cout << csv_line(one, settings_.commit) << std::endl;
  }

 private:
  Row row(const std::string& operation) const {
    Row row;
    row.data_set = name_;
    row.operation = operation;
    row.voxel_count = static_cast<std::uint64_t>(mask_.size().voxel_count());
    row.raw_bytes = row.voxel_count;
    return row;
  }

  static void number_own(const std::vector<OCode>& leaves) {
    std::vector<HexCell> cells;
    cells.reserve(leaves.size());
    for (const OCode& leaf : leaves) cells.push_back(cell_of(leaf));
    const HexNodes nodes(cells);
    HexNodes::Near near;
    std::uint64_t sum = 0;
    for (const HexCell& cell : cells) sum += nodes.corners_of(cell, near)[7];
    if (sum == 0) throw Error(ErrorKind::internal, "no corner has a number");
  }

  /// The root's level, then level and first voxel of each leaf.
  void write_leaves(const std::string& path) const {
    std::ofstream out(path);
    out << universe_level(mask_.size()) << "\n";
    for_each_leaf(mask_, [&](const OCode& leaf) {
      out << leaf.level << " " << (leaf.code << 3 * leaf.level) << "\n";
    });
    out.close();
    if (!out) throw Error(ErrorKind::io, "cannot be written", path);
  }

  const Settings& settings_;
  std::string peer_;
  std::string name_;
  MaskTree mask_;
};

void run(int count, char** words) {
  Settings settings;
  const std::vector<std::string> volumes = take_settings(count, words, settings);
  if (volumes.empty()) {
    throw Error(ErrorKind::invalid_argument,
                "usage: bench_hexahedra [--commit ID] [--rounds N] VOLUME...");
  }
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, 1);
  std::cout << csv_header() << "\n";
  const std::string peer = std::filesystem::path(words[0]).replace_filename(kPeer).string();
  for (const std::string& text : volumes) HexahedraBench(text, peer, settings).run();
}

}  // namespace
}  // namespace octavo::bench

int main(int count, char** words) {
  return octavo::bench::run_named("bench_hexahedra", [=] { octavo::bench::run(count, words); });
}
