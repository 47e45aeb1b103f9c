// Runs codecs side by side on raw volumes and prints one CSV row per codec, volume and direction.
//
// usage: bench_peers [--commit ID] [--only NAME,..] [--rounds N] [--budget SECONDS] LIST
//
// LIST is a file with one volume per line: NAME PATH nx,ny,nz,type [grey|labels] [sx,sy,sz];
// bench/prepare writes one. Codecs take turns: each round runs every codec once, so that a busy
// machine slows all of them alike. A codec leaves the rounds when it has used its budget for a
// volume (the CSV says how many runs it had). Every decode is compared with the voxels; a
// difference stops the program.

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <sstream>

#include "bench/common/measure.h"
#include "bench/peers/peer.h"
#include "octavo/core/error.h"

namespace octavo::bench {
namespace {

struct Settings {
  std::string commit = "unknown";
  std::string only;
  int rounds = 5;
  double budget_seconds = 60;
  std::string list;
};

struct Contest {
  Peer* peer = nullptr;
  Row encode;
  Row decode;
  double spent_seconds = 0;
  bool has_run() const { return !encode.seconds.empty(); }
};

void run_once(Contest& contest, const RawVolume& volume) {
  RawVolume decoded = volume;
  std::fill(decoded.voxels.begin(), decoded.voxels.end(), std::uint8_t{0});
  Encoded encoded;

  reset_peak_memory();
  contest.encode.seconds.push_back(seconds_of([&] { encoded = contest.peer->encode(volume); }));
  contest.encode.peak_memory_bytes =
      std::max(contest.encode.peak_memory_bytes, peak_memory_bytes());

  reset_peak_memory();
  contest.decode.seconds.push_back(seconds_of([&] { contest.peer->decode(encoded, decoded); }));
  contest.decode.peak_memory_bytes =
      std::max(contest.decode.peak_memory_bytes, peak_memory_bytes());

  require(decoded.voxels == volume.voxels, (contest.peer->name() + " is not lossless").c_str());
  contest.encode.bytes = contest.decode.bytes = encoded.byte_count();
  contest.spent_seconds += contest.encode.seconds.back() + contest.decode.seconds.back();
}

/// True when `name` stands in the list of --only, or there is none.
bool is_wanted(const std::string& name, const Settings& settings) {
  if (settings.only.empty()) return true;
  std::istringstream names(settings.only);
  for (std::string choice; std::getline(names, choice, ',');) {
    if (choice == name) return true;
  }
  return false;
}

std::vector<Contest> enter(const Peers& peers, const RawVolume& volume, const Settings& settings) {
  std::vector<Contest> contests;
  for (const auto& peer : peers) {
    if (!is_wanted(peer->name(), settings) || !peer->supports(volume)) continue;
    Contest contest;
    contest.peer = peer.get();
    contest.encode.data_set = contest.decode.data_set = volume.name;
    contest.encode.operation = "encode " + peer->name();
    contest.decode.operation = "decode " + peer->name();
    contest.encode.raw_bytes = contest.decode.raw_bytes = volume.voxels.size();
    contests.push_back(std::move(contest));
  }
  return contests;
}

void run_volume(const Peers& peers, const RawVolume& volume, const Settings& settings) {
  std::vector<Contest> contests = enter(peers, volume, settings);
  for (int round = 0; round < settings.rounds; ++round) {
    for (Contest& contest : contests) {
      const bool is_within =
          contest.spent_seconds * (round + 1) <= settings.budget_seconds * std::max(round, 1);
      if (!contest.has_run() || is_within) run_once(contest, volume);
    }
  }
  for (const Contest& contest : contests) {
    std::cout << csv_line(contest.encode, settings.commit) << "\n"
              << csv_line(contest.decode, settings.commit) << std::endl;
  }
}

Settings parse(int count, char** words) {
  Settings settings;
  for (int i = 1; i < count; ++i) {
    const std::string word = words[i];
    const bool has_value = i + 1 < count;
    if (word == "--commit" && has_value) settings.commit = words[++i];
    else if (word == "--only" && has_value) settings.only = words[++i];
    else if (word == "--rounds" && has_value) settings.rounds = std::stoi(words[++i]);
    else if (word == "--budget" && has_value) settings.budget_seconds = std::stod(words[++i]);
    else settings.list = word;
  }
  if (settings.list.empty()) {
    throw Error(
        ErrorKind::invalid_argument,
        "usage: bench_peers [--commit ID] [--only NAME,..] [--rounds N] [--budget SECONDS] LIST");
  }
  return settings;
}

int run(int count, char** words) {
  const Settings settings = parse(count, words);
  Peers peers;
  add_general_peers(peers);
  add_jpeg_ls_peer(peers);
  add_jpeg2000_peer(peers);
  add_htj2k_peer(peers);
  add_jpeg_xl_peer(peers);
  add_octavo_peers(peers);
  std::ifstream list(settings.list);
  if (!list) throw Error(ErrorKind::io, "cannot be opened", settings.list);
  std::cout << csv_header() << "\n";
  for (std::string line; std::getline(list, line);) {
    if (!line.empty() && line[0] != '#') run_volume(peers, load_raw_volume(line), settings);
  }
  return 0;
}

}  // namespace
}  // namespace octavo::bench

int main(int count, char** words) {
  try {
    return octavo::bench::run(count, words);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_peers: %s\n", error.what());
    return 1;
  }
}
