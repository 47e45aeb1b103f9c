// Masks beside OpenVDB and ITK: making them, set operations, components, moments, random voxels.
//
// usage: bench_masks [--commit ID] [--rounds N] [--threads N] [--growth] VOLUME...
//
// VOLUME    NAME=PATH,nx,ny,nz,LOWEST: a headerless file of int16, the mask is what is not below
//           LOWEST
// --growth  no peers: shells and a bundle of thin tubes in volumes of growing size
//
// The second mask of set operations is the first, moved by 10, 10, 5 voxels. Libraries take turns;
// all must give the same number of voxels, components and hits. Column bytes: those of the mask;
// peak memory is measured with one thread only, in a process of its own.

#include <itkMultiThreaderBase.h>
#include <malloc.h>
#include <sys/wait.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iostream>
#include <map>
#include <sstream>

#include "bench/common/measure.h"
#include "bench/common/settings.h"
#include "bench/masks/engine.h"
#include "octavo/core/error.h"

namespace octavo::bench {
namespace {

void require(bool ok, const std::string& what) {
  if (!ok) throw Error(ErrorKind::internal, "failed: " + what);
}

struct MaskSettings : Settings {
  bool is_growth = false;
  std::vector<std::string> volumes;
};

MaskVolume empty_volume(const std::string& name, const Size3& size, std::int16_t lowest) {
  return {name, size, std::vector<std::int16_t>(static_cast<std::size_t>(size.voxel_count())),
          lowest};
}

MaskVolume load_volume(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) throw Error(ErrorKind::invalid_argument, "no volume: " + text);
  const std::string name = text.substr(0, equals);
  std::stringstream rest(text.substr(equals + 1));
  std::string words[5];
  for (std::string& word : words) std::getline(rest, word, ',');
  MaskVolume volume =
      empty_volume(name, {std::stoll(words[1]), std::stoll(words[2]), std::stoll(words[3])},
                   static_cast<std::int16_t>(std::stoi(words[4])));
  std::ifstream file(words[0], std::ios::binary);
  const auto bytes = static_cast<std::streamsize>(volume.voxels.size() * sizeof(std::int16_t));
  if (!file.read(reinterpret_cast<char*>(volume.voxels.data()), bytes)) {
    throw Error(ErrorKind::io, "cannot read all voxels", words[0]);
  }
  return volume;
}

MaskVolume moved(const MaskVolume& volume) {
  const Size3& size = volume.size;
  MaskVolume result = volume;
  std::fill(result.voxels.begin(), result.voxels.end(), std::int16_t{-32768});
  for (std::int64_t z = 5; z < size.z; ++z) {
    for (std::int64_t y = 10; y < size.y; ++y) {
      const std::int16_t* const from = volume.voxels.data() + ((z - 5) * size.y + y - 10) * size.x;
      std::copy(from, from + size.x - 10, result.voxels.data() + (z * size.y + y) * size.x + 10);
    }
  }
  return result;
}

/// A hollow ball: all surface.
MaskVolume shell_volume(std::int64_t side) {
  MaskVolume volume = empty_volume("shell-" + std::to_string(side), {side, side, side}, 1);
  const double center = static_cast<double>(side - 1) / 2;
  std::size_t at = 0;
  for (std::int64_t z = 0; z < side; ++z) {
    for (std::int64_t y = 0; y < side; ++y) {
      for (std::int64_t x = 0; x < side; ++x, ++at) {
        const double r =
            std::hypot(static_cast<double>(x) - center, static_cast<double>(y) - center,
                       static_cast<double>(z) - center);
        volume.voxels[at] = std::abs(r - 0.4 * static_cast<double>(side)) < 3 ? 1 : 0;
      }
    }
  }
  return volume;
}

/// Thin winding tubes in a long volume of 474 x 470 x `length`: nearly all of it is empty.
MaskVolume tube_volume(std::int64_t length) {
  const Size3 size{474, 470, length};
  MaskVolume volume = empty_volume("tubes-474x470x" + std::to_string(length), size, 1);
  for (std::int64_t z = 0; z < length; ++z) {
    for (int tube = 0; tube < 12; ++tube) {
      const double turn = static_cast<double>(z) / 90 + tube;
      const double cx = 237 + (40 + 14.0 * tube) * std::cos(turn);
      const double cy = 235 + (40 + 14.0 * tube) * std::sin(turn);
      for (std::int64_t y = std::max<std::int64_t>(0, std::lround(cy) - 4);
           y < std::min(size.y, static_cast<std::int64_t>(std::lround(cy)) + 5); ++y) {
        for (std::int64_t x = std::max<std::int64_t>(0, std::lround(cx) - 4);
             x < std::min(size.x, static_cast<std::int64_t>(std::lround(cx)) + 5); ++x) {
          if (std::hypot(static_cast<double>(x) - cx, static_cast<double>(y) - cy) < 4) {
            volume.voxels[static_cast<std::size_t>((z * size.y + y) * size.x + x)] = 1;
          }
        }
      }
    }
  }
  return volume;
}

/// Runs of one operation of one library.
struct Contest {
  Row row;
  MaskOperation operation;
};

/// Growth of resident memory during one run, in a child of its own.
/// Requires that this process has no other thread.
std::uint64_t memory_of(const MaskOperation& operation) {
  std::array<int, 2> ends{};
  require(pipe(ends.data()) == 0, "pipe");
  malloc_trim(0);  // memory that was freed before would hide what is needed
  const pid_t child = fork();
  require(child >= 0, "fork");
  if (child == 0) {
    if (operation.prepare) operation.prepare();
    reset_peak_memory();
    const std::uint64_t before = resident_memory_bytes();
    operation.run();
    const std::uint64_t grown = std::max(peak_memory_bytes(), before) - before;
    _exit(write(ends[1], &grown, sizeof grown) == sizeof grown ? 0 : 1);
  }
  close(ends[1]);
  std::uint64_t grown = 0;
  const bool is_whole = read(ends[0], &grown, sizeof grown) == sizeof grown;
  close(ends[0]);
  waitpid(child, nullptr, 0);
  require(is_whole, operation.name);
  return grown;
}

void run_once(Contest& contest, std::map<std::string, std::uint64_t>& results) {
  if (contest.operation.prepare) contest.operation.prepare();
  std::uint64_t result = 0;
  contest.row.seconds.push_back(seconds_of([&] { result = contest.operation.run(); }));
  const auto [known, is_new] = results.emplace(contest.operation.name, result);
  if (!is_new && known->second != result) {
    throw Error(ErrorKind::internal, contest.row.operation + " gives " + std::to_string(result) +
                                         ", others " + std::to_string(known->second));
  }
}

void contest(const MaskVolume& volume, const MaskSettings& settings) {
  const MaskVolume other = moved(volume);
  std::vector<std::unique_ptr<MaskEngine>> engines;
  engines.push_back(make_octavo_masks(volume, other));
  if (!settings.is_growth) {
    engines.push_back(make_openvdb_masks(volume, other));
    engines.push_back(make_itk_masks(volume, other));
  }
  std::vector<Contest> contests;
  for (const auto& engine : engines) {
    for (MaskOperation& operation : engine->operations()) {
      Row row;
      row.threads = settings.threads;
      row.data_set = volume.name;
      row.operation = engine->name() + " " + operation.name;
      row.bytes = engine->memory_bytes();
      row.raw_bytes = volume.voxels.size() * sizeof(std::int16_t);
      row.voxel_count = volume.voxels.size();
      if (settings.threads == 1) row.peak_memory_bytes = memory_of(operation);
      contests.push_back({row, std::move(operation)});
    }
  }
  std::map<std::string, std::uint64_t> results;
  for (int round = 0; round < settings.rounds; ++round) {
    for (Contest& one : contests) run_once(one, results);
  }
  for (const Contest& one : contests) std::cout << csv_line(one.row, settings.commit) << std::endl;
}

MaskSettings parse(int count, char** words) {
  MaskSettings settings;
  for (const std::string& word : take_settings(count, words, settings)) {
    if (word == "--growth") settings.is_growth = true;
    else settings.volumes.push_back(word);
  }
  if (settings.volumes.empty() && !settings.is_growth) {
    throw Error(ErrorKind::invalid_argument,
                "usage: bench_masks [--commit ID] [--rounds N] [--threads N] [--growth] VOLUME...");
  }
  return settings;
}

void run(const MaskSettings& settings) {
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(settings.threads));
  itk::MultiThreaderBase::SetGlobalMaximumNumberOfThreads(
      static_cast<itk::ThreadIdType>(settings.threads));
  itk::MultiThreaderBase::SetGlobalDefaultNumberOfThreads(
      static_cast<itk::ThreadIdType>(settings.threads));
  std::cout << csv_header() << "\n";
  for (const std::string& text : settings.volumes) contest(load_volume(text), settings);
  if (!settings.is_growth) return;
  for (const std::int64_t side : {128, 256, 512, 1024}) contest(shell_volume(side), settings);
  for (const std::int64_t length : {400, 800, 1597}) contest(tube_volume(length), settings);
}

}  // namespace
}  // namespace octavo::bench

int main(int count, char** words) {
  using namespace octavo::bench;
  return run_named("bench_masks", [=] { run(parse(count, words)); });
}
