#include "octavo/render/rays/large_pages.h"

#ifdef __linux__
#include <sys/mman.h>
#endif

#include <new>

namespace octavo {

namespace {

constexpr std::size_t kLargePageBytes = std::size_t{1} << 21;
constexpr std::align_val_t kLargePageAlignment{kLargePageBytes};

}  // namespace

void LargePagesDeleter::operator()(std::uint8_t* bytes) const {
  ::operator delete(bytes, kLargePageAlignment);
}

LargePages make_large_pages(std::size_t bytes) {
  LargePages made(static_cast<std::uint8_t*>(::operator new(bytes, kLargePageAlignment)));
#ifdef __linux__
  // Whole ones alone. Where the machine has none nothing changes.
  const std::size_t whole = bytes / kLargePageBytes * kLargePageBytes;
  if (whole > 0) madvise(made.get(), whole, MADV_HUGEPAGE);
#endif
  return made;
}

LargePages KeptPages::take(std::size_t bytes) {
  {
    const std::lock_guard lock(guard_);
    if (pages_ && bytes_ == bytes) return std::move(pages_);
  }
  return make_large_pages(bytes);
}

void KeptPages::give_back(LargePages pages, std::size_t bytes) {
  const std::lock_guard lock(guard_);
  pages_.swap(pages);
  bytes_ = bytes;
}

}  // namespace octavo
