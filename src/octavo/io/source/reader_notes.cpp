#include "octavo/io/source/reader_notes.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <memory>
#include <vector>

#include "octavo/core/error.h"

namespace octavo {

namespace {

constexpr std::size_t kPathBytes = 1016;
constexpr std::int32_t kSlotCount = 128;

struct Slot {
  std::atomic<std::int64_t> plane_and_one;
  char path[kPathBytes];
};

struct Notes {
  std::atomic<std::int32_t> crashed_and_one;
  std::atomic<std::int32_t> taken;
  Slot slots[kSlotCount];
};
static_assert(std::atomic<std::int64_t>::is_always_lock_free, "shared between processes");

std::atomic<Notes*> kept_notes{nullptr};
constexpr std::int32_t kUnclaimed = -1;
thread_local std::int32_t own_slot = kUnclaimed;

/// This thread's slot; null when no notes are kept or all slots are taken.
Slot* slot_of_thread() noexcept {
  Notes* notes = kept_notes.load(std::memory_order_acquire);
  if (notes == nullptr) return nullptr;
  if (own_slot == kUnclaimed) own_slot = std::min(notes->taken.fetch_add(1), kSlotCount);
  return own_slot < kSlotCount ? &notes->slots[own_slot] : nullptr;
}

ReaderNote note_in(const Slot& slot) {
  const char* end = std::find(slot.path, slot.path + kPathBytes, '\0');
  return {slot.plane_and_one.load() - 1, std::string(slot.path, end)};
}

}  // namespace

const std::size_t kReaderNotesBytes = sizeof(Notes);

void keep_reader_notes(int descriptor) {
  void* memory =
      ::mmap(nullptr, sizeof(Notes), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
  if (memory == MAP_FAILED) {
    throw Error(ErrorKind::io, std::string("cannot share notes: ") + std::strerror(errno));
  }
  kept_notes.store(static_cast<Notes*>(memory), std::memory_order_release);
}

void note_file(const std::string& path) noexcept {
  Slot* slot = slot_of_thread();
  if (slot == nullptr) return;
  const std::size_t count = std::min(path.size(), kPathBytes - 1);
  std::memcpy(slot->path, path.data(), count);
  slot->path[count] = '\0';
}

void note_plane(std::int64_t z) noexcept {
  Slot* slot = slot_of_thread();
  if (slot == nullptr) return;
  slot->path[0] = '\0';
  slot->plane_and_one.store(z + 1);
}

void note_crash() noexcept {
  Notes* notes = kept_notes.load(std::memory_order_acquire);
  const bool has_slot = own_slot != kUnclaimed && own_slot < kSlotCount;
  if (notes != nullptr && has_slot) notes->crashed_and_one.store(own_slot + 1);
}

ReaderNote reader_note(int descriptor, std::int64_t z) {
  const auto notes = std::make_unique<Notes>();
  const ssize_t count = ::pread(descriptor, static_cast<void*>(notes.get()), sizeof(Notes), 0);
  if (count != static_cast<ssize_t>(sizeof(Notes))) return {};
  const std::int32_t crashed = notes->crashed_and_one.load();
  if (crashed >= 1 && crashed <= kSlotCount) return note_in(notes->slots[crashed - 1]);
  for (const Slot& slot : notes->slots) {
    if (slot.plane_and_one.load() == z + 1 && slot.path[0] != '\0') return note_in(slot);
  }
  return {};
}

}  // namespace octavo
