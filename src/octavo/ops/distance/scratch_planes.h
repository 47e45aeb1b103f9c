// Values of a volume in a scratch file: made plane by plane, then changed along z, a few rows of
// all planes at a time (distance_field.h draws it).
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "octavo/core/box.h"
#include "octavo/core/error.h"
#include "octavo/core/progress.h"
#include "octavo/file/storage/storage.h"

namespace octavo {

template <class Value>
class ScratchPlanes {
 public:
  /// Throws Error{io}
  ScratchPlanes(const Size3& size, Storage& storage, const std::string& folder)
      : size_(size), file_(storage.create_scratch(folder)) {}

  /// Writes all planes: make(begin, end, values) fills those of [begin, end), [z][y][x].
  /// room  holds a plane at least
  template <class Make>
  void write_planes(std::vector<Value>& room, Make&& make) {
    const std::int64_t planes = static_cast<std::int64_t>(room.size()) / (size_.x * size_.y);
    for (std::int64_t z = 0; z < size_.z; z += planes) {
      const std::int64_t end = std::min(z + planes, size_.z);
      make(z, end, room.data());
      file_->write(offset(z, 0), bytes_of(room.data(), (end - z) * size_.x * size_.y));
    }
  }

  /// Changes all rows: change(block, values) gets some of them of all planes, [z][y][x].
  /// room    holds a row of all planes at least
  /// Throws  Error{cancelled}
  template <class Change>
  void change_rows(std::vector<Value>& room, const Progress& progress, Change&& change) {
    const std::int64_t rows = static_cast<std::int64_t>(room.size()) / (size_.x * size_.z);
    for (std::int64_t y = 0; y < size_.y; y += rows) {
      if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
      const Size3 block = {size_.x, std::min(rows, size_.y - y), size_.z};
      const std::int64_t piece = block.x * block.y;
      for (std::int64_t z = 0; z < size_.z; ++z) {
        file_->read(offset(z, y), bytes_of(room.data() + z * piece, piece));
      }
      change(block, room.data());
      for (std::int64_t z = 0; z < size_.z; ++z) {
        file_->write(offset(z, y), bytes_of(room.data() + z * piece, piece));
      }
    }
  }

  /// Planes [begin, end), [z][y][x].
  void read(std::int64_t begin, std::int64_t end, Value* values) const {
    file_->read(offset(begin, 0), bytes_of(values, (end - begin) * size_.x * size_.y));
  }

 private:
  static std::span<std::uint8_t> bytes_of(Value* values, std::int64_t count) {
    return {reinterpret_cast<std::uint8_t*>(values),
            static_cast<std::size_t>(count) * sizeof(Value)};
  }
  std::uint64_t offset(std::int64_t z, std::int64_t y) const {
    return static_cast<std::uint64_t>((z * size_.y + y) * size_.x) * sizeof(Value);
  }

  Size3 size_;
  std::unique_ptr<StorageFile> file_;
};

}  // namespace octavo
