// What a build in parts costs beside one in one piece, and a join beside a copy of the file.
//
// usage: bench_parts [--commit ID] [--rounds N] [--side N] [--planes N] [--small] FOLDER
//
// A phantom with noise of N x N x planes voxels of 16 bits; parts of four groups. Builds, plan,
// parts, join and cp take turns on one thread; times are processor time, medians of the rounds.
// FOLDER is made for the files and goes with them. The file of the join is that of the build, or
// the program ends with an error.

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

#include "bench/common/measure.h"
#include "bench/common/settings.h"
#include "octavo/core/error.h"
#include "octavo/dist/parts.h"
#include "octavo/dist/plan_text.h"
#include "octavo/planes/phantom.h"

namespace octavo::bench {
namespace {

constexpr std::int64_t kGroupsOfPart = 4;

struct Choice {
  Settings settings;
  std::int64_t side = 1024;
  std::int64_t planes = 1024;
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

std::unique_ptr<PlaneSource> phantom(const Choice& choice) {
  PhantomOptions options;
  options.size = {choice.side, choice.side, choice.planes};
  options.noise_sigma = 12;
  return make_phantom(options);
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

void run_round(const Choice& choice, Times& times) {
  NoProgress progress;
  BuildOptions options;
  options.preset = choice.preset;
  options.threads = 1;
  options.overwrite = true;
  options.is_resumable = false;
  const std::string whole = choice.folder + "/whole.8vo";
  const std::string joined = choice.folder + "/joined.8vo";
  times.build.push_back(processor_seconds_of(
      [&] { build_file(*phantom(choice), local_storage(), whole, options, progress); }));
  BuildPlan plan;
  times.plan.push_back(processor_seconds_of(
      [&] { plan = parse_plan(plan_text(plan_build(*phantom(choice), options, progress))); }));
  times.parts.push_back(processor_seconds_of([&] {
    for (std::int64_t first = 0; first < plan.group_count; first += kGroupsOfPart) {
      build_part(plan, *phantom(choice), first, std::min(first + kGroupsOfPart, plan.group_count),
                 local_storage(), part_path(choice, first), {.threads = 1}, progress);
    }
  }));
  std::filesystem::remove(joined);
  times.join.push_back(processor_seconds_of([&] {
    std::vector<std::shared_ptr<PartFile>> parts;
    for (std::int64_t first = 0; first < plan.group_count; first += kGroupsOfPart) {
      parts.push_back(PartFile::open(local_storage(), part_path(choice, first)));
    }
    join_parts(plan, parts, local_storage(), joined, true, {.threads = 1}, progress);
  }));
  const auto copy = [&](bool is_synced) {
    const std::string path = choice.folder + "/copy.8vo";
    std::filesystem::remove(path);
    return processor_seconds_of([&] { copy_by_cp(joined, path, is_synced); }, RUSAGE_CHILDREN);
  };
  times.copy.push_back(copy(false));
  times.synced_copy.push_back(copy(true));
  if (!are_same(whole, joined)) throw Error(ErrorKind::internal, "the files differ", joined);
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
  for (int round = 0; round < choice.settings.rounds; ++round) run_round(choice, times);
  std::filesystem::remove_all(choice.folder);
  const double build = median(times.build);
  const double plan = median(times.plan);
  const double parts = median(times.parts);
  const double join = median(times.join);
  const double copy = median(times.copy);
  const double synced_copy = median(times.synced_copy);
  std::printf("commit,machine,data_set,operation,runs,value,unit,goal\n");
  print_row(choice, "build", build, "CPU s", "");
  print_row(choice, "plan", plan, "CPU s", "");
  print_row(choice, "parts of 4 groups", parts, "CPU s", "");
  print_row(choice, "join", join, "CPU s", "");
  print_row(choice, "cp of the file", copy, "CPU s", "");
  print_row(choice, "plan + parts + join over build", (plan + parts + join) / build, "times",
            "1.03");
  print_row(choice, "cp and sync of the file", synced_copy, "CPU s", "");
  print_row(choice, "join over cp", join / copy, "times", "1.5");
  print_row(choice, "join over cp and sync", join / synced_copy, "times", "1.5");
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
