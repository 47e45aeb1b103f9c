#include "octavo/file/write/append_file.h"

#include "octavo/core/crc32c.h"

namespace octavo {

namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 20;

}  // namespace

void AppendFile::append(ByteSpan bytes) {
  digest_ = crc32c(bytes, digest_);
  if (buffer_.size() + bytes.size() > kBufferBytes) flush();
  if (bytes.size() > kBufferBytes) {
    file_->write(written_, bytes);
    written_ += bytes.size();
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
  file_->write(written_, buffer_);
  written_ += buffer_.size();
  buffer_.clear();
}

}  // namespace octavo
