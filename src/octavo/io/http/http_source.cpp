#include "octavo/io/http/http_source.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/url_text.h"
#include "octavo/file/lru_cache.h"
#include "octavo/file/storage/sparse_source.h"
#include "octavo/file/storage/storage.h"
#include "octavo/io/http/http_range.h"
#include "octavo/io/source/own_threads.h"

namespace octavo {

namespace {

constexpr std::uint64_t kBlockBytes = std::uint64_t{1} << 16;
constexpr std::uint64_t kCacheBytes = 64 * kBlockBytes;
constexpr std::uint64_t kLargestRequest = std::uint64_t{1} << 26;
constexpr std::uint64_t kFetchedBytes = std::uint64_t{1} << 26;

using BlockBytes = std::vector<std::uint8_t>;
using Block = std::shared_ptr<const BlockBytes>;

/// The end of a file, asked for on a thread of its own while its front is. What goes wrong is met
/// again when the bytes are read.
class EndInProgress {
 public:
  EndInProgress(RangeClient& client, const HttpOptions& options) {
    if (options.end_bytes == 0) return;
    const auto fetch = [this, &client, &options] {
      answer_ = client.fetch_end(options.end_bytes, [&] {
        return Clock::now() > until_.load() || (options.is_cancelled && options.is_cancelled());
      });
    };
    try {
      thread_ = std::jthread(fetch);
    } catch (const std::system_error&) {
      // Where the system gives no more threads.
    }
  }

  ~EndInProgress() { until_ = Clock::now(); }

  /// The front is here: the end has a little longer.
  std::optional<RangeAnswer> wait() {
    constexpr std::chrono::duration<double> kWait(kSilentSeconds);
    until_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(kWait);
    if (thread_.joinable()) thread_.join();
    return std::move(answer_);
  }

 private:
  using Clock = std::chrono::steady_clock;

  std::optional<RangeAnswer> answer_;
  std::atomic<Clock::time_point> until_ = Clock::time_point::max();
  std::jthread thread_;
};

class HttpSource final : public ByteSource {
 public:
  HttpSource(const std::string& url, const HttpOptions& options)
      : client_(url, options),
        most_requests_(static_cast<std::size_t>(std::max(options.most_requests, 1))) {
    EndInProgress end_in_progress(client_, options);
    RangeAnswer head = client_.fetch(0, kBlockBytes);
    size_ = head.total_bytes;
    validator_ = std::move(head.validator);
    head_ = std::make_shared<const BlockBytes>(std::move(head.bytes));
    const std::optional<RangeAnswer> end = end_in_progress.wait();
    if (end && end->total_bytes == size_ && end->validator == validator_) {
      fetched_.put(end->offset, end->bytes);
    }
  }

  std::uint64_t size() const override { return size_; }
  const std::string& name() const override { return client_.name(); }

  void read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
    if (offset > size_ || out.size() > size_ - offset) {
      throw Error(ErrorKind::truncated,
                  "ends at byte " + std::to_string(size_) + ", " + std::to_string(out.size()) +
                      " more were needed",
                  name(), offset);
    }
    // What begins in the head is at hand so far, and missing() leaves it out.
    if (const std::uint64_t head_bytes = kept_head_bytes(); offset < head_bytes) {
      const std::size_t count = std::min<std::size_t>(out.size(), head_bytes - offset);
      std::copy_n(head_->begin() + static_cast<std::ptrdiff_t>(offset), count, out.begin());
      out = out.subspan(count);
      offset += count;
    }
    if (out.empty() || read_fetched(offset, out)) return;
    if (out.size() > kBlockBytes) return read_directly(offset, out);
    // At most two blocks: those that lie side by side come in one request.
    const std::uint64_t first = offset / kBlockBytes;
    const std::uint64_t last = (offset + out.size() - 1) / kBlockBytes;
    if (last > first && !known(first) && !known(last)) fetch_blocks(first, last);
    while (!out.empty()) {
      const std::uint64_t start = offset % kBlockBytes;
      const Block bytes = block(offset / kBlockBytes);
      const std::size_t count = std::min<std::size_t>(out.size(), bytes->size() - start);
      std::copy_n(bytes->begin() + static_cast<std::ptrdiff_t>(start), count, out.begin());
      out = out.subspan(count);
      offset += count;
    }
  }

  std::uint64_t fetched_bytes_kept() const override { return kFetchedBytes; }

  std::vector<ByteRange> missing(std::span<const ByteRange> ranges) const override {
    std::vector<ByteRange> behind_head;
    for (ByteRange range : ranges) {
      const std::uint64_t known = std::min(range.end(), kept_head_bytes());
      if (known > range.offset) range = {known, range.end() - known};
      behind_head.push_back(range);
    }
    const std::lock_guard lock(mutex_);
    return fetched_.missing(behind_head);
  }

  std::shared_ptr<const void> hold(std::span<const ByteRange> ranges) const override {
    const std::lock_guard lock(mutex_);
    return fetched_.hold(ranges);
  }

  bool forget(std::span<const ByteRange> ranges) const override {
    const std::lock_guard lock(mutex_);
    fetched_.drop(ranges);
    ++generation_;
    const auto begins_in_head = [&](const ByteRange& range) {
      return range.offset < head_->size();
    };
    if (std::ranges::any_of(ranges, begins_in_head)) has_head_ = false;
    return true;
  }

  void fetch(std::span<const ByteRange> ranges) const override {
    std::vector<ByteRange> wanted;
    for (ByteRange range : ranges) {
      while (range.length > 0) {
        const std::uint64_t length = std::min(range.length, kLargestRequest);
        wanted.push_back({range.offset, length});
        range = {range.offset + length, range.length - length};
      }
    }
    fetch_all(wanted);
  }

 private:
  std::uint64_t kept_head_bytes() const { return has_head_ ? head_->size() : 0; }

  void fetch_all(std::span<const ByteRange> ranges) const {
    on_own_threads(ranges.size(), most_requests_, [&](std::size_t i) {
      keep(ranges[i].offset, fetch(ranges[i].offset, ranges[i].length));
    });
  }

  void keep(std::uint64_t offset, const std::vector<std::uint8_t>& bytes) const {
    const std::lock_guard lock(mutex_);
    fetched_.put(offset, bytes);
    fetched_.shrink_to(kFetchedBytes);
  }

  bool read_fetched(std::uint64_t offset, std::span<std::uint8_t> out) const {
    const std::lock_guard lock(mutex_);
    return fetched_.read(offset, out);
  }

  /// The proven bytes [offset, offset + count), all of them inside the file.
  std::vector<std::uint8_t> fetch(std::uint64_t offset, std::uint64_t count) const {
    RangeAnswer answer = client_.fetch(offset, count);
    if (answer.total_bytes != size_ || answer.validator != validator_) {
      throw Error(ErrorKind::io, "the file was replaced while being read; open it again", name(),
                  offset);
    }
    return std::move(answer.bytes);
  }

  void read_directly(std::uint64_t offset, std::span<std::uint8_t> out) const {
    while (!out.empty()) {
      const auto bytes = fetch(offset, std::min<std::uint64_t>(out.size(), kLargestRequest));
      std::copy(bytes.begin(), bytes.end(), out.begin());
      out = out.subspan(bytes.size());
      offset += bytes.size();
    }
  }

  /// The block, if it was fetched before.
  Block known(std::uint64_t number) const { return cache_.find({generation_, number}); }

  Block block(std::uint64_t number) const {
    if (Block kept = known(number)) return kept;
    return fetch_blocks(number, number);
  }

  /// Keeps the blocks first .. last; returns the last one.
  Block fetch_blocks(std::uint64_t first, std::uint64_t last) const {
    const std::uint64_t start = first * kBlockBytes;
    const std::uint64_t end = std::min((last + 1) * kBlockBytes, size_);
    const std::uint64_t generation = generation_;
    const std::vector<std::uint8_t> bytes = fetch(start, end - start);
    Block fresh;
    for (std::uint64_t at = start; at < end; at += kBlockBytes) {
      const auto from = bytes.begin() + static_cast<std::ptrdiff_t>(at - start);
      const auto count = static_cast<std::ptrdiff_t>(std::min(kBlockBytes, end - at));
      fresh = std::make_shared<const BlockBytes>(from, from + count);
      cache_.insert({generation, at / kBlockBytes}, fresh, kBlockBytes);
    }
    return fresh;
  }

  mutable RangeClient client_;
  mutable LruCache<BlockBytes> cache_{kCacheBytes};
  std::uint64_t size_ = 0;
  std::string validator_;
  Block head_;
  mutable std::atomic<bool> has_head_ = true;
  mutable std::atomic<std::uint64_t> generation_ = 0;  ///< of blocks: those of earlier ones are out
  std::size_t most_requests_;
  mutable std::mutex mutex_;
  mutable SparseBytes fetched_;
};

}  // namespace

std::shared_ptr<ByteSource> open_url(const std::string& url, const HttpOptions& options) {
  if (!is_url(url)) throw Error(ErrorKind::invalid_argument, "is no http or https URL", url);
  return std::make_shared<HttpSource>(url, options);
}

std::shared_ptr<ByteSource> open_any(const std::string& path, const HttpOptions& options) {
  return is_url(path) ? open_url(path, options) : open_byte_source(local_storage(), path);
}

}  // namespace octavo
