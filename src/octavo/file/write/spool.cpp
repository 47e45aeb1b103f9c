#include "octavo/file/write/spool.h"

#include <algorithm>
#include <utility>

namespace octavo {

namespace {

constexpr std::size_t kSpoolTailBytes = std::size_t{256} << 10;

}  // namespace

Spool::Spool(Storage& storage, std::string folder, std::size_t stream_count)
    : storage_(&storage), folder_(std::move(folder)), streams_(stream_count) {}

void Spool::append(std::size_t number, ByteSpan bytes) {
  Stream& stream = streams_[number];
  if (storage_ == nullptr) {
    stream.tail.insert(stream.tail.end(), bytes.begin(), bytes.end());
    return;
  }
  while (!bytes.empty()) {
    const std::size_t count = std::min(bytes.size(), kSpoolTailBytes - stream.tail.size());
    const ByteSpan head = bytes.first(count);
    stream.tail.insert(stream.tail.end(), head.begin(), head.end());
    bytes = bytes.subspan(count);
    if (stream.tail.size() == kSpoolTailBytes) send_tail(number);
  }
}

void Spool::send_tail(std::size_t number) {
  Stream& stream = streams_[number];
  std::uint64_t offset = scratch_bytes_;
  if (journal_ != nullptr) {
    offset = journal_->append_block(number, stream.tail);
  } else {
    if (!scratch_) scratch_ = storage_->create_scratch(folder_);
    scratch_->write(offset, stream.tail);
    scratch_bytes_ += stream.tail.size();
  }
  stream.blocks.push_back({offset, stream.tail.size()});
  stream.block_bytes += stream.tail.size();
  stream.tail.clear();
}

void Spool::flush() {
  for (std::size_t number = 0; number < streams_.size(); ++number) {
    if (!streams_[number].tail.empty()) send_tail(number);
  }
}

void Spool::restore(const JournalBlock& block) {
  Stream& stream = streams_.at(block.stream);
  stream.blocks.push_back({block.offset, block.length});
  stream.block_bytes += block.length;
}

std::uint64_t Spool::size(std::size_t number) const {
  const Stream& stream = streams_[number];
  return stream.block_bytes + stream.tail.size();
}

void Spool::copy(std::size_t number, const std::function<void(ByteSpan)>& sink) const {
  const Stream& stream = streams_[number];
  const StorageFile* const file = journal_ != nullptr ? &journal_->file() : scratch_.get();
  Bytes bytes;
  for (const Block& block : stream.blocks) {
    bytes.resize(static_cast<std::size_t>(block.length));
    file->read(block.offset, bytes);
    sink(bytes);
  }
  sink(stream.tail);
}

}  // namespace octavo
