#include "bench/common/measure.h"

#include <ctime>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <thread>

namespace octavo::bench {
namespace {

/// The value of the first line of `path` that starts with `key`, without blanks and colon around
/// it.
std::string proc_value(const char* path, const std::string& key) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with(key)) continue;
    const auto colon = line.find(':');
    if (colon == std::string::npos) continue;
    const auto start = line.find_first_not_of(" \t", colon + 1);
    return start == std::string::npos ? std::string() : line.substr(start);
  }
  return {};
}

}  // namespace

double now_seconds() {
  using clock = std::chrono::steady_clock;
  return std::chrono::duration<double>(clock::now().time_since_epoch()).count();
}

double cpu_seconds() {
  timespec now{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double seconds_of(const std::function<void()>& work) {
  const double start = now_seconds();
  work();
  return now_seconds() - start;
}

bool reset_peak_memory() {
  std::ofstream file("/proc/self/clear_refs");
  file << "5\n";
  file.flush();
  return file.good();
}

std::uint64_t peak_memory_bytes() {
  const std::string kilobytes = proc_value("/proc/self/status", "VmHWM");
  return kilobytes.empty() ? 0 : std::stoull(kilobytes) * 1024;
}

std::uint64_t resident_memory_bytes() {
  const std::string kilobytes = proc_value("/proc/self/status", "VmRSS");
  return kilobytes.empty() ? 0 : std::stoull(kilobytes) * 1024;
}

std::string machine_name() {
  std::string name = proc_value("/proc/cpuinfo", "model name");
  std::replace(name.begin(), name.end(), ',', ' ');
  return name + " / " + std::to_string(std::thread::hardware_concurrency()) + " cores";
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
}

std::string csv_header() {
  return "commit,machine,threads,data_set,operation,runs,median_s,spread_s,bytes,raw_bytes,ratio,"
         "MB_per_s,Mvoxel_per_s,peak_memory_bytes";
}

std::string csv_line(const Row& row, const std::string& commit) {
  const auto [fastest, slowest] = std::minmax_element(row.seconds.begin(), row.seconds.end());
  const double spread = row.seconds.empty() ? 0 : *slowest - *fastest;
  const double time = median(row.seconds);
  const auto raw = static_cast<double>(row.raw_bytes);
  std::array<char, 512> text{};
  std::snprintf(text.data(), text.size(), ",%d,%s,%s,%zu,%.6f,%.6f,%llu,%llu,%.4f,%.2f,%.2f,%llu",
                row.threads, row.data_set.c_str(), row.operation.c_str(), row.seconds.size(), time,
                spread, static_cast<unsigned long long>(row.bytes),
                static_cast<unsigned long long>(row.raw_bytes),
                row.bytes > 0 ? raw / static_cast<double>(row.bytes) : 0,
                time > 0 ? raw / time / 1e6 : 0,
                time > 0 ? static_cast<double>(row.voxel_count) / time / 1e6 : 0,
                static_cast<unsigned long long>(row.peak_memory_bytes));
  return commit + "," + machine_name() + text.data();
}

}  // namespace octavo::bench
