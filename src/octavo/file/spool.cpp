#include "octavo/file/spool.h"

#include <algorithm>
#include <utility>

namespace octavo {

namespace {

constexpr std::size_t kBlockBytes = std::size_t{256} << 10;

}  // namespace

Spool::Spool(Storage& storage, std::string folder, std::size_t stream_count)
    : storage_(storage), folder_(std::move(folder)), streams_(stream_count) {}

void Spool::append(std::size_t number, ByteSpan bytes) {
  Stream& stream = streams_[number];
  while (!bytes.empty()) {
    const std::size_t count = std::min(bytes.size(), kBlockBytes - stream.tail.size());
    const ByteSpan head = bytes.first(count);
    stream.tail.insert(stream.tail.end(), head.begin(), head.end());
    bytes = bytes.subspan(count);
    if (stream.tail.size() < kBlockBytes) return;
    if (!scratch_) scratch_ = storage_.create_scratch(folder_);
    scratch_->write(scratch_bytes_, stream.tail);
    stream.blocks.push_back(scratch_bytes_);
    scratch_bytes_ += kBlockBytes;
    stream.tail.clear();
  }
}

std::uint64_t Spool::size(std::size_t number) const {
  const Stream& stream = streams_[number];
  return stream.blocks.size() * std::uint64_t{kBlockBytes} + stream.tail.size();
}

void Spool::copy(std::size_t number, const std::function<void(ByteSpan)>& sink) const {
  const Stream& stream = streams_[number];
  Bytes block(stream.blocks.empty() ? 0 : kBlockBytes);
  for (const std::uint64_t offset : stream.blocks) {
    scratch_->read(offset, block);
    sink(block);
  }
  sink(stream.tail);
}

}  // namespace octavo
