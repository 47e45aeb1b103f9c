// Runs codecs side by side on raw volumes and prints one CSV row per codec, volume and direction.
//
// usage: bench_peers [--commit ID] [--only NAME,..] [--without NAME,..] [--rounds N]
//                    [--budget SECONDS] [--max-error E,..] LIST
//
// LIST is a file with one volume per line: NAME PATH nx,ny,nz,type [grey|labels] [sx,sy,sz];
// bench/prepare writes some. Codecs take turns: each round runs every codec once, so that a busy
// machine slows all of them alike. A codec leaves the rounds when it has used its budget for a
// volume (the CSV says how many runs it had). Every decode is compared with the voxels; a
// difference beyond the bound stops the program.
//
// Without --max-error all codecs run lossless; with it, those that can promise a maximum error run
// once for each bound, in voxel units.

#include <cstdio>
#include <fstream>
#include <sstream>

#include "bench/peers/contest.h"
#include "octavo/core/error.h"

namespace octavo::bench {
namespace {

struct Settings {
  ContestSettings contest;
  std::vector<std::int64_t> max_errors;  ///< empty: lossless
  std::string list;
};

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> names;
  std::istringstream words(text);
  for (std::string name; std::getline(words, name, ',');) names.push_back(name);
  return names;
}

std::vector<std::int64_t> parse_bounds(const std::string& text) {
  std::vector<std::int64_t> bounds;
  for (const std::string& word : split(text)) {
    bounds.push_back(std::stoll(word));
    if (bounds.back() < 1) {
      throw Error(ErrorKind::invalid_argument, "--max-error takes whole numbers from 1");
    }
  }
  return bounds;
}

Settings parse(int count, char** words) {
  Settings settings;
  for (int i = 1; i < count; ++i) {
    const std::string word = words[i];
    const bool has_value = i + 1 < count;
    if (word == "--commit" && has_value) settings.contest.commit = words[++i];
    else if (word == "--only" && has_value) settings.contest.only = split(words[++i]);
    else if (word == "--without" && has_value) settings.contest.without = split(words[++i]);
    else if (word == "--rounds" && has_value) settings.contest.rounds = std::stoi(words[++i]);
    else if (word == "--budget" && has_value) {
      settings.contest.budget_seconds = std::stod(words[++i]);
    } else if (word == "--max-error" && has_value) settings.max_errors = parse_bounds(words[++i]);
    else settings.list = word;
  }
  if (settings.list.empty() || settings.list.starts_with("--")) {
    throw Error(ErrorKind::invalid_argument,
                "usage: bench_peers [--commit ID] [--only NAME,..] [--without NAME,..] "
                "[--rounds N] [--budget SECONDS] [--max-error E,..] LIST");
  }
  return settings;
}

Peers lossless_peers() {
  Peers peers;
  add_general_peers(peers);
  add_zfp_peer(peers, 0);
  add_jpeg_ls_peer(peers, 0);
  add_jpeg2000_peer(peers);
  add_htj2k_peer(peers);
  add_jpeg_xl_peers(peers);
  add_octavo_peers(peers, 0);
  return peers;
}

Peers bounded_peers(std::int64_t max_error) {
  Peers peers;
  add_zfp_peer(peers, max_error);
  add_jpeg_ls_peer(peers, max_error);
  add_octavo_peers(peers, max_error);
  return peers;
}

/// The codecs of one maximum error.
struct Field {
  std::int64_t max_error = 0;
  Peers peers;
};

std::vector<Field> fields_of(const Settings& settings) {
  std::vector<Field> fields;
  if (settings.max_errors.empty()) fields.push_back({0, lossless_peers()});
  for (const std::int64_t bound : settings.max_errors) {
    fields.push_back({bound, bounded_peers(bound)});
  }
  return fields;
}

int run(int count, char** words) {
  const Settings settings = parse(count, words);
  std::ifstream list(settings.list);
  if (!list) throw Error(ErrorKind::io, "cannot be opened", settings.list);
  const std::vector<Field> fields = fields_of(settings);
  std::printf("%s\n", contest_header().c_str());
  for (std::string line; std::getline(list, line);) {
    if (line.empty() || line[0] == '#') continue;
    const RawVolume volume = load_raw_volume(line);
    for (const Field& field : fields) {
      run_contest(field.peers, volume, field.max_error, settings.contest);
    }
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
