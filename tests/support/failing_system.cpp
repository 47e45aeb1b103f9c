#include "support/failing_system.h"

#include <fcntl.h>
#include <linux/fs.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <mutex>
#include <random>

namespace {

using octavo::testing::SystemCounts;
using octavo::testing::SystemFaults;

std::mutex mutex;
bool is_on = false;
SystemFaults faults;
SystemCounts counts;
int failed_descriptor = -1;
std::mt19937_64 numbers;

// What is to happen to a call: an errno, or 0. `can_interrupt`: it may return EINTR.
int fate_of(const char* call, int descriptor, bool can_interrupt) {
  std::unique_lock lock(mutex);
  if (!is_on) return 0;
  if (faults.is_rough && can_interrupt && numbers() % 2 == 0) {
    ++counts.interrupted_calls;
    return EINTR;
  }
  if (faults.call != call) return 0;
  if (descriptor >= 0 && descriptor == failed_descriptor) ++counts.later_calls;
  const std::uint64_t number = ++counts.calls;
  const int code = faults.always || number == faults.number ? faults.code : 0;
  if (code != 0) failed_descriptor = descriptor;
  const auto before = faults.before;
  lock.unlock();
  if (before) before(number);
  return code;
}

std::size_t shortened(std::size_t count) {
  const std::lock_guard lock(mutex);
  if (!is_on || !faults.is_rough || count < 2) return count;
  const std::size_t part = 1 + numbers() % count;
  if (part < count) ++counts.short_calls;
  return part;
}

int failed(int code) {
  errno = code;
  return -1;
}

}  // namespace

namespace octavo::testing {

void set_faults(const SystemFaults& wanted) {
  const std::lock_guard lock(mutex);
  faults = wanted;
  counts = {};
  failed_descriptor = -1;
  numbers.seed(wanted.number + 1);
  is_on = true;
}

SystemCounts end_faults() {
  const std::lock_guard lock(mutex);
  is_on = false;
  return counts;
}

}  // namespace octavo::testing

// In place of those of the C library.
extern "C" {

int open(const char* path, int flags, ...) {
  std::va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = va_arg(arguments, mode_t);
  va_end(arguments);
  if (const int code = fate_of("open", -1, true)) return failed(code);
  return static_cast<int>(::syscall(SYS_openat, AT_FDCWD, path, flags, mode));
}

ssize_t pread(int descriptor, void* out, std::size_t count, off_t offset) {
  if (const int code = fate_of("pread", descriptor, true)) return failed(code);
  return ::syscall(SYS_pread64, descriptor, out, shortened(count), offset);
}

ssize_t pwrite(int descriptor, const void* bytes, std::size_t count, off_t offset) {
  if (const int code = fate_of("pwrite", descriptor, true)) return failed(code);
  return ::syscall(SYS_pwrite64, descriptor, bytes, shortened(count), offset);
}

int fsync(int descriptor) {
  if (const int code = fate_of("fsync", descriptor, true)) return failed(code);
  return static_cast<int>(::syscall(SYS_fsync, descriptor));
}

int close(int descriptor) {
  const int code = fate_of("close", descriptor, false);
  const int result = static_cast<int>(::syscall(SYS_close, descriptor));
  return code != 0 ? failed(code) : result;
}

int rename(const char* from, const char* to) noexcept {
  if (const int code = fate_of("rename", -1, false)) return failed(code);
  return static_cast<int>(::syscall(SYS_rename, from, to));
}

int renameat2(int from_folder, const char* from, int to_folder, const char* to,
              unsigned flags) noexcept {
  if (const int code = fate_of("rename", -1, false)) return failed(code);
  return static_cast<int>(::syscall(SYS_renameat2, from_folder, from, to_folder, to, flags));
}

int flock(int descriptor, int operation) noexcept {
  if (const int code = fate_of("flock", descriptor, true)) return failed(code);
  return static_cast<int>(::syscall(SYS_flock, descriptor, operation));
}

int fstat(int descriptor, struct stat* status) noexcept {
  if (const int code = fate_of("fstat", descriptor, false)) return failed(code);
  return static_cast<int>(::syscall(SYS_newfstatat, descriptor, "", status, AT_EMPTY_PATH));
}

int stat(const char* path, struct stat* status) noexcept {
  if (const int code = fate_of("stat", -1, false)) return failed(code);
  return static_cast<int>(::syscall(SYS_newfstatat, AT_FDCWD, path, status, 0));
}

int lstat(const char* path, struct stat* status) noexcept {
  if (const int code = fate_of("lstat", -1, false)) return failed(code);
  return static_cast<int>(
      ::syscall(SYS_newfstatat, AT_FDCWD, path, status, AT_SYMLINK_NOFOLLOW));
}

int ftruncate(int descriptor, off_t size) noexcept {
  if (const int code = fate_of("ftruncate", descriptor, true)) return failed(code);
  return static_cast<int>(::syscall(SYS_ftruncate, descriptor, size));
}

int unlink(const char* path) noexcept {
  if (const int code = fate_of("unlink", -1, false)) return failed(code);
  return static_cast<int>(::syscall(SYS_unlinkat, AT_FDCWD, path, 0));
}

int fchown(int descriptor, uid_t owner, gid_t group) noexcept {
  if (const int code = fate_of("fchown", descriptor, false)) return failed(code);
  return static_cast<int>(::syscall(SYS_fchown, descriptor, owner, group));
}

int mkdir(const char* path, mode_t mode) noexcept {
  if (const int code = fate_of("mkdir", -1, false)) return failed(code);
  return static_cast<int>(::syscall(SYS_mkdirat, AT_FDCWD, path, mode));
}

}  // extern "C"
