// Time, memory and the CSV row of one measurement.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace octavo::bench {

/// Seconds on the monotonic clock.
double now_seconds();

/// Seconds of processors that this process has taken.
double cpu_seconds();

/// Seconds that `work` takes.
double seconds_of(const std::function<void()>& work);

/// Starts the peak of resident memory anew; false where the system does not allow it.
bool reset_peak_memory();

/// Peak resident memory of this process since reset_peak_memory, bytes.
std::uint64_t peak_memory_bytes();

/// Resident memory of this process now, bytes.
std::uint64_t resident_memory_bytes();

/// The CPU's name and the number of its cores.
std::string machine_name();

/// One line of a result file.
struct Row {
  int threads = 1;
  std::string data_set;
  std::string operation;
  std::vector<double> seconds;      ///< one entry per run
  std::uint64_t bytes = 0;          ///< size of the result: compressed bytes, or bytes read
  std::uint64_t raw_bytes = 0;      ///< voxels that went through, in bytes
  std::uint64_t voxel_count = 0;    ///< voxels that went through
  std::uint64_t peak_memory_bytes = 0;
};

double median(std::vector<double> values);

/// The names of the columns; docs/benchmarks.md explains them.
std::string csv_header();

/// spread_s is the slowest run less the fastest; ratio is raw_bytes / bytes; MB are 10^6 bytes of
/// voxels, Mvoxel 10^6 voxels.
std::string csv_line(const Row& row, const std::string& commit);

}  // namespace octavo::bench
