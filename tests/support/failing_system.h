// The system calls of file/local_storage, which fail, stop short or are interrupted on demand.
// Holds for every program that links failing_system.cpp.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace octavo::testing {

struct SystemFaults {
  /// "open", "pread", "pwrite", "fsync", "close", "rename", "flock", "fstat", "stat", "lstat",
  /// "ftruncate", "unlink", "mkdir", "fchown"; empty: none fails.
  std::string call;
  std::uint64_t number = 0;  ///< of the call that fails, from 1
  int code = 0;              ///< errno it fails with
  /// What others do meanwhile: runs before each of those calls, with its number.
  std::function<void(std::uint64_t)> before = {};
  /// Reads and writes give 1 byte up to all that was asked for, and every second call is
  /// interrupted before it does anything.
  bool is_rough = false;
  bool always = false;  ///< every call of the kind fails, whatever its number
};

/// Holds from now on.
void set_faults(const SystemFaults& faults);

struct SystemCounts {
  std::uint64_t calls = 0;        ///< of the kind that was to fail
  std::uint64_t later_calls = 0;  ///< of the same kind, on the same file, after the one that failed
  std::uint64_t short_calls = 0;
  std::uint64_t interrupted_calls = 0;
};

/// Ends all faults and tells what there was.
SystemCounts end_faults();

}  // namespace octavo::testing
