#include "support/counted_memory.h"

#include <link.h>
#include <malloc.h>

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <new>

namespace {

std::atomic<std::size_t> live = 0;
std::atomic<std::size_t> peak = 0;
std::atomic<std::uint64_t> calls = 0;
std::atomic<std::int64_t> left = 0;  // allocations until one fails; 0: none fails
std::atomic<bool> all_later_fail = false;
std::atomic<bool> has_failed = false;

// Where the code of TBB stands: its own few allocations lie inside noexcept functions, so that it
// ends the process when one fails, and no caller can do anything about it.
struct Range {
  std::uintptr_t first = 0;
  std::uintptr_t end = 0;
};

Range find_tbb() {
  Range range;
  ::dl_iterate_phdr(
      [](dl_phdr_info* library, std::size_t, void* out) {
        if (std::strstr(library->dlpi_name, "libtbb.so") == nullptr) return 0;
        auto& found = *static_cast<Range*>(out);
        for (int i = 0; i < library->dlpi_phnum; ++i) {
          const auto& part = library->dlpi_phdr[i];
          if (part.p_type != PT_LOAD || (part.p_flags & PF_X) == 0) continue;
          found.first = library->dlpi_addr + part.p_vaddr;
          found.end = found.first + part.p_memsz;
        }
        return 1;
      },
      &range);
  return range;
}

bool is_of_tbb(const void* caller) {
  static const Range tbb = find_tbb();
  const auto address = reinterpret_cast<std::uintptr_t>(caller);
  return address >= tbb.first && address < tbb.end;
}

bool is_to_fail(const void* caller) {
  if (is_of_tbb(caller)) return false;
  calls.fetch_add(1, std::memory_order_relaxed);
  if (left.load(std::memory_order_relaxed) == 0) return false;
  if (has_failed) return all_later_fail;
  if (left.fetch_sub(1) != 1) return false;
  // Not 0, which would end the counting.
  left = 1;
  return !has_failed.exchange(true) || all_later_fail;
}

void* counted(void* block) {
  if (block == nullptr) throw std::bad_alloc();
  const std::size_t now = live += ::malloc_usable_size(block);
  std::size_t highest = peak;
  while (now > highest && !peak.compare_exchange_weak(highest, now)) {
  }
  return block;
}

void release(void* block) noexcept {
  if (block != nullptr) live -= ::malloc_usable_size(block);
  std::free(block);
}

}  // namespace

__attribute__((noinline)) void* operator new(std::size_t size) {
  return counted(is_to_fail(__builtin_return_address(0)) ? nullptr : std::malloc(size));
}

__attribute__((noinline)) void* operator new(std::size_t size, std::align_val_t alignment) {
  void* block = nullptr;
  if (!is_to_fail(__builtin_return_address(0)) &&
      ::posix_memalign(&block, static_cast<std::size_t>(alignment), size) != 0) {
    block = nullptr;
  }
  return counted(block);
}

__attribute__((noinline)) void operator delete(void* block) noexcept { release(block); }
void operator delete(void* block, std::size_t) noexcept { release(block); }
void operator delete(void* block, std::align_val_t) noexcept { release(block); }
void operator delete(void* block, std::size_t, std::align_val_t) noexcept { release(block); }

namespace octavo::testing {

std::size_t live_bytes() noexcept { return live; }
std::size_t peak_bytes() noexcept { return peak; }
std::uint64_t allocation_count() noexcept { return calls; }
void reset_peak() noexcept { peak = live.load(); }

void fail_allocation(std::uint64_t number, bool and_all_later) noexcept {
  has_failed = false;
  all_later_fail = and_all_later;
  left = static_cast<std::int64_t>(number);
}

bool stop_failing() noexcept {
  left = 0;
  return has_failed.exchange(false);
}

}  // namespace octavo::testing
