// Memory that rays look into far apart: where the machine gives large pages for the asking, a look
// costs no search for its page, and few are set up.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <type_traits>
#include <utility>

namespace octavo {

struct LargePagesDeleter {
  void operator()(std::uint8_t* bytes) const;
};

using LargePages = std::unique_ptr<std::uint8_t[], LargePagesDeleter>;

/// Bytes that are not set; pages that nothing comes to are never touched.
/// Throws  std::bad_alloc
LargePages make_large_pages(std::size_t bytes);

/// Large pages that were given back last, for the next one who asks for as many: a picture is drawn
/// where the one before stood, and sets up no pages. Threads may share it.
class KeptPages {
 public:
  /// Throws  std::bad_alloc
  LargePages take(std::size_t bytes);
  void give_back(LargePages pages, std::size_t bytes);

 private:
  std::mutex guard_;
  LargePages pages_;
  std::size_t bytes_ = 0;
};

/// Of vectors whose memory is kept for the next ones of their size.
template <class T>
class KeptAllocator {
 public:
  using value_type = T;
  using propagate_on_container_move_assignment = std::true_type;

  /// Memory that is not kept.
  KeptAllocator() = default;
  explicit KeptAllocator(std::shared_ptr<KeptPages> kept) : kept_(std::move(kept)) {}
  template <class U>
  explicit KeptAllocator(const KeptAllocator<U>& other) : kept_(other.kept()) {}

  T* allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    LargePages pages = kept_ ? kept_->take(bytes) : make_large_pages(bytes);
    return reinterpret_cast<T*>(pages.release());
  }
  void deallocate(T* values, std::size_t count) {
    LargePages pages(reinterpret_cast<std::uint8_t*>(values));
    if (kept_) kept_->give_back(std::move(pages), count * sizeof(T));
  }

  const std::shared_ptr<KeptPages>& kept() const { return kept_; }
  template <class U>
  bool operator==(const KeptAllocator<U>& other) const {
    return kept_ == other.kept();
  }

 private:
  std::shared_ptr<KeptPages> kept_;
};

}  // namespace octavo
