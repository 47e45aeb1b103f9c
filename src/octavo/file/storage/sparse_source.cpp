#include "octavo/file/storage/sparse_source.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "octavo/core/error.h"

namespace octavo {

namespace {

/// `ranges`  rising and apart from one another
bool overlaps_any(const ByteRange& run, const std::vector<ByteRange>& ranges) {
  const auto after = std::upper_bound(
      ranges.begin(), ranges.end(), run.offset,
      [](std::uint64_t offset, const ByteRange& range) { return offset < range.end(); });
  return after != ranges.end() && after->offset < run.end();
}

}  // namespace

void SparseBytes::insert(std::uint64_t offset, std::span<const std::uint8_t> bytes) {
  const std::uint64_t number = next_number_++;
  runs_.emplace(offset, Run{{bytes.begin(), bytes.end()}, number});
  offsets_.emplace(number, offset);
  byte_count_ += bytes.size();
}

SparseBytes::Runs::iterator SparseBytes::erase(Runs::iterator run) {
  byte_count_ -= run->second.bytes.size();
  offsets_.erase(run->second.number);
  return runs_.erase(run);
}

void SparseBytes::put(std::uint64_t offset, std::span<const std::uint8_t> bytes) {
  const ByteRange all{offset, bytes.size()};
  for (const ByteRange& gap : missing({&all, 1})) {
    insert(gap.offset, bytes.subspan(gap.offset - offset, gap.length));
  }
}

bool SparseBytes::read(std::uint64_t offset, std::span<std::uint8_t> out) const {
  auto run = runs_.upper_bound(offset);
  if (run == runs_.begin()) return out.empty();
  for (--run; !out.empty(); ++run) {
    if (run == runs_.end() || offset < run->first) return false;
    const std::uint64_t start = offset - run->first;
    const std::vector<std::uint8_t>& bytes = run->second.bytes;
    if (start >= bytes.size()) return false;
    const auto count = std::min<std::size_t>(out.size(), bytes.size() - start);
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(start), count, out.begin());
    out = out.subspan(count);
    offset += count;
  }
  return true;
}

std::vector<ByteRange> SparseBytes::missing(std::span<const ByteRange> ranges) const {
  std::vector<ByteRange> gaps;
  for (const ByteRange& range : joined({ranges.begin(), ranges.end()}, kNoGaps)) {
    std::uint64_t at = range.offset;
    auto run = runs_.upper_bound(at);
    if (run != runs_.begin()) --run;
    for (; run != runs_.end() && run->first < range.end(); ++run) {
      const std::uint64_t end = run->first + run->second.bytes.size();
      if (end <= at) continue;
      if (run->first > at) gaps.push_back({at, run->first - at});
      at = end;
    }
    if (at < range.end()) gaps.push_back({at, range.end() - at});
  }
  return gaps;
}

std::shared_ptr<const void> SparseBytes::hold(std::span<const ByteRange> ranges) {
  std::erase_if(holds_, [](const auto& hold) { return hold.expired(); });
  auto held = std::make_shared<const Ranges>(joined({ranges.begin(), ranges.end()}, kNoGaps));
  holds_.push_back(held);
  return held;
}

void SparseBytes::drop(std::span<const ByteRange> ranges) {
  const std::vector<ByteRange> dropped = joined({ranges.begin(), ranges.end()}, kNoGaps);
  for (auto run = runs_.begin(); run != runs_.end();) {
    const ByteRange range{run->first, run->second.bytes.size()};
    run = overlaps_any(range, dropped) ? erase(run) : std::next(run);
  }
}

void SparseBytes::shrink_to(std::uint64_t most_bytes) {
  if (byte_count_ <= most_bytes) return;
  std::vector<std::shared_ptr<const Ranges>> holds;
  for (const auto& hold : holds_) {
    if (auto held = hold.lock()) holds.push_back(std::move(held));
  }
  for (auto next = offsets_.begin(); next != offsets_.end() && byte_count_ > most_bytes;) {
    const auto run = runs_.find((next++)->second);
    const ByteRange range{run->first, run->second.bytes.size()};
    const bool is_held = std::any_of(holds.begin(), holds.end(), [&](const auto& held) {
      return overlaps_any(range, *held);
    });
    if (!is_held) erase(run);
  }
}

SparseSource::SparseSource(std::uint64_t size, std::string name)
    : size_(size), name_(std::move(name)) {}

void SparseSource::put(std::uint64_t offset, std::span<const std::uint8_t> bytes) {
  if (offset > size_ || bytes.size() > size_ - offset) {
    throw Error(ErrorKind::invalid_argument,
                std::to_string(bytes.size()) + " bytes beyond the end of the file at byte " +
                    std::to_string(size_),
                name_, offset);
  }
  const std::lock_guard lock(mutex_);
  held_.put(offset, bytes);
}

void SparseSource::shrink_to(std::uint64_t most_bytes) {
  const std::lock_guard lock(mutex_);
  held_.shrink_to(most_bytes);
}

std::uint64_t SparseSource::byte_count() const {
  const std::lock_guard lock(mutex_);
  return held_.byte_count();
}

void SparseSource::read(std::uint64_t offset, std::span<std::uint8_t> out) const {
  if (offset > size_ || out.size() > size_ - offset) {
    throw Error(ErrorKind::truncated, "ends before the bytes that are needed", name_, offset);
  }
  const std::lock_guard lock(mutex_);
  if (held_.read(offset, out)) return;
  throw Error(ErrorKind::io,
              std::to_string(out.size()) + " bytes are needed that were not fetched", name_,
              offset);
}

std::vector<ByteRange> SparseSource::missing(std::span<const ByteRange> ranges) const {
  const std::lock_guard lock(mutex_);
  return held_.missing(ranges);
}

std::shared_ptr<const void> SparseSource::hold(std::span<const ByteRange> ranges) const {
  const std::lock_guard lock(mutex_);
  return held_.hold(ranges);
}

}  // namespace octavo
