// What a build in parts costs beside one in one piece, and a join beside a copy of the file.
//
// usage: bench_parts [--commit ID] [--rounds N] [--side N] [--planes N] [--small] FOLDER
//
// A phantom with noise of N x N x planes voxels of 16 bits, held in memory, so that to read it
// again costs what a copy of it does; parts of four groups. Builds, plan, parts, join and cp take
// turns on one thread, and who begins changes from round to round; times are processor time,
// medians of the rounds, and ratios medians of those of the rounds. FOLDER is made for the files
// and goes with them. The file of the join is that of the build, or the program ends with an error.

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include "bench/common/measure.h"
#include "bench/common/settings.h"
#include "octavo/core/error.h"
#include "octavo/dist/parts.h"
#include "octavo/dist/plan_text.h"
#include "octavo/planes/memory_source.h"
#include "octavo/planes/phantom.h"

namespace octavo::bench {
namespace {

constexpr std::int64_t kGroupsOfPart = 4;

struct Choice {
  Settings settings;
  std::int64_t side = 512;
  std::int64_t planes = 2048;
  Preset preset = Preset::fast;
  std::string folder;
};

double processor_seconds(int who) {
  rusage used{};
  ::getrusage(who, &used);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) / 1e6;
  };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

/// Of this process, or of the processes that `work` waits for.
double processor_seconds_of(const std::function<void()>& work, int who = RUSAGE_SELF) {
  const double began = processor_seconds(who);
  work();
  return processor_seconds(who) - began;
}

/// What is built, plane by plane.
struct Scan {
  VolumeDescription description;
  std::vector<std::byte> voxels;

  std::unique_ptr<PlaneSource> open() const { return make_memory_source(description, voxels); }
};

Scan phantom(const Choice& choice) {
  PhantomOptions options;
  options.size = {choice.side, choice.side, choice.planes};
  options.noise_sigma = 12;
  const auto source = make_phantom(options);
  Scan scan{source->description(), {}};
  const auto plane = static_cast<std::size_t>(plane_bytes(scan.description));
  scan.voxels.resize(plane * static_cast<std::size_t>(choice.planes));
  for (std::size_t at = 0; at < scan.voxels.size(); at += plane) {
    source->read_plane(std::span(scan.voxels).subspan(at, plane));
  }
  return scan;
}

std::string part_path(const Choice& choice, std::int64_t first) {
  return choice.folder + "/part-" + std::to_string(first);
}

/// A join makes its file durable before it has its name; so does the copy that is synced.
void copy_by_cp(const std::string& from, const std::string& to, bool is_synced) {
  const std::string command = is_synced ? R"(cp "$0" "$1" && sync "$1")" : R"(cp "$0" "$1")";
  const pid_t process = ::fork();
  if (process == 0) {
    ::execlp("sh", "sh", "-c", command.c_str(), from.c_str(), to.c_str(), nullptr);
    ::_exit(127);
  }
  int status = 0;
  ::waitpid(process, &status, 0);
  if (status != 0) throw Error(ErrorKind::io, "cp failed", from);
}

bool are_same(const std::string& a, const std::string& b) {
  std::ifstream one(a, std::ios::binary);
  std::ifstream other(b, std::ios::binary);
  using Bytes = std::istreambuf_iterator<char>;
  return std::equal(Bytes(one), Bytes(), Bytes(other), Bytes());
}

struct Times {
  std::vector<double> build, plan, parts, join, copy, synced_copy;
};

/// One round: what it builds, where, and who begins.
class Round {
 public:
  Round(const Choice& choice, const Scan& scan, Times& times)
      : choice_(choice), scan_(scan), times_(times) {
    options_.preset = choice.preset;
    options_.threads = 1;
    options_.overwrite = true;
    options_.is_resumable = false;
  }

  void run(bool begins_whole) {
    if (begins_whole) build_whole();
    build_parted();
    if (!begins_whole) build_whole();
    copy(times_.copy, false);
    copy(times_.synced_copy, true);
    if (!are_same(whole_, joined_)) throw Error(ErrorKind::internal, "the files differ", joined_);
  }

 private:
  void build_whole() {
    times_.build.push_back(processor_seconds_of(
        [&] { build_file(*scan_.open(), local_storage(), whole_, options_, progress_); }));
  }

  void build_parted() {
    BuildPlan plan;
    times_.plan.push_back(processor_seconds_of(
        [&] { plan = parse_plan(plan_text(plan_build(*scan_.open(), options_, progress_))); }));
    times_.parts.push_back(processor_seconds_of([&] {
      for (std::int64_t first = 0; first < plan.group_count; first += kGroupsOfPart) {
        build_part(plan, *scan_.open(), first,
                   std::min(first + kGroupsOfPart, plan.group_count), local_storage(),
                   part_path(choice_, first), {.threads = 1}, progress_);
      }
    }));
    std::filesystem::remove(joined_);
    times_.join.push_back(processor_seconds_of([&] {
      std::vector<std::shared_ptr<PartFile>> parts;
      for (std::int64_t first = 0; first < plan.group_count; first += kGroupsOfPart) {
        parts.push_back(PartFile::open(local_storage(), part_path(choice_, first)));
      }
      join_parts(plan, parts, local_storage(), joined_, true, {.threads = 1}, progress_);
    }));
  }

  void copy(std::vector<double>& times, bool is_synced) {
    const std::string path = choice_.folder + "/copy.8vo";
    std::filesystem::remove(path);
    times.push_back(processor_seconds_of([&] { copy_by_cp(joined_, path, is_synced); },
                                         RUSAGE_CHILDREN));
  }

  const Choice& choice_;
  const Scan& scan_;
  Times& times_;
  BuildOptions options_;
  NoProgress progress_;
  const std::string whole_ = choice_.folder + "/whole.8vo";
  const std::string joined_ = choice_.folder + "/joined.8vo";
};

/// The median of one time over another, round by round.
double median_ratio(const std::vector<double>& times, const std::vector<double>& of) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < times.size(); ++i) ratios.push_back(times[i] / of[i]);
  return median(ratios);
}

void print_row(const Choice& choice, const char* operation, double value, const char* unit,
               const char* goal) {
  const std::string size = std::to_string(choice.side);
  const std::string phantom = "phantom " + size + " x " + size + " x " +
                              std::to_string(choice.planes) +
                              (choice.preset == Preset::fast ? " fast" : " small");
  std::printf("%s,%s,%s,%s,%d,%.3f,%s,%s\n", choice.settings.commit.c_str(),
              machine_name().c_str(), phantom.c_str(), operation, choice.settings.rounds, value,
              unit, goal);
}

void run(const Choice& choice) {
  Times times;
  if (!std::filesystem::create_directories(choice.folder)) {
    throw Error(ErrorKind::io, "is there already: give a new folder", choice.folder);
  }
  const Scan scan = phantom(choice);
  for (int round = 0; round < choice.settings.rounds; ++round) {
    Round(choice, scan, times).run(round % 2 == 0);
  }
  std::filesystem::remove_all(choice.folder);
  std::vector<double> all = times.plan;
  for (std::size_t i = 0; i < all.size(); ++i) all[i] += times.parts[i] + times.join[i];
  std::printf("commit,machine,data_set,operation,runs,value,unit,goal\n");
  print_row(choice, "build", median(times.build), "CPU s", "");
  print_row(choice, "plan", median(times.plan), "CPU s", "");
  print_row(choice, "parts of 4 groups", median(times.parts), "CPU s", "");
  print_row(choice, "join", median(times.join), "CPU s", "");
  print_row(choice, "cp of the file", median(times.copy), "CPU s", "");
  print_row(choice, "cp and sync of the file", median(times.synced_copy), "CPU s", "");
  print_row(choice, "plan + parts + join over build", median_ratio(all, times.build), "times",
            "1.03");
  print_row(choice, "join over cp", median_ratio(times.join, times.copy), "times", "1.5");
  print_row(choice, "join over cp and sync", median_ratio(times.join, times.synced_copy), "times",
            "1.5");
}

Choice choice_of(int count, char** words) {
  Choice choice;
  choice.settings.rounds = 3;
  const std::vector<std::string> rest = take_settings(count, words, choice.settings);
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const auto number = [&] { return i + 1 < rest.size() ? std::atoll(rest[++i].c_str()) : 0; };
    if (rest[i] == "--side") choice.side = number();
    else if (rest[i] == "--planes") choice.planes = number();
    else if (rest[i] == "--small") choice.preset = Preset::small;
    else choice.folder = rest[i];
  }
  if (choice.folder.empty()) throw Error(ErrorKind::invalid_argument, "no folder given");
  return choice;
}

}  // namespace
}  // namespace octavo::bench

int main(int argc, char** argv) {
  using namespace octavo::bench;
  return run_named("bench_parts", [&] { run(choice_of(argc, argv)); });
}
