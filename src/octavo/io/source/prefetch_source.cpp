#include "octavo/io/source/prefetch_source.h"

#include <algorithm>
#include <condition_variable>
#include <cstring>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/unset_bytes.h"
#include "octavo/io/source/described_source.h"
#include "octavo/io/source/reader_notes.h"

namespace octavo {

namespace {

constexpr std::int64_t kSlotsPerThread = 3;

/// Plane z is read into slot z mod slot count, and only when plane z - slot count has been
/// consumed:
/// every slot belongs to one plane at a time, and the planes held are those next in order.
class PrefetchSource final : public PlaneSource {
 public:
  PrefetchSource(std::unique_ptr<PlaneSource> source, const PrefetchOptions& options)
      : source_(std::move(source)),
        indexed_(dynamic_cast<const IndexedPlaneSource*>(source_.get())),
        warnings_(source_->warnings()),
        plane_count_(source_->description().size.z) {
    const std::int64_t cores = std::max(1U, std::thread::hardware_concurrency());
    const std::int64_t wanted = options.threads > 0 ? options.threads : cores;
    const std::int64_t thread_count = indexed_ != nullptr ? std::min(wanted, plane_count_) : 1;
    const auto bytes = static_cast<std::int64_t>(plane_bytes(source_->description()));
    const auto limit = static_cast<std::int64_t>(
        std::min<std::uint64_t>(options.max_bytes, std::uint64_t{1} << 40));
    const std::int64_t slot_count = std::clamp<std::int64_t>(
        limit / bytes, 2, std::max<std::int64_t>(2, kSlotsPerThread * thread_count));
    slots_.resize(static_cast<std::size_t>(slot_count));
    for (Slot& slot : slots_) slot.plane.resize(static_cast<std::size_t>(bytes));
    for (std::int64_t i = 0; i < thread_count; ++i) threads_.emplace_back([this] { work(); });
  }

  ~PrefetchSource() override {
    {
      const std::lock_guard lock(mutex_);
      is_stopping_ = true;
    }
    changed_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

  const VolumeDescription& description() const override { return source_->description(); }
  const std::vector<Warning>& warnings() const override { return warnings_; }
  std::uint64_t resident_bytes() const override {
    return source_->resident_bytes() + slots_.size() * slots_.front().plane.size();
  }

  void read_plane(std::span<std::byte> plane) override {
    if (consumed_ >= plane_count_ || plane.size() != slots_.front().plane.size()) {
      throw Error(ErrorKind::invalid_argument, "no such plane, or a buffer of another size");
    }
    Slot& slot = slot_of(consumed_);
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return slot.filled_with == consumed_; });
      if (slot.failure) std::rethrow_exception(slot.failure);
    }
    std::memcpy(plane.data(), slot.plane.data(), plane.size());
    {
      const std::lock_guard lock(mutex_);
      ++consumed_;
      if (consumed_ == plane_count_) warnings_ = source_->warnings();
    }
    changed_.notify_all();
  }

 private:
  struct Slot {
    UnsetBytes plane;
    std::int64_t filled_with = -1;
    std::exception_ptr failure;
  };

  Slot& slot_of(std::int64_t z) {
    return slots_[static_cast<std::size_t>(z) % slots_.size()];
  }

  /// The next plane to read, once its slot is free; plane_count_ when there is nothing left to do.
  std::int64_t take_ticket() {
    std::unique_lock lock(mutex_);
    const auto slot_count = static_cast<std::int64_t>(slots_.size());
    if (next_ticket_ >= plane_count_) return plane_count_;
    const std::int64_t z = next_ticket_++;
    changed_.wait(lock, [&] { return is_stopping_ || z < consumed_ + slot_count; });
    return is_stopping_ ? plane_count_ : z;
  }

  void work() {
    for (std::int64_t z = take_ticket(); z < plane_count_; z = take_ticket()) {
      Slot& slot = slot_of(z);
      std::exception_ptr failure;
      note_plane(z);
      try {
        if (indexed_ != nullptr) {
          indexed_->read_plane_at(z, slot.plane.bytes());
        } else {
          source_->read_plane(slot.plane.bytes());
        }
      } catch (...) {
        failure = std::current_exception();
      }
      {
        const std::lock_guard lock(mutex_);
        slot.failure = failure;
        slot.filled_with = z;
        if (failure) next_ticket_ = plane_count_;
      }
      changed_.notify_all();
    }
  }

  std::unique_ptr<PlaneSource> source_;
  const IndexedPlaneSource* indexed_;
  std::vector<Warning> warnings_;
  std::int64_t plane_count_;
  std::vector<Slot> slots_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::int64_t next_ticket_ = 0;
  std::int64_t consumed_ = 0;
  bool is_stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace

std::unique_ptr<PlaneSource> make_prefetch_source(std::unique_ptr<PlaneSource> source,
                                                  const PrefetchOptions& options) {
  return std::make_unique<PrefetchSource>(std::move(source), options);
}

}  // namespace octavo
