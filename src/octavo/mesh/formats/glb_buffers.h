// The arrays of a GLB file and what its JSON says of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "octavo/core/bytes.h"
#include "octavo/core/json_text.h"

namespace octavo {

/// Numbers of glTF.
enum class GlbType { int8 = 5120, uint16 = 5123, uint32 = 5125, float32 = 5126 };

/// Arrays one behind the other, each compressed by meshoptimizer unless all are plain.
class GlbBuffers {
 public:
  explicit GlbBuffers(bool is_plain) : is_plain_(is_plain) {}

  /// Three numbers for each of `count` points, `stride` bytes apart.
  /// about  further members of the accessor
  /// Returns the number of the accessor
  std::size_t add_points(const void* data, std::size_t count, std::size_t stride, GlbType type,
                         const char* filter, JsonObject about);
  /// Numbers of the points of triangles, below point_count.
  std::size_t add_triangles(const std::vector<std::uint32_t>& numbers, std::size_t point_count);

  bool is_empty() const { return bytes_.empty(); }
  const Bytes& bytes() const { return bytes_; }
  /// "accessors", "bufferViews" and "buffers"; nothing where there are no arrays.
  void describe(JsonObject& json) const;

 private:
  struct Array {
    std::size_t count;
    std::size_t stride;
    const char* mode;
    const char* filter;
    bool is_of_points;
  };

  std::size_t add_accessor(const Array& array, ByteSpan data, ByteSpan packed, JsonObject accessor);

  bool is_plain_;
  Bytes bytes_;
  std::uint64_t unpacked_bytes_ = 0;
  std::vector<JsonObject> accessors_;
  std::vector<JsonObject> views_;
};

}  // namespace octavo
