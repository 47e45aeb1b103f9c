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
#include "octavo/planes/plane_cursor.h"

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
        cursor_(source_->description().size.z),
        end_(cursor_.end()) {
    const std::int64_t cores = std::max(1U, std::thread::hardware_concurrency());
    const std::int64_t wanted = options.threads > 0 ? options.threads : cores;
    thread_count_ = indexed_ != nullptr ? std::min(wanted, end_) : 1;
    const auto bytes = static_cast<std::int64_t>(plane_bytes(source_->description()));
    const auto limit = static_cast<std::int64_t>(
        std::min<std::uint64_t>(options.max_bytes, std::uint64_t{1} << 40));
    const std::int64_t slot_count = std::clamp<std::int64_t>(
        limit / bytes, 2, std::max<std::int64_t>(2, kSlotsPerThread * thread_count_));
    slots_.resize(static_cast<std::size_t>(slot_count));
    for (Slot& slot : slots_) slot.plane.resize(static_cast<std::size_t>(bytes));
  }

  ~PrefetchSource() override { stop(); }

  const VolumeDescription& description() const override { return source_->description(); }
  const std::vector<Warning>& warnings() const override { return warnings_; }
  std::uint64_t resident_bytes() const override {
    return source_->resident_bytes() + slots_.size() * slots_.front().plane.size();
  }
  const PlaneFiles& files() const override { return source_->files(); }

  void read_plane(std::span<std::byte> plane) override {
    if (cursor_.is_done() || plane.size() != slots_.front().plane.size()) {
      throw Error(ErrorKind::invalid_argument, "no such plane, or a buffer of another size");
    }
    if (threads_.empty()) start();
    const std::int64_t z = cursor_.next();
    Slot& slot = slot_of(z);
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return slot.filled_with == z; });
      if (slot.failure) std::rethrow_exception(slot.failure);
    }
    std::memcpy(plane.data(), slot.plane.data(), plane.size());
    {
      const std::lock_guard lock(mutex_);
      cursor_.take();
      if (cursor_.is_done()) warnings_ = source_->warnings();
    }
    changed_.notify_all();
  }

  bool can_seek() const override { return source_->can_seek(); }

  void seek(std::int64_t first, std::int64_t end) override {
    stop();
    cursor_.seek(first, end);
    source_->seek(first, end);
    end_ = end;
    next_ticket_ = first;
    for (Slot& slot : slots_) slot.filled_with = -1;
  }

 private:
  struct Slot {
    UnsetBytes plane;
    std::int64_t filled_with = -1;
    std::exception_ptr failure;
  };

  // Only once a plane is asked for, so that none is read that is passed by seeking.
  void start() {
    is_stopping_ = false;
    for (std::int64_t i = 0; i < thread_count_; ++i) threads_.emplace_back([this] { work(); });
  }

  void stop() {
    {
      const std::lock_guard lock(mutex_);
      is_stopping_ = true;
    }
    changed_.notify_all();
    for (std::thread& thread : threads_) thread.join();
    threads_.clear();
  }

  Slot& slot_of(std::int64_t z) {
    return slots_[static_cast<std::size_t>(z) % slots_.size()];
  }

  /// The next plane to read, once its slot is free; end_ when there is nothing left to do.
  std::int64_t take_ticket() {
    std::unique_lock lock(mutex_);
    const auto slot_count = static_cast<std::int64_t>(slots_.size());
    if (next_ticket_ >= end_) return end_;
    const std::int64_t z = next_ticket_++;
    changed_.wait(lock, [&] { return is_stopping_ || z < cursor_.next() + slot_count; });
    return is_stopping_ ? end_ : z;
  }

  void work() {
    for (std::int64_t z = take_ticket(); z < end_; z = take_ticket()) {
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
        if (failure) next_ticket_ = end_;
      }
      changed_.notify_all();
    }
  }

  std::unique_ptr<PlaneSource> source_;
  const IndexedPlaneSource* indexed_;
  std::vector<Warning> warnings_;
  PlaneCursor cursor_;  // taken from under the lock
  std::int64_t end_;    // of the planes to be read
  std::int64_t thread_count_ = 1;
  std::vector<Slot> slots_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::int64_t next_ticket_ = 0;
  bool is_stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace

std::unique_ptr<PlaneSource> make_prefetch_source(std::unique_ptr<PlaneSource> source,
                                                  const PrefetchOptions& options) {
  return std::make_unique<PrefetchSource>(std::move(source), options);
}

}  // namespace octavo
