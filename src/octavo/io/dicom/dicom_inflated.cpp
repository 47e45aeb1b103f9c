#include "octavo/io/dicom/dicom_inflated.h"

#include <algorithm>
#include <utility>

namespace octavo {

namespace {

constexpr std::size_t kMaxCursors = 32;

}  // namespace

InflatedFile::InflatedFile(const std::string& path, std::uint64_t start)
    : path_(path),
      start_(start),
      size_(start + VoxelStream(path, start, StreamCoding::bare_deflated).finish()),
      end_(size_) {}

InflatedFile::Cursor InflatedFile::take_cursor(std::uint64_t offset) {
  const std::lock_guard lock(mutex_);
  auto best = cursors_.end();
  for (auto each = cursors_.begin(); each != cursors_.end(); ++each) {
    if (each->at <= offset && (best == cursors_.end() || each->at > best->at)) best = each;
  }
  if (best == cursors_.end()) {
    return {start_, VoxelStream(path_, start_, StreamCoding::bare_deflated)};
  }
  Cursor cursor = std::move(*best);
  cursors_.erase(best);
  return cursor;
}

void InflatedFile::read_exactly(std::uint64_t offset, std::span<std::byte> bytes) {
  Cursor cursor = take_cursor(offset);
  cursor.stream.skip(offset - cursor.at);
  cursor.stream.read(bytes);
  cursor.at = offset + bytes.size();
  const std::lock_guard lock(mutex_);
  if (cursor.at >= end_) return;
  if (cursors_.size() == kMaxCursors) cursors_.erase(cursors_.begin());
  cursors_.push_back(std::move(cursor));
}

void InflatedFile::close_behind(std::uint64_t end) {
  const std::lock_guard lock(mutex_);
  cursors_.clear();
  end_ = end;
}

}  // namespace octavo
