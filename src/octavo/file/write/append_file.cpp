#include "octavo/file/write/append_file.h"

#include <utility>

#include "octavo/core/crc32c.h"

namespace octavo {

namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 20;

}  // namespace

void AppendFile::append(ByteSpan bytes) {
  digest_ = crc32c(bytes, digest_);
  if (buffer_.size() + bytes.size() > kBufferBytes) flush();
  if (bytes.size() > kBufferBytes) {
    write(bytes);
    return;
  }
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

Section AppendFile::append_section(ByteSpan bytes) {
  const Section section{size(), bytes.size(), crc32c(bytes)};
  append(bytes);
  return section;
}

void AppendFile::flush() {
  if (buffer_.empty()) return;
  write(buffer_);
  buffer_.clear();
}

void AppendFile::write(ByteSpan bytes) {
  if (file_) file_->write(written_, bytes);
  else kept_.emplace_back(bytes.begin(), bytes.end());
  written_ += bytes.size();
}

void AppendFile::pass_over(std::uint64_t length, std::uint32_t crc) {
  flush();
  written_ += length;
  digest_ = crc32c_joined(digest_, crc, crc32c_shift(length));
}

std::vector<Bytes> AppendFile::take() {
  flush();
  return std::exchange(kept_, {});
}

}  // namespace octavo
